/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the pattern that all differences together form. The code applies the rules by which the validation classifies
 * differences (difference/pattern.h), and further rules that need only the files.
 *
 *   geometry        dims, spacing or origin differ
 *   only-removed    voxels were only removed, as by reaming
 *   only-added      voxels were only added
 *   ...             the patterns of pattern.h, in that order; the class is the first pattern that applies
 */
#include "app/diff/compare.h"

#include <stdarg.h>
#include <stdio.h>

static void add(diff_result *r, const char *name, const char *format, ...) OST_PRINTF(3, 4);
static void add(diff_result *r, const char *name, const char *format, ...)
{
    if (r->pattern_count == DIFF_PATTERN_MAX)
        return;
    diff_pattern *p = &r->patterns[r->pattern_count++];
    p->name = name;
    va_list args;
    va_start(args, format);
    vsnprintf(p->text, sizeof p->text, format, args);
    va_end(args);
}

static void geometry(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    if (r->same_dims && r->same_spacing && r->same_origin)
        return;
    const ost_geometry *ga = &a->volume.geometry, *gb = &b->volume.geometry;
    char text[2][3][OST_PM_TEXT];
    if (!r->same_dims) {
        add(r, "geometry", "dims %d x %d x %d against %d x %d x %d", ga->dims.x, ga->dims.y, ga->dims.z, gb->dims.x,
            gb->dims.y, gb->dims.z);
        return;
    }
    const ost_pm3 va = r->same_spacing ? ga->origin : ga->spacing, vb = r->same_spacing ? gb->origin : gb->spacing;
    add(r, "geometry", "%s (%s, %s, %s) against (%s, %s, %s) mm", r->same_spacing ? "origin" : "spacing",
        ost_pm_format(va.x, text[0][0]), ost_pm_format(va.y, text[0][1]), ost_pm_format(va.z, text[0][2]),
        ost_pm_format(vb.x, text[1][0]), ost_pm_format(vb.y, text[1][1]), ost_pm_format(vb.z, text[1][2]));
}

void diff_patterns(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    const pattern_view view = {.a = a->volume.voxels,
                               .b = b->volume.voxels,
                               .dims = a->volume.geometry.dims,
                               .dims_b = b->volume.geometry.dims,
                               .solid_a = a->threshold,
                               .solid_b = b->threshold,
                               .tool = a->kind == LOAD_TOOL,
                               .chunk = r->chunk_size};
    pattern_list found;
    geometry(a, b, r);
    if (r->same_dims && !r->different)
        return;
    ost_pattern_find(&view, &found);
    if (found.of_all != PATTERN_UNCLASSIFIED || r->same_dims)
        r->class = ost_pattern_name(found.of_all);
    for (int p = 0; p < PATTERNS; p++)
        if (found.holds[p])
            add(r, ost_pattern_name((pattern)p), "%s", found.text[p]);
    if (r->same_dims && r->count[DIFF_REMOVED] == r->different)
        add(r, "only-removed", "B is A with voxels removed, nothing else");
    if (r->same_dims && r->count[DIFF_ADDED] == r->different)
        add(r, "only-added", "B is A with voxels added, nothing else");
}
