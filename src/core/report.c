/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the reports of events and the density classes (AR-REM-7, AR-CLS). */
#include "core/conditions.h"

#include <osteon/event.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ost_removal_report_clear(ost_removal_report *report)
{
    ost_chunk_report *chunks = report->chunks;
    size_t capacity = report->capacity;
    *report = (ost_removal_report){.chunks = chunks, .capacity = capacity};
}

ost_status ost_removal_report_add(ost_removal_report *report, const ost_chunk_report *chunk, ost_error *err)
{
    if (report->count == report->capacity) {
        size_t capacity = report->capacity ? 2 * report->capacity : 64;
        ost_chunk_report *more = realloc(report->chunks, capacity * sizeof *more);
        if (!more)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a report of %zu chunks", capacity);
        report->chunks = more;
        report->capacity = capacity;
    }
    report->chunks[report->count++] = *chunk;
    for (int c = 0; c < OST_CLASS_MAX; c++) {
        report->voxels[c] += chunk->voxels[c];
        report->density[c] += chunk->density[c];
        report->total_voxels += chunk->voxels[c];
    }
    return OST_OK;
}

void ost_removal_report_free(ost_removal_report *report)
{
    if (!report)
        return;
    free(report->chunks);
    *report = (ost_removal_report){0};
}

ost_density_classes ost_density_classes_default(void)
{
    return (ost_density_classes){
        .count = 3,
        .border = {120, 150, 650},
        .name = {"cartilage", "cancellous", "cortical"},
    };
}

ost_status ost_density_classes_check(const ost_density_classes *classes, ost_error *err)
{
    if (classes->count < 1 || classes->count > OST_CLASS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "%d density classes; expected 1 to %d", classes->count, OST_CLASS_MAX);
    if (classes->border[0] < 1)
        return ost_fail(err, OST_ERR_USAGE, "density class 0 begins at %d; an active voxel has 1 or more",
                        classes->border[0]);
    for (int c = 1; c < classes->count; c++)
        if (classes->border[c] <= classes->border[c - 1])
            return ost_fail(err, OST_ERR_USAGE, "density class %d begins at %d, which is not above %d", c,
                            classes->border[c], classes->border[c - 1]);
    return OST_OK;
}

static bool name_is_good(const char *name, size_t length)
{
    return length >= 1 && length < OST_CLASS_NAME && strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_-") >= length;
}

ost_status ost_density_classes_parse(const char *text, ost_density_classes *out, ost_error *err)
{
    ost_density_classes classes = {0};
    for (const char *p = text;;) {
        const char *colon = strchr(p, ':');
        const char *end = p + strcspn(p, ",");
        if (!colon || colon > end || !name_is_good(p, (size_t)(colon - p)))
            return ost_fail(err, OST_ERR_USAGE,
                            "'%.100s': expected NAME:HU,NAME:HU,... with names of a-z, 0-9, - and _", text);
        if (classes.count == OST_CLASS_MAX)
            return ost_fail(err, OST_ERR_USAGE, "'%.100s': at most %d density classes", text, OST_CLASS_MAX);
        ost_decimal decimal;
        int64_t border;
        bool exact = false;
        if (ost_decimal_read(colon + 1, end, &decimal) != end || !ost_decimal_scale(&decimal, 1, &border, &exact) ||
            !exact || border < 1 || border > INT16_MAX)
            return ost_fail(err, OST_ERR_USAGE,
                            "'%.*s' is not a density in HU; expected a whole number from 1 to 32767",
                            (int)(end - colon - 1), colon + 1);
        if (classes.count > 0 && border <= classes.border[classes.count - 1])
            return ost_fail(err, OST_ERR_USAGE, "'%.100s': values in HU must increase", text);
        snprintf(classes.name[classes.count], OST_CLASS_NAME, "%.*s", (int)(colon - p), p);
        classes.border[classes.count++] = (int16_t)border;
        if (*end == 0)
            break;
        p = end + 1;
    }
    *out = classes;
    return OST_OK;
}
