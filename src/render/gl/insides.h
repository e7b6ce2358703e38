/* SPDX-License-Identifier: Apache-2.0 */
/* The internal state of the OpenGL renderer, private to the files of this folder. */
#ifndef OST_RENDER_GL_INSIDES_H
#define OST_RENDER_GL_INSIDES_H

#include "render/gl/programs.h"
#include "render/gl/resident.h"
#include "render/gl/target.h"
#include "render/gl/worker.h"

/* An object, and its state while a frame is drawn. */
typedef struct ost_gl_layer {
    const ost_frame_thing *thing;
    ost_splat_eye eye;
    ost_gl_resident *resident;
    ost_gl_form form;
    bool mesh;
    bool smooth;                 /* true if the object's smooth mesh is drawn instead of its voxels */
    GLuint palette, palette_texture;
    /* entries of this layer in the list. begin: index of the first entry; near: number of entries that are drawn as
       quads; count: number of all entries */
    uint32_t begin, near, count;
    int32_t blocks;              /* number of selected blocks */
    /* true to draw the points in the list; false to draw all points of the selected blocks */
    bool listed;
    /* depth_scale: factor that converts a squared distance to a value of the depth buffer; depth_slack: upper bound on
     * the rounding error of this value */
    float depth_scale, depth_slack;
    int y0, y1;
} ost_gl_layer;

/* A buffer that contains a smooth mesh, with the mesh's hash and number of triangles. */
enum { OST_GL_SMOOTH = 16 };
typedef struct ost_gl_smooth_mesh {
    uint64_t hash;
    size_t count;
    GLuint buffer; /* 0 if nothing has been uploaded */
} ost_gl_smooth_mesh;

struct ost_gl {
    ost_gl_worker *worker;  /* thread that owns the context; NULL if the context of the calling thread is used */
    /* The following fields belong to the worker's thread. Other threads may read them only while the worker is idle. */
    bool open;              /* true if the context exists */
    ost_gl_context context;
    ost_gl_store store;
    ost_gl_programs programs;
    ost_gl_targets targets;
    GLuint eyes, vertices;  /* eyes: buffer with the uniforms of all layers; vertices: vertex array */
    GLint eye_stride;
    GLuint list, list_texture;
    void *list_mapped;
    uint32_t list_capacity, list_used;
    uint32_t *numbers;      /* owned; numbers of the points or bricks to draw; list_capacity entries */
    GLuint quad_indices;    /* indices of two triangles for each quad of the largest block */
    uint32_t quad_capacity; /* capacity of quad_indices in quads */
    ost_gl_layer layer[OST_FRAME_LAYERS];
    ost_gl_smooth_mesh smooth[OST_GL_SMOOTH];
    unsigned smooth_next;   /* number of buffers that have been filled so far */
    GLuint sheet;           /* texture of the sheet that was shown last; 0 before the first sheet */
    int sheet_width, sheet_height;
    ost_frame_block *blocks; /* owned; blocks selected for drawing; block_capacity entries */
    float *bases;           /* owned; for each slot, the vector from the eye to the block's first voxel, in 4 floats */
    GLint *firsts;          /* owned; firsts, counts, offsets and wanted have block_capacity entries each */
    GLsizei *counts;        /* owned */
    /* owned; block_capacity null pointers: each block's indices start at offset 0 of quad_indices */
    const void **offsets;
    /* owned; for each selected block, the set of cells to draw next, encoded like ost_gl_run.cells */
    uint64_t *wanted;
    int32_t block_capacity;
    bool tests_depth;       /* true if this frame searches for hidden cells (hide.c) */
    ost_light light;
    ost_directions directions;
    uint32_t palette[OST_OCTAHEDRAL_COUNT + OST_PAINTS];
    /* signalled when OpenGL has completed the last frame; NULL if there is nothing to wait for */
    GLsync fence;
    ost_gl_counts did;
};

#endif
