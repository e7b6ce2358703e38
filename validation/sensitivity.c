/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/sensitivity.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "validation/compare.h"
#include "validation/dense/dense.h"
#include "validation/draw.h"
#include "validation/locate/finding.h"
#include "validation/perform.h"
#include "validation/scratch.h"

enum { PER_SCENE = 16, AGAIN = 4, THREADS = 63 };

uint64_t sensitivity_injections(plan_tier tier)
{
    static const uint64_t counts[PLAN_TIERS] = {DEVIATION_KINDS - 1, 4000, 20000};
    return counts[tier];
}

/* The record that was being computed when the mistake first changed a result. */
typedef struct witness {
    ost_backend *backend;
    bool seen;
    trace_stage stage;
    uint32_t item;
    deviation_record record; /* state of the mistake after this record */
} witness;

static void watch(void *user, trace_stage stage, uint32_t item)
{
    witness *w = user;
    /*
     * These stages are skipped: a backend computes neither snapped meshes nor steps, and the steps of an event are
     * recorded only after the event.
     */
    if (w->seen || stage == TRACE_SNAP ||
        stage == TRACE_STEPS)
        return;
    w->record = dense_record(w->backend);
    if (w->record.changed) {
        w->seen = true;
        w->stage = stage;
        w->item = item;
    }
}

static ost_status run_one(ost_backend *backend, const scene *s, const char *path, perform_watch *watcher, void *user,
                          trace *out, ost_error *err)
{
    trace_writer *w;
    ost_error why;
    ost_status status = trace_create(path, &w, err);
    if (status != OST_OK)
        return status;
    status = perform(backend, s, 0, w, watcher, user, &why, err);
    if (status == OST_OK) {
        trace_begin(w, TRACE_END, 1, 0);
        status = trace_end(w, err);
    }
    ost_status closed = trace_close(w, err);
    status = status != OST_OK ? status : closed;
    return status == OST_OK ? trace_open(path, out, err) : status;
}

/*
 * Returns true if the comparison named the position that the mistake changed first. A bone that is
 * uploaded in parts has only one record, and a later part may overwrite the voxel that changed
 * first. For such a bone the stage and the item of the record are sufficient.
 */
static bool is_located(const witness *w, const compare_difference *d)
{
    if (!w->seen || d->stage != w->stage || d->item != w->item)
        return false;
    if (d->stage == TRACE_UPLOAD)
        return true;
    const deviation_position *first = &w->record.first_changed;
    if (d->kind == COMPARE_VOXEL)
        return memcmp(d->voxel, first->voxel, sizeof d->voxel) == 0;
    if (d->kind == COMPARE_WORD)
        return first->voxel[0] < 0 && (first->chunk < 0 || first->chunk == d->chunk);
    return true; /* the numbers of words or blocks differ, so only the stage and the item can be compared */
}

static void judge(sensitivity *out, const deviation *how, const plan_case *c, const witness *w,
                  const deviation_record *record, const compare_difference *d)
{
    sensitivity_counts *counts[2] = {&out->all, &out->of[how->kind]};
    const bool detected = d->kind != COMPARE_EQUAL, located = detected && is_located(w, d);
    for (int i = 0; i < 2; i++) {
        sensitivity_counts *n = counts[i];
        n->injected++;
        n->triggered += record->acted > 0;
        n->changed += record->changed > 0;
        n->detected += detected;
        n->located += located;
        n->survived += record->acted > 0 && !record->changed;
        n->not_detected += record->changed && !detected;
        n->not_located += record->changed && detected && !located;
    }
    const bool alarm = detected && !record->changed;
    out->false_alarms += alarm;
    if ((alarm || (record->changed && !located)) && !out->first_problem[0])
        snprintf(out->first_problem, sizeof out->first_problem,
                 "%s in %s (campaign seed %llu, its seed %llu, one in %u): %s; first changed: %s call %llu voxel "
                 "%d,%d,%d chunk %lld at %s %u; found: %s %u voxel "
                 "%d,%d,%d word %zu chunk %lld",
                 deviation_describe(how->kind)->name, c->id, (unsigned long long)c->seed, (unsigned long long)how->seed,
                 how->one_in,
                 alarm       ? "an alarm without a change"
                 : !detected ? "not detected"
                             : "not located",
                 deviation_stage_name(w->record.first_changed.stage), (unsigned long long)w->record.first_changed.call,
                 w->record.first_changed.voxel[0], w->record.first_changed.voxel[1], w->record.first_changed.voxel[2],
                 (long long)w->record.first_changed.chunk, w->seen ? trace_stage_name(w->stage) : "nothing", w->item,
                 detected ? trace_stage_name(d->stage) : "nothing", d->item, d->voxel[0], d->voxel[1], d->voxel[2],
                 d->word, (long long)d->chunk);
}

