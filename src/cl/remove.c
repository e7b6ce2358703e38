/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Removal and collision (AR-MAP, AR-REM) by one launch for all chunks, blocks and poses of an event.
 *
 *   host    chunks with a slot that overlap a pose's box     ascending, as in the report
 *             their blocks of 16^3
 *               entries: the poses that may reach the block, each with the block's base
 *   queue   event with poses, blocks, entries -> ost_remove -> a report per block
 *   host    waits once, for the reports; sums the reports of each chunk
 *
 * An entry is omitted if no voxel of the block can lie in the tool's grid.  There are three such
 * cases: the pose's box does not overlap the block, the block's base is far (AR-MAP-5), or the eight
 * corners of the block all lie on one side of the grid.
 *
 * The entries of a launch have at most ENTRIES_BYTES.  An event with more entries is
 * divided into several launches of complete blocks.  The division affects only the time,
 * because chunks are independent of each other.
 */
#include "cl/mirror.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = OST_MAP_BLOCK, ENTRIES_BYTES = (1 << 22) * sizeof(ost_cl_entry) };

typedef struct event_array {
    void *host;      /* owned */
    size_t capacity; /* allocated bytes */
    size_t bytes;    /* bytes in use */
} event_array;

struct ost_cl_event_scratch {
    event_array poses, blocks, entries, reports;
    event_array input; /* the struct of the event and, after it, the event's arrays */
    cl_mem input_device, reports_device;
    size_t input_capacity, reports_capacity; /* capacity of input_device and of reports_device, in bytes */
    size_t *chunk; /* owned; for each block, the number of its chunk */
    size_t chunk_capacity;
    bool warm; /* true after the first launch of the removal kernel */
};

void ost_cl_event_free(cl_backend *b)
{
    struct ost_cl_event_scratch *s = b->event;
    if (!s)
        return;
    ost_cl_buffer_free(b, &s->input_device);
    ost_cl_buffer_free(b, &s->reports_device);
    free(s->poses.host);
    free(s->blocks.host);
    free(s->entries.host);
    free(s->reports.host);
    free(s->input.host);
    free(s->chunk);
    free(s);
    b->event = NULL;
}

/* Ensures that the array has a capacity of at least `bytes` bytes. The content of the array is preserved. */
static ost_status array_reserve(event_array *a, size_t bytes, ost_error *err)
{
    if (bytes <= a->capacity)
        return OST_OK;
    const size_t capacity = bytes + bytes / 2;
    void *host = realloc(a->host, capacity);
    if (!host)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an event (%zu bytes)", capacity);
    a->host = host;
    a->capacity = capacity;
    return OST_OK;
}

/* Appends one element. */
static ost_status array_add(event_array *a, const void *element, size_t size, ost_error *err)
{
    ost_status status = array_reserve(a, a->bytes + size, err);
    if (status != OST_OK)
        return status;
    memcpy((char *)a->host + a->bytes, element, size);
    a->bytes += size;
    return OST_OK;
}

/* Ensures that a buffer on the device has at least `bytes` bytes. If the buffer grows, its content is lost. */
static ost_status device_reserve(cl_backend *b, cl_mem *device, size_t *reserved, size_t bytes, ost_error *err)
{
    if (bytes <= *reserved)
        return OST_OK;
    cl_mem grown = NULL;
    ost_status status = ost_cl_buffer(b, bytes + bytes / 2, NULL, "an event", &grown, err);
    if (status != OST_OK)
        return status;
    ost_cl_buffer_free(b, device);
    *device = grown;
    *reserved = bytes + bytes / 2;
    return OST_OK;
}

/* ------------------------------------------------------------- planning */

