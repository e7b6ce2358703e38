/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/trace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "validation/steps_record.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "traces are written as they lie in memory, on little-endian machines"
#endif

enum { HEAD = 32, BLOCK_HEAD = 32 };
static const char magic[4] = {'O', 'S', 'T', 'R'};

static const char *const stage_names[TRACE_STAGES] = {"case",    "rect",  "cubic", "resample", "chunks",
                                                      "snap",    "tool",  "collide", "steps",  "tick",
                                                      "sample",  "upload", "final", "failed",  "end"};

const char *trace_stage_name(trace_stage stage)
{
    return stage < TRACE_STAGES ? stage_names[stage] : "unknown";
}

size_t trace_report_head(trace_stage stage)
{
    return stage == TRACE_TICK ? 13 : stage == TRACE_COLLIDE ? 3 : 0;
}

/* Writes the name of a word in a chunk's line of a report. The line consists of the chunk's number and, for each
   class, the number of voxels and the sum of their densities. */
static void name_in_line(uint64_t at, char text[TRACE_WORD])
{
    if (at == 0)
        snprintf(text, TRACE_WORD, "number of a chunk");
    else
        snprintf(text, TRACE_WORD, "%s of class %u in a chunk", at % 2 ? "voxels" : "sum of densities",
                 (unsigned)((at - 1) / 2 % 100 + 1));
}

const char *trace_word_name(trace_stage stage, size_t word, uint64_t line_words, char text[TRACE_WORD])
{
    static const char *const input[] = {"digest of the input", "digest of the input", "digest of the input",
                                        "digest of the input"};
    static const char *const rect[] = {"samples",       "duplicates",    "off lattice", "worst offset", "worst line",
                                       "rejected line", "conflict line", "density had", "density has"};
    static const char *const cubic[] = {"width", "height", "depth", "x spacing", "y spacing", "z spacing"};
    static const char *const chunks[] = {"chunks",         "active chunks",  "active voxels", "digest of bone",
                                         "digest of bone", "digest of bone", "digest of bone"};
    static const char *const tool[] = {"solid voxels", "cutting voxels", "leaking rows"};
    static const char *const tick[] = {
        "status",      "removal",     "boxes meet",  "poses",         "chunk range",    "chunk range",    "chunk range",
        "chunk range", "chunk range", "chunk range", "voxels in all", "touched voxels", "chunks reported"};
    static const char *const failed[] = {"status"};
    static const struct {
        const char *const *names;
        size_t count;
    } of[TRACE_STAGES] = {[TRACE_CASE] = {input, 4},        [TRACE_RECT] = {rect, 9},     [TRACE_CUBIC] = {cubic, 6},
                          [TRACE_CHUNKS] = {chunks, 7},     [TRACE_TOOL] = {tool, 3},     [TRACE_TICK] = {tick, 13},
                          [TRACE_COLLIDE] = {tick + 10, 3}, [TRACE_UPLOAD] = {chunks, 7}, [TRACE_FINAL] = {chunks, 7},
                          [TRACE_FAILED] = {failed, 1},     [TRACE_RESAMPLE] = {cubic, 6}};
    if (stage < TRACE_STAGES && word < of[stage].count)
        return of[stage].names[word];
    const size_t head = trace_report_head(stage);
    if (stage == TRACE_SNAP || stage == TRACE_STEPS)
        steps_word_name(stage, word, text);
    else if (head && line_words && word >= head)
        name_in_line((word - head) % line_words, text);
    else
        snprintf(text, TRACE_WORD, "report word %zu", word);
    return text;
}

bool trace_word_is_bound(trace_stage stage, size_t word)
{
    return stage == TRACE_STEPS
               ? steps_word_is_bound(word)
               /* the words of boxes_meet and of the range of chunks */
               : stage == TRACE_TICK && (word == 2 || (word >= 4 && word < 10));
}

bool trace_word_holds(trace_stage stage, size_t word, const uint8_t *is, const uint8_t *least)
{
    if (!trace_word_is_bound(stage, word))
        return trace_word_at(is, word) == trace_word_at(least, word);
    if (stage != TRACE_TICK)
        return steps_word_holds(word, is, least);
    const int64_t has = (int64_t)trace_word_at(is, word), needs = (int64_t)trace_word_at(least, word);
    /* A range of chunks may begin below the bound and end above it. boxes_meet may be 1 even if the bound is 0. */
    return word >= 4 && word % 2 == 0 ? has <= needs
                                      : has >= needs;
}

