/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Passes the state and the chunks of the bone from the tick to the viewer.
 *
 * The state has three buffers. The tick writes to the back buffer, the viewer reads the front buffer, and the third
 * buffer is the middle buffer. The tick and the viewer each exchange their own buffer with the middle buffer, so
 * they never use the same buffer at the same time.
 *
 *        tick                         viewer
 *     state[back]  <--> middle <-->  state[front]        middle: index of a buffer, and a bit for "new"
 *
 * The words of the bone are in memory that the tick and the viewer share; each word is atomic. The tick writes the
 * words of a chunk and then sets the chunk's dirty bit (release). The viewer clears dirty bits (acquire) and then
 * reads the words. If the tick writes while the viewer reads, the dirty bit is set again afterwards, and the viewer
 * reads the chunk once more. Therefore no change is missed.
 *
 *     waiting: a queue of distinct slots              words[slot]     dirty
 *     changed --> [ 7 | 3 | 12 |   |   ] --publish--> 1 0 1 1 ...     bit of slot
 */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/live.h>

enum { LINE = 64, BUDGET_WORDS = 2048, FRESH = 4, NONE = -1, STATES = 3 };

struct ost_live_channel {
    const ost_bone *bone;
    ost_geometry geometry;
    int n;
    ost_dims chunk_dims;
    size_t chunk_words;    /* number of 32-bit words in a chunk */
    int32_t *slot_of;      /* owned; slot of each chunk; NONE for a chunk that had no active voxels at the start */
    int32_t *chunk_of;     /* owned; chunk of each slot */
    int32_t slots;
    _Atomic uint32_t *words; /* owned; chunk_words words for each slot */
    _Atomic uint64_t *dirty; /* owned; one bit for each slot */

    ost_live_state state[STATES];
    _Alignas(LINE) _Atomic unsigned middle;
    _Alignas(LINE) unsigned front; /* index of the viewer's buffer */
    bool any;              /* used by the viewer; true once state[front] contains a state */
    uint32_t *seen;        /* owned; used by the viewer; the words of one chunk */

    _Alignas(LINE) unsigned back; /* index of the tick's buffer; this and all members below are used only by the tick */
    int32_t *waiting;      /* owned; a ring buffer of slot numbers */
    bool *waits;           /* owned; for each slot, true if the slot is in `waiting` */
    int32_t first, count;
    uint32_t *fresh;       /* owned; words of all chunks that one call publishes */
    int32_t at_once;
};

static size_t dirty_words(const ost_live_channel *live)
{
    return ((size_t)live->slots + 63) / 64;
}

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for a snapshot of a bone");
}

/* Calls `visit` with the words of each chunk, in ascending order of chunk numbers. */
static ost_status for_chunks(ost_live_channel *live, int64_t chunks,
                             void (*visit)(ost_live_channel *live, int32_t chunk, const uint32_t *words),
                             ost_error *err)
{
    uint32_t *words = malloc(live->chunk_words * sizeof *words);
    ost_status status = words ? OST_OK : no_memory(err);
    for (int32_t c = 0; c < chunks && status == OST_OK; c++) {
        status = ost_bone_occupancy(live->bone, 1, &c, words, err);
        if (status == OST_OK)
            visit(live, c, words);
    }
    free(words);
    return status;
}

static void number(ost_live_channel *live, int32_t chunk, const uint32_t *words)
{
    bool any = false;
    for (size_t i = 0; i < live->chunk_words && !any; i++)
        any = words[i] != 0;
    live->slot_of[chunk] = any ? live->slots++ : NONE;
}

static void store(ost_live_channel *live, int32_t slot, const uint32_t *words)
{
    _Atomic uint32_t *to = live->words + (size_t)slot * live->chunk_words;
    for (size_t i = 0; i < live->chunk_words; i++)
        atomic_store_explicit(&to[i], words[i], memory_order_relaxed);
    atomic_fetch_or_explicit(&live->dirty[slot / 64], UINT64_C(1) << (slot % 64), memory_order_release);
}

static void fill(ost_live_channel *live, int32_t chunk, const uint32_t *words)
{
    const int32_t slot = live->slot_of[chunk];
    if (slot != NONE) {
        live->chunk_of[slot] = chunk;
        store(live, slot, words);
    }
}

static ost_status make(ost_live_channel *live, ost_error *err)
{
    ost_bone_info info;
    ost_status status = ost_bone_info_get(live->bone, &info, err);
    if (status != OST_OK)
        return status;
    live->geometry = info.geometry;
    live->n = info.chunk_size;
    live->chunk_dims = info.chunk_dims;
    live->chunk_words = (size_t)live->n * (size_t)live->n * (size_t)live->n / 32;
    live->at_once = (int32_t)(BUDGET_WORDS / live->chunk_words);
    live->at_once = live->at_once ? live->at_once : 1;
    live->slot_of = malloc((size_t)info.chunks * sizeof *live->slot_of);
    if (!live->slot_of)
        return no_memory(err);
    status = for_chunks(live, info.chunks, number, err);
    if (status != OST_OK)
        return status;
    const size_t capacity = (size_t)live->slots + 1; /* at least 1, even without slots */
    live->chunk_of = malloc(capacity * sizeof *live->chunk_of);
    live->words = malloc(capacity * live->chunk_words * sizeof(_Atomic uint32_t));
    live->dirty = calloc(dirty_words(live) + 1, sizeof(_Atomic uint64_t));
    live->waiting = malloc(capacity * sizeof *live->waiting);
    live->waits = calloc(capacity, sizeof *live->waits);
    live->fresh = malloc((size_t)live->at_once * live->chunk_words * sizeof *live->fresh);
    live->seen = malloc(live->chunk_words * sizeof *live->seen);
    if (!live->chunk_of || !live->words || !live->dirty || !live->waiting || !live->waits || !live->fresh ||
        !live->seen)
        return no_memory(err);
    atomic_init(&live->middle, 1);
    live->front = 0;
    live->back = 2;
    return for_chunks(live, info.chunks, fill, err);
}

