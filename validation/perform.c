/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/perform.h"

#include <stdlib.h>
#include <string.h>

#include "core/backend.h"
#include "sim/world.h"
#include "validation/compare.h"
#include "validation/dense/steps.h"
#include "validation/draw.h"
#include "validation/steps_make.h"

/*
 * A bone is fetched whole after each tick up to PERFORM_WHOLE; a larger one in
 * the slices that the event could reach, and whole every WHOLE_EVERY ticks and
 * at the end: what a backend changes where its event could not reach shows
 * that much later.  For a million voxels the fetching is nine tenths of a
 * tick's time, for a device's more.
 */
enum { WHOLE_EVERY = 32 };

typedef struct performer {
    ost_backend *backend;
    const scene *s;
    trace_writer *w;
    uint32_t case_index;
    ost_bone *bone;
    ost_tool *tools[SCENE_TOOLS_MAX];
    ost_tool_geometry grids[SCENE_TOOLS_MAX]; /* theirs */
    ost_world *world;
    ost_geometry geometry; /* of the bone, as the maps have it */
    ost_dims dims;         /* as the backend has it */
    int16_t *was, *is;    /* the bone as last recorded, and as fetched */
    ost_report collided, removed;
    bool second;          /* the steps are the second implementation's, and there is no world */
    bool light;           /* of second: ticks' steps alone are made */
    ost_path path;        /* the ticks; own_path: to be freed */
    bool own_path;
    steps_history history; /* of second */
    ost_pose *made_poses;  /* owned; of a backend that makes them itself, room for OST_SWEEP_MAX */
    ost_map *made_maps;
    ost_map *maps;         /* owned; of second: an event's, room for OST_SWEEP_MAX */
    ost_voxel_box *boxes;
    perform_watch *watch;
    void *user;
    const trace *given; /* apart: the reference's; else NULL */
    compare_range in_given;
    bool refused;       /* the CT has a rejected or a conflicting sample: the case ends with its report */
    int16_t *right;     /* apart: the bone as the reference has it */
} performer;

/* A case without a bone: its ticks' steps alone are made. */
static bool is_of_steps(const scene *s)
{
    return !s->sample_count && s->path.count;
}

static size_t at_voxel(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

/* The record that was begun. */
static ost_status end_record(performer *p, trace_stage stage, uint32_t item, ost_error *err)
{
    ost_status status = trace_end(p->w, err);
    if (status == OST_OK && p->watch)
        p->watch(p->user, stage, item);
    return status;
}

/* ------------------------------------------------------------------- apart */

static ost_status given_record(const performer *p, trace_stage stage, uint32_t item, const trace_record **out, ost_error *err)
{
    for (size_t i = 0; i < p->in_given.count; i++) {
        *out = &p->given->records[p->in_given.first + i];
        if ((*out)->stage == stage && (*out)->item == item)
            return OST_OK;
    }
    return ost_fail(err, OST_ERR_INPUT, "the reference made no %s %u that could be given to the next stage", trace_stage_name(stage), (unsigned)item);
}

/* The one block of a whole grid. */
static ost_status given_grid(const performer *p, trace_stage stage, uint32_t item, uint32_t voxel_bytes, ost_dims dims, trace_block_view *out, ost_error *err)
{
    const trace_record *r;
    size_t at = 0;
    ost_status status = given_record(p, stage, item, &r, err);
    if (status == OST_OK && (!trace_next_block(r, &at, out) || out->voxel_bytes != voxel_bytes || out->dims.x != dims.x || out->dims.y != dims.y || out->dims.z != dims.z))
        status = ost_fail(err, OST_ERR_INPUT, "the reference's %s has not the size of this backend's", trace_stage_name(stage));
    return status;
}

static ost_status give_grid(const performer *p, trace_stage stage, ost_grid *grid, ost_error *err)
{
    const ost_dims dims = ost_grid_geometry(grid)->dims;
    trace_block_view block;
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, stage, 0, sizeof(int16_t), dims, &block, err);
    if (status != OST_OK)
        return status;
    const size_t bytes = (size_t)ost_dims_count(dims) * sizeof(int16_t);
    int16_t *voxels = malloc(bytes); /* a trace does not align them */
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a grid of %zu bytes", bytes);
    memcpy(voxels, block.voxels, bytes);
    status = ost_grid_upload(grid, 0, dims.z, voxels, err);
    free(voxels);
    return status;
}

static ost_status give_bone(performer *p, ost_error *err)
{
    trace_block_view block;
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, TRACE_CHUNKS, 0, sizeof(int16_t), p->dims, &block, err);
    if (status != OST_OK)
        return status;
    const size_t bytes = (size_t)ost_dims_count(p->dims) * sizeof(int16_t);
    p->right = malloc(bytes);
    if (!p->right)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a bone of %zu bytes", bytes);
    memcpy(p->right, block.voxels, bytes);
    memcpy(p->was, p->right, bytes);
    return ost_bone_upload(p->bone, 0, p->dims.z, p->right, err);
}

