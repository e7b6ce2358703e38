/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "io/stack/read.h"

#include <stdio.h>
#include <string.h>

#include "io/stack/names.h"
#include "io/stack/slice.h"
#include "io/volume/rows.h"

typedef struct stack {
    const char *path;
    ost_stack_names names;
    int32_t sizes[3]; /* number of columns, rows and slices */
    ost_element element;
    bool swap;
    char encoding[16], first[OST_SLICE_NAME]; /* encoding and name of the first slice */
    double pixel_mm[2];
} stack;

/* ---------------------------------------------------------------- first pass */

static ost_status add_slice(stack *s, const ost_slice *slice, ost_error *err)
{
    char name[OST_SLICE_NAME];
    ost_slice_name(slice, name);
    if (s->sizes[2] == 0) {
        s->sizes[0] = slice->width;
        s->sizes[1] = slice->height;
        s->element = slice->element;
        s->swap = slice->swap;
        memcpy(s->encoding, slice->encoding, sizeof s->encoding);
        memcpy(s->pixel_mm, slice->pixel_mm, sizeof s->pixel_mm);
        memcpy(s->first, name, sizeof s->first);
    }
    if (slice->width != s->sizes[0] || slice->height != s->sizes[1])
        return ost_fail(err, OST_ERR_INPUT, "%s: %d x %d pixels; %s has %d x %d, and all slices must have one size",
                        name, (int)slice->width, (int)slice->height, s->first, (int)s->sizes[0], (int)s->sizes[1]);
    if (slice->element != s->element || slice->swap != s->swap)
        return ost_fail(err, OST_ERR_INPUT, "%s: values of type %s; %s has %s, and all slices must have one type and "
                        "format", name, ost_element_name(slice->element), s->first, ost_element_name(s->element));
    s->sizes[2]++;
    return OST_OK;
}

/*
 * Adds the pages of one file. The total size of the pages is limited to the file size, or to OST_SLICE_UNPACK_MAX times
 * the file size if the pages are compressed. Without this limit, a small file could request any amount of memory,
 * because several pages may refer to the same bytes.
 */
static ost_status add_file(stack *s, const char *path, ost_error *err)
{
    ost_slice *slice;
    ost_status status = ost_slice_open(path, &slice, err);
    uint64_t bytes = 0;
    for (bool more = true; status == OST_OK && more;) {
        if (s->names.count > 1 && slice->page)
            status = ost_fail(err, OST_ERR_INPUT, "%s: has several pages; expected one page in each file of a stack",
                              path);
        if (status == OST_OK)
            status = add_slice(s, slice, err);
        bytes += (uint64_t)slice->width * (uint64_t)slice->height * ost_element_bytes(slice->element);
        const uint64_t most = (uint64_t)slice->bytes * (slice->packed ? OST_SLICE_UNPACK_MAX : 1);
        if (status == OST_OK && bytes > most)
            status = ost_fail(err, OST_ERR_INPUT, "%s: its first %u pages need %llu bytes; a file of %lld bytes has at "
                              "most %llu", path, (unsigned)slice->page, (unsigned long long)bytes,
                              (long long)slice->bytes, (unsigned long long)most);
        if (status == OST_OK)
            status = ost_slice_next(slice, &more, err);
    }
    ost_slice_close(slice);
    return status;
}

static ost_status scan(stack *s, ost_error *err)
{
    ost_status status = ost_stack_names_read(s->path, &s->names, err);
    for (size_t i = 0; i < s->names.count && status == OST_OK; i++)
        status = add_file(s, s->names.paths[i], err);
    const int64_t sizes[3] = {s->sizes[0], s->sizes[1], s->sizes[2]};
    return status == OST_OK ? ost_rows_sizes(s->path, sizes, s->sizes, err) : status;
}

/* --------------------------------------------------------------- second pass */

typedef struct stack_rows {
    ost_rows rows; /* must be the first member, because an ost_rows * is cast to this struct */
    const stack *stack;
    size_t file; /* index of the next file in the list of files */
    ost_slice *slice; /* the open slice; NULL before the first slice is opened */
} stack_rows;

static ost_status open_slice(stack_rows *r, ost_error *err)
{
    bool more = false;
    ost_status status = r->slice ? ost_slice_next(r->slice, &more, err) : OST_OK;
    if (status != OST_OK || more)
        return status;
    ost_slice_close(r->slice);
    r->slice = NULL;
    if (r->file == r->stack->names.count)
        return ost_fail(err, OST_ERR_INPUT, "%s: changed while it was read", r->stack->path);
    return ost_slice_open(r->stack->names.paths[r->file++], &r->slice, err);
}

