/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes bones, tools and poses for the tests of removal and of the world. They are generated from a seed, on
 * any backend. Bones and tools are small enough for tests to download them completely.
 */
#ifndef OST_TESTS_REF_SCENE_H
#define OST_TESTS_REF_SCENE_H

#include "backends.h"

#define UM (OST_PM_PER_MM / 1000)

static inline ost_geometry cubic_geometry(int32_t x, int32_t y, int32_t z, ost_pm spacing, ost_pm3 origin)
{
    return (ost_geometry){.dims = {x, y, z}, .spacing = {spacing, spacing, spacing}, .origin = origin};
}

static inline size_t voxel_count(const ost_geometry *g)
{
    return (size_t)ost_dims_count(g->dims);
}

/*
 * Returns random densities. On average, `share` of every 8 voxels are active, with densities from 120 to
 * 1,000. The other densities are below the threshold, from -1,000 to 119.
 */
static inline int16_t *random_densities(test_rng *rng, const ost_geometry *g, int share)
{
    size_t count = voxel_count(g);
    int16_t *voxels = malloc(count * sizeof *voxels);
    assert_non_null(voxels);
    for (size_t i = 0; i < count; i++)
        voxels[i] = rng_range(rng, 0, 7) < share ? (int16_t)rng_range(rng, 120, 1000)
                                                 : (int16_t)rng_range(rng, -1000, 119);
    return voxels;
}

static inline ost_bone *bone_of(ost_backend *backend, const ost_geometry *g, int chunk_size, const int16_t *voxels)
{
    ost_error err = {0};
    ost_bone *bone;
    assert_ok(ost_bone_create(backend, g, chunk_size, 120, &bone, &err));
    assert_ok(ost_bone_upload(bone, 0, g->dims.z, voxels, &err));
    return bone;
}

static inline int16_t *content(const ost_bone *bone, const ost_geometry *g)
{
    ost_error err = {0};
    int16_t *voxels = malloc(voxel_count(g) * sizeof *voxels);
    assert_non_null(voxels);
    assert_ok(ost_bone_download(bone, 0, g->dims.z, voxels, &err));
    return voxels;
}

static inline void assert_same_voxels(const int16_t *a, const int16_t *b, const ost_geometry *g)
{
    for (size_t i = 0; i < voxel_count(g); i++)
        if (a[i] != b[i])
            fail_msg("voxel %zu: %d, expected %d", i, a[i], b[i]);
}

static inline ost_digest digest_of(const ost_bone *bone)
{
    ost_error err = {0};
    ost_digest digest;
    assert_ok(ost_bone_digest(bone, NULL, &digest, &err));
    return digest;
}

/* Returns a tool whose voxels all have the class tool_class. */
static inline ost_tool *solid_tool(ost_backend *backend, ost_tool_geometry g, uint8_t tool_class)
{
    ost_error err = {0};
    ost_tool_volume volume;
    ost_tool *tool;
    assert_ok(ost_tool_volume_init(&volume, &g, &err));
    memset(volume.voxels, tool_class, (size_t)ost_dims_count(g.dims));
    assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
    ost_tool_volume_free(&volume);
    return tool;
}

/* Returns a tool of random empty, cutting and non-cutting voxels. */
static inline ost_tool *random_tool(ost_backend *backend, test_rng *rng, ost_tool_geometry g)
{
    ost_error err = {0};
    ost_tool_volume volume;
    ost_tool *tool;
    assert_ok(ost_tool_volume_init(&volume, &g, &err));
    for (int64_t i = 0; i < ost_dims_count(g.dims); i++) {
        int64_t r = rng_range(rng, 0, 9);
        volume.voxels[i] = r < 6 ? OST_TOOL_CUTTING : r < 8 ? OST_TOOL_NONCUTTING : OST_TOOL_VOID;
    }
    assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
    ost_tool_volume_free(&volume);
    return tool;
}

/*
 * Returns a random pose. The quaternion is drawn from a 4-ball by rejection and scaled to 2^30 by an
 * integer square root. Its distribution is sufficiently uniform, and libm is not needed.
 */
static inline ost_pose random_pose(test_rng *rng, ost_pm3 lo, ost_pm3 hi)
{
    int64_t c[4], n;
    do {
        n = 0;
        for (int a = 0; a < 4; a++) {
            c[a] = rng_range(rng, -(1 << 20), 1 << 20);
            n += c[a] * c[a];
        }
    } while (n > (INT64_C(1) << 40) || n < (INT64_C(1) << 34));
    int64_t root = 1;
    for (int64_t bit = INT64_C(1) << 21; bit; bit >>= 1)
        if ((root + bit) * (root + bit) <= n)
            root += bit;
    ost_pose pose = {
        .t = {rng_range(rng, lo.x, hi.x), rng_range(rng, lo.y, hi.y), rng_range(rng, lo.z, hi.z)},
        .qw = (int32_t)(c[0] * OST_Q30_ONE / root),
        .qx = (int32_t)(c[1] * OST_Q30_ONE / root),
        .qy = (int32_t)(c[2] * OST_Q30_ONE / root),
        .qz = (int32_t)(c[3] * OST_Q30_ONE / root),
    };
    assert_int_equal(ost_pose_check(&pose, NULL), OST_OK);
    return pose;
}

/* An event whose boxes are the complete grid, as in the definition of removal. */
enum { SCENE_POSES = 64 };
typedef struct scene_event {
    ost_map maps[SCENE_POSES];
    ost_voxel_box boxes[SCENE_POSES];
    ost_density_classes classes;
    ost_removal_event event;
} scene_event;

static inline const ost_removal_event *event_of(scene_event *e, const ost_geometry *g, const ost_tool *tool,
                                        const ost_pose *poses, int count)
{
    ost_error err = {0};
    assert_true(count <= SCENE_POSES);
    for (int k = 0; k < count; k++) {
        assert_ok(ost_map_make(&poses[k], g, ost_tool_geometry_get(tool), &e->maps[k], &err));
        e->boxes[k] = (ost_voxel_box){.hi = {g->dims.x, g->dims.y, g->dims.z}};
    }
    e->classes = ost_density_classes_default();
    e->event = (ost_removal_event){.pose_count = count, .maps = e->maps, .boxes = e->boxes, .classes = &e->classes};
    return &e->event;
}

static inline void remove_at(ost_bone *bone, const ost_geometry *g, const ost_tool *tool, const ost_pose *poses,
                             int count, ost_removal_report *report)
{
    ost_error err = {0};
    scene_event *e = malloc(sizeof *e);
    assert_non_null(e);
    assert_ok(ost_bone_remove(bone, tool, event_of(e, g, tool, poses, count), report, &err));
    free(e);
}

static inline void assert_same_report(const ost_removal_report *a, const ost_removal_report *b)
{
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->total_voxels, b->total_voxels);
    assert_int_equal(a->touched_voxels, b->touched_voxels);
    assert_memory_equal(a->voxels, b->voxels, sizeof a->voxels);
    assert_memory_equal(a->density, b->density, sizeof a->density);
    for (size_t i = 0; i < a->count; i++) {
        assert_int_equal(a->chunks[i].chunk, b->chunks[i].chunk);
        assert_memory_equal(a->chunks[i].voxels, b->chunks[i].voxels, sizeof a->chunks[i].voxels);
        assert_memory_equal(a->chunks[i].density, b->chunks[i].density, sizeof a->chunks[i].density);
    }
}

#endif
