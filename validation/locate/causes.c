/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/causes.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* The table contains the results of `osteon validate --faults-only --tier standard --json` with seed 1, in which
   2,767 mistakes changed a result. The test test_locate computes the table again. */
static const causes known[] = {
    {"byte-order", 49, 1, {{"byte-order", 49}}},
    {"axis-swap", 66, 2, {{"swapped-axis", 64}, {"excluded-crossing", 2}}},
    {"shift", 173, 7, {{"layer-off-by-one", 61}, {"chunk-shifted", 49}, {"other-rule", 35}}},
    {"row-pitch", 62, 1, {{"padded-pitch", 62}}},
    {"threshold", 132, 6, {{"unsigned-compare", 45}, {"inactive-kept", 43}, {"wrong-threshold", 35}}},
    {"stale-chunk", 60, 1, {{"stale-chunk", 60}}},
    {"lost-tail", 130, 5, {{"last-layer-lost", 54}, {"dropped-last-items", 51}, {"last-chunk-lost", 22}}},
    {"lost-chunk", 180, 9, {{"partial-chunks-lost", 63}, {"transposed-matrix", 32}, {"last-chunk-lost", 31}}},
    {"column-parity", 488, 11, {{"triangles-lost", 63}, {"culled-back-faces", 57}, {"missing-edge", 56}}},
    {"tool-class", 22, 2, {{"noncutting-on-top", 21}, {"parity-for-winding", 1}}},
    {"boundary-layer", 266, 22, {{"corner-for-centre", 47}, {"omitted-sweep-step", 26}, {"excluded-crossing", 21}}},
    {"carried-rows", 20, 1, {{"uncleared-counts", 20}}},
    {"speckle", 338, 22, {{"flip-bit", 63}, {"garbage-in-void", 48}, {"saturated-short", 48}}},
    {"unclassified", 420, 31, {{"off-by-one-dims", 59}, {"thesis-f32", 38}, {"thesis-f32-fma", 37}}},
    {"report-only", 361, 23, {{"lost-chunk-report", 62}, {"occupancy-not-cleared", 57}, {"report-overwritten", 47}}},
};

const causes *causes_of(const char *class)
{
    for (size_t i = 0; class && i < sizeof known / sizeof known[0]; i++)
        if (strcmp(known[i].class, class) == 0)
            return &known[i];
    return NULL;
}

void causes_text(const char *class, char out[CAUSES_TEXT])
{
    const causes *c = causes_of(class);
    int n = 0, named = 0;
    out[0] = '\0';
    if (!c)
        return;
    n = snprintf(out, CAUSES_TEXT, "possible causes, by %d known mistakes that look like this:", c->mistakes);
    for (; named < CAUSES_NAMED && c->most[named].kind; named++)
        n += snprintf(out + n, CAUSES_TEXT - (size_t)n, "%s %s %d %%", named ? "," : "", c->most[named].kind,
                      (100 * c->most[named].mistakes + c->mistakes / 2) / c->mistakes);
    if (c->kinds > named)
        snprintf(out + n, CAUSES_TEXT - (size_t)n, ", %d other kind%s", c->kinds - named,
                 c->kinds - named == 1 ? "" : "s");
}
