/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/export.h"

#include <errno.h>
#include <jansson.h>
#include <osteon/io.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "validation/dump/dump.h"
#include "validation/signal_cleanup.h"
#include "validation/scene.h"

enum { PATH = 4096 };

static ost_status join(char path[PATH], const char *folder, const char *name, ost_error *err)
{
    const int n = snprintf(path, PATH, "%s/%s", folder, name);
    return n > 0 && n < PATH ? OST_OK : ost_fail(err, OST_ERR_USAGE, "%.60s...: the name is too long", folder);
}

static ost_status open_file(const char *folder, const char *name, char path[PATH], FILE **out, ost_error *err)
{
    ost_status status = join(path, folder, name, err);
    *out = status == OST_OK ? fopen(path, "wb") : NULL;
    return status != OST_OK || *out ? status : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
}

static ost_status close_file(FILE *f, const char *path, ost_error *err)
{
    const bool bad = ferror(f) != 0;
    return fclose(f) != 0 || bad ? ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno)) : OST_OK;
}

static ost_status put_json(const char *folder, const char *name, json_t *value, ost_error *err)
{
    char path[PATH];
    FILE *f = NULL;
    ost_status status = value ? open_file(folder, name, path, &f, err)
                              : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    if (status == OST_OK) {
        const bool dumped = json_dumpf(value, f, JSON_INDENT(1) | JSON_SORT_KEYS) == 0 && fputc('\n', f) != EOF;
        status = close_file(f, path, err);
        if (status == OST_OK && !dumped)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", path);
    }
    json_decref(value);
    return status;
}

/* Writes the samples as exact decimals, in the order in which the case scatters them. */
static ost_status put_samples(const char *folder, const scene *s, ost_error *err)
{
    char path[PATH], x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    FILE *f;
    ost_status status = open_file(folder, "samples.txt", path, &f, err);
    if (status != OST_OK)
        return status;
    fputs("# x_mm y_mm z_mm density, in the order in which they are scattered\n", f);
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        fprintf(f, "%s %s %s %d\n", ost_pm_format(one->x, x), ost_pm_format(one->y, y), ost_pm_format(one->z, z),
                (int)one->density);
    }
    return close_file(f, path, err);
}

/* Writes a mesh as OBJ with the exact integers of the lattice. In a face, vertices are counted from 1. */
static ost_status put_obj(const char *folder, const char *name, const ost_snapped_mesh *m, ost_error *err)
{
    char path[PATH];
    FILE *f;
    ost_status status = open_file(folder, name, path, &f, err);
    if (status != OST_OK)
        return status;
    fprintf(f, "# vertices in units of voxel / 2^%d from the tool grid's corner\n", m->fraction_bits);
    for (size_t v = 0; v < m->vertex_count; v++)
        fprintf(f, "v %d %d %d\n", (int)m->vertices[v][0], (int)m->vertices[v][1], (int)m->vertices[v][2]);
    for (size_t t = 0; t < m->triangle_count; t++)
        fprintf(f, "f %u %u %u\n", m->triangles[t][0] + 1, m->triangles[t][1] + 1, m->triangles[t][2] + 1);
    return close_file(f, path, err);
}

/* Writes a snapped mesh as STL with floats in millimetres, for programs that snap their meshes themselves. */
static ost_status put_stl(const char *folder, const char *name, const ost_snapped_mesh *m, ost_error *err)
{
    char path[PATH];
    ost_mesh mesh = {0};
    ost_status status = join(path, folder, name, err);
    if (status == OST_OK)
        status = ost_mesh_init(&mesh, m->vertex_count, m->triangle_count, err);
    if (status != OST_OK)
        return status;
    const double unit = (double)m->grid.voxel / (double)(1 << m->fraction_bits);
    for (size_t v = 0; v < m->vertex_count; v++)
        mesh.vertices[v] = (ost_pm3){m->grid.corner.x + (ost_pm)(m->vertices[v][0] * unit),
                                     m->grid.corner.y + (ost_pm)(m->vertices[v][1] * unit),
                                     m->grid.corner.z + (ost_pm)(m->vertices[v][2] * unit)};
    memcpy(mesh.triangles, m->triangles, m->triangle_count * sizeof *mesh.triangles);
    status = ost_mesh_write_stl(path, &mesh, err);
    ost_mesh_free(&mesh);
    return status;
}

