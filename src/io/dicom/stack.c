/* SPDX-License-Identifier: Apache-2.0 */
#include "io/dicom/stack.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "io/dicom/series.h"
#include "io/volume/rows.h"

enum { SHARE = 8, LEAST_STEPS = 64 };
static const ost_pm EVEN_MOST = OST_PM_PER_MM / 10, SAME = OST_PM_PER_MM / 1000;

void ost_dicom_stack_free(ost_dicom_stack *stack)
{
    free((void *)stack->images);
    free(stack->slices);
    *stack = (ost_dicom_stack){0};
}

const char *ost_dicom_path_of(const ost_dicom_stack *stack, const ost_dicom_frame *frame)
{
    return stack->scan->files.path[frame->file];
}

/* --------------------------------------------------------------- one image */

static ost_status check_attributes(const char *path, const ost_dicom_frame *f, ost_error *err)
{
    static const struct {
        const char *name, *expected;
    } attributes[] = {
        [OST_DICOM_POSITION] = {"ImagePositionPatient", "three lengths within 8 m"},
        [OST_DICOM_ORIENTATION] = {"ImageOrientationPatient", "six numbers from -1 to 1"},
        [OST_DICOM_SPACING] = {"PixelSpacing", "two lengths from 0.001 to 100 mm"},
        [OST_DICOM_SLOPE] = {"RescaleSlope", "a number below 9,000,000"},
        [OST_DICOM_INTERCEPT] = {"RescaleIntercept", "a number below 9,000,000"},
    };
    if (f->bad != OST_DICOM_NO_ATTRIBUTE && f->bad_value[0])
        return ost_fail(err, OST_ERR_INPUT, "%s: %s '%s'; expected %s", path, attributes[f->bad].name, f->bad_value,
                        attributes[f->bad].expected);
    if (f->bad != OST_DICOM_NO_ATTRIBUTE)
        return ost_fail(err, OST_ERR_INPUT, "%s: has no %s%s", path, attributes[f->bad].name,
                        f->flags & OST_DICOM_IMAGE_ENCRYPTED ? "; its attributes are encrypted" : "");
    const int64_t *r = f->direction[0], *c = f->direction[1];
    ost_i128 rr = 0, cc = 0, rc = 0;
    for (int w = 0; w < 3; w++) {
        rr += (ost_i128)r[w] * r[w];
        cc += (ost_i128)c[w] * c[w];
        rc += (ost_i128)r[w] * c[w];
    }
    const ost_i128 one = (ost_i128)OST_DICOM_UNIT * OST_DICOM_UNIT, slack = one / 500;
    if (rr < one - slack || rr > one + slack || cc < one - slack || cc > one + slack || rc > slack || rc < -slack)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: ImageOrientationPatient is not two perpendicular directions of length 1", path);
    return OST_OK;
}

static ost_status check_pixels(const char *path, const ost_dicom_frame *f, ost_error *err)
{
    if (f->result != OST_DICOM_RESULT_OK)
        return ost_dicom_refuse(path, f->result, err);
    if (f->flags & OST_DICOM_IMAGE_FLOAT)
        return ost_fail(err, OST_ERR_INPUT, "%s: has pixels of floating-point numbers; expected integers", path);
    if (f->flags & OST_DICOM_IMAGE_COLOUR)
        return ost_fail(err, OST_ERR_INPUT, "%s: is a colour image; expected one sample per pixel", path);
    if (f->flags & OST_DICOM_IMAGE_LUT)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: has a ModalityLUTSequence; expected RescaleSlope and RescaleIntercept", path);
    if (f->columns < 1 || f->rows < 1 || f->columns > OST_DICOM_SIDE_MAX || f->rows > OST_DICOM_SIDE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: has %" PRId32 " columns and %" PRId32 " rows; expected 1 to %d", path,
                        f->columns, f->rows, OST_DICOM_SIDE_MAX);
    if ((f->bits_allocated != 8 && f->bits_allocated != 16) || f->bits_stored < 8 ||
        f->bits_stored > f->bits_allocated || f->high_bit >= f->bits_allocated || f->high_bit + 1 < f->bits_stored)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %d bits allocated, %d stored, high bit %d; expected 8 or 16 allocated and 8 to 16 stored",
                        path, f->bits_allocated, f->bits_stored, f->high_bit);
    return OST_OK;
}

/* ----------------------------------------------------------- pairs of images */

