/* SPDX-License-Identifier: Apache-2.0 */
/* Functions that generate the parts of a scene: a CT, tools, ticks. After a failure the caller must call scene_free. */
#ifndef OST_VALIDATION_SCENE_PARTS_H
#define OST_VALIDATION_SCENE_PARTS_H

#include "validation/draw.h"
#include "validation/scene.h"

/* Makes the samples of a random CT of these dims. Spacing, origin and duplicates must be set. If the threshold is 0, a
   random one is set. */
ost_status scene_ct(scene *s, draw *d, ost_dims dims, ost_error *err);
/*
 * Makes one sample per voxel, in the order of a file. Along x the distance of a sample from its lattice
 * point grows from sample to sample, up to SCENE_DRIFT picometres at the last sample.
 */
enum { SCENE_DRIFT = 2000005 };
ost_status scene_ct_drifting(scene *s, draw *d, ost_dims dims, ost_error *err);
/* Makes one sample per voxel of a volume, in the order of the voxels in a file. */
ost_status scene_ct_of_volume(scene *s, const ost_volume *volume, ost_error *err);

/* Makes static event `number` of the thesis: a bone without empty voxels, one tool and one pose. */
ost_status scene_static(scene *s, int number, ost_error *err);

/* Makes grids, meshes and ticks for a case of the PLAN_STEPS family: sweep, map, motor and snapping, without voxels. */
ost_status scene_steps(scene *s, draw *d, int number, ost_error *err);

/* Makes case `number` of the family PLAN_REACH. */
ost_status scene_reach(const plan_case *c, scene *s, draw *d, ost_error *err);

/* Makes poses at which a corner of a cube of 8^3 voxels lies just inside a tool of one voxel (scene_corner.c). */
ost_status scene_corners(scene *s, draw *d, ost_error *err);

/* These functions make two types of cases of PLAN_REACH (scene_lone.c). scene_lone makes chunks in which only one
   column has active voxels. scene_emptied makes a bone without active voxels. */
ost_status scene_lone(int kind, scene *s, draw *d, ost_error *err);
ost_status scene_emptied(const plan_case *c, int kind, scene *s, draw *d, ost_error *err);

/*
 * Adds a tool that is a box of `size` voxels, such as a rod, plate or bar along an axis. The box fills its
 * grid up to the border. The last `shaft` layers along z do not cut.
 */
ost_status scene_add_bar(scene *s, ost_dims size, int32_t shaft, ost_pm voxel, ost_error *err);

/*
 * Adds two closed plates, 32 voxels apart along x, and between them a non-cutting box. The box lacks the face
 * at its upper end along x, so its mesh is not closed in the rows that pass through it. These rows also pass
 * through both plates. The corners of some triangles are collinear.
 */
ost_status scene_add_plates(scene *s, ost_pm voxel, ost_error *err);

/*
 * Adds a tool of 2 x 257 x 256 voxels, which has more than 2^16 rows. Column 0 is
 * solid. In column 1 six rows are solid, each filled by a needle whose ends are
 * the smallest triangles of the lattice.
 */
ost_status scene_add_thin_tool(scene *s, ost_pm voxel, ost_error *err);

typedef enum scene_shape {
    SHAPE_REAMER,   /* SHAPE_REAMER, SHAPE_PEG and SHAPE_BURR: parametric tools of random size */
    SHAPE_PEG,
    SHAPE_BURR,
    SHAPE_BOX,      /* a parallelepiped of any orientation */
    SHAPE_TWICE,    /* the same solid twice; its voxels are inside by winding number, outside by parity */
    SHAPE_HOLLOW,   /* a solid with a cavity, which is a second solid whose faces are turned inside out */
    SHAPE_OPEN,     /* a solid without some of its triangles, so that the mesh is open */
    SHAPE_SOUP,     /* triangles that enclose nothing */
    SHAPE_SLIVERS,  /* thin and tiny triangles; snapping reduces many of them to an area of 0 */
    SHAPE_COUNT
} scene_shape;

/* Adds a tool that is about `size` wide and has voxels of size `voxel`. If `noncutting` is true, a part of the tool
   does not cut. */
ost_status scene_add_tool(scene *s, draw *d, scene_shape shape, ost_pm size, ost_pm voxel, bool noncutting,
                          ost_fill_rule rule, ost_error *err);

/*
 * Adds a tool of 58^3 voxels that is solid up to the border of its grid. A grid computed from a mesh has an empty
 * margin instead. The tool is a box with solids in it. The sloped edges of the solids pass exactly through the centres
 * of rows, and most products in their edge functions exceed 2^24.
 */
ost_status scene_add_full_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Adds small solids in random orientations with more than 2^16 triangles in total. Nearly all of the triangles have
   the centre of a row within their bounds. */
ost_status scene_add_fine_tool(scene *s, draw *d, ost_pm voxel, ost_error *err);

/* Returns `count` density classes, 1 to 8, whose lowest densities are 1, 1 + step, 1 + 2 step, ... */
ost_density_classes scene_classes(int count, int step);

/* Sets sweep_off, and makes a path of `count` unrelated poses. At each pose, a tool overlaps the bone. */
ost_status scene_unrelated_poses(scene *s, draw *d, size_t count, ost_error *err);
/* Adds `count` ticks at which the last tool is near the middle of the bone. */
ost_status scene_add_poses_inside(scene *s, draw *d, size_t count, ost_error *err);
/*
 * Adds three ticks with the last tool, without rotation. In each tick, the distance from a layer of bone
 * voxels to the tool's face is a few units of 2^-20 tool voxels, so a backend that rounds differently removes
 * a different layer.
 */
ost_status scene_add_border_poses(scene *s, draw *d, ost_error *err);
/* Adds two ticks in which the last tool moves through the middle of a chunk from one side to the other. In this
   sweep, a voxel is hit at many poses of one event. */
ost_status scene_add_crossing(scene *s, ost_error *err);
/* Adds a tick with the last tool 2^32 units away from the bone. The tool covers no voxel there, but would cover all
   voxels if coordinates wrapped at 32 bits. */
ost_status scene_add_far_pose(scene *s, ost_error *err);
ost_status scene_drive(scene *s, draw *d, size_t count, ost_pm speed, double turn, ost_error *err);

#endif
