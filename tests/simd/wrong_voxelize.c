/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Wrong kernels of the voxelization of meshes.
 */
#include <stdlib.h>
#include <string.h>

#include "cpu/kernels.h"
#include "cpu/voxelize/voxelize.h"
#include "simd/wrong.h"

extern const check_kernel check_vox_mark, check_vox_keys, check_vox_fill, check_vox_expand;

static void mark_omits_the_last_slice(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    tile->k1--;
    ost_vox_mark_scalar(tile, list, count);
    tile->k1++;
}

static void mark_omits_the_last_triangle(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count - (count > 0));
}

/* Simulates a kernel that loads four numbers of a vertex instead of three. */
static void mark_reads_beyond(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count);
    touch(&tile->mesh->vertices[tile->mesh->vertex_count]);
}

static void mark_clears_the_row_states(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count);
    if (tile->any_unproven)
        memset(tile->row_state, 0, ost_vox_rows(tile));
    tile->any_unproven = false;
}

static void keys_writes_beyond(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                               uint32_t *keys)
{
    ost_vox_keys_scalar(plan, mesh, first, count, keys);
    keys[count] = 0;
}

static void keys_omits_the_many_value(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first,
                                      size_t count, uint32_t *keys)
{
    ost_vox_keys_scalar(plan, mesh, first, count, keys);
    for (size_t i = 0; i < count; i++)
        keys[i] = keys[i] == OST_VOX_KEY_MANY ? 0 : keys[i];
}

static uint64_t fill_clears_nothing(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const bool row_state = tile->any_unproven;
    tile->any_unproven = true;
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    tile->any_unproven = row_state;
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->any_unproven = tile->any_unproven || (tile->row_state[r] & OST_VOX_UNPROVEN);
    return count;
}

static uint64_t fill_reports_all_rows_as_proven(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const bool row_state = tile->any_unproven;
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->row_state[r] &= OST_VOX_SPILLED;
    tile->any_unproven = row_state;
    return count;
}

static uint64_t fill_counts_wrong(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    return count > 5000 ? count + 1 : count;
}

static uint64_t fill_clears_the_spills(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->row_state[r] &= OST_VOX_UNPROVEN;
    return count;
}

static void expand_writes_beyond(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words,
                                 int32_t nx, bool stream, uint8_t *voxels)
{
    ost_vox_expand_scalar(cutting, noncutting, rows, words, nx, stream, voxels);
    if (rows > 0 && nx % 8 != 0)
        voxels[rows * (size_t)nx] = 0;
}

static void expand_reads_beyond(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                                bool stream, uint8_t *voxels)
{
    touch(cutting + rows * (size_t)words);
    ost_vox_expand_scalar(cutting, noncutting, rows, words, nx, stream, voxels);
}

static void expand_omits_the_second_class(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words,
                                          int32_t nx, bool stream, uint8_t *voxels)
{
    (void)noncutting;
    ost_vox_expand_scalar(cutting, NULL, rows, words, nx, stream, voxels);
}

static const wrong list[] = {
    WRONG(vox_mark, mark_omits_the_last_slice, DIFFERS),
    WRONG(vox_mark, mark_omits_the_last_triangle, DIFFERS),
    WRONG(vox_mark, mark_reads_beyond, FAULT),
    WRONG(vox_mark, mark_clears_the_row_states, DIFFERS),
    WRONG(vox_keys, keys_writes_beyond, BEYOND),
    WRONG(vox_keys, keys_omits_the_many_value, DIFFERS),
    WRONG(vox_fill, fill_clears_nothing, DIFFERS),
    WRONG(vox_fill, fill_reports_all_rows_as_proven, DIFFERS),
    WRONG(vox_fill, fill_counts_wrong, DIFFERS),
    WRONG(vox_fill, fill_clears_the_spills, DIFFERS),
    WRONG(vox_expand, expand_writes_beyond, BEYOND),
    WRONG(vox_expand, expand_reads_beyond, FAULT),
    WRONG(vox_expand, expand_omits_the_second_class, DIFFERS),
};
const wrong_list wrong_voxelize = {list, sizeof list / sizeof list[0]};
