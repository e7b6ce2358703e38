/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#ifdef HAVE_NIFTI

#include "io/nifti/header.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nifti2_io.h>

#include "core/conditions.h"
#include "core/shortest.h"
#include "io/nifti/extension.h"
#include "io/nifti/read.h"
#include "io/volume/rows.h"

/* ---------------------------------------------------------------- checking */

static const struct {
    int code, bits;
    ost_element element;
    const char *name; /* description of the voxels in an error message; NULL if the type is supported */
} types[] = {
    {DT_UINT8, 8, OST_ELEMENT_UINT8, NULL},      {DT_INT8, 8, OST_ELEMENT_INT8, NULL},
    {DT_INT16, 16, OST_ELEMENT_INT16, NULL},     {DT_UINT16, 16, OST_ELEMENT_UINT16, NULL},
    {DT_INT32, 32, OST_ELEMENT_INT32, NULL},     {DT_UINT32, 32, OST_ELEMENT_UINT32, NULL},
    {DT_INT64, 64, OST_ELEMENT_INT64, NULL},     {DT_UINT64, 64, OST_ELEMENT_UINT64, NULL},
    {DT_FLOAT32, 32, OST_ELEMENT_FLOAT32, NULL}, {DT_FLOAT64, 64, OST_ELEMENT_FLOAT64, NULL},
    {DT_BINARY, 1, OST_ELEMENT_NONE, "bits"},    {DT_RGB24, 24, OST_ELEMENT_NONE, "RGB colours"},
    {DT_RGBA32, 32, OST_ELEMENT_NONE, "RGBA colours"},
    {DT_COMPLEX64, 64, OST_ELEMENT_NONE, "complex numbers"},
    {DT_COMPLEX128, 128, OST_ELEMENT_NONE, "complex numbers"},
    {DT_COMPLEX256, 256, OST_ELEMENT_NONE, "complex numbers"},
    {DT_FLOAT128, 128, OST_ELEMENT_NONE, "128-bit floats"},
};

static ost_status check_type(const char *path, int code, int bits, ost_element *out, ost_error *err)
{
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++) {
        if (types[t].code != code)
            continue;
        if (types[t].element == OST_ELEMENT_NONE)
            return ost_fail(err, OST_ERR_INPUT, "%s: voxels are %s; expected one density per voxel", path,
                            types[t].name);
        if (types[t].bits != bits)
            return ost_fail(err, OST_ERR_INPUT, "%s: bitpix %d does not fit datatype %d (%s)", path, bits, code,
                            ost_element_name(types[t].element));
        *out = types[t].element;
        return OST_OK;
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: unknown datatype %d", path, code);
}

static ost_status check_dims(const char *path, const int64_t dim[8], int32_t sizes[3], ost_error *err)
{
    if (dim[0] < 1 || dim[0] > 7)
        return ost_fail(err, OST_ERR_INPUT, "%s: dim[0] is %lld; expected 3 axes", path, (long long)dim[0]);
    if (dim[0] < 3)
        return ost_fail(err, OST_ERR_INPUT, "%s: %lld axes; expected three", path, (long long)dim[0]);
    for (int a = 4; a <= dim[0]; a++)
        if (dim[a] != 1)
            return ost_fail(err, OST_ERR_INPUT, "%s: dim[%d] is %lld; expected three axes and one density per voxel",
                            path, a, (long long)dim[a]);
    return ost_rows_sizes(path, dim + 1, sizes, err);
}

/* Checks vox_offset. In a file that contains both header and voxels, the voxels begin after the header's struct. */
static ost_status check_offset(const char *path, double offset, bool pair, int struct_bytes, uint64_t *out,
                               ost_error *err)
{
    double least = pair ? 0 : struct_bytes;
    if (!(offset >= least && offset <= 9007199254740992.0) || offset != floor(offset))
        return ost_fail(err, OST_ERR_INPUT, "%s: vox_offset is %.9g; expected a whole number of at least %.0f", path,
                        offset, least);
    *out = (uint64_t)offset;
    return OST_OK;
}

/* ----------------------------------------------------------------- lengths */

/* Precision of the floats in a header, and their unit of length. */
typedef struct scale {
    bool single;
    uint64_t unit; /* unit of length in picometres */
} scale;

/*
 * Converts a float in the header's unit to a length: the shortest decimal that reads back as this float. For m and um,
 * the decimal is found before scaling, because scaling changes the float: 0.000488281 m * 1000 differs from 0.488281
 * mm.
 */
