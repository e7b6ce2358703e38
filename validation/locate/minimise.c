/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/minimise.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "validation/perform.h"
#include "validation/user_store.h"
#include "validation/worker.h"

/* BATCH is the maximum number of candidates per process, RUNS is the maximum number of processes per case, LIMIT is the
   time limit of a process in seconds, and PATH is the capacity of a path. */
enum { BATCH = 12, RUNS = 40, LIMIT = 60, PATH = 1200 };

typedef struct job {
    const plan_case *c;
    const char *spec, *program;
    char cases[PATH], trace[PATH], ref[PATH];
    trace_stage stage;
    const char *class;
    minimised *best;
} job;

typedef struct candidates {
    int count;
    scene_cut cut[BATCH];
} candidates;

static void add(candidates *list, const scene_cut *cut)
{
    if (list->count < BATCH)
        list->cut[list->count++] = *cut;
}

/* --------------------------------------------------- running candidates */

static ost_status write_cases(const job *j, const candidates *list, ost_error *err)
{
    json_t *cases = json_array(), *o = json_object();
    for (int i = 0; i < list->count; i++)
        json_array_append_new(cases, case_to_json(j->c, &list->cut[i]));
    json_object_set_new(o, "cases", cases);
    const bool written = json_array_size(cases) == (size_t)list->count &&
                         json_dump_file(o, j->cases, JSON_COMPACT) == 0;
    json_decref(o);
    return written ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: cannot be written", j->cases);
}

static ost_status run_worker(job *j, trace *got, ost_error *err)
{
    const char *const words[] = {j->program, "validate", "--worker",
                                 j->spec,    "--trace",  j->trace,
                                 "--case",   j->cases,   j->c->store ? "--user" : NULL,
                                 NULL};
    char *argv[sizeof words / sizeof words[0]];
    worker w;
    worker_result end;
    ost_error unread = {0};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        argv[i] = (char *)(uintptr_t)words[i];
    ost_status status = worker_start(argv, -1, user_store_fd(j->c->store), LIMIT, &w, err);
    if (status == OST_OK)
        status = worker_wait(&w, &end, err);
    j->best->runs++;
    *got = (trace){0};
    if (status == OST_OK && access(j->trace, F_OK) == 0 && trace_open(j->trace, got, &unread) != OST_OK)
        *got = (trace){0};
    unlink(j->trace);
    return status;
}

static ost_status trace_reference(const job *j, const scene *s, trace *out, ost_error *err)
{
    ost_backend *ref = NULL;
    trace_writer *w = NULL;
    ost_error why;
    ost_status status = ost_backend_open("ref", &ref, err);
    if (status == OST_OK)
        status = trace_create(j->ref, &w, err);
    if (status == OST_OK)
        status = perform(ref, s, 0, w, NULL, NULL, &why, err);
    ost_status closed = trace_close(w, status == OST_OK ? err : NULL);
    status = status != OST_OK ? status : closed;
    if (status == OST_OK)
        status = trace_open(j->ref, out, err);
    unlink(j->ref);
    ost_backend_close(ref);
    return status;
}

/* Compares case i of the worker's trace with the reference. If the case still shows the same difference, sets *same
   to true and makes the case the best case so far. */
static ost_status judge(job *j, const scene_cut *cut, const trace *got, uint32_t i, bool *same, ost_error *err)
{
    plan_case c = *j->c;
    scene_cut own = *cut;
    scene s;
    trace ref = {0};
    ost_error none = {0};
    const compare_range range = compare_find(got, i);
    *same = false;
    c.cut = &own;
    if (!range.count || scene_make(&c, &s, &none) != OST_OK)
        return OST_OK;
    /* The comparison includes the digest of the input, which the worker's trace contains. Therefore the
       reference's trace must contain it too. */
    ost_status status = scene_digest(&s, &s.digest, err);
    if (status == OST_OK)
        status = trace_reference(j, &s, &ref, err);
    if (status == OST_OK) {
        const compare_range in_ref = compare_find(&ref, 0);
        compare_difference d;
        compare_case(&ref, in_ref, got, range, &d);
        if (d.kind != COMPARE_EQUAL && d.stage == j->stage) {
            finding f;
            finding_make(&s, &ref, in_ref, got, range, &d, &f);
            if ((f.class != NULL) == (j->class != NULL) && (!f.class || strcmp(f.class, j->class) == 0)) {
                minimised *m = j->best;
                *same = true;
                m->cut = *cut;
                m->difference = d;
                m->found = f;
                m->samples = s.sample_count;
                m->ticks = s.path.count;
                m->tools = s.tool_count;
                m->rect = s.rect.dims;
                m->triangles = 0;
                for (int t = 0; t < s.tool_count; t++)
                    m->triangles += s.tools[t].cutting.triangle_count + s.tools[t].noncutting.triangle_count;
            }
        }
    }
    trace_free(&ref);
    scene_free(&s);
    return status;
}

