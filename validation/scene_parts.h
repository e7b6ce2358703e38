/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of scenes: a CT, tools, ticks. After a failure the caller frees the scene with scene_free. */
#ifndef OST_VALIDATION_SCENE_PARTS_H
#define OST_VALIDATION_SCENE_PARTS_H

#include "validation/draw.h"
#include "validation/scene.h"

/* Makes the samples of a random CT of these dims; spacing, origin and duplicates must be set; a threshold of 0 is
   drawn. */
ost_status scene_ct(scene *s, draw *d, ost_dims dims, ost_error *err);
/*
 * Makes one sample of every voxel, in the order of a file.  Along x each sample
 * lies a little farther off its lattice point than the one before, the last of
 * them by SCENE_DRIFT.
 */
enum { SCENE_DRIFT = 2000005 };
ost_status scene_ct_drifting(scene *s, draw *d, ost_dims dims, ost_error *err);
/* Makes one sample of every voxel of a volume, in the order of a file. */
ost_status scene_ct_of_volume(scene *s, const ost_volume *volume, ost_error *err);

/* Makes static event `number`: a bone without void voxels, one tool, one pose. */
ost_status scene_static(scene *s, int number, ost_error *err);

/* Makes grids, meshes and ticks for a case of the family PLAN_STEPS: sweep, map, motor and snapping, without voxels. */
ost_status scene_steps(scene *s, draw *d, int number, ost_error *err);

/* Makes case `number` of the family PLAN_REACH (scene_reach.c). */
ost_status scene_reach(const plan_case *c, scene *s, draw *d, ost_error *err);

/* Makes poses at which the corner of a cube of 8^3 voxels lies just within a tool of one voxel (scene_corner.c). */
ost_status scene_corners(scene *s, draw *d, ost_error *err);

/* Make two kinds of cases of PLAN_REACH (scene_lone.c): chunks with one column of active voxels; a bone without any. */
ost_status scene_lone(int kind, scene *s, draw *d, ost_error *err);
ost_status scene_emptied(const plan_case *c, int kind, scene *s, draw *d, ost_error *err);

/*
 * Adds a box of `size` voxels whose grid has no margin around it: rods, plates
 * and bars along the axes.  Its last `shaft` layers along z do not cut, up to
 * the grid's border.
 */
ost_status scene_add_bar(scene *s, ost_dims size, int32_t shaft, ost_pm voxel, ost_error *err);

/*
 * Adds two closed plates, 32 voxels apart along x, and between them a non-cutting
 * box without one of its faces: its rows leak, and they pass through both plates.
 * The corners of some triangles are collinear.
 */
ost_status scene_add_plates(scene *s, ost_pm voxel, ost_error *err);

/*
 * Adds a tool of 2 x 257 x 256 voxels, which has more than 2^16 rows: column 0
 * is solid, and six rows are solid in column 1, by needles whose ends are the
 * smallest triangles of the lattice.
 */
ost_status scene_add_thin_tool(scene *s, ost_pm voxel, ost_error *err);

typedef enum scene_shape {
    SHAPE_REAMER,   /* this and the next two: the parametric tools, of random size */
    SHAPE_PEG,
    SHAPE_BURR,
    SHAPE_BOX,      /* a parallelepiped in any orientation */
    SHAPE_TWICE,    /* the same solid twice: winding 2, parity void */
    SHAPE_HOLLOW,   /* a solid that contains another one turned inside out */
    SHAPE_OPEN,     /* a solid without some of its triangles: leaking rows */
    SHAPE_SOUP,     /* triangles that enclose nothing */
    SHAPE_SLIVERS,  /* thin and tiny triangles, many without area after snapping */
    SHAPE_COUNT
} scene_shape;

/* Adds a tool about `size` wide with voxels of size `voxel`, with a part that does not cut if noncutting is true. */
ost_status scene_add_tool(scene *s, draw *d, scene_shape shape, ost_pm size, ost_pm voxel, bool noncutting,
                          ost_fill_rule rule, ost_error *err);

/*
 * Adds a tool of 58^3 voxels that is solid up to its grid's border, which no
 * mesh with a margin is: a box, and in it solids whose sloped edges pass exactly
 * through the centres of rows, with products beyond 2^24.
 */
ost_status scene_add_full_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Adds small solids in random orientations, with more than 2^16 triangles, nearly all of which have rows of voxels
   within their bounds. */
ost_status scene_add_fine_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Makes `count` unrelated poses that bring a tool into the bone, with sweep off. */
ost_status scene_unrelated_poses(scene *s, draw *d, size_t count, ost_error *err);
/* Adds `count` ticks with the last tool near the middle of the bone. */
ost_status scene_add_poses_inside(scene *s, draw *d, size_t count, ost_error *err);
/*
 * Adds three ticks with the last tool, not turned. In each a layer of bone
 * voxels lies within a few units of 2^-20 of the tool's face: a backend that
 * rounds differently removes another layer.
 */
ost_status scene_add_border_poses(scene *s, draw *d, ost_error *err);
/* Adds two ticks with the last tool, through the middle of a chunk from one side to the other. In the sweep a voxel
   is hit at many poses of one event. */
ost_status scene_add_crossing(scene *s, ost_error *err);
/* Adds a tick with the last tool 2^32 units away: it meets nothing, but would meet everything if coordinates
   wrapped. */
ost_status scene_add_far_pose(scene *s, ost_error *err);
ost_status scene_drive(scene *s, draw *d, size_t count, ost_pm speed, double turn, ost_error *err);

#endif