static ost_status give_tool(performer *p, int i, const ost_tool_geometry *geometry, ost_error *err)
{
    trace_block_view block;
    ost_tool_volume volume = {0};
    if (!p->given)
        return OST_OK;
    ost_status status = given_grid(p, TRACE_TOOL, (uint32_t)i, 1, geometry->dims, &block, err);
    if (status == OST_OK)
        status = ost_tool_volume_init(&volume, geometry, err);
    if (status == OST_OK) {
        memcpy(volume.voxels, block.voxels, (size_t)ost_dims_count(geometry->dims));
        ost_tool_free(p->tools[i]);
        p->tools[i] = NULL;
        status = ost_tool_upload(p->backend, &volume, &p->tools[i], err);
    }
    ost_tool_volume_free(&volume);
    return status;
}

/* The bone after tick i, where slices [z0, z1) were fetched: a difference ends with its tick. */
static ost_status give_tick(performer *p, uint32_t i, int32_t z0, int32_t z1, ost_error *err)
{
    const ost_dims d = p->dims;
    const trace_record *r;
    trace_block_view block;
    size_t at = 0;
    if (!p->given)
        return OST_OK;
    const ost_status status = given_record(p, TRACE_TICK, i, &r, err);
    if (status != OST_OK)
        return status;
    while (trace_next_block(r, &at, &block)) {
        const ost_dims n = block.dims;
        if (block.voxel_bytes != sizeof(int16_t) || block.lo[0] < 0 || block.lo[1] < 0 || block.lo[2] < 0 || block.lo[0] + n.x > d.x || block.lo[1] + n.y > d.y ||
            block.lo[2] + n.z > d.z)
            return ost_fail(err, OST_ERR_INPUT, "a leaf of the reference's tick %u lies outside of the bone", (unsigned)i);
        for (int32_t k = 0; k < n.z; k++)
            for (int32_t j = 0; j < n.y; j++)
                memcpy(p->right + at_voxel(d, block.lo[0], block.lo[1] + j, block.lo[2] + k),
                       block.voxels + sizeof(int16_t) * (size_t)n.x * ((size_t)j + (size_t)n.y * (size_t)k), sizeof(int16_t) * (size_t)n.x);
    }
    if (z0 >= z1)
        return OST_OK;
    const size_t from = at_voxel(d, 0, 0, z0), bytes = sizeof(int16_t) * (at_voxel(d, 0, 0, z1) - from);
    if (memcmp(p->was + from, p->right + from, bytes) == 0)
        return OST_OK;
    memcpy(p->was + from, p->right + from, bytes);
    return ost_bone_upload(p->bone, z0, z1 - z0, p->right + from, err);
}

/* ------------------------------------------------------------------ stages */

static ost_status record_grid(performer *p, const ost_grid *grid, ost_error *err)
{
    const ost_dims dims = ost_grid_geometry(grid)->dims;
    const int32_t lo[3] = {0, 0, 0};
    int16_t *voxels = trace_block(p->w, lo, dims, 2);
    return voxels ? ost_grid_download(grid, 0, dims.z, voxels, err) : OST_OK; /* trace_end says what is wrong */
}

static void record_bone_counts(performer *p, const ost_bone_info *info)
{
    trace_word(p->w, (uint64_t)info->chunks);
    trace_word(p->w, (uint64_t)info->active_chunks);
    trace_word(p->w, (uint64_t)info->active_voxels);
}

/* The samples, which are one a voxel and on the lattice, as slices: s->slices of them a call. */
static ost_status upload_ct(performer *p, ost_grid *rect, ost_error *err)
{
    const scene *s = p->s;
    const ost_geometry *g = &s->rect;
    const size_t slice = (size_t)g->dims.x * (size_t)g->dims.y;
    int16_t *voxels = calloc(slice * (size_t)g->dims.z, sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a CT of %d slices", (int)g->dims.z);
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        voxels[(size_t)((one->x - g->origin.x) / g->spacing.x) + (size_t)g->dims.x * (size_t)((one->y - g->origin.y) / g->spacing.y) +
               slice * (size_t)((one->z - g->origin.z) / g->spacing.z)] = (int16_t)one->density;
    }
    ost_status status = OST_OK;
    for (int32_t z = 0; z < g->dims.z && status == OST_OK; z += s->slices) {
        const int32_t count = g->dims.z - z < s->slices ? g->dims.z - z : s->slices;
        status = ost_grid_upload(rect, z, count, voxels + slice * (size_t)z, err);
    }
    free(voxels);
    return status;
}

