/* SPDX-License-Identifier: Apache-2.0 */
/* Checks the laws of docs/spec/arithmetic.md (AR-LAW). A law states that two computations give the same voxels. The
   bones, tools and poses are random. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/common/lab.h"

enum { SIDE = 36, COUNT = SIDE * SIDE * SIDE, ROUNDS = 5, POSES = 3 };

typedef struct scene {
    ost_geometry g;
    int16_t *before, *a, *b;
    ost_tool *tool;
    ost_pose poses[POSES];
} scene;

static void make(lab *l, draw *d, scene *s)
{
    s->g = lab_cube(SIDE, SIDE, SIDE, LAB_MM);
    s->before = malloc(3 * COUNT * sizeof *s->before);
    s->tool = NULL;
    if (!s->before) {
        if (l->status == OST_OK)
            l->status = ost_fail(l->err, OST_ERR_MEMORY, "out of memory for a bone");
        return;
    }
    s->a = s->before + COUNT;
    s->b = s->a + COUNT;
    lab_fill(d, s->before, COUNT);
    memcpy(s->a, s->before, COUNT * sizeof *s->a);
    memcpy(s->b, s->before, COUNT * sizeof *s->b);
    s->tool = lab_random_tool(l, d, (ost_dims){24, 20, 16}, LAB_MM / 2,
                              (ost_pm3){-6 * LAB_MM, -5 * LAB_MM, -4 * LAB_MM});
    for (int k = 0; k < POSES; k++)
        s->poses[k] = lab_random_pose(l, d, SIDE * LAB_MM);
}

static void end(scene *s)
{
    ost_tool_free(s->tool);
    free(s->before);
}

static int64_t differ(const int16_t *a, const int16_t *b)
{
    int64_t n = 0;
    for (int i = 0; i < COUNT; i++)
        n += a[i] != b[i];
    return n;
}

typedef struct law {
    const char *name, *requirements, *what;
    /* computes a result in two ways and stores it in s->a and s->b, which must then be equal */
    void (*two_ways)(lab *l, draw *d, scene *s);
} law;

static void chunk_sizes(lab *l, draw *d, scene *s)
{
    lab_remove(l, &s->g, 16, s->a, s->tool, s->poses, POSES, NULL);
    lab_remove(l, &s->g, draw_one_in(d, 2) ? 32 : 64, s->b, s->tool, s->poses, POSES, NULL);
}

static void twice(lab *l, draw *d, scene *s)
{
    (void)d;
    lab_remove(l, &s->g, 32, s->a, s->tool, s->poses, POSES, NULL);
    lab_remove(l, &s->g, 32, s->b, s->tool, s->poses, POSES, NULL);
    lab_remove(l, &s->g, 32, s->b, s->tool, s->poses, POSES, NULL);
}

static void order(lab *l, draw *d, scene *s)
{
    (void)d;
    for (int k = 0; k < POSES; k++)
        lab_remove(l, &s->g, 32, s->a, s->tool, &s->poses[k], 1, NULL);
    for (int k = POSES - 1; k >= 0; k--)
        lab_remove(l, &s->g, 32, s->b, s->tool, &s->poses[k], 1, NULL);
}

static void one_by_one(lab *l, draw *d, scene *s)
{
    (void)d;
    lab_remove(l, &s->g, 32, s->a, s->tool, s->poses, POSES, NULL);
    for (int k = 0; k < POSES; k++)
        lab_remove(l, &s->g, 32, s->b, s->tool, &s->poses[k], 1, NULL);
}

/* Moves the bone and the tool by the same vector in picometres. The indices of the removed voxels must not change. */
static void moved(lab *l, draw *d, scene *s)
{
    const ost_pm3 by = draw_point(d, -LAB_MM * 99, LAB_MM * 99);
    lab_remove(l, &s->g, 32, s->a, s->tool, s->poses, POSES, NULL);
    s->g.origin = by;
    for (int k = 0; k < POSES; k++)
        s->poses[k].t = (ost_pm3){s->poses[k].t.x + by.x, s->poses[k].t.y + by.y, s->poses[k].t.z + by.z};
    lab_remove(l, &s->g, 32, s->b, s->tool, s->poses, POSES, NULL);
}

/* Moves the tool by a whole number of voxels in its own frame, and the pose by the same distance in the opposite
   direction. The pose has no rotation. */
