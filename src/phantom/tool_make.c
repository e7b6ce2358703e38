/* SPDX-License-Identifier: Apache-2.0 */
/* Makes parametric tools of each kind, with their defaults and limits. */
#include <string.h>

#include "phantom/tool_shape.h"

static const struct {
    const char *name;
    ost_pm diameter, length;
    ost_status (*make)(const ost_tool_options *options, ost_mesh *out, ost_error *err);
} kinds[OST_TOOL_KIND_COUNT] = {
    [OST_TOOL_REAMER] = {"reamer", 36 * OST_PM_PER_MM, 203 * OST_PM_PER_MM / 10, ost_tool_make_reamer},
    [OST_TOOL_PEG] = {"peg", 6 * OST_PM_PER_MM, 30 * OST_PM_PER_MM, ost_tool_make_peg},
    [OST_TOOL_BURR] = {"burr", 6 * OST_PM_PER_MM, 20 * OST_PM_PER_MM, ost_tool_make_burr},
};

const char *ost_tool_kind_name(ost_tool_kind kind)
{
    return (unsigned)kind < OST_TOOL_KIND_COUNT ? kinds[kind].name : "unknown";
}

static ost_status check_length(const char *kind, const char *what, ost_pm value, ost_error *err)
{
    char text[OST_PM_TEXT];
    if (value < OST_PM_PER_MM / 10 || value > 1000 * OST_PM_PER_MM)
        return ost_fail(err, OST_ERR_USAGE, "%s: a %s of %s mm is outside 0.1 to 1000 mm", kind, what,
                        ost_pm_format(value, text));
    return OST_OK;
}

bool ost_tool_has_shaft(ost_tool_kind kind)
{
    return kind == OST_TOOL_REAMER || kind == OST_TOOL_BURR;
}

ost_status ost_tool_make(ost_tool_kind kind, const ost_tool_options *options, ost_mesh *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    if ((unsigned)kind >= OST_TOOL_KIND_COUNT)
        return ost_fail(err, OST_ERR_USAGE, "no tool of kind %d; known are reamer, peg and burr", (int)kind);
    ost_tool_options o = options ? *options : (ost_tool_options){0};
    if (o.part == OST_TOOL_SHAFT && !ost_tool_has_shaft(kind))
        return ost_fail(err, OST_ERR_USAGE, "a %s has no shaft", kinds[kind].name);
    if (o.diameter == 0)
        o.diameter = kinds[kind].diameter;
    if (o.length == 0)
        o.length = kinds[kind].length;
    if (o.segments == 0)
        o.segments = 96;
    ost_status status = check_length(kinds[kind].name, "diameter", o.diameter, err);
    if (status == OST_OK)
        status = check_length(kinds[kind].name, "length", o.length, err);
    if (status != OST_OK)
        return status;
    if (o.segments < OST_TOOL_SEGMENTS_MIN || o.segments > OST_TOOL_SEGMENTS_MAX || o.segments % 4)
        return ost_fail(err, OST_ERR_USAGE, "%s: %d segments; expected a multiple of 4 from %d to %d",
                        kinds[kind].name, o.segments, OST_TOOL_SEGMENTS_MIN, OST_TOOL_SEGMENTS_MAX);
    return kinds[kind].make(&o, out, err);
}
