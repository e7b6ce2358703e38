/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 05: removes the same bone on two backends and compares the digests.
 *
 *   05_compare BONE.nrrd TOOL.nrrd BACKEND BACKEND
 *
 * A backend is given as for `osteon --backend`: ref, cpu, cpu:isa=avx2,threads=2, cl.
 * All backends compute bit-identical grids, so the digests are equal. The exit status
 * is 1 if the digests differ.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

/* Drills a peg's hole on the backend `spec` and computes the digest of the remaining bone. */
static ost_status drill(const char *spec, const char *bone_file, const char *tool_file, ost_digest *out,
                        ost_error *err)
{
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
    int index = 0;
    ost_status status;

    memset(&volume, 0, sizeof volume);
    memset(&path, 0, sizeof path);
    memset(&motor, 0, sizeof motor);
    status = ost_backend_open(spec, &backend, err);
    if (!status)
        status = ost_import(backend, bone_file, NULL, &bone, &source, err);
    if (!status)
        status = ost_tool_volume_read(tool_file, &volume, err);
    if (!status)
        status = ost_tool_upload(backend, &volume, &tool, err);
    if (!status)
        status = ost_world_create(bone, NULL, &world, err);
    if (!status)
        status = ost_world_add_tool(world, "peg", tool, &index, err);
    if (!status)
        status = ost_glenoid_from_meta(&source.meta, &glenoid, err);
    if (!status)
        status = ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &volume.geometry, index, &path, err);
    if (!status)
        status = ost_motor_path(&path, OST_RPM_REAMER, &motor, err);
    for (size_t i = 0; !status && i < path.count; i++)
        status = ost_world_step(world, &path.ticks[i], &step, err);
    /* NULL, because the digests of the leaves of 32^3 voxels are not needed; they would show where two bones differ */
    if (!status)
        status = ost_bone_digest(bone, NULL, out, err);

    ost_path_free(&path);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_tool_volume_free(&volume);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return status;
}

int main(int argc, char **argv)
{
    ost_error err = {OST_OK, ""};
    ost_digest digest[2];
    char hex[OST_DIGEST_HEX];
    ost_status status = OST_OK;

    if (argc != 5) {
        fprintf(stderr, "usage: 05_compare BONE.nrrd TOOL.nrrd BACKEND BACKEND\n");
        return 2;
    }
    for (int i = 0; !status && i < 2; i++) {
        status = drill(argv[3 + i], argv[1], argv[2], &digest[i], &err);
        if (!status)
            printf("%s  %s\n", ost_digest_hex(&digest[i], hex), argv[3 + i]);
    }
    if (!status && !ost_digest_equal(&digest[0], &digest[1]))
        status = ost_fail(&err, OST_ERR_DIFFER, "%s and %s give different bones", argv[3], argv[4]);
    if (status)
        fprintf(stderr, "05_compare: %s\n", err.text);
    return ost_status_exit(status);
}
