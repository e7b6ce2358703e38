/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dump.h"

#include <errno.h>
#include <jansson.h>
#include <osteon/io.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"

enum { PATH = 4096, FORMAT = 1 };

void dump_case_folder(const char *id, char name[PLAN_ID])
{
    snprintf(name, PLAN_ID, "%s", id);
    for (char *c = name; *c; c++)
        if (*c == '/')
            *c = '-';
}

static ost_status join(char path[PATH], const char *folder, const char *name, ost_error *err)
{
    const int n = snprintf(path, PATH, "%s/%s", folder, name);
    return n > 0 && n < PATH ? OST_OK : ost_fail(err, OST_ERR_USAGE, "%.60s...: the name is too long", folder);
}

/* Writes the name of a record's file without its ending: "rect", "tool-0", "tick-12". */
static void stage_name(const trace_record *r, char name[40])
{
    if (r->stage == TRACE_TOOL || r->stage == TRACE_TICK)
        snprintf(name, 40, "%s-%u", trace_stage_name(r->stage), (unsigned)r->item);
    else
        snprintf(name, 40, "%s", trace_stage_name(r->stage));
}

/* Returns true for stages whose record is one grid, which a dump may contain. The record of a tick has the leaves
   that changed. */
static bool is_grid(trace_stage stage)
{
    return stage == TRACE_RECT || stage == TRACE_CUBIC || stage == TRACE_CHUNKS || stage == TRACE_TOOL ||
           stage == TRACE_FINAL;
}

/* ------------------------------------------------------------------- head */

static ost_status bad_head(const char *path, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %s", path, what);
}

static bool decimal(const char *text, uint64_t *out)
{
    *out = 0;
    size_t n = 0;
    for (; text[n] >= '0' && text[n] <= '9' && n < 19; n++)
        *out = 10 * *out + (uint64_t)(text[n] - '0');
    return n > 0 && !text[n];
}

ost_status dump_read_head(const char *folder, dump_head *out, ost_error *err)
{
    char path[PATH];
    char *bytes;
    size_t size;
    bool absent;
    json_error_t where;
    ost_error why = {0};
    ost_status status = join(path, folder, "dump.json", err);
    *out = (dump_head){.seed = 1};
    if (status != OST_OK)
        return status;
    status = ost_file_read(path, 1 << 20, &bytes, &size, &absent, &why);
    if (status != OST_OK)
        return ost_fail(err, status, "%s%s", why.text, absent ? "; a dump has this file, see docs/spec/dumps.md" : "");
    json_t *o = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, &where);
    free(bytes);
    if (!o)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s", path, where.line, where.text);
    const json_t *format = json_object_get(o, "osteon_dump"), *tier = json_object_get(o, "tier"),
                 *seed = json_object_get(o, "seed"), *only = json_object_get(o, "only"),
                 *program = json_object_get(o, "program"), *arithmetic = json_object_get(o, "arithmetic");
    const char *tier_text = json_string_value(tier);
    bool known = !tier;
    for (int i = 0; tier_text && i < PLAN_TIERS; i++)
        if (strcmp(tier_text, plan_tier_name((plan_tier)i)) == 0) {
            out->tier = (plan_tier)i;
            known = true;
        }
    if (!json_is_integer(format) || json_integer_value(format) != FORMAT)
        status = bad_head(path, "osteon_dump must be 1, the format's version", err);
    else if (arithmetic && json_integer_value(arithmetic) != OST_ARITHMETIC_VERSION)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: arithmetic is %lld; this osteon compares with version %d of docs/spec/arithmetic.md",
                          path, (long long)json_integer_value(arithmetic), OST_ARITHMETIC_VERSION);
    else if (!known)
        status = bad_head(path, "tier must be \"smoke\", \"standard\" or \"full\"", err);
    else if (seed && (!json_is_string(seed) || !decimal(json_string_value(seed), &out->seed)))
        status = bad_head(path, "seed must be a number in quotes, as in \"1\"", err);
    else if (only && (!json_is_string(only) || json_string_length(only) >= sizeof out->only))
        status = bad_head(path, "only must be the beginning of a case's name, as in \"import/0\"", err);
    else if (program && (!json_is_string(program) || json_string_length(program) >= sizeof out->program))
        status = bad_head(path, "program must be a text of less than 200 bytes", err);
    if (status == OST_OK) {
        snprintf(out->only, sizeof out->only, "%s", only ? json_string_value(only) : "");
        snprintf(out->program, sizeof out->program, "%s", program ? json_string_value(program) : "");
    }
    json_decref(o);
    return status;
}

/* ---------------------------------------------------------------- reading */

