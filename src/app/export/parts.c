/* SPDX-License-Identifier: Apache-2.0 */
#include "app/export/parts.h"

#include <string.h>


ost_status export_removed(const app_state *app, const char *before, const char *name, loaded_volume *in, int64_t *count,
                          ost_error *err)
{
    loaded_volume old = {0};
    *count = 0;
    ost_status status = load_volume(app, before, &old, err);
    if (status == OST_OK && !ost_geometry_equal(&old.volume.geometry, &in->volume.geometry))
        status = ost_fail(err, OST_ERR_INPUT, "%s and %s differ in dims, spacing or origin", before, name);
    const int64_t voxels = status == OST_OK ? ost_dims_count(in->volume.geometry.dims) : 0;
    for (int64_t v = 0; v < voxels; v++) {
        const bool removed = old.volume.voxels[v] >= old.threshold && in->volume.voxels[v] < in->threshold;
        in->volume.voxels[v] = removed ? old.volume.voxels[v] : 0;
        *count += removed;
    }
    if (status == OST_OK && *count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: has every voxel of %s, so nothing was removed", name,
                          before);
    if (status == OST_OK)
        in->threshold = 1;
    ost_volume_free(&old.volume);
    return status;
}

ost_status export_labels(const char *name, loaded_volume *in, ost_error *err)
{
    const int64_t voxels = ost_dims_count(in->volume.geometry.dims);
    const char *kind = ost_meta_get(&in->volume.meta, OST_META_KIND);
    if (kind && strcmp(kind, "labels") == 0)
        return OST_OK;
    for (int64_t v = 0; v < voxels; v++)
        in->volume.voxels[v] = in->volume.voxels[v] >= in->threshold;
    const ost_status status = ost_meta_set(&in->volume.meta, OST_META_KIND, "labels", err);
    return status == OST_OK ? status : ost_fail_context(err, "%s", name);
}