/* A rejected or conflicting sample ends an import: its grid is of no use. */
static bool refused(const ost_scatter_report *r)
{
    return r->rejected_line != 0 || r->conflict_line != 0;
}

static ost_status run_rect(performer *p, ost_grid **out, ost_error *err)
{
    const scene *s = p->s;
    ost_scatter_report r = {0};
    ost_status status = ost_grid_create(p->backend, &s->rect, out, err);
    if (s->slices && status == OST_OK)
        status = upload_ct(p, *out, err);
    for (size_t at = s->slices ? s->sample_count : 0; at < s->sample_count && status == OST_OK; at += s->batch) {
        const size_t n = s->sample_count - at < s->batch ? s->sample_count - at : s->batch;
        status = ost_ct_to_rect(*out, s->samples + at, n, (int64_t)at + 1, s->duplicates, &r, err);
    }
    if (status != OST_OK)
        return status;
    const int64_t words[] = {(int64_t)r.samples, (int64_t)r.duplicates, (int64_t)r.off_lattice, (int64_t)r.worst_offset_ppm, r.worst_line,
                             r.rejected_line,    r.conflict_line,       r.conflict_had,         r.conflict_has};
    trace_begin(p->w, TRACE_RECT, p->case_index, 0);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        trace_word(p->w, (uint64_t)words[i]);
    if (refused(&r))
        p->refused = true;
    else
        status = record_grid(p, *out, err);
    ost_status written = end_record(p, TRACE_RECT, 0, err);
    return status != OST_OK ? status : written;
}

static ost_status run_cubic(performer *p, const ost_grid *rect, ost_grid **out, ost_error *err)
{
    ost_status status = ost_rect_to_cubic(rect, p->s->cubic, p->s->resample, out, err);
    if (status != OST_OK)
        return status;
    const ost_geometry *g = ost_grid_geometry(*out);
    const int64_t words[] = {g->dims.x, g->dims.y, g->dims.z, g->spacing.x, g->spacing.y, g->spacing.z};
    trace_begin(p->w, TRACE_CUBIC, p->case_index, 0);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        trace_word(p->w, (uint64_t)words[i]);
    status = record_grid(p, *out, err);
    ost_status written = end_record(p, TRACE_CUBIC, 0, err);
    return status != OST_OK ? status : written;
}

/* The backend's own digest is a result like any other. */
static void record_digest(performer *p, const ost_digest *root)
{
    for (int i = 0; i < 4; i++) {
        uint64_t word;
        memcpy(&word, root->bytes + 8 * i, 8);
        trace_word(p->w, word);
    }
}

static ost_status record_whole_bone(performer *p, trace_stage stage, ost_error *err)
{
    ost_bone_info info;
    const int32_t lo[3] = {0, 0, 0};
    ost_digest root;
    ost_status status = ost_bone_info_get(p->bone, &info, err);
    if (status == OST_OK)
        status = ost_bone_digest(p->bone, NULL, &root, err);
    if (status != OST_OK)
        return status;
    trace_begin(p->w, stage, p->case_index, 0);
    record_bone_counts(p, &info);
    record_digest(p, &root);
    int16_t *voxels = trace_block(p->w, lo, info.geometry.dims, 2);
    if (voxels)
        status = ost_bone_download(p->bone, 0, info.geometry.dims.z, voxels, err);
    if (voxels && status == OST_OK)
        memcpy(p->was, voxels, (size_t)ost_dims_count(p->dims) * 2);
    ost_status written = end_record(p, stage, 0, err);
    return status != OST_OK ? status : written;
}

/* ------------------------------------------------------ sampling and upload */

enum { SAMPLES_MAX = 33 };

/* FNV-1a */
static uint64_t hash_words(const uint32_t *words, size_t count)
{
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < count; i++)
        h = (h ^ words[i]) * UINT64_C(0x100000001b3);
    return h;
}

/* Densities of 0 to 33 voxels a call, on both sides of the grid's borders, so that every remainder of a vector comes up. */
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
                at[a][i] = (int32_t)(draw_one_in(d, 4) ? border + draw_between(d, -2, 1) : draw_between(d, 0, dims[a] - 1));
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
        return ost_fail(err, OST_ERR_MEMORY, "no memory for the occupancy of a chunk");
    for (int32_t c = 0; c < info.chunks && status == OST_OK; c++) {
        status = ost_bone_occupancy(p->bone, 1, &c, bits, err);
        if (status == OST_OK)
            trace_word(p->w, hash_words(bits, words));
    }
    free(bits);
    return status;
}

