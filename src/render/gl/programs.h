/* SPDX-License-Identifier: Apache-2.0 */
/* The programs that a variant needs. Each program is compiled when it is first used. */
#ifndef OST_RENDER_GL_PROGRAMS_H
#define OST_RENDER_GL_PROGRAMS_H

#include "render/gl/program.h"

typedef enum ost_gl_stage {
    OST_GL_STAGE_POINTS,
    OST_GL_STAGE_BRICKS,
    OST_GL_STAGE_MESH,
    OST_GL_STAGE_QUADS,
    OST_GL_STAGE_SMOOTH,
    OST_GL_STAGE_COMPOSITE,
    OST_GL_STAGE_WIDE,
    OST_GL_STAGE_TILES,
    OST_GL_STAGE_SHOW
} ost_gl_stage;

/* The texture units of the samplers, which are the same in all programs. */
typedef enum ost_gl_unit {
    OST_GL_UNIT_PAGES,
    OST_GL_UNIT_POINTS,
    OST_GL_UNIT_PALETTE,
    OST_GL_UNIT_SEEN,
    OST_GL_UNIT_LIST,
    OST_GL_UNIT_SHADES,
    OST_GL_UNIT_NORMALS,
    OST_GL_UNIT_COLOURS,
    OST_GL_UNIT_DEPTHS,
    OST_GL_UNIT_PICTURE,
    OST_GL_UNIT_SHEET
} ost_gl_unit;

/* The settings that are passed to the shaders of a stage as macros. */
typedef struct ost_gl_program_key {
    ost_gl_stage stage;
    ost_gl_target target;
    bool every_voxel, tight, lines, true_depth, quads, first, antialiased;
    unsigned page_bits;
} ost_gl_program_key;

enum { OST_GL_PROGRAMS = 64 };

typedef struct ost_gl_programs {
    int count;
    struct {
        ost_gl_program_key key;
        GLuint program;
        /* location of the uniform `first`, which is used for quads; -1 if the program has no such uniform */
        GLint first;
    } made[OST_GL_PROGRAMS];
} ost_gl_programs;

void ost_gl_programs_free(ost_gl_programs *programs);
/* Makes a program current, and compiles it on first use. Unless `first` is NULL, sets *first to the location of the
 * uniform `first` in the program. */
ost_status ost_gl_programs_use(ost_gl_context *context, ost_gl_programs *programs, const ost_gl_program_key *key,
                               GLint *first, ost_error *err);

#endif
