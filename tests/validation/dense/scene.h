/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a scene through every stage (samples, rect grid, cubic grid, bone, a tool from meshes, and
 * events) and stores all results of a backend.
 *
 * The scenes are made so that every mistake of validation/dense can have an effect: densities at
 * the threshold and at the borders of classes, duplicates, voxels without a sample, vertices on
 * voxel centres, open meshes, meshes within meshes, poses within a rounding error of the borders of
 * tool voxels, sweeps, and distant tools.
 */
#ifndef OST_TESTS_VALIDATION_SCENE_H
#define OST_TESTS_VALIDATION_SCENE_H

#include "ref/scene.h"

enum { EVENTS = 4, POSES = 8, LATTICE = 1024 };

typedef struct scene {
    /* the inputs of the import */
    ost_geometry rect;
    ost_sample *samples;
    size_t count, first_batch; /* the second batch begins at sample first_batch */
    int64_t first_line;
    ost_duplicates duplicates;
    ost_pm cubic;
    ost_resample rule;
    int chunk_size;
    /* the meshes of one tool, and another tool with random classes */
    ost_snapped_mesh cutting, noncutting;
    bool two_meshes;
    ost_fill_rule fill;
    ost_tool_volume given;
    /* the events, in order */
    struct {
        ost_pose poses[POSES];
        int count;
        bool given, collide;
    } events[EVENTS];
} scene;

/* -------------------------------------------------------- making a scene */

/* The densities of a scene: varied, all equal, or 0 in nearly all voxels. If they are UNIFORM or EMPTY, many mistakes
   have no effect. */
typedef enum flavour { VARIED, UNIFORM, EMPTY } flavour;

static inline int16_t scene_density(test_rng *rng, flavour f)
{
    if (f == UNIFORM)
        return 5001;
    if (f == EMPTY)
        return rng_range(rng, 0, 3000) ? 0 : 700;
    static const int16_t borders[] = {119, 120, 121, 149, 150, 649, 650, 651};
    switch (rng_range(rng, 0, 4)) {
    case 0: return borders[rng_range(rng, 0, 7)];
    case 1: return (int16_t)rng_range(rng, -1200, 119);
    case 2: return (int16_t)rng_range(rng, 2000, 6000);
    default: return (int16_t)rng_range(rng, 120, 3000);
    }
}

static inline void make_samples(scene *s, test_rng *rng, flavour f)
{
    static const ost_pm spacings[] = {470 * UM, 300 * UM, 488281250, 1000 * UM, 32 * UM * 10, 700 * UM};
    const ost_pm across = spacings[rng_range(rng, 0, 5)];
    s->rect = (ost_geometry){
        .dims = {(int32_t)rng_range(rng, 15, 45), (int32_t)rng_range(rng, 15, 45), (int32_t)rng_range(rng, 12, 30)},
        .spacing = {across, across, rng_range(rng, 0, 2) ? spacings[rng_range(rng, 0, 5)] : across},
        .origin = {rng_range(rng, 0, 1) ? 0 : -122 * across, rng_range(rng, -9, 9) * across,
                   rng_range(rng, 0, 1) ? 0 : 7 * UM},
    };
    const int64_t voxels = ost_dims_count(s->rect.dims);
    s->samples = malloc((size_t)(2 * voxels) * sizeof *s->samples);
    assert_non_null(s->samples);
    const bool offsets = rng_range(rng, 0, 1), sparse = f == VARIED && rng_range(rng, 0, 1);
    for (int64_t v = 0; v < voxels; v++)
        for (int again = 0; again < 2; again++) {
            if (again ? rng_range(rng, 0, 9) != 0 : sparse && rng_range(rng, 0, 7) == 0)
                continue;
            const ost_dims d = s->rect.dims;
            const int64_t jitter = offsets ? rng_range(rng, 0, 40) == 0 ? across / 5 : across / 100 : 0;
            s->samples[s->count] = (ost_sample){
                .x = s->rect.origin.x + v % d.x * across + (jitter ? rng_range(rng, -jitter, jitter) : 0),
                .y = s->rect.origin.y + v / d.x % d.y * across + (jitter ? rng_range(rng, -jitter, jitter) : 0),
                .z = s->rect.origin.z + v / d.x / d.y * s->rect.spacing.z,
                .density = scene_density(rng, f),
                .line = (uint32_t)s->count,
            };
            s->count++;
        }
    s->first_batch = (size_t)rng_range(rng, 1, (int64_t)s->count - 1);
    s->first_line = rng_range(rng, 1, 9);
    s->duplicates = (ost_duplicates)rng_range(rng, OST_DUPLICATES_FIRST, OST_DUPLICATES_MAX);
    if (rng_range(rng, 0, 5) == 0)
        s->duplicates = OST_DUPLICATES_ERROR;
    s->cubic = rng_range(rng, 0, 3) ? across : rng_range(rng, 280, 700) * UM;
    s->rule = (ost_resample)rng_range(rng, OST_RESAMPLE_LINEAR, OST_RESAMPLE_THESIS);
    s->chunk_size = 16 << rng_range(rng, 0, 2);
}