/* Returns true if the two identities differ. A missing identity counts as equal to every identity. */
static bool differ(const uint8_t a[OST_DICOM_IDENTITY], const uint8_t b[OST_DICOM_IDENTITY])
{
    static const uint8_t none[OST_DICOM_IDENTITY];
    return memcmp(a, b, OST_DICOM_IDENTITY) != 0 && memcmp(a, none, sizeof none) != 0 &&
           memcmp(b, none, sizeof none) != 0;
}

/* Returns true if |a - b| * steps exceeds 1/8 of `spacing`. `steps` is a number of pixels. */
static bool is_beyond(int64_t a, int64_t b, int32_t steps, int64_t spacing)
{
    const int64_t difference = a > b ? a - b : b - a;
    return (ost_i128)difference * steps * SHARE > spacing;
}

static ost_status check_pair(const char *path, const ost_dicom_frame *f, const char *other, const ost_dicom_frame *g,
                             ost_error *err)
{
    if (differ(f->patient, g->patient))
        return ost_fail(err, OST_ERR_INPUT, "%s: belongs to another patient than %s", path, other);
    if (differ(f->study, g->study))
        return ost_fail(err, OST_ERR_INPUT, "%s: belongs to another study than %s", path, other);
    if (differ(f->reference, g->reference))
        return ost_fail(err, OST_ERR_INPUT, "%s: belongs to another frame of reference than %s", path, other);
    if (f->columns != g->columns || f->rows != g->rows)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: has %" PRId32 " x %" PRId32 " pixels, but %s has %" PRId32 " x %" PRId32, path,
                        f->columns, f->rows, other, g->columns, g->rows);
    for (int a = 0; a < 2; a++)
        for (int w = 0; w < 3; w++)
            if (is_beyond(f->direction[a][w], g->direction[a][w], a ? f->rows : f->columns, OST_DICOM_UNIT))
                return ost_fail(err, OST_ERR_INPUT, "%s: its ImageOrientationPatient differs from that of %s", path,
                                other);
    if (is_beyond(f->spacing[0], g->spacing[0], f->columns, g->spacing[0]) ||
        is_beyond(f->spacing[1], g->spacing[1], f->rows, g->spacing[1]))
        return ost_fail(err, OST_ERR_INPUT, "%s: its PixelSpacing differs from that of %s", path, other);
    return OST_OK;
}

/* ------------------------------------------------------------------- order */

/* An image and its position along the stack's normal, measured from an arbitrary image of the stack. */
typedef struct placed {
    const ost_dicom_frame *frame;
    ost_pm along;
} placed;

/*
 * Computes the normal of an image as the cross product of its two directions, in units of 10^-9, rounded half to even.
 */
static void normal_of(const ost_dicom_frame *f, int64_t out[3])
{
    const int64_t *r = f->direction[0], *c = f->direction[1];
    for (int w = 0; w < 3; w++) {
        const int u = (w + 1) % 3, v = (w + 2) % 3;
        out[w] = (int64_t)ost_rhe_div128((ost_i128)r[u] * c[v] - (ost_i128)r[v] * c[u], OST_DICOM_UNIT);
    }
}

/*
 * Computes the component of b - a along the direction d, rounded half to even: 10^9 ((b - a) . d) / (d . d), where d is
 * given in units of 10^-9. Each coordinate of b - a is below 2^45 and |d| < 2^31, so the dividend is below 3 * 2^106.
 */
static ost_pm component(const ost_pm a[3], const ost_pm b[3], const int64_t d[3])
{
    ost_i128 product = 0, square = 0;
    for (int w = 0; w < 3; w++) {
        product += (ost_i128)(b[w] - a[w]) * d[w];
        square += (ost_i128)d[w] * d[w];
    }
    return (ost_pm)ost_rhe_div128(product * OST_DICOM_UNIT, square);
}

static int by_position(const void *x, const void *y)
{
    const placed *a = x, *b = y;
    if (a->along != b->along)
        return a->along < b->along ? -1 : 1;
    if (a->frame->file != b->frame->file)
        return a->frame->file < b->frame->file ? -1 : 1;
    return a->frame->frame < b->frame->frame ? -1 : a->frame->frame > b->frame->frame;
}

/*
 * Divides the ordered images into slices. An image within 1 um of the first image of a slice belongs to the same slice
 * and is counted in slice->doubles.
 */