static void shifted(lab *l, draw *d, scene *s)
{
    ost_tool_volume v = {.voxels = NULL};
    ost_tool *other = NULL;
    const ost_pm3 n = draw_point(d, -9, 9), by = {n.x * (LAB_MM / 2), n.y * (LAB_MM / 2), n.z * (LAB_MM / 2)};
    ost_pose pose = ost_pose_identity();
    pose.t = s->poses[0].t;
    lab_remove(l, &s->g, 32, s->a, s->tool, &pose, 1, NULL);
    if (l->status == OST_OK)
        l->status = ost_tool_download(s->tool, &v, l->err);
    v.geometry.corner = (ost_pm3){v.geometry.corner.x + by.x, v.geometry.corner.y + by.y, v.geometry.corner.z + by.z};
    pose.t = (ost_pm3){pose.t.x - by.x, pose.t.y - by.y, pose.t.z - by.z};
    if (l->status == OST_OK)
        l->status = ost_tool_upload(l->backend, &v, &other, l->err);
    if (other)
        lab_remove(l, &s->g, 32, s->b, other, &pose, 1, NULL);
    ost_tool_free(other);
    ost_tool_volume_free(&v);
}

static const law laws[] = {
    {"chunk sizes", "AR-CHK-3 AR-LAW-1", "chunks of 16, 32 and 64 give the same voxels", chunk_sizes},
    {"twice is once", "AR-LAW-2", "the same event again removes nothing", twice},
    {"order", "AR-LAW-2", "events in another order give the same voxels", order},
    {"poses one by one", "AR-LAW-3", "an event of several poses equals single events at these poses", one_by_one},
    {"moved together", "AR-LAW-5", "bone and tool moved together by any number of picometres give the same voxels",
     moved},
    {"moved tool", "AR-MAP-1", "a tool moved within its frame, with a pose that moves it back, removes the same voxels",
     shifted},
};

/* Counts the voxels that an event changed to a value other than 0. An event may only remove voxels. */
static void only_removed(lab *l, const int16_t *before, const int16_t *after, int64_t *wrong)
{
    for (int i = 0; i < COUNT && l->status == OST_OK; i++)
        *wrong += after[i] != before[i] && after[i] != 0;
}

static void removal_laws(lab *l)
{
    int64_t added = 0, removed = 0;
    for (size_t k = 0; k < sizeof laws / sizeof laws[0]; k++) {
        draw d = draw_named(l->seed, laws[k].name);
        int64_t wrong = 0;
        int rounds = 0;
        for (; rounds < ROUNDS && l->status == OST_OK; rounds++) {
            scene s;
            make(l, &d, &s);
            if (l->status == OST_OK)
                laws[k].two_ways(l, &d, &s);
            if (l->status == OST_OK) {
                wrong += differ(s.a, s.b);
                removed += differ(s.before, s.a);
                only_removed(l, s.before, s.a, &added);
            }
            end(&s);
        }
        lab_record(l, "relation", laws[k].name, laws[k].requirements, laws[k].what, wrong == 0, "0 voxels differ",
                   "%lld voxels differ in %d rounds", (long long)wrong, rounds);
    }
    lab_record(l, "relation", "only removed", "AR-LAW-2 AR-REM-2",
               "each voxel is unchanged or removed, and some are removed", added == 0 && removed > 0,
               "0 other voxels", "%lld other voxels, %lld removed", (long long)added, (long long)removed);
}

static int64_t differ_tools(const ost_tool_volume *a, const ost_tool_volume *b)
{
    const int64_t n = ost_dims_count(a->geometry.dims);
    int64_t wrong = n != ost_dims_count(b->geometry.dims);
    for (int64_t i = 0; !wrong && i < n; i++)
        wrong += a->voxels[i] != b->voxels[i];
    return wrong;
}

/* Checks three laws for boxes with borders at any position. The box is turned inside out, cut into two halves, or moved
   by a whole number of voxels. */
