/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 04: computes the force on the hand while a tool is pressed into bone.
 *
 *   04_force BONE.nrrd TOOL.nrrd
 *
 *   pose of the hand --ost_force_step--> pose of the tool, hand force --ost_safety_step--> force for a device
 *
 * The motor is off. Therefore the tool stops at the bone while the hand advances, and the spring
 * between tool and hand is stretched. No bone is removed. A program that also removes bone passes
 * the tool's pose of each step to ost_world_step (example 03).
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <string.h>

/* Stores the largest magnitude of the three components of v in *greatest, unless *greatest is already larger. */
static void raise_to(double *greatest, const double v[3])
{
    for (int a = 0; a < 3; a++) {
        const double magnitude = v[a] < 0 ? -v[a] : v[a];
        if (magnitude > *greatest)
            *greatest = magnitude;
    }
}

int main(int argc, char **argv)
{
    const double period_s = 1e-3; /* one tick per millisecond */
    ost_error err = {OST_OK, ""};
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_tool *tool = NULL;
    ost_force *force = NULL;
    ost_tool_volume volume;
    ost_path path;
    ost_import_result source;
    ost_glenoid glenoid;
    ost_force_result result;
    ost_safety safety;
    double hand_n = 0, device_n = 0; /* largest force component in newtons: before the safety layer, and after it */
    int ticks_in_contact = 0;
    ost_status status;

    if (argc != 3) {
        fprintf(stderr, "usage: 04_force BONE.nrrd TOOL.nrrd\n");
        return 2;
    }
    memset(&volume, 0, sizeof volume);
    memset(&path, 0, sizeof path);

    status = ost_backend_open("cpu", &backend, &err);
    if (!status)
        status = ost_import(backend, argv[1], NULL, &bone, &source, &err);
    if (!status)
        status = ost_tool_volume_read(argv[2], &volume, &err);
    if (!status)
        status = ost_tool_upload(backend, &volume, &tool, &err);

    /*
     * If the parameters are NULL, the defaults are used (docs/reference/force.md). ost_force_step
     * reads single voxels of the bone.
     */
    if (!status)
        status = ost_force_create(bone, NULL, &force, &err);
    if (!status)
        status = ost_force_add_tool(force, tool, &err);
    ost_safety_begin(&safety, NULL);

    /* The hand follows the path of a drill: from outside along the axis of the glenoid into the bone, and back. */
    if (!status)
        status = ost_glenoid_from_meta(&source.meta, &glenoid, &err);
    if (!status)
        status = ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &volume.geometry, 0, &path, &err);
    if (!status)
        ost_force_motor(force, 0, 0);
    for (size_t i = 0; !status && i < path.count; i++) {
        const ost_pose *hand = &path.ticks[i].pose;
        status = ost_force_step(force, 0, hand, period_s, &result, &err);
        if (status)
            break;
        ticks_in_contact += result.touching > 0;
        raise_to(&hand_n, result.force_n);
        /*
         * The safety layer limits the force and the torque in place. A program must write only
         * these limited values to a device.
         */
        ost_safety_step(&safety, hand, true, 0, period_s, result.force_n, result.torque_nm);
        raise_to(&device_n, result.force_n);
    }

    if (status)
        fprintf(stderr, "04_force: %s\n", err.text);
    else
        printf("%d ticks in contact, at most %.3f N, limited to %.3f N\n", ticks_in_contact, hand_n, device_n);

    ost_path_free(&path);
    ost_force_free(force);
    ost_tool_free(tool);
    ost_tool_volume_free(&volume);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return ost_status_exit(status);
}