static void divide(ost_dicom_stack *stack, const placed *images)
{
    const ost_dicom_frame *first = images[0].frame;
    for (size_t i = 0; i < stack->image_count; i++) {
        const ost_pm along = images[i].along - images[0].along;
        stack->images[i] = images[i].frame;
        ost_dicom_slice *last = stack->slice_count ? &stack->slices[stack->slice_count - 1] : NULL;
        if (last && along - last->along <= SAME) {
            last->doubles++;
            continue;
        }
        ost_dicom_slice *slice = &stack->slices[stack->slice_count++];
        *slice = (ost_dicom_slice){.image = i, .along = along};
        for (int a = 0; a < 2; a++)
            slice->drift[a] = component(first->position, images[i].frame->position, first->direction[a]);
    }
}

/* Checks every image of the series, compares each image with the first one, and orders the images. */
static ost_status order(ost_dicom_stack *stack, size_t series, ost_error *err)
{
    const ost_dicom_scan *scan = stack->scan;
    const size_t most = stack->group->images;
    placed *images = malloc(most * sizeof *images);
    stack->images = malloc(most * sizeof *stack->images);
    stack->slices = malloc(most * sizeof *stack->slices);
    ost_status status = OST_OK;
    if (!images || !stack->images || !stack->slices)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu slices", scan->path, most);
    int64_t normal[3];
    for (size_t i = 0; i < scan->frame_count && status == OST_OK; i++) {
        const ost_dicom_frame *f = &scan->frames[i];
        if (f->series != series || f->flags & OST_DICOM_IMAGE_LOCALIZER)
            continue;
        const char *path = scan->files.path[f->file];
        status = check_pixels(path, f, err);
        if (status == OST_OK)
            status = check_attributes(path, f, err);
        if (status != OST_OK)
            break;
        const ost_dicom_frame *first = stack->image_count ? images[0].frame : f;
        if (first == f)
            normal_of(f, normal);
        else
            status = check_pair(path, f, scan->files.path[first->file], first, err);
        images[stack->image_count++] = (placed){.frame = f, .along = component(first->position, f->position, normal)};
    }
    if (status == OST_OK) {
        qsort(images, stack->image_count, sizeof *images, by_position);
        divide(stack, images);
    }
    free(images);
    return status;
}

/* ---------------------------------------------------------------- geometry */

static const char *slice_path(const ost_dicom_stack *stack, size_t slice)
{
    return ost_dicom_path_of(stack, stack->images[stack->slices[slice].image]);
}

static ost_pm gap_before(const ost_dicom_stack *stack, size_t slice)
{
    return stack->slices[slice].along - stack->slices[slice - 1].along;
}

static int by_length(const void *x, const void *y)
{
    const ost_pm a = *(const ost_pm *)x, b = *(const ost_pm *)y;
    return a < b ? -1 : a > b;
}

/*
 * Computes the lower median of the distances between adjacent slices. Returns 0 if memory is exhausted.
 */
static ost_pm median_gap(const ost_dicom_stack *stack)
{
    const size_t count = stack->slice_count - 1;
    ost_pm *gaps = malloc(count * sizeof *gaps);
    if (!gaps)
        return 0;
    for (size_t k = 0; k < count; k++)
        gaps[k] = gap_before(stack, k + 1);
    qsort(gaps, count, sizeof *gaps, by_length);
    const ost_pm median = gaps[(count - 1) / 2];
    free(gaps);
    return median;
}

static ost_pm magnitude(ost_pm a)
{
    return a < 0 ? -a : a;
}

/*
 * Finds the slice that is farthest from its position in an evenly spaced stack. Returns the distance, rounded half to
 * even.
 */
static ost_pm worst_slice(const ost_dicom_stack *stack, size_t *out)
{
    const int64_t steps = (int64_t)stack->slice_count - 1;
    const ost_pm extent = stack->slices[steps].along;
    ost_pm worst = -1;
    for (int64_t k = 0; k <= steps; k++) {
        /* `along` and `extent` are below 2^46, and `k` and `steps` are below 2^16, so the products fit into int64. */
        const ost_pm off = magnitude(ost_rhe_div(stack->slices[k].along * steps - k * extent, steps));
        if (off > worst) {
            worst = off;
            *out = (size_t)k;
        }
    }
    return worst;
}

static ost_pm tolerance(ost_pm distance)
{
    return distance / SHARE < EVEN_MOST ? distance / SHARE : EVEN_MOST;
}