/* Reads raw voxels, stored as in memory; the file's size must be that of the reference's grid. */
static ost_status read_raw(const char *path, uint64_t bytes, void *to, ost_error *err)
{
    ost_file file;
    ost_status status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return status;
    if ((uint64_t)file.size != bytes)
        status = ost_fail(err, OST_ERR_INPUT, "%s: %lld bytes; the grid of this case and stage has %llu", path,
                          (long long)file.size, (unsigned long long)bytes);
    else
        status = ost_file_fill(path, &file, to, err);
    close(file.fd);
    return status;
}

static ost_status wrong_dims(const char *path, ost_dims has, ost_dims wants, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %d x %d x %d voxels; this case and stage has %d x %d x %d", path, has.x,
                    has.y, has.z, wants.x, wants.y, wants.z);
}

static bool same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Reads a NRRD file. The dimensions are checked before the voxels are read, because a header may state any size. */
static ost_status read_nrrd(const char *path, ost_dims dims, uint32_t voxel_bytes, void *to, ost_error *err)
{
    ost_geometry g;
    ost_meta meta;
    ost_status status = ost_volume_read_header(path, &g, &meta, NULL, err);
    if (status == OST_OK && !same_dims(g.dims, dims))
        status = wrong_dims(path, g.dims, dims, err);
    if (status != OST_OK)
        return status;
    ost_volume volume = {0};
    status = ost_volume_read(path, NULL, &volume, NULL, err);
    if (status != OST_OK)
        return status;
    const size_t count = (size_t)ost_dims_count(dims);
    if (!same_dims(volume.geometry.dims, dims))
        status = wrong_dims(path, volume.geometry.dims, dims, err);
    else if (voxel_bytes == 2)
        memcpy(to, volume.voxels, 2 * count);
    for (size_t i = 0; i < count && status == OST_OK && voxel_bytes == 1; i++) {
        if (volume.voxels[i] < 0 || volume.voxels[i] > 255)
            status = ost_fail(err, OST_ERR_INPUT, "%s: voxel %zu is %d; a tool's are 0, 1 or 2", path, i,
                              volume.voxels[i]);
        ((uint8_t *)to)[i] = (uint8_t)volume.voxels[i];
    }
    ost_volume_free(&volume);
    return status;
}