/* Runs the candidates, the smallest first. The first candidate that still shows the same difference becomes the best
   case so far. */
static ost_status try_all(job *j, const candidates *list, bool *found, ost_error *err)
{
    trace got;
    *found = false;
    if (!list->count || j->best->runs >= RUNS)
        return OST_OK;
    ost_status status = write_cases(j, list, err);
    if (status == OST_OK)
        status = run_worker(j, &got, err);
    unlink(j->cases);
    if (status != OST_OK)
        return status;
    for (int i = 0; i < list->count && !*found && status == OST_OK; i++)
        status = judge(j, &list->cut[i], &got, (uint32_t)i, found, err);
    trace_free(&got);
    return status;
}

/* ------------------------------------------------------ making candidates */

static cut_list one_range(uint32_t from, uint32_t to)
{
    return (cut_list){.some = true, .count = 1, .range = {{from, to}}};
}

/* Tries to omit later stages, tools without an effect on the difference, and ticks before and after the difference. */
static ost_status cut_stages(job *j, const scene *s, const compare_difference *d, bool *found, ost_error *err)
{
    candidates list = {.count = 0};
    scene_cut cut = {.no_ct = d->stage == TRACE_TOOL || d->stage == TRACE_SNAP,
                     .no_collide = d->stage != TRACE_COLLIDE};
    const uint32_t all = (1u << s->tool_count) - 1;
    if (d->stage == TRACE_RECT || d->stage == TRACE_CUBIC || d->stage == TRACE_RESAMPLE || d->stage == TRACE_CHUNKS) {
        cut.no_tools = all;
        cut.ticks = (cut_list){.some = true};
        add(&list, &cut);
    } else if (d->stage == TRACE_TOOL || d->stage == TRACE_SNAP) {
        cut.no_tools = all & ~(1u << d->item);
        cut.ticks = (cut_list){.some = true};
        add(&list, &cut);
    } else if ((d->stage == TRACE_TICK || d->stage == TRACE_STEPS || d->stage == TRACE_COLLIDE) &&
               d->item < s->path.count) {
        const uint32_t tool = (uint32_t)s->path.ticks[d->item].tool;
        for (uint32_t before = 0;; before = before ? 2 * before : 1) {
            const uint32_t from = before < d->item ? d->item - before : 0;
            cut.ticks = one_range(from, d->item + 1);
            cut.no_tools = all & ~(1u << tool);
            add(&list, &cut);
            if (from == 0)
                break;
            if (list.count == BATCH - 2) {
                cut.ticks = one_range(0, d->item + 1);
                add(&list, &cut);
                break;
            }
        }
        /* Keeps all tools, because the difference may depend on voxels that another tool removed. */
        cut.no_tools = 0;
        add(&list, &cut);
    }
    scene_cut uncut = {.no_collide = false};
    add(&list, &uncut);
    return try_all(j, &list, found, err);
}

/* Finds the rect voxel that contains the centre of a bone voxel. The `linear` rule also reads neighbours of the rect
   voxel. */
static void source_of(const scene *s, trace_stage stage, const int32_t voxel[3], int32_t at[3])
{
    const ost_pm spacing[3] = {s->rect.spacing.x, s->rect.spacing.y, s->rect.spacing.z};
    const int32_t n[3] = {s->rect.dims.x, s->rect.dims.y, s->rect.dims.z};
    for (int a = 0; a < 3; a++) {
        const int64_t top = s->resample == OST_RESAMPLE_THESIS ? 2 * voxel[a] * s->cubic
                                                               : (2 * (int64_t)voxel[a] + 1) * s->cubic;
        const int64_t source = ost_floor_div(top, 2 * spacing[a]);
        at[a] = stage == TRACE_RECT ? voxel[a] : source < n[a] - 1 ? (int32_t)source : n[a] - 1;
    }
}

/* Tries to retain only a part of the grid around the first differing voxel or chunk. First finds the smallest cube
   that shows the same difference, and then reduces each side separately. */