/* Writes a mesh as OBJ, as it is before snapping. The coordinates are integers, in picometres. */
static ost_status put_raw(const char *folder, const char *name, const ost_mesh *m, ost_error *err)
{
    char path[PATH];
    FILE *f;
    ost_status status = open_file(folder, name, path, &f, err);
    if (status != OST_OK)
        return status;
    fputs("# vertices in picometres, before snapping\n", f);
    for (size_t v = 0; v < m->vertex_count; v++)
        fprintf(f, "v %lld %lld %lld\n", (long long)m->vertices[v].x, (long long)m->vertices[v].y,
                (long long)m->vertices[v].z);
    for (size_t t = 0; t < m->triangle_count; t++)
        fprintf(f, "f %u %u %u\n", m->triangles[t][0] + 1, m->triangles[t][1] + 1, m->triangles[t][2] + 1);
    return close_file(f, path, err);
}

static json_t *three(int64_t x, int64_t y, int64_t z)
{
    return json_pack("[I,I,I]", (json_int_t)x, (json_int_t)y, (json_int_t)z);
}

static ost_status put_tool(const char *folder, const scene_tool *t, int number, json_t *tools, ost_error *err)
{
    const ost_tool_geometry *g = &t->cutting.grid;
    ost_status status = OST_OK;
    json_t *o = json_pack("{s:i,s:s,s:o,s:I,s:o,s:i,s:b}", "number", number, "rule",
                          t->rule == OST_FILL_PARITY ? "parity" : "winding", "dims",
                          three(g->dims.x, g->dims.y, g->dims.z), "voxel_pm", (json_int_t)g->voxel, "corner_pm",
                          three(g->corner.x, g->corner.y, g->corner.z), "fraction_bits", t->cutting.fraction_bits,
                          "grid_given", t->grid_given);
    for (int part = 0; part < 2 && status == OST_OK; part++) {
        const ost_snapped_mesh *m = part ? &t->noncutting : &t->cutting;
        char name[64];
        if (part && !m->triangle_count)
            continue;
        snprintf(name, sizeof name, "tool-%d%s.obj", number, part ? "-noncutting" : "");
        json_object_set_new(o, part ? "noncutting" : "cutting", json_string(name));
        status = put_obj(folder, name, m, err);
        snprintf(name, sizeof name, "tool-%d%s.stl", number, part ? "-noncutting" : "");
        if (status == OST_OK && m->triangle_count)
            status = put_stl(folder, name, m, err);
        snprintf(name, sizeof name, "tool-%d%s-raw.obj", number, part ? "-noncutting" : "");
        if (status == OST_OK && t->raw[part].triangle_count)
            status = put_raw(folder, name, &t->raw[part], err);
    }
    json_array_append_new(tools, o);
    return status;
}

static json_t *grid_json(const ost_geometry *g)
{
    return json_pack("{s:o,s:o,s:o}", "dims", three(g->dims.x, g->dims.y, g->dims.z), "spacing_pm",
                     three(g->spacing.x, g->spacing.y, g->spacing.z), "origin_pm",
                     three(g->origin.x, g->origin.y, g->origin.z));
}

