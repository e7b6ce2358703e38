/* SPDX-License-Identifier: Apache-2.0 */
#include "app/diff/diff.h"

#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"

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

void diff_report(const app_state *app, const diff_args *args, const loaded_volume *a, const loaded_volume *b,
                 const diff_result *r)
{
    put_geometry(app->result, "a", args->name_a, a);
    put_geometry(app->result, "b", args->name_b, b);
    put_result(app, a, b, r);
    print_result(app, args->name_a, args->name_b, a, b, r, args->limit);
    put_notes(app, &a->volume.meta, &b->volume.meta);
}
