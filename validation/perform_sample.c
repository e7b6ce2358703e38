/* SPDX-License-Identifier: Apache-2.0 */
/* Samples the bone of a case, reads its occupancy, and uploads its slices to a second bone. A backend is not required
   to implement the occupancy. */
#include "validation/perform_parts.h"

#include <stdlib.h>

#include "validation/draw.h"

enum { SAMPLES_MAX = 33 };

/* Returns the FNV-1a hash of an array of words. */
static uint64_t hash_words(const uint32_t *words, size_t count)
{
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < count; i++)
        h = (h ^ words[i]) * UINT64_C(0x100000001b3);
    return h;
}

/* Records the densities of 0 to 33 voxels per call, inside and outside the grid's borders. Every possible number of
   voxels in the last vector of a call therefore occurs. */
static ost_status sample_words(performer *p, draw *d, ost_error *err)
{
    const int32_t dims[3] = {p->dims.x, p->dims.y, p->dims.z};
    int32_t at[3][SAMPLES_MAX];
    int16_t densities[SAMPLES_MAX];
    const int32_t *const axes[3] = {at[0], at[1], at[2]};
    for (size_t n = 0; n <= SAMPLES_MAX; n++) {
        for (size_t i = 0; i < n; i++)
            for (int a = 0; a < 3; a++) {
                const int64_t border = draw_one_in(d, 2) ? dims[a] : 0;
                at[a][i] = (int32_t)(draw_one_in(d, 4) ? border + draw_between(d, -2, 1)
                                                       : draw_between(d, 0, dims[a] - 1));
            }
        const ost_status status = ost_bone_sample(p->bone, n, axes, densities, err);
        if (status != OST_OK)
            return status;
        for (size_t i = 0; i < n; i++)
            trace_word(p->w, (uint64_t)(int64_t)densities[i]);
    }
    return OST_OK;
}

static ost_status occupancy_words(performer *p, ost_error *err)
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(p->bone, &info, err);
    if (status != OST_OK)
        return status;
    const size_t words = (size_t)info.chunk_size * (size_t)info.chunk_size * (size_t)info.chunk_size / 32;
    uint32_t *bits = malloc(words * sizeof *bits);
    if (!bits)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the occupancy of a chunk");
    for (int32_t c = 0; c < info.chunks && status == OST_OK; c++) {
        status = ost_bone_occupancy(p->bone, 1, &c, bits, err);
        if (status == OST_OK)
            trace_word(p->w, hash_words(bits, words));
    }
    free(bits);
    return status;
}

/* Returns a random stream that depends only on the bone, so that all backends get the same numbers. */
static draw draw_of(const performer *p, uint64_t number)
{
    const int32_t of[4] = {p->dims.x, p->dims.y, p->dims.z, p->s->threshold};
    draw d = {number};
    for (int i = 0; i < 4; i++)
        d.state = (d.state ^ (uint64_t)of[i]) * UINT64_C(0x100000001b3);
    return d;
}

static ost_status record_densities(performer *p, uint32_t time, ost_error *err)
{
    draw d = draw_of(p, time);
    trace_begin(p->w, TRACE_SAMPLE, p->case_index, 2 * time);
    const ost_status status = sample_words(p, &d, err);
    const ost_status written = perform_end_record(p, TRACE_SAMPLE, 2 * time, err);
    return status != OST_OK ? status : written;
}

static ost_status record_occupancy(performer *p, uint32_t time, ost_error *err)
{
    trace_begin(p->w, TRACE_SAMPLE, p->case_index, 2 * time + 1);
    const ost_status status = occupancy_words(p, err);
    const ost_status written = perform_end_record(p, TRACE_SAMPLE, 2 * time + 1, err);
    return status != OST_OK ? status : written;
}

/* If the backend does not implement a function, the function's record is not compared. If an implemented function
   fails, the case ends. */
ost_status perform_sample(performer *p, uint32_t time, ost_error *err)
{
    const ost_backend_ops *ops = p->backend->ops;
    const ost_status status = ops->bone_sample == ost_no_sample ? perform_record_nothing(p, TRACE_SAMPLE, 2 * time, err)
                                                                : record_densities(p, time, err);
    if (status != OST_OK)
        return status;
    return ops->bone_occupancy == ost_no_occupancy ? perform_record_nothing(p, TRACE_SAMPLE, 2 * time + 1, err)
                                                   : record_occupancy(p, time, err);
}

/* Makes a second bone by uploading the slices of the first bone in parts. Then uploads one part again with other
   densities, some of which are below the threshold. */
static ost_status upload_slices(performer *p, ost_bone *copy, ost_error *err)
{
    draw d = draw_of(p, 2);
    const int32_t z = p->dims.z;
    const size_t slice = (size_t)p->dims.x * (size_t)p->dims.y;
    ost_status status = OST_OK;
    for (int32_t at = 0; at < z && status == OST_OK;) {
        const int32_t left = z - at, part = (int32_t)draw_between(&d, 1, left);
        status = ost_bone_upload(copy, at, part, p->was + slice * (size_t)at, err);
        at += part;
    }
    const int32_t from = (int32_t)draw_between(&d, 0, z - 1), count = (int32_t)draw_between(&d, 1, z - from);
    for (size_t i = 0; i < slice * (size_t)count; i++) {
        const int32_t v = p->was[slice * (size_t)from + i] - 7;
        p->is[i] = (int16_t)(v < -32768 ? v + 14 : v);
    }
    return status == OST_OK ? ost_bone_upload(copy, from, count, p->is, err) : status;
}

ost_status perform_upload(performer *p, ost_error *err)
{
    ost_bone *copy = NULL;
    ost_bone_info info;
    ost_digest root;
    ost_status status = ost_bone_create(p->backend, &p->geometry, p->s->chunk_size, p->s->threshold, &copy, err);
    if (status == OST_OK)
        status = upload_slices(p, copy, err);
    if (status == OST_OK)
        status = ost_bone_info_get(copy, &info, err);
    if (status == OST_OK)
        status = ost_bone_digest(copy, NULL, &root, err);
    trace_begin(p->w, TRACE_UPLOAD, p->case_index, 0);
    if (status == OST_OK) {
        perform_record_counts(p, &info);
        perform_record_digest(p, &root);
    }
    /* The voxels of a larger bone are represented by their digest. */
    if (status == OST_OK && ost_dims_count(p->dims) <= PERFORM_ALL_VOXELS) {
        const int32_t lo[3] = {0, 0, 0};
        int16_t *voxels = trace_block(p->w, lo, p->dims, 2);
        if (voxels)
            status = ost_bone_download(copy, 0, p->dims.z, voxels, err);
    }
    ost_bone_free(copy);
    const ost_status written = perform_end_record(p, TRACE_UPLOAD, 0, err);
    return status != OST_OK ? status : written;
}