static void mesh_laws(lab *l)
{
    draw d = draw_named(l->seed, "meshes");
    const ost_pm voxel = LAB_MM / 2;
    int64_t reversed = 0, halves = 0, moved_by = 0, solid = 0;
    int rounds = 0;
    for (; rounds < ROUNDS && l->status == OST_OK; rounds++) {
        ost_mesh m[5];
        ost_tool_volume v[5] = {{.voxels = NULL}};
        const ost_pm3 lo = draw_point(&d, -9 * LAB_MM, 0);
        const ost_pm3 hi = draw_point(&d, LAB_MM, 9 * LAB_MM);
        const ost_pm3 n = draw_point(&d, -20, 20), by = {n.x * voxel, n.y * voxel, n.z * voxel};
        const ost_pm cut = draw_between(&d, lo.x + 1, hi.x - 1);
        /* Initialised because it is read below, even if ost_tool_geometry_from_bounds fails. */
        ost_tool_geometry grid = {.dims = {0, 0, 0}};
        l->status = ost_tool_geometry_from_bounds(lo, hi, voxel, &grid, l->err);
        ost_tool_geometry there = grid;
        there.corner = (ost_pm3){grid.corner.x + by.x, grid.corner.y + by.y, grid.corner.z + by.z};
        lab_box(l, lo, hi, false, &m[0]);
        lab_box(l, lo, hi, true, &m[1]);
        lab_box(l, lo, (ost_pm3){cut, hi.y, hi.z}, false, &m[2]);
        lab_box(l, (ost_pm3){cut, lo.y, lo.z}, hi, false, &m[3]);
        lab_box(l, (ost_pm3){lo.x + by.x, lo.y + by.y, lo.z + by.z}, (ost_pm3){hi.x + by.x, hi.y + by.y, hi.z + by.z},
                false, &m[4]);
        for (int i = 0; i < 5; i++)
            lab_voxelize(l, &m[i], i == 4 ? &there : &grid, voxel, &v[i]);
        if (l->status == OST_OK) {
            reversed += differ_tools(&v[0], &v[1]);
            for (int64_t i = 0; i < ost_dims_count(grid.dims); i++) {
                /* counts the voxels that are not in exactly one of the two halves of the box */
                halves += (v[2].voxels[i] + v[3].voxels[i]) != v[0].voxels[i];
                solid += v[0].voxels[i];
            }
            moved_by += differ_tools(&v[0], &v[4]);
        }
        for (int i = 0; i < 5; i++) {
            ost_tool_volume_free(&v[i]);
            ost_mesh_free(&m[i]);
        }
    }
    lab_record(l, "relation", "inside out", "AR-LAW-8", "a mesh with all its faces reversed gives the same voxels",
               reversed == 0 && solid > 0, "0 voxels differ", "%lld differ in %d rounds", (long long)reversed, rounds);
    lab_record(l, "relation", "two halves", "AR-LAW-7 AR-VOX-2",
               "of a mesh cut into two closed halves, each solid voxel is in exactly one half",
               halves == 0 && solid > 0, "0 voxels differ", "%lld differ in %d rounds", (long long)halves, rounds);
    lab_record(l, "relation", "moved mesh", "AR-LAW-4", "a mesh moved by a whole number of voxels gives the same grid",
               moved_by == 0 && solid > 0, "0 voxels differ", "%lld differ in %d rounds", (long long)moved_by, rounds);
}

/* Checks that a grid does not depend on the order of samples or on the sizes of batches. */
static void sample_laws(lab *l)
{
    enum { N = 9 * 8 * 7 };
    draw d = draw_named(l->seed, "samples");
    ost_sample s[N];
    int16_t got[2][N] = {{0}};
    const ost_geometry g = {.dims = {9, 8, 7}, .spacing = {LAB_MM, 2 * LAB_MM, 3 * LAB_MM}};
    for (int i = 0; i < N; i++)
        s[i] = (ost_sample){.x = i % 9 * LAB_MM,
                            .y = i / 9 % 8 * 2 * LAB_MM,
                            .z = i / 72 * 3 * LAB_MM,
                            .density = (int32_t)draw_between(&d, -1000, 3000),
                            .line = (uint32_t)i};
    for (int way = 0; way < 2 && l->status == OST_OK; way++) {
        ost_grid *rect = NULL;
        ost_scatter_report report = {0};
        l->status = ost_grid_create(l->backend, &g, &rect, l->err);
        for (int at = 0; at < N && l->status == OST_OK;) {
            const int n = way ? (int)draw_between(&d, 1, N - at) : N;
            for (int i = 0; i < n; i++)
                s[at + i].line = (uint32_t)i;
            l->status = ost_ct_to_rect(rect, s + at, (size_t)n, at + 1, OST_DUPLICATES_ERROR, &report, l->err);
            at += n;
        }
        if (l->status == OST_OK)
            l->status = ost_grid_download(rect, 0, 7, got[way], l->err);
        ost_grid_free(rect);
        for (int i = N - 1; i > 0; i--) {
            const int j = (int)draw_between(&d, 0, i);
            const ost_sample t = s[i];
            s[i] = s[j];
            s[j] = t;
        }
    }
    lab_record(l, "relation", "samples in any order", "AR-CT-9",
               "samples in any order and in batches of any size give the same grid",
               memcmp(got[0], got[1], sizeof got[0]) == 0, "the same grid",
               memcmp(got[0], got[1], sizeof got[0]) == 0 ? "the same grid" : "another grid");
}

void lab_relations(lab *l)
{
    sample_laws(l);
    removal_laws(l);
    mesh_laws(l);
}
