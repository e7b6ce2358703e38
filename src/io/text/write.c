/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a volume as text. For speed, positions are formatted once per axis, not once per voxel. A line consists of the
 * text of x, the text " y z " of the row, and the digits of the density.
 */
#include "core/conditions.h"

#include "io/text/write.h"

#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/outfile.h"

/* Buffer sizes: NUMBER for "-8000.123456789" and a blank, LINE for three numbers and "-32768\n". */
enum { NUMBER = 20, LINE = 3 * NUMBER + 8 };

typedef struct number {
    int length;
    char text[NUMBER];
} number;

static int64_t unit_of(int decimals)
{
    int64_t unit = OST_PM_PER_MM;
    for (int i = 0; i < decimals; i++)
        unit /= 10;
    return unit;
}

/*
 * Formats a position, rounded half to even to the unit of the last digit. |value| <= 8 m, so at most four digits
 * precede the decimal point.
 */
static number format_position(ost_pm value, int decimals)
{
    int64_t units = ost_rhe_div(value, unit_of(decimals));
    bool negative = units < 0;
    uint64_t remainder = (uint64_t)(negative ? -units : units);
    char digits[NUMBER];
    int at = NUMBER;
    for (int i = 0; i < decimals; i++, remainder /= 10)
        digits[--at] = (char)('0' + remainder % 10);
    if (decimals > 0)
        digits[--at] = '.';
    do {
        digits[--at] = (char)('0' + remainder % 10);
        remainder /= 10;
    } while (remainder > 0);
    if (negative)
        digits[--at] = '-';
    number n = {.length = NUMBER - at};
    memcpy(n.text, digits + at, (size_t)n.length);
    return n;
}

static number *format_axis(ost_pm origin, ost_pm spacing, int32_t count, int decimals)
{
    number *axis = malloc((size_t)count * sizeof *axis);
    for (int32_t i = 0; axis && i < count; i++)
        axis[i] = format_position(origin + i * spacing, decimals);
    return axis;
}

static char *put(char *to, const char *text, int length)
{
    memcpy(to, text, (size_t)length);
    return to + length;
}

static char *put_density(char *to, int16_t density)
{
    unsigned remainder = density < 0 ? (unsigned)-density : (unsigned)density;
    char digits[6];
    int at = sizeof digits;
    do {
        digits[--at] = (char)('0' + remainder % 10);
        remainder /= 10;
    } while (remainder > 0);
    if (density < 0)
        *to++ = '-';
    return put(to, digits + at, (int)sizeof digits - at);
}

/* Returns the smallest number of decimal places that represents all positions exactly. */
static int decimals_needed(const ost_geometry *g)
{
    const int64_t lengths[6] = {g->origin.x, g->origin.y, g->origin.z, g->spacing.x, g->spacing.y, g->spacing.z};
    int decimals = 0;
    for (int i = 0; i < 6; i++)
        while (lengths[i] % unit_of(decimals) != 0)
            decimals++;
    return decimals;
}

/* Finds the lowest index of a nonzero voxel on each axis. Returns false if all voxels are 0. */
static bool first_voxels(const ost_volume *volume, int32_t lo[3])
{
    const ost_dims dims = volume->geometry.dims;
    const int16_t *voxel = volume->voxels;
    lo[0] = dims.x;
    lo[1] = dims.y;
    lo[2] = dims.z;
    for (int32_t k = 0; k < dims.z; k++)
        for (int32_t j = 0; j < dims.y; j++, voxel += dims.x) {
            int32_t i = 0;
            while (i < dims.x && voxel[i] == 0)
                i++;
            if (i == dims.x)
                continue;
            lo[0] = i < lo[0] ? i : lo[0];
            lo[1] = j < lo[1] ? j : lo[1];
            lo[2] = k < lo[2] ? k : lo[2];
        }
    return lo[2] < dims.z;
}