/* A backend that has no such function says so; its record is compared with nothing. */
static ost_status end_optional(performer *p, trace_stage stage, uint32_t item, ost_status status, ost_error *err)
{
    if (status == OST_ERR_UNAVAILABLE) {
        trace_begin(p->w, stage, p->case_index, item);
        trace_flags(p->w, TRACE_STANDS_IN);
        *err = (ost_error){0};
        status = OST_OK;
    }
    const ost_status written = end_record(p, stage, item, err);
    return status != OST_OK ? status : written;
}

/* A stream of the bone's own, whoever runs the case. */
static draw draw_of(const performer *p, uint64_t number)
{
    const int32_t of[4] = {p->dims.x, p->dims.y, p->dims.z, p->s->threshold};
    draw d = {number};
    for (int i = 0; i < 4; i++)
        d.state = (d.state ^ (uint64_t)of[i]) * UINT64_C(0x100000001b3);
    return d;
}

/* time 0: the bone as it was imported, items 0 and 1; 1: at the end, items 2 and 3. */
static ost_status run_sample(performer *p, uint32_t time, ost_error *err)
{
    draw d = draw_of(p, time);
    trace_begin(p->w, TRACE_SAMPLE, p->case_index, 2 * time);
    ost_status status = sample_words(p, &d, err);
    status = end_optional(p, TRACE_SAMPLE, 2 * time, status, err);
    if (status != OST_OK)
        return status;
    trace_begin(p->w, TRACE_SAMPLE, p->case_index, 2 * time + 1);
    status = occupancy_words(p, err);
    return end_optional(p, TRACE_SAMPLE, 2 * time + 1, status, err);
}

/* A second bone of the slices of the first, in parts; then a part again with other densities, some below the threshold. */
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

static ost_status run_upload(performer *p, ost_error *err)
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
        record_bone_counts(p, &info);
        record_digest(p, &root);
    }
    if (status == OST_OK && ost_dims_count(p->dims) <= PERFORM_WHOLE) { /* of a larger one the digest alone */
        const int32_t lo[3] = {0, 0, 0};
        int16_t *voxels = trace_block(p->w, lo, p->dims, 2);
        if (voxels)
            status = ost_bone_download(copy, 0, p->dims.z, voxels, err);
    }
    ost_bone_free(copy);
    return end_optional(p, TRACE_UPLOAD, 0, status, err);
}

