/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bones of the `cl` backend: a pool of slots on the device, and a table of chunks on the host
 * (AR-CHK).
 *
 * Slices are stored in two passes, so that the operation changes nothing if memory is insufficient:
 *
 *   scan    counts, for each chunk, the voxels that the slices make active  only reads
 *           slots are assigned to the chunks that need one; the pool grows if needed
 *   store   writes densities and occupancy to the slots                     changes the bone
 *           if the slices cover a layer of chunks only in part, the
 *           voxels of all slots are counted again
 *
 * Slices are transferred through a buffer of limited size, the slab, whose voxels are
 * stored x fastest and without padding.
 *
 * The file has more than 500 lines, because the pool, the table and the slices are always changed
 * together.
 */
#include "cl/mirror.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/chunk_grid.h"

enum { SLAB_BYTES = 1 << 26 };

static cl_backend *backend_of(const cl_bone *bone)
{
    return (cl_backend *)bone->base.backend;
}

/* ------------------------------------------------------------ creation, spare buffers */

ost_status ost_cl_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                              ost_bone **out, ost_error *err)
{
    cl_bone *bone = calloc(1, sizeof *bone);
    if (!bone)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone");
    bone->base = (ost_bone){
        .backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold};
    bone->chunk_dims = ost_chunk_dims(geometry->dims, chunk_size);
    bone->chunks = (size_t)ost_dims_count(bone->chunk_dims);
    bone->chunk_voxels = (size_t)chunk_size * (size_t)chunk_size * (size_t)chunk_size;
    bone->slot = malloc(bone->chunks * sizeof *bone->slot);
    bone->active = calloc(bone->chunks, sizeof *bone->active);
    bone->slots_outdated = true;
    ost_status status = OST_OK;
    if (!bone->slot || !bone->active)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the table of %zu chunks", bone->chunks);
    else
        memset(bone->slot, 0xff, bone->chunks * sizeof *bone->slot); /* OST_CL_NONE */
    const ost_cl_bone shape = {
        .dims = {geometry->dims.x, geometry->dims.y, geometry->dims.z},
        .size = chunk_size,
        .chunk_dims = {bone->chunk_dims.x, bone->chunk_dims.y, bone->chunk_dims.z},
        .threshold = threshold,
    };
    if (status == OST_OK)
        status = ost_cl_buffer((cl_backend *)backend, sizeof shape, &shape, "bone", &bone->shape, err);
    if (status == OST_OK)
        status = ost_cl_buffer((cl_backend *)backend, bone->chunks * sizeof *bone->slot, NULL, "table of chunks",
                               &bone->slots, err);
    if (status != OST_OK) {
        ost_cl_bone_free(&bone->base);
        return status;
    }
    *out = &bone->base;
    return OST_OK;
}

void ost_cl_bone_free(ost_bone *base)
{
    cl_bone *bone = (cl_bone *)base;
    cl_backend *b = backend_of(bone);
    ost_cl_buffer_free(b, &bone->shape);
    ost_cl_spare_return(b, &bone->density, bone->density_bytes_reserved);
    ost_cl_buffer_free(b, &bone->words);
    ost_cl_buffer_free(b, &bone->slots);
    free(bone->slot);
    free(bone->active);
    free(bone->free);
    ost_cl_mirror_free(bone);
    free(bone);
}

ost_status ost_cl_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    const cl_bone *bone = (const cl_bone *)base;
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    info->active_chunks = 0;
    info->active_voxels = 0;
    for (size_t c = 0; c < bone->chunks; c++) {
        info->active_chunks += bone->active[c] > 0;
        info->active_voxels += bone->active[c];
    }
    info->chunk_bytes = info->active_chunks * (int64_t)ost_chunk_bytes(base->chunk_size);
    /*
     * A slot occupies memory for its densities, its words of occupancy, and an element of the list of free slots. A
     * chunk occupies memory for its slot number, on the host and on the device, and for its count of active voxels.
     */
    const size_t slot = bone->chunk_voxels * sizeof(int16_t) + bone->chunk_voxels / 8 + sizeof *bone->free;
    const size_t chunk = 2 * sizeof *bone->slot + sizeof *bone->active;
    info->resident_bytes = (int64_t)(bone->capacity * slot + bone->chunks * chunk + sizeof *bone) +
                           ost_cl_mirror_bytes(bone);
    return status;
}

