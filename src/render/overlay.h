/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws explanatory lines over a frame. Lines behind surfaces are drawn faintly.
 *
 *   chunks        the grid of chunks: active ones red, others grey (thesis, Figs. 2.1, 3.1)
 *   boxes         the bone's box, the tool's oriented box, and their intersection (Fig. 2.3)
 *   hits          active chunks that intersect the tool's box (Figs. 2.3, 3.3); a chunk that has just changed is bright
 *   tool-voxels   edges of the tool's voxels (Fig. 3.4)
 *   bone-voxels   edges of the bone's voxels within the tool's box (Fig. 3.3)
 *   axis          the planned axis, with a tick per millimetre down to the planned depth
 *   landmarks     the glenoid's rim, centre and axis, the trigonum and the inferior angle, and the lines between them
 */
#ifndef OST_RENDER_OVERLAY_H
#define OST_RENDER_OVERLAY_H

#include <osteon/tool.h>

#include "render/points/frame.h"

typedef enum ost_overlay {
    OST_OVERLAY_CHUNKS,
    OST_OVERLAY_BOXES,
    OST_OVERLAY_HITS,
    OST_OVERLAY_TOOL_VOXELS,
    OST_OVERLAY_BONE_VOXELS,
    OST_OVERLAY_AXIS,
    OST_OVERLAY_LANDMARKS,
    OST_OVERLAY_COUNT
} ost_overlay;
extern const char *const ost_overlay_names[OST_OVERLAY_COUNT]; /* names of the overlays: "chunks", "boxes", ... */

enum { OST_OVERLAY_CHANGED = 64, OST_OVERLAY_RIM = 72 };

typedef struct ost_overlay_scene {
    /* surfaces of the bone and the tool, borrowed; `tool` is NULL if no tool is drawn */
    const ost_surface *bone, *tool;
    ost_tool_geometry tool_grid;
    ost_pose pose;                  /* pose of the tool in the bone's frame */
    int chunk;                      /* edge length of a chunk in voxels */
    int changed;                    /* number of positions in changed_at[] */
    /* positions of the chunks that the last update changed, in units of chunks */
    int32_t changed_at[OST_OVERLAY_CHANGED][3];
    bool planned;
    double face_mm[3], inward[3], depth_mm;
    /* trigonum spinae and inferior angle; valid if the overlay `landmarks` is selected */
    double trigonum_mm[3], inferior_mm[3];
    double rim_mm[OST_OVERLAY_RIM][3];     /* points of the glenoid's rim, in order around the rim */
    int rim_count;
} ost_overlay_scene;

/*
 * Draws overlays on the frame. `which` is a bit mask of overlays, and `eye` is the frame's eye in voxel coordinates of
 * the bone.
 */
void ost_overlay_draw(const ost_frame *frame, const ost_eye *eye, unsigned which, const ost_overlay_scene *scene);

/*
 * Computes the half-open range of the chunks that may intersect the tool's box. The range is empty if there are none.
 */
void ost_overlay_hit_range(const ost_overlay_scene *scene, int32_t lo[3], int32_t hi[3]);

/* Draws a line between two positions in voxel coordinates of the bone. `strength` is the opacity, 0 to 256 (opaque).
   The width is in pixels, at least 1. */
void ost_overlay_line(const ost_frame *frame, const ost_eye *eye, const float from[3], const float to[3],
                      uint32_t colour, unsigned strength, int width);

#endif
