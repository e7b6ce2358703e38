/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the slots of operations that some backends do not support. The slots return an error. */
#include "core/backend.h"
#include "core/paths.h"

ost_status ost_no_devices(ost_device_visit *visit, void *user, ost_error *err)
{
    (void)visit;
    (void)user;
    (void)err;
    return OST_OK;
}

void ost_no_paths(const ost_backend *backend, ost_path_visit *visit, void *user)
{
    (void)backend;
    (void)visit;
    (void)user;
}

ost_status ost_no_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                         ost_error *err)
{
    (void)count;
    (void)at;
    (void)densities;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "backend %s: single voxels cannot be read; a force needs backend cpu, cl or ref",
                    bone->backend->ops->name);
}

ost_status ost_no_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words, ost_error *err)
{
    (void)count;
    (void)chunks;
    (void)words;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "backend %s: no snapshot of a bone while it changes; use backend cpu, ref or cl",
                    bone->backend->ops->name);
}
