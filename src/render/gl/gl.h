/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws voxels as GL_POINTS with a ray-box test in the fragment shader (Majercik et al. 2018; thesis 2.6 and 3.3.2).
 * The picture is the same as that drawn on the CPU by the code in points/.
 *
 *   surfaces --changed blocks--> buffers of OpenGL
 *   eye --blocks in view, points that face it--> list --GL_POINTS--> colour, face and depth of each pixel
 *                                                      --composite--> lit colours, depth --read--> planes of a frame
 *
 * The variant ost_gl_mesh draws the visible faces of the voxels as quads instead (thesis 3.3.1):
 *
 *   changed blocks --backend: face meshes (core/face_mesh.h)--> vertices --quads that face the eye--> the same G-buffer
 *
 * By default, the context needs no display (EGL) and belongs to a separate worker thread. The functions may therefore
 * be called on any thread, even one with a window, but only by one thread at a time. If the context of a window is used
 * instead, the picture can be shown without being read back:
 *
 *   lit colours --smooth the edges, lay a sheet over them--> framebuffer of the window          ost_gl_show
 */
#ifndef OST_RENDER_GL_H
#define OST_RENDER_GL_H

#include <osteon/backend.h>

#include "render/points/frame.h"

typedef struct ost_gl ost_gl;

/* The format of the render target for the fragments of voxels. */
typedef enum ost_gl_target {
    OST_GL_COMPACT, /* colour, face and depth in 64 bits per pixel */
    OST_GL_WIDE,    /* normal and colour as 32-bit floats, as in the thesis */
    OST_GL_SMALL,   /* normal and colour, 8 bits each */
    OST_GL_FORWARD  /* the lit colour, without a G-buffer */
} ost_gl_target;

/* A drawing method. The variants other than ost_gl_ours and ost_gl_thesis exist only for comparisons. */
typedef struct ost_gl_variant {
    /* true to draw, as in the thesis, a point for each voxel of each used block, including voxels that are not active;
       requires OST_GL_WIDE */
    bool every_voxel;
    bool frustum;     /* true to skip blocks outside the view frustum */
    bool facing;      /* true to skip points without a face toward the eye */
    bool order;       /* true to draw near blocks first */
    /* true to skip hidden cells of 8^3 voxels; requires `frustum` and OST_GL_COMPACT, and cannot be combined with
       `true_depth` */
    bool occlusion;
    /* true to compute the depths of tiles in a shader even with a software renderer; used only with `occlusion` */
    bool tiles;
    /* if true, a point covers the bounding rectangle of its cube, clipped to the frame; if false, the bounding
       square of the cube's bounding sphere */
    bool tight;
    /* if true, a pixel is tested with linear inequalities on three axes (splat_scalar.c); if false, with the slab
       test of the thesis */
    bool lines;
    /* if true, the fragment shader writes the depth of the hit; if false, the depth is the squared distance of the
       voxel's centre */
    bool true_depth;
    /* true to draw a point for each brick of 4^3 voxels, which the shader traverses; requires `tight` and either
       OST_GL_COMPACT or OST_GL_FORWARD, and cannot be combined with `facing` */
    bool bricks;
    /* true to draw bricks where voxels appear small, and single voxels elsewhere */
    bool choose;
    /* true to draw quads of visible faces instead of points; requires `frustum`, OST_GL_COMPACT and a mesher, and
       cannot be combined with other options */
    bool mesh;
    /* if greater than 0, only blocks with a slot below this number are drawn, to measure the time per block */
    int32_t slots;
    ost_gl_target target;
} ost_gl_variant;

extern const ost_gl_variant ost_gl_ours;
/* Draws as in the thesis: the voxels of the first object as points, and the visible faces of the other objects as
   triangles. Faces are flat in every style. */
extern const ost_gl_variant ost_gl_thesis;
/* Draws quads of visible faces. Requires ost_gl_set_mesher. */
extern const ost_gl_variant ost_gl_mesh;

typedef struct ost_gl_options {
    bool debug;  /* true to enable the driver's messages and report them as errors */
    /* maximum OpenGL version, times ten; 0 means no limit. If the driver does not support this version, an older
       version is used. */
    int version;
    bool hardware; /* true to refuse software renderers */
    /*
     * true to use the context that is current on the calling thread, for example that of a window, instead of a
     * separate context and thread. All functions must then be called on this thread while the context is current. If
     * the context no longer exists, ost_gl_abandon must be called instead of ost_gl_close.
     */
    bool current;
} ost_gl_options;

