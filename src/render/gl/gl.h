/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxels as GL_POINTs with a ray-box test in the fragment shader (Majercik et
 * al. 2018; thesis 2.6 and 3.3.2).  OpenGL makes the same picture that points/
 * makes on the processor.
 *
 *   surfaces --changed blocks--> buffers of OpenGL
 *   eye --blocks in view, points turned to it--> list --GL_POINTS--> colour, face and depth of each pixel
 *                                                      --composite--> lit colours, depth --read--> planes of a frame
 *
 * Its context needs no display (EGL) and belongs to a thread of its own, so the
 * functions may be called on any thread, one at a time, including a window's.
 */
#ifndef OST_RENDER_GL_H
#define OST_RENDER_GL_H

#include "render/points/frame.h"

typedef struct ost_gl ost_gl;

/* The format of the target to which a voxel's fragment is written. */
typedef enum ost_gl_target {
    OST_GL_COMPACT, /* colour, face and depth in 64 bits */
    OST_GL_WIDE,    /* normal and colour as 32-bit floats, as in the thesis */
    OST_GL_SMALL,   /* normal and colour, 8 bits each */
    OST_GL_FORWARD  /* the lit colour, without a G-buffer */
} ost_gl_target;

/* A way of drawing. All variants but ost_gl_ours and ost_gl_thesis exist for comparisons only. */
typedef struct ost_gl_variant {
    /* a point for every voxel of every used block, active or not, as in the thesis; needs OST_GL_WIDE */
    bool every_voxel;
    bool frustum;     /* only blocks in view */
    bool facing;      /* only points with a face toward the eye */
    bool order;       /* near blocks first */
    bool occlusion;   /* only cells of 8^3 voxels that are not hidden; needs frustum, no true_depth, OST_GL_COMPACT */
    /* OpenGL computes the depths of tiles for occlusion even if it is software, as on a graphics card */
    bool tiles;
    bool tight;       /* a point covers its cube's bounding rectangle, clipped to the frame; else its sphere's square */
    bool lines;       /* three linear inequalities decide if a pixel is covered; else the slab test of the thesis */
    bool true_depth;  /* the fragment shader writes the depth; else it is the squared distance of the voxel's centre */
    /* a point is 4^3 voxels that the shader traverses; needs tight, no facing, OST_GL_COMPACT or OST_GL_FORWARD */
    bool bricks;
    bool choose;      /* draws bricks if voxels are small on the screen, else single voxels */
    ost_gl_target target;
} ost_gl_variant;

extern const ost_gl_variant ost_gl_ours;
/* Draws tools as triangles, with flat faces in every style. */
extern const ost_gl_variant ost_gl_thesis;

typedef struct ost_gl_options {
    bool debug;  /* enables the driver's messages, which become errors */
    int version; /* ten times the newest version to use, 0: any; the driver's may be older */
} ost_gl_options;

typedef struct ost_gl_info {
    char version[96];  /* "4.5 (Core Profile) Mesa 22.3.6" */
    char driver[128];  /* "llvmpipe (LLVM 15.0.6, 256 bits)" */
    char way[48];      /* "EGL without a surface" */
    bool software;     /* OpenGL runs on the processor */
    bool mapped;       /* buffers stay mapped */
    float largest;     /* greatest size of a point, in pixels */
} ost_gl_info;

/* Returns NULL if this build has OpenGL; otherwise the reason. */
const char *ost_gl_missing(void);
/* Returns OST_ERR_UNAVAILABLE with the missing part in err: support in this build, EGL, a driver, OpenGL 3.3. */
ost_status ost_gl_open(const ost_gl_options *options, ost_gl **out, ost_error *err);
void ost_gl_close(ost_gl *gl); /* NULL is allowed */
ost_gl_info ost_gl_info_get(const ost_gl *gl);

/*
 * Draws the same picture as ost_frame_draw_things.  Blocks that changed since the
 * last call are uploaded first.  Returns OST_ERR_RANGE under the same conditions,
 * and OST_ERR_UNAVAILABLE if OpenGL fails or has lost its context.
 */
ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count,
                       ost_style style, ost_error *err);
/* Waits until drawing is complete. */
ost_status ost_gl_finish(ost_gl *gl, ost_error *err);
/* Copies the last picture to a frame of its size: colour, face and, if requested, depth. Keys are not changed. */
ost_status ost_gl_read(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err);

/* Counts of the last draw. */
typedef struct ost_gl_counts {
    uint64_t points;   /* vertices given to OpenGL */
    uint64_t uploaded; /* bytes of surfaces uploaded */
    bool bricks;       /* the first object was drawn as bricks */
    uint32_t hidden;   /* cells of 8^3 voxels of the first object, in blocks in view, that were skipped as hidden */
} ost_gl_counts;
ost_gl_counts ost_gl_counts_get(const ost_gl *gl);

#endif