/* Returns the error for slices that are not evenly spaced. */
static ost_status refuse_uneven(const ost_dicom_stack *stack, size_t worst, ost_pm off, ost_pm median, ost_error *err)
{
    size_t widest = 1;
    char a[OST_PM_TEXT], b[OST_PM_TEXT];
    for (size_t k = 2; k < stack->slice_count; k++)
        if (gap_before(stack, k) > gap_before(stack, widest))
            widest = k;
    const ost_pm gap = gap_before(stack, widest);
    const int64_t parts = ost_rhe_div(gap, median);
    if (parts >= 2 && magnitude(gap - parts * median) <= 2 * tolerance(median))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: lies %s mm after %s, but most slices are %s mm apart: %" PRId64 " slice%s missing; "
                        "restore %s, or interpolate %s with --even-slices",
                        slice_path(stack, widest), ost_pm_format(gap, a), slice_path(stack, widest - 1),
                        ost_pm_format(median, b), parts - 1, parts == 2 ? " is" : "s are", parts == 2 ? "it" : "them",
                        parts == 2 ? "it" : "them");
    const int64_t steps = (int64_t)stack->slice_count - 1;
    return ost_fail(err, OST_ERR_INPUT,
                    "%s: lies %s mm off its position in an even stack of slices %s mm apart; --even-slices resamples "
                    "the series",
                    slice_path(stack, worst), ost_pm_format(off, a),
                    ost_pm_format(ost_rhe_div(stack->slices[steps].along, steps), b));
}

/*
 * Computes the number of equal steps from the first to the last slice of the result. Sets stack->evened if the slices
 * must be resampled.
 */
static ost_status find_slices(ost_dicom_stack *stack, bool even_slices, ost_dicom_report *report, int64_t *steps,
                              ost_error *err)
{
    size_t worst = 0;
    *steps = (int64_t)stack->slice_count - 1;
    const ost_pm off = worst_slice(stack, &worst), distance = stack->slices[*steps].along / *steps;
    for (size_t k = 1; k < stack->slice_count; k++)
        report->largest_gap = gap_before(stack, k) > report->largest_gap ? gap_before(stack, k) : report->largest_gap;
    if (off <= tolerance(distance))
        return OST_OK;
    const ost_pm median = median_gap(stack);
    if (median == 0)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the distances of slices", stack->scan->path);
    if (!even_slices)
        return refuse_uneven(stack, worst, off, median, err);
    stack->evened = true;
    *steps = ost_rhe_div(stack->slices[*steps].along, median);
    return OST_OK;
}

/* Returns OST_OK if the slices lie straight above each other, otherwise the error. */
static ost_status check_drift(const ost_dicom_stack *stack, const ost_pm spacing[2], ost_error *err)
{
    const int64_t steps = (int64_t)stack->slice_count - 1, counted = steps > LEAST_STEPS ? steps : LEAST_STEPS;
    const ost_dicom_slice *last = &stack->slices[steps];
    char a[OST_PM_TEXT];
    for (int axis = 0; axis < 2; axis++)
        for (int64_t k = 1; k < steps; k++) {
            /* drift of the line through the first and the last slice, at the position of this slice */
            const ost_pm line = (ost_pm)ost_rhe_div128((ost_i128)last->drift[axis] * stack->slices[k].along,
                                                       last->along);
            const ost_pm off = magnitude(stack->slices[k].drift[axis] - line);
            if (off > spacing[axis] / SHARE)
                return ost_fail(err, OST_ERR_INPUT,
                                "%s: lies %s mm beside the line through the first and the last slice; --untilt moves "
                                "it back",
                                slice_path(stack, (size_t)k), ost_pm_format(off, a));
        }
    for (int axis = 0; axis < 2; axis++)
        if ((ost_i128)magnitude(last->drift[axis]) * counted * SHARE > (ost_i128)spacing[axis] * steps) {
            const double across = hypot((double)last->drift[0], (double)last->drift[1]),
                         degrees = atan2(across, (double)last->along) * 57.29577951308232;
            return ost_fail(err, OST_ERR_INPUT,
                            "%s: the slices are tilted by %.2f degrees (each lies %.3g mm beside the one before it); "
                            "--untilt shears them back",
                            slice_path(stack, (size_t)steps), degrees, across / (double)steps * 1e-9);
        }
    return OST_OK;
}

/* Enlarges the grid so that the shifted slices fit into it, and moves the origin accordingly. */
static void add_margins(ost_dicom_stack *stack, const ost_pm spacing[2], int64_t sizes[3], ost_dicom_report *report)
{
    for (int axis = 0; axis < 2; axis++) {
        ost_pm least = 0, greatest = 0;
        for (size_t k = 0; k < stack->slice_count; k++) {
            const ost_pm drift = stack->slices[k].drift[axis];
            least = drift < least ? drift : least;
            greatest = drift > greatest ? drift : greatest;
        }
        const int64_t before = -ost_floor_div(least, spacing[axis]), after = ost_ceil_div(greatest, spacing[axis]);
        report->sheared = greatest - least > report->sheared ? greatest - least : report->sheared;
        sizes[axis] += before + after;
        /* A size beyond OST_DIM_MAX is refused later by ost_rows_sizes. */
        stack->margin[axis] = before <= OST_DIM_MAX ? (int32_t)before : OST_DIM_MAX;
        for (int w = 0; w < 3; w++)
            stack->affine.origin[w] -= stack->margin[axis] * stack->affine.column[axis][w];
    }
    stack->untilted = report->sheared > 0;
}

