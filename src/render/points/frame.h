/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a frame. Surfaces are drawn into planes of pixels (splat.h), from which the colours are computed.
 *
 *   blocks --frustum, order--> near ones first --facing, tint--> a list --bands of rows, by threads--> planes
 *
 * Each further object, such as a tool, is drawn in the same way, but into separate planes of the band. The planes are
 * then merged, so that each pixel shows the nearest object. A tool whose mesh is known is drawn as a smooth mesh
 * instead (triangles.h), after all voxels.
 *
 * A block is skipped if nearer blocks already cover all pixels that it could cover. For this test, the farthest key of
 * each tile of 8 x 8 pixels is cached, and recomputed only when it is needed and the tile has changed. Skipping blocks
 * does not change the picture.
 *
 * After a call of ost_frame_store, unchanged parts of a frame are reused while the eye and the light do not change:
 *
 *   blocks with changed lists --old and new compared entry by entry--> voxels that differ
 *   cells that these voxels may cover --drawn again--> planes with only the first object
 *   these cells, and the cells that other layers covered --copied from these planes--> frame
 *   other layers --drawn over the copied cells--> frame
 *
 * The picture is bit-identical to one that is drawn completely. In a cell that no changed voxel can cover, the nearest
 * voxel is the same as before. Ties between equal distances are broken by the voxel's number, which has the same order
 * as the voxels' positions.
 *
 * After a call of ost_frame_antialias, the colours of the objects are drawn into a separate plane. The colours of the
 * frame, with smooth edges (antialias.h), are computed from this plane, but only where something may have changed.
 * Ghosts, lines and letters are drawn on the smoothed colours.
 *
 * The memory is reused from frame to frame: 9 bytes per pixel, 18 after ost_frame_store, and 4.25 more after
 * ost_frame_antialias.
 */
#ifndef OST_RENDER_FRAME_H
#define OST_RENDER_FRAME_H

#include "render/lettering.h"
#include "render/points/antialias.h"
#include "render/points/blocks.h"
#include "render/points/cells.h"
#include "render/points/light.h"
#include "render/points/triangles.h"

enum {
    /* number of rows that a thread draws at a time. The keys of 64 rows of 1280 pixels fit into a second-level cache */
    OST_BAND = 64,
};

/* The farthest key of a tile. If `stale` is true, `farthest` is only an upper bound. */
typedef struct ost_frame_tile {
    uint64_t farthest;
    bool stale;
} ost_frame_tile;

_Static_assert(OST_BAND % OST_CELL_HEIGHT == 0 && (int)OST_CELL_HEIGHT == OST_TILE && (int)OST_CELL_WIDTH == OST_LANES,
               "cells are whole tiles");

/* Scratch of one thread for drawing a band. It is small enough to stay in a cache between bands and layers. */
typedef struct ost_frame_bench {
    /* owned; planes for the current layer; for the first layer, only the keys are used */
    ost_planes over;
    ost_frame_tile *tiles;  /* owned; tiles of the band, tiles_across per row */
    struct ost_frame_lists *lists; /* owned; scratch for making lists */
} ost_frame_bench;

/* The list of the points of one block that face the layer's eye. */
typedef struct ost_frame_list {
    uint64_t version;       /* version of the block from which the list was computed */
    /* count: number of entries; capacity: number of entries for which memory is reserved */
    uint32_t count, capacity;
    /* index of the memory reserved for the next list of the block; the current list begins at visible.begin */
    uint32_t visible_first;
    int32_t at[3];          /* position of the block, in blocks */
    bool listed;            /* true if the list exists; if false, no voxel of the block is drawn */
    /* true if the block was in the view frustum in the last frame, even if it was hidden */
    bool there;
} ost_frame_list;

/* An object to draw, and the lists of its blocks. */
typedef struct ost_frame_layer {
    const ost_surface *surface; /* surface to draw; borrowed while a frame is drawn */
    ost_frame_block *blocks; /* owned; blocks in view; `count` entries after culling */
    int32_t count;
    ost_visible visible;    /* the lists */
    size_t visible_capacity, visible_used;
    ost_frame_list *list;   /* owned; state of the list of each slot's block */
    /* slots: number of slots in the last frame; slot_capacity: capacity of the arrays that are indexed by slot */
    int32_t slots, slot_capacity;
    float *bases;           /* owned; for each slot, the vector from the eye to the block's first voxel, in 4 floats */
    ost_splat_eye eye;
    ost_light light;
    float scale;            /* edge length of this layer's voxels, in voxels of the first object */
    /* true if the eye is inside the object or very close to it; faces between two active voxels may then be visible */
    bool within;
    /* true if frames are stored and the eye and the light are the same as in the previous frame */
    bool same;
    int y0, y1;             /* half-open range of rows that the layer may cover */
    ost_cells cells;        /* cells that the layer may cover */
} ost_frame_layer;

enum { OST_FRAME_LAYERS = 4 };

