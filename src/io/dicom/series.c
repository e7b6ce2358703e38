/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/series.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

char *ost_dicom_series_name(const ost_dicom_group *group, char text[OST_DICOM_SERIES_NAME])
{
    if (group->numbered)
        snprintf(text, OST_DICOM_SERIES_NAME, "series %" PRId32, group->number);
    else
        snprintf(text, OST_DICOM_SERIES_NAME, "the series without a number");
    return text;
}

static bool matches(const ost_dicom_group *group, const char *wanted)
{
    char number[16];
    snprintf(number, sizeof number, "%" PRId32, group->number);
    return (group->numbered && strcmp(wanted, number) == 0) ||
           (group->description[0] && strcmp(wanted, group->description) == 0) ||
           (group->uid[0] && strcmp(wanted, group->uid) == 0);
}

/*
 * Returns the error for a series that is not a volume. If an image of the series cannot be read, returns the error of
 * that image's file, because the image may be a missing slice.
 */
static ost_status too_few(const ost_dicom_scan *scan, size_t series, ost_error *err)
{
    char name[OST_DICOM_SERIES_NAME];
    const ost_dicom_group *group = &scan->series[series];
    for (size_t i = 0; i < scan->frame_count; i++)
        if (scan->frames[i].series == series && scan->frames[i].result != OST_DICOM_RESULT_OK)
            return ost_dicom_refuse(scan->files.path[scan->frames[i].file], scan->frames[i].result, err);
    ost_dicom_series_name(group, name);
    if (group->images == 1)
        return ost_fail(err, OST_ERR_INPUT, "%s: %s has one image; a volume needs at least two slices", scan->path,
                        name);
    return ost_fail(err, OST_ERR_INPUT, "%s: %s has no image that can be a slice of a CT", scan->path, name);
}

/* Returns the error for a folder that contains several volumes. The message lists the numbers of their series. */
static ost_status several(const ost_dicom_scan *scan, size_t count, ost_error *err)
{
    char numbers[160] = "";
    size_t n = 0;
    for (size_t s = 0; s < scan->series_count && n < sizeof numbers - 16; s++) {
        const ost_dicom_group *group = &scan->series[s];
        if (group->images >= 2 && group->numbered)
            n += (size_t)snprintf(numbers + n, sizeof numbers - n, "%s%" PRId32, n ? ", " : "", group->number);
    }
    const bool all = n < sizeof numbers - 16;
    return ost_fail(err, OST_ERR_INPUT,
                    "%s: contains %zu series that are volumes%s%s%s%s; select one with --series; 'osteon info %s' "
                    "lists them",
                    scan->path, count, n ? " (numbers " : "", numbers, n && !all ? ", ..." : "", n ? ")" : "",
                    scan->path);
}

ost_status ost_dicom_series_select(const ost_dicom_scan *scan, const char *wanted, size_t *out, ost_error *err)
{
    size_t count = 0;
    for (size_t s = 0; s < scan->series_count; s++) {
        if (wanted ? matches(&scan->series[s], wanted) : scan->series[s].images >= 2) {
            *out = s;
            count++;
        }
    }
    if (wanted && count == 0 && scan->series_count)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: no series has the number, description or UID '%.64s'; 'osteon info %s' lists them",
                        scan->path, wanted, scan->path);
    if (wanted && count > 1)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %zu series match --series '%.64s'; pass the UID that 'osteon info %s' lists", scan->path,
                        count, wanted, scan->path);
    if (count > 1)
        return several(scan, count, err);
    if (count == 1)
        return scan->series[*out].images >= 2 ? OST_OK : too_few(scan, *out, err);
    if (scan->series_count == 0 && scan->files.count == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the folder contains no file; expected DICOM images, or TIFF or PNG "
                        "slices", scan->path);
    if (scan->series_count == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: contains no DICOM image; %zu file%s examined; a pattern such as "
                        "'%s/*.tif' selects slices among other files", scan->path, scan->files.count,
                        scan->files.count == 1 ? " was" : "s were", scan->path);
    for (size_t s = 0; s < scan->series_count; s++)
        if (scan->series[s].images)
            return too_few(scan, s, err);
    return too_few(scan, 0, err);
}
