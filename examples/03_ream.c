/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 03: moves a tool along a path and removes bone.
 *
 *   03_ream BONE.nrrd TOOL.nrrd OUT.nrrd
 *
 * The built-in path drills a peg's hole into the middle of the glenoid, whose position is a fact in the
 * bone's file. The function ost_path_read_csv reads other paths from files with one tick per row. A program
 * that computes poses itself passes each pose to ost_world_step, the only function that advances the world.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_tool *tool = NULL;
    ost_world *world = NULL;
    ost_tool_volume volume;
    ost_path path;
    ost_motor motor;
    ost_import_result source;
    ost_glenoid glenoid;
    ost_step_result step;
    ost_world_totals totals;
    int index = 0;
    ost_status status;

    if (argc != 4) {
        fprintf(stderr, "usage: 03_ream BONE.nrrd TOOL.nrrd OUT.nrrd\n");
        return 2;
    }
    memset(&volume, 0, sizeof volume);
    memset(&path, 0, sizeof path);
    memset(&motor, 0, sizeof motor);

    /* Upload the bone and the tool to the backend. */
    status = ost_backend_open("cpu", &backend, &err);
    if (!status)
        status = ost_import(backend, argv[1], NULL, &bone, &source, &err);
    if (!status)
        status = ost_tool_volume_read(argv[2], &volume, &err);
    if (!status)
        status = ost_tool_upload(backend, &volume, &tool, &err);

    /* Create a world with the bone and the tool. The world borrows both. */
    if (!status)
        status = ost_world_create(bone, NULL, &world, &err);
    if (!status)
        status = ost_world_add_tool(world, "peg", tool, &index, &err);

    /* Make the tool's path, with a thousand ticks per second. */
    if (!status)
        status = ost_glenoid_from_meta(&source.meta, &glenoid, &err);
    if (!status)
        status = ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &volume.geometry, index, &path, &err);
    /* The path contains the poses of the hand. The motor adds the rotation of the tool. */
    if (!status)
        status = ost_motor_path(&path, OST_RPM_REAMER, &motor, &err);
    for (size_t i = 0; !status && i < path.count; i++)
        status = ost_world_step(world, &path.ticks[i], &step, &err);

    if (!status)
        status = ost_bone_write(argv[3], bone, &source.meta, NULL, &err);
    if (!status) {
        ost_world_totals_get(world, &totals);
        printf("%llu ticks, %llu voxels removed\n", (unsigned long long)totals.ticks,
               (unsigned long long)totals.removed_voxels);
    } else
        fprintf(stderr, "03_ream: %s\n", err.text);

    ost_path_free(&path);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_tool_volume_free(&volume);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return ost_status_exit(status);
}