/*
 * Ensures that the pool has a capacity of at least `capacity` slots. On failure, the pool does not change. If `raw` is
 * true, the new slots are not set to zero, because the caller writes all slots completely.
 */
static ost_status reserve(cl_bone *bone, size_t capacity, bool raw, ost_error *err)
{
    if (capacity <= bone->capacity)
        return OST_OK;
    cl_backend *b = backend_of(bone);
    const size_t density_bytes = bone->chunk_voxels * sizeof(int16_t), word_bytes = bone->chunk_voxels / 8;
    cl_mem density = NULL, words = NULL;
    size_t reserved = 0;
    uint32_t *list = realloc(bone->free, capacity * sizeof *list);
    if (!list)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of %zu chunks", capacity);
    bone->free = list;
    ost_status status = ost_cl_spare_take(b, capacity * density_bytes, "densities of a bone", &density, &reserved, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, capacity * word_bytes, NULL, "occupancy of a bone", &words, err);
    if (status == OST_OK && !raw)
        status = ost_cl_zero(b, density, 0, capacity * density_bytes, err);
    if (status == OST_OK && !raw)
        status = ost_cl_zero(b, words, 0, capacity * word_bytes, err);
    if (status == OST_OK && bone->used)
        status = ost_cl_copy(b, bone->density, density, bone->used * density_bytes, err);
    if (status == OST_OK && bone->used)
        status = ost_cl_copy(b, bone->words, words, bone->used * word_bytes, err);
    if (status == OST_OK && bone->used) {
        b->entered[OST_CL_PATH_POOL_GROWN]++;
        /* The old buffers must not be released before the copies that read them have ended. */
        status = ost_cl_finish(b, err);
    }
    if (status != OST_OK) {
        ost_cl_spare_return(b, &density, reserved);
        ost_cl_buffer_free(b, &words);
        return status;
    }
    ost_cl_spare_return(b, &bone->density, bone->density_bytes_reserved);
    ost_cl_buffer_free(b, &bone->words);
    bone->density = density;
    bone->density_bytes_reserved = reserved;
    bone->words = words;
    bone->capacity = capacity;
    return OST_OK;
}

static uint32_t take_slot(cl_bone *bone)
{
    if (bone->free_count) {
        backend_of(bone)->entered[OST_CL_PATH_SLOT_REUSED]++;
        return bone->free[--bone->free_count];
    }
    assert(bone->used < bone->capacity);
    return (uint32_t)bone->used++;
}

void ost_cl_bone_release(cl_bone *bone, size_t chunk)
{
    assert(bone->slot[chunk] != OST_CL_NONE && bone->active[chunk] == 0);
    bone->free[bone->free_count++] = bone->slot[chunk];
    bone->slot[chunk] = OST_CL_NONE;
    bone->slots_outdated = true;
}

/* Copies slot[] to the device if it has changed since the last copy. */
static ost_status sync_slots(cl_bone *bone, ost_error *err)
{
    if (!bone->slots_outdated)
        return OST_OK;
    ost_status status = ost_cl_write(backend_of(bone), bone->slots, 0, bone->chunks * sizeof *bone->slot, bone->slot,
                                     err);
    bone->slots_outdated = status != OST_OK;
    return status;
}

/* ---------------------------------------------------------------- slices */

/* The slices to store in a bone. The source is either voxels on the host or a grid that is already on the device. */
typedef struct slices {
    int32_t z0, z1;
    /* voxels on the host, beginning with slice z0; NULL if `slab` is the store of a grid, which begins with slice 0 */
    const int16_t *voxels;
    cl_mem slab;           /* the slices to convert: a buffer of `step` slices, or the store of a grid */
    /* slice k is slice i of the slab; i is layers[first + k - z0] or, if `first` is negative, k - z0 */
    cl_mem layers;
    /* If weights >= 0, slice k is instead the weighted mean of slices i and i + 1 of the slab. The weight of slice
       i + 1 is layers[weights + k - z0]. */
    int32_t first, weights;
    int32_t step;
} slices;

