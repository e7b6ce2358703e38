/* SPDX-License-Identifier: Apache-2.0 */
/* Checks the triangle count in the header of a binary STL file. */
#include "io/mesh/input.h"

enum { HEADER = 84, RECORD = 50 };

ost_status ost_mesh_check_stl_count(const char *path, uint64_t file_size, uint64_t count, ost_error *err)
{
    const uint64_t there = (file_size - HEADER) / RECORD;
    if (count == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 80: the file has no triangle", path);
    if (count != there)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: byte 80: the header states %llu triangles, which take %llu bytes; the file has %llu%s",
                        path, (unsigned long long)count, (unsigned long long)count * RECORD + HEADER,
                        (unsigned long long)file_size, count > there ? " (truncated, or not an STL file)" : "");
    if (count > OST_MESH_FILE_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: byte 80: %llu triangles; at most %d are read: simplify the mesh", path,
                        (unsigned long long)count, OST_MESH_FILE_TRIANGLES_MAX);
    return OST_OK;
}
