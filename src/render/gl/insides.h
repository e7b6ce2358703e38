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
    GLuint palette, palette_texture;
    /* in the list: index of the first entry, number of entries drawn as quads, total number of entries */
    uint32_t begin, near, count;
    int32_t blocks;              /* number of selected blocks */
    /* set if the list contains the points to draw; otherwise all points of the blocks are drawn */
    bool listed;
    /* scale of a squared distance in the depth buffer, and a bound of its rounding error */
    float depth_scale, depth_slack;
    int y0, y1;
} ost_gl_layer;

struct ost_gl {
    /* all following fields belong to the worker's thread; other threads read them only while it is
       idle */
    ost_gl_worker *worker;
    ost_gl_context context;
    ost_gl_store store;
    ost_gl_programs programs;
    ost_gl_targets targets;
    GLuint eyes, vertices;  /* uniform buffers, vertex array */
    GLint eye_stride;
    GLuint list, list_texture;
    void *list_mapped;
    uint32_t list_capacity, list_used;
    uint32_t *numbers;      /* owned; list_capacity entries */
    ost_gl_layer layer[OST_FRAME_LAYERS];
    ost_frame_block *blocks; /* owned; block_capacity entries */
    float *bases;           /* owned; 4 for each block */
    GLint *firsts;          /* owned; block_capacity entries, as are counts and wanted */
    GLsizei *counts;        /* owned */
    uint64_t *wanted;       /* owned; for each block the cells to list next, with the bits of ost_gl_run.cells */
    int32_t block_capacity;
    bool tests_depth;       /* set if this frame searches for hidden cells (hide.c) */
    ost_light light;
    ost_directions directions;
    uint32_t palette[OST_OCTAHEDRAL_COUNT + OST_PAINTS];
    /* signalled when the last frame has been drawn; NULL if there is none or it has already been
       waited for */
    GLsync fence;
    ost_gl_counts did;
};

#endif
