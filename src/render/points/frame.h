/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame: a surface through a camera, into planes and then into colours.
 *
 *   blocks --frustum, order--> near ones first --facing, tint--> a list --bands of rows, by threads--> planes
 *
 * Its memory is kept from frame to frame.
 */
#ifndef OST_RENDER_FRAME_H
#define OST_RENDER_FRAME_H

#include "render/points/splat.h"

enum { OST_BAND = 40 }; /* rows: 1280 of 8 bytes of these stay in a second-level cache */

typedef struct ost_frame_block {
    int32_t slot;
    float distance;      /* squared, of its centre: the order */
    int y0, y1;          /* rows that it may cover, half-open */
    uint32_t begin, count; /* in the list */
} ost_frame_block;

typedef struct ost_frame {
    int width, height;
    ost_planes planes;      /* owned */
    ost_splat_kernels kernels;
    int threads;
    ost_frame_block *blocks; /* owned; count of them after the cull */
    int32_t count, block_room;
    ost_visible visible;    /* the list */
    size_t visible_room;
    float *bases;           /* owned; 4 a slot */
    ost_style style;
    ost_splat_eye eye;      /* of the last frame */
} ost_frame;

/* threads 0: all processors. */
ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads, ost_error *err);
void ost_frame_free(ost_frame *frame); /* also of a zeroed one */

/* Fills the planes; eye's size is the frame's. OST_ERR_RANGE when the eye is more than 2^15 voxels away. */
ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err);

/* The colours of the last frame; picture has the frame's size. */
void ost_frame_copy(const ost_frame *frame, ost_picture *picture);

#endif
