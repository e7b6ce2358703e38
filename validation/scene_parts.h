/* SPDX-License-Identifier: Apache-2.0 */
/* What scenes are made of: a CT, tools, ticks. A failed part leaves the scene to scene_free. */
#ifndef OST_VALIDATION_SCENE_PARTS_H
#define OST_VALIDATION_SCENE_PARTS_H

#include "validation/draw.h"
#include "validation/scene.h"

/* Samples of a random CT of these dims; spacing, origin and duplicates are set, threshold 0 is drawn. */
ost_status scene_ct(scene *s, draw *d, ost_dims dims, ost_error *err);
/* Every voxel a sample, in the file's order. */
ost_status scene_ct_of_volume(scene *s, const ost_volume *volume, ost_error *err);

/* Static event `number`: full bone, one tool, one pose. */
ost_status scene_static(scene *s, int number, ost_error *err);

/* Grids, meshes and ticks of the steps alone. */
ost_status scene_steps(scene *s, draw *d, int number, ost_error *err);

/* Case `number` of the family that enters what others do not (scene_reach.c). */
ost_status scene_reach(const plan_case *c, scene *s, draw *d, ost_error *err);

/* Make two of its kinds (scene_lone.c): chunks with one column of active voxels, a bone without any. */
ost_status scene_lone(int kind, scene *s, draw *d, ost_error *err);
ost_status scene_emptied(int kind, scene *s, draw *d, ost_error *err);

/*
 * Adds a box of size voxels without a margin of its own: rods, plates and bars
 * along the axes.  Its last `shaft` layers along z do not cut, to the grid's border.
 */
ost_status scene_add_bar(scene *s, ost_dims size, int32_t shaft, ost_pm voxel, ost_error *err);

/*
 * Adds two plates, closed, 32 voxels apart along x, and between them a box that
 * does not cut and lacks a face: its rows leak, and go through both plates.
 * Some triangles have their corners on one line.
 */
ost_status scene_add_plates(scene *s, ost_pm voxel, ost_error *err);

typedef enum scene_shape {
    SHAPE_REAMER,   /* the parametric tools, of random size */
    SHAPE_PEG,
    SHAPE_BURR,
    SHAPE_BOX,      /* a parallelepiped of any direction */
    SHAPE_TWICE,    /* the same solid twice: winding 2, parity void */
    SHAPE_HOLLOW,   /* a solid with another turned inside out in it */
    SHAPE_OPEN,     /* a solid that lost triangles: leaking rows */
    SHAPE_SOUP,     /* triangles that bound nothing */
    SHAPE_SLIVERS,  /* thin and tiny ones, many without area once snapped */
    SHAPE_COUNT
} scene_shape;

/* Adds a tool about `size` wide of voxels `voxel`; with a noncutting part if asked. */
ost_status scene_add_tool(scene *s, draw *d, scene_shape shape, ost_pm size, ost_pm voxel, bool noncutting, ost_fill_rule rule,
                          ost_error *err);

/*
 * Adds a tool of 58^3 voxels that is solid to its grid's border, as no mesh
 * with a margin is: a box, and in it solids whose sloped edges go through rows'
 * centres exactly, with products beyond 2^24.
 */
ost_status scene_add_full_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Adds small solids in any direction, of more than 2^16 triangles, nearly each of which has rows of voxels in its bounds. */
ost_status scene_add_fine_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Poses that bring a tool into the bone: unrelated ones (with sweep off), a fast drive, a slow cut. */
ost_status scene_unrelated_poses(scene *s, draw *d, size_t count, ost_error *err);
/* So many ticks more, of the last tool near the middle of the bone. */
ost_status scene_add_poses_inside(scene *s, draw *d, size_t count, ost_error *err);
/*
 * Three ticks of it, not turned, each with a layer of bone voxels within some
 * units of 2^-20 of its face: what rounds otherwise loses the layer.
 */
ost_status scene_add_border_poses(scene *s, draw *d, ost_error *err);
/* Two ticks of it, through the middle of a chunk from side to side: swept, a voxel on the way is hit at many poses of one event. */
ost_status scene_add_crossing(scene *s, ost_error *err);
/* A tick of it 2^32 units away: it meets nothing, and all where coordinates wrap. */
ost_status scene_add_far_pose(scene *s, ost_error *err);
ost_status scene_drive(scene *s, draw *d, size_t count, ost_pm speed, double turn, ost_error *err);

#endif
