/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/user_store.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "validation/scratch.h"

/*
 * The format of the store file, which is read only by this program and its workers:
 *
 *   head, MAGIC and the entries of USER_CASES_MAX cases
 *   arrays: samples, vertices, triangles, ticks, each at the offset in its entry
 */
#define MAGIC UINT64_C(0x31524553554e5453)

typedef struct part {
    ost_tool_geometry grid;
    int fraction_bits;
    uint64_t vertices, triangles, dropped; /* numbers of vertices, triangles and dropped triangles */
    uint64_t vertices_at, triangles_at;    /* offsets in bytes from the beginning of the file */
    uint64_t raw_vertices, raw_triangles, raw_vertices_at, raw_triangles_at; /* the mesh before snapping */
} part;

typedef struct entry {
    scene head; /* all members of the scene; its pointers are not valid in the file */
    uint64_t samples, samples_at, ticks, ticks_at, handle_path, hand_at;
    part parts[SCENE_TOOLS_MAX][2];
} entry;

typedef struct store_head {
    uint64_t magic, bytes; /* `bytes` is the size of the complete file */
    int32_t count, entry_bytes;
    entry entries[USER_CASES_MAX];
} store_head;

struct user_store {
    int fd;
    bool own_fd;
    uint8_t *map; /* mapping of the complete file; NULL while the file is written */
    size_t size;
    store_head *head; /* owned while the file is written; afterwards it points to the beginning of `map` */
};

/* ---------------------------------------------------------- writing a store */

/* Smallest number of the store's descriptor. It is greater than the descriptors that workers use. Otherwise,
   worker_start could overwrite the store's descriptor before a worker inherits it. */
enum { BEYOND_WORKERS = 16 };

ost_status user_store_begin(user_store **out, ost_error *err)
{
    user_store *u = calloc(1, sizeof *u);
    *out = u;
    if (u)
        u->fd = -1;
    if (u)
        u->head = calloc(1, sizeof *u->head);
    if (!u || !u->head)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the user's cases");
    *u->head = (store_head){.magic = MAGIC, .entry_bytes = (int32_t)sizeof(entry)};
    u->size = sizeof *u->head;
    u->own_fd = true;
    int fd;
    const ost_status status = scratch_file(&fd, err);
    if (status != OST_OK)
        return status;
    u->fd = fcntl(fd, F_DUPFD_CLOEXEC, BEYOND_WORKERS);
    close(fd);
    return u->fd >= 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "no descriptor for the user's cases: %s", strerror(errno));
}

static ost_status write_at(user_store *u, const void *bytes, size_t size, uint64_t at, ost_error *err)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n = pwrite(u->fd, (const uint8_t *)bytes + done, size - done, (off_t)(at + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return ost_fail(err, OST_ERR_IO, "the inputs cannot be kept where TMPDIR says, or in /tmp: %s",
                            n ? strerror(errno) : "nothing is written");
        done += (size_t)n;
    }
    return OST_OK;
}

/* Appends an array to the file at an offset that is aligned for any element type. Sets *at to the offset. */
static ost_status add_array(user_store *u, const void *bytes, size_t count, size_t each, uint64_t *at, ost_error *err)
{
    *at = u->size;
    if (!count)
        return OST_OK;
    const ost_status status = write_at(u, bytes, count * each, u->size, err);
    u->size += (count * each + 63) / 64 * 64;
    return status;
}

ost_status user_case_samples(user_store *u, const ost_sample *samples, size_t count, size_t batch, ost_error *err)
{
    entry *e = &u->head->entries[u->head->count];
    enum { AT_ONCE = 4096 };
    ost_sample lines[AT_ONCE];
    ost_status status = OST_OK;
    if (!e->samples)
        e->samples_at = u->size;
    e->head.batch = batch;
    for (size_t i = 0; i < count && status == OST_OK;) {
        size_t n = 0;
        for (; n < AT_ONCE && i < count; n++, i++) {
            lines[n] = samples[i];
            lines[n].line = (uint32_t)((e->samples + n) % batch);
        }
        status = write_at(u, lines, n * sizeof *lines, e->samples_at + e->samples * sizeof *lines, err);
        e->samples += n;
    }
    u->size = e->samples_at + e->samples * sizeof *lines; /* a sample has 32 bytes, so the next array is aligned */
    return status;
}