static size_t slice_voxels(const cl_bone *bone)
{
    return (size_t)bone->base.geometry.dims.x * (size_t)bone->base.geometry.dims.y;
}

static int32_t slab_step(const cl_bone *bone, int32_t count)
{
    const size_t fit = ost_cl_staging(backend_of(bone), SLAB_BYTES) / (slice_voxels(bone) * sizeof(int16_t));
    return fit < 1 ? 1 : fit < (size_t)count ? (int32_t)fit : count;
}

/* The function of a pass. It processes the slices z0 <= k < z1, which the slab contains. */
typedef ost_status slab_pass(cl_bone *bone, int32_t z0, int32_t z1, const slices *s, void *user, ost_error *err);

static ost_status for_slabs(cl_bone *bone, const slices *s, slab_pass *pass, void *user, ost_error *err)
{
    ost_status status = OST_OK;
    for (int32_t z = s->z0; z < s->z1 && status == OST_OK; z += s->step) {
        const int32_t end = s->z1 - z < s->step ? s->z1 : z + s->step;
        if (s->voxels) {
            const size_t slice = slice_voxels(bone);
            status = ost_cl_write(backend_of(bone), s->slab, 0, slice * (size_t)(end - z) * sizeof *s->voxels,
                                  s->voxels + slice * (size_t)(z - s->z0), err);
        }
        if (status == OST_OK)
            status = pass(bone, z, end, s, user, err);
    }
    return status;
}

static size_t columns_of(const cl_bone *bone)
{
    return (size_t)bone->chunk_dims.x * (size_t)bone->chunk_dims.y;
}

static ost_status scan(cl_bone *bone, int32_t z0, int32_t z1, const slices *s, void *user, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    cl_mem *active = user;
    const ost_cl_arg args[] = {OST_CL_ARG(bone->shape), OST_CL_ARG(z0),         OST_CL_ARG(z1),
                               OST_CL_ARG(s->first),    OST_CL_ARG(s->weights), OST_CL_ARG(s->layers),
                               OST_CL_ARG(s->slab),     OST_CL_ARG(*active)};
    enum { ARGS = sizeof args / sizeof args[0] };
    if (b->cpu_set)
        return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_scan_layers, (size_t)bone->chunk_dims.y,
                             (size_t)bone->chunk_dims.z, 1, args, ARGS, err);
    return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_scan, (size_t)(z1 - z0), columns_of(bone), 1, args, ARGS, err);
}

static ost_status store(cl_bone *bone, int32_t z0, int32_t z1, const slices *s, void *user, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    const size_t row_words = (size_t)bone->base.chunk_size * (size_t)bone->base.chunk_size / 32;
    const ost_cl_arg args[] = {OST_CL_ARG(bone->shape), OST_CL_ARG(z0),          OST_CL_ARG(z1),
                               OST_CL_ARG(s->first),    OST_CL_ARG(s->weights),  OST_CL_ARG(s->layers),
                               OST_CL_ARG(s->slab),     OST_CL_ARG(bone->slots), OST_CL_ARG(bone->density),
                               OST_CL_ARG(bone->words)};
    enum { ARGS = sizeof args / sizeof args[0] };
    (void)user;
    if (b->cpu_set)
        return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_store_layers, columns_of(bone), (size_t)bone->chunk_dims.z, 1,
                             args, ARGS, err);
    return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_store, row_words, columns_of(bone), (size_t)(z1 - z0), args, ARGS,
                         err);
}

/*
 * Counts the active voxels of all slots. Sets count[i] to the number of active voxels in slot i, for 0 <= i <
 * bone->used.
 */
static ost_status count_slots(cl_bone *bone, uint32_t *count, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    const cl_uint first = 0, slots = (cl_uint)bone->used;
    cl_mem buffer = NULL;
    ost_status status = ost_cl_buffer_zero(b, bone->used * sizeof *count, "counts", &buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_chunk_count, (size_t)bone->base.chunk_size, slots, 1, err,
                               OST_CL_ARG(bone->shape), OST_CL_ARG(first), OST_CL_ARG(slots), OST_CL_ARG(bone->words),
                               OST_CL_ARG(buffer));
    if (status == OST_OK)
        status = ost_cl_read(b, buffer, 0, bone->used * sizeof *count, count, err);
    ost_cl_buffer_free(b, &buffer);
    return status;
}