static bool to_pm(const scale *s, double value, ost_pm *out)
{
    if (s->unit == (uint64_t)OST_PM_PER_MM)
        return s->single ? ost_pm_from_float((float)value, out) : ost_pm_from_double(value, out);
    ost_decimal decimal;
    return isfinite(value) && ost_decimal_shortest(value, s->single, &decimal) &&
           ost_decimal_scale(&decimal, s->unit, out, NULL) && *out <= OST_LENGTH_MAX && *out >= -OST_LENGTH_MAX;
}

static ost_status find_scale(const char *path, int version, int units, scale *out, ost_error *err)
{
    *out = (scale){.single = version == 1, .unit = (uint64_t)OST_PM_PER_MM};
    switch (units) {
    case NIFTI_UNITS_UNKNOWN:
    case NIFTI_UNITS_MM: return OST_OK;
    case NIFTI_UNITS_METER: out->unit = (uint64_t)OST_PM_PER_MM * 1000; return OST_OK;
    case NIFTI_UNITS_MICRON: out->unit = (uint64_t)OST_PM_PER_MM / 1000; return OST_OK;
    default: break;
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: xyzt_units has %d for lengths; expected 1 (m), 2 (mm), 3 (um) or 0",
                    path, units);
}

/* -------------------------------------------------------------- orientation */