typedef struct plan {
    cl_backend *b;
    cl_bone *bone;
    cl_tool *tool;
    const ost_removal_event *event;
    struct ost_cl_event_scratch *s;
    bool apply;
    bool changed; /* true once a launch that removes voxels has been enqueued */
    ost_removal_report *report;
    ost_chunk_report part; /* sums over the blocks of the current chunk; part.chunk is -1 before the first chunk */
} plan;

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t greatest(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static bool empty_box(const ost_voxel_box *box, ost_dims dims)
{
    const int32_t d[3] = {dims.x, dims.y, dims.z};
    for (int a = 0; a < 3; a++)
        if (greatest(box->lo[a], 0) >= least(box->hi[a], d[a]))
            return true;
    return false;
}

/* Finds the half-open range of chunks that contains the boxes of all poses. lo > hi if all boxes are empty. */
static void chunk_range(const plan *p, int32_t lo[3], int32_t hi[3])
{
    const ost_dims dims = p->bone->base.geometry.dims;
    const int32_t d[3] = {dims.x, dims.y, dims.z}, n = p->bone->base.chunk_size;
    for (int a = 0; a < 3; a++) {
        lo[a] = INT32_MAX;
        hi[a] = 0;
    }
    for (int k = 0; k < p->event->pose_count; k++) {
        const ost_voxel_box *box = &p->event->boxes[k];
        if (empty_box(box, dims))
            continue;
        for (int a = 0; a < 3; a++) {
            lo[a] = least(lo[a], greatest(box->lo[a], 0) / n);
            hi[a] = greatest(hi[a], (least(box->hi[a], d[a]) - 1) / n + 1);
        }
    }
}

/* Returns true if all corners of the block, and therefore the entire block, lie beyond one face of the tool's grid. */
static bool is_outside(const int32_t base[3], const ost_map *map, ost_dims dims)
{
    const int64_t d[3] = {dims.x, dims.y, dims.z};
    for (int a = 0; a < 3; a++) {
        int64_t low = base[a], high = base[a]; /* 64-bit variables, because the sums may exceed int32 */
        for (int axis = 0; axis < 3; axis++) {
            const int64_t along = (int64_t)(BLOCK - 1) * map->step[axis][a];
            low += along < 0 ? along : 0;
            high += along > 0 ? along : 0;
        }
        if (high < 0 || low >= d[a] << OST_MAP_FRACTION)
            return true;
    }
    return false;
}

/* Adds the entries of one block. Sets *count to their number, which is 0 if the tool overlaps the block at no pose. */
static ost_status plan_entries(plan *p, const int32_t first[3], uint32_t *count, ost_error *err)
{
    const ost_dims dims = p->bone->base.geometry.dims;
    const int32_t end[3] = {least(first[0] + BLOCK, dims.x), least(first[1] + BLOCK, dims.y),
                            least(first[2] + BLOCK, dims.z)};
    *count = 0;
    for (int k = 0; k < p->event->pose_count; k++) {
        const ost_voxel_box *box = &p->event->boxes[k];
        bool meets = true;
        for (int a = 0; a < 3; a++)
            meets = meets && greatest(box->lo[a], first[a]) < least(box->hi[a], end[a]);
        ost_cl_entry entry = {.pose = (uint32_t)k};
        if (!meets ||
            !ost_map_block_base(&p->event->maps[k], (ost_dims){first[0] / BLOCK, first[1] / BLOCK, first[2] / BLOCK},
                                entry.base) ||
            is_outside(entry.base, &p->event->maps[k], p->tool->base.geometry.dims))
            continue;
        ost_status status = array_add(&p->s->entries, &entry, sizeof entry, err);
        if (status != OST_OK)
            return status;
        ++*count;
    }
    return OST_OK;
}

static size_t block_count(const plan *p)
{
    return p->s->blocks.bytes / sizeof(ost_cl_block);
}

static ost_status plan_block(plan *p, size_t chunk, const int32_t first[3], ost_error *err)
{
    struct ost_cl_event_scratch *s = p->s;
    const size_t entry = s->entries.bytes / sizeof(ost_cl_entry), number = block_count(p);
    uint32_t count;
    ost_status status = plan_entries(p, first, &count, err);
    if (status != OST_OK || count == 0)
        return status;
    if (number == s->chunk_capacity) {
        const size_t capacity = number ? 2 * number : 256;
        size_t *grown = realloc(s->chunk, capacity * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for an event of %zu blocks", capacity);
        s->chunk = grown;
        s->chunk_capacity = capacity;
    }
    const ost_cl_block block = {
        .first = {first[0], first[1], first[2]},
        .slot = p->bone->slot[chunk],
        .entry = (uint32_t)entry,
        .entries = count,
    };
    s->chunk[number] = chunk;
    return array_add(&s->blocks, &block, sizeof block, err);
}

static ost_status plan_poses(plan *p, ost_error *err)
{
    struct ost_cl_event_scratch *s = p->s;
    const size_t bytes = (size_t)p->event->pose_count * sizeof(ost_cl_pose);
    ost_status status = array_reserve(&s->poses, bytes, err);
    if (status != OST_OK)
        return status;
    ost_cl_pose *poses = s->poses.host;
    s->poses.bytes = bytes;
    for (int k = 0; k < p->event->pose_count; k++) {
        poses[k] = (ost_cl_pose){.step = {{0}}};
        memcpy(poses[k].step, p->event->maps[k].step, sizeof poses[k].step);
        memcpy(poses[k].lo, p->event->boxes[k].lo, sizeof poses[k].lo);
        memcpy(poses[k].hi, p->event->boxes[k].hi, sizeof poses[k].hi);
        ost_cl_pose_reach(&poses[k]);
    }
    return OST_OK;
}

/* -------------------------------------------------------------- running */

/* Adds the sums of the current chunk to the report. In a removal, also updates the chunk's number of active voxels. */
static ost_status close_part(plan *p, ost_error *err)
{
    if (p->part.chunk < 0)
        return OST_OK;
    const size_t chunk = (size_t)p->part.chunk;
    uint64_t hit = 0;
    for (int c = 0; c < OST_CLASS_MAX; c++)
        hit += p->part.voxels[c];
    ost_status status = OST_OK;
    if (hit > p->bone->active[chunk])
        status = ost_fail(err, OST_ERR_UNAVAILABLE,
                          "OpenCL device '%.120s' is defective: it reports %llu voxels hit in a chunk that has %u",
                          p->b->device.name, (unsigned long long)hit, (unsigned)p->bone->active[chunk]);
    if (status == OST_OK && hit > 0)
        status = ost_removal_report_add(p->report, &p->part, err);
    if (status == OST_OK && p->apply && hit > 0) {
        p->bone->active[chunk] -= (uint32_t)hit;
        ost_cl_mirror_changed(p->bone, chunk);
        if (p->bone->active[chunk] == 0)
            ost_cl_bone_release(p->bone, chunk);
    }
    p->part = (ost_chunk_report){.chunk = -1};
    return status;
}

static ost_status take_reports(plan *p, ost_error *err)
{
    const ost_cl_block_report *reports = p->s->reports.host;
    ost_status status = OST_OK;
    for (size_t i = 0; i < block_count(p) && status == OST_OK; i++) {
        const size_t chunk = p->s->chunk[i];
        if (p->part.chunk < 0 || (size_t)p->part.chunk != chunk) {
            status = close_part(p, err);
            p->part = (ost_chunk_report){.chunk = (int32_t)chunk};
        }
        p->report->touched_voxels += reports[i].touched;
        for (int c = 0; c < p->event->classes->count; c++) {
            p->part.voxels[c] += reports[i].voxels[c];
            p->part.density[c] += reports[i].density[c];
        }
    }
    return status;
}

/* Enqueues one launch for the blocks in the arrays on the device. If `blocks` is 0, all work items return at once. */
static ost_status launch(const plan *p, size_t blocks, ost_error *err)
{
    struct ost_cl_event_scratch *s = p->s;
    const size_t items = blocks ? blocks : 1;
    if (p->b->cpu_set)
        return OST_CL_LAUNCH(p->b, ost_remove_blocks, (items + OST_CL_BATCHES - 1) / OST_CL_BATCHES * OST_CL_BATCHES, 1,
                             1, err, OST_CL_ARG(s->input_device), OST_CL_ARG(p->tool->cells),
                             OST_CL_ARG(p->tool->windows), OST_CL_ARG(p->bone->density), OST_CL_ARG(p->bone->words),
                             OST_CL_ARG(s->reports_device));
    return OST_CL_LAUNCH(p->b, ost_remove, items * (size_t)(BLOCK * BLOCK), 1, 1, err, OST_CL_ARG(s->input_device),
                         OST_CL_ARG(p->tool->cells), OST_CL_ARG(p->bone->density), OST_CL_ARG(p->bone->words),
                         OST_CL_ARG(s->reports_device));
}

/* Enqueues the transfer of the event and its arrays as one buffer. Enlarges the buffer for the reports if needed. */
static ost_status write_input(plan *p, ost_error *err)
{
    struct ost_cl_event_scratch *s = p->s;
    const ost_density_classes *classes = p->event->classes;
    const ost_dims dims = p->tool->base.geometry.dims;
    ost_cl_event head = {
        .tool_dims = {dims.x, dims.y, dims.z},
        .size = p->bone->base.chunk_size,
        .blocks = (uint32_t)block_count(p),
        .apply = p->apply,
        .classes = classes->count,
        .touches = p->tool->touches,
    };
    const event_array *parts[] = {&s->poses, &s->blocks, &s->entries};
    uint32_t *at[] = {&head.poses_at, &head.blocks_at, &head.entries_at};
    size_t bytes = sizeof head;
    for (int c = 0; c < classes->count; c++)
        head.border[c] = classes->border[c];
    for (int i = 0; i < 3; i++) { /* aligned, because all offsets and sizes are multiples of 8 */
        *at[i] = (uint32_t)bytes;
        bytes += parts[i]->bytes;
    }
    if (bytes > UINT32_MAX)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an event (%zu bytes)", bytes);
    s->reports.bytes = head.blocks * sizeof(ost_cl_block_report);
    const size_t reports = s->reports.bytes ? s->reports.bytes : sizeof(ost_cl_block_report);
    ost_status status = array_reserve(&s->input, bytes, err);
    if (status == OST_OK)
        status = array_reserve(&s->reports, reports, err);
    if (status == OST_OK)
        status = device_reserve(p->b, &s->input_device, &s->input_capacity, bytes, err);
    if (status == OST_OK)
        status = device_reserve(p->b, &s->reports_device, &s->reports_capacity, reports, err);
    if (status != OST_OK)
        return status;
    memcpy(s->input.host, &head, sizeof head);
    for (int i = 0; i < 3; i++)
        if (parts[i]->bytes)
            memcpy((char *)s->input.host + *at[i], parts[i]->host, parts[i]->bytes);
    return ost_cl_write_later(p->b, s->input_device, bytes, s->input.host, err);
}

/*
 * Launches the removal kernel once without a block. Some drivers build a kernel for a group size only when the kernel
 * is first launched; this launch makes them build it before the operation. The function is called for an event whose
 * boxes overlap no block. A world runs such an event when a tool is added.
 */
static ost_status warm(plan *p, ost_error *err)
{
    ost_status status = write_input(p, err);
    if (status == OST_OK)
        status = launch(p, 0, err);
    if (status == OST_OK)
        /* A warm-up launch has no blocks, so it is not counted. */
        p->b->launched[p->b->cpu_set ? OST_CL_KERNEL_ost_remove_blocks : OST_CL_KERNEL_ost_remove]--;
    if (status == OST_OK)
        status = ost_cl_finish(p->b, err);
    if (status == OST_OK)
        ost_cl_tool_finish(p->tool, true);
    p->s->warm = status == OST_OK;
    return status;
}

/* Launches the kernel for the planned blocks, adds the reports of the blocks, and clears the plan. */
static ost_status flush(plan *p, ost_error *err)
{
    struct ost_cl_event_scratch *s = p->s;
    const size_t blocks = block_count(p);
    if (blocks == 0)
        return OST_OK;
    ost_status status = write_input(p, err);
    if (status == OST_OK && !p->b->cpu_set)
        status = ost_cl_zero(p->b, s->reports_device, 0, s->reports.bytes, err);
    if (status == OST_OK) {
        status = launch(p, blocks, err);
        p->changed = p->changed || (status == OST_OK && p->apply);
        s->warm = true;
    }
    if (status == OST_OK)
        status = ost_cl_read(p->b, s->reports_device, 0, s->reports.bytes, s->reports.host, err);
    if (status == OST_OK) {
        ost_cl_tool_finish(p->tool, true);
        status = take_reports(p, err);
    }
    s->blocks.bytes = 0;
    s->entries.bytes = 0;
    return status;
}

static ost_status plan_chunk(plan *p, size_t chunk, const int32_t corner[3], ost_error *err)
{
    const int32_t n = p->bone->base.chunk_size;
    ost_status status = OST_OK;
    for (int32_t z = 0; z < n && status == OST_OK; z += BLOCK)
        for (int32_t y = 0; y < n && status == OST_OK; y += BLOCK)
            for (int32_t x = 0; x < n && status == OST_OK; x += BLOCK) {
                const int32_t first[3] = {corner[0] + x, corner[1] + y, corner[2] + z};
                status = plan_block(p, chunk, first, err);
                if (status == OST_OK && p->s->entries.bytes >= ost_cl_staging(p->b, ENTRIES_BYTES)) {
                    p->b->entered[OST_CL_PATH_EVENT_IN_PARTS]++;
                    status = flush(p, err);
                }
            }
    return status;
}

/* Reserves memory in the report for every chunk of the range, so that no allocation for the report can fail after the
   first voxel has been removed. */
static ost_status reserve_report(const plan *p, const int32_t lo[3], const int32_t hi[3], ost_error *err)
{
    size_t needed = p->report->count;
    const ost_dims cd = p->bone->chunk_dims;
    for (int32_t z = lo[2]; z < hi[2]; z++)
        for (int32_t y = lo[1]; y < hi[1]; y++)
            for (int32_t x = lo[0]; x < hi[0]; x++)
                needed += p->bone->active[(size_t)x + (size_t)cd.x * ((size_t)y + (size_t)cd.y * (size_t)z)] > 0;
    if (needed <= p->report->capacity)
        return OST_OK;
    ost_chunk_report *grown = realloc(p->report->chunks, needed * sizeof *grown);
    if (!grown)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a report of %zu chunks", needed);
    p->report->chunks = grown;
    p->report->capacity = needed;
    return OST_OK;
}

static ost_status run_event(cl_bone *bone, cl_tool *tool, const ost_removal_event *event, bool apply,
                            ost_removal_report *report, ost_error *err)
{
    cl_backend *b = (cl_backend *)bone->base.backend;
    ost_status status = ost_cl_alive(bone->base.backend, bone->lost, "bone", err);
    if (status == OST_OK && !b->event && !(b->event = calloc(1, sizeof *b->event)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for an event");
    if (status != OST_OK)
        return status;
    if (b->turns < OST_CL_TURNS && (uint32_t)event->pose_count > OST_CL_TURNS_POSES(b->turns))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "OpenCL device '%.120s' ends a loop after %u iterations without an error, too early for an "
                        "event of %d poses", b->device.name, (unsigned)b->turns, event->pose_count);
    plan p = {.b = b,
              .bone = bone,
              .tool = tool,
              .event = event,
              .s = b->event,
              .apply = apply,
              .report = report,
              .part = {.chunk = -1}};
    p.s->blocks.bytes = p.s->entries.bytes = 0;
    int32_t lo[3], hi[3];
    b->entered[apply ? OST_CL_PATH_EVENT_REMOVES : OST_CL_PATH_EVENT_COLLIDES]++;
    chunk_range(&p, lo, hi);
    status = reserve_report(&p, lo, hi, err);
    if (status == OST_OK)
        status = ost_cl_tool_prepare(tool, err);
    if (status == OST_OK)
        status = plan_poses(&p, err);
    const ost_dims cd = bone->chunk_dims;
    const int32_t n = bone->base.chunk_size;
    for (int32_t z = lo[2]; z < hi[2] && status == OST_OK; z++)
        for (int32_t y = lo[1]; y < hi[1] && status == OST_OK; y++)
            for (int32_t x = lo[0]; x < hi[0] && status == OST_OK; x++) {
                const size_t chunk = (size_t)x + (size_t)cd.x * ((size_t)y + (size_t)cd.y * (size_t)z);
                if (bone->active[chunk] > 0)
                    status = plan_chunk(&p, chunk, (const int32_t[3]){x * n, y * n, z * n}, err);
            }
    if (status == OST_OK)
        status = flush(&p, err);
    if (status == OST_OK)
        status = close_part(&p, err);
    if (status == OST_OK && !p.s->warm && bone->density)
        status = warm(&p, err);
    if (status != OST_OK) {
        bone->lost = bone->lost || p.changed;
        ost_cl_finish(b, NULL); /* Waits, because transfers from the event's arrays may not have ended. */
        ost_cl_tool_finish(tool, false);
    }
    return status;
}

ost_status ost_cl_remove(ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                         ost_removal_report *report, ost_error *err)
{
    return run_event((cl_bone *)bone, (cl_tool *)(uintptr_t)tool, event, true, report, err);
}

/* The function casts away const, because run_event allocates buffers on the device on demand. The voxels of the bone
   and the tool do not change. */
ost_status ost_cl_collide(const ost_bone *bone, const ost_tool *tool, const ost_removal_event *event,
                          ost_removal_report *report, ost_error *err)
{
    return run_event((cl_bone *)(uintptr_t)bone, (cl_tool *)(uintptr_t)tool, event, false, report, err);
}
