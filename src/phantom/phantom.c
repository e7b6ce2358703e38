/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Selects a generated bone by its name, checks the options, and calls the function that makes the
 * bone.
 *
 *   kind -> box of Table 3.1, scaled --spacing--> dims -> right side
 *        -> mirrored if the left side is requested -> meta
 */
#include <stdio.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "phantom/scan.h"

#define UM INT64_C(1000000)
#define VOXELS_MAX (INT64_C(1) << 31)
#define SCALE_MIN 0.125
#define SCALE_MAX 8.0

/*
 * A box of a generated bone, in micrometres. Its physical size is that of Table 3.1: dims times spacing. corner_um is
 * the position of the box's first corner in the patient, for the right side. The distance from the corner of the
 * scapula's box to the corner of the glenoid's box is a whole number of voxels, so that the glenoid phantom is a part
 * of the scapula phantom.
 */
typedef struct box {
    const char *name;
    int32_t dims[3];
    int32_t spacing_um[3];
    int32_t corner_um[3];
} box;

enum { SCAPULA_X = -170160, SCAPULA_Y = -69990, SCAPULA_Z = -100500, CROP_I = 25, CROP_J = 71, CROP_K = 132,
       ASIDE_I = 80 };

static const box BOXES[OST_PHANTOM_COUNT] = {
    [OST_PHANTOM_SCAPULA] = {"scapula", {256, 234, 201}, {470, 470, 1000}, {SCAPULA_X, SCAPULA_Y, SCAPULA_Z}},
    [OST_PHANTOM_GLENOID] = {"glenoid",
                             {49, 81, 41},
                             {470, 470, 1000},
                             {SCAPULA_X + 470 * CROP_I, SCAPULA_Y + 470 * CROP_J, SCAPULA_Z + 1000 * CROP_K}},
    [OST_PHANTOM_TRABECULAR] = {"trabecular", {156, 156, 313}, {32, 32, 32}, {0, 0, 0}},
    [OST_PHANTOM_TRABECULAR2] = {"trabecular2", {314, 316, 360}, {32, 32, 32}, {0, 0, 0}},
    [OST_PHANTOM_FOAM] = {"foam", {314, 320, 604}, {32, 32, 32}, {0, 0, 0}},
    /* The box of the scapula phantom, extended to the side by an integral number of voxels. */
    [OST_PHANTOM_SHOULDER] = {"shoulder",
                              {256 + ASIDE_I, 234, 201},
                              {470, 470, 1000},
                              {SCAPULA_X - 470 * ASIDE_I, SCAPULA_Y, SCAPULA_Z}},
};

const char *ost_phantom_name(ost_phantom_kind kind)
{
    return (int)kind >= 0 && kind < OST_PHANTOM_COUNT ? BOXES[kind].name : "unknown";
}

/*
 * Returns `um` micrometres times `scale` in picometres, rounded half up. The computation consists of one product
 * and one floor, so the result is the same on every machine.
 */
static ost_pm scaled(int64_t um, double scale)
{
    double pm = (double)(um * UM) * scale + 0.5; /* |um| < 2^18 and scale <= 8, so the product is below 2^41 */
    int64_t integer = (int64_t)pm;
    return integer - ((double)integer > pm);
}

static ost_status lay_out(const box *b, const ost_phantom_options *o, double scale, ost_geometry *g, ost_scan *scan,
                          ost_error *err)
{
    const ost_pm requested[3] = {o->spacing.x, o->spacing.y, o->spacing.z};
    const bool is_scapula = b == &BOXES[OST_PHANTOM_GLENOID] || b == &BOXES[OST_PHANTOM_SHOULDER];
    const box *integer = &BOXES[is_scapula ? OST_PHANTOM_SCAPULA : b - BOXES];
    int32_t dims[3];
    ost_pm spacing[3], corner2[3], whole2[3];
    for (int a = 0; a < 3; a++) {
        spacing[a] = requested[a] ? requested[a] : (ost_pm)b->spacing_um[a] * UM;
        if (spacing[a] < OST_SPACING_MIN || spacing[a] > OST_SPACING_MAX) {
            char text[OST_PM_TEXT];
            return ost_fail(err, OST_ERR_RANGE, "a spacing of %s mm along %c: expected 0.001 to 100 mm",
                            ost_pm_format(spacing[a], text), "xyz"[a]);
        }
        int64_t n = ost_ceil_div(scaled((int64_t)b->dims[a] * b->spacing_um[a], scale), spacing[a]);
        if (n > OST_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE,
                            "a %s would have %lld voxels along %c; expected at most %d: increase the spacing", b->name,
                            (long long)n, "xyz"[a], OST_DIM_MAX);
        dims[a] = (int32_t)n;
        corner2[a] = 2 * scaled(b->corner_um[a], scale);
        whole2[a] = 2 * scaled(integer->corner_um[a], scale);
    }
    g->dims = (ost_dims){dims[0], dims[1], dims[2]};
    if (ost_dims_count(g->dims) > VOXELS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a %s of %d x %d x %d voxels: a generated bone has at most 2^31", b->name,
                        dims[0], dims[1], dims[2]);
    g->spacing = (ost_pm3){spacing[0], spacing[1], spacing[2]};
    /*
     * If the spacing is an odd number of picometres, the centre of the first voxel is wrong by half a picometre.
     * This error is the same on every machine.
     */
    g->origin = (ost_pm3){ost_floor_div(corner2[0] + spacing[0], 2), ost_floor_div(corner2[1] + spacing[1], 2),
                          ost_floor_div(corner2[2] + spacing[2], 2)};
    scan->corner = (ost_pm3){corner2[0], corner2[1], corner2[2]};
    scan->extent = (ost_pm3){whole2[0], whole2[1], whole2[2]};
    return ost_geometry_check(g, b->name, err);
}