static ost_status next_row(ost_rows *rows, int64_t first, int16_t *out, ost_error *err)
{
    stack_rows *r = (stack_rows *)rows;
    const int32_t y = (int32_t)(first / rows->sizes[0] % rows->sizes[1]);
    ost_status status = y == 0 ? open_slice(r, err) : OST_OK;
    const ost_slice *slice = r->slice;
    if (status == OST_OK && (slice->width != rows->sizes[0] || slice->height != rows->sizes[1] ||
                             slice->element != r->stack->element || slice->swap != r->stack->swap))
        status = ost_fail(err, OST_ERR_INPUT, "%s: changed while it was read", slice->path);
    if (status == OST_OK)
        status = ost_slice_row(r->slice, y, rows->scratch, err);
    if (status != OST_OK)
        return status;
    ost_bad bad;
    const size_t count = (size_t)rows->sizes[0];
    const size_t done = ost_element_table_convert(rows->table, &rows->converter, rows->scratch, count, out, &bad);
    if (done == count)
        return OST_OK;
    char location[64], name[OST_SLICE_NAME];
    snprintf(location, sizeof location, "column %zu, row %d", done, (int)y);
    return ost_rows_bad(rows, first + (int64_t)done, ost_slice_name(r->slice, name), location, &bad, err);
}

static ost_status read_voxels(const stack *s, const ost_volume_options *options, const ost_affine *affine,
                              const ost_placement *placement, const ost_geometry *geometry, const ost_target *target,
                              ost_volume_report *report, ost_error *err)
{
    ost_parts none = {.count = 0}; /* empty, because libtiff and libpng read the files */
    stack_rows r = {.rows = {.next = next_row,
                             .path = s->path,
                             .parts = &none,
                             .converter = {.element = s->element,
                                           .swap = s->swap,
                                           .clamp = options->clamp,
                                           .nan_as_air = options->nan_as_air}},
                    .stack = s};
    memcpy(r.rows.sizes, s->sizes, sizeof r.rows.sizes);
    const ost_status status = ost_volume_fill(&r.rows, affine, placement, geometry, target, err);
    ost_slice_close(r.slice);
    report->rounded_values = r.rows.converter.rounded;
    report->clamped_values = r.rows.converter.clamped;
    report->nan_values = r.rows.converter.nan;
    return status;
}

/* ------------------------------------------------------------------- the stack */

static ost_status spacing_missing(const stack *s, ost_error *err)
{
    char stated[120] = "";
    if (s->pixel_mm[0] > 0 && s->pixel_mm[1] > 0)
        snprintf(stated, sizeof stated, "; its first slice states %.6g x %.6g mm per pixel, which may be wrong",
                 s->pixel_mm[0], s->pixel_mm[1]);
    return ost_fail(err, OST_ERR_USAGE, "%s: a stack of %d slices states no spacing; import it with 'osteon import "
                    "--spacing MM' or '--spacing MM,MM,MM' for columns, rows and slices%s", s->path, s->sizes[2],
                    stated);
}

ost_status ost_stack_describe(const char *path, ost_stack_facts *out, ost_error *err)
{
    stack s = {.path = path};
    const ost_status status = scan(&s, err);
    ost_stack_names_free(&s.names);
    if (status != OST_OK)
        return status;
    *out = (ost_stack_facts){.dims = {s.sizes[0], s.sizes[1], s.sizes[2]}, .pixel_mm = {s.pixel_mm[0], s.pixel_mm[1]}};
    snprintf(out->type, sizeof out->type, "%s", ost_element_name(s.element));
    snprintf(out->encoding, sizeof out->encoding, "%s", s.encoding);
    return OST_OK;
}

ost_status ost_stack_read(const char *path, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                          ost_error *err)
{
    static const ost_volume_options plain;
    const ost_volume_options *o = options ? options : &plain;
    const ost_pm spacing[3] = {o->stack_spacing.x, o->stack_spacing.y, o->stack_spacing.z};
    stack s = {.path = path};
    ost_placement placement;
    ost_affine affine = {0};
    bool oriented = false;
    if (o->form != OST_FORM_AUTO)
        return ost_fail(err, OST_ERR_USAGE, "%s: is a stack of slices; --form needs a NIfTI file", path);
    ost_status status = scan(&s, err);
    if (status == OST_OK && (spacing[0] <= 0 || spacing[1] <= 0 || spacing[2] <= 0))
        status = spacing_missing(&s, err);
    if (status == OST_OK) {
        for (int a = 0; a < 3; a++)
            affine.column[a][a] = spacing[a];
        snprintf(report->type, sizeof report->type, "%s", ost_element_name(s.element));
        snprintf(report->encoding, sizeof report->encoding, "%s", s.encoding);
        memcpy(report->pixel_mm, s.pixel_mm, sizeof report->pixel_mm);
        *element = s.element;
        status = ost_volume_orientation(path, options, &affine, &oriented, meta, report, err);
    }
    if (status == OST_OK)
        status = ost_volume_resolve(path, &affine, s.sizes, options, oriented, &placement, geometry, report, err);
    if (status == OST_OK && target)
        status = read_voxels(&s, o, &affine, &placement, geometry, target, report, err);
    ost_stack_names_free(&s.names);
    return status;
}