static ost_status run_import(performer *p, ost_error *err)
{
    ost_grid *rect = NULL, *cubic = NULL;
    ost_status status = run_rect(p, &rect, err);
    if (p->refused) {
        ost_grid_free(rect);
        return status;
    }
    if (status == OST_OK)
        status = give_grid(p, TRACE_RECT, rect, err);
    if (status == OST_OK)
        status = run_cubic(p, rect, &cubic, err);
    if (status == OST_OK)
        status = give_grid(p, TRACE_CUBIC, cubic, err);
    if (status == OST_OK)
        status = ost_cubic_to_chunks(cubic, p->s->chunk_size, p->s->threshold, &p->bone, err);
    if (status == OST_OK) {
        p->geometry = p->second ? steps_cubic(&p->s->rect, p->s->cubic) : *ost_grid_geometry(cubic);
        p->dims = ost_grid_geometry(cubic)->dims;
        const size_t bytes = (size_t)ost_dims_count(p->dims) * 2;
        p->was = malloc(bytes);
        p->is = malloc(bytes);
        status = p->was && p->is ? record_whole_bone(p, TRACE_CHUNKS, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for a bone of %zu bytes", bytes);
    }
    if (status == OST_OK)
        status = give_bone(p, err);
    if (status == OST_OK)
        status = run_sample(p, 0, err);
    if (status == OST_OK)
        status = run_upload(p, err);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return status;
}

/* The backend's own snapped meshes in place of src/core's, where it makes them. */
static ost_status snap_by_backend(performer *p, const scene_tool *t, ost_snapped_mesh meshes[2], bool *own, bool *made, ost_error *err)
{
    ost_snapped_mesh its[2] = {{.fraction_bits = 0}, {.fraction_bits = 0}};
    if (p->second || !p->backend->ops->snap || !t->raw[0].triangle_count)
        return OST_OK;
    ost_status status = p->backend->ops->snap(p->backend, &t->raw[0], &meshes[0].grid, &its[0], err);
    if (status == OST_OK && t->raw[1].triangle_count)
        status = p->backend->ops->snap(p->backend, &t->raw[1], &meshes[0].grid, &its[1], err);
    if (status == OST_ERR_UNAVAILABLE)
        return OST_OK;
    *made = *own = status == OST_OK;
    for (int k = 0; k < 2 && *made; k++)
        meshes[k] = its[k];
    steps_meshes_free(its, status != OST_OK);
    return status;
}

/* A tool's grid and meshes on it, before a voxel is made. */
static ost_status record_snap(performer *p, int i, const ost_snapped_mesh meshes[2], bool made, ost_error *err)
{
    trace_begin(p->w, TRACE_SNAP, p->case_index, (uint32_t)i);
    if (made)
        trace_flags(p->w, TRACE_MADE);
    const ost_status status = steps_put_snap(p->w, p->s->tools[i].raw[0].triangle_count ? meshes : NULL, err);
    const ost_status written = end_record(p, TRACE_SNAP, (uint32_t)i, err);
    return status != OST_OK ? status : written;
}

static ost_status run_tool(performer *p, int i, ost_error *err)
{
    const scene_tool *t = &p->s->tools[i];
    const int32_t lo[3] = {0, 0, 0};
    ost_voxelize_report r;
    ost_tool_volume volume = {0};
    ost_snapped_mesh meshes[2];
    bool own;
    bool made = false;
    ost_status status = steps_meshes_of(p->second, t, meshes, &own, err);
    if (status == OST_OK)
        status = snap_by_backend(p, t, meshes, &own, &made, err);
    if (status == OST_OK)
        status = record_snap(p, i, meshes, made, err);
    if (status == OST_OK)
        p->grids[i] = meshes[0].grid;
    if (status == OST_OK && !is_of_steps(p->s))
        status = ost_voxelize(p->backend, &meshes[0], meshes[1].triangle_count ? &meshes[1] : NULL, t->rule, &r, &p->tools[i], err);
    steps_meshes_free(meshes, own);
    if (status != OST_OK || is_of_steps(p->s))
        return status;
    if (status == OST_OK)
        status = ost_tool_download(p->tools[i], &volume, err);
    if (status == OST_OK) {
        trace_begin(p->w, TRACE_TOOL, p->case_index, (uint32_t)i);
        trace_word(p->w, r.solid_voxels);
        trace_word(p->w, r.cutting_voxels);
        trace_word(p->w, r.leaking_rows);
        uint8_t *voxels = trace_block(p->w, lo, volume.geometry.dims, 1);
        if (voxels)
            memcpy(voxels, volume.voxels, (size_t)ost_dims_count(volume.geometry.dims));
        status = end_record(p, TRACE_TOOL, (uint32_t)i, err);
    }
    if (status == OST_OK)
        status = give_tool(p, i, &volume.geometry, err);
    ost_tool_volume_free(&volume);
    return status;
}

/* AR-CLS-2 where a scene has no classes of its own. */
static ost_density_classes classes_of(const performer *p)
{
    if (p->world)
        return *ost_world_classes(p->world);
    return p->s->world.classes.count ? p->s->world.classes : (ost_density_classes){.count = 3, .border = {120, 150, 650}};
}

/* A record that another implementation fills: this one made nothing there. */
static ost_status record_nothing(performer *p, trace_stage stage, uint32_t item, ost_error *err)
{
    trace_begin(p->w, stage, p->case_index, item);
    trace_flags(p->w, TRACE_STANDS_IN);
    return end_record(p, stage, item, err);
}

/* Totals, then per chunk: number, voxels and sums of densities of every class. */
static void record_report(performer *p, const ost_report *r)
{
    const int classes = classes_of(p).count;
    trace_word(p->w, r ? r->total_voxels : 0);
    trace_word(p->w, r ? r->touched_voxels : 0);
    trace_word(p->w, r ? r->count : 0);
    for (size_t i = 0; r && i < r->count; i++) {
        trace_word(p->w, (uint64_t)(int64_t)r->chunks[i].chunk);
        for (int c = 0; c < classes; c++) {
            trace_word(p->w, r->chunks[i].voxels[c]);
            trace_word(p->w, (uint64_t)r->chunks[i].density[c]);
        }
    }
}

/* Blocks of the leaves in slices [z0, z1) where `is` is not `was`; `was` becomes `is`. */
static void record_changed(performer *p, int32_t z0, int32_t z1)
{
    const ost_dims d = p->dims;
    for (int32_t z = z0; z < z1; z += OST_LEAF)
        for (int32_t y = 0; y < d.y; y += OST_LEAF)
            for (int32_t x = 0; x < d.x; x += OST_LEAF) {
                const ost_dims n = {d.x - x < OST_LEAF ? d.x - x : OST_LEAF, d.y - y < OST_LEAF ? d.y - y : OST_LEAF, d.z - z < OST_LEAF ? d.z - z : OST_LEAF};
                bool changed = false;
                for (int32_t k = 0; k < n.z && !changed; k++)
                    for (int32_t j = 0; j < n.y && !changed; j++) {
                        const size_t at = at_voxel(d, x, y + j, z + k);
                        changed = memcmp(p->is + at, p->was + at, (size_t)n.x * 2) != 0;
                    }
                if (!changed)
                    continue;
                const int32_t lo[3] = {x, y, z};
                int16_t *to = trace_block(p->w, lo, n, 2);
                for (int32_t k = 0; k < n.z; k++)
                    for (int32_t j = 0; j < n.y; j++) {
                        const size_t at = at_voxel(d, x, y + j, z + k);
                        if (to)
                            memcpy(to + (size_t)n.x * ((size_t)j + (size_t)n.y * (size_t)k), p->is + at, (size_t)n.x * 2);
                        memcpy(p->was + at, p->is + at, (size_t)n.x * 2);
                    }
            }
}

/* Poses and maps that the backend makes itself of the same two poses; the event itself is run with the host's, which must be the same ones. */
static ost_status steps_by_backend(performer *p, const ost_tick *tick, int handed, const ost_pose *from, int *count, bool *made, ost_error *err)
{
    if (p->second || !p->backend->ops->steps)
        return OST_OK;
    if (!p->made_poses)
        p->made_poses = malloc(OST_SWEEP_MAX * sizeof *p->made_poses);
    if (!p->made_maps)
        p->made_maps = malloc(OST_SWEEP_MAX * sizeof *p->made_maps);
    if (!p->made_poses || !p->made_maps)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %d poses", OST_SWEEP_MAX);
    int its = handed;
    const bool sweeps = memcmp(from, &tick->pose, sizeof *from) != 0;
    const ost_status status = p->backend->ops->steps(p->backend, &p->geometry, &p->grids[tick->tool], sweeps ? from : NULL, &tick->pose, &its, p->made_poses,
                                                     p->made_maps, err);
    if (status == OST_ERR_UNAVAILABLE)
        return OST_OK;
    *made = status == OST_OK || status == OST_ERR_RANGE; /* which refuses an event that the host has */
    *count = status == OST_OK ? its : status == OST_ERR_RANGE ? 0 : handed;
    return *made ? OST_OK : status;
}

/* The poses of tick i's event, from `from` to the tick's; their maps go into p->maps where the event is run here. */
static ost_status record_steps(performer *p, size_t i, bool refused, bool removal, int count, const ost_pose *from, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    bool made_by_backend = false;
    ost_status status = removal ? steps_by_backend(p, tick, count, from, &count, &made_by_backend, err) : OST_OK;
    trace_begin(p->w, TRACE_STEPS, p->case_index, (uint32_t)i);
    trace_flags(p->w, (p->second ? TRACE_BOUNDS : 0) | (made_by_backend ? TRACE_MADE : 0));
    steps_put_tick(p->w, refused, removal, count, tick);
    for (int k = 1; k <= count && status == OST_OK; k++) {
        const ost_pose pose = made_by_backend ? p->made_poses[k - 1] : steps_between(p->second, from, &tick->pose, k, count);
        steps_pose made;
        status = steps_pose_of(p->second, &pose, &p->geometry, &p->grids[tick->tool], &made, err);
        if (status != OST_OK)
            break;
        if (made_by_backend)
            made.map = p->made_maps[k - 1];
        steps_put_pose(p->w, &made);
        if (p->maps) {
            p->maps[k - 1] = made.map;
            p->boxes[k - 1] = (ost_voxel_box){.hi = {p->dims.x, p->dims.y, p->dims.z}};
        }
    }
    const ost_status written = end_record(p, TRACE_STEPS, (uint32_t)i, err);
    return status != OST_OK ? status : written;
}

/* The world's step. */
static ost_status step_of_world(performer *p, size_t i, ost_step_result *r, bool *refused, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    const ost_world *world = p->world;
    const bool anew = tick->tool != world->clock.tool || tick->lifted || world->options.sweep_off;
    const ost_pose from = anew ? tick->pose : world->tools[tick->tool].input.event;
    ost_error why = {0};
    const ost_status stepped = ost_world_step(p->world, tick, r, &why);
    *refused = stepped == OST_ERR_RANGE; /* a jump too far is an answer; anything else is a failure */
    if (stepped != OST_OK && !*refused) {
        *err = why;
        return stepped;
    }
    return record_steps(p, i, *refused, r->removal, r->pose_count, &from, err);
}

/* The second implementation's: no world, no box, every pose over the whole grid. */
static ost_status step_of_second(performer *p, size_t i, ost_step_result *r, bool *refused, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    const steps_event e = steps_next(&p->history, i, &p->grids[tick->tool], p->geometry.spacing.x);
    const ost_density_classes classes = classes_of(p);
    *refused = e.refused;
    *r = (ost_step_result){.removal = e.removal, .pose_count = e.count};
    ost_status status = record_steps(p, i, e.refused, e.removal, e.count, &e.from, err);
    if (status != OST_OK || !e.removal || p->light)
        return status;
    const ost_event event = {.pose_count = e.count, .maps = p->maps, .boxes = p->boxes, .classes = &classes};
    r->report = &p->removed;
    return ost_bone_remove(p->bone, p->tools[tick->tool], &event, &p->removed, err);
}

static ost_status run_tick(performer *p, size_t i, ost_error *err)
{
    const ost_dims d = p->dims;
    ost_step_result r = {0};
    bool refused;
    ost_status status = (p->second ? step_of_second : step_of_world)(p, i, &r, &refused, err);
    if (status != OST_OK)
        return status;
    if (p->light)
        return record_nothing(p, TRACE_TICK, (uint32_t)i, err);
    trace_begin(p->w, TRACE_TICK, p->case_index, (uint32_t)i);
    if (p->second)
        trace_flags(p->w, TRACE_BOUNDS);
    trace_word(p->w, refused ? OST_ERR_RANGE : OST_OK);
    trace_word(p->w, r.removal);
    trace_word(p->w, r.boxes_meet);
    trace_word(p->w, (uint64_t)r.pose_count);
    for (int a = 0; a < 3; a++) {
        trace_word(p->w, (uint64_t)(int64_t)r.chunk_lo[a]);
        trace_word(p->w, (uint64_t)(int64_t)r.chunk_hi[a]);
    }
    record_report(p, r.report);
    int32_t z0 = 0, z1 = d.z;
    if (ost_dims_count(d) > PERFORM_WHOLE && (i + 1) % WHOLE_EVERY != 0 && !p->second) {
        const int32_t size = p->s->chunk_size;
        z0 = r.chunk_lo[2] * size / OST_LEAF * OST_LEAF;
        z1 = (r.chunk_hi[2] * size + OST_LEAF - 1) / OST_LEAF * OST_LEAF;
        z0 = z0 < 0 ? 0 : z0;
        z1 = z1 > d.z ? d.z : z1;
    }
    if (z0 < z1) {
        status = ost_bone_download(p->bone, z0, z1 - z0, p->is + at_voxel(d, 0, 0, z0), err);
        if (status == OST_OK)
            record_changed(p, z0, z1);
    }
    ost_status written = end_record(p, TRACE_TICK, (uint32_t)i, err);
    if (status == OST_OK && written == OST_OK)
        status = give_tick(p, (uint32_t)i, z0, z1, err);
    return status != OST_OK ? status : written;
}

/* A case of steps: each tick goes on from the one before it, where that has the same tool. */
static ost_status run_steps(performer *p, size_t i, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    int count = 1;
    ost_pose from = tick->pose;
    if (i > 0 && tick[-1].tool == tick->tool && !tick->lifted && !p->s->world.sweep_off) {
        from = tick[-1].pose;
        count = steps_count_of(p->second, &from, &tick->pose, &p->grids[tick->tool], p->geometry.spacing.x);
    }
    return record_steps(p, i, count == 0, count > 0, count, &from, err);
}

/* The same pose asked alone, over the whole grid: nothing is skipped by boxes, and nothing may change. */
static ost_status run_collide(performer *p, size_t i, ost_error *err)
{
    const ost_tick *tick = &p->path.ticks[i];
    steps_pose made;
    if (p->light)
        return record_nothing(p, TRACE_COLLIDE, (uint32_t)i, err);
    ost_status status = steps_pose_of(p->second, &tick->pose, &p->geometry, &p->grids[tick->tool], &made, err);
    if (status != OST_OK)
        return status;
    const ost_voxel_box box = {{0, 0, 0}, {p->dims.x, p->dims.y, p->dims.z}};
    const ost_density_classes classes = classes_of(p);
    const ost_event event = {.pose_count = 1, .maps = &made.map, .boxes = &box, .classes = &classes};
    status = ost_bone_collide(p->bone, p->tools[tick->tool], &event, &p->collided, err);
    if (status != OST_OK)
        return status;
    trace_begin(p->w, TRACE_COLLIDE, p->case_index, (uint32_t)i);
    record_report(p, &p->collided);
    return end_record(p, TRACE_COLLIDE, (uint32_t)i, err);
}

/* Voxels times ticks up to which the second implementation runs events as well: it takes about a microsecond for a thousand. */
#define SECOND_WORK ((int64_t)1 << 25)

/* What a case's ticks are run in: a world, or the second implementation's history and room for an event. */
static ost_status begin_ticks(performer *p, ost_error *err)
{
    const scene *s = p->s;
    ost_status status = OST_OK;
    if (is_of_steps(s)) {
        p->geometry = s->rect;
        p->dims = s->rect.dims;
        return OST_OK;
    }
    if (!p->second) {
        status = ost_world_create(p->bone, &s->world, &p->world, err);
        for (int i = 0; i < s->tool_count && status == OST_OK; i++)
            status = ost_world_add_tool(p->world, s->tools[i].name, p->tools[i], NULL, err);
        return status;
    }
    const ost_pose identity = {.qw = OST_Q30_ONE};
    steps_pose ignored;
    for (int i = 0; i < s->tool_count && status == OST_OK; i++) /* AR-MAP-2 refuses a tool before its first tick */
        status = steps_pose_of(true, &identity, &p->geometry, &p->grids[i], &ignored, err);
    if (status == OST_OK)
        status = steps_history_begin(&p->path, s->world.sweep_off, s->world.removal_period_ns, &p->history, err);
    p->light = ost_dims_count(p->dims) * (int64_t)p->path.count > SECOND_WORK;
    if (status != OST_OK || p->light)
        return status;
    p->maps = calloc(OST_SWEEP_MAX, sizeof *p->maps);
    p->boxes = calloc(OST_SWEEP_MAX, sizeof *p->boxes);
    return p->maps && p->boxes ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "no memory for an event of %d poses", OST_SWEEP_MAX);
}

