/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 02: converts a mesh to a tool grid.
 *
 *   02_voxelize MESH VOXEL_MM TOOL.nrrd
 *
 *   file --read--> mesh --bounds--> grid --snap--> integer mesh --voxelize--> tool
 *
 * The snapped mesh has integer coordinates on a fine lattice. From this mesh, every
 * backend computes bit-identical voxels.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL;
    ost_tool *tool = NULL;
    ost_mesh mesh;
    ost_snapped_mesh snapped;
    ost_tool_volume volume;
    ost_voxelize_report report;
    ost_tool_geometry grid;
    ost_pm voxel = 0; /* lengths are integers, in picometres */
    ost_pm3 min, max;
    ost_status status;

    if (argc != 4) {
        fprintf(stderr, "usage: 02_voxelize MESH VOXEL_MM TOOL.nrrd\n");
        return 2;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&snapped, 0, sizeof snapped);
    memset(&volume, 0, sizeof volume);

    /* the text "0.5" is converted exactly, without an intermediate binary float */
    status = ost_pm_parse(argv[2], &voxel, &err);
    if (!status)
        status = ost_mesh_read(argv[1], OST_UNIT_MM, &mesh, NULL, &err);
    if (!status)
        status = ost_mesh_bounds(&mesh, &min, &max, &err);
    if (!status)
        status = ost_tool_geometry_from_bounds(min, max, voxel, &grid, &err);
    if (!status)
        status = ost_mesh_snap(&mesh, &grid, &snapped, &err);
    if (!status)
        status = ost_backend_open("cpu", &backend, &err);
    if (!status) /* NULL: the tool has no non-cutting part, such as a shaft */
        status = ost_voxelize(backend, &snapped, NULL, OST_FILL_WINDING, &report, &tool, &err);
    if (!status)
        status = ost_tool_download(tool, &volume, &err);
    if (!status)
        status = ost_tool_volume_write(argv[3], &volume, &err);

    if (status)
        fprintf(stderr, "02_voxelize: %s\n", err.text);
    else
        printf("%d x %d x %d voxels, %llu solid\n", grid.dims.x, grid.dims.y, grid.dims.z,
               (unsigned long long)report.solid_voxels);

    ost_tool_volume_free(&volume);
    ost_tool_free(tool);
    ost_backend_close(backend);
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    return ost_status_exit(status);
}
