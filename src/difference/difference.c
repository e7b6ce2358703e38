/* SPDX-License-Identifier: Apache-2.0 */
/* Implements ost_difference_find: checks the arguments, finds the patterns that hold, and copies them to the result. */
#include <osteon/difference.h>

#include <stdio.h>

#include "difference/pattern.h"

_Static_assert((int)PATTERNS <= (int)OST_DIFFERENCE_PATTERNS_MAX, "every pattern fits the public struct");
_Static_assert((int)PATTERN_TEXT == (int)OST_DIFFERENCE_TEXT, "the evidence of a pattern fits the public struct");

static ost_status check_threshold(int32_t value, const char *name, ost_error *err)
{
    return value >= 0 && value <= INT16_MAX
               ? OST_OK
               : ost_fail(err, OST_ERR_RANGE, "threshold_%s %d: expected 0 to %d", name, (int)value, INT16_MAX);
}

static ost_status check(const ost_volume *a, const ost_volume *b, const ost_difference_options *o, ost_error *err)
{
    if (!a->voxels || !b->voxels)
        return ost_fail(err, OST_ERR_USAGE, "difference: volume %s has no voxels", a->voxels ? "b" : "a");
    const ost_dims d = a->geometry.dims;
    if (o->before) {
        const ost_dims e = o->before->geometry.dims;
        if (!o->before->voxels || e.x != d.x || e.y != d.y || e.z != d.z)
            return ost_fail(err, OST_ERR_USAGE, "difference: 'before' has %d x %d x %d voxels; expected %d x %d x %d",
                            e.x, e.y, e.z, d.x, d.y, d.z);
    }
    if (o->chunk_size != 0 && o->chunk_size != 16 && o->chunk_size != 32 && o->chunk_size != 64)
        return ost_fail(err, OST_ERR_USAGE, "difference: chunk size %d; expected 16, 32 or 64", o->chunk_size);
    const ost_status status = check_threshold(o->threshold_a, "a", err);
    return status == OST_OK ? check_threshold(o->threshold_b, "b", err) : status;
}

static void count_voxels(const ost_volume *a, const ost_volume *b, ost_difference *out)
{
    const ost_dims d = a->geometry.dims;
    int64_t i = 0;
    for (int32_t z = 0; z < d.z; z++)
        for (int32_t y = 0; y < d.y; y++)
            for (int32_t x = 0; x < d.x; x++, i++) {
                if (a->voxels[i] == b->voxels[i])
                    continue;
                const int32_t at[3] = {x, y, z};
                for (int axis = 0; axis < 3; axis++) {
                    if (out->voxels == 0 || at[axis] < out->box.lo[axis])
                        out->box.lo[axis] = at[axis];
                    if (out->voxels == 0 || at[axis] >= out->box.hi[axis])
                        out->box.hi[axis] = at[axis] + 1;
                }
                out->voxels++;
            }
}

ost_status ost_difference_find(const ost_volume *a, const ost_volume *b, const ost_difference_options *options,
                               ost_difference *out, ost_error *err)
{
    enum { THRESHOLD = 120, CHUNK = 32 };
    const ost_difference_options o = options ? *options : (ost_difference_options){0};
    *out = (ost_difference){0};
    const ost_status status = check(a, b, &o, err);
    if (status != OST_OK)
        return status;
    const int32_t lowest = o.tool ? 1 : THRESHOLD;
    const pattern_view view = {.a = a->voxels,
                               .b = b->voxels,
                               .dims = a->geometry.dims,
                               .dims_b = b->geometry.dims,
                               .solid_a = o.threshold_a ? o.threshold_a : lowest,
                               .solid_b = o.threshold_b ? o.threshold_b : lowest,
                               .tool = o.tool,
                               .chunk = o.chunk_size ? o.chunk_size : CHUNK,
                               .input = o.before ? PATTERN_BEFORE : PATTERN_NO_INPUT,
                               .in = o.before ? o.before->voxels : NULL,
                               .in_dims = o.before ? o.before->geometry.dims : (ost_dims){0, 0, 0},
                               .reported_too = o.report_differs};
    const ost_dims d = view.dims, e = view.dims_b;
    const bool same_dims = d.x == e.x && d.y == e.y && d.z == e.z;
    if (same_dims)
        count_voxels(a, b, out);
    if (same_dims && out->voxels == 0)
        return OST_OK;
    pattern_list found;
    ost_pattern_find(&view, &found);
    out->class_name = ost_pattern_name(found.of_all);
    for (int p = 0; p < PATTERNS; p++)
        if (found.holds[p]) {
            ost_difference_pattern *to = &out->patterns[out->pattern_count++];
            to->name = ost_pattern_name((pattern)p);
            snprintf(to->text, sizeof to->text, "%s", found.text[p]);
        }
    return OST_OK;
}