static ost_status run_stages(performer *p, ost_error *err)
{
    const scene *s = p->s;
    ost_status status = OST_OK;
    if (s->sample_count)
        status = run_import(p, err);
    for (int i = 0; i < s->tool_count && status == OST_OK; i++)
        status = run_tool(p, i, err);
    if (!s->path.count || p->refused || status != OST_OK)
        return status;
    status = steps_path_of(p->second, s, &p->path, &p->own_path, err);
    if (status == OST_OK)
        status = begin_ticks(p, err);
    for (size_t i = 0; i < p->path.count && status == OST_OK; i++) {
        if (is_of_steps(s)) {
            status = run_steps(p, i, err);
            continue;
        }
        if (s->collide_every && i % (size_t)s->collide_every == 0)
            status = run_collide(p, i, err);
        if (status == OST_OK)
            status = run_tick(p, i, err);
    }
    if (status != OST_OK || is_of_steps(s))
        return status;
    if (p->light) {
        for (uint32_t item = 2; item < 4 && status == OST_OK; item++)
            status = record_nothing(p, TRACE_SAMPLE, item, err);
        return status == OST_OK ? record_nothing(p, TRACE_FINAL, 0, err) : status;
    }
    status = run_sample(p, 1, err);
    return status == OST_OK ? record_whole_bone(p, TRACE_FINAL, err) : status;
}

