/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/programs.h"

#include <stdio.h>

#include "render/gl/embedded.h"
#include "render/points/antialias.h"

enum { TEXT = 512 };

static const char *const samplers[] = {"pages",  "points",  "palette", "seen",   "list",
                                       "shades", "normals", "colours", "depths", "picture", "sheet", NULL};

void ost_gl_programs_free(ost_gl_programs *programs)
{
    for (int i = 0; i < programs->count; i++)
        glDeleteProgram(programs->made[i].program);
    programs->count = 0;
}

static bool same(const ost_gl_program_key *a, const ost_gl_program_key *b)
{
    return a->stage == b->stage && a->target == b->target && a->every_voxel == b->every_voxel && a->tight == b->tight &&
           a->lines == b->lines && a->true_depth == b->true_depth && a->quads == b->quads && a->first == b->first &&
           a->antialiased == b->antialiased && a->page_bits == b->page_bits;
}

static ost_status make(ost_gl_context *c, const ost_gl_program_key *key, GLuint *out, ost_error *err)
{
    const ost_gl_source sources[][2] = {
        [OST_GL_STAGE_POINTS] = {{"point.vert", ost_gl_point_vert, ost_gl_point_vert_count},
                                 {"point.frag", ost_gl_point_frag, ost_gl_point_frag_count}},
        [OST_GL_STAGE_BRICKS] = {{"brick.vert", ost_gl_brick_vert, ost_gl_brick_vert_count},
                                 {"brick.frag", ost_gl_brick_frag, ost_gl_brick_frag_count}},
        [OST_GL_STAGE_MESH] = {{"mesh.vert", ost_gl_mesh_vert, ost_gl_mesh_vert_count},
                               {"mesh.frag", ost_gl_mesh_frag, ost_gl_mesh_frag_count}},
        [OST_GL_STAGE_QUADS] = {{"quad.vert", ost_gl_quad_vert, ost_gl_quad_vert_count},
                                {"quad.frag", ost_gl_quad_frag, ost_gl_quad_frag_count}},
        [OST_GL_STAGE_SMOOTH] = {{"smooth.vert", ost_gl_smooth_vert, ost_gl_smooth_vert_count},
                                 {"smooth.frag", ost_gl_smooth_frag, ost_gl_smooth_frag_count}},
        [OST_GL_STAGE_COMPOSITE] = {{"whole.vert", ost_gl_whole_vert, ost_gl_whole_vert_count},
                                    {"composite.frag", ost_gl_composite_frag, ost_gl_composite_frag_count}},
        [OST_GL_STAGE_WIDE] = {{"whole.vert", ost_gl_whole_vert, ost_gl_whole_vert_count},
                               {"composite_wide.frag", ost_gl_composite_wide_frag, ost_gl_composite_wide_frag_count}},
        [OST_GL_STAGE_TILES] = {{"whole.vert", ost_gl_whole_vert, ost_gl_whole_vert_count},
                                {"tiles.frag", ost_gl_tiles_frag, ost_gl_tiles_frag_count}},
        [OST_GL_STAGE_SHOW] = {{"whole.vert", ost_gl_whole_vert, ost_gl_whole_vert_count},
                               {"show.frag", ost_gl_show_frag, ost_gl_show_frag_count}},
    };
    static const char *const point[] = {"point", NULL}, *const density[] = {"density", NULL},
                             *const brick[] = {"brick", NULL};
    static const char *const mesh[] = {"corner", "out_of_it", NULL}, *const none[] = {NULL},
                             *const quad[] = {"corner", NULL};
    const char *const *inputs = key->stage == OST_GL_STAGE_BRICKS  ? brick
                                : key->stage == OST_GL_STAGE_MESH || key->stage == OST_GL_STAGE_SMOOTH ? mesh
                                : key->stage == OST_GL_STAGE_QUADS ? quad
                                : key->stage != OST_GL_STAGE_POINTS || key->quads ? none
                                : key->every_voxel ? density
                                                   : point;
    char defines[TEXT];
    snprintf(defines, sizeof defines,
             "#define COMPACT %d\n#define WIDE %d\n#define SMALL %d\n#define FORWARD %d\n#define TARGET %d\n#define "
             "EVERY_VOXEL %d\n#define TIGHT %d\n"
             "#define LINES %d\n#define TRUE_DEPTH %d\n#define QUADS %d\n#define FIRST %d\n#define PAGE_BITS %u\n"
             "#define ANTIALIASED %d\n#define RUN %d\n#define LEAST %d\n",
             OST_GL_COMPACT, OST_GL_WIDE, OST_GL_SMALL, OST_GL_FORWARD, key->target, key->every_voxel, key->tight,
             key->lines, key->true_depth, key->quads, key->first, key->page_bits, key->antialiased,
             OST_ANTIALIAS_RUN, OST_ANTIALIAS_LEAST);
    return ost_gl_program_make(c, &sources[key->stage][0], &sources[key->stage][1], defines, inputs, samplers, out,
                               err);
}

ost_status ost_gl_programs_use(ost_gl_context *context, ost_gl_programs *programs, const ost_gl_program_key *key,
                               GLint *first, ost_error *err)
{
    int i = 0;
    while (i < programs->count && !same(&programs->made[i].key, key))
        i++;
    if (i == programs->count) {
        GLuint program;
        if (i == OST_GL_PROGRAMS)
            return ost_fail(err, OST_ERR_INTERNAL, "more than %d programs of OpenGL", OST_GL_PROGRAMS);
        ost_status status = make(context, key, &program, err);
        if (status != OST_OK)
            return status;
        programs->made[i].key = *key;
        programs->made[i].program = program;
        programs->made[i].first = glGetUniformLocation(program, "first");
        programs->count++;
    }
    glUseProgram(programs->made[i].program);
    if (first)
        *first = programs->made[i].first;
    return OST_OK;
}
