/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Helpers for the tests of colours, clip planes, highlighting and overlays: a bone before and after a removal, a viewer
 * of this bone, and functions that visit the points of a surface or compare two surfaces.
 */
#ifndef OST_TESTS_LOOK_BONE_H
#define OST_TESTS_LOOK_BONE_H

#include "harness.h"

#include "render/points/extract.h"
#include "render/points/renew.h"
#include "render/viewer.h"

#define MM OST_PM_PER_MM
enum { NX = 70, NY = 41, NZ = 38, COUNT = NX * NY * NZ };

static inline ost_geometry grid(void)
{
    return (ost_geometry){{NX, NY, NZ}, {MM / 2, MM / 2, MM / 2}, {5 * MM, -3 * MM, 0}};
}

static inline size_t index_of(int i, int j, int k)
{
    return (size_t)i + (size_t)NX * ((size_t)j + (size_t)NY * (size_t)k);
}

/*
 * Makes a bone of many densities, with rounded corners and pores. In *after, a cylinder along x has been
 * removed from this bone. The cylinder extends from i = 46 to the end of the bone.
 */
static inline void make_bone(test_rng *rng, ost_volume *before, ost_volume *after)
{
    ost_error err = {0};
    const ost_geometry g = grid();
    assert_ok(ost_volume_init(before, &g, &err));
    assert_ok(ost_volume_init(after, &g, &err));
    for (int k = 0; k < NZ; k++)
        for (int j = 0; j < NY; j++)
            for (int i = 0; i < NX; i++) {
                const double a = (i - 34) / 32.0, b = (j - 20) / 17.0, c = (k - 19) / 16.0,
                             e = (j - 20.0) * (j - 20.0) + (k - 17.0) * (k - 17.0);
                const double shell = a * a * a * a + b * b * b * b + c * c * c * c;
                /* pores begin at a depth of four voxels */
                const bool bone = shell < 0.3 ? rng_range(rng, 0, 200) != 0 : shell < 1;
                const int16_t v = bone ? (int16_t)rng_range(rng, 120, 1500) : 0;
                before->voxels[index_of(i, j, k)] = v;
                after->voxels[index_of(i, j, k)] = i > 45 && e < 36 ? 0 : v;
            }
}

static inline int at(const ost_volume *v, int i, int j, int k)
{
    return i >= 0 && j >= 0 && k >= 0 && i < NX && j < NY && k < NZ ? v->voxels[index_of(i, j, k)] : 0;
}

static inline void set_bone(ost_viewer *v, const ost_volume *before, const ost_volume *now)
{
    ost_error err = {0};
    const ost_geometry g = grid();
    const ost_density_classes classes = ost_density_classes_default();
    ost_volume copy;
    assert_ok(ost_viewer_init(v, &g, OST_STYLE_SMOOTH, NULL, 1, &err));
    assert_ok(ost_volume_init(&copy, &g, &err));
    memcpy(copy.voxels, before->voxels, COUNT * sizeof *copy.voxels);
    assert_ok(ost_viewer_set_uncut(v, &copy, 120, &classes, NULL, NULL, &err));
    assert_ok(ost_surface_set_volume(&v->bone, now, 120, &err));
    assert_ok(ost_surface_update(&v->bone, &err));
}

typedef void each_point(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block);

static inline void for_points(const ost_surface *s, each_point *visit, void *user)
{
    for (int32_t b = 0; b < s->used; b++)
        for (uint32_t p = 0; p < s->slot[b]->count; p++) {
            const uint32_t w = s->slot[b]->points[p];
            const int v[3] = {32 * s->slot[b]->at[0] + (int)(w & 31), 32 * s->slot[b]->at[1] + (int)(w >> 5 & 31),
                              32 * s->slot[b]->at[2] + (int)(w >> 10 & 31)};
            visit(user, v, w, s->slot[b]->shades[p], s->slot[b]);
        }
}

static inline void assert_same_shades(const ost_surface *a, const ost_surface *b)
{
    assert_int_equal(a->points, b->points);
    for (int32_t i = 0; i < b->used; i++) {
        const int32_t *at = b->slot[i]->at;
        const ost_surface_block *same = ost_surface_block_at(a, at[0], at[1], at[2]);
        assert_non_null(same);
        assert_int_equal(same->count, b->slot[i]->count);
        if (same->count == 0)
            continue;
        assert_memory_equal(same->points, b->slot[i]->points, same->count * sizeof(uint32_t));
        assert_memory_equal(same->shades, b->slot[i]->shades, same->count * sizeof(uint32_t));
    }
}

typedef struct check {
    const ost_volume *before, *now;
    const ost_clip *clip;
    int seen, painted;
} check;

static inline uint32_t paint_of(uint32_t shade)
{
    return shade >> OST_PAINT_SHIFT & 255;
}

static inline bool borders_on_removed_voxel(const check *c, const int v[3])
{
    for (int f = 0; f < 6; f++) {
        int n[3] = {v[0], v[1], v[2]};
        n[f / 2] += f % 2 ? 1 : -1;
        if (at(c->now, n[0], n[1], n[2]) < 120 && at(c->before, n[0], n[1], n[2]) >= 120)
            return true;
    }
    return false;
}

static inline ost_tool_volume rod(void)
{
    ost_error err = {0};
    ost_tool_volume t;
    const ost_tool_geometry g = {{8, 8, 60}, MM / 2, {-2 * MM, -2 * MM, 0}};
    assert_ok(ost_tool_volume_init(&t, &g, &err));
    memset(t.voxels, OST_TOOL_CUTTING, 8 * 8 * 60);
    return t;
}

#endif