/* Runs the dense backend without a mistake. A difference from the reference is a false alarm. */
static ost_status run_clean(const scene *s, const plan_case *c, const char *path, const trace *ref,
                            compare_range in_ref, sensitivity *out, ost_error *err)
{
    ost_backend *backend;
    trace got = {0};
    compare_difference d;
    ost_status status = dense_open(NULL, &backend, err);
    if (status != OST_OK)
        return status;
    status = run_one(backend, s, path, NULL, NULL, &got, err);
    ost_backend_close(backend);
    if (status != OST_OK)
        return status;
    compare_case(ref, in_ref, &got, compare_find(&got, 0), &d);
    out->clean_runs++;
    if (d.kind != COMPARE_EQUAL) {
        out->false_alarms++;
        if (!out->first_problem[0])
            snprintf(out->first_problem, sizeof out->first_problem,
                     "a clean run of %s (seed %llu) differs: %s %u voxel %d,%d,%d word %zu", c->id,
                     (unsigned long long)c->seed, trace_stage_name(d.stage), d.item, d.voxel[0], d.voxel[1], d.voxel[2],
                     d.word);
    }
    trace_free(&got);
    return OST_OK;
}

const char *sensitivity_class_name(int class)
{
    return class < PATTERNS ? ost_pattern_name((pattern)class) : class == PATTERNS ? "report-only" : "none";
}

static void classify(const deviation *how, const scene *s, const trace *ref, compare_range in_ref, const trace *got,
                     const compare_difference *d, sensitivity *out)
{
    finding f;
    if (d->kind == COMPARE_EQUAL)
        return;
    finding_make(s, ref, in_ref, got, compare_find(got, 0), d, &f);
    int class = 0;
    while (class < SENSITIVITY_CLASSES - 1 && (!f.class || strcmp(f.class, sensitivity_class_name(class)) != 0))
        class++;
    out->classes[how->kind][class]++;
}

static ost_status inject(const deviation *how, const scene *s, const plan_case *c, const char *path, const trace *ref,
                         compare_range in_ref, sensitivity *out, ost_error *err)
{
    witness w = {0};
    trace got = {0};
    compare_difference d;
    ost_status status = dense_open(how, &w.backend, err);
    if (status != OST_OK)
        return status;
    status = run_one(w.backend, s, path, watch, &w, &got, err);
    const deviation_record record = dense_record(w.backend);
    ost_backend_close(w.backend);
    if (status != OST_OK)
        return status;
    compare_case(ref, in_ref, &got, compare_find(&got, 0), &d);
    judge(out, how, c, &w, &record, &d);
    classify(how, s, ref, in_ref, &got, &d, out);
    trace_free(&got);
    return OST_OK;
}

/* Draws the rate of a mistake: on average the mistake is made in one of 2^k units. Even at the lowest rate, a few
   scenes have enough units for at least one mistake, so that most injections are triggered. */
static uint32_t drawn_rate(draw *d, deviation_kind kind)
{
    static const struct {
        const char *unit;
        int bits;
    } most[] = {{"sample", 11}, {"voxel", 11}, {"triangle", 4}, {"row", 5},  {"chunk", 3},
                {"block", 3},   {"pose", 2},   {"layer", 4},    {"batch", 1}};
    int bits = 0;
    for (size_t i = 0; i < sizeof most / sizeof most[0]; i++)
        if (strcmp(deviation_describe(kind)->unit, most[i].unit) == 0)
            bits = most[i].bits;
    return (uint32_t)1 << draw_between(d, 0, bits);
}