static json_t *ct_json(const scene *s)
{
    static const char *const duplicates[] = {"error", "first", "last", "max"};
    json_t *o = grid_json(&s->rect);
    json_object_set_new(o, "duplicates", json_string(duplicates[s->duplicates]));
    json_object_set_new(o, "cubic_pm", json_integer((json_int_t)s->cubic));
    json_object_set_new(o, "resample", json_string(ost_resample_name(s->resample)));
    json_object_set_new(o, "chunk_size", json_integer(s->chunk_size));
    json_object_set_new(o, "threshold", json_integer(s->threshold));
    json_object_set_new(o, "samples", json_integer((json_int_t)s->sample_count));
    return o;
}

static ost_status put_case(const char *folder, const plan_case *c, json_t *list, ost_error *err)
{
    scene s;
    ost_digest digest;
    char hex[OST_DIGEST_HEX], name[PLAN_ID], path[PATH], csv[PATH];
    dump_case_folder(c->id, name);
    ost_status status = join(path, folder, name, err);
    if (status == OST_OK && mkdir(path, 0777) != 0)
        status = ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    if (status == OST_OK)
        status = scene_make(c, &s, err);
    if (status != OST_OK)
        return status;
    json_t *tools = json_array();
    status = scene_digest(&s, &digest, err);
    if (status == OST_OK && s.sample_count)
        status = put_samples(path, &s, err);
    for (int t = 0; t < s.tool_count && status == OST_OK; t++)
        status = put_tool(path, &s.tools[t], t, tools, err);
    if (status == OST_OK && s.path.count) {
        status = join(csv, path, "path.csv", err);
        if (status == OST_OK)
            status = ost_path_write_csv(csv, &s.path, err);
    }
    if (status == OST_OK && s.handle_path.count) {
        status = join(csv, path, "handle.csv", err);
        if (status == OST_OK)
            status = ost_path_write_csv(csv, &s.handle_path, err);
    }
    if (status == OST_OK) {
        ost_digest_hex(&digest, hex);
        json_t *o = json_pack("{s:s,s:s,s:o,s:I}", "id", c->id, "input_sha256", hex, "tools", json_incref(tools),
                              "ticks", (json_int_t)s.path.count);
        if (s.sample_count)
            json_object_set_new(o, "ct", ct_json(&s));
        else if (s.path.count) /* without a CT, the case has no voxels, so only the steps are written */
            json_object_set_new(o, "bone", grid_json(&s.rect));
        if (s.path.count)
            json_object_set_new(o, "world",
                                json_pack("{s:b,s:I,s:i}", "sweep", !s.world.sweep_off, "removal_period_ns",
                                          (json_int_t)s.world.removal_period_ns, "handle_rpm", (int)s.handle_rpm));
        status = put_json(path, "case.json", o, err);
        json_array_append_new(list, json_pack("{s:s,s:s,s:s}", "id", c->id, "folder", name, "input_sha256", hex));
    }
    json_decref(tools);
    scene_free(&s);
    return status;
}

ost_status export_cases(const char *folder, const plan *p, ost_error *err)
{
    char seed[32];
    if (mkdir(folder, 0777) != 0)
        return ost_fail(err, OST_ERR_IO, errno == EEXIST ? "%s: already exists; choose a new folder"
                                                         : "%s: cannot make the folder: %s", folder, strerror(errno));
    signal_cleanup_folder(folder);
    json_t *list = json_array();
    ost_status status = OST_OK;
    for (int i = 0; i < p->count && status == OST_OK; i++)
        status = put_case(folder, &p->cases[i], list, err);
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    if (status == OST_OK)
        status = put_json(folder, "cases.json",
                          json_pack("{s:i,s:i,s:s,s:s,s:s,s:O}", "osteon_cases", 1, "arithmetic",
                                    OST_ARITHMETIC_VERSION, "tier", plan_tier_name(p->tier), "seed", seed, "only",
                                    p->only ? p->only : "", "cases", list),
                          err);
    json_decref(list);
    if (status == OST_OK)
        signal_cleanup_folder_gone(folder);
    else
        signal_cleanup_folder_remove(folder);
    return status;
}
