/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/models.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/io.h>
#include <osteon/phantom.h>

#include "bench/inputs.h"
#include "reproduction/stated.h"

const int model_chunk[MODEL_CHUNK_SIZES] = {16, 32, 64};
const char *const model_words[MODELS] = {"foam", "core-2", "core-1", "scapula", "glenoid"};

static const ost_phantom_kind phantoms[MODELS] = {OST_PHANTOM_FOAM, OST_PHANTOM_TRABECULAR2, OST_PHANTOM_TRABECULAR,
                                                  OST_PHANTOM_SCAPULA, OST_PHANTOM_GLENOID};

bool model_is_own(const model_store *store, model_id id)
{
    return store->ct[id] != NULL;
}

/*
 * Reads a CT. A CT in text form is imported, because ost_import determines its grid. Any other volume is read with
 * ost_volume_read.
 */
static ost_status read_ct(const model_store *store, const char *path, ost_volume *out, ost_error *err)
{
    ost_file_kind kind;
    ost_status status = ost_file_kind_find(path, &kind, err);
    if (status != OST_OK || kind != OST_FILE_CT_TEXT)
        return status == OST_OK ? ost_volume_read(path, NULL, out, NULL, err) : status;
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_bone_info info;
    const ost_import_options options = {.progress = store->progress, .progress_user = store->progress_user};
    status = ost_backend_open("cpu", &backend, err);
    if (status == OST_OK)
        status = ost_import(backend, path, &options, &bone, NULL, err);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = ost_volume_init(out, &info.geometry, err);
    if (status == OST_OK)
        status = ost_bone_download(bone, 0, info.geometry.dims.z, out->voxels, err);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return status;
}

ost_status model_get(model_store *store, model_id id, const model **out, ost_error *err)
{
    model *m = &store->model[id];
    *out = m;
    if (m->made)
        return OST_OK;
    const ost_phantom_options options = {.progress = store->progress, .progress_user = store->progress_user};
    ost_status status = store->ct[id] ? read_ct(store, store->ct[id], &m->rect, err)
                                      : ost_phantom_make(phantoms[id], &options, &m->rect, err);
    if (status != OST_OK) {
        ost_volume_free(&m->rect);
        return status;
    }
    snprintf(m->name, sizeof m->name, "%s%s", stated_models[id].name, store->ct[id] ? " (own CT)" : "");
    m->made = true;
    return OST_OK;
}

ost_status model_bone(const model *m, ost_backend *backend, int chunk, ost_bone **out, ost_error *err)
{
    ost_grid *rect = NULL, *cubic = NULL;
    const ost_geometry *g = &m->rect.geometry;
    ost_status status = ost_grid_create(backend, g, &rect, err);
    if (status == OST_OK)
        status = ost_grid_upload(rect, 0, g->dims.z, m->rect.voxels, err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(rect, g->spacing.x, OST_RESAMPLE_LINEAR, &cubic, err);
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, chunk, MODEL_THRESHOLD, out, err);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return status;
}

ost_status model_cubic(const model *m, ost_volume *out, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_status status = ost_backend_open("cpu", &backend, err);
    if (status == OST_OK)
        status = bench_cubic_make(backend, &m->rect, out, err);
    if (status == OST_OK)
        out->meta = m->rect.meta;
    ost_backend_close(backend);
    return status;
}

static bool active_at(const ost_volume *v, int64_t x, int64_t y, int64_t z)
{
    const ost_dims d = v->geometry.dims;
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z &&
           v->voxels[x + d.x * (y + d.y * z)] >= MODEL_THRESHOLD;
}

/* Counts the active voxels with at least one neighbour that is not active. */
static int64_t count_surface(const ost_volume *v)
{
    const ost_dims d = v->geometry.dims;
    int64_t count = 0;
    for (int64_t z = 0; z < d.z; z++)
        for (int64_t y = 0; y < d.y; y++)
            for (int64_t x = 0; x < d.x; x++)
                count += active_at(v, x, y, z) &&
                         !(active_at(v, x - 1, y, z) && active_at(v, x + 1, y, z) && active_at(v, x, y - 1, z) &&
                           active_at(v, x, y + 1, z) && active_at(v, x, y, z - 1) && active_at(v, x, y, z + 1));
    return count;
}

static ost_status count_surface_of(const ost_bone *bone, const ost_geometry *geometry, int64_t *count, ost_error *err)
{
    ost_volume cubic = {.voxels = NULL};
    ost_status status = ost_volume_init(&cubic, geometry, err);
    if (status == OST_OK)
        status = ost_bone_download(bone, 0, geometry->dims.z, cubic.voxels, err);
    if (status == OST_OK)
        *count = count_surface(&cubic);
    ost_volume_free(&cubic);
    return status;
}

ost_status model_counted(model_store *store, model_id id, const model **out, ost_error *err)
{
    model *m = &store->model[id];
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_status status = model_get(store, id, out, err);
    if (status != OST_OK || m->counted)
        return status;
    status = ost_backend_open("cpu", &backend, err);
    for (int i = 0; i < MODEL_CHUNK_SIZES && status == OST_OK; i++) {
        status = model_bone(m, backend, model_chunk[i], &bone, err);
        if (status == OST_OK)
            status = ost_bone_info_get(bone, &m->info[i], err);
        if (status == OST_OK && i == MODEL_CHUNK_32)
            status = count_surface_of(bone, &m->info[i].geometry, &m->surface_voxels, err);
        ost_bone_free(bone);
        bone = NULL;
    }
    m->counted = status == OST_OK;
    ost_backend_close(backend);
    return status;
}

ost_status model_glenoid(const model *m, ost_glenoid *out, ost_error *err)
{
    return ost_glenoid_from_meta(&m->rect.meta, out, err);
}

void model_store_free(model_store *store)
{
    for (int i = 0; i < MODELS; i++)
        ost_volume_free(&store->model[i].rect);
    memset(store->model, 0, sizeof store->model);
}