static ost_status write_facts(ost_outfile *out, const ost_volume *volume, bool omit_empty, ost_error *err)
{
    const ost_geometry *g = &volume->geometry;
    char s[3][OST_PM_TEXT], o[3][OST_PM_TEXT];
    int32_t lo[3] = {0, 0, 0};
    if (omit_empty && !first_voxels(volume, lo))
        return ost_fail(err, OST_ERR_INPUT, "%s: every voxel is empty, so the text would have no line",
                        ost_outfile_path(out));
    ost_status status = OST_OK;
    if (!omit_empty)
        status = ost_outfile_printf(out, err, "# osteon dims: %d %d %d\n", (int)g->dims.x, (int)g->dims.y,
                                    (int)g->dims.z);
    if (status == OST_OK)
        status = ost_outfile_printf(out, err, "# osteon spacing_mm: %s %s %s\n# osteon origin_mm: %s %s %s\n",
                                    ost_pm_format(g->spacing.x, s[0]), ost_pm_format(g->spacing.y, s[1]),
                                    ost_pm_format(g->spacing.z, s[2]),
                                    ost_pm_format(g->origin.x + lo[0] * g->spacing.x, o[0]),
                                    ost_pm_format(g->origin.y + lo[1] * g->spacing.y, o[1]),
                                    ost_pm_format(g->origin.z + lo[2] * g->spacing.z, o[2]));
    for (int i = 0; i < volume->meta.count && status == OST_OK; i++)
        if (!ost_meta_key_is_geometry(volume->meta.entry[i].key))
            status = ost_outfile_printf(out, err, "# osteon %s: %s\n", volume->meta.entry[i].key,
                                        volume->meta.entry[i].value);
    return status;
}

static ost_status write_rows(ost_outfile *out, const ost_volume *volume, const number *x, const number *y,
                             const number *z, bool omit_empty, char *row, ost_error *err)
{
    const ost_dims dims = volume->geometry.dims;
    const int16_t *voxel = volume->voxels;
    ost_status status = OST_OK;
    for (int32_t k = 0; k < dims.z && status == OST_OK; k++) {
        for (int32_t j = 0; j < dims.y && status == OST_OK; j++) {
            char common[2 * NUMBER + 3], *c = common, *to = row;
            *c++ = ' ';
            c = put(c, y[j].text, y[j].length);
            *c++ = ' ';
            c = put(c, z[k].text, z[k].length);
            *c++ = ' ';
            for (int32_t i = 0; i < dims.x; i++) {
                if (omit_empty && *voxel == 0) {
                    voxel++;
                    continue;
                }
                to = put(to, x[i].text, x[i].length);
                to = put(to, common, (int)(c - common));
                to = put_density(to, *voxel++);
                *to++ = '\n';
            }
            status = ost_outfile_write(out, row, (size_t)(to - row), err);
        }
    }
    return status;
}

ost_status ost_text_write_volume(const char *path, const ost_volume *volume, const ost_write_options *options,
                                 ost_error *err)
{
    int decimals = options ? options->text_decimals : 0;
    const bool omit_empty = options && options->omit_empty;
    const ost_geometry *g = &volume->geometry;
    ost_status status = ost_geometry_check(g, path, err);
    if (status != OST_OK)
        return status;
    if (decimals < 0 || decimals > 9)
        return ost_fail(err, OST_ERR_USAGE, "%s: %d decimals; expected 1 to 9, or 0 for as many as needed", path,
                        decimals);
    if (decimals == 0) {
        decimals = decimals_needed(g);
    } else {
        int64_t least = g->spacing.x < g->spacing.y ? g->spacing.x : g->spacing.y;
        least = least < g->spacing.z ? least : g->spacing.z;
        if (4 * unit_of(decimals) > least)
            return ost_fail(err, OST_ERR_USAGE, "%s: %d decimals are too few for voxels of %.9g mm", path, decimals,
                            ost_pm_to_mm(least));
    }

    number *x = format_axis(g->origin.x, g->spacing.x, g->dims.x, decimals);
    number *y = format_axis(g->origin.y, g->spacing.y, g->dims.y, decimals);
    number *z = format_axis(g->origin.z, g->spacing.z, g->dims.z, decimals);
    char *row = malloc((size_t)g->dims.x * LINE);
    ost_outfile *out = NULL;
    if (!x || !y || !z || !row)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory to format %d x %d x %d positions", path,
                          (int)g->dims.x, (int)g->dims.y, (int)g->dims.z);
    if (status == OST_OK)
        status = ost_outfile_open(path, &out, err);
    if (status == OST_OK)
        status = write_facts(out, volume, omit_empty, err);
    if (status == OST_OK)
        status = write_rows(out, volume, x, y, z, omit_empty, row, err);
    if (status == OST_OK)
        status = ost_outfile_commit(out, err);
    else
        ost_outfile_discard(out);
    free(x);
    free(y);
    free(z);
    free(row);
    return status;
}
