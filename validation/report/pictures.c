/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/report/pictures.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/picture.h>

#include "validation/report/triplet.h"
#include "validation/scene.h"

/* VIEW and SLICE are widths of pictures in pixels. TRIED is the maximum number of differing records that are searched
   for voxels. */
enum { VIEW = 480, SLICE = 420, TRIED = 16 };

void picture_name(char name[PICTURE_NAME], const char *case_id, size_t backend, picture_role role)
{
    static const char *const roles[PICTURE_ROLES] = {"reference", "got", "difference"};
    char id[PLAN_ID];
    size_t n = 0;
    for (; case_id[n] && n < sizeof id - 1; n++) {
        const char c = case_id[n];
        id[n] = (char)((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '-');
    }
    id[n] = '\0';
    snprintf(name, PICTURE_NAME, "pictures/%s-backend-%zu-%s.png", id, backend, roles[role]);
}

static ost_status put_picture(const ost_picture *picture, const char *name, evidence_sink *sink, void *user,
                              ost_error *err)
{
    uint8_t *png = NULL;
    size_t size = 0;
    ost_error missing = {0};
    ost_status status = ost_picture_encode_png(picture, &png, &size, &missing);
    if (status == OST_ERR_UNAVAILABLE)
        return OST_OK;
    if (status == OST_OK)
        status = sink(user, name, png, size, err);
    else
        *err = missing;
    free(png);
    return status;
}

/* ---------------------------------------------------- voxels of a record */

static const trace_record *record_of(const trace *t, compare_range in, trace_stage stage)
{
    for (size_t i = 0; i < in.count; i++)
        if (t->records[in.first + i].stage == stage)
            return &t->records[in.first + i];
    return NULL;
}

static int16_t voxel_of(const trace_block_view *b, size_t i)
{
    int16_t wide;
    if (b->voxel_bytes == 1)
        return b->voxels[i];
    memcpy(&wide, b->voxels + 2 * i, 2); /* memcpy is used, because the voxels of a block need not be aligned */
    return wide;
}

/* Copies a block into a volume. Returns false if the block is not completely inside the volume. */
static bool lay_block(const trace_block_view *b, ost_volume *to)
{
    const ost_dims d = to->geometry.dims;
    if (b->lo[0] < 0 || b->lo[1] < 0 || b->lo[2] < 0 || b->lo[0] > d.x - b->dims.x || b->lo[1] > d.y - b->dims.y ||
        b->lo[2] > d.z - b->dims.z)
        return false;
    size_t i = 0;
    for (int32_t z = 0; z < b->dims.z; z++)
        for (int32_t y = 0; y < b->dims.y; y++)
            for (int32_t x = 0; x < b->dims.x; x++)
                to->voxels[(size_t)(b->lo[0] + x) +
                           (size_t)d.x * ((size_t)(b->lo[1] + y) + (size_t)d.y * (size_t)(b->lo[2] + z))] =
                    voxel_of(b, i++);
    return true;
}

static bool lay_record(const trace_record *r, ost_volume *to)
{
    size_t at = 0;
    trace_block_view block;
    while (trace_next_block(r, &at, &block))
        if (!lay_block(&block, to))
            return false;
    return true;
}

/* Makes a volume with cubic voxels from the first block of a record. Returns false if the record has no block at the
   origin. */
static bool volume_of(const trace_record *r, ost_volume *out)
{
    size_t at = 0;
    trace_block_view block;
    *out = (ost_volume){.voxels = NULL};
    if (!r || !trace_next_block(r, &at, &block) || block.lo[0] || block.lo[1] || block.lo[2])
        return false;
    const ost_geometry g = {block.dims, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    return ost_volume_init(out, &g, NULL) == OST_OK && lay_block(&block, out);
}

/* ------------------------------------------------------------ operation */

/* Computes the view direction, which is the direction in which the first tool enters the bone. */
static void view_direction(const scene *s, double direction[3])
{
    size_t last = 0;
    while (last + 1 < s->path.count && s->path.ticks[last + 1].tool == s->path.ticks[0].tool)
        last++;
    const ost_pm3 a = s->path.ticks[0].pose.t, b = s->path.ticks[last].pose.t;
    direction[0] = (double)(b.x - a.x);
    direction[1] = (double)(b.y - a.y);
    direction[2] = (double)(b.z - a.z);
}

static ost_status draw_operation(const scene *s, ost_volume *before, ost_volume *after, evidence_sink *sink, void *user,
                                 ost_error *err)
{
    ost_view_options view = {.threshold = s->threshold, .width = VIEW, .height = VIEW};
    ost_slices_options slices = {.threshold = s->threshold, .at = {-1, -1, -1}, .pixels = SLICE};
    const ost_pm3 cube = {s->cubic, s->cubic, s->cubic};
    ost_status status = OST_OK;
    before->geometry.spacing = after->geometry.spacing = cube;
    if (s->path.count)
        view_direction(s, view.direction);
    for (int k = 0; k < 4 && status == OST_OK; k++) {
        static const char *const names[4] = {PICTURE_BEFORE, PICTURE_AFTER, PICTURE_SLICES_BEFORE,
                                             PICTURE_SLICES_AFTER};
        const ost_volume *now = k % 2 ? after : before, *old = k % 2 ? before : NULL;
        ost_picture picture = {0};
        if (k == 2) { /* Both pictures show the slices through the centre of the removed voxels. */
            int64_t sum[3] = {0, 0, 0}, n = 0;
            const ost_dims d = before->geometry.dims;
            for (int64_t v = 0; v < ost_dims_count(d); v++)
                if (before->voxels[v] != after->voxels[v]) {
                    sum[0] += v % d.x;
                    sum[1] += v / d.x % d.y;
                    sum[2] += v / d.x / d.y;
                    n++;
                }
            for (int a = 0; a < 3 && n; a++)
                slices.at[a] = (int32_t)(sum[a] / n);
        }
        status = k < 2 ? ost_picture_view(now, old, &view, &picture, err)
                       : ost_picture_slices(now, old, &slices, &picture, err);
        if (status == OST_OK)
            status = put_picture(&picture, names[k], sink, user, err);
        ost_picture_free(&picture);
    }
    return status;
}

ost_status pictures_of_operation(const campaign *c, evidence_sink *sink, void *user, ost_error *err)
{
    for (int i = 0; i < c->plan->count; i++) {
        scene s;
        ost_volume before = {.voxels = NULL}, after = {.voxels = NULL};
        if (c->plan->cases[i].family != PLAN_OPERATION || c->plan->cases[i].number != 0 || !c->ranges[i].count)
            continue;
        ost_status status = scene_make(&c->plan->cases[i], &s, err);
        if (status != OST_OK)
            return status;
        if (volume_of(record_of(&c->reference, c->ranges[i], TRACE_CHUNKS), &before) &&
            volume_of(record_of(&c->reference, c->ranges[i], TRACE_FINAL), &after) &&
            ost_geometry_equal(&before.geometry, &after.geometry))
            status = draw_operation(&s, &before, &after, sink, user, err);
        ost_volume_free(&before);
        ost_volume_free(&after);
        scene_free(&s);
        return status;
    }
    return OST_OK;
}

/* ----------------------------------------------------------- differences */

/*
 * Makes the volumes of the reference and of the backend at record `at` of the case. The leaves of a tick are copied
 * into the bone before the tick.
 */
static bool volumes_at(const campaign *c, int case_index, size_t at, const trace_record *got, ost_volume *a,
                       ost_volume *b)
{
    const trace_record *in = &c->reference.records[c->ranges[case_index].first];
    if (in[at].stage != got->stage || in[at].item != got->item)
        return false;
    if (in[at].stage != TRACE_TICK)
        return volume_of(&in[at], a) && volume_of(got, b) && ost_geometry_equal(&a->geometry, &b->geometry);
    const trace_record *first = record_of(&c->reference, c->ranges[case_index], TRACE_CHUNKS);
    if (!volume_of(first, a))
        return false;
    for (size_t i = 0; i < at; i++)
        if (in[i].stage == TRACE_TICK && !lay_record(&in[i], a))
            return false;
    if (ost_volume_init(b, &a->geometry, NULL) != OST_OK)
        return false;
    memcpy(b->voxels, a->voxels, (size_t)ost_dims_count(a->geometry.dims) * sizeof *b->voxels);
    return lay_record(&in[at], a) && lay_record(got, b);
}

void pictures_of_difference(void *keeper, const campaign *c, int case_index, int subject_index, const trace *got,
                            compare_range in_got)
{
    picture_keeper *k = keeper;
    const compare_difference *d = &c->results[(size_t)case_index * (size_t)c->subjects->count + (size_t)subject_index]
                                       .difference;
    ost_volume a = {.voxels = NULL}, b = {.voxels = NULL};
    if (k->err.status != OST_OK || subject_index >= PICTURES_BACKENDS ||
        k->drawn[subject_index] >= PICTURES_A_BACKEND || d->records < 1)
        return;
    /* The first difference may be in a report, so the loop searches for the first record in which a voxel differs.
       Before this record, both bones equal the reference's bone. */
    const compare_range in_ref = c->ranges[case_index];
    triplet t;
    bool differ = false;
    int tried = 0;
    for (size_t at = (size_t)d->records - 1; at < in_ref.count && at < in_got.count && tried < TRIED && !differ; at++) {
        const trace_record *ref = &c->reference.records[in_ref.first + at], *other = &got->records[in_got.first + at];
        if (ref->stage != other->stage || ref->item != other->item)
            break;
        if (ref->body_bytes == other->body_bytes && memcmp(ref->body, other->body, ref->body_bytes) == 0)
            continue;
        ost_volume_free(&a);
        ost_volume_free(&b);
        tried++;
        differ = volumes_at(c, case_index, at, other, &a, &b) && triplet_of(&a, &b, ref->stage == TRACE_TOOL, &t);
    }
    if (differ) {
        ost_status status = OST_OK;
        for (int role = 0; role < PICTURE_ROLES && status == OST_OK; role++) {
            char name[PICTURE_NAME];
            ost_picture picture = {0};
            picture_name(name, c->plan->cases[case_index].id, (size_t)subject_index, (picture_role)role);
            status = triplet_draw(&t, (picture_role)role, &picture, &k->err);
            if (status == OST_OK)
                status = put_picture(&picture, name, k->sink, k->user, &k->err);
            ost_picture_free(&picture);
        }
        k->drawn[subject_index]++;
    }
    ost_volume_free(&a);
    ost_volume_free(&b);
}
