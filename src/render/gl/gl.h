/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxels as GL_POINTs with a ray-box test in the fragment shader (Majercik et
 * al. 2018; thesis 2.6 and 3.3.2): what points/ does on the processor, by
 * OpenGL, into the same picture.
 *
 *   surfaces --changed blocks--> buffers of OpenGL
 *   eye --blocks in sight, points turned to it--> list --GL_POINTS--> colour, face and depth of each pixel
 *                                                      --composite--> lit colours, depth --read--> planes of a frame
 *
 * Its context needs no display (EGL) and belongs to a thread of its own, so any
 * thread may ask, one at a time, a window's too.
 */
#ifndef OST_RENDER_GL_H
#define OST_RENDER_GL_H

#include "render/points/frame.h"

typedef struct ost_gl ost_gl;

/* Where a voxel's fragment goes. */
typedef enum ost_gl_target {
    OST_GL_COMPACT, /* its colour, the face and its depth, 64 bits */
    OST_GL_WIDE,    /* normal and colour, 32-bit floats each: the thesis' */
    OST_GL_SMALL,   /* the same in 8 bits */
    OST_GL_FORWARD  /* the colour itself */
} ost_gl_target;

/* What is drawn, and how. All but ost_gl_ours and ost_gl_thesis is there to be compared. */
typedef struct ost_gl_variant {
    bool every_voxel; /* of every block in use a point, active or not: the thesis'; needs OST_GL_WIDE */
    bool frustum;     /* only blocks in sight */
    bool facing;      /* only points with a face toward the eye */
    bool order;       /* near blocks first */
    bool occlusion;   /* only cells of 8^3 voxels that no others hide; asks for frustum, no true_depth, OST_GL_COMPACT */
    bool tiles;       /* what that asks of depths is found by OpenGL, though it be software: as on a graphics card */
    bool tight;       /* the cube's own rectangle, cut to the frame; else the square about its bounding sphere */
    bool lines;       /* coverage by three linear inequalities; else the slabs of the thesis */
    bool true_depth;  /* written by the fragment shader; else the squared distance of the voxel's centre */
    bool bricks;      /* 4^3 voxels a point, with a walk within; asks for tight, no facing, OST_GL_COMPACT or OST_GL_FORWARD */
    bool choose;      /* bricks where voxels are small on the screen */
    ost_gl_target target;
} ost_gl_variant;

extern const ost_gl_variant ost_gl_ours;
/* Tools as triangles; flat faces, whatever the style. */
extern const ost_gl_variant ost_gl_thesis;

typedef struct ost_gl_options {
    bool debug;  /* asks the driver for messages, which become errors */
    int version; /* ten times the newest version to make use of, 0: any; the driver's own may be older */
} ost_gl_options;

typedef struct ost_gl_info {
    char version[96];  /* "4.5 (Core Profile) Mesa 22.3.6" */
    char driver[128];  /* "llvmpipe (LLVM 15.0.6, 256 bits)" */
    char way[48];      /* "EGL without a surface" */
    bool software;     /* drawn by the processor too */
    bool mapped;       /* buffers stay mapped */
    float largest;     /* point, in pixels */
} ost_gl_info;

/* NULL where this build has it; else why not. */
const char *ost_gl_missing(void);
/* OST_ERR_UNAVAILABLE with what is missing, in one line: this build, EGL, a driver, OpenGL 3.3. */
ost_status ost_gl_open(const ost_gl_options *options, ost_gl **out, ost_error *err);
void ost_gl_close(ost_gl *gl); /* NULL is allowed */
ost_gl_info ost_gl_info_get(const ost_gl *gl);

/*
 * The same picture as ost_frame_draw_things makes of the same things; what
 * changed since the last time is brought to OpenGL first.  OST_ERR_RANGE as
 * there; OST_ERR_UNAVAILABLE when OpenGL refuses, or has lost its context.
 */
ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count, ost_style style, ost_error *err);
/* Until all of it is drawn. */
ost_status ost_gl_finish(ost_gl *gl, ost_error *err);
/* The last picture into a frame of its size: colour and face, and depth where it is asked for; keys are left as they were. */
ost_status ost_gl_read(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err);

/* What the last draw did. */
typedef struct ost_gl_counts {
    uint64_t points;   /* vertices given to OpenGL */
    uint64_t uploaded; /* bytes of surfaces brought to it */
    bool bricks;       /* the first thing went as bricks */
    uint32_t hidden;   /* cells of 8^3 voxels of it, in blocks in sight, that were left out behind others */
} ost_gl_counts;
ost_gl_counts ost_gl_counts_get(const ost_gl *gl);

#endif
