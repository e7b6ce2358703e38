/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of the suite `render` that draw with OpenGL. They are the frame of the thesis, the frame of osteon, and the
   steps between the two. */
#ifndef OST_BENCH_RENDER_GL_H
#define OST_BENCH_RENDER_GL_H

#include "bench/bench.h"
#include "render/points/frame.h"

typedef struct bench_gl bench_gl;

/* Returns true if the filter may select a row whose name starts with render/gl/. */
bool bench_gl_wanted(const char *filter);
/* Opens OpenGL. If OpenGL is unavailable, the function still succeeds, and every row contains the reason. */
ost_status bench_gl_open(bench_gl **out, ost_error *err);
void bench_gl_close(bench_gl *gl); /* gl may be NULL */
/* Adds the rows of one view, which have the names render/gl/VIEW/... */
ost_status bench_gl_view(bench_gl *gl, const bench_options *options, bench_table *table, const char *view,
                         const ost_surface *surface, const ost_camera *camera, ost_isa isa, ost_error *err);

#endif
