/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Detects state that a backend retains by mistake: earlier work of a process must not change the results
 * of a case. The functions below do such earlier work and do not record its results. Before the import,
 * some of the case's samples are scattered into a grid with a different lattice, and a grid is converted
 * to chunks of a different size. Before the ticks, each tool collides with a bone whose voxels have a
 * different size. If a backend retains state from this work, the records of the case change.
 */
#include "validation/perform_parts.h"

enum { LATTICE_SIDE = 7, LATTICE_SAMPLES = 64, GRID_SIDE = 8, BONE_SIDE = 16, BONE_DENSITY = 32767 };

/* larger tools are skipped, because preparing one takes tens of milliseconds */
#define TOOL_VOXELS ((int64_t)1 << 18)

/* Returns an origin two voxels below the CT's origin, or two voxels above it if the lower one would exceed the range
   of lengths. */
static ost_pm other_origin(ost_pm origin, ost_pm spacing)
{
    return origin - 2 * spacing < -OST_LENGTH_MAX ? origin + 2 * spacing : origin - 2 * spacing;
}

ost_status perform_other_lattice(performer *p, ost_error *err)
{
    const scene *s = p->s;
    const ost_geometry *g = &s->rect;
    const size_t n = s->sample_count < LATTICE_SAMPLES ? s->sample_count : LATTICE_SAMPLES;
    const ost_geometry other = {{LATTICE_SIDE, LATTICE_SIDE, LATTICE_SIDE},
                                g->spacing,
                                {other_origin(g->origin.x, g->spacing.x), other_origin(g->origin.y, g->spacing.y),
                                 other_origin(g->origin.z, g->spacing.z)}};
    ost_sample samples[LATTICE_SAMPLES];
    ost_scatter_report ignored = {0};
    ost_grid *grid = NULL;
    if (s->slices)
        return OST_OK;
    for (size_t i = 0; i < n; i++) /* the order is reversed, so that the case's first sample comes last */
        samples[i] = s->samples[n - 1 - i];
    ost_status status = ost_grid_create(p->backend, &other, &grid, err);
    if (status == OST_OK)
        status = ost_ct_to_rect(grid, samples, n, 1, OST_DUPLICATES_LAST, &ignored, err);
    ost_grid_free(grid);
    return status;
}

static void fill(int16_t *voxels, size_t count)
{
    for (size_t v = 0; v < count; v++)
        voxels[v] = BONE_DENSITY;
}

ost_status perform_other_chunks(performer *p, ost_error *err)
{
    static int16_t voxels[GRID_SIDE * GRID_SIDE * GRID_SIDE];
    const scene *s = p->s;
    const ost_geometry geometry = {{GRID_SIDE, GRID_SIDE, GRID_SIDE}, {s->cubic, s->cubic, s->cubic}, {0, 0, 0}};
    ost_grid *grid = NULL;
    ost_bone *bone = NULL;
    fill(voxels, sizeof voxels / sizeof voxels[0]);
    ost_status status = ost_grid_create(p->backend, &geometry, &grid, err);
    if (status == OST_OK)
        status = ost_grid_upload(grid, 0, GRID_SIDE, voxels, err);
    /* The chunks made here are smaller than those of the case, unless the case's chunks have the smallest size. Memory
       that a backend retains by mistake is then too small for the chunks of the case. */
    if (status == OST_OK)
        status = ost_cubic_to_chunks(grid, s->chunk_size == 16 ? 64 : s->chunk_size / 2, s->threshold, &bone, err);
    ost_bone_free(bone);
    ost_grid_free(grid);
    return status;
}

static ost_status meet(performer *p, int i, ost_bone *bone, const ost_geometry *geometry, ost_error *err)
{
    const ost_dims d = geometry->dims;
    const ost_pose pose = {.t = {geometry->spacing.x * d.x / 2, geometry->spacing.x * d.y / 2,
                                 geometry->spacing.x * d.z / 2},
                           .qw = OST_Q30_ONE};
    const ost_density_classes classes = {.count = 1, .border = {1}};
    const ost_voxel_box box = {.hi = {d.x, d.y, d.z}};
    steps_pose made;
    if (steps_pose_of(p->second, &pose, geometry, &p->grids[i], &made, NULL) != OST_OK)
        return OST_OK; /* AR-MAP-2 does not allow this tool with this bone. */
    const ost_removal_event event = {.pose_count = 1, .maps = &made.map, .boxes = &box, .classes = &classes};
    return ost_bone_collide(bone, p->tools[i], &event, &p->collided, err);
}

ost_status perform_other_bone(performer *p, int i, ost_error *err)
{
    static int16_t voxels[BONE_SIDE * BONE_SIDE * BONE_SIDE];
    const ost_tool_geometry *grid = &p->grids[i];
    const bool finer = p->geometry.spacing.x > grid->voxel && grid->voxel / 4 >= OST_SPACING_MIN;
    const ost_pm spacing = finer ? grid->voxel / 4 : 4 * grid->voxel;
    const ost_geometry geometry = {{BONE_SIDE, BONE_SIDE, BONE_SIDE}, {spacing, spacing, spacing}, {0, 0, 0}};
    ost_bone *bone = NULL;
    if (ost_dims_count(grid->dims) > TOOL_VOXELS || spacing > OST_SPACING_MAX || spacing * BONE_SIDE > OST_LENGTH_MAX)
        return OST_OK;
    fill(voxels, sizeof voxels / sizeof voxels[0]);
    ost_status status = ost_bone_create(p->backend, &geometry, BONE_SIDE, 1, &bone, err);
    if (status == OST_OK)
        status = ost_bone_upload(bone, 0, BONE_SIDE, voxels, err);
    if (status == OST_OK)
        status = meet(p, i, bone, &geometry, err);
    ost_bone_free(bone);
    if (status == OST_ERR_UNAVAILABLE) { /* A plugin may leave the upload of a bone unimplemented. */
        *err = (ost_error){0};
        status = OST_OK;
    }
    return status;
}
