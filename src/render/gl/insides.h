/* SPDX-License-Identifier: Apache-2.0 */
/* What OpenGL's renderer holds, for the files that make its frames. */
#ifndef OST_RENDER_GL_INSIDES_H
#define OST_RENDER_GL_INSIDES_H

#include "render/gl/programs.h"
#include "render/gl/resident.h"
#include "render/gl/target.h"
#include "render/gl/worker.h"

/* A thing on its way through a frame. */
typedef struct ost_gl_layer {
    const ost_frame_thing *thing;
    ost_splat_eye eye;
    ost_gl_resident *resident;
    ost_gl_form form;
    bool mesh;
    GLuint palette, palette_texture;
    uint32_t begin, near, count; /* in the list: its first entry, how many of them as quads, how many in all */
    int32_t blocks;              /* chosen */
    bool listed;                 /* what is drawn of them stands in the list; else all of it is drawn */
    float depth_scale, depth_slack; /* of a squared distance in a buffer of depths, and how far rounding may be from it */
    int y0, y1;
} ost_gl_layer;

struct ost_gl {
    ost_gl_worker *worker; /* all below is its, but for what is read while it rests */
    ost_gl_context context;
    ost_gl_store store;
    ost_gl_programs programs;
    ost_gl_targets targets;
    GLuint eyes, vertices;  /* uniforms, a vertex array */
    GLint eye_stride;
    GLuint list, list_texture;
    void *list_mapped;
    uint32_t list_room, list_used;
    uint32_t *numbers;      /* owned; of list_room */
    ost_gl_layer layer[OST_FRAME_LAYERS];
    ost_frame_block *blocks; /* owned; of block_room */
    float *bases;           /* owned; 4 a block */
    GLint *firsts;          /* owned; of block_room, and counts */
    GLsizei *counts;
    uint64_t *wanted;       /* likewise: of each of blocks the cells that are listed next, as ost_gl_run has them */
    int32_t block_room;
    bool look;              /* this frame looks who is hidden (hide.c) */
    ost_light light;
    ost_directions directions;
    uint32_t palette[OST_OCTAHEDRAL_COUNT + OST_PAINTS];
    GLsync fence;           /* of the last frame; NULL: none, or waited for */
    ost_gl_counts did;
};

#endif