static inline int32_t scene_coordinate(test_rng *rng, int32_t n)
{
    switch (rng_range(rng, 0, 2)) {
    case 0: return (int32_t)(rng_range(rng, 0, n - 1) * LATTICE + LATTICE / 2);
    case 1: return (int32_t)(rng_range(rng, 0, n) * LATTICE);
    default: return (int32_t)rng_range(rng, 0, (int64_t)n * LATTICE);
    }
}

static inline void add_vertex(ost_snapped_mesh *m, int32_t x, int32_t y, int32_t z)
{
    const int32_t v[3] = {x, y, z};
    memcpy(m->vertices[m->vertex_count++], v, sizeof v);
}

static inline void add_triangle(ost_snapped_mesh *m, size_t a, size_t b, size_t c)
{
    uint32_t *t = m->triangles[m->triangle_count++];
    t[0] = (uint32_t)a;
    t[1] = (uint32_t)b;
    t[2] = (uint32_t)c;
}

/*
 * Sets *lo and *hi to limits at the same odd distance from the centre of the middle voxel. A diagonal of a
 * box with such limits passes exactly through this centre.
 */
static inline void about_centre(test_rng *rng, int32_t n, int32_t *lo, int32_t *hi)
{
    const int32_t middle = (n / 2) * LATTICE + LATTICE / 2,
                  margin = middle < n * LATTICE - middle ? middle : n * LATTICE - middle;
    const int32_t half = (int32_t)rng_range(rng, margin / 2, margin - 1) | 1;
    *lo = middle - half;
    *hi = middle + half;
}

