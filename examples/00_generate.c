/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 00: generates a scan and a tool, so that the other examples need no other
 * data.
 *
 *   00_generate CT.nrrd TOOL.stl
 *
 * Writes the CT of a generated glenoid (the joint's socket on the shoulder blade)
 * and the mesh of a cylinder that drills the hole for an implant's peg.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_volume ct;
    ost_mesh mesh;
    ost_status status;

    if (argc != 3) {
        fprintf(stderr, "usage: 00_generate CT.nrrd TOOL.stl\n");
        return 2;
    }
    memset(&ct, 0, sizeof ct);
    memset(&mesh, 0, sizeof mesh);

    /* If options is NULL, the phantom is a right glenoid with the dimensions of the thesis and noise from seed 1. */
    status = ost_phantom_make(OST_PHANTOM_GLENOID, NULL, &ct, &err);
    if (!status)
        status = ost_volume_write(argv[1], &ct, NULL, &err);
    if (!status)
        status = ost_tool_make(OST_TOOL_PEG, NULL, &mesh, &err);
    if (!status)
        status = ost_mesh_write_stl(argv[2], &mesh, &err);

    if (status)
        fprintf(stderr, "00_generate: %s\n", err.text);
    else
        printf("%d x %d x %d voxels, %zu triangles\n", ct.geometry.dims.x, ct.geometry.dims.y, ct.geometry.dims.z,
               mesh.triangle_count);
    ost_mesh_free(&mesh);
    ost_volume_free(&ct);
    return ost_status_exit(status);
}
