/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/slices.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"

/* A slice that lies within 1 um of the requested position is used unchanged. */
static const ost_pm SAME = OST_PM_PER_MM / 1000;

/* -------------------------------------------------------------- resampling */

void ost_dicom_shear(const int16_t *from, int32_t columns, int32_t rows, const ost_pm drift[2], const ost_pm spacing[2],
                     const int32_t margin[2], const int32_t sizes[2], int16_t *to)
{
    /* Pixel 0 of the result lies at -margin * spacing - drift in the slice. On axis a, this position is whole[a] pixels
     * plus part[a], with 0 <= part[a] < spacing[a]. */
    int64_t whole[2], part[2], rest[2];
    for (int a = 0; a < 2; a++) {
        const int64_t at = -margin[a] * spacing[a] - drift[a];
        whole[a] = ost_floor_div(at, spacing[a]);
        part[a] = at - whole[a] * spacing[a];
        rest[a] = spacing[a] - part[a];
    }
    const ost_i128 area = (ost_i128)spacing[0] * spacing[1];
    for (int32_t j = 0; j < sizes[1]; j++) {
        const int64_t y = j + whole[1];
        const bool inside = y >= 0 && y + (part[1] > 0) < rows;
        for (int32_t i = 0; i < sizes[0]; i++) {
            const int64_t x = i + whole[0];
            int16_t *out = &to[(int64_t)j * sizes[0] + i];
            if (!inside || x < 0 || x + (part[0] > 0) >= columns) {
                *out = OST_DICOM_AIR;
                continue;
            }
            /* A spacing is below 2^37, so |upper|, |lower| < 2^53, and the weighted sum of both is below 2^91. */
            const int16_t *p = from + y * columns + x, *q = part[1] ? p + columns : p;
            const int64_t upper = p[0] * rest[0] + p[part[0] > 0] * part[0];
            const int64_t lower = q[0] * rest[0] + q[part[0] > 0] * part[0];
            *out = part[0] ? (int16_t)ost_rhe_div128((ost_i128)upper * rest[1] + (ost_i128)lower * part[1], area)
                           : (int16_t)ost_rhe_div(p[0] * rest[1] + q[0] * part[1], spacing[1]);
        }
    }
}