/* Runs the first pass. Sets scanned[c] to the number of voxels in chunk c that the slices make active. */
static ost_status scan_all(cl_bone *bone, const slices *s, uint32_t *scanned, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    const size_t bytes = bone->chunks * sizeof *scanned;
    cl_mem active = NULL;
    ost_status status = ost_cl_buffer_zero(b, bytes, "counts", &active, err);
    if (status == OST_OK)
        status = for_slabs(bone, s, scan, &active, err);
    if (status == OST_OK)
        status = ost_cl_read(b, active, 0, bytes, scanned, err);
    ost_cl_buffer_free(b, &active);
    return status;
}

/*
 * Assigns slots to the chunks that will have active voxels. Chunks without active voxels may also have slots until
 * store_slices ends.
 */
static ost_status give_slots(cl_bone *bone, const uint32_t *scanned, bool all_slices, ost_error *err)
{
    /* The kernel set for CPUs stores complete chunks including the padding, so the slots need not be cleared. */
    const bool raw = all_slices && bone->used == 0 && backend_of(bone)->cpu_set;
    size_t needed = 0;
    for (size_t c = 0; c < bone->chunks; c++)
        needed += scanned[c] > 0 && bone->slot[c] == OST_CL_NONE;
    if (needed > bone->free_count) {
        ost_status status = reserve(bone, bone->used + needed - bone->free_count, raw, err);
        if (status != OST_OK)
            return status;
    }
    for (size_t c = 0; c < bone->chunks && needed > 0; c++)
        if (scanned[c] > 0 && bone->slot[c] == OST_CL_NONE) {
            bone->slot[c] = take_slot(bone);
            bone->slots_outdated = true;
            needed--;
        }
    return OST_OK;
}

/* Releases the slot of each chunk whose active voxels have all been removed. */
static void release_empty(cl_bone *bone)
{
    for (size_t c = 0; c < bone->chunks; c++)
        if (bone->slot[c] != OST_CL_NONE && bone->active[c] == 0)
            ost_cl_bone_release(bone, c);
}

static ost_status store_slices(cl_bone *bone, const slices *s, ost_error *err)
{
    const int32_t n = bone->base.chunk_size, last = bone->base.geometry.dims.z;
    const size_t layer = (size_t)bone->chunk_dims.x * (size_t)bone->chunk_dims.y;
    const bool complete_layers = s->z0 % n == 0 && (s->z1 % n == 0 || s->z1 == last);
    uint32_t *scanned = calloc(bone->chunks, sizeof *scanned), *counted = NULL;
    ost_status status = OST_OK;
    if (!scanned)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the counts of %zu chunks", bone->chunks);
    if (status == OST_OK)
        status = scan_all(bone, s, scanned, err);
    if (status == OST_OK)
        status = give_slots(bone, scanned, s->z0 == 0 && s->z1 == last, err);
    if (status == OST_OK && bone->used && !complete_layers && !(counted = malloc(bone->used * sizeof *counted)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the counts of %zu chunks", bone->used);
    if (status == OST_OK)
        status = sync_slots(bone, err);
    if (status != OST_OK)
        goto done; /* no kernel has stored a voxel, so chunks that just received a slot have no active voxel */

    status = bone->used ? for_slabs(bone, s, store, NULL, err) : OST_OK;
    if (status == OST_OK && counted)
        status = count_slots(bone, counted, err);
    if (status == OST_OK) /* ost_cl_finish also returns the errors of commands that were enqueued earlier. */
        status = ost_cl_finish(backend_of(bone), err);
    bone->lost = status != OST_OK;
    for (size_t c = layer * (size_t)(s->z0 / n); status == OST_OK && c < layer * (size_t)((s->z1 + n - 1) / n); c++)
        bone->active[c] = !counted ? scanned[c] : bone->slot[c] == OST_CL_NONE ? 0 : counted[bone->slot[c]];
done:
    release_empty(bone);
    free(counted);
    free(scanned);
    return status;
}

ost_status ost_cl_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    cl_bone *bone = (cl_bone *)base;
    cl_backend *b = backend_of(bone);
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status != OST_OK || count == 0)
        return status;
    slices s = {.z0 = z0,
                .z1 = z0 + count,
                .voxels = voxels,
                .layers = bone->slots,
                .first = -1,
                .weights = -1,
                .step = slab_step(bone, count)};
    size_t reserved;
    b->entered[OST_CL_PATH_SLICES_UP_IN_PARTS] += s.step < count;
    ost_cl_mirror_free(bone);
    status = ost_cl_spare_take(b, slice_voxels(bone) * (size_t)s.step * sizeof *voxels, "slices", &s.slab, &reserved,
                               err);
    if (status == OST_OK) {
        status = store_slices(bone, &s, err);
        ost_cl_spare_return(b, &s.slab, reserved);
    }
    return status;
}

