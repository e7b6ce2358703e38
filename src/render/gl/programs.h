/* SPDX-License-Identifier: Apache-2.0 */
/* The programs that a variant needs, each made when it is first asked for. */
#ifndef OST_RENDER_GL_PROGRAMS_H
#define OST_RENDER_GL_PROGRAMS_H

#include "render/gl/program.h"

typedef enum ost_gl_stage { OST_GL_STAGE_POINTS, OST_GL_STAGE_BRICKS, OST_GL_STAGE_MESH, OST_GL_STAGE_COMPOSITE, OST_GL_STAGE_WIDE, OST_GL_STAGE_TILES } ost_gl_stage;

/* What a sampler reads stands at its own unit in every program. */
typedef enum ost_gl_unit {
    OST_GL_UNIT_PAGES,
    OST_GL_UNIT_POINTS,
    OST_GL_UNIT_PALETTE,
    OST_GL_UNIT_SEEN,
    OST_GL_UNIT_LIST,
    OST_GL_UNIT_LOOKS,
    OST_GL_UNIT_NORMALS,
    OST_GL_UNIT_COLOURS,
    OST_GL_UNIT_DEPTHS
} ost_gl_unit;

/* What is defined before a stage's shaders. */
typedef struct ost_gl_program_key {
    ost_gl_stage stage;
    ost_gl_target target;
    bool every_voxel, tight, lines, true_depth, quads, first;
    unsigned page_bits;
} ost_gl_program_key;

enum { OST_GL_PROGRAMS = 64 };

typedef struct ost_gl_programs {
    int count;
    struct {
        ost_gl_program_key key;
        GLuint program;
        GLint first; /* the uniform of quads; -1: none */
    } made[OST_GL_PROGRAMS];
} ost_gl_programs;

void ost_gl_programs_free(ost_gl_programs *programs);
/* In use from now on; *first as above, may be NULL. */
ost_status ost_gl_programs_use(ost_gl_context *context, ost_gl_programs *programs, const ost_gl_program_key *key, GLint *first, ost_error *err);

#endif