static ost_status perform_case(performer p, ost_error *why, ost_error *err)
{
    const scene *s = p.s;
    trace_writer *w = p.w;
    const uint32_t case_index = p.case_index;
    trace_begin(w, TRACE_CASE, case_index, 0);
    for (size_t i = 0; i < sizeof s->digest.bytes; i += 8) {
        uint64_t word;
        memcpy(&word, s->digest.bytes + i, 8);
        trace_word(w, word);
    }
    ost_status written = trace_end(w, err);
    *why = (ost_error){0};
    if (written == OST_OK && run_stages(&p, why) != OST_OK) {
        trace_begin(w, TRACE_FAILED, case_index, 0);
        trace_word(w, (uint64_t)why->status);
        const int32_t lo[3] = {0, 0, 0};
        const ost_dims line = {(int32_t)strlen(why->text) + 1, 1, 1}; /* for people; only the status is compared */
        char *text = trace_block(w, lo, line, 1);
        if (text)
            memcpy(text, why->text, (size_t)line.x);
        written = trace_end(w, err);
    }
    ost_report_free(&p.collided);
    ost_report_free(&p.removed);
    steps_history_free(&p.history);
    if (p.own_path)
        ost_path_free(&p.path);
    free(p.made_poses);
    free(p.made_maps);
    free(p.maps);
    free(p.boxes);
    ost_world_free(p.world);
    for (int i = 0; i < s->tool_count; i++)
        ost_tool_free(p.tools[i]);
    ost_bone_free(p.bone);
    free(p.was);
    free(p.is);
    free(p.right);
    return written;
}

ost_status perform(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, perform_watch *watch, void *user, ost_error *why,
                   ost_error *err)
{
    return perform_case((performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .watch = watch, .user = user}, why, err);
}

ost_status perform_second(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, ost_error *why, ost_error *err)
{
    return perform_case((performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .second = true}, why, err);
}

ost_status perform_apart(ost_backend *backend, const scene *s, uint32_t case_index, trace_writer *w, const trace *given, ost_error *why, ost_error *err)
{
    const compare_range range = compare_find(given, case_index);
    return perform_case((performer){.backend = backend, .s = s, .w = w, .case_index = case_index, .given = given, .in_given = range}, why, err);
}