static ost_status cut_grid(job *j, const scene *s, ost_error *err)
{
    const compare_difference *d = &j->best->difference;
    const finding *f = &j->best->found;
    const int32_t n[3] = {s->rect.dims.x, s->rect.dims.y, s->rect.dims.z},
                  align = d->stage == TRACE_TICK ? OST_MAP_BLOCK : 1;
    candidates list = {.count = 0};
    int32_t at[3];
    bool found;
    if (j->best->cut.no_ct)
        return OST_OK;
    if (d->kind == COMPARE_VOXEL)
        source_of(s, d->stage, d->voxel, at);
    /* if the report of a chunk differs, the search starts at the middle of the chunk */
    else if (d->kind == COMPARE_WORD && f->chunk_size) {
        const int32_t middle[3] = {f->chunk[0] * f->chunk_size + f->chunk_size / 2,
                                   f->chunk[1] * f->chunk_size + f->chunk_size / 2,
                                   f->chunk[2] * f->chunk_size + f->chunk_size / 2};
        source_of(s, d->stage, middle, at);
    } else
        return OST_OK;
    for (int32_t radius = 0; radius <= 64 && list.count < BATCH; radius = radius ? 2 * radius : 1) {
        scene_cut cut = j->best->cut;
        bool less = false;
        cut.cropped = true;
        for (int a = 0; a < 3; a++) {
            cut.lo[a] = at[a] - radius < 0 ? 0 : (at[a] - radius) / align * align;
            cut.hi[a] = at[a] + radius + 1 > n[a] ? n[a] : at[a] + radius + 1;
            less |= cut.lo[a] > 0 || cut.hi[a] < n[a];
        }
        if (less)
            add(&list, &cut);
    }
    ost_status status = try_all(j, &list, &found, err);
    for (int round = 0; round < 6 && status == OST_OK; round++) {
        scene_cut now = j->best->cut;
        list.count = 0;
        if (!now.cropped) {
            now.cropped = true;
            for (int a = 0; a < 3; a++) {
                now.lo[a] = 0;
                now.hi[a] = n[a];
            }
        }
        for (int part = 2; part <= 4; part += 2)
            for (int a = 0; a < 3; a++) {
                const int32_t by = (now.hi[a] - now.lo[a]) / part;
                scene_cut less = now;
                if (by < 1)
                    continue;
                less.hi[a] -= by;
                add(&list, &less);
                less = now;
                less.lo[a] += (by + align - 1) / align * align;
                if (less.lo[a] < less.hi[a])
                    add(&list, &less);
            }
        status = try_all(j, &list, &found, err);
        if (!found)
            break;
    }
    return status;
}

/*
 * Removes the interval [a, b) from the ranges of `list` and stores the remaining ranges in *out. Returns false if they
 * exceed the capacity of *out.
 */
static bool without(const cut_list *list, uint32_t a, uint32_t b, cut_list *out)
{
    *out = (cut_list){.some = true};
    for (int i = 0; i < list->count; i++) {
        const uint32_t from = list->range[i][0], to = list->range[i][1],
                       parts[2][2] = {{from, to < a ? to : a}, {from > b ? from : b, to}};
        for (int p = 0; p < 2; p++) {
            if (parts[p][0] >= parts[p][1])
                continue;
            if (out->count == CUT_RANGES)
                return false;
            out->range[out->count][0] = parts[p][0];
            out->range[out->count++][1] = parts[p][1];
        }
    }
    return true;
}

/* Applies delta debugging to one list: divides the list into 2, 4, ... parts, and tries to retain only one part or to
   omit one part. `which` returns the address of this list in a cut. */