static ost_status add_part(user_store *u, const ost_snapped_mesh *m, const ost_mesh *raw, part *p, ost_error *err)
{
    *p = (part){.grid = m->grid,
                .fraction_bits = m->fraction_bits,
                .vertices = m->vertex_count,
                .triangles = m->triangle_count,
                .dropped = m->dropped_triangles,
                .raw_vertices = raw->vertex_count,
                .raw_triangles = raw->triangle_count};
    ost_status status = add_array(u, raw->vertices, raw->vertex_count, sizeof *raw->vertices, &p->raw_vertices_at, err);
    if (status == OST_OK)
        status = add_array(u, raw->triangles, raw->triangle_count, sizeof *raw->triangles, &p->raw_triangles_at, err);
    if (status == OST_OK)
        status = add_array(u, m->vertices, m->vertex_count, sizeof *m->vertices, &p->vertices_at, err);
    return status != OST_OK ? status
           : status == OST_OK
               ? add_array(u, m->triangles, m->triangle_count, sizeof *m->triangles, &p->triangles_at, err)
               : status;
}

ost_status user_case_end(user_store *u, const scene *head, ost_error *err)
{
    entry *e = &u->head->entries[u->head->count];
    const size_t batch = e->head.batch;
    ost_status status = OST_OK;
    e->head = *head;
    e->head.batch = batch;
    e->head.samples = NULL;
    e->head.path.ticks = NULL;
    e->ticks = head->path.count;
    for (int t = 0; t < head->tool_count && status == OST_OK; t++)
        for (int k = 0; k < 2 && status == OST_OK; k++) {
            status = add_part(u, k ? &head->tools[t].noncutting : &head->tools[t].cutting, &head->tools[t].raw[k],
                              &e->parts[t][k], err);
            *(k ? &e->head.tools[t].noncutting : &e->head.tools[t].cutting) = (ost_snapped_mesh){.fraction_bits = 0};
            e->head.tools[t].raw[k] = (ost_mesh){.vertex_count = 0};
        }
    e->head.handle_path = (ost_path){.count = 0};
    e->handle_path = head->handle_path.count;
    if (status == OST_OK)
        status = add_array(u, head->handle_path.ticks, head->handle_path.count, sizeof *head->handle_path.ticks,
                           &e->hand_at, err);
    if (status == OST_OK)
        status = add_array(u, head->path.ticks, head->path.count, sizeof *head->path.ticks, &e->ticks_at, err);
    u->head->count++;
    return status;
}

static ost_status map_all(user_store *u, ost_error *err)
{
    u->map = mmap(NULL, u->size, PROT_READ, MAP_SHARED, u->fd, 0);
    if (u->map == MAP_FAILED) {
        u->map = NULL;
        return ost_fail(err, OST_ERR_MEMORY, "the inputs cannot be mapped: %s", strerror(errno));
    }
    u->head = (store_head *)(void *)u->map;
    return OST_OK;
}

ost_status user_store_end(user_store *u, ost_error *err)
{
    store_head *head = u->head;
    head->bytes = u->size;
    ost_status status = write_at(u, head, sizeof *head, 0, err);
    if (status == OST_OK && ftruncate(u->fd, (off_t)u->size) != 0)
        status = ost_fail(err, OST_ERR_IO, "the inputs cannot be kept: %s", strerror(errno));
    if (status == OST_OK && (status = map_all(u, err)) == OST_OK)
        free(head);
    return status;
}

/* ---------------------------------------------------------- reading a store */

static bool lies_within(const user_store *u, uint64_t at, uint64_t count, uint64_t each)
{
    return at % 8 == 0 && at >= sizeof(store_head) && at <= u->size && count <= (u->size - at) / each;
}

