/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon segment`: divides a CT into bones and writes them as a label map.
 */
#include <math.h>
#include <osteon/segment.h>
#include <stdio.h>
#include <string.h>

#include "app/input/load.h"
#include "app/common/print.h"
#include "app/common/result.h"

enum { CUTS_MAX = OPTION_LIST_MAX * 2, SHOWN = 10, THRESHOLD = 120, AIR = -200 };

/* Parses "a,b,...", a list of `count` decimals in millimetres. */
static bool parse_lengths(const char *text, int count, ost_pm *out)
{
    char copy[256], *at = copy;
    if ((size_t)snprintf(copy, sizeof copy, "%s", text) >= sizeof copy)
        return false;
    for (int i = 0; i < count; i++) {
        char *comma = strchr(at, ',');
        if ((comma != NULL) != (i + 1 < count))
            return false;
        if (comma)
            *comma = '\0';
        if (ost_pm_parse(at, &out[i], NULL) != OST_OK)
            return false;
        at = comma ? comma + 1 : at;
    }
    return true;
}

static ost_status parse_cuts(const app_state *app, const option_list *balls, const option_list *planes,
                             ost_segment_cut cuts[CUTS_MAX], size_t *count, ost_error *err)
{
    for (int i = 0; i < balls->count; i++) {
        ost_pm v[4];
        if (!parse_lengths(balls->value[i], 4, v) || v[3] <= 0)
            return usage_error(app, err,
                               "--cut-ball '%.80s': expected X,Y,Z,RADIUS in millimetres, such as -120,190,-160,24",
                               balls->value[i]);
        cuts[(*count)++] = (ost_segment_cut){.at = {v[0], v[1], v[2]}, .radius = v[3]};
    }
    for (int i = 0; i < planes->count; i++) {
        ost_pm v[6];
        if (!parse_lengths(planes->value[i], 6, v) || (!v[3] && !v[4] && !v[5]))
            return usage_error(app, err,
                               "--cut-plane '%.80s': expected X,Y,Z,NX,NY,NZ, a point in millimetres and a direction",
                               planes->value[i]);
        cuts[(*count)++] = (ost_segment_cut){.at = {v[0], v[1], v[2]}, .normal = {v[3], v[4], v[5]}};
    }
    return OST_OK;
}

static double voxel_mm3(const ost_geometry *g)
{
    return ost_pm_to_mm(g->spacing.x) * ost_pm_to_mm(g->spacing.y) * ost_pm_to_mm(g->spacing.z);
}

/* Returns the label at a position, or -1 if it is outside the grid. */
static int label_at(const ost_volume *labels, ost_pm3 at)
{
    const ost_geometry *g = &labels->geometry;
    const ost_pm p[3] = {at.x, at.y, at.z}, o[3] = {g->origin.x, g->origin.y, g->origin.z},
                 s[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    size_t index = 0;
    for (int a = 2; a >= 0; a--) {
        const double i = floor((double)(p[a] - o[a]) / (double)s[a] + 0.5);
        if (!(i >= 0 && i < n[a]))
            return -1;
        index = index * (size_t)n[a] + (size_t)i;
    }
    return labels->voxels[index];
}

static void put_segments(const app_state *app, const ost_geometry *g, const ost_segment *segments, size_t count)
{
    json_t *list = json_array();
    for (size_t k = 0; k < count; k++) {
        const ost_segment *s = &segments[k];
        json_t *o = json_object();
        put_integer(o, "label", (int64_t)k + 1);
        put_integer(o, "voxels", (int64_t)s->voxels);
        put_integer(o, "filled", (int64_t)s->filled);
        put_real(o, "volume_mm3", (double)(s->voxels + s->filled) * voxel_mm3(g));
        put(o, "box_lo", json_pack("[i,i,i]", s->box.lo[0], s->box.lo[1], s->box.lo[2]));
        put(o, "box_hi", json_pack("[i,i,i]", s->box.hi[0], s->box.hi[1], s->box.hi[2]));
        append(list, o);
    }
    put(app->result, "segments", list);
}

static void print_segments(const app_state *app, const ost_geometry *g, const ost_segment *segments, size_t count)
{
    const double mm[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)},
                 origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    if (count)
        print_line(app, "  label   volume mm3   from mm (L, P, S)            to mm");
    for (size_t k = 0; k < count && k < SHOWN; k++) {
        const ost_segment *s = &segments[k];
        double lo[3], hi[3];
        for (int a = 0; a < 3; a++) {
            lo[a] = origin[a] + (s->box.lo[a] - 0.5) * mm[a];
            hi[a] = origin[a] + (s->box.hi[a] - 0.5) * mm[a];
        }
        print_line(app, "  %5zu %12.0f   %8.1f %8.1f %8.1f   %8.1f %8.1f %8.1f", k + 1,
                   (double)(s->voxels + s->filled) * voxel_mm3(g), lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]);
    }
    if (count > SHOWN)
        print_line(app, "  ... and %zu smaller ones", count - SHOWN);
}

/* Stores the options as facts of the label map. */
static ost_status set_facts(ost_meta *meta, const ost_meta *of_ct, const ost_segment_options *o,
                            const option_list *balls, const option_list *planes, ost_error *err)
{
    char text[OST_META_VALUE];
    *meta = *of_ct;
    ost_status status = ost_meta_set(meta, OST_META_KIND, "labels", err);
    snprintf(text, sizeof text, "%d", (int)o->threshold);
    if (status == OST_OK)
        status = ost_meta_set(meta, "segment_threshold", text, err);
    snprintf(text, sizeof text, "%d", (int)(o->growth ? o->growth : o->threshold));
    if (status == OST_OK)
        status = ost_meta_set(meta, "segment_growth", text, err);
    snprintf(text, sizeof text, "%llu", (unsigned long long)o->min_voxels);
    if (status == OST_OK)
        status = ost_meta_set(meta, "segment_min_voxels", text, err);
    snprintf(text, sizeof text, "%d", (int)o->air);
    if (status == OST_OK && o->fill)
        status = ost_meta_set(meta, "segment_fill_air", text, err);
    for (int i = 0; i < balls->count + planes->count && status == OST_OK; i++) {
        char key[OST_META_KEY];
        const bool ball = i < balls->count;
        snprintf(key, sizeof key, "segment_%s_%d", ball ? "ball" : "plane", (ball ? i : i - balls->count) + 1);
        status = ost_meta_set(meta, key, ball ? balls->value[i] : planes->value[i - balls->count], err);
    }
    return status;
}

ost_status cmd_segment(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *name = NULL, *out = NULL, *orientation = NULL;
    int64_t threshold = THRESHOLD, growth = 0, air = AIR;
    option_decimal min_volume = {.text = NULL};
    option_list balls = {0}, planes = {0};
    ost_pm3 at = {0, 0, 0};
    dicom_options dicom = {.series = NULL};
    bool fill = false, has_at = false, compress = false;
    const operand operands[] = {{"CT", &name, "no CT given"}, {0}};
    const option options[] = {
        {.name = "out", .kind = OPTION_TEXT, .out = &out, .value = "FILE", .required = true,
         .help = "the label map: .nrrd, .nii or .nii.gz"},
        HEADING("what is bone"),
        {.name = "threshold", .kind = OPTION_INTEGER, .out = &threshold, .value = "HU", .min = 1, .max = 32767,
         .help = "density that a bone reaches somewhere (default: 120)"},
        {.name = "growth", .kind = OPTION_INTEGER, .out = &growth, .value = "HU", .min = 1, .max = 32767,
         .help = "lowest density of the other voxels of a bone (default: as --threshold)"},
        {.name = "min-volume", .kind = OPTION_DECIMAL, .out = &min_volume, .value = "MM3",
         .help = "volume of the smallest component that gets a label (default: 100)"},
        {.name = "fill", .kind = OPTION_FLAG, .out = &fill,
         .help = "give holes inside a bone its label, unless they have air"},
        {.name = "air", .kind = OPTION_INTEGER, .out = &air, .value = "HU", .min = -32768, .max = 32767,
         .help = "density below which a voxel is air (default: -200)"},
        HEADING("separating bones that touch"),
        {.name = "cut-ball", .kind = OPTION_LIST, .out = &balls, .value = "X,Y,Z,R",
         .help = "no voxel within R mm of this position gets a label; may be given several times"},
        {.name = "cut-plane", .kind = OPTION_LIST, .out = &planes, .value = "X,Y,Z,NX,NY,NZ",
         .help = "no voxel on the side of this plane to which N points gets a label; may be given several times"},
        HEADING("reading and reporting"),
        {.name = "at", .kind = OPTION_POINT, .out = &at, .given = &has_at, .value = "X,Y,Z",
         .help = "report the label at this position"},
        {.name = "orientation", .kind = OPTION_TEXT, .out = &orientation, .value = "XYZ",
         .help = "directions of the axes of a CT whose file does not state them, such as LPS or RAS"},
        DICOM_OPTIONS(dicom),
        COMPRESS_OPTION(compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "CT --out LABELS.nrrd [options]",
        .about = "Divides a CT (NRRD, NIfTI, MetaImage or a folder of DICOM files) into bones:\n"
                 "components of dense voxels that share faces. Label 1 is the largest. osteon import\n"
                 "--mask LABELS.nrrd:1 makes a bone of it.",
        .operands = operands,
        .options = options,
        .notes = "Lengths are in millimetres in the patient's axes (LPS), densities in HU. The label map\n"
                 "is equal on every machine.",
        .example = "  osteon segment shoulder.nii.gz --out labels.nrrd\n"
                   "  osteon segment shoulder.nii.gz --cut-ball -142,196,-159,26 --out labels.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) ||
        (status = out_check(app, out, "nrrd|nii|nii.gz", err)) != OST_OK)
        return status;
    ost_segment_cut cuts[CUTS_MAX];
    ost_segment_options segment = {.threshold = (int32_t)threshold, .growth = (int32_t)growth, .cuts = cuts,
                                   .fill = fill, .air = (int32_t)air};
    ost_volume_options read = {.clamp = false};
    ost_volume_report report;
    ost_volume ct = {0}, labels = {0};
    ost_segment *segments = NULL;
    size_t count = 0;
    int64_t min_um3 = INT64_C(100000000000); /* 1e-9 mm3 */
    if (min_volume.text &&
        (min_volume.value.negative || !ost_decimal_scale(&min_volume.value, 1000000000, &min_um3, NULL)))
        return usage_error(app, err, "--min-volume '%.40s': expected a volume from 0 to 9e9 mm3", min_volume.text);
    if (growth > threshold)
        return usage_error(app, err, "--growth %lld: expected at most the threshold, %lld", (long long)growth,
                           (long long)threshold);
    if (orientation && strlen(orientation) != 3)
        return usage_error(app, err, "--orientation '%s': expected three letters, such as LPS or RAS", orientation);
    if (orientation)
        memcpy(read.orientation, orientation, sizeof read.orientation);
    load_dicom_options(&dicom, &read);
    status = parse_cuts(app, &balls, &planes, cuts, &segment.cut_count, err);
    if (status == OST_OK)
        status = ost_volume_read(name, &read, &ct, &report, err);
    if (status == OST_OK) {
        const double least = (double)min_um3 * 1e-9 / voxel_mm3(&ct.geometry);
        segment.min_voxels = least > 1 ? (uint64_t)ceil(least) : 1;
        status = ost_segment_volume(&ct, &segment, &labels, &segments, &count, err);
        if (status != OST_OK)
            (void)ost_fail_context(err, "%s", name);
    }
    if (status == OST_OK)
        status = set_facts(&labels.meta, &ct.meta, &segment, &balls, &planes, err);
    if (status == OST_OK)
        status = ost_volume_write(out, &labels, &(ost_write_options){.compress = compress}, err);
    if (status == OST_OK) {
        load_warn_orientation(app, name, &ct.meta);
        load_warn_dicom(app, name, &report.dicom);
        put_text(app->result, "in", name);
        put_text(app->result, "out", out);
        put_integer(app->result, "components", (int64_t)count);
        put_segments(app, &labels.geometry, segments, count);
        print_line(app, "%s: %zu component%s of %g mm3 or more", out, count, count == 1 ? "" : "s",
                   (double)segment.min_voxels * voxel_mm3(&ct.geometry));
        print_segments(app, &labels.geometry, segments, count);
        if (!count)
            warn(app, "%s: no component is so large; a lower --threshold or --min-volume finds more", name);
        if (has_at) {
            const int label = label_at(&labels, at);
            put_integer(app->result, "label_at", label);
            print_line(app, "  at %.9g,%.9g,%.9g: %s", ost_pm_to_mm(at.x), ost_pm_to_mm(at.y), ost_pm_to_mm(at.z),
                       label < 0 ? "outside the CT" : label ? "" : "no label");
            if (label > 0)
                print_line(app, "    label %d", label);
        }
    }
    ost_segments_free(segments);
    ost_volume_free(&labels);
    ost_volume_free(&ct);
    return status;
}
