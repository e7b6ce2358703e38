/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Building blocks of the parametric tools: points on a circle, square roots, and a
 * closed surface (skin) made of rings from a lower pole to an upper pole.
 *
 *        .  upper pole
 *       / \
 *      o---o  ring m-1        every ring has `segments` points, counter-
 *      |   |                  clockwise seen from +z; neighbouring rings are
 *      o---o  ring 0          joined by two triangles per segment; the skin
 *       \ /                   is closed and faces outward by construction
 *        .  lower pole
 *
 * Only integers are used, so a tool is the same on every machine, to the picometre.
 */
#ifndef OST_PHANTOM_TOOL_SHAPE_H
#define OST_PHANTOM_TOOL_SHAPE_H

#include <osteon/phantom.h>

/* A number in [-4, 4], multiplied by 2^60. */
typedef int64_t ost_q60;
#define OST_Q60_ONE (INT64_C(1) << 60)

/*
 * Returns numerator / denominator as an ost_q60, rounded half to even. Requires 0 <= numerator <= 4 * denominator
 * and denominator >= 1.
 */
ost_q60 ost_q60_ratio(int64_t numerator, int64_t denominator);
/* Returns a * b / 2^60, rounded half to even. */
int64_t ost_q60_times(int64_t a, ost_q60 b);

/*
 * Computes the cosine and the sine of k/n of a turn, each with an error of at most 2^-56. The results are exactly
 * symmetric under reflections in the axes and in the diagonals, and exact at quarter turns. n must be at least 1.
 */
void ost_circle(int64_t k, int64_t n, ost_q60 *cosine, ost_q60 *sine);

/* Returns floor(sqrt(n)) for 0 <= n < 2^126. */
int64_t ost_isqrt(unsigned __int128 n);

typedef struct ost_skin {
    int segments;
    int rings;
    int filled;     /* number of rings made so far */
    ost_mesh *mesh; /* vertices in this order: lower pole, rings, upper pole */
} ost_skin;

/* Allocates the mesh, and sets its triangles and its two poles, which lie on the axis. rings must be at least 1. */
ost_status ost_skin_init(ost_skin *skin, ost_mesh *mesh, int segments, int rings, ost_pm bottom, ost_pm top,
                         ost_error *err);
/* Returns memory for the points of the next ring. The caller must write these points. */
ost_pm3 *ost_skin_ring(ost_skin *skin);
void ost_skin_circle(ost_skin *skin, ost_pm radius, ost_pm z);

/*
 * The functions that make a tool, one for each kind. All lengths must be set and within 0.1 mm to 1 m. segments must be
 * within OST_TOOL_SEGMENTS_MIN to OST_TOOL_SEGMENTS_MAX.
 */
enum { OST_TOOL_SEGMENTS_MIN = 12, OST_TOOL_SEGMENTS_MAX = 3072 };
ost_status ost_tool_make_reamer(const ost_tool_options *options, ost_mesh *out, ost_error *err);
ost_status ost_tool_make_peg(const ost_tool_options *options, ost_mesh *out, ost_error *err);
ost_status ost_tool_make_burr(const ost_tool_options *options, ost_mesh *out, ost_error *err);

#endif