/* Reads the grid of one stage if the dump has it. */
static ost_status read_grid(const char *folder, const char *name, ost_dims dims, uint32_t voxel_bytes, void *to,
                            bool *there, ost_error *err)
{
    static const char *const ends[] = {".raw", ".nrrd"};
    char path[PATH], file[64];
    *there = false;
    for (int i = 0; i < 2; i++) {
        snprintf(file, sizeof file, "%s%s", name, ends[i]);
        ost_status status = join(path, folder, file, err);
        if (status != OST_OK)
            return status;
        if (access(path, F_OK) != 0 && (errno == ENOENT || errno == ENOTDIR))
            continue;
        if (*there)
            return ost_fail(err, OST_ERR_INPUT, "%s: there is also a .raw of this stage", path);
        *there = true;
        status = i == 0 ? read_raw(path, (uint64_t)ost_dims_count(dims) * voxel_bytes, to, err)
                        : read_nrrd(path, dims, voxel_bytes, to, err);
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

/* The state of one case while its trace is made. */
typedef struct maker {
    const char *folder;
    trace_writer *w;
    ost_dims dims;
    int16_t *ref, *state, *next; /* the reference's bone, the trace's, and that of the next record */
    uint64_t compared;
} maker;

static size_t at_voxel(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

static void copy_words(trace_writer *w, const trace_record *r)
{
    uint64_t count;
    const uint8_t *words;
    if (trace_words(r, &count, &words))
        for (uint64_t i = 0; i < count; i++)
            trace_word(w, trace_word_at(words, i));
}

static void copy_blocks(trace_writer *w, const trace_record *r)
{
    size_t at = 0;
    trace_block_view b;
    while (trace_next_block(r, &at, &b)) {
        void *to = trace_block(w, b.lo, b.dims, b.voxel_bytes);
        if (to)
            memcpy(to, b.voxels, (size_t)ost_dims_count(b.dims) * b.voxel_bytes);
    }
}

/* Copies a block into a bone. */
static void lay(const trace_block_view *b, ost_dims d, int16_t *bone)
{
    if (b->voxel_bytes != 2 || b->lo[0] < 0 || b->lo[1] < 0 || b->lo[2] < 0 || b->lo[0] + b->dims.x > d.x ||
        b->lo[1] + b->dims.y > d.y || b->lo[2] + b->dims.z > d.z)
        return;
    for (int32_t k = 0; k < b->dims.z; k++)
        for (int32_t j = 0; j < b->dims.y; j++)
            memcpy(bone + at_voxel(d, b->lo[0], b->lo[1] + j, b->lo[2] + k), b->voxels + 2 * at_voxel(b->dims, 0, j, k),
                   2 * (size_t)b->dims.x);
}

/* Writes the leaves in which `next` differs from `state` as blocks; `state` becomes `next`. */
static void changed_leaves(maker *m)
{
    const ost_dims d = m->dims;
    for (int32_t z = 0; z < d.z; z += OST_LEAF)
        for (int32_t y = 0; y < d.y; y += OST_LEAF)
            for (int32_t x = 0; x < d.x; x += OST_LEAF) {
                const int32_t lo[3] = {x, y, z};
                const ost_dims n = {d.x - x < OST_LEAF ? d.x - x : OST_LEAF, d.y - y < OST_LEAF ? d.y - y : OST_LEAF,
                                    d.z - z < OST_LEAF ? d.z - z : OST_LEAF};
                bool changed = false;
                for (int32_t k = 0; k < n.z && !changed; k++)
                    for (int32_t j = 0; j < n.y && !changed; j++)
                        changed = memcmp(m->state + at_voxel(d, x, y + j, z + k),
                                         m->next + at_voxel(d, x, y + j, z + k), 2 * (size_t)n.x) != 0;
                uint8_t *to = changed ? trace_block(m->w, lo, n, 2) : NULL;
                for (int32_t k = 0; k < n.z && to; k++)
                    for (int32_t j = 0; j < n.y; j++, to += 2 * (size_t)n.x)
                        memcpy(to, m->next + at_voxel(d, x, y + j, z + k), 2 * (size_t)n.x);
            }
    memcpy(m->state, m->next, 2 * (size_t)ost_dims_count(d));
}

static ost_status store_bone(maker *m, const trace_block_view *b, const int16_t *got, ost_error *err)
{
    const size_t bytes = 2 * (size_t)ost_dims_count(b->dims);
    m->dims = b->dims;
    m->ref = malloc(bytes);
    m->state = malloc(bytes);
    m->next = malloc(bytes);
    if (!m->ref || !m->state || !m->next)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
    memcpy(m->ref, b->voxels, bytes);
    memcpy(m->state, got, bytes);
    return OST_OK;
}

/* Writes the record of a stage that has one complete grid. */
static ost_status make_complete(maker *m, const trace_record *r, const char *name, ost_error *err)
{
    size_t at = 0;
    trace_block_view b;
    bool there = false;
    if (!trace_next_block(r, &at, &b)) { /* an import that was refused has no grid */
        copy_words(m->w, r);
        trace_flags(m->w, TRACE_STAND_IN);
        return OST_OK;
    }
    const size_t bytes = (size_t)ost_dims_count(b.dims) * b.voxel_bytes;
    uint8_t *voxels = malloc(bytes);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %zu bytes", bytes);
    ost_status status = read_grid(m->folder, name, b.dims, b.voxel_bytes, voxels, &there, err);
    if (status == OST_OK && !there)
        memcpy(voxels, b.voxels, bytes);
    if (status == OST_OK) {
        copy_words(m->w, r);
        trace_flags(m->w, there ? TRACE_NO_WORDS : TRACE_STAND_IN);
        void *to = trace_block(m->w, b.lo, b.dims, b.voxel_bytes);
        if (to)
            memcpy(to, voxels, bytes);
        m->compared += there;
        if (r->stage == TRACE_CHUNKS)
            status = store_bone(m, &b, (const int16_t *)(const void *)voxels, err);
    }
    free(voxels);
    return status;
}

static ost_status make_tick(maker *m, const trace_record *r, const char *name, ost_error *err)
{
    size_t at = 0;
    trace_block_view b;
    bool there = false;
    if (!m->ref)
        return ost_fail(err, OST_ERR_INTERNAL, "the reference's trace has %s before its bone", name);
    while (trace_next_block(r, &at, &b))
        lay(&b, m->dims, m->ref);
    ost_status status = read_grid(m->folder, name, m->dims, 2, m->next, &there, err);
    if (status != OST_OK)
        return status;
    if (!there)
        memcpy(m->next, m->ref, 2 * (size_t)ost_dims_count(m->dims));
    copy_words(m->w, r);
    trace_flags(m->w, there ? TRACE_NO_WORDS : TRACE_STAND_IN);
    changed_leaves(m);
    m->compared += there;
    return OST_OK;
}

static ost_status make_case(maker *m, const trace *ref, compare_range range, uint32_t number, ost_error *err)
{
    ost_status status = OST_OK;
    for (size_t i = 0; i < range.count && status == OST_OK; i++) {
        const trace_record *r = &ref->records[range.first + i];
        char name[40];
        stage_name(r, name);
        trace_begin(m->w, r->stage, number, r->item);
        if (r->stage == TRACE_TICK)
            status = make_tick(m, r, name, err);
        else if (is_grid(r->stage))
            status = make_complete(m, r, name, err);
        else { /* stages that have only reports */
            copy_words(m->w, r);
            copy_blocks(m->w, r);
            trace_flags(m->w, TRACE_STAND_IN);
        }
        if (status == OST_OK)
            status = trace_end(m->w, err);
    }
    free(m->ref);
    free(m->state);
    free(m->next);
    return status;
}

ost_status dump_trace(const char *folder, const plan *p, int first, int end, const trace *ref,
                      const compare_range *ranges, const char *path, uint64_t *compared, ost_error *err)
{
    trace_writer *w = NULL;
    ost_status status = trace_create(path, &w, err);
    for (int i = first; i < end && status == OST_OK; i++) {
        char name[PLAN_ID], sub[PATH];
        struct stat info;
        dump_case_folder(p->cases[i].id, name);
        status = join(sub, folder, name, err);
        compared[i] = 0;
        if (status != OST_OK || stat(sub, &info) != 0)
            continue;
        maker m = {.folder = sub, .w = w};
        status = make_case(&m, ref, ranges[i], (uint32_t)i, err);
        compared[i] = m.compared;
    }
    if (status == OST_OK) {
        trace_begin(w, TRACE_END, (uint32_t)p->count, 0);
        status = trace_end(w, err);
    }
    ost_status closed = trace_close(w, status == OST_OK ? err : NULL);
    return status != OST_OK ? status : closed;
}

/* ---------------------------------------------------------------- writing */

static ost_status write_file(const char *path, const void *bytes, size_t size, ost_error *err)
{
    FILE *f = fopen(path, "wb");
    const bool written = f && fwrite(bytes, 1, size, f) == size;
    if ((f && fclose(f) != 0) || !written)
        return ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    return OST_OK;
}

static ost_status make_folder(const char *path, ost_error *err)
{
    return mkdir(path, 0777) == 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
}

static ost_status write_case(const char *folder, const trace *t, compare_range range, ost_error *err)
{
    ost_dims dims = {0, 0, 0};
    int16_t *bone = NULL;
    ost_status status = OST_OK;
    for (size_t i = 0; i < range.count && status == OST_OK; i++) {
        const trace_record *r = &t->records[range.first + i];
        char name[40], file[64], path[PATH];
        size_t at = 0, bytes = 0;
        trace_block_view b;
        const void *voxels = NULL;
        stage_name(r, name);
        snprintf(file, sizeof file, "%s.raw", name);
        status = join(path, folder, file, err);
        if (r->stage == TRACE_TICK && bone) {
            while (trace_next_block(r, &at, &b))
                lay(&b, dims, bone);
            voxels = bone;
            bytes = 2 * (size_t)ost_dims_count(dims);
        } else if (is_grid(r->stage) && trace_next_block(r, &at, &b)) {
            voxels = b.voxels;
            bytes = (size_t)ost_dims_count(b.dims) * b.voxel_bytes;
            if (r->stage == TRACE_CHUNKS && !bone) {
                dims = b.dims;
                bone = malloc(bytes);
                if (!bone)
                    status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
                else
                    memcpy(bone, b.voxels, bytes);
            }
        }
        if (voxels && status == OST_OK)
            status = write_file(path, voxels, bytes, err);
    }
    free(bone);
    return status;
}

ost_status dump_write(const char *folder, const char *program, const plan *p, const trace *t, ost_error *err)
{
    char path[PATH];
    ost_status status = make_folder(folder, err);
    for (int i = 0; i < p->count && status == OST_OK; i++) {
        const compare_range range = compare_find(t, (uint32_t)i);
        char name[PLAN_ID];
        dump_case_folder(p->cases[i].id, name);
        if (!range.count)
            continue;
        status = join(path, folder, name, err);
        if (status == OST_OK)
            status = make_folder(path, err);
        if (status == OST_OK)
            status = write_case(path, t, range, err);
    }
    if (status == OST_OK)
        status = join(path, folder, "dump.json", err);
    if (status != OST_OK)
        return status;
    char seed[32];
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    json_t *o = json_pack("{s:i,s:s,s:i,s:s,s:s,s:s}", "osteon_dump", FORMAT, "program", program, "arithmetic",
                          OST_ARITHMETIC_VERSION, "tier", plan_tier_name(p->tier), "seed", seed, "only",
                          p->only ? p->only : "");
    char *text = o ? json_dumps(o, JSON_INDENT(1) | JSON_SORT_KEYS) : NULL;
    status = text ? write_file(path, text, strlen(text), err)
                  : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", path);
    free(text);
    json_decref(o);
    return status;
}