/* ---------------------------------------------------------- writing a trace */

/* A writer and the state of the record that is being written. The counts in the record's head are set when the record
   ends. */
struct trace_writer {
    FILE *file;
    char *path;
    uint8_t *buffer;
    size_t used, capacity;
    /* offset of the block count in the record; 0 while words are added, before the first block */
    size_t blocks_at;
    uint64_t words, blocks;
    bool no_memory;
};

static uint8_t *more(trace_writer *w, size_t bytes)
{
    if (w->capacity - w->used < bytes) {
        const size_t capacity = (w->used + bytes) * 2;
        uint8_t *grown = realloc(w->buffer, capacity);
        if (!grown) {
            w->no_memory = true;
            return NULL;
        }
        w->buffer = grown;
        w->capacity = capacity;
    }
    uint8_t *at = w->buffer + w->used;
    w->used += bytes;
    return at;
}

static void put(trace_writer *w, const void *value, size_t bytes)
{
    uint8_t *at = more(w, bytes);
    if (at)
        memcpy(at, value, bytes);
}

ost_status trace_create(const char *path, trace_writer **out, ost_error *err)
{
    trace_writer *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w || !(w->path = strdup(path))) {
        free(w);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a trace");
    }
    w->file = fopen(path, "wb");
    if (!w->file) {
        const int error = errno;
        free(w->path);
        free(w);
        /* After OST_ERR_IO, a worker ends with WORKER_EXIT_RESOURCES, which means that the machine lacks resources. An
           unusable path is not such a case, so it gets a different status. */
        const bool unusable = error == ENOENT || error == ENOTDIR || error == EISDIR || error == EACCES;
        return ost_fail(err, unusable ? OST_ERR_INPUT : OST_ERR_IO, "%s: cannot write: %s", path, strerror(error));
    }
    *out = w;
    return OST_OK;
}

ost_status trace_close(trace_writer *w, ost_error *err)
{
    ost_status status = OST_OK;
    if (!w)
        return OST_OK;
    if (fclose(w->file) != 0)
        status = ost_fail(err, OST_ERR_IO, "%s: %s", w->path, strerror(errno));
    free(w->path);
    free(w->buffer);
    free(w);
    return status;
}

void trace_begin(trace_writer *w, trace_stage stage, uint32_t case_index, uint32_t item)
{
    const uint32_t names[3] = {(uint32_t)stage, case_index, item};
    const uint64_t zero[2] = {0, 0};
    w->used = 0;
    w->blocks_at = 0;
    w->words = w->blocks = 0;
    put(w, magic, 4);
    put(w, names, 12);
    put(w, zero, 16);
    put(w, zero, 8);
}

void trace_flags(trace_writer *w, uint64_t flags)
{
    if (!w->no_memory)
        memcpy(w->buffer + HEAD - 8, &flags, sizeof flags);
}

void trace_word(trace_writer *w, uint64_t value)
{
    put(w, &value, 8);
    w->words++;
}

static void end_words(trace_writer *w)
{
    const uint64_t zero = 0;
    if (w->blocks_at)
        return;
    w->blocks_at = w->used;
    put(w, &zero, 8);
}

void *trace_block(trace_writer *w, const int32_t lo[3], ost_dims dims, uint32_t voxel_bytes)
{
    const int32_t wide[3] = {dims.x, dims.y, dims.z};
    const uint32_t kind[2] = {voxel_bytes, 0};
    end_words(w);
    put(w, lo, 12);
    put(w, wide, 12);
    put(w, kind, 8);
    w->blocks++;
    return more(w, (size_t)ost_dims_count(dims) * voxel_bytes);
}

ost_status trace_end(trace_writer *w, ost_error *err)
{
    end_words(w);
    if (w->no_memory)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a record of %zu bytes", w->used);
    const uint64_t body = w->used - HEAD;
    memcpy(w->buffer + 16, &body, 8);
    memcpy(w->buffer + HEAD, &w->words, 8);
    memcpy(w->buffer + w->blocks_at, &w->blocks, 8);
    if (fwrite(w->buffer, 1, w->used, w->file) != w->used)
        return ost_fail(err, OST_ERR_IO, "%s: %s", w->path, strerror(errno));
    return OST_OK;
}

