/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon tool`: writes a parametric cutting tool as a closed mesh.
 */
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "app/input/load.h"
#include "io/mesh/write_any.h"
#include "mesh/surface.h"

static ost_status find_kind(const app_state *app, const char *name, ost_tool_kind *out, ost_error *err)
{
    const char *names[OST_TOOL_KIND_COUNT];
    for (int k = 0; k < OST_TOOL_KIND_COUNT; k++) {
        names[k] = ost_tool_kind_name((ost_tool_kind)k);
        if (strcmp(name, names[k]) == 0) {
            *out = (ost_tool_kind)k;
            return OST_OK;
        }
    }
    const char *near = nearest_name(name, names, OST_TOOL_KIND_COUNT);
    if (near)
        return usage_error(app, err, "'%s' is not a tool; did you mean %s?", name, near);
    return usage_error(app, err, "'%s' is not a tool; expected reamer, peg or burr", name);
}

ost_status cmd_tool(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *kind_name = NULL, *out = NULL;
    ost_tool_options make = {0};
    int64_t segments = 0;
    const operand operands[] = {{"KIND", &kind_name, "no tool named; expected reamer, peg or burr"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_OUTPUT, .out = &out, .value = "FILE", .required = true,
         .help = "the mesh: .stl, .ply or .obj"},
        {.name = "diameter", .kind = OPTION_LENGTH, .out = &make.diameter, .value = "MM",
         .help = "diameter (default: reamer 36, peg 6, burr 6)"},
        {.name = "length", .kind = OPTION_LENGTH, .out = &make.length, .value = "MM",
         .help = "length of the reamer's head, the peg or the burr's shaft (default: 20.3, 30, 20)"},
        {.name = "segments", .kind = OPTION_INTEGER, .out = &segments, .value = "N", .min = 12, .max = 3072,
         .help = "number of facets around the axis, a multiple of 4 from 12 to 3072 (default: 96)"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "KIND --out FILE.stl [options]",
        .about = "Generates a cutting tool as a closed mesh.\n"
                 "\n"
                 "kinds\n"
                 "  reamer  a hemisphere with teeth; by default the head of the thesis\n"
                 "  peg     a cylinder, for a peg hole\n"
                 "  burr    a sphere on a shaft",
        .operands = operands,
        .options = options,
        .notes = "Lengths are in millimetres. The tool cuts towards -z of its own frame: its face\n"
                 "is at z = 0, its shaft along +z.",
        .example = "  osteon tool reamer --out reamer.stl\n  osteon tool peg --diameter 5 --out peg.stl",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    ost_tool_kind kind = OST_TOOL_REAMER;
    if ((status = find_kind(app, kind_name, &kind, err)) != OST_OK ||
        (status = out_check(app, out, "stl|ply|obj", err)) != OST_OK)
        return status;
    make.segments = (int)segments;

    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    status = ost_tool_make(kind, &make, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_write_any(out, &mesh, OST_MESH_OWN, err);
    if (status == OST_OK) {
        char count[FORMAT_TEXT], from[FORMAT_TEXT], to[FORMAT_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_text(app->result, "kind", ost_tool_kind_name(kind));
        put_text(app->result, "out", out);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put(app->result, "bounds_mm",
            json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                      ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        put_real(app->result, "volume_mm3", volume);
        print_line(app, "%s: a %s of %s triangles, %.0f mm3, from %s to %s", out, ost_tool_kind_name(kind),
                   format_count(count, (int64_t)mesh.triangle_count), volume, format_point(from, lo),
                   format_point(to, hi));
    }
    ost_mesh_free(&mesh);
    return status;
}
