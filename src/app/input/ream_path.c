/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/ream_path.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/result.h"
#include "app/common/print.h"
#include "app/input/load.h"
#include "core/integer.h"

enum { GAP_NS = 1000000 };

ost_status target_side(const target_options *options, const ost_meta *meta, const char *bone, ost_side *out,
                       ost_error *err)
{
    const ost_side given = !options->side_given ? OST_SIDE_UNKNOWN
                           : options->side == 0 ? OST_SIDE_LEFT
                                                : OST_SIDE_RIGHT;
    ost_status status = ost_side_from_meta(meta, out, err);
    if (status == OST_OK && given != OST_SIDE_UNKNOWN && *out != OST_SIDE_UNKNOWN && given != *out) {
        const char *name = given == OST_SIDE_LEFT ? "left" : "right";
        return ost_fail(
            err, OST_ERR_INPUT,
            "--side %s contradicts %s, whose header has side %s; 'osteon info %s --set side=%s' corrects it", name,
            bone, *out == OST_SIDE_LEFT ? "left" : "right", bone, name);
    }
    *out = given == OST_SIDE_UNKNOWN ? *out : given;
    return status;
}

ost_status target_find(const app_state *app, const target_options *options, const ost_meta *meta, const char *bone,
                       ost_glenoid *out, ost_error *err)
{
    ost_side side;
    bool has_at = true, has_axis = true;
    *out = (ost_glenoid){.at = options->at};
    memcpy(out->axis, options->axis, sizeof out->axis);
    ost_status status = options->at_given ? OST_OK
                                          : ost_point_from_meta(meta, OST_META_GLENOID_AT, &out->at, &has_at, err);
    if (status == OST_OK && !options->axis_given)
        status = ost_axis_from_meta(meta, out->axis, &has_axis, err);
    if (status != OST_OK) {
        ost_fail_context(err, "%s", bone);
        return status;
    }
    const char *const missing =
        has_at     ? "axis is not set: pass --axis X,Y,Z (into the bone), or import with --axis"
        : has_axis ? "position is not set: pass --at X,Y,Z, or import with --at or --landmarks"
                   : "position and axis are not set: pass --at X,Y,Z and --axis X,Y,Z (into the bone), or import with "
                     "--at or --landmarks";
    if (!has_at || !has_axis)
        return usage_error(app, err, "%s: the glenoid's %s", bone, missing);
    status = target_side(options, meta, bone, &side, err);
    if (status == OST_OK && (status = ost_glenoid_side(out->axis, side, &out->left, err)) != OST_OK)
        ost_fail_context(err, "%s", bone);
    return status;
}

static ost_status builtin_path(const app_state *app, const char *name, const target_options *target,
                               const ost_meta *meta, const char *bone, const ost_tool_geometry *tool, int32_t index,
                               ost_path *out, ost_error *err)
{
    const char *names[OST_BUILTIN_COUNT];
    for (int b = 0; b < OST_BUILTIN_COUNT; b++) {
        names[b] = ost_builtin_name((ost_builtin)b);
        if (strcmp(name, names[b]) == 0) {
            ost_glenoid glenoid;
            ost_status status = target_find(app, target, meta, bone, &glenoid, err);
            if (status != OST_OK)
                return status;
            if (b == OST_BUILTIN_GLENOID_PRESS && target->press_ticks)
                return ost_builtin_press(&glenoid, tool, index, target->press_ticks, out, err);
            return ost_builtin_path((ost_builtin)b, &glenoid, tool, index, out, err);
        }
    }
    const char *near = nearest_name(name, names, OST_BUILTIN_COUNT);
    return usage_error(app, err, "--path builtin:%s: unknown path; did you mean builtin:%s?", name,
                       near ? near : names[0]);
}

/* Reads a file of ticks. If all ticks refer to tool 0, changes them to refer to tool number `index` (AR-PATH-6). */
static ost_status file_path(const app_state *app, const char *name, int32_t index, int tool_count,
                            const ost_path_options *gaps, ost_path *out, ream_gaps *counted, ost_error *err)
{
    /* If the type of a file cannot be determined, for example because the file is a pipe, the file is read as text. */
    ost_file_kind kind;
    const bool known = ost_file_kind_find(name, &kind, NULL) == OST_OK;
    ost_path_report report = {0};
    ost_status status = known && kind == OST_FILE_SESSION ? load_session_path(app, name, out, err)
                                                          : ost_path_read(name, gaps, out, &report, err);
    if (status != OST_OK)
        return status;
    int32_t last = 0;
    for (size_t i = 0; i < out->count; i++)
        last = out->ticks[i].tool > last ? out->ticks[i].tool : last;
    if (last >= tool_count) {
        ost_path_free(out);
        return ost_fail(err, OST_ERR_INPUT, "%s: a tick uses tool %d; tools are numbered from 0, and %d %s given with "
                        "--tool", name, last, tool_count, tool_count == 1 ? "is" : "are");
    }
    for (size_t i = 0; i < out->count; i++) {
        out->ticks[i].tool = last == 0 ? index : out->ticks[i].tool;
        counted->gaps += i > 0 && out->ticks[i].lifted;
    }
    counted->lost_rows += report.lost_rows;
    return OST_OK;
}