/* ---------------------------------------------------------- reading a trace */

static uint64_t u64_at(const uint8_t *p)
{
    uint64_t v;
    memcpy(&v, p, 8);
    return v;
}

static uint32_t u32_at(const uint8_t *p)
{
    uint32_t v;
    memcpy(&v, p, 4);
    return v;
}

static ost_status index_records(const char *path, trace *t, ost_error *err)
{
    size_t capacity = 0;
    if (t->size && memcmp(t->bytes, magic, t->size < 4 ? t->size : 4) != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: not a trace; expected a file that --trace wrote", path);
    for (size_t at = 0; t->size - at >= HEAD;) {
        const uint8_t *head = t->bytes + at;
        const uint64_t body = u64_at(head + 16);
        if (memcmp(head, magic, 4) != 0 || u32_at(head + 4) >= TRACE_STAGES)
            return ost_fail(err, OST_ERR_INPUT, "%s: offset %zu: no record of a trace begins here", path, at);
        if (body > t->size - at - HEAD)
            return OST_OK; /* the writer stopped within this record, so the record is ignored */
        if (t->count == capacity) {
            capacity = capacity ? 2 * capacity : 1024;
            trace_record *grown = realloc(t->records, capacity * sizeof *grown);
            if (!grown)
                return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu records", path, capacity);
            t->records = grown;
        }
        t->records[t->count++] = (trace_record){
            (trace_stage)u32_at(head + 4), u32_at(head + 8), u32_at(head + 12), head + HEAD, body,
            u64_at(head + HEAD - 8)};
        at += HEAD + body;
        t->complete = t->records[t->count - 1].stage == TRACE_END && at == t->size;
    }
    return OST_OK;
}

ost_status trace_open(const char *path, trace *out, ost_error *err)
{
    ost_file file;
    *out = (trace){0};
    ost_status status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return file.absent ? ost_fail(err, OST_ERR_INPUT, "%s: cannot open: %s", path, strerror(ENOENT)) : status;
    if (file.size > 0) {
        void *bytes = mmap(NULL, (size_t)file.size, PROT_READ, MAP_PRIVATE, file.fd, 0);
        if (bytes == MAP_FAILED) {
            status = ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
        } else {
            out->bytes = bytes;
            out->size = (size_t)file.size;
        }
    }
    close(file.fd);
    if (status == OST_OK)
        status = index_records(path, out, err);
    if (status != OST_OK)
        trace_free(out);
    return status;
}

void trace_free(trace *t)
{
    if (t->bytes)
        munmap((void *)(uintptr_t)t->bytes, t->size);
    free(t->records);
    *t = (trace){0};
}

bool trace_words(const trace_record *r, uint64_t *count, const uint8_t **words)
{
    if (r->body_bytes < 8)
        return false;
    *count = u64_at(r->body);
    *words = r->body + 8;
    return *count <= (r->body_bytes - 8) / 8;
}

bool trace_next_block(const trace_record *r, size_t *at, trace_block_view *out)
{
    uint64_t words;
    const uint8_t *unused;
    if (*at == 0) {
        if (!trace_words(r, &words, &unused))
            return false;
        *at = 8 + 8 * (size_t)words + 8;
    }
    if (*at > r->body_bytes || r->body_bytes - *at < BLOCK_HEAD)
        return false;
    const uint8_t *head = r->body + *at;
    memcpy(out->lo, head, 12);
    memcpy(&out->dims, head + 12, 12);
    out->voxel_bytes = u32_at(head + 24);
    out->voxels = head + BLOCK_HEAD;
    const ost_dims d = out->dims;
    if (d.x < 1 || d.y < 1 || d.z < 1 || d.x > OST_DIM_MAX || d.y > OST_DIM_MAX || d.z > OST_DIM_MAX ||
        out->voxel_bytes < 1 || out->voxel_bytes > 2)
        return false;
    const uint64_t bytes = (uint64_t)ost_dims_count(d) * out->voxel_bytes;
    if (bytes > r->body_bytes - *at - BLOCK_HEAD)
        return false;
    *at += BLOCK_HEAD + (size_t)bytes;
    return true;
}
