/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures how the tool was moved, from the removal, tool position and force of each tick.
 *
 *   ticks in contact  .:::.:.::      ::::::.     intervals less than GAP_S apart are merged
 *                     '-------'      '-----'
 *
 * Speeds are averaged over WINDOW_S. The length of a path is measured between positions that are
 * PLACE_S apart in time, because movements on shorter time scales are noise of the encoder.
 */
#include <osteon/metrics.h>

#include <math.h>
#include <stdlib.h>

#include "core/vector.h"

#define GAP_S 0.2
#define PASS_GAP_S 0.5
#define WINDOW_S 0.05
#define PLACE_S 0.02
#define FELT_N 0.05

static bool touches(const ost_motion *m)
{
    return m->removed > 0 || m->touched > 0 || m->force_n >= FELT_N;
}

static bool cuts(const ost_motion *m)
{
    return m->removed > 0;
}

/*
 * Finds the intervals in which the function is() returns true. Intervals less than gap_s apart are merged. Returns the
 * number of intervals and adds their durations to *seconds. Unless the array `in` is NULL, in[i] is set to true for
 * each tick i in an interval.
 */
static int spells(const ost_motion *m, size_t count, bool (*is)(const ost_motion *), double gap_s, double *seconds,
                  bool *in)
{
    int number = 0;
    size_t first = 0, last = 0;
    for (size_t i = 0; i < count; i++) {
        if (in)
            in[i] = false;
        if (!is(&m[i]))
            continue;
        if (number == 0 || m[i].t_s - m[last].t_s >= gap_s) {
            number++;
            first = i;
        }
        for (size_t k = last > first ? last : first; in && k <= i; k++)
            in[k] = true;
        *seconds += first < i ? m[i].t_s - m[last].t_s : 0;
        last = i;
    }
    return number;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void forces(const ost_motion *m, size_t count, const bool *in, double *scratch, ost_technique *out)
{
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        out->force_max_n = fmax(out->force_max_n, m[i].force_n);
        if (!in[i])
            continue;
        out->force_mean_n += m[i].force_n;
        scratch[n++] = m[i].force_n;
    }
    out->felt = out->force_max_n > 0;
    if (n == 0)
        return;
    out->force_mean_n /= (double)n;
    qsort(scratch, n, sizeof *scratch, ascending);
    out->force_p95_n = scratch[(n - 1) * 95 / 100];
}

static void plunges(const ost_motion *m, size_t count, const bool *in, const double w[3], ost_technique *out)
{
    size_t from = 0, broken = 0; /* broken: first tick since contact began or the tool changed */
    bool fast = false;
    double begun = 0;
    for (size_t i = 0; i < count; i++) {
        if (!in[i]) {
            broken = i + 1;
            fast = false;
            continue;
        }
        if (i > 0 && m[i].tool != m[i - 1].tool)
            broken = i;
        from = from < broken ? broken : from;
        while (from < i && m[i].t_s - m[from + 1].t_s >= WINDOW_S - 1e-9)
            from++;
        const double span = m[i].t_s - m[from].t_s;
        double depth[2] = {0, 0}, speed = 0;
        for (int a = 0; a < 3; a++) {
            depth[0] += m[from].mm[a] * w[a];
            depth[1] += m[i].mm[a] * w[a];
        }
        if (span >= WINDOW_S - 1e-9)
            speed = (depth[1] - depth[0]) / span;
        out->inward_max_mm_s = fmax(out->inward_max_mm_s, speed);
        if (speed > OST_PLUNGE_MM_S && !fast) {
            out->plunges++;
            begun = depth[0];
        }
        /*
         * The end threshold is well below the start threshold. With equal thresholds, a speed that varies around the
         * limit would be counted as many plunges.
         */
        fast = speed > (fast ? OST_PLUNGE_END_MM_S : OST_PLUNGE_MM_S);
        if (fast)
            out->plunge_mm = fmax(out->plunge_mm, depth[1] - begun);
    }
}

ost_status ost_technique_make(const ost_motion *motion, size_t count, const ost_metrics_plan *plan, ost_technique *out,
                              ost_error *err)
{
    const double size = sqrt(plan->axis[0] * plan->axis[0] + plan->axis[1] * plan->axis[1] +
                             plan->axis[2] * plan->axis[2]);
    const double w[3] = {plan->axis[0] / size, plan->axis[1] / size, plan->axis[2] / size};
    *out = (ost_technique){0};
    if (count == 0)
        return OST_OK;
    bool *in = malloc(count * sizeof *in);
    double *scratch = malloc(count * sizeof *scratch);
    if (!in || !scratch) {
        free(in);
        free(scratch);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the technique of %zu ticks", count);
    }
    out->passes = spells(motion, count, cuts, PASS_GAP_S, &out->cutting_s, NULL);
    out->contacts = spells(motion, count, touches, GAP_S, &out->contact_s, in);
    out->seconds = motion[count - 1].t_s - motion[0].t_s;
    size_t previous = 0, tilts = 0;
    for (size_t i = 0; i < count; i++) {
        if (in[i]) {
            const double along = motion[i].axis[0] * w[0] + motion[i].axis[1] * w[1] + motion[i].axis[2] * w[2];
            const double tilt = acos(fmax(-1, fmin(1, along))) * 180 / 3.14159265358979323846;
            out->tilt_mean_deg += tilt;
            out->tilt_max_deg = fmax(out->tilt_max_deg, tilt);
            tilts++;
        }
        if (motion[i].tool != motion[previous].tool) {
            previous = i; /* the distance between the positions of two tools is not part of the path */
        } else if (motion[i].t_s - motion[previous].t_s >= PLACE_S - 1e-9 || i + 1 == count) {
            const double way = ost_vector_distance(motion[i].mm, motion[previous].mm);
            out->path_mm += way;
            out->contact_path_mm += in[i] && in[previous] ? way : 0;
            previous = i;
        }
    }
    out->tilt_mean_deg /= tilts ? (double)tilts : 1;
    forces(motion, count, in, scratch, out);
    plunges(motion, count, in, w, out);
    free(in);
    free(scratch);
    return OST_OK;
}