/* The mistakes to make in one scene. */
typedef struct share {
    /* The mistakes of a pass are numbered, and every kind occurs equally often. In this scene, `count` mistakes
       are made, beginning with number `first`. */
    uint64_t first, count;
    /* if not NULL, each of these kinds of mistakes is made once, and the range of numbers is ignored */
    const deviation_kind *kinds;
    /* true if the mistakes are made in every unit; false if they are made at a random rate */
    bool everywhere;
} share;

/* The scratch files and results of one thread of the proof. */
typedef struct bench {
    int files[2]; /* file descriptors of the reference's trace and of the compared trace */
    char names[2][SCRATCH_NAME];
    sensitivity found;
} bench;

static deviation drawn_mistake(draw *d, const share *of, uint64_t i)
{
    deviation how = {.kind = of->kinds
                                 ? of->kinds[i]
                                 : (deviation_kind)(DEVIATION_NONE + 1 + (of->first + i) % (DEVIATION_KINDS - 1))};
    how.seed = draw_bits(d);
    how.one_in = drawn_rate(d, how.kind);
    if (of->everywhere)
        how.one_in = 1;
    return how;
}

/* Runs a scene once without a mistake, and then with each of its mistakes. All random values depend only on the scene's
   number, so the result does not depend on the thread. */
static ost_status run_scene(bench *b, int number, const share *of, ost_error *err)
{
    plan_case c = {.family = PLAN_SMALL, .number = number, .seed = b->found.seed};
    char name[PLAN_ID + 16];
    scene s;
    ost_backend *ref_backend;
    trace ref = {0};
    snprintf(c.id, sizeof c.id, "small/%d", number);
    snprintf(name, sizeof name, "sensitivity/%d", number);
    draw d = draw_named(c.seed, name);
    ost_status status = scene_make(&c, &s, err);
    if (status != OST_OK)
        return status;
    status = ost_backend_open("ref", &ref_backend, err);
    if (status == OST_OK) {
        status = run_one(ref_backend, &s, b->names[0], NULL, NULL, &ref, err);
        ost_backend_close(ref_backend);
    }
    if (status == OST_OK) {
        const compare_range in_ref = compare_find(&ref, 0);
        status = run_clean(&s, &c, b->names[1], &ref, in_ref, &b->found, err);
        for (uint64_t i = 0; i < of->count && status == OST_OK; i++) {
            const deviation how = drawn_mistake(&d, of, i);
            status = inject(&how, &s, &c, b->names[1], &ref, in_ref, &b->found, err);
        }
    }
    trace_free(&ref);
    scene_free(&s);
    return status;
}

static void add_counts(sensitivity_counts *to, const sensitivity_counts *n)
{
    to->injected += n->injected;
    to->triggered += n->triggered;
    to->changed += n->changed;
    to->detected += n->detected;
    to->located += n->located;
    to->survived += n->survived;
    to->not_detected += n->not_detected;
    to->not_located += n->not_located;
}

/* The state of one pass, shared by its threads. A thread that is free takes the next scene. */
typedef struct proof {
    sensitivity *out;
    uint64_t injections;
    deviation_kind kinds[DEVIATION_KINDS]; /* the kinds of mistakes of the second pass */
    uint64_t kind_count;                   /* number of these kinds; 0 in the first pass */
    int end;                               /* number of the pass's last scene, plus 1 */
    void (*show)(void *user, const char *what, double share);
    void *user;
    pthread_mutex_t lock; /* protects the following members and *out */
    int next;             /* number of the next scene to run */
    int problem_at;       /* number of the scene with the problem in out->first_problem, or -1 */
    ost_error err;
} proof;

