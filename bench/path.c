/* SPDX-License-Identifier: Apache-2.0 */
#include "bench/path.h"

#include <math.h>
#include <stdlib.h>

#include "core/quaternion.h"

ost_status bench_path_make(const bench_scene *scene, int count, ost_tick **out, ost_error *err)
{
    const double side = scene->bone.dims.x * ost_pm_to_mm(SCENE_SPACING), feed = 0.02, depth = feed * PATH_TICKS;
    double tilt[4] = {0.97, 0.17, -0.13, 0.11}, step[4] = {256, 0, 0, 1};
    ost_quaternion_unit(tilt);
    ost_quaternion_unit(step);
    /* The direction into the bone, which is the tool's -z axis rotated by `tilt`. */
    double down[3] = {0, 0, -1};
    ost_quaternion_rotate(tilt, down, down);
    /* Halfway along the path, the tool's face is in the middle of the upper part of the bone. At the
       first tick, the tool's face is just inside the bone. */
    const double middle[3] = {side / 2, side / 2, side - depth / 2 * -down[2]};
    double turn[4] = {1, 0, 0, 0};
    ost_tick *ticks = malloc((size_t)count * sizeof *ticks);
    ost_status status = OST_OK;
    *out = ticks;
    if (!ticks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a path of %d ticks", count);
    for (int i = 0; i < count && status == OST_OK; i++) {
        const double s = feed * i - depth / 2;
        const double t[3] = {middle[0] + s * down[0], middle[1] + s * down[1], middle[2] + s * down[2]};
        double q[4];
        ost_quaternion_product(tilt, turn, q);
        ost_quaternion_unit(q);
        ticks[i] = (ost_tick){.t_ns = (int64_t)i * 1000000, .tool = 0, .rpm = OST_RPM_ON};
        status = ost_pose_from_doubles(t, q, &ticks[i].pose, err);
        ost_quaternion_product(turn, step, turn);
        ost_quaternion_unit(turn);
    }
    return status;
}

ost_status bench_sequence_init(bench_sequence *sequence, int count, ost_error *err)
{
    *sequence = (bench_sequence){.best = malloc((size_t)count * sizeof(double)), .count = count};
    if (!sequence->best)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of %d ticks", count);
    for (int i = 0; i < count; i++)
        sequence->best[i] = HUGE_VAL;
    return OST_OK;
}

void bench_sequence_add(bench_sequence *sequence, const double *ns)
{
    double sum = 0;
    for (int i = 0; i < sequence->count; i++) {
        sum += ns[i];
        bench_series_add(&sequence->ticks, ns[i]);
        if (ns[i] < sequence->best[i])
            sequence->best[i] = ns[i];
    }
    bench_series_add(&sequence->means, sum / sequence->count);
}

void bench_sequence_row(bench_sequence *sequence, bench_row *row)
{
    bench_series best = {0};
    for (int i = 0; i < sequence->count; i++)
        bench_series_add(&best, sequence->best[i]);
    bench_row_ours(row, &sequence->means);
    bench_row_extra(row, "ticks", sequence->count);
    bench_row_extra(row, "p50", bench_series_at(&sequence->ticks, 0.5) / 1e3);
    bench_row_extra(row, "p99", bench_series_at(&sequence->ticks, 0.99) / 1e3);
    bench_row_extra(row, "max", bench_series_at(&sequence->ticks, 1) / 1e3);
    bench_row_extra(row, "undisturbed_mean", bench_series_mean(&best) / 1e3);
    bench_row_extra(row, "undisturbed_p99", bench_series_at(&best, 0.99) / 1e3);
    bench_row_extra(row, "undisturbed_max", bench_series_at(&best, 1) / 1e3);
    bench_series_free(&best);
}

void bench_sequence_free(bench_sequence *sequence)
{
    bench_series_free(&sequence->means);
    bench_series_free(&sequence->ticks);
    free(sequence->best);
}