static bool entry_is_complete(const user_store *u, const entry *e)
{
    bool complete =
        e->head.tool_count >= 0 && e->head.tool_count <= SCENE_TOOLS_MAX &&
        (!e->samples || (e->head.batch > 0 && lies_within(u, e->samples_at, e->samples, sizeof(ost_sample)))) &&
        (!e->ticks || lies_within(u, e->ticks_at, e->ticks, sizeof(ost_tick))) &&
        (!e->handle_path || lies_within(u, e->hand_at, e->handle_path, sizeof(ost_tick)));
    for (int t = 0; complete && t < e->head.tool_count; t++)
        for (int k = 0; complete && k < 2; k++) {
            const part *p = &e->parts[t][k];
            complete = (!p->raw_vertices || lies_within(u, p->raw_vertices_at, p->raw_vertices, sizeof(ost_pm3))) &&
                       (!p->raw_triangles ||
                        lies_within(u, p->raw_triangles_at, p->raw_triangles, 3 * sizeof(uint32_t))) &&
                       (!p->vertices || lies_within(u, p->vertices_at, p->vertices, 3 * sizeof(int32_t))) &&
                       (!p->triangles || lies_within(u, p->triangles_at, p->triangles, 3 * sizeof(uint32_t)));
        }
    return complete;
}

ost_status user_store_open(int fd, user_store **out, ost_error *err)
{
    struct stat info;
    user_store *u = calloc(1, sizeof *u);
    *out = u;
    if (!u)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the user's cases");
    u->fd = fd;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size < (off_t)sizeof *u->head)
        return ost_fail(err, OST_ERR_INPUT, "--user is for workers of osteon validate: descriptor %d has no cases",
                        fd);
    u->size = (size_t)info.st_size;
    ost_status status = map_all(u, err);
    if (status != OST_OK)
        return status;
    bool complete = u->head->magic == MAGIC && u->head->bytes == u->size &&
                    u->head->entry_bytes == (int32_t)sizeof(entry) && u->head->count >= 0 &&
                    u->head->count <= USER_CASES_MAX;
    for (int i = 0; complete && i < u->head->count; i++)
        complete = entry_is_complete(u, &u->head->entries[i]);
    return complete
               ? OST_OK
               : ost_fail(err, OST_ERR_INPUT,
                          "--user is for workers of osteon validate: descriptor %d has cases of another program", fd);
}

void user_store_free(user_store *u)
{
    if (!u)
        return;
    if (u->map)
        munmap(u->map, u->size);
    else
        free(u->head);
    if (u->own_fd && u->fd >= 0)
        close(u->fd);
    free(u);
}

int user_store_count(const user_store *u)
{
    return u && u->head ? u->head->count : 0;
}

int user_store_fd(const user_store *u)
{
    return u ? u->fd : -1;
}

static ost_status read_raw(const user_store *u, const part *p, ost_mesh *m, ost_error *err)
{
    if (!p->raw_triangles)
        return OST_OK;
    const ost_status status = ost_mesh_init(m, p->raw_vertices, p->raw_triangles, err);
    if (status != OST_OK)
        return status;
    memcpy(m->vertices, u->map + p->raw_vertices_at, p->raw_vertices * sizeof *m->vertices);
    memcpy(m->triangles, u->map + p->raw_triangles_at, p->raw_triangles * sizeof *m->triangles);
    return OST_OK; /* vertex indices are not checked here; snapping refuses a mesh with an index that is too large */
}

static ost_status read_path(const user_store *u, uint64_t count, uint64_t at, ost_path *out, ost_error *err)
{
    *out = (ost_path){0};
    const ost_status status = count ? ost_path_init(out, count, err) : OST_OK;
    if (status == OST_OK && count)
        memcpy(out->ticks, u->map + at, count * sizeof *out->ticks);
    return status;
}