typedef struct ost_frame {
    int width, height;
    /* owned; planes of the frame; without keys unless ost_frame_store_keys was called */
    ost_planes planes;
    /* Planes that objects are drawn into. They share the memory of `planes`. After a call of ost_frame_antialias,
       `colour` is a separate array instead, which the frame owns. */
    ost_planes drawn;
    ost_antialias antialias; /* owned; edges of the picture; empty before ost_frame_antialias */
    ost_planes ghost;       /* owned; planes for a ghost, without keys; NULL before the first ghost */
    /* owned; planes of the first layer alone; they have no keys, and are NULL before ost_frame_store */
    ost_planes stored;
    bool is_stored;         /* true if `stored` contains the first layer of the last frame */
    ost_cells part;         /* cells of the first layer that are redrawn in this frame */
    /* cells to copy from `stored`, because they are redrawn or were covered by other layers in the previous frame */
    ost_cells stale;
    /* cells whose colours may differ from `stored`; code that draws on the frame's sheet adds cells to this set */
    ost_cells over;
    /* cells whose smooth colours were computed in this frame; empty before ost_frame_antialias */
    ost_cells smoothed;
    ost_frame_bench *bench; /* owned; one scratch per thread */
    int tiles_across;
    uint32_t *blank;        /* owned; one row of background */
    ost_splat_kernels kernels;
    ost_light_tint_of *tint;
    ost_triangle_rows *rows;
    int threads;
    int band;               /* number of rows that a thread draws at a time, a multiple of OST_TILE */
    ost_frame_layer layer[OST_FRAME_LAYERS];
    int layers;             /* number of layers in the last frame */
    ost_triangles smooth[OST_FRAME_LAYERS]; /* objects of this frame that are drawn as smooth meshes */
    int smooth_count;
    ost_style style;
    ost_directions *directions; /* owned */
} ost_frame;

/* An object to draw. */
typedef struct ost_frame_thing {
    const ost_surface *surface;
    /* eye in voxel coordinates of the object; its picture size must be that of the frame */
    ost_eye eye;
    ost_paint paint;
    /* colours of the paint numbers; borrowed; NULL if all voxels have the object's own paint */
    const uint32_t *palette;
    /* borrowed; smooth mesh to draw instead of the surface's voxels, or NULL; must be NULL for the first object */
    const ost_smooth_mesh *mesh;
} ost_frame_thing;

/* Allocates a frame. 0 threads means one thread per processor. */
ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads,
                          ost_error *err);
/* Frees the frame's memory. Accepts a zero-initialized frame. */
void ost_frame_free(ost_frame *frame);

/* For tests: enables keys for later frames. The planes then also contain the keys of the first layer, which identify
   the voxel at each pixel. */
ost_status ost_frame_store_keys(ost_frame *frame, ost_error *err);

/* Enables partial redrawing: later frames draw only the parts that differ from the previous frame, which saves time
   if few blocks change between frames. */
ost_status ost_frame_store(ost_frame *frame, ost_error *err);
/*
 * Enables antialiasing of later frames with OST_STYLE_SMOOTH. Frames with OST_STYLE_FACES are not smoothed, because
 * they have edges everywhere. Must be called before the first frame is drawn.
 */
ost_status ost_frame_antialias(ost_frame *frame, ost_isa isa, ost_error *err);
/* Must be called after another renderer has overwritten all pixels of frame->drawn. Smooths the edges if antialiasing
   is enabled. No pixel of this frame is reused in the next frame. */
void ost_frame_overwritten(ost_frame *frame);
/*
 * Adds to `cells` all cells in which the frame may differ from the previous frame. Pixels that were drawn through the
 * frame's sheet are taken into account.
 */
void ost_frame_changed(const ost_frame *frame, const ost_cells *cells);
/* Returns the frame's colours as a sheet to draw on. */
ost_sheet ost_frame_sheet(const ost_frame *frame);

/*
 * Draws `count` objects into the planes. Depth is in voxels of the first object. Returns OST_ERR_RANGE if the eye is
 * more than 2^15 voxels away from an object, measured in voxels of this object.
 */
ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err);
/*
 * Blends one more object over a frame, which any renderer may have drawn. The opacity of the object is share / 256
 * where it is in front of the other objects, and half of that elsewhere. Only colours change. `spacing` is the voxel
 * spacing of the first object, which is the unit of depth.
 */
ost_status ost_frame_draw_ghost(ost_frame *frame, const ost_frame_thing *thing, unsigned share, ost_pm spacing,
                                ost_error *err);
/* Draws a frame that contains only the bone. */
ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err);

/* Copies the colours of the last frame to a picture of the frame's size. */
void ost_frame_copy(const ost_frame *frame, ost_picture *picture);
/* Copies colours in the format of a frame (red in the lowest byte, `stride` pixels per row) to the picture. */
void ost_colours_copy(const uint32_t *colours, int stride, ost_picture *picture);

#endif
