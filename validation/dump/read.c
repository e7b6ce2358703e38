/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the grids of a dump into a trace. Where the dump has no grid, the trace gets the reference's record. */
#include "validation/dump/parts.h"

#include <errno.h>
#include <osteon/io.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"

/* Reads raw voxels in the byte order of this machine. The file must have the size of the reference's grid. */
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

/* Reads the grid of one stage. Sets *there to false if the dump has no such grid. */
static ost_status read_grid(const char *folder, const char *name, ost_dims dims, uint32_t voxel_bytes, void *to,
                            bool *there, ost_error *err)
{
    static const char *const ends[] = {".raw", ".nrrd"};
    char path[DUMP_PATH], file[64];
    *there = false;
    for (int i = 0; i < 2; i++) {
        snprintf(file, sizeof file, "%s%s", name, ends[i]);
        ost_status status = dump_join(path, folder, file, err);
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

/* The state while the trace of one case is made from the dump. */
typedef struct maker {
    const char *folder;
    trace_writer *w;
    ost_dims dims;
    /* Voxels of the bone. `ref`: the reference's bone; `state`: the bone after the records written so far; `next`: the
       bone after the record that is written next. */
    int16_t *ref, *state, *next;
    uint64_t compared;
} maker;

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

/* Writes blocks for the leaves in which `next` differs from `state`. Then copies `next` to `state`. */
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
                        changed = memcmp(m->state + dump_voxel_index(d, x, y + j, z + k),
                                         m->next + dump_voxel_index(d, x, y + j, z + k), 2 * (size_t)n.x) != 0;
                uint8_t *to = changed ? trace_block(m->w, lo, n, 2) : NULL;
                for (int32_t k = 0; k < n.z && to; k++)
                    for (int32_t j = 0; j < n.y; j++, to += 2 * (size_t)n.x)
                        memcpy(to, m->next + dump_voxel_index(d, x, y + j, z + k), 2 * (size_t)n.x);
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

/* Writes the record of a stage whose result is a single complete grid. */
static ost_status make_complete(maker *m, const trace_record *r, const char *name, ost_error *err)
{
    size_t at = 0;
    trace_block_view b;
    bool there = false;
    if (!trace_next_block(r, &at, &b)) { /* a refused import has no grid */
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
        dump_copy_block(&b, m->dims, m->ref);
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

/* Copies the reference's record, because the dump does not contain this stage. */
static void stand_in(maker *m, const trace_record *r)
{
    copy_words(m->w, r);
    copy_blocks(m->w, r);
    trace_flags(m->w, TRACE_STAND_IN);
}

static ost_status make_steps(maker *m, const trace_record *r, ost_error *err)
{
    bool there;
    const ost_status status = dump_read_steps(m->folder, r, m->w, &there, err);
    if (status == OST_OK && there) {
        trace_flags(m->w, TRACE_MADE);
        m->compared++;
    } else if (status == OST_OK)
        stand_in(m, r);
    return status;
}

static ost_status make_case(maker *m, const trace *ref, compare_range range, uint32_t number, ost_error *err)
{
    ost_status status = OST_OK;
    for (size_t i = 0; i < range.count && status == OST_OK; i++) {
        const trace_record *r = &ref->records[range.first + i];
        char name[40];
        dump_stage_name(r, name);
        trace_begin(m->w, r->stage, number, r->item);
        if (r->stage == TRACE_TICK)
            status = make_tick(m, r, name, err);
        else if (dump_is_grid(r->stage))
            status = make_complete(m, r, name, err);
        else if (r->stage == TRACE_SNAP || r->stage == TRACE_STEPS)
            status = make_steps(m, r, err);
        else
            stand_in(m, r);
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
        char name[PLAN_ID], sub[DUMP_PATH];
        struct stat info;
        dump_case_folder(p->cases[i].id, name);
        status = dump_join(sub, folder, name, err);
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
