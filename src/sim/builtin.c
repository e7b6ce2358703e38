/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Generates the built-in paths: the peg hole, then reaming (thesis 2.5).
 *
 *        approach            advance        dwell     retreat
 *   -8 mm -------> 0 (face) --------> depth ----> depth -------> -8 mm
 *         20 um per tick     feed
 *
 * The working face of the tool, that is, its lowest point along -z, moves along the inward axis of the glenoid. The
 * poses are poses of the hand. The motor's rotation is added to them (motor.h). A tick lasts 1 ms.
 *
 *   peg-hole      22 mm deep at 10 mm/s: within the vault, which is 25 to 30 mm deep
 *   glenoid-ream  3 mm deep at 1.5 mm/s: through 2 mm of cartilage and into the subchondral
 *                 plate, which is 1.2 to 2.9 mm thick; the remaining part of the plate
 *                 carries the implant (facts and sources: docs/spec/arithmetic.md, AR-CLS)
 *
 *   glenoid-slow  the depth of glenoid-ream in a minute, starting close to the face, so that the
 *                 tool is always in contact; for tests of the servo loop and of devices
 *   glenoid-press the target of a hand that presses the tool, moves it along an ellipse and tilts it,
 *                 for a minute or a given number of ticks; the target lies in the bone, so the path
 *                 requires a force (press.h)
 *
 * Depths are integers. The code uses only + - * /, rint and sqrt of doubles. Every machine rounds these operations in
 * the same way, so a path is the same on every machine.
 */
#include "core/conditions.h"

#include <osteon/sim.h>

#include <math.h>
#include <string.h>

#include "core/quaternion.h"
#include "core/vector.h"
#include "sim/press.h"

enum { TICK_NS = 1000000, PRESS_TICKS = 60000 };

#define UM (OST_PM_PER_MM / 1000)

/* A path. Distances are measured from the glenoid's face along the inward axis; speeds are per tick. */
typedef struct plan {
    const char *name;
    ost_pm outside, approach;
    ost_pm depth, feed;
    int dwell; /* number of ticks at the maximum depth */
    ost_pm retreat;
} plan;

static const plan plans[OST_BUILTIN_GLENOID_PRESS] = {
    [OST_BUILTIN_PEG_HOLE] = {"peg-hole", -8000 * UM, 20 * UM, 22000 * UM, 10 * UM, 200, 20 * UM},
    [OST_BUILTIN_GLENOID_REAM] = {"glenoid-ream", -8000 * UM, 20 * UM, 3000 * UM, 3 * UM / 2, 400, 20 * UM},
    [OST_BUILTIN_GLENOID_SLOW] = {"glenoid-slow", -2000 * UM, 20 * UM, 3000 * UM, UM / 20, 400, 20 * UM},
};

const char *ost_builtin_name(ost_builtin which)
{
    if (which == OST_BUILTIN_GLENOID_PRESS)
        return "glenoid-press";
    return (unsigned)which < OST_BUILTIN_COUNT ? plans[which].name : "unknown";
}

/* Computes the rotation that maps the working direction, -z, to the unit vector a. */
static void facing(const double a[3], double q[4])
{
    const double half_turn[4] = {0, 1, 0, 0}, up[4] = {1 - a[2], a[1], -a[0], 0}, down[4] = {1 + a[2], -a[1], a[0], 0};
    memcpy(q, a[2] <= 0 ? up : down, sizeof up);
    ost_quaternion_unit(q);
    /* Half a turn about x maps -z to +z. The remaining rotation is less than a quarter turn. */
    if (a[2] > 0)
        ost_quaternion_product(q, half_turn, q);
}

static double mm(ost_pm value)
{
    return (double)value / (double)OST_PM_PER_MM;
}

/* Returns the x or y coordinate of the tool's axis. It is 0 if the grid's range [lo, hi] contains 0; otherwise, it
   is the middle of this range. */
static double axis_of(ost_pm lo, ost_pm hi)
{
    return lo <= 0 && hi >= 0 ? 0 : mm(lo) / 2 + mm(hi) / 2;
}

/*
 * Computes the point of the tool that moves along the axis. By Alg. 2.1, the lowest vertex of the mesh is one to
 * two voxels above the lower corner of the grid. This function uses the middle of this range, 3/2 voxels.
 */
static void working_point(const ost_tool_geometry *g, double tip[3])
{
    tip[0] = axis_of(g->corner.x, g->corner.x + g->dims.x * g->voxel);
    tip[1] = axis_of(g->corner.y, g->corner.y + g->dims.y * g->voxel);
    tip[2] = mm(g->corner.z + 3 * g->voxel / 2);
}

static int64_t ticks_for(ost_pm distance, ost_pm speed)
{
    return (distance + speed - 1) / speed;
}

/* Returns the depth at tick k. The depth is a piecewise linear function of time. */
static ost_pm depth_at(const plan *p, int64_t k)
{
    int64_t approach = ticks_for(-p->outside, p->approach), advance = ticks_for(p->depth, p->feed);
    if (k < approach)
        return p->outside + k * p->approach;
    k -= approach;
    if (k < advance)
        return k * p->feed;
    k -= advance;
    if (k < p->dwell)
        return p->depth;
    ost_pm depth = p->depth - (k - p->dwell) * p->retreat;
    return depth > p->outside ? depth : p->outside;
}

static int64_t tick_count(const plan *p)
{
    return ticks_for(-p->outside, p->approach) + ticks_for(p->depth, p->feed) + p->dwell +
           ticks_for(p->depth - p->outside, p->retreat) + 1;
}