/*
 * Computes the vector from one slice to the next. It lies along the line through the first and the last slice or, if
 * the stack is untilted, along the normal.
 */
static void set_slice_axis(ost_dicom_stack *stack, int64_t steps)
{
    const ost_dicom_frame *first = stack->images[0],
                          *last = stack->images[stack->slices[stack->slice_count - 1].image];
    int64_t normal[3];
    ost_i128 square = 0, product = 0;
    normal_of(first, normal);
    for (int w = 0; w < 3; w++) {
        square += (ost_i128)normal[w] * normal[w];
        product += (ost_i128)(last->position[w] - first->position[w]) * normal[w];
    }
    /* |product| < 3 * 2^75 and |normal| < 2^31, so the dividends are below 2^108. */
    for (int w = 0; w < 3; w++)
        stack->affine.column[2][w] =
            stack->untilted ? (ost_pm)ost_rhe_div128(product * normal[w], square * steps)
                            : ost_rhe_div(last->position[w] - first->position[w], steps);
}

static void describe(const ost_dicom_stack *stack, ost_dicom_report *report)
{
    const ost_dicom_scan *scan = stack->scan;
    report->localizers = stack->group->localizers;
    report->other_files = (int64_t)scan->not_dicom + scan->no_image;
    report->images = (int64_t)stack->slice_count;
    report->doubled = (int64_t)(stack->image_count - stack->slice_count);
    report->thickness = stack->images[0]->thickness;
    report->no_rescale = true;
    for (size_t i = 0; i < stack->image_count; i++) {
        report->lossy |= (stack->images[i]->flags & OST_DICOM_IMAGE_LOSSY) != 0;
        report->no_rescale &= !stack->images[i]->rescaled;
        if (stack->images[i]->thickness != report->thickness)
            report->thickness = 0;
    }
    snprintf(report->modality, sizeof report->modality, "%.*s", (int)sizeof report->modality - 1,
             stack->group->modality);
}

static ost_status place(ost_dicom_stack *stack, const ost_volume_options *options, ost_dicom_report *report,
                        ost_error *err)
{
    const ost_dicom_frame *first = stack->images[0];
    if (stack->slice_count < 2) {
        char name[OST_DICOM_SERIES_NAME];
        return ost_fail(err, OST_ERR_INPUT, "%s: all images of %s have the same position as %s", stack->scan->path,
                        ost_dicom_series_name(stack->group, name), slice_path(stack, 0));
    }
    int64_t sizes[3] = {first->columns, first->rows, 0}, steps;
    for (int w = 0; w < 3; w++) {
        stack->affine.origin[w] = first->position[w];
        for (int a = 0; a < 2; a++)
            stack->affine.column[a][w] =
                (ost_pm)ost_rhe_div128((ost_i128)first->direction[a][w] * first->spacing[a], OST_DICOM_UNIT);
    }
    ost_status status = OST_OK;
    if (!options || !options->untilt)
        status = check_drift(stack, first->spacing, err);
    else if (check_drift(stack, first->spacing, NULL) != OST_OK)
        add_margins(stack, first->spacing, sizes, report);
    if (status == OST_OK)
        status = find_slices(stack, options && options->even_slices, report, &steps, err);
    if (status != OST_OK)
        return status;
    sizes[2] = steps + 1;
    set_slice_axis(stack, steps);
    return ost_rows_sizes(stack->scan->path, sizes, stack->sizes, err);
}

ost_status ost_dicom_stack_make(const ost_dicom_scan *scan, size_t series, const ost_volume_options *options,
                                ost_dicom_stack *out, ost_dicom_report *report, ost_error *err)
{
    *out = (ost_dicom_stack){.scan = scan, .group = &scan->series[series]};
    *report = (ost_dicom_report){0};
    ost_status status = order(out, series, err);
    if (status == OST_OK) {
        describe(out, report);
        status = place(out, options, report, err);
    }
    if (status != OST_OK)
        ost_dicom_stack_free(out);
    return status;
}
