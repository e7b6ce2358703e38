/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon diff`: shows how two grids differ, from the verdict down to single voxels.
 *
 * Two grids are equal if their geometry and all their voxels are equal. Facts in a file's header
 * (such as the glenoid's position) affect neither voxels nor the verdict; they are compared and
 * printed separately.
 */
#include <string.h>

#include "app/diff/compare.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"

static json_t *voxel_json(const diff_voxel *v, const loaded_volume *a, const loaded_volume *b)
{
    const ost_geometry *g = &a->volume.geometry;
    json_t *row = json_object();
    put(row, "ijk", json_pack("[i,i,i]", v->at[0], v->at[1], v->at[2]));
    put_mm3(row, "mm", (ost_pm3){g->origin.x + v->at[0] * g->spacing.x, g->origin.y + v->at[1] * g->spacing.y,
                                 g->origin.z + v->at[2] * g->spacing.z});
    put_integer(row, "a", v->a);
    put_integer(row, "b", v->b);
    put_text(row, "class", diff_kind_name(diff_kind_of(v->a, v->b, a->threshold, b->threshold)));
    return row;
}

static void put_geometry(json_t *o, const char *key, const char *name, const loaded_volume *in)
{
    static const char *const kind[] = {"ct", "bone", "tool"};
    json_t *row = json_object();
    put_text(row, "file", name);
    put_text(row, "kind", kind[in->kind]);
    put_dims(row, "dims", in->volume.geometry.dims);
    put_mm3(row, "spacing_mm", in->volume.geometry.spacing);
    put_mm3(row, "origin_mm", in->volume.geometry.origin);
    put(o, key, row);
}

static void put_result(const app_state *app, const loaded_volume *a, const loaded_volume *b, const diff_result *r)
{
    json_t *o = app->result, *chunks = json_array(), *classes = json_array(), *patterns = json_array(),
           *voxels = json_array();
    put_bool(o, "equal", r->equal);
    put_bool(o, "same_dims", r->same_dims);
    put_bool(o, "same_spacing", r->same_spacing);
    put_bool(o, "same_origin", r->same_origin);
    put_bool(o, "rounded_geometry", r->rounded_geometry);
    put(o, "pattern", r->class ? json_string(r->class) : json_null());
    put(o, "different_voxels", r->same_dims ? json_integer(r->different) : json_null());
    for (int k = 0; k < DIFF_KIND_COUNT && r->same_dims; k++) {
        json_t *row = json_object();
        put_text(row, "name", diff_kind_name((diff_kind)k));
        put_integer(row, "voxels", r->count[k]);
        append(classes, row);
    }
    for (int i = 0; i < r->pattern_count; i++) {
        json_t *row = json_object();
        put_text(row, "name", r->patterns[i].name);
        put_text(row, "text", r->patterns[i].text);
        append(patterns, row);
    }
    for (size_t c = 0; c < r->chunk_count; c++) {
        const diff_chunk *chunk = &r->chunks[c];
        json_t *row = json_object();
        put(row, "chunk", json_pack("[i,i,i]", chunk->at[0], chunk->at[1], chunk->at[2]));
        put_integer(row, "different_voxels", chunk->different);
        for (int k = 0; k < DIFF_KIND_COUNT; k++)
            put_integer(row, diff_kind_name((diff_kind)k), chunk->count[k]);
        put(row, "first", voxel_json(&chunk->first, a, b));
        append(chunks, row);
    }
    for (size_t v = 0; v < r->first_count; v++)
        append(voxels, voxel_json(&r->first[v], a, b));
    put(o, "classes", classes);
    put(o, "patterns", patterns);
    put_integer(o, "chunk", r->chunk_size);
    put(o, "chunks", chunks);
    put(o, "voxels", voxels);
}

/* Prints and stores the header facts that differ, ordered by key. A missing value is stored as null. */
static void put_notes(const app_state *app, const ost_meta *a, const ost_meta *b)
{
    json_t *notes = json_array();
    const ost_meta *side[2] = {a, b};
    for (int s = 0; s < 2; s++)
        for (int i = 0; i < side[s]->count; i++) {
            const char *key = side[s]->entry[i].key, *va = ost_meta_get(a, key), *vb = ost_meta_get(b, key);
            if ((va && vb && strcmp(va, vb) == 0) || (s == 1 && va))
                continue;
            json_t *row = json_object();
            put_text(row, "key", key);
            put(row, "a", va ? json_string(va) : json_null());
            put(row, "b", vb ? json_string(vb) : json_null());
            append(notes, row);
            print_line(app, "  note %s: %s against %s (decides no voxel)", key, va ? va : "none", vb ? vb : "none");
        }
    put(app->result, "notes", notes);
}

static void print_result(const app_state *app, const char *name_a, const char *name_b, const loaded_volume *a,
                         const loaded_volume *b, const diff_result *r, int64_t limit)
{
    char n[FORMAT_TEXT], m[FORMAT_TEXT];
    if (r->equal) {
        print_line(app, "equal: %s and %s, %s voxels", name_a, name_b, format_dims(n, a->volume.geometry.dims));
        if (r->rounded_geometry)
            print_line(app, "  spacing or origin: the same number to the precision of a float32, not to the picometre");
        return;
    }
    if (!r->same_dims)
        print_line(app, "different: %s and %s differ in dims, so no voxel was compared", name_a, name_b);
    else
        print_line(app, "different: %s of %s voxels, in %zu of %s chunks", format_count(n, r->different),
                   format_count(m, ost_dims_count(a->volume.geometry.dims)), r->chunk_count,
                   format_count((char[FORMAT_TEXT]){0}, ost_dims_count(r->chunk_dims)));
    for (int i = 0; i < r->pattern_count; i++)
        print_line(app, "  %s: %s", r->patterns[i].name, r->patterns[i].text);
    for (int k = 0; k < DIFF_KIND_COUNT; k++)
        if (r->count[k])
            print_line(app, "  %-8s %12s  %s", diff_kind_name((diff_kind)k), format_count(n, r->count[k]),
                       diff_kind_text((diff_kind)k));
    if (!r->different || limit == 0)
        return;
    print_line(app, "  between voxels (%d, %d, %d) and (%d, %d, %d); the first:", r->box.lo[0], r->box.lo[1],
               r->box.lo[2], r->box.hi[0] - 1, r->box.hi[1] - 1, r->box.hi[2] - 1);
    for (size_t v = 0; v < r->first_count; v++)
        print_line(app, "    (%d, %d, %d)  A %d  B %d  %s", r->first[v].at[0], r->first[v].at[1], r->first[v].at[2],
                   r->first[v].a, r->first[v].b,
                   diff_kind_name(diff_kind_of(r->first[v].a, r->first[v].b, a->threshold, b->threshold)));
}

ost_status cmd_diff(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *name_a = NULL, *name_b = NULL, *html = NULL;
    int64_t limit = 10;
    int chunk = 1;
    const operand operands[] = {
        {"A", &name_a, "no grids given; expected two"}, {"B", &name_b, "no second grid given"}, {0}};
    const option options[] = {
        {.name = "html", .kind = OPTION_OUTPUT, .out = &html, .value = "FILE",
         .help = "write a page with slices, a view of the surface with the most differences, a map of the chunks "
                 "and the voxels"},
        {.name = "limit", .kind = OPTION_INTEGER, .out = &limit, .value = "N", .min = 0, .max = 100000,
         .help = "number of voxels to print (default: 10)"},
        {.name = "chunk", .kind = OPTION_CHOICE, .out = &chunk, .value = "16|32|64",
         .help = "edge length of the chunks for the counts, in voxels (default: 32)"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "A B [--html FILE] [options]",
        .about = "Prints whether two grids differ, and in which pattern, chunks and voxels. A and B\n"
                 "are two bones, two CTs or two tools. They can also be two bundles of osteon\n"
                 "validate, whose digests are compared for each stage, tick and chunk.",
        .operands = operands,
        .options = options,
        .notes = "Exit status 0 if they are equal (same dimensions, spacing, origin and voxels), 1 if\n"
                 "they differ. Two lengths are equal if they differ by at most 2^-23 of their size,\n"
                 "the precision of float32 in a NIfTI file. Other facts in the headers are not\n"
                 "compared. A text file is first converted into a bone, as by osteon import. Two\n"
                 "bundles are equal if every case of both was compared and is equal.",
        .example = "  osteon diff scapula.nrrd reamed.nrrd --html difference.html\n"
                   "  osteon diff our-bundle their-bundle",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (html && (status = out_check(app, html, "html|htm", err)) != OST_OK)
        return status;
    if (diff_is_folder(name_a) != diff_is_folder(name_b))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s is a folder and %s is not; expected two grids, two tools or two bundles",
                        diff_is_folder(name_a) ? name_a : name_b, diff_is_folder(name_a) ? name_b : name_a);
    if (diff_is_folder(name_a)) {
        if (html)
            return usage_error(app, err, "--html needs grids, not bundles");
        return diff_bundles(app, name_a, name_b, limit, err);
    }
    loaded_volume a = {0}, b = {0};
    diff_result r = {0};
    status = load_volume(app, name_a, &a, err);
    if (status == OST_OK)
        status = load_volume(app, name_b, &b, err);
    if (status == OST_OK && (a.kind == LOAD_TOOL) != (b.kind == LOAD_TOOL))
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s is a tool and %s is not; expected two grids, two tools or two bundles",
                          a.kind == LOAD_TOOL ? name_a : name_b, a.kind == LOAD_TOOL ? name_b : name_a);
    progress_show(NULL, "comparing", 0);
    if (status == OST_OK)
        status = diff_compare(&a, &b, 16 << chunk, (size_t)limit, &r, err);
    if (status == OST_OK && html)
        status = diff_html(html, name_a, name_b, &a, &b, &r, err);
    if (status == OST_OK) {
        put_geometry(app->result, "a", name_a, &a);
        put_geometry(app->result, "b", name_b, &b);
        put_result(app, &a, &b, &r);
        print_result(app, name_a, name_b, &a, &b, &r, limit);
        put_notes(app, &a.volume.meta, &b.volume.meta);
        if (html) {
            put_text(app->result, "html", html);
            print_line(app, "  page: %s", html);
        }
        status = r.equal ? OST_OK : OST_ERR_DIFFER;
    }
    diff_free(&r);
    ost_volume_free(&a.volume);
    ost_volume_free(&b.volume);
    return status;
}