static ost_status cut_items(job *j, uint32_t count, cut_list *(*which)(scene_cut *cut, int tool), int tool,
                            ost_error *err)
{
    ost_status status = OST_OK;
    if (count < 2)
        return OST_OK;
    cut_list *list = which(&j->best->cut, tool);
    if (!list->some)
        *list = one_range(0, count);
    for (uint32_t parts = 2; status == OST_OK && j->best->runs < RUNS;) {
        const cut_list now = *which(&j->best->cut, tool);
        candidates tried = {.count = 0};
        const uint32_t lo = now.count ? now.range[0][0] : 0, hi = now.count ? now.range[now.count - 1][1] : 0,
                       step = (hi - lo + parts - 1) / parts;
        bool found = false;
        if (hi - lo < 2 || step == 0)
            break;
        /*
         * Candidates that retain only one part are tried first, because they are smaller than candidates that omit one
         * part.
         */
        for (uint32_t pass = 0; pass < 2; pass++)
            for (uint32_t from = lo; from < hi; from += step) {
                scene_cut cut = j->best->cut;
                const uint32_t to = hi - from < step ? hi : from + step;
                cut_list kept, head;
                bool fits = pass == 1 && without(&now, from, to, &kept);
                if (pass == 0)
                    fits = without(&now, 0, from, &head) && without(&head, to, UINT32_MAX, &kept);
                if (!fits || kept.count == 0 || tried.count == BATCH)
                    continue;
                *which(&cut, tool) = kept;
                add(&tried, &cut);
            }
        status = try_all(j, &tried, &found, err);
        if (!found && (step == 1 || parts >= 16))
            break;
        parts = found ? 2 : 2 * parts;
    }
    return status;
}

static cut_list *ticks_of(scene_cut *cut, int tool)
{
    (void)tool;
    return &cut->ticks;
}

static cut_list *samples_of(scene_cut *cut, int tool)
{
    (void)tool;
    return &cut->samples;
}

static cut_list *cutting_of(scene_cut *cut, int tool)
{
    return &cut->triangles[tool][0];
}

static cut_list *noncutting_of(scene_cut *cut, int tool)
{
    return &cut->triangles[tool][1];
}

static ost_status cut_all(job *j, const scene *s, const compare_difference *d, bool *done, ost_error *err)
{
    ost_status status = cut_stages(j, s, d, done, err);
    if (status != OST_OK || !*done)
        return status;
    if (j->best->ticks > 2)
        status = cut_items(j, (uint32_t)s->path.count, ticks_of, 0, err);
    if (status == OST_OK)
        status = cut_grid(j, s, err);
    if (status == OST_OK && !j->best->cut.no_ct && j->best->samples > 1 && j->stage != TRACE_TICK)
        status = cut_items(j, (uint32_t)s->sample_count, samples_of, 0, err);
    for (int t = 0; t < s->tool_count && status == OST_OK; t++)
        if (!(j->best->cut.no_tools >> t & 1)) {
            status = cut_items(j, (uint32_t)s->tools[t].noncutting.triangle_count, noncutting_of, t, err);
            if (status == OST_OK)
                status = cut_items(j, (uint32_t)s->tools[t].cutting.triangle_count, cutting_of, t, err);
        }
    return status;
}

ost_status minimise(const plan_case *c, const char *spec, const compare_difference *d, const finding *f,
                    const char *program, const char *folder, minimised *out, bool *done, ost_error *err)
{
    job j = {.c = c, .spec = spec, .program = program, .stage = d->stage, .class = f->class, .best = out};
    scene s;
    *out = (minimised){.runs = 0};
    *done = false;
    if (c->cut || d->kind == COMPARE_EQUAL)
        return OST_OK; /* A case from a case file is already small, so it is not reduced. */
    snprintf(j.cases, sizeof j.cases, "%s/cases.json", folder);
    snprintf(j.trace, sizeof j.trace, "%s/trace-small", folder);
    snprintf(j.ref, sizeof j.ref, "%s/trace-small-ref", folder);
    ost_status status = scene_make(c, &s, err);
    if (status != OST_OK)
        return status;
    status = cut_all(&j, &s, d, done, err);
    scene_free(&s);
    return status;
}

const char *minimised_text(const minimised *m, char text[MINIMISED_TEXT])
{
    char part[3][MINIMISED_TEXT / 3] = {"", "", ""}; /* each part has enough space for the greatest numbers */
    if (m->ticks)
        snprintf(part[0], sizeof part[0], "%llu tick%s", (unsigned long long)m->ticks, m->ticks == 1 ? "" : "s");
    if (m->tools)
        snprintf(part[1], sizeof part[1], "%s%d tool%s of %llu triangle%s", m->ticks ? ", " : "", m->tools,
                 m->tools == 1 ? "" : "s", (unsigned long long)m->triangles, m->triangles == 1 ? "" : "s");
    if (m->samples)
        snprintf(part[2], sizeof part[2], "%s%llu sample%s in %d x %d x %d voxels", m->tools ? ", " : "",
                 (unsigned long long)m->samples, m->samples == 1 ? "" : "s", m->rect.x, m->rect.y, m->rect.z);
    snprintf(text, MINIMISED_TEXT, "%s%s%s", part[0], part[1], part[2]);
    return text;
}