/*
 * Appends the path `part` to the path `all`. The first appended tick is GAP_NS after the last tick of `all` and is
 * lifted (AR-PATH-6).
 */
static ost_status join(ost_path *all, const ost_path *part, ost_error *err)
{
    if (part->count > OST_PATH_TICKS_MAX - all->count)
        return ost_fail(err, OST_ERR_RANGE, "the paths together have more than %d ticks", OST_PATH_TICKS_MAX);
    const ost_i128 shift = all->count ? (ost_i128)all->ticks[all->count - 1].t_ns + GAP_NS - part->ticks[0].t_ns
                                        : 0;
    const ost_i128 end = part->ticks[part->count - 1].t_ns + shift;
    if (all->count && end > OST_PATH_TIME_MAX_NS)
        return ost_fail(err, OST_ERR_RANGE, "the paths together last until %.9g s; expected times up to 4 * 10^9 s",
                        (double)end * 1e-9);
    ost_tick *ticks = realloc(all->ticks, (all->count + part->count) * sizeof *ticks);
    if (!ticks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu ticks", all->count + part->count);
    all->ticks = ticks;
    for (size_t i = 0; i < part->count; i++) {
        ost_tick *tick = &ticks[all->count + i];
        *tick = part->ticks[i];
        tick->t_ns = (int64_t)(part->ticks[i].t_ns + shift);
        tick->lifted |= i == 0 && all->count > 0;
    }
    all->count += part->count;
    return OST_OK;
}

ost_status ream_path_make(const app_state *app, const option_list *paths, const target_options *target,
                          const ost_meta *meta, const char *bone, const ost_tool_geometry *const *tools, int tool_count,
                          const ost_path_options *gaps, ost_path *out, ream_gaps *counted, ost_error *err)
{
    *out = (ost_path){0};
    *counted = (ream_gaps){0};
    ost_status status = OST_OK;
    for (int k = 0; k < paths->count && status == OST_OK; k++) {
        ost_path part = {0};
        const char *name = paths->value[k];
        int32_t index = tool_count == 1 ? 0 : k;
        if (strncmp(name, "builtin:", 8) == 0)
            status = builtin_path(app, name + 8, target, meta, bone, tools[index], index, &part, err);
        else
            status = file_path(app, name, index, tool_count, gaps, &part, counted, err);
        if (status == OST_OK && part.count)
            status = join(out, &part, err);
        ost_path_free(&part);
    }
    if (status == OST_OK && out->count == 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: has no ticks", paths->value[0]);
    if (status != OST_OK)
        ost_path_free(out);
    return status;
}

/*
 * Converts a rate in hertz to a period in nanoseconds, rounded down. The computation uses only integers, because the
 * period determines which ticks remove bone.
 */
ost_status ream_period(const app_state *app, const option_decimal *rate, int64_t *period_ns, ost_error *err)
{
    int64_t micro;
    *period_ns = 0;
    if (!rate->text)
        return OST_OK;
    if (!ost_decimal_scale(&rate->value, 1000000, &micro, NULL) || micro < 1000 || micro > INT64_C(1000000000000))
        return usage_error(app, err, "--rate %s: must be from 0.001 to 1000000 Hz", rate->text);
    *period_ns = INT64_C(1000000000000000) / micro;
    return OST_OK;
}

/* largest values of --max-gap: one hour, and 8 m */
enum { GAP_MS_MAX = 3600000, JUMP_UM_MAX = 8000000 };

ost_status ream_max_gap(const app_state *app, const char *text, ost_path_options *out, ost_error *err)
{
    ost_decimal ms, mm;
    *out = (ost_path_options){0};
    if (!text)
        return OST_OK;
    if (strcmp(text, "off") == 0) {
        *out = (ost_path_options){OST_PATH_NO_GAPS, OST_PATH_NO_GAPS};
        return OST_OK;
    }
    const char *end = text + strlen(text), *p = ost_decimal_read(text, end, &ms);
    bool right = p && ost_decimal_scale(&ms, 1000000, &out->max_gap_ns, NULL) && out->max_gap_ns > 0 &&
                 out->max_gap_ns <= GAP_MS_MAX * INT64_C(1000000);
    if (right && *p == ',')
        right = (p = ost_decimal_read(p + 1, end, &mm)) && ost_decimal_to_pm(&mm, &out->max_jump_pm, NULL) &&
                out->max_jump_pm > 0 && out->max_jump_pm <= JUMP_UM_MAX * (OST_PM_PER_MM / 1000);
    if (!right || p != end)
        return usage_error(app, err, "--max-gap %s: must be MS or MS,MM, up to %d ms and %d mm, or off", text,
                           GAP_MS_MAX, JUMP_UM_MAX / 1000);
    return OST_OK;
}

void ream_print_gaps(const app_state *app, const ream_gaps *gaps)
{
    char a[FORMAT_TEXT];
    put_integer(app->result, "gaps", (int64_t)gaps->gaps);
    put_integer(app->result, "lost_rows", (int64_t)gaps->lost_rows);
    if (gaps->gaps)
        print_line(app, "  %s gap%s in the path, across which nothing was cut", format_count(a, (int64_t)gaps->gaps),
                   gaps->gaps == 1 ? "" : "s");
}