static void take_over(proof *p, const sensitivity *found, int number)
{
    add_counts(&p->out->all, &found->all);
    for (int k = 0; k < DEVIATION_KINDS; k++) {
        add_counts(&p->out->of[k], &found->of[k]);
        for (int c = 0; c < SENSITIVITY_CLASSES; c++)
            p->out->classes[k][c] += found->classes[k][c];
    }
    p->out->clean_runs += found->clean_runs;
    p->out->false_alarms += found->false_alarms;
    if (found->first_problem[0] && (p->problem_at < 0 || number < p->problem_at)) {
        memcpy(p->out->first_problem, found->first_problem, sizeof found->first_problem);
        p->problem_at = number;
    }
}

static ost_status bench_open(bench *b, ost_error *err)
{
    ost_status status = OST_OK;
    *b = (bench){.files = {-1, -1}};
    for (int f = 0; f < 2 && status == OST_OK; f++) {
        status = scratch_file(&b->files[f], err);
        scratch_name(b->files[f], b->names[f]);
    }
    return status;
}

static void bench_close(const bench *b)
{
    for (int f = 0; f < 2; f++)
        if (b->files[f] >= 0)
            close(b->files[f]);
}

/* Returns the mistakes to make in a scene of this pass. */
static share share_of(const proof *p, int number)
{
    const uint64_t first = (uint64_t)number * PER_SCENE, left = p->injections > first ? p->injections - first : 0;
    if (p->kind_count)
        return (share){.count = p->kind_count, .kinds = p->kinds, .everywhere = true};
    return (share){
        .first = first, .count = left < PER_SCENE ? left : PER_SCENE, .everywhere = p->injections < DEVIATION_KINDS};
}

static void *work(void *user)
{
    proof *p = user;
    bench b;
    ost_error err = {0};
    ost_status status = bench_open(&b, &err);
    pthread_mutex_lock(&p->lock);
    while (status == OST_OK && p->err.status == OST_OK && p->next < p->end) {
        const int number = p->next++;
        const share of = share_of(p, number);
        if (p->show)
            p->show(p->user, "sensitivity", (double)number / (double)p->end);
        pthread_mutex_unlock(&p->lock);
        b.found = (sensitivity){.seed = p->out->seed};
        status = run_scene(&b, number, &of, &err);
        pthread_mutex_lock(&p->lock);
        take_over(p, &b.found, number);
    }
    if (status != OST_OK && p->err.status == OST_OK)
        p->err = err;
    pthread_mutex_unlock(&p->lock);
    bench_close(&b);
    return NULL;
}

static void run_pass(proof *p, int jobs)
{
    pthread_t others[THREADS];
    int started = 0;
    while (started < THREADS && started < jobs - 1 && pthread_create(&others[started], NULL, work, p) == 0)
        started++;
    work(p);
    for (int i = 0; i < started; i++)
        pthread_join(others[i], NULL);
}

ost_status sensitivity_run(uint64_t seed, uint64_t injections, int jobs,
                           void (*show)(void *user, const char *what, double share), void *user, sensitivity *out,
                           ost_error *err)
{
    proof p = {.out = out,
               .injections = injections,
               .show = show,
               .user = user,
               .lock = PTHREAD_MUTEX_INITIALIZER,
               .problem_at = -1,
               .end = (int)((injections + PER_SCENE - 1) / PER_SCENE)};
    *out = (sensitivity){.seed = seed};
    run_pass(&p, jobs);
    /* If the run has at least as many injections as there are kinds of mistakes, each kind that changed no result is
       made in every unit of a few more scenes. */
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS && injections >= DEVIATION_KINDS - 1; k++)
        if (!out->of[k].changed)
            p.kinds[p.kind_count++] = (deviation_kind)k;
    if (p.kind_count && p.err.status == OST_OK) {
        p.end += AGAIN;
        run_pass(&p, jobs);
    }
    pthread_mutex_destroy(&p.lock);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++) {
        const sensitivity_counts *n = &out->of[k];
        out->kinds_changed += n->changed > 0;
        out->kinds_noticed += n->changed > 0 && !n->not_detected && !n->not_located;
    }
    if (p.err.status != OST_OK)
        *err = p.err;
    return p.err.status;
}