static ost_status unit_axis(const ost_glenoid *glenoid, double out[3], ost_error *err)
{
    const double *a = glenoid->axis;
    double largest = fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
    if (!isfinite(a[0]) || !isfinite(a[1]) || !isfinite(a[2]) || !(largest > 0))
        return ost_fail(err, OST_ERR_USAGE, "the glenoid's axis (%g, %g, %g) is not a direction", a[0], a[1], a[2]);
    for (int i = 0; i < 3; i++)
        out[i] = a[i] / largest;
    ost_vector_unit(out, 2);
    return OST_OK;
}

/*
 * Converts a pose to integers. q has unit length, so its components times 2^30 fit into int32; rint rounds half to
 * even.
 */
static ost_status quantised(const double t[3], const double q[4], ost_pose *out, ost_error *err)
{
    if (!ost_pm_from_binary(t[0], &out->t.x) || !ost_pm_from_binary(t[1], &out->t.y) ||
        !ost_pm_from_binary(t[2], &out->t.z))
        return ost_fail(err, OST_ERR_RANGE, "the path leaves the range of 8 m around the bone's origin");
    out->qw = (int32_t)rint(q[0] * OST_Q30_ONE);
    out->qx = (int32_t)rint(q[1] * OST_Q30_ONE);
    out->qy = (int32_t)rint(q[2] * OST_Q30_ONE);
    out->qz = (int32_t)rint(q[3] * OST_Q30_ONE);
    return ost_pose_check(out, err);
}

/* Values that all built-in paths use. */
typedef struct start {
    double at[3], axis[3], tip[3];
    double face[4]; /* rotation that maps -z to the axis */
} start;

static ost_status begin(const ost_glenoid *glenoid, const ost_tool_geometry *geometry, size_t ticks, start *s,
                        ost_path *out, ost_error *err)
{
    ost_status status = unit_axis(glenoid, s->axis, err);
    if (status == OST_OK)
        status = ost_tool_geometry_check(geometry, err);
    if (status == OST_OK)
        status = ost_path_init(out, ticks, err);
    if (status != OST_OK)
        return status;
    s->at[0] = mm(glenoid->at.x);
    s->at[1] = mm(glenoid->at.y);
    s->at[2] = mm(glenoid->at.z);
    working_point(geometry, s->tip);
    facing(s->axis, s->face);
    return OST_OK;
}

/*
 * Computes the pose with the orientation q at which the tool's tip has the given depth along the axis and the
 * offset `sideways` from the axis.
 */
static ost_status make_pose(const start *s, const double q[4], double depth, const double sideways[3], ost_pose *out,
                            ost_error *err)
{
    double r[3], t[3];
    ost_quaternion_rotate(q, s->tip, r);
    for (int a = 0; a < 3; a++)
        t[a] = s->at[a] + depth * s->axis[a] + sideways[a] - r[a];
    return quantised(t, q, out, err);
}

ost_status ost_builtin_press(const ost_glenoid *glenoid, const ost_tool_geometry *geometry, int32_t tool, size_t ticks,
                             ost_path *out, ost_error *err)
{
    start s;
    press_load load;
    *out = (ost_path){0};
    if (ticks == 0 || ticks > OST_PATH_TICKS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a path of %zu ticks; expected 1 to %d", ticks, OST_PATH_TICKS_MAX);
    ost_status status = begin(glenoid, geometry, ticks, &s, out, err);
    ost_press_begin(&load);
    for (size_t k = 0; k < ticks && status == OST_OK; k++) {
        ost_press_go_on(&load, (int64_t)k);
        double sideways[3] = {load.across[0], load.across[1], 0}, q[4] = {1, load.lean[0], load.lean[1], 0};
        ost_quaternion_rotate(s.face, sideways, sideways);
        ost_quaternion_unit(q);
        ost_quaternion_product(s.face, q, q);
        ost_quaternion_unit(q);
        out->ticks[k] = (ost_tick){.t_ns = (int64_t)k * TICK_NS, .tool = tool, .rpm = OST_RPM_OF_DEVICE};
        status = make_pose(&s, q, load.depth, sideways, &out->ticks[k].pose, err);
    }
    if (status != OST_OK)
        ost_path_free(out);
    return status;
}

ost_status ost_builtin_path(ost_builtin which, const ost_glenoid *glenoid, const ost_tool_geometry *geometry,
                            int32_t tool, ost_path *out, ost_error *err)
{
    start s;
    *out = (ost_path){0};
    if ((unsigned)which >= OST_BUILTIN_COUNT)
        return ost_fail(err, OST_ERR_USAGE, "no built-in path %d; there are %d", (int)which, OST_BUILTIN_COUNT);
    if (which == OST_BUILTIN_GLENOID_PRESS)
        return ost_builtin_press(glenoid, geometry, tool, PRESS_TICKS, out, err);
    const plan *p = &plans[which];
    const double centre[3] = {0, 0, 0};
    ost_status status = begin(glenoid, geometry, (size_t)tick_count(p), &s, out, err);
    if (status == OST_OK)
        ost_quaternion_unit(s.face);
    for (size_t k = 0; status == OST_OK && k < out->count; k++) {
        out->ticks[k] = (ost_tick){.t_ns = (int64_t)k * TICK_NS, .tool = tool, .rpm = OST_RPM_OF_DEVICE};
        status = make_pose(&s, s.face, mm(depth_at(p, (int64_t)k)), centre, &out->ticks[k].pose, err);
    }
    if (status != OST_OK)
        ost_path_free(out);
    return status;
}