ost_status ost_cl_cubic_to_chunks(const ost_grid *base, int chunk_size, int32_t threshold, ost_bone **out,
                                  ost_error *err)
{
    const cl_grid *cubic = (const cl_grid *)base;
    ost_bone *bone = NULL;
    ost_status status = ost_cl_alive(base->backend, cubic->lost, "grid", err);
    if (status == OST_OK)
        status = ost_cl_bone_create(base->backend, &base->geometry, chunk_size, threshold, &bone, err);
    if (status != OST_OK)
        return status;
    const int32_t nz = base->geometry.dims.z;
    slices s = {.z0 = 0,
                .z1 = nz,
                .slab = cubic->store->voxels,
                .layers = ((cl_bone *)bone)->slots,
                .first = -1,
                .weights = -1,
                .step = nz};
    if (cubic->sources) {
        ((cl_backend *)base->backend)->entered[OST_CL_PATH_CHUNKS_OF_LIST]++;
        s.layers = cubic->sources;
        s.first = base->geometry.dims.x + base->geometry.dims.y;
        s.weights = cubic->linear ? 2 * s.first + nz : -1;
    }
    status = store_slices((cl_bone *)bone, &s, err);
    if (status != OST_OK) {
        ost_cl_bone_free(bone);
        return status;
    }
    *out = bone;
    return OST_OK;
}

/* Enqueues a kernel that copies the slices z0 <= z < z1 of the bone to `slab`. */
static ost_status load(cl_bone *bone, cl_int z0, cl_int z1, cl_mem slab, ost_error *err)
{
    cl_backend *b = backend_of(bone);
    const ost_dims d = bone->base.geometry.dims;
    const ost_cl_arg args[] = {OST_CL_ARG(bone->shape), OST_CL_ARG(z0),   OST_CL_ARG(z1), OST_CL_ARG(bone->slots),
                               OST_CL_ARG(bone->density), OST_CL_ARG(slab)};
    enum { ARGS = sizeof args / sizeof args[0] };
    if (b->cpu_set)
        return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_load_rows, (size_t)bone->chunk_dims.y, (size_t)(z1 - z0), 1,
                             args, ARGS, err);
    return ost_cl_launch(b, OST_CL_KERNEL_ost_chunk_load, (size_t)d.x, (size_t)d.y, (size_t)(z1 - z0), args, ARGS, err);
}

ost_status ost_cl_bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    /*
     * The function casts away const, because it may update the bone's table of slots on the device. No voxel changes.
     */
    cl_bone *bone = (cl_bone *)(uintptr_t)base;
    cl_backend *b = backend_of(bone);
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status != OST_OK || count == 0)
        return status;
    const size_t slice = slice_voxels(bone);
    if (bone->used == 0) {
        b->entered[OST_CL_PATH_EMPTY_DOWN]++;
        memset(voxels, 0, slice * (size_t)count * sizeof *voxels);
        return OST_OK;
    }
    const int32_t step = slab_step(bone, count);
    b->entered[OST_CL_PATH_SLICES_DOWN_IN_PARTS] += step < count;
    cl_mem slab = NULL;
    size_t reserved = 0;
    status = ost_cl_spare_take(b, slice * (size_t)step * sizeof *voxels, "slices", &slab, &reserved, err);
    if (status == OST_OK)
        status = sync_slots(bone, err);
    for (cl_int z = z0; z < z0 + count && status == OST_OK; z += step) {
        const cl_int end = z0 + count - z < step ? z0 + count : z + step;
        status = load(bone, z, end, slab, err);
        if (status == OST_OK)
            status = ost_cl_read(b, slab, 0, slice * (size_t)(end - z) * sizeof *voxels,
                                 voxels + slice * (size_t)(z - z0), err);
    }
    ost_cl_spare_return(b, &slab, reserved);
    return status;
}

