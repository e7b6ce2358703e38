/* SPDX-License-Identifier: Apache-2.0 */
#include "bench/tool_bits.h"

#include "cpu/voxelize/voxelize.h"

#include <stdlib.h>
#include <string.h>

uint64_t *bench_tool_bits(ost_dims dims, ost_error *err)
{
    const size_t bytes = (8 * (size_t)ost_vox_words(dims.x) * (size_t)dims.y * (size_t)dims.z + 63) / 64 * 64;
    uint64_t *bits = aligned_alloc(64, bytes);
    if (!bits) {
        ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu bytes of bits", bytes);
        return NULL;
    }
    return memset(bits, 1, bytes);
}

ost_status bench_tool_voxels(ost_backend *backend, const ost_snapped_mesh *mesh, ost_tool_volume *out,
                             ost_voxelize_report *report, ost_error *err)
{
    ost_tool *tool = NULL;
    ost_status status = ost_voxelize(backend, mesh, NULL, OST_FILL_WINDING, report, &tool, err);
    if (status == OST_OK)
        status = ost_tool_download(tool, out, err);
    ost_tool_free(tool);
    return status;
}

bool bench_tool_bits_are(const uint64_t *bits, ost_dims dims, const uint8_t *voxels)
{
    const size_t words = (size_t)ost_vox_words(dims.x);
    for (size_t row = 0; row < (size_t)dims.y * (size_t)dims.z; row++)
        for (int32_t i = 0; i < dims.x; i++)
            if ((bits[row * words + (size_t)i / 64] >> (i % 64) & 1) != *voxels++)
                return false;
    return true;
}