/* Adds a box or a tetrahedron of random orientation to m. If `leaks` is true, one face is missing. */
static inline void add_body(ost_snapped_mesh *m, test_rng *rng, bool leaks)
{
    static const uint8_t faces[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                                         {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    const size_t first = m->vertex_count;
    const ost_dims d = m->grid.dims;
    if (rng_range(rng, 0, 1)) {
        int32_t lo[3], hi[3];
        const bool centred = rng_range(rng, 0, 2) == 0;
        for (int a = 0; a < 3; a++) {
            const int32_t n = a == 0 ? d.x : a == 1 ? d.y : d.z;
            if (centred) {
                about_centre(rng, n, &lo[a], &hi[a]);
                continue;
            }
            do {
                lo[a] = scene_coordinate(rng, n);
                hi[a] = scene_coordinate(rng, n);
            } while (hi[a] - lo[a] < LATTICE);
        }
        for (int c = 0; c < 8; c++)
            add_vertex(m, c & 1 ? hi[0] : lo[0], c & 2 ? hi[1] : lo[1], c & 4 ? hi[2] : lo[2]);
        for (int f = leaks ? 1 : 0; f < 12; f++)
            add_triangle(m, first + faces[f][0], first + faces[f][1], first + faces[f][2]);
    } else {
        for (int v = 0; v < 4; v++)
            add_vertex(m, scene_coordinate(rng, d.x), scene_coordinate(rng, d.y), scene_coordinate(rng, d.z));
        add_triangle(m, first, first + 1, first + 2);
        add_triangle(m, first, first + 3, first + 1);
        add_triangle(m, first + 1, first + 3, first + 2);
        if (!leaks)
            add_triangle(m, first, first + 2, first + 3);
    }
}

static inline ost_snapped_mesh make_mesh(test_rng *rng, const ost_tool_geometry *grid)
{
    enum { BODIES = 9 };
    ost_snapped_mesh m = {.grid = *grid, .fraction_bits = 10};
    const int bodies = (int)rng_range(rng, 1, BODIES);
    m.vertices = malloc(8 * BODIES * sizeof *m.vertices);
    m.triangles = malloc(12 * BODIES * sizeof *m.triangles);
    assert_true(m.vertices && m.triangles);
    for (int b = 0; b < bodies; b++)
        add_body(&m, rng, rng_range(rng, 0, 9) == 0);
    return m;
}

static inline void make_tools(scene *s, test_rng *rng)
{
    ost_error err = {0};
    const ost_pm voxels[] = {s->cubic, s->cubic / 2, 500 * UM, s->cubic / 10, s->cubic / 15};
    const ost_pm voxel = voxels[rng_range(rng, 0, 4)];
    const bool wide = rng_range(rng, 0, 2) == 0;
    const int32_t least = wide ? 60 : 4, most = wide ? 80 : 30;
    ost_tool_geometry g = {
        {(int32_t)rng_range(rng, 4, 24), (int32_t)rng_range(rng, least, most), (int32_t)rng_range(rng, least, most)},
        voxel,
        {0}};
    g.corner = (ost_pm3){-(g.dims.x / 2) * voxel, -(g.dims.y / 2) * voxel, -(g.dims.z / 2) * voxel};
    s->cutting = make_mesh(rng, &g);
    s->two_meshes = rng_range(rng, 0, 1);
    s->noncutting = make_mesh(rng, &g);
    s->fill = (ost_fill_rule)rng_range(rng, 0, 1);

    const ost_pm own = voxels[rng_range(rng, 0, 4)];
    const int32_t size = (int32_t)(own < s->cubic / 4 ? rng_range(rng, 30, 90) : rng_range(rng, 3, 70));
    g = (ost_tool_geometry){
        {size, size, (int32_t)rng_range(rng, 3, size)}, own, {-(size / 2) * own, -(size / 2) * own, 0}};
    const bool solid = rng_range(rng, 0, 2) == 0;
    assert_ok(ost_tool_volume_init(&s->given, &g, &err));
    for (int64_t v = 0; v < ost_dims_count(g.dims); v++) {
        const int64_t r = solid ? 0 : rng_range(rng, 0, 9);
        s->given.voxels[v] = r < 6 ? OST_TOOL_CUTTING : r < 8 ? OST_TOOL_NONCUTTING : OST_TOOL_VOID;
    }
}

static inline ost_geometry cubic_of(const scene *s)
{
    const ost_geometry *r = &s->rect;
    const ost_pm c = s->cubic;
    return (ost_geometry){
        .dims = {(int32_t)((r->dims.x * r->spacing.x + c - 1) / c), (int32_t)((r->dims.y * r->spacing.y + c - 1) / c),
                 (int32_t)((r->dims.z * r->spacing.z + c - 1) / c)},
        .spacing = {c, c, c},
        .origin = r->origin,
    };
}

/*
 * Returns a random pose in the bone. For some poses, the borders of tool voxels coincide with borders of
 * bone voxels to within a few nanometres.
 */
static inline ost_pose scene_pose(const scene *s, test_rng *rng, ost_pm voxel)
{
    const ost_geometry g = cubic_of(s);
    const ost_pm3 lo = g.origin,
                  hi = {lo.x + g.dims.x * s->cubic, lo.y + g.dims.y * s->cubic, lo.z + g.dims.z * s->cubic};
    ost_pose pose = random_pose(rng, lo, hi);
    const int64_t mode = rng_range(rng, 0, 6);
    if (mode < 3)
        return pose;
    ost_pm *t[3] = {&pose.t.x, &pose.t.y, &pose.t.z};
    const ost_pm o[3] = {lo.x, lo.y, lo.z};
    for (int a = 0; a < 3; a++)
        *t[a] = o[a] + (*t[a] - o[a]) / voxel * voxel + rng_range(rng, -3, 3) * rng_range(rng, 0, 1000);
    pose.qw = OST_Q30_ONE;
    pose.qx = pose.qy = pose.qz = 0;
    if (mode == 4) {
        pose.qw = 759250125;
        pose.qz = rng_range(rng, 0, 1) ? 759250125 : -759250125;
    }
    if (mode == 5)
        *t[rng_range(rng, 0, 2)] += (rng_range(rng, 0, 1) ? 4096 : -4096) * voxel;
    return pose;
}

static inline void make_events(scene *s, test_rng *rng)
{
    const ost_pm step = s->cubic;
    for (int e = 0; e < EVENTS; e++) {
        s->events[e].given = rng_range(rng, 0, 2) > 0;
        s->events[e].collide = rng_range(rng, 0, 5) == 0;
        const ost_tool_geometry *g = s->events[e].given ? &s->given.geometry : &s->cutting.grid;
        ost_pose to = scene_pose(s, rng, g->voxel), from = to;
        if (e > 0 && rng_range(rng, 0, 2) == 0) { /* the event begins at the last pose of the previous one */
            from = s->events[e - 1].poses[s->events[e - 1].count - 1];
            to = from;
        }
        s->events[e].count = 1;
        s->events[e].poses[0] = to;
        if (rng_range(rng, 0, 3) == 0)
            continue;
        int n;
        to.t.x += rng_range(rng, -2 * step, 2 * step);
        to.t.y += rng_range(rng, -step, step);
        to.qz += (int32_t)rng_range(rng, -1000000, 1000000);
        if (ost_pose_check(&to, NULL) != OST_OK || ost_sweep_count(&from, &to, g, s->cubic, &n, NULL) != OST_OK ||
            n > POSES)
            continue;
        s->events[e].count = n;
        for (int k = 1; k <= n; k++)
            s->events[e].poses[k - 1] = ost_sweep_pose(&from, &to, k, n);
    }
}

static inline scene *make_scene(test_rng *rng, flavour f)
{
    scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    make_samples(s, rng, f);
    make_tools(s, rng);
    make_events(s, rng);
    return s;
}

static inline void free_scene(scene *s)
{
    free(s->samples);
    ost_snapped_mesh_free(&s->cutting);
    ost_snapped_mesh_free(&s->noncutting);
    ost_tool_volume_free(&s->given);
    free(s);
}

/* ------------------------------------------------------- running a scene */

typedef struct outcome {
    int16_t *rect, *cubic, *chunks, *after[EVENTS];
    ost_scatter_report scatter;
    ost_bone_info info[2]; /* info[0] before the events, info[1] after the events */
    ost_digest root;
    ost_tool_volume tool;
    ost_voxelize_report voxelize;
    ost_removal_report reports[EVENTS];
} outcome;

static inline int16_t *all_of(const ost_grid *grid)
{
    ost_error err = {0};
    const ost_geometry *g = ost_grid_geometry(grid);
    int16_t *voxels = malloc(voxel_count(g) * sizeof *voxels);
    assert_non_null(voxels);
    assert_ok(ost_grid_download(grid, 0, g->dims.z, voxels, &err));
    return voxels;
}

/* Runs the scene on a backend. A chunk_size greater than 0 replaces the scene's chunk size. */
static inline outcome *run_scene(const scene *s, ost_backend *backend, int chunk_size)
{
    ost_error err = {0};
    outcome *o = calloc(1, sizeof *o);
    ost_grid *rect, *cubic;
    ost_bone *bone;
    ost_tool *tools[2];
    assert_non_null(o);

    assert_ok(ost_grid_create(backend, &s->rect, &rect, &err));
    assert_ok(ost_ct_to_rect(rect, s->samples, s->first_batch, s->first_line, s->duplicates, &o->scatter, &err));
    assert_ok(ost_ct_to_rect(rect, s->samples + s->first_batch, s->count - s->first_batch, s->first_line, s->duplicates,
                             &o->scatter, &err));
    o->rect = all_of(rect);
    assert_ok(ost_rect_to_cubic(rect, s->cubic, s->rule, &cubic, &err));
    o->cubic = all_of(cubic);
    assert_ok(ost_cubic_to_chunks(cubic, chunk_size ? chunk_size : s->chunk_size, 120, &bone, &err));
    const ost_geometry g = *ost_grid_geometry(cubic);
    o->chunks = content(bone, &g);
    assert_ok(ost_bone_info_get(bone, &o->info[0], &err));

    assert_ok(ost_voxelize(backend, &s->cutting, s->two_meshes ? &s->noncutting : NULL, s->fill, &o->voxelize,
                           &tools[0], &err));
    assert_ok(ost_tool_download(tools[0], &o->tool, &err));
    assert_ok(ost_tool_upload(backend, &s->given, &tools[1], &err));
    scene_event *event = malloc(sizeof *event);
    assert_non_null(event);
    for (int e = 0; e < EVENTS; e++) {
        const ost_tool *tool = tools[s->events[e].given];
        event_of(event, &g, tool, s->events[e].poses, s->events[e].count);
        if (s->events[e].collide)
            assert_ok(ost_bone_collide(bone, tool, &event->event, &o->reports[e], &err));
        else
            assert_ok(ost_bone_remove(bone, tool, &event->event, &o->reports[e], &err));
        o->after[e] = content(bone, &g);
    }
    assert_ok(ost_bone_info_get(bone, &o->info[1], &err));
    o->root = digest_of(bone);
    free(event);
    ost_tool_free(tools[0]);
    ost_tool_free(tools[1]);
    ost_bone_free(bone);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return o;
}

static inline void free_outcome(outcome *o)
{
    free(o->rect);
    free(o->cubic);
    free(o->chunks);
    ost_tool_volume_free(&o->tool);
    for (int e = 0; e < EVENTS; e++) {
        free(o->after[e]);
        ost_removal_report_free(&o->reports[e]);
    }
    free(o);
}

#endif