ost_status ost_cl_bone_occupancy(const ost_bone *base, size_t count, const int32_t *chunks, uint32_t *words,
                                 ost_error *err)
{
    const cl_bone *bone = (const cl_bone *)base;
    const size_t bytes = bone->chunk_voxels / 8;
    ost_status status = ost_cl_alive(base->backend, bone->lost, "bone", err);
    if (status != OST_OK)
        return status;
    backend_of(bone)->entered[OST_CL_PATH_OCCUPANCY_DOWN]++;
    for (size_t i = 0; i < count && status == OST_OK; i++, words += bytes / sizeof *words) {
        const uint32_t slot = bone->slot[chunks[i]];
        if (slot != OST_CL_NONE)
            status = ost_cl_read_later(backend_of(bone), bone->words, slot * bytes, bytes, words, err);
        else
            memset(words, 0, bytes);
    }
    /* Waits even after an error, because transfers to `words` may not have ended. */
    const ost_status finished = ost_cl_finish(backend_of(bone), status == OST_OK ? err : NULL);
    return status == OST_OK ? finished : status;
}

/* --------------------------------------------------------------- digests */

/* Copies leaf (x, y) from the `count` slices of the leaf's layer. Returns false if all voxels of the leaf are zero. */
static bool cut_leaf(const ost_dims dims, const int16_t *voxels, int32_t x, int32_t y, int32_t count, int16_t *leaf)
{
    int16_t any = 0;
    const int32_t nx = dims.x - x * OST_LEAF < OST_LEAF ? dims.x - x * OST_LEAF : OST_LEAF;
    const int32_t ny = dims.y - y * OST_LEAF < OST_LEAF ? dims.y - y * OST_LEAF : OST_LEAF;
    memset(leaf, 0, OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    for (int32_t k = 0; k < count; k++)
        for (int32_t j = 0; j < ny; j++) {
            const int16_t *from = voxels + (size_t)x * OST_LEAF +
                                  (size_t)dims.x * ((size_t)(y * OST_LEAF + j) + (size_t)dims.y * (size_t)k);
            int16_t *to = leaf + (k * OST_LEAF + j) * OST_LEAF;
            for (int32_t i = 0; i < nx; i++) {
                to[i] = from[i];
                any |= from[i];
            }
        }
    return any != 0;
}

ost_status ost_cl_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const cl_backend *b = (const cl_backend *)base->backend;
    const ost_dims dims = base->geometry.dims, leaf_dims = ost_leaf_dims(dims);
    const size_t slice = (size_t)dims.x * (size_t)dims.y;
    int16_t *voxels = malloc(slice * (size_t)(dims.z < OST_LEAF ? dims.z : OST_LEAF) * sizeof *voxels);
    int16_t *leaf = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    ost_status status = OST_OK;
    if (!voxels || !leaf)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a layer of leaves");
    for (int32_t z = 0; z < leaf_dims.z && status == OST_OK; z++) {
        const int32_t z0 = z * OST_LEAF, count = dims.z - z0 < OST_LEAF ? dims.z - z0 : OST_LEAF;
        status = ost_cl_bone_download(base, z0, count, voxels, err);
        for (int32_t y = 0; y < leaf_dims.y && status == OST_OK; y++)
            for (int32_t x = 0; x < leaf_dims.x && status == OST_OK; x++, leaves++) {
                if (cut_leaf(dims, voxels, x, y, count, leaf))
                    status = ost_digest_leaf16(leaf, leaves, err);
                else
                    *leaves = b->empty_leaf;
            }
    }
    free(leaf);
    free(voxels);
    return status;
}
