/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The function table of the OpenCL backend. The backend is opened on the first device
 * that the user's options select and that passes the checks.
 */
#include "cl/objects.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool ost_cl_available_with(const ost_cl_api *cl, char *reason, size_t size)
{
    ost_cl_devices devices;
    ost_error err = {0};
    bool found = false;
    if (size)
        reason[0] = 0;
    if (ost_cl_devices_list(cl, &devices, &err) != OST_OK) {
        snprintf(reason, size, "%s", err.text);
        return false;
    }
    for (size_t i = 0; i < devices.count && !found; i++)
        found = !devices.list[i].reason[0];
    if (!found && devices.count == 0)
        snprintf(reason, size, "%s", devices.reason);
    else if (!found)
        snprintf(reason, size, "no OpenCL device can be used; platform '%.60s': %.160s", devices.list[0].platform_name,
                 devices.list[0].reason);
    ost_cl_devices_free(&devices);
    return found;
}

ost_status ost_cl_open_with(const ost_cl_api *cl, const char *text, ost_backend **out, ost_error *err)
{
    ost_cl_options options;
    ost_cl_devices devices;
    cl_backend *backend = NULL;
    *out = NULL;
    ost_status status = ost_cl_options_read(text, &options, err);
    if (status != OST_OK)
        return status;
    status = ost_cl_devices_list(cl, &devices, err);
    if (status != OST_OK)
        return status;

    bool tried = false;
    ost_status first = OST_OK;
    ost_error why = {0}; /* error of the first selected device; the user probably means this device */
    for (size_t i = 0; i < devices.count && !backend; i++) {
        if (!ost_cl_options_match(&options, &devices.list[i]))
            continue;
        ost_error this = {0};
        status = ost_cl_device_open(cl, &devices.list[i], &options, &backend, &this);
        if (status != OST_OK && !tried) {
            why = this;
            first = status;
            tried = true;
        }
    }
    if (backend)
        *out = &backend->base, status = OST_OK;
    else if (devices.count == 0)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "backend cl: %s", devices.reason);
    else if (tried)
        status = ost_fail(err, first, "%s", why.text);
    else
        status = ost_fail(err, OST_ERR_UNAVAILABLE,
                          "backend cl: no OpenCL device matches '%.200s'; see osteon devices", text);
    ost_cl_devices_free(&devices);
    return status;
}

ost_status ost_cl_visit_with(const ost_cl_api *cl, ost_device_visit *visit, void *user, ost_error *err)
{
    const ost_cl_options standard = {.kernels = OST_CL_SET_AUTO};
    ost_cl_devices devices;
    ost_status status = ost_cl_devices_list(cl, &devices, err);
    if (status != OST_OK)
        return status;
    for (size_t i = 0; i < devices.count; i++) {
        const ost_cl_device *d = &devices.list[i];
        char spec[64], platform[2 * OST_CL_NAME + 4], name[2 * OST_CL_NAME + 16], notes[256] = "";
        snprintf(spec, sizeof spec, d->id ? "cl:platform=%d,device=%d" : "cl:platform=%d", d->platform_index,
                 d->device_index);
        snprintf(platform, sizeof platform, "%s (%s)", d->platform_name, d->platform_version);
        snprintf(name, sizeof name, d->id ? "%s (driver %s)" : "%s%s", d->name, d->driver);
        cl_backend *backend = NULL;
        ost_error why = {0};
        ost_status opened = d->reason[0] ? OST_ERR_UNAVAILABLE : ost_cl_device_open(cl, d, &standard, &backend, &why);
        if (opened == OST_OK)
            ost_cl_fingerprint_floats(backend, notes, sizeof notes);
        char *facts = ost_cl_facts(cl, d);
        const ost_device_info info = {
            .spec = spec,
            .platform = platform,
            .name = name,
            .available = opened == OST_OK,
            .reason = d->reason[0] ? d->reason : why.text,
            .notes = notes,
            .facts = facts ? facts : "",
        };
        visit(&info, user);
        free(facts);
        ost_cl_device_close(backend);
    }
    ost_cl_devices_free(&devices);
    return OST_OK;
}

/* ------------------------------------------------------------- the table */

static bool available(char *reason, size_t size)
{
    return ost_cl_available_with(&ost_cl_loader, reason, size);
}

static ost_status devices_cl(ost_device_visit *visit, void *user, ost_error *err)
{
    return ost_cl_visit_with(&ost_cl_loader, visit, user, err);
}

static ost_status open_cl(const char *options, ost_backend **out, ost_error *err)
{
    return ost_cl_open_with(&ost_cl_loader, options, out, err);
}

static void close_cl(ost_backend *backend)
{
    ost_cl_event_free((cl_backend *)backend);
    ost_cl_face_free((cl_backend *)backend);
    ost_cl_device_close((cl_backend *)backend);
}

/* Returns the settings of the backend. The host uses one thread, which only enqueues work; the device has its own
   instructions and threads. */
static ost_backend_settings settings(const ost_backend *base)
{
    const ost_cl_device *on = &((const cl_backend *)base)->device;
    return (ost_backend_settings){.isa = "", .threads = 1, .platform = on->platform_index, .device = on->device_index};
}

static ost_status finish(ost_backend *base, ost_error *err)
{
    return ost_cl_finish((cl_backend *)base, err);
}

const ost_backend_ops ost_backend_cl = {
    .name = "cl",
    .description = "OpenCL 1.2: CPUs by PoCL, GPUs of any vendor; integers only, checked at start; options platform=, "
                   "device=, kernels=cpu|gpu, workgroup=, staging=, order=",
    .available = available,
    .devices = devices_cl,
    .open = open_cl,
    .close = close_cl,
    .settings = settings,
    .finish = finish,
    .paths = ost_cl_paths,
    .grid_create = ost_cl_grid_create,
    .grid_free = ost_cl_grid_free,
    .grid_upload = ost_cl_grid_upload,
    .grid_download = ost_cl_grid_download,
    .ct_to_rect = ost_cl_ct_to_rect,
    .rect_to_cubic = ost_cl_rect_to_cubic,
    .cubic_to_chunks = ost_cl_cubic_to_chunks,
    .bone_create = ost_cl_bone_create,
    .bone_free = ost_cl_bone_free,
    .bone_stats = ost_cl_bone_stats,
    .bone_upload = ost_cl_bone_upload,
    .bone_download = ost_cl_bone_download,
    .bone_sample = ost_cl_bone_sample,
    .bone_occupancy = ost_cl_bone_occupancy,
    .bone_leaves = ost_cl_bone_leaves,
    .voxelize = ost_cl_voxelize,
    .tool_upload = ost_cl_tool_upload,
    .tool_download = ost_cl_tool_download,
    .tool_free = ost_cl_tool_free,
    .remove = ost_cl_remove,
    .collide = ost_cl_collide,
    .face_mesh = ost_cl_face_mesh,
};