typedef struct ost_gl_info {
    char version[96];  /* version of OpenGL, for example "4.5 (Core Profile) Mesa 22.3.6" */
    char driver[128];  /* name of the renderer, for example "llvmpipe (LLVM 15.0.6, 256 bits)" */
    char way[48];      /* how the context was opened, for example "EGL without a surface" */
    bool software;     /* true if the renderer is a software renderer */
    bool mapped;       /* true if buffers stay mapped */
    float largest;     /* maximum point size in pixels */
} ost_gl_info;

/* Returns NULL if this build supports OpenGL, otherwise the reason why it does not. */
const char *ost_gl_missing(void);
/* Opens OpenGL. Returns OST_ERR_UNAVAILABLE if this build has no OpenGL, or if EGL, a driver, OpenGL 3.3 or a required
 * graphics card is missing; the message names the missing component. */
ost_status ost_gl_open(const ost_gl_options *options, ost_gl **out, ost_error *err);
void ost_gl_close(ost_gl *gl); /* NULL is allowed */
/* Frees a renderer that was opened with the option `current`, without calling OpenGL. NULL is allowed. */
void ost_gl_abandon(ost_gl *gl);
ost_gl_info ost_gl_info_get(const ost_gl *gl);

/*
 * Sets the backend that makes the meshes of the variant ost_gl_mesh. The backend is borrowed. ost_gl_draw calls it on
 * the worker's thread, so no other thread may use the backend during a call of ost_gl_draw.
 */
void ost_gl_set_mesher(ost_gl *gl, ost_backend *mesher);

/*
 * Draws the same picture as ost_frame_draw_things. First uploads the blocks that have changed since the last call, and
 * smooth meshes that are not uploaded yet. Returns OST_ERR_RANGE under the same conditions as ost_frame_draw_things,
 * and OST_ERR_UNAVAILABLE if OpenGL fails or the context is lost.
 */
ost_status ost_gl_draw(ost_gl *gl, const ost_gl_variant *variant, const ost_frame_thing *things, int count,
                       ost_style style, ost_error *err);
/*
 * The EGL objects that another library needs to use the renderer's context. The pointers have EGL's types and are valid
 * until ost_gl_close is called.
 */
typedef struct ost_gl_egl {
    void *display, *config, *context;
} ost_gl_egl;
ost_gl_egl ost_gl_egl_get(const ost_gl *gl);

/* Calls a function on the thread of the context, and waits for its result. */
typedef ost_status ost_gl_function(void *user, ost_error *err);
ost_status ost_gl_do(ost_gl *gl, ost_gl_function *function, void *user, ost_error *err);

/*
 * Copies the colours of the last picture to a texture of this context, without reading them back. The texture must have
 * the picture's size. Rows are in OpenGL's order: the picture's top row becomes the texture's last row.
 */
ost_status ost_gl_copy(ost_gl *gl, unsigned texture, ost_error *err);

/* A layer of letters and boxes to show over a picture (ost_sheet). */
typedef struct ost_gl_sheet {
    /* pixels 0xAABBGGRR of the picture's size, with colours multiplied by their opacity AA; the first row is the top
       row */
    const uint32_t *pixels;
    int stride;
    /* cells that may differ from the previous sheet; NULL if any cell may differ */
    const ost_cells *changed;
} ost_gl_sheet;

/*
 * Draws the last picture with the sheet over it into a framebuffer of the picture's size; 0 is the framebuffer of a
 * window. If `antialiased` is true, edges are smoothed, bit-identically to ost_antialias.
 */
ost_status ost_gl_show(ost_gl *gl, unsigned framebuffer, bool antialiased, const ost_gl_sheet *sheet, ost_error *err);

/* Waits until drawing is complete. */
ost_status ost_gl_finish(ost_gl *gl, ost_error *err);
/* Copies colours, faces and, if `depth` is true, depths of the last picture to a frame of the same size. The frame's
   keys remain unchanged. */
ost_status ost_gl_read(ost_gl *gl, ost_frame *frame, bool depth, ost_error *err);

/* Numbers that describe the last draw. */
typedef struct ost_gl_counts {
    uint64_t points;   /* number of vertices passed to OpenGL */
    uint64_t uploaded; /* number of bytes of surface data uploaded */
    bool bricks;       /* true if the first object was drawn as bricks */
    /* number of hidden cells of 8^3 voxels that were skipped in those blocks of the first object that are in view */
    uint32_t hidden;
    /* The following values are set only by the variant ost_gl_mesh. */
    uint32_t meshed;   /* number of blocks that were meshed again because their visible faces had changed */
    int64_t mesh_ns;   /* time, in ns, that the mesher takes */
    int64_t copy_ns;   /* time, in ns, to copy vertices and looks to OpenGL's buffers */
    uint64_t quads;    /* number of quads passed to OpenGL */
} ost_gl_counts;
ost_gl_counts ost_gl_counts_get(const ost_gl *gl);

#endif