static ost_status read_part(const user_store *u, const part *p, ost_snapped_mesh *m, ost_error *err)
{
    *m = (ost_snapped_mesh){.grid = p->grid,
                            .fraction_bits = p->fraction_bits,
                            .vertex_count = p->vertices,
                            .triangle_count = p->triangles,
                            .dropped_triangles = p->dropped};
    if (!p->vertices)
        return OST_OK;
    m->vertices = malloc(p->vertices * sizeof *m->vertices);
    m->triangles = malloc((p->triangles ? p->triangles : 1) * sizeof *m->triangles);
    if (!m->vertices || !m->triangles)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a mesh of %llu triangles",
                        (unsigned long long)p->triangles);
    memcpy(m->vertices, u->map + p->vertices_at, p->vertices * sizeof *m->vertices);
    memcpy(m->triangles, u->map + p->triangles_at, p->triangles * sizeof *m->triangles);
    for (size_t t = 0; t < m->triangle_count; t++)
        for (int v = 0; v < 3; v++)
            if (m->triangles[t][v] >= p->vertices)
                return ost_fail(err, OST_ERR_INPUT, "triangle %zu has a vertex beyond the last", t);
    return OST_OK;
}

ost_status user_scene(const user_store *u, int number, scene *out, ost_error *err)
{
    if (!u || !u->map || number < 1 || number > u->head->count)
        return ost_fail(err, OST_ERR_USAGE,
                        "it is made of the user's own files: give them with --ct, --tool and --path");
    const entry *e = &u->head->entries[number - 1];
    *out = e->head;
    for (int t = 0; t < SCENE_TOOLS_MAX; t++) { /* pointers in the file are not valid, so they are replaced */
        out->tools[t].cutting = out->tools[t].noncutting = (ost_snapped_mesh){.fraction_bits = 0};
        out->tools[t].raw[0] = out->tools[t].raw[1] = (ost_mesh){.vertex_count = 0};
    }
    out->path = out->handle_path = (ost_path){0};
    out->lent = true;
    out->sample_count = e->samples;
    out->samples = e->samples ? (ost_sample *)(void *)(u->map + e->samples_at) : NULL;
    ost_status status = OST_OK;
    for (int t = 0; t < out->tool_count && status == OST_OK; t++)
        for (int k = 0; k < 2 && status == OST_OK; k++)
            if ((status = read_part(u, &e->parts[t][k], k ? &out->tools[t].noncutting : &out->tools[t].cutting, err)) ==
                OST_OK)
                status = read_raw(u, &e->parts[t][k], &out->tools[t].raw[k], err);
    if (status == OST_OK)
        status = read_path(u, e->ticks, e->ticks_at, &out->path, err);
    return status == OST_OK ? read_path(u, e->handle_path, e->hand_at, &out->handle_path, err) : status;
}

/*
 * Estimates the size of a case's trace in bytes. The estimate includes rect, cubic, chunks and the bone at
 * the end, each tool, and for each tick the leaves that it changes. A tick changes only leaves at the tool's
 * border in which bone remains. The estimate assumes one changed leaf per tick (TICK_LEAVES), which is
 * several times the average in slow cutting. If the estimate is too small and the disk becomes full, the
 * campaign ends.
 */
enum { TICK_LEAVES = 1 };
uint64_t user_trace_bytes(const user_store *u, int number)
{
    if (!u || !u->map || number < 1 || number > u->head->count)
        return 0;
    const entry *e = &u->head->entries[number - 1];
    const ost_geometry *g = &e->head.rect;
    const ost_pm c = e->head.cubic > 0 ? e->head.cubic : 1;
    const uint64_t rect = e->samples ? (uint64_t)ost_dims_count(g->dims) : 0;
    const double grow = (double)g->spacing.x / (double)c * ((double)g->spacing.y / (double)c) *
                        ((double)g->spacing.z / (double)c);
    uint64_t bytes = (4 << 20) + 2 * rect + (uint64_t)(6.3 * grow * (double)rect);
    for (int t = 0; t < e->head.tool_count; t++)
        bytes += (uint64_t)ost_dims_count(e->parts[t][0].grid.dims);
    return bytes + e->ticks * (uint64_t)TICK_LEAVES * OST_LEAF * OST_LEAF * OST_LEAF * 2;
}
