/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame: a surface through a camera, into planes and then into colours.
 *
 *   blocks --frustum, order--> near ones first --facing, tint--> a list --bands of rows, by threads--> planes
 *
 * A second thing, a tool with voxels of its own that stands at an angle, is
 * drawn the same way into planes beside these, and of each pixel the nearer
 * one stays.
 *
 * Its memory is kept from frame to frame.
 */
#ifndef OST_RENDER_FRAME_H
#define OST_RENDER_FRAME_H

#include "render/points/light.h"
#include "render/points/splat.h"

enum { OST_BAND = 40 }; /* rows: 1280 of 8 bytes of these stay in a second-level cache */

typedef struct ost_frame_block {
    int32_t slot;
    float distance;      /* squared, of its centre: the order */
    int y0, y1;          /* rows that it may cover, half-open */
    uint32_t begin, count; /* in the list */
} ost_frame_block;

/* One thing that is drawn, and its list. */
typedef struct ost_frame_layer {
    const ost_surface *surface; /* borrowed for a frame */
    ost_frame_block *blocks; /* owned; count of them after the cull */
    int32_t count, block_room;
    ost_visible visible;    /* the list */
    size_t visible_room;
    float *bases;           /* owned; 4 a slot */
    ost_splat_eye eye;
    ost_light light;
    float scale;            /* its voxels in voxels of the first */
    int y0, y1;             /* rows that it may cover, half-open */
} ost_frame_layer;

enum { OST_FRAME_LAYERS = 4 };

typedef struct ost_frame {
    int width, height;
    ost_planes planes;      /* owned */
    ost_planes over;        /* owned; where layers but the first are drawn; NULL before there was one */
    ost_splat_kernels kernels;
    int threads;
    ost_frame_layer layer[OST_FRAME_LAYERS];
    int layers;             /* of the last frame */
    ost_style style;
} ost_frame;

/* A thing in front of the camera. */
typedef struct ost_frame_thing {
    const ost_surface *surface;
    ost_eye eye;            /* in its voxels; its size is the frame's */
    ost_paint paint;
} ost_frame_thing;

/* threads 0: all processors. */
ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads, ost_error *err);
void ost_frame_free(ost_frame *frame); /* also of a zeroed one */

/* Fills the planes; depth is in voxels of the first. OST_ERR_RANGE when the eye is more than 2^15 of its voxels away from a thing. */
ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err);
/* Of bone alone. */
ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err);

/* The colours of the last frame; picture has the frame's size. */
void ost_frame_copy(const ost_frame *frame, ost_picture *picture);
/* The same of colours as a frame has them, r in the lowest byte, stride a row. */
void ost_colours_copy(const uint32_t *colours, int stride, ost_picture *picture);

#endif