/* Computes the matrix of the quaternion in RAS. Each column is multiplied by its pixdim (NIfTI-1, method 2). */
static void from_quaternion(const nifti_image *nim, const double pixdim[3], double out[3][4])
{
    double b = nim->quatern_b, c = nim->quatern_c, d = nim->quatern_d;
    double squares = b * b + c * c + d * d, a = 0;
    if (1.0 - squares < 1e-7) {
        /* For a rotation by 180 degrees, the quaternion's component a is exactly 0. Computing it would yield only
         * rounding noise. */
        double length = sqrt(squares);
        b /= length;
        c /= length;
        d /= length;
    } else {
        a = sqrt(1.0 - squares);
    }
    const double r[3][3] = {
        {a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
        {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
        {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - c * c - b * b},
    };
    const double size[3] = {pixdim[0], pixdim[1], nim->qfac < 0 ? -pixdim[2] : pixdim[2]};
    const double offset[3] = {nim->qoffset_x, nim->qoffset_y, nim->qoffset_z};
    for (int w = 0; w < 3; w++) {
        for (int col = 0; col < 3; col++)
            out[w][col] = r[w][col] * size[col];
        out[w][3] = offset[w];
    }
}

/*
 * Replaces the length of an affine column with pixdim if two conditions hold: the column deviates from its axis, but by
 * at most 1/1000, and its length agrees with pixdim to 1/10000.
 */
static void resolve_spacing(ost_pm column[3], ost_pm pixdim)
{
    int major = 0;
    for (int w = 1; w < 3; w++)
        if (llabs(column[w]) > llabs(column[major]))
            major = w;
    ost_pm most = llabs(column[major]), off = 0;
    for (int w = 0; w < 3; w++)
        if (w != major && llabs(column[w]) > off)
            off = llabs(column[w]);
    if (off == 0 || off > most / 1000 || llabs(most - pixdim) > pixdim / 10000)
        return;
    column[major] = column[major] < 0 ? -pixdim : pixdim;
}

typedef enum form { FORM_SFORM, FORM_QFORM, FORM_NONE } form;

/*
 * Reads the sform or the qform and converts it to LPS. spacing[] contains the spacings from pixdim; an element is 0
 * if its pixdim is not a valid length.
 */
static ost_status read_form(const char *path, const nifti_image *nim, form which, const double pixdim[3],
                            const ost_pm spacing[3], const scale *s, ost_affine *out, ost_error *err)
{
    static const char *const names[] = {"sform", "qform"};
    double ras[3][4] = {{0}};
    if (which == FORM_SFORM) {
        for (int w = 0; w < 3; w++)
            for (int c = 0; c < 4; c++)
                ras[w][c] = nim->sto_xyz.m[w][c];
    } else {
        double squares = nim->quatern_b * nim->quatern_b + nim->quatern_c * nim->quatern_c +
                         nim->quatern_d * nim->quatern_d;
        if (!(squares <= 1.001))
            return ost_fail(err, OST_ERR_INPUT, "%s: its qform's quaternion (%.6g, %.6g, %.6g) is longer than 1", path,
                            nim->quatern_b, nim->quatern_c, nim->quatern_d);
        from_quaternion(nim, pixdim, ras);
    }
    for (int w = 0; w < 3; w++) {
        for (int c = 0; c < 4; c++) {
            /* From RAS to LPS, x and y change their signs. */
            double value = w < 2 ? -ras[w][c] : ras[w][c];
            ost_pm *to = c < 3 ? &out->column[c][w] : &out->origin[w];
            if (!to_pm(s, value, to))
                return ost_fail(err, OST_ERR_INPUT, "%s: its %s has %.9g for %s %d; expected a length within 8 m",
                                path, names[which], ras[w][c], c < 3 ? "axis" : "the origin, coordinate",
                                (c < 3 ? c : w) + 1);
        }
    }
    for (int a = 0; a < 3; a++)
        if (spacing[a] > 0)
            resolve_spacing(out->column[a], spacing[a]);
    return OST_OK;
}

/*
 * Returns an error if the two transforms disagree, that is, if they map some voxel centre to two positions that differ
 * along an axis by more than the smallest pixdim. The difference of the transforms is affine, so its maximum is at a
 * corner of the grid. |apart| <= 2 * 8e12 * (1 + 3 * 16383) < 2^60.
 */
static ost_status check_agreement(const char *path, const ost_affine *a, const ost_affine *b, const int32_t sizes[3],
                                  const ost_pm spacing[3], ost_error *err)
{
    ost_pm voxel = spacing[0], greatest = 0;
    for (int i = 1; i < 3; i++)
        voxel = spacing[i] < voxel ? spacing[i] : voxel;
    for (int corner = 0; corner < 8; corner++) {
        for (int w = 0; w < 3; w++) {
            ost_pm apart = a->origin[w] - b->origin[w];
            for (int i = 0; i < 3; i++)
                apart += corner >> i & 1 ? (a->column[i][w] - b->column[i][w]) * (sizes[i] - 1) : 0;
            apart = apart < 0 ? -apart : apart;
            greatest = apart > greatest ? apart : greatest;
        }
    }
    if (greatest <= voxel)
        return OST_OK;
    return ost_fail(
        err, OST_ERR_INPUT,
        "%s: its qform and its sform place the same voxel up to %.4g mm apart, and a voxel is %.4g mm; choose one with "
        "'osteon import --form qform' or '--form sform'",
        path, ost_pm_to_mm(greatest), ost_pm_to_mm(voxel));
}

static bool leads_to_patient(int code)
{
    return code == NIFTI_XFORM_SCANNER_ANAT || code == NIFTI_XFORM_ALIGNED_ANAT;
}

/* Determines the affine transform. pixdim is read from the raw header, because libnifti would replace 0 with 1. */
static ost_status find_affine(const char *path, const nifti_image *nim, const double pixdim[3], const scale *s,
                              ost_nifti_form chosen, ost_nifti_header *out, ost_error *err)
{
    form which = leads_to_patient(nim->sform_code) || (nim->sform_code > 0 && nim->qform_code <= 0) ? FORM_SFORM
                 : nim->qform_code > 0                                                              ? FORM_QFORM
                                                                                                    : FORM_NONE;
    if (chosen != OST_FORM_AUTO) {
        which = chosen == OST_FORM_SFORM ? FORM_SFORM : FORM_QFORM;
        if ((which == FORM_SFORM ? nim->sform_code : nim->qform_code) <= 0)
            return ost_fail(err, OST_ERR_USAGE, "%s: --form %s: not in the header (its code is %d)", path,
                            which == FORM_SFORM ? "sform" : "qform",
                            which == FORM_SFORM ? nim->sform_code : nim->qform_code);
    }
    ost_pm spacing[3] = {0, 0, 0};
    bool sized = true;
    for (int a = 0; a < 3; a++) {
        if (to_pm(s, pixdim[a], &spacing[a]) && spacing[a] > 0)
            continue;
        sized = false;
        if (which != FORM_SFORM)
            return ost_fail(err, OST_ERR_INPUT,
                            "%s: pixdim[%d] is %.9g; expected a length greater than 0 and within 8 m", path, a + 1,
                            pixdim[a]);
    }
    out->oriented = which != FORM_NONE;
    if (which == FORM_NONE) {
        for (int a = 0; a < 3; a++)
            out->affine.column[a][a] = spacing[a];
        return OST_OK;
    }
    ost_status status = read_form(path, nim, which, pixdim, spacing, s, &out->affine, err);
    if (status != OST_OK || chosen != OST_FORM_AUTO || !sized || !leads_to_patient(nim->sform_code) ||
        !leads_to_patient(nim->qform_code))
        return status;
    ost_affine other = {{{0}}, {0}};
    return read_form(path, nim, FORM_QFORM, pixdim, spacing, s, &other, NULL) == OST_OK
               ? check_agreement(path, &out->affine, &other, out->sizes, spacing, err)
               : OST_OK;
}

/* ---------------------------------------------------------- exact geometry */

static bool read_lengths(const char *text, ost_pm out[3])
{
    const char *end = text + strlen(text);
    for (int w = 0; w < 3; w++) {
        ost_decimal d;
        text = ost_decimal_read(text, end, &d);
        if (!text || !ost_decimal_to_pm(&d, &out[w], NULL) || (w < 2 && *text++ != ' '))
            return false;
    }
    return text == end;
}

static bool same_float(ost_pm a, ost_pm b)
{
    return (float)ost_pm_to_mm(a) == (float)ost_pm_to_mm(b);
}

/*
 * Replaces the header's float lengths with the exact lengths from osteon's own comment if the exact lengths round to
 * these floats. Otherwise, another program has changed the header. In both cases, removes the exact lengths from the
 * header facts.
 */
static void take_exact(ost_nifti_header *h)
{
    const char *spacing_text = ost_meta_get(&h->meta, OST_NIFTI_SPACING),
               *origin_text = ost_meta_get(&h->meta, OST_NIFTI_ORIGIN);
    ost_pm spacing[3], origin[3];
    bool good = spacing_text && origin_text && read_lengths(spacing_text, spacing) && read_lengths(origin_text, origin);
    for (int a = 0; good && a < 3; a++) {
        for (int w = 0; w < 3; w++)
            good = good && same_float(h->affine.column[a][w], a == w ? spacing[a] : 0);
        good = good && same_float(h->affine.origin[a], origin[a]);
    }
    for (int a = 0; good && a < 3; a++) {
        h->affine.column[a][a] = spacing[a];
        h->affine.origin[a] = origin[a];
    }
    int kept = 0;
    for (int i = 0; i < h->meta.count; i++) {
        const char *key = h->meta.entry[i].key;
        if (strcmp(key, OST_NIFTI_SPACING) != 0 && strcmp(key, OST_NIFTI_ORIGIN) != 0)
            h->meta.entry[kept++] = h->meta.entry[i];
    }
    h->meta.count = kept;
}

/* ------------------------------------------------------------------ reading */

/* The raw header, which read_raw converts to native byte order. */
typedef union raw_header {
    unsigned char bytes[540];
    nifti_1_header one;
    nifti_2_header two;
} raw_header;

static ost_status read_raw(ost_input *input, raw_header *raw, ost_nifti_header *out, ost_error *err)
{
    const char *path = ost_input_path(input);
    size_t got, more = 0;
    memset(raw, 0, sizeof *raw);
    ost_status status = ost_input_read(input, raw->bytes, OST_NIFTI_SNIFF, &got, err);
    if (status != OST_OK)
        return status;
    out->version = ost_nifti_sniff(raw->bytes, got);
    if (out->version == 2) {
        status = ost_input_read(input, raw->bytes + got, sizeof raw->bytes - got, &more, err);
        if (status != OST_OK)
            return status;
        if (got + more < sizeof raw->bytes)
            return ost_fail(err, OST_ERR_INPUT, "%s: ends at byte %zu, within its header of %zu bytes", path,
                            got + more, sizeof raw->bytes);
    } else if (out->version == 7) {
        return ost_fail(err, OST_ERR_INPUT, "%s: an ANALYZE 7.5 header (no NIfTI magic at byte 344), which does not "
                        "state its orientation; convert it to NIfTI", path);
    } else if (out->version == 0) {
        return ost_fail(err, OST_ERR_INPUT, "%s: no NIfTI header at byte 0 (%zu bytes)", path, got);
    }
    out->swap = raw->bytes[0] == 0;
    if (out->swap && out->version == 1)
        nifti_swap_as_nifti1(&raw->one);
    else if (out->swap)
        nifti_swap_as_nifti2(&raw->two);
    return OST_OK;
}

/*
 * Refuses NaN and infinity, which libnifti would silently replace with 0. srow is checked where it is used, because
 * libnifti does not change it. A slope that is not finite means no scaling.
 */
static ost_status check_reals(const char *path, const raw_header *raw, bool one, ost_error *err)
{
    const struct {
        const char *name;
        double value;
    } reals[] = {
        {"pixdim[0]", one ? (double)raw->one.pixdim[0] : raw->two.pixdim[0]},
        {"pixdim[1]", one ? (double)raw->one.pixdim[1] : raw->two.pixdim[1]},
        {"pixdim[2]", one ? (double)raw->one.pixdim[2] : raw->two.pixdim[2]},
        {"pixdim[3]", one ? (double)raw->one.pixdim[3] : raw->two.pixdim[3]},
        {"quatern_b", one ? (double)raw->one.quatern_b : raw->two.quatern_b},
        {"quatern_c", one ? (double)raw->one.quatern_c : raw->two.quatern_c},
        {"quatern_d", one ? (double)raw->one.quatern_d : raw->two.quatern_d},
        {"qoffset_x", one ? (double)raw->one.qoffset_x : raw->two.qoffset_x},
        {"qoffset_y", one ? (double)raw->one.qoffset_y : raw->two.qoffset_y},
        {"qoffset_z", one ? (double)raw->one.qoffset_z : raw->two.qoffset_z},
    };
    bool uses_qform = (one ? raw->one.qform_code : raw->two.qform_code) > 0;
    for (size_t i = 0; i < (uses_qform ? sizeof reals / sizeof reals[0] : 4); i++)
        if (!isfinite(reals[i].value))
            return ost_fail(err, OST_ERR_INPUT, "%s: %s in the header is not a number", path, reals[i].name);
    double slope = one ? (double)raw->one.scl_slope : raw->two.scl_slope;
    double intercept = one ? (double)raw->one.scl_inter : raw->two.scl_inter;
    if (slope != 0 && isfinite(slope) && !isfinite(intercept))
        return ost_fail(err, OST_ERR_INPUT, "%s: scl_inter in the header is not a number, though scl_slope is %.9g",
                        path, slope);
    return OST_OK;
}

static ost_status check_raw(const char *path, const raw_header *raw, ost_nifti_header *out, ost_error *err)
{
    int64_t dim[8];
    ost_status status;
    bool one = out->version == 1;
    out->pair = one ? raw->one.magic[1] == 'i' : raw->two.magic[1] == 'i';
    for (int a = 0; a < 8; a++)
        dim[a] = one ? raw->one.dim[a] : raw->two.dim[a];
    if ((status = check_dims(path, dim, out->sizes, err)) != OST_OK)
        return status;
    out->labels = (one ? raw->one.intent_code : raw->two.intent_code) == NIFTI_INTENT_LABEL;
    status = one ? check_type(path, raw->one.datatype, raw->one.bitpix, &out->element, err)
                 : check_type(path, raw->two.datatype, raw->two.bitpix, &out->element, err);
    if (status != OST_OK)
        return status;
    double offset = one ? (double)raw->one.vox_offset : (double)raw->two.vox_offset;
    status = check_offset(path, offset, out->pair, one ? 348 : 540, &out->image_at, err);
    if (status != OST_OK)
        return status;
    return check_reals(path, raw, one, err);
}

static void find_scaling(const nifti_image *nim, ost_nifti_header *out)
{
    double slope = nim->scl_slope, intercept = nim->scl_inter;
    out->scaled = slope != 0 && (slope != 1 || intercept != 0) && ost_binary_from_double(slope, &out->slope) &&
                  ost_binary_from_double(intercept, &out->intercept);
}

ost_status ost_nifti_header_read(ost_input *input, ost_nifti_form chosen, ost_label_names *names, ost_nifti_header *out,
                                 ost_error *err)
{
    const char *path = ost_input_path(input);
    raw_header raw;
    scale lengths;
    memset(out, 0, sizeof *out);
    ost_status status = read_raw(input, &raw, out, err);
    if (status == OST_OK)
        status = check_raw(path, &raw, out, err);
    if (status != OST_OK)
        return status;

    double pixdim[3];
    for (int a = 0; a < 3; a++)
        pixdim[a] = out->version == 1 ? (double)raw.one.pixdim[a + 1] : raw.two.pixdim[a + 1];
    nifti_set_debug_level(0);
    nifti_image *nim = out->version == 1 ? nifti_convert_n1hdr2nim(raw.one, NULL)
                                         : nifti_convert_n2hdr2nim(raw.two, NULL);
    if (!nim)
        return ost_fail(err, OST_ERR_INPUT, "%s: libnifti rejects the header", path);
    status = find_scale(path, out->version, nim->xyz_units, &lengths, err);
    find_scaling(nim, out);
    if (status == OST_OK)
        status = find_affine(path, nim, pixdim, &lengths, chosen, out, err);
    nifti_image_free(nim);
    if (status == OST_OK)
        status = ost_nifti_extensions_read(input, out->pair ? UINT64_MAX : out->image_at, out->swap, &out->meta, names,
                                           err);
    if (status == OST_OK)
        take_exact(out);
    return status;
}

#else
typedef int ost_nifti_header_is_absent;
#endif