static int64_t greatest_divisor(int64_t a, int64_t b)
{
    while (b) {
        const int64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

void ost_dicom_mix(const int16_t *before, const int16_t *after, size_t count, int64_t part, int64_t gap, int16_t *to)
{
    const int64_t common = greatest_divisor(gap, part), p = part / common, g = gap / common, r = g - p;
    /* Positions in a file are usually multiples of 1 um, so g, which is `gap` divided by the greatest common divisor
     * of `gap` and `part`, is usually small enough for 64-bit arithmetic. */
    if (g < INT64_C(1) << 46)
        for (size_t i = 0; i < count; i++)
            to[i] = (int16_t)ost_rhe_div(before[i] * r + after[i] * p, g);
    else
        for (size_t i = 0; i < count; i++)
            to[i] = (int16_t)ost_rhe_div128((ost_i128)before[i] * r + (ost_i128)after[i] * p, g);
}

/* ------------------------------------------------------------------ slices */

/* Converts `count` cells of the slice that was read last, beginning with cell `from`. */
static ost_status convert(ost_dicom_slices *s, size_t from, size_t count, int16_t *out, ost_error *err)
{
    int32_t value = 0;
    const size_t done = ost_dicom_convert(&s->table, s->images.cells + from, count, out, &value);
    if (done == count)
        return OST_OK;
    const ost_dicom_stack *stack = s->images.stack;
    const int64_t slice = (int64_t)s->frame->columns * s->frame->rows;
    char location[OST_LOCATION_TEXT];
    ost_bad bad = {.kind = OST_BAD_RANGE};
    ost_rows source = {.converter = s->rows.converter, .sizes = {s->frame->columns, s->frame->rows, 1}};
    snprintf(bad.value, sizeof bad.value, "value %d", (int)value);
    snprintf(location, sizeof location, "frame %u", (unsigned)s->frame->frame + 1);
    return ost_rows_bad(&source, (int64_t)(from + done) % slice, ost_dicom_path_of(stack, s->frame), location, &bad,
                        err);
}

static ost_status read_slice(ost_dicom_slices *s, ost_error *err)
{
    ost_status status = ost_dicom_images_next(&s->images, &s->frame, err);
    if (status == OST_OK)
        ost_dicom_table_set(&s->table, s->frame);
    return status;
}

/* Reads the next slice, converts it to densities and, if the stack is untilted, shears it. */
static ost_status read_resampled(ost_dicom_slices *s, int16_t *to, ost_error *err)
{
    const ost_dicom_stack *stack = s->images.stack;
    const ost_dicom_slice *slice = &stack->slices[s->images.next_slice];
    ost_status status = read_slice(s, err);
    if (status == OST_OK)
        status = convert(s, 0, s->images.bytes / sizeof(uint16_t), stack->untilted ? s->plain : to, err);
    if (status == OST_OK && stack->untilted)
        ost_dicom_shear(s->plain, s->frame->columns, s->frame->rows, slice->drift, stack->images[0]->spacing,
                        stack->margin, stack->sizes, to);
    return status;
}

/*
 * Computes slice k of an evened stack. The slice lies at k * extent / steps. The two stack slices around this position
 * are in memory: `before` has index s->index - 2, and `after` has index s->index - 1. All positions are scaled by
 * `steps` to remain integers, so they are below 2^46 * 2^14.
 */
static ost_status make_even(ost_dicom_slices *s, int64_t k, ost_error *err)
{
    const ost_dicom_stack *stack = s->images.stack;
    const int64_t steps = stack->sizes[2] - 1;
    const int64_t at = k * stack->slices[stack->slice_count - 1].along;
    ost_status status = OST_OK;
    if (s->index == 0) {
        status = read_resampled(s, s->after, err);
        s->index = 1;
    }
    while (status == OST_OK && stack->slices[s->index - 1].along * steps < at) {
        int16_t *free_slice = s->before;
        s->before = s->after;
        s->after = free_slice;
        s->index++;
        status = read_resampled(s, s->after, err);
    }
    if (status != OST_OK)
        return status;
    const int64_t end = stack->slices[s->index - 1].along * steps;
    const int64_t begin = s->index > 1 ? stack->slices[s->index - 2].along * steps : end;
    s->current = s->mixed;
    if (end - at <= SAME * steps) {
        s->current = s->after;
    } else if (at - begin <= SAME * steps) {
        s->current = s->before;
    } else {
        ost_dicom_mix(s->before, s->after, (size_t)stack->sizes[0] * (size_t)stack->sizes[1], at - begin, end - begin,
                      s->mixed);
        s->interpolated++;
    }
    return OST_OK;
}

/* Implements ost_rows.next. Rows must be requested in order. */
static ost_status next_row(ost_rows *rows, int64_t first, int16_t *out, ost_error *err)
{
    ost_dicom_slices *s = (ost_dicom_slices *)(void *)rows;
    const ost_dicom_stack *stack = s->images.stack;
    const int64_t slice = (int64_t)stack->sizes[0] * stack->sizes[1], at = first % slice;
    const size_t count = (size_t)stack->sizes[0];
    ost_status status = OST_OK;
    if (!stack->evened && !stack->untilted) {
        if (at == 0)
            status = read_slice(s, err);
        return status == OST_OK ? convert(s, (size_t)at, count, out, err) : status;
    }
    if (at == 0 && stack->evened)
        status = make_even(s, first / slice, err);
    else if (at == 0)
        status = read_resampled(s, s->before, err);
    if (at == 0 && !stack->evened)
        s->current = s->before;
    if (status == OST_OK)
        memcpy(out, s->current + at, count * sizeof *out);
    return status;
}

ost_status ost_dicom_slices_open(const ost_dicom_stack *stack, const ost_dicom_launch *launch, bool clamp,
                                 ost_dicom_slices *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    out->rows = (ost_rows){.next = next_row,
                           .path = stack->scan->path,
                           .converter = {.scaled = true}}; /* selects the message of ost_rows_bad */
    memcpy(out->rows.sizes, stack->sizes, sizeof out->rows.sizes);
    out->table.clamp = clamp;
    ost_status status = ost_dicom_images_open(stack, launch, &out->images, err);
    if (status != OST_OK || !(stack->evened || stack->untilted))
        return status;
    const size_t plain = out->images.bytes, slice = (size_t)stack->sizes[0] * (size_t)stack->sizes[1] * sizeof(int16_t);
    bool failed = !(out->before = malloc(slice));
    failed |= stack->untilted && !(out->plain = malloc(plain));
    failed |= stack->evened && (!(out->after = malloc(slice)) || !(out->mixed = malloc(slice)));
    return failed ? ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for slices of %zu bytes", stack->scan->path, slice)
                  : OST_OK;
}

void ost_dicom_slices_close(ost_dicom_slices *slices)
{
    ost_dicom_images_close(&slices->images);
    free(slices->plain);
    free(slices->before);
    free(slices->after);
    free(slices->mixed);
    slices->plain = slices->before = slices->after = slices->mixed = NULL;
}
