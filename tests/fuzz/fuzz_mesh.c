/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as mesh files. The first byte of an input selects the format (s, o, p
 * or 3); the remaining bytes are the file. A mesh that is read must be valid. It is voxelized
 * on a grid of about eight voxels per side.
 */
#include "fuzz.h"

#include <osteon/io.h>

#include "cpu/ref/voxelize.h"

const char *const fuzz_words[] = {
    "solid ",    "endsolid\n", "facet normal 0 0 1\n", "outer loop\n",   "vertex 1 2 3\n", "endloop\n", "endfacet\n",
    "v 1 2 3\n", "f 1 2 3\n",  "f -1 -2 -3 -4\n",      "o part\n",       "\\\n",           "1e38",      "nan",
    "element ",  "property ",  "list uchar int ",      "vertex_indices", "double",         "comment\n", NULL};

static const float corners[4][3] = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}};
static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

static size_t put(uint8_t *bytes, size_t at, const void *what, size_t size)
{
    memcpy(bytes + at, what, size);
    return at + size;
}

static size_t put_text(uint8_t *bytes, size_t at, const char *text)
{
    return put(bytes, at, text, strlen(text));
}

static size_t binary_stl(uint8_t *bytes)
{
    const uint32_t count = 4;
    memset(bytes, 0, 300);
    size_t at = put(bytes, put_text(bytes, 0, "s") + 80, &count, sizeof count);
    for (int t = 0; t < 4; t++) {
        at += 12;
        for (int c = 0; c < 3; c++)
            at = put(bytes, at, corners[faces[t][c]], 12);
        at += 2;
    }
    return at;
}

static size_t ascii_stl(uint8_t *bytes)
{
    size_t at = put_text(bytes, 0, "ssolid t\n");
    for (int t = 0; t < 4; t++) {
        at = put_text(bytes, at, "facet normal 0 0 0\nouter loop\n");
        for (int c = 0; c < 3; c++) {
            const float *v = corners[faces[t][c]];
            char line[64];
            snprintf(line, sizeof line, "vertex %g %g %g\n", (double)v[0], (double)v[1], (double)v[2]);
            at = put_text(bytes, at, line);
        }
        at = put_text(bytes, at, "endloop\nendfacet\n");
    }
    return put_text(bytes, at, "endsolid t\n");
}

static size_t ply(uint8_t *bytes, bool text)
{
    size_t at = put_text(bytes, 0, text ? "pply\nformat ascii 1.0\n" : "pply\nformat binary_little_endian 1.0\n");
    at = put_text(bytes, at, "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n");
    at = put_text(bytes, at, "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n");
    if (text)
        return put_text(bytes, at, "0 0 0\n9 0 0\n0 9 0\n0 0 9\n4 0 1 2 3\n");
    at = put(bytes, at, corners, sizeof corners);
    return put(bytes, at, "\4\0\0\1\0\2\0\3\0", 9);
}

static size_t three_ds(uint8_t *bytes)
{
    static const uint8_t head[] = {'3', 0x4d, 0x4d, 0x7e, 0,    0,    0, 0x3d, 0x3d, 0x78, 0,    0,
                                   0,   0x00, 0x40, 0x72, 0,    0,    0, 'a',  0,    0,    0x41, 0x6a,
                                   0,   0,    0,    0x10, 0x41, 0x38, 0, 0,    0,    4,    0};
    size_t at = put(bytes, 0, head, sizeof head);
    at = put(bytes, at, corners, sizeof corners);
    at = put(bytes, at, "\x20\x41\x28\0\0\0\4\0", 8);
    for (int t = 0; t < 4; t++)
        for (int c = 0; c < 4; c++) {
            uint16_t index = (uint16_t)(c < 3 ? faces[t][c] : 0);
            at = put(bytes, at, &index, sizeof index);
        }
    return at;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (capacity < 4096)
        return 0;
    switch (index) {
    case 0: return binary_stl(bytes);
    case 1: return ascii_stl(bytes);
    case 2:
        return put_text(bytes, 0,
                        "o# t\no t\nv 0 0 0\nv 9 0 0 1.0\nv 0 9 0 .5 .5 .5\nv 0 0 9e0\nf 1 3 2\nf 1/1 2/2 4/4\nf 1//1 "
                        "4//2 3//3\nf -3 -2 -1\n");
    case 3: return ply(bytes, true);
    case 4: return ply(bytes, false);
    case 5: return three_ds(bytes);
    default: return 0;
    }
}

static void voxelize(const ost_mesh *mesh)
{
    ost_error err = {0};
    ost_pm3 min, max;
    fuzz_require(ost_mesh_bounds(mesh, &min, &max, &err) == OST_OK);
    ost_pm extent = max.x - min.x;
    extent = max.y - min.y > extent ? max.y - min.y : extent;
    extent = max.z - min.z > extent ? max.z - min.z : extent;
    ost_pm voxel = extent / 8 + OST_TOOL_VOXEL_MIN;
    ost_tool_geometry grid;
    ost_snapped_mesh snapped;
    if (voxel > OST_SPACING_MAX || ost_tool_geometry_from_bounds(min, max, voxel, &grid, &err) != OST_OK)
        return; /* The mesh is refused if it is metres wide or lies at the limit of coordinates. */
    fuzz_require(ost_mesh_snap(mesh, &grid, &snapped, &err) == OST_OK);
    uint8_t *voxels = malloc((size_t)ost_dims_count(grid.dims));
    ost_voxelize_report report;
    fuzz_require(voxels != NULL);
    fuzz_require(ost_ref_voxelize(&snapped, NULL, OST_FILL_WINDING, &report, voxels, &err) == OST_OK);
    fuzz_require(report.solid_voxels <= (uint64_t)ost_dims_count(grid.dims));
    free(voxels);
    ost_snapped_mesh_free(&snapped);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0)
        return 0;
    const char *name = data[0] == 'o'   ? "mesh.obj"
                       : data[0] == 'p' ? "mesh.ply"
                       : data[0] == '3' ? "mesh.3ds"
                                        : "mesh.stl";
    const char *path = fuzz_file(name, data + 1, size - 1);
    ost_error err = {0};
    ost_mesh mesh;
    ost_mesh_report report;
    ost_status status = ost_mesh_read(path, OST_UNIT_MM, &mesh, &report, &err);
    fuzz_require_error(status, err, path);
    if (status == OST_OK) {
        for (size_t t = 0; t < mesh.triangle_count; t++)
            for (int c = 0; c < 3; c++)
                fuzz_require(mesh.triangles[t][c] < mesh.vertex_count);
        fuzz_require(mesh.triangle_count >= 1 && report.file_triangles >= 1);
        voxelize(&mesh);
        ost_mesh_free(&mesh);
    }
    return 0;
}