/*
 * Mirrors the volume at x = 0, which is the midline of the body. The left scapula therefore has the negated x
 * coordinates of the right scapula.
 */
static void mirror(ost_volume *v)
{
    ost_geometry *g = &v->geometry;
    size_t rows = (size_t)g->dims.y * (size_t)g->dims.z, n = (size_t)g->dims.x;
    for (size_t r = 0; r < rows; r++) {
        int16_t *row = v->voxels + r * n;
        for (size_t i = 0; i < n / 2; i++) {
            int16_t t = row[i];
            row[i] = row[n - 1 - i];
            row[n - 1 - i] = t;
        }
    }
    g->origin.x = -(g->origin.x + (g->dims.x - 1) * g->spacing.x);
}

/* Negates the first number of a vector such as "-12.5 3 4". */
static ost_status mirror_vector(ost_meta *meta, const char *key, ost_error *err)
{
    const char *value = ost_meta_get(meta, key);
    if (!value)
        return OST_OK;
    char text[OST_META_VALUE];
    snprintf(text, sizeof text, "%s%s", value[0] == '-' ? "" : "-", value[0] == '-' ? value + 1 : value);
    return ost_meta_set(meta, key, text, err);
}

static ost_status describe(ost_volume *v, const box *b, uint64_t seed, const char *side, ost_error *err)
{
    char text[32];
    snprintf(text, sizeof text, "%llu", (unsigned long long)seed);
    ost_status status = ost_meta_set(&v->meta, OST_META_KIND, "ct", err);
    if (status == OST_OK)
        status = ost_meta_set(&v->meta, "phantom", b->name, err);
    if (status == OST_OK)
        status = ost_meta_set(&v->meta, "seed", text, err);
    if (status == OST_OK && side)
        status = ost_meta_set(&v->meta, OST_META_SIDE, side, err);
    return status;
}

ost_status ost_phantom_make(ost_phantom_kind kind, const ost_phantom_options *options, ost_volume *out, ost_error *err)
{
    static const ost_phantom_options defaults;
    const ost_phantom_options *o = options ? options : &defaults;
    memset(out, 0, sizeof *out);
    if ((int)kind < 0 || kind >= OST_PHANTOM_COUNT)
        return ost_fail(err, OST_ERR_USAGE, "no phantom %d", (int)kind);
    double scale = o->scale == 0 ? 1 : o->scale;
    if (!(scale >= SCALE_MIN && scale <= SCALE_MAX))
        return ost_fail(err, OST_ERR_RANGE, "a scale of %g: expected %g to %g", scale, SCALE_MIN, SCALE_MAX);

    const box *b = &BOXES[kind];
    bool sided = kind == OST_PHANTOM_SCAPULA || kind == OST_PHANTOM_GLENOID || kind == OST_PHANTOM_SHOULDER;
    ost_scan scan = {.volume = out,
                     .scale = scale,
                     .seed = o->seed ? o->seed : 1,
                     .has_humerus = kind == OST_PHANTOM_SHOULDER,
                     .options = o};
    ost_geometry geometry;
    ost_status status = lay_out(b, o, scale, &geometry, &scan, err);
    if (status == OST_OK)
        status = ost_volume_init(out, &geometry, err);
    if (status == OST_OK)
        status = describe(out, b, scan.seed, sided ? (o->left ? "left" : "right") : NULL, err);
    if (status == OST_OK)
        status = sided ? ost_scan_scapula(&scan, err) : ost_scan_core(&scan, kind, err);
    if (status == OST_OK && o->left) {
        mirror(out);
        static const char *const vectors[] = {OST_META_GLENOID_AT, OST_META_GLENOID_AXIS, OST_META_TRIGONUM,
                                              OST_META_INFERIOR_ANGLE, OST_SCAN_HEAD};
        for (int i = 0; i < 5 && status == OST_OK; i++)
            status = mirror_vector(&out->meta, vectors[i], err);
    }
    if (status != OST_OK)
        ost_volume_free(out);
    return status;
}

