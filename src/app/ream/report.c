/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the results of `osteon ream`, and adds them to its JSON object. */
#include "app/ream/ream.h"

#include <stdlib.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

static int ascending(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Sorts tick_ns, and reports percentiles of the durations by the nearest-rank method. */
static void put_tick_times(const app_state *app, ream_job *j)
{
    size_t n = j->path.count;
    qsort(j->tick_ns, n, sizeof *j->tick_ns, ascending);
    double p50 = j->tick_ns[(n - 1) * 50 / 100] * 1e-3;
    double p99 = j->tick_ns[(n - 1) * 99 / 100] * 1e-3;
    double max = j->tick_ns[n - 1] * 1e-3;
    put(app->result, "tick_us", json_pack("{s:f,s:f,s:f}", "p50", p50, "p99", p99, "max", max));
    print_line(app, "  a tick: %.4g us median, %.4g us at 99 %%, %.4g us at most", p50, p99, max);
}

static void put_classes(const app_state *app, const ost_world_totals *totals, const ost_density_classes *classes,
                        double voxel_mm3)
{
    json_t *array = json_array();
    char text[FORMAT_TEXT];
    for (int c = 0; c < classes->count; c++) {
        int64_t voxels = (int64_t)totals->removed_by_class[c];
        json_t *row = json_object();
        put_text(row, "name", classes->name[c]);
        put_integer(row, "from_hu", classes->border[c]);
        put_integer(row, "voxels", voxels);
        put_real(row, "mm3", (double)voxels * voxel_mm3);
        put_integer(row, "density_sum", totals->density_by_class[c]);
        append(array, row);
        if (voxels)
            print_line(app, "  %-12s %12s voxels %10.1f mm3, %.0f HU on average", classes->name[c],
                       format_count(text, voxels), (double)voxels * voxel_mm3,
                       (double)totals->density_by_class[c] / (double)voxels);
    }
    put(app->result, "removed_by_class", array);
}

/* Warns that nothing was removed, and prints the positions of bone and tool. The usual cause is a
   wrong coordinate system. */
static void warn_nothing(const app_state *app, const ream_job *j)
{
    ost_pm3 lo = j->before.geometry.origin, hi = lo;
    const ost_pm3 at = j->path.ticks[j->path.count / 2].pose.t;
    hi.x += j->before.geometry.spacing.x * (j->before.geometry.dims.x - 1);
    hi.y += j->before.geometry.spacing.y * (j->before.geometry.dims.y - 1);
    hi.z += j->before.geometry.spacing.z * (j->before.geometry.dims.z - 1);
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    warn(app,
         "no bone was removed: the tool %s; the bone's grid is from %s to %s; halfway along its path the tool was at "
         "(%.2f, %.2f, %.2f) mm",
         j->met ? "entered the grid but touched no bone" : "did not reach the grid", format_point(a, lo),
         format_point(b, hi), ost_pm_to_mm(at.x), ost_pm_to_mm(at.y), ost_pm_to_mm(at.z));
}

ost_status ream_take_results(const ream_args *args, ream_job *j, ost_error *err)
{
    const ost_write_options write = {.compress = args->compress, .progress = progress_show};
    ost_status status = ost_bone_digest(j->bone, NULL, &j->root, err);
    if (status == OST_OK)
        status = ost_bone_info_get(j->bone, &j->after, err);
    if (status == OST_OK)
        status = start_check_end(&j->site, j->bone, err);
    if (status == OST_OK)
        status = ost_bone_write(args->out, j->bone, &j->imported.meta, &write, err);
    return status;
}

ost_status ream_report(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    ost_digest file;
    ost_world_totals totals;
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    ost_status status = file_digest(args->out, &file, err);
    if (status != OST_OK)
        return status;
    ost_world_totals_get(j->world, &totals);
    double voxel = ost_pm_to_mm(j->before.geometry.spacing.x), mm3 = voxel * voxel * voxel;
    json_t *o = app->result;
    put_text(o, "bone", args->bone);
    put_text(o, "out", args->out);
    put_integer(o, "ticks", (int64_t)totals.ticks);
    put_integer(o, "removals", (int64_t)totals.removals);
    put_integer(o, "poses", (int64_t)totals.poses);
    put_integer(o, "removed_voxels", (int64_t)totals.removed_voxels);
    put_real(o, "removed_mm3", (double)totals.removed_voxels * mm3);
    put_integer(o, "active_voxels_before", j->before.active_voxels);
    put_integer(o, "active_voxels", j->after.active_voxels);
    put_integer(o, "active_chunks", j->after.active_chunks);
    put_integer(o, "chunk", j->before.chunk_size);
    put_real(o, "run_ms", j->run_ms);
    if (!totals.removed_voxels)
        warn_nothing(app, j);
    print_line(app, "%s: %s of %s bone voxels removed, %.1f mm3", args->out,
               format_count(a, (int64_t)totals.removed_voxels), format_count(b, j->before.active_voxels),
               (double)totals.removed_voxels * mm3);
    put_classes(app, &totals, ost_world_classes(j->world), mm3);
    start_check_report(app, &j->site, mm3);
    print_line(app, "  %s ticks, %s removals, in %s", format_count(a, (int64_t)totals.ticks),
               format_count(b, (int64_t)totals.removals), format_time(c, j->run_ms));
    ream_print_gaps(app, &j->gaps);
    put_tick_times(app, j);
    put_digest(o, "sha256", &j->root);
    put_digest(o, "file_sha256", &file);
    char hex[OST_DIGEST_HEX];
    print_line(app, "  grid %s", ost_digest_hex(&j->root, hex));
    return OST_OK;
}