ost_status ost_live_create(const ost_bone *bone, ost_live_channel **out, ost_error *err)
{
    *out = NULL;
    if (!bone)
        return ost_fail(err, OST_ERR_USAGE, "no bone given");
    ost_live_channel *live = aligned_alloc(LINE, (sizeof *live + LINE - 1) / LINE * LINE);
    if (!live)
        return no_memory(err);
    memset(live, 0, sizeof *live);
    live->bone = bone;
    ost_status status = make(live, err);
    if (status != OST_OK) {
        ost_live_free(live);
        return status;
    }
    *out = live;
    return OST_OK;
}

void ost_live_free(ost_live_channel *live)
{
    if (!live)
        return;
    free(live->slot_of);
    free(live->chunk_of);
    free(live->words);
    free(live->dirty);
    free(live->waiting);
    free(live->waits);
    free(live->fresh);
    free(live->seen);
    free(live);
}

const ost_geometry *ost_live_geometry(const ost_live_channel *live)
{
    return &live->geometry;
}

int ost_live_chunk_size(const ost_live_channel *live)
{
    return live->n;
}

/* ------------------------------------------------------------------- tick */

void ost_live_changed(ost_live_channel *live, const ost_removal_report *report)
{
    for (size_t i = 0; report && i < report->count; i++) {
        const int32_t slot = live->slot_of[report->chunks[i].chunk];
        if (slot == NONE || live->waits[slot])
            continue;
        int32_t last = live->first + live->count; /* cannot overflow, because slots <= 2^30 (2^10 chunks per axis) */
        last = last < live->slots ? last : last - live->slots;
        live->waiting[last] = slot;
        live->waits[slot] = true;
        live->count++;
    }
}

/* Publishes the first waiting slots, at most live->at_once of them. */
static ost_status publish_some(ost_live_channel *live, ost_error *err)
{
    int32_t chunk[BUDGET_WORDS / 128] = {0}, slot[BUDGET_WORDS / 128]; /* a chunk of 16^3 voxels has 128 words */
    const int32_t some = live->count < live->at_once ? live->count : live->at_once;
    for (int32_t i = 0; i < some; i++) {
        const int32_t at = live->first + i;
        slot[i] = live->waiting[at < live->slots ? at : at - live->slots];
        chunk[i] = live->chunk_of[slot[i]];
    }
    ost_status status = ost_bone_occupancy(live->bone, (size_t)some, chunk, live->fresh, err);
    if (status != OST_OK)
        return status;
    for (int32_t i = 0; i < some; i++) {
        store(live, slot[i], live->fresh + (size_t)i * live->chunk_words);
        live->waits[slot[i]] = false;
    }
    live->first += some;
    live->first = live->first < live->slots ? live->first : live->first - live->slots;
    live->count -= some;
    return OST_OK;
}

ost_status ost_live_publish(ost_live_channel *live, const ost_live_state *state, ost_error *err)
{
    live->state[live->back] = *state;
    live->back = atomic_exchange_explicit(&live->middle, live->back | FRESH, memory_order_acq_rel) & ~(unsigned)FRESH;
    return live->count ? publish_some(live, err) : OST_OK;
}

ost_status ost_live_flush(ost_live_channel *live, ost_error *err)
{
    ost_status status = OST_OK;
    while (live->count && status == OST_OK)
        status = publish_some(live, err);
    return status;
}

/* ----------------------------------------------------------------- viewer */

bool ost_live_state_get(ost_live_channel *live, ost_live_state *out)
{
    if (atomic_load_explicit(&live->middle, memory_order_relaxed) & FRESH) {
        live->front = atomic_exchange_explicit(&live->middle, live->front, memory_order_acq_rel) & ~(unsigned)FRESH;
        live->any = true;
    }
    if (live->any)
        *out = live->state[live->front];
    return live->any;
}

static ost_status show(ost_live_channel *live, int32_t slot, ost_live_visit *visit, void *user, ost_error *err)
{
    const _Atomic uint32_t *from = live->words + (size_t)slot * live->chunk_words;
    const int32_t chunk = live->chunk_of[slot];
    const ost_dims d = live->chunk_dims;
    const int32_t at[3] = {chunk % d.x, chunk / d.x % d.y, chunk / d.x / d.y};
    for (size_t i = 0; i < live->chunk_words; i++)
        live->seen[i] = atomic_load_explicit(&from[i], memory_order_relaxed);
    return visit(user, at, live->seen, err);
}

ost_status ost_live_take(ost_live_channel *live, ost_live_visit *visit, void *user, ost_error *err)
{
    ost_status status = OST_OK;
    for (size_t w = 0; w < dirty_words(live) && status == OST_OK; w++) {
        if (!atomic_load_explicit(&live->dirty[w], memory_order_relaxed))
            continue;
        uint64_t left = atomic_exchange_explicit(&live->dirty[w], 0, memory_order_acquire);
        for (; left && status == OST_OK; left &= left - 1) {
            status = show(live, (int32_t)(w * 64) + __builtin_ctzll(left), visit, user, err);
            if (status != OST_OK)
                break;
        }
        /* Restores the dirty bits of those chunks that were not visited. */
        if (left)
            atomic_fetch_or_explicit(&live->dirty[w], left, memory_order_relaxed);
    }
    return status;
}
