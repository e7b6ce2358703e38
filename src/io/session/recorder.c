/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A recorder consists of a ring buffer and a thread that writes the records from the ring to the file.
 *
 *   put --> ring --every 25 ms: all waiting records, as blocks--> file --sync-->
 *
 * The writer thread wakes up periodically, because waking it from `put` would require a system call within the tick.
 * Unless the disk is slow, a wait, a write and a sync together take less than 100 ms, so a power cut loses at most 100
 * ms of records. If the process is killed, at most 25 ms of records are lost.
 *
 * A failed write is undone by truncating the file to its last complete block, and retried every 250 ms. Meanwhile, the
 * ring accepts further records. Records that do not fit are counted, and blocks contain this count. If space on a full
 * disk is freed in time, no record is lost.
 */
#include "io/session/recorder.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "io/session/ring.h"
#include "io/thread.h"

/*
 * Maximum number of records in a block: one second of ticks. A damaged block therefore loses at most one second, even
 * if more records were waiting when the block was written.
 */
enum { MOST = 1000 };
_Static_assert(MOST <= (int)SESSION_BLOCK_RECORDS, "readers have room for a block");

enum { CAPACITY = 65536, CAPACITY_MAX = 1 << 24, POLL_MS = 25, RETRY_MS = 250, PATIENCE_MS = 10000 };

struct ost_recorder {
    session_ring ring;
    _Atomic uint64_t lost;
    /* true after a long disk failure; ost_recorder_put_waiting then returns at once. Used only by the producer */
    bool impatient;

    char *name;  /* owned */
    int fd;      /* descriptor of the file; -1 if the caller provided the sink */
    bool sync;
    session_writer writer;       /* used only by the writer thread */
    unsigned char *block;        /* owned; buffer for a block header and records; used only by the writer thread */
    uint64_t in_block;           /* number of records in `block` that have not been written yet */
    uint64_t lost_in_block;      /* value of `lost` when the records in `block` were taken from the ring */
    pthread_t thread;
    bool running;

    _Atomic uint64_t put, written, bytes;
    _Atomic int failing; /* errno of the last write; 0 if it succeeded */
    _Atomic bool stop;
    pthread_mutex_t wake_lock; /* protects `stop`; never locked by functions that put records */
    pthread_cond_t wake;
};

/* --------------------------------------------- the sink that writes to a file */

static int file_append(void *user, const void *bytes, size_t size)
{
    const ost_recorder *r = user;
    const char *p = bytes;
    while (size > 0) {
        ssize_t n = write(r->fd, p, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? errno : ENOSPC;
        p += n;
        size -= (size_t)n;
    }
    return 0;
}

static int file_cut(void *user, uint64_t size)
{
    const ost_recorder *r = user;
    if (ftruncate(r->fd, (off_t)size) != 0 || lseek(r->fd, (off_t)size, SEEK_SET) < 0)
        return errno;
    return 0;
}

static int file_sync(void *user)
{
    const ost_recorder *r = user;
    /* EINVAL and EROFS mean that the target, such as /dev/null, cannot be synced; this is not an error. */
    return fdatasync(r->fd) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

static const char *reason_of(int error, char text[160])
{
    const char *known = error == ENOSPC ? "the disk is full"
                        : error == EDQUOT ? "the disk quota is used up"
                        : error == EFBIG  ? "the limit of a file's size is reached"
                        : error == EPIPE  ? "the reader has closed the pipe"
                                          : NULL;
    char buffer[120];
    snprintf(text, 160, "%s", known ? known : strerror_r(error, buffer, sizeof buffer));
    return text;
}

/* -------------------------------------------------------- the writer thread */

/* Writes one block. Returns false if no records are waiting or if the disk fails. */
static bool write_block(ost_recorder *r)
{
    if (r->in_block == 0) {
        const uint64_t waiting = ring_waiting(&r->ring);
        if (waiting == 0)
            return false;
        r->in_block = waiting < MOST ? waiting : MOST;
        ring_copy(&r->ring, r->block + SESSION_BLOCK, r->in_block);
        ring_pop(&r->ring, r->in_block);
        r->lost_in_block = atomic_load_explicit(&r->lost, memory_order_relaxed);
    }
    unsigned char *records = r->block + SESSION_BLOCK;
    uint64_t count = r->in_block;
    int error;
    /* Retries with fewer records, because a nearly full disk may have space for some of them. */
    while ((error = ost_session_write_records(&r->writer, records, (uint32_t)count, r->lost_in_block)) != 0 &&
           count > 1)
        count /= 2;
    atomic_store_explicit(&r->failing, error, memory_order_release);
    if (error)
        return false;
    atomic_fetch_add_explicit(&r->written, count, memory_order_relaxed);
    atomic_store_explicit(&r->bytes, r->writer.bytes, memory_order_relaxed);
    r->in_block -= count;
    memmove(records, records + count * SESSION_RECORD, r->in_block * SESSION_RECORD);
    return true;
}

static void write_all(ost_recorder *r)
{
    bool any = false;
    while (write_block(r))
        any = true;
    if (any && r->sync && !atomic_load(&r->failing)) {
        const int error = r->writer.sink.sync(r->writer.sink.user);
        if (error)
            atomic_store_explicit(&r->failing, error, memory_order_release);
    }
}

static void *work(void *user)
{
    ost_recorder *r = user;
    struct timespec next;
    clock_gettime(CLOCK_MONOTONIC, &next);
    pthread_mutex_lock(&r->wake_lock);
    while (!atomic_load(&r->stop)) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        next = now;
        next.tv_nsec += (atomic_load(&r->failing) ? RETRY_MS : POLL_MS) * 1000000L;
        next.tv_sec += next.tv_nsec / 1000000000L;
        next.tv_nsec %= 1000000000L;
        while (!atomic_load(&r->stop) && pthread_cond_timedwait(&r->wake, &r->wake_lock, &next) != ETIMEDOUT)
            ;
        pthread_mutex_unlock(&r->wake_lock);
        write_all(r);
        pthread_mutex_lock(&r->wake_lock);
    }
    pthread_mutex_unlock(&r->wake_lock);
    write_all(r);
    return NULL;
}

/* Starts the writer thread, with normal priority and with all signals blocked. */
static int begin_thread(ost_recorder *r)
{
    pthread_condattr_t clock;
    int error = pthread_condattr_init(&clock);
    if (error)
        return error;
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    error = pthread_cond_init(&r->wake, &clock);
    pthread_condattr_destroy(&clock);
    if (error)
        return error;
    pthread_mutex_init(&r->wake_lock, NULL);
    error = ost_thread_begin(&r->thread, work, r);
    r->running = error == 0;
    if (error) {
        pthread_cond_destroy(&r->wake);
        pthread_mutex_destroy(&r->wake_lock);
    }
    return error;
}

/* ----------------------------------------------------------- the interface */

static void recorder_free(ost_recorder *r)
{
    if (r->running) {
        pthread_cond_destroy(&r->wake);
        pthread_mutex_destroy(&r->wake_lock);
    }
    if (r->fd >= 0)
        close(r->fd);
    ring_close(&r->ring);
    free(r->block);
    free(r->name);
    free(r);
}

/* Allocates a recorder without a sink. */
static ost_status recorder_make(const char *name, const ost_recorder_options *options, ost_recorder **out,
                                ost_error *err)
{
    const ost_recorder_options chosen = options ? *options : (ost_recorder_options){0};
    const uint32_t capacity = chosen.capacity ? chosen.capacity : CAPACITY;
    *out = NULL;
    if (capacity > CAPACITY_MAX || (capacity & (capacity - 1)) != 0)
        return ost_fail(err, OST_ERR_USAGE, "a recorder's capacity of %u records; expected a power of two up to %d",
                        (unsigned)capacity, CAPACITY_MAX);
    /* aligned_alloc is used, because the ring's head and tail must be aligned to cache lines. */
    const size_t size = (sizeof(ost_recorder) + RING_LINE - 1) / RING_LINE * RING_LINE;
    ost_recorder *r = aligned_alloc(RING_LINE, size);
    if (!r)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a recorder", name);
    memset(r, 0, size);
    r->fd = -1;
    r->sync = !chosen.no_sync;
    r->name = strdup(name);
    r->block = malloc(SESSION_BLOCK + SESSION_PAYLOAD_MAX);
    if (!r->name || !r->block || !ring_open(&r->ring, capacity)) {
        recorder_free(r);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a recorder of %u records", name,
                        (unsigned)capacity);
    }
    *out = r;
    return OST_OK;
}

static ost_status begin(ost_recorder *r, const ost_session_header *header, ost_error *err)
{
    unsigned char *payload = NULL;
    uint32_t size;
    char text[160];
    ost_status status = ost_session_header_encode(header, &payload, &size, err);
    if (status != OST_OK)
        return status;
    int error = ost_session_write_header(&r->writer, payload, size);
    free(payload);
    if (!error && r->sync)
        error = r->writer.sink.sync(r->writer.sink.user);
    atomic_store(&r->bytes, r->writer.bytes);
    if (error)
        return ost_fail(err, OST_ERR_IO, "%s: cannot start the recording: %s", r->name, reason_of(error, text));
    error = begin_thread(r);
    if (error)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: cannot create a thread for recording: %s", r->name,
                        strerror(error));
    return OST_OK;
}

ost_status ost_recorder_open_sink(const char *name, const session_sink *sink, const ost_session_header *header,
                                  const ost_recorder_options *options, ost_recorder **out, ost_error *err)
{
    ost_recorder *r;
    *out = NULL;
    ost_status status = recorder_make(name, options, &r, err);
    if (status != OST_OK)
        return status;
    r->writer.sink = *sink;
    status = begin(r, header, err);
    if (status == OST_OK)
        *out = r;
    else
        recorder_free(r);
    return status;
}

/*
 * Creates the file, or truncates an existing file. Fails if another recorder has locked the file. Refuses a symbolic
 * link, because opening a link would truncate the file to which it points.
 */
static ost_status create_file(ost_recorder *r, const char *path, ost_error *err)
{
    r->fd = open(path, O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NOCTTY, 0666);
    if (r->fd < 0 && errno == ELOOP)
        return ost_fail(err, OST_ERR_IO, "%s: is a symbolic link; pass the name of the file itself", path);
    if (r->fd < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open for recording: %s", path, strerror(errno));
    if (flock(r->fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return ost_fail(err, OST_ERR_IO, "%s: in use by another recording", path);
    struct stat st;
    if (fstat(r->fd, &st) == 0 && S_ISREG(st.st_mode) && ftruncate(r->fd, 0) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open for recording: %s", path, strerror(errno));
    return OST_OK;
}

ost_status ost_recorder_open(const char *path, const ost_session_header *header, const ost_recorder_options *options,
                             ost_recorder **out, ost_error *err)
{
    ost_recorder *r;
    *out = NULL;
    ost_status status = recorder_make(path, options, &r, err);
    if (status != OST_OK)
        return status;
    r->writer.sink = (session_sink){.user = r, .append = file_append, .cut = file_cut, .sync = file_sync};
    status = create_file(r, path, err);
    if (status == OST_OK)
        status = begin(r, header, err);
    if (status == OST_OK)
        *out = r;
    else
        recorder_free(r);
    return status;
}

bool ost_recorder_put(ost_recorder *recorder, const ost_record *record)
{
    unsigned char *slot = ring_slot(&recorder->ring);
    if (!slot) {
        atomic_fetch_add_explicit(&recorder->lost, 1, memory_order_relaxed);
        return false;
    }
    ost_session_record_encode(record, slot);
    ring_push(&recorder->ring);
    atomic_fetch_add_explicit(&recorder->put, 1, memory_order_relaxed);
    return true;
}

bool ost_recorder_put_waiting(ost_recorder *recorder, const ost_record *record)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    for (int ms = 0; !ring_slot(&recorder->ring) && !recorder->impatient; ms++) {
        recorder->impatient = ms >= PATIENCE_MS && atomic_load(&recorder->failing);
        nanosleep(&pause, NULL);
    }
    return ost_recorder_put(recorder, record);
}

void ost_recorder_state_get(ost_recorder *recorder, ost_recorder_state *out)
{
    const int failing = atomic_load_explicit(&recorder->failing, memory_order_acquire);
    *out = (ost_recorder_state){
        .written = atomic_load_explicit(&recorder->written, memory_order_relaxed),
        .put = atomic_load_explicit(&recorder->put, memory_order_relaxed),
        .lost = atomic_load_explicit(&recorder->lost, memory_order_relaxed),
        .written_bytes = atomic_load_explicit(&recorder->bytes, memory_order_relaxed),
        .failing = failing != 0,
    };
    if (failing)
        reason_of(failing, out->reason);
}

ost_status ost_recorder_close(ost_recorder *recorder, const ost_session_end *end, ost_error *err)
{
    if (!recorder)
        return OST_OK;
    pthread_mutex_lock(&recorder->wake_lock);
    atomic_store(&recorder->stop, true);
    pthread_cond_signal(&recorder->wake);
    pthread_mutex_unlock(&recorder->wake_lock);
    pthread_join(recorder->thread, NULL);
    if (end && !atomic_load(&recorder->failing)) {
        /* The writer thread has ended and the ring is empty, so there is a free slot for the end record. */
        const ost_record record = {.kind = OST_RECORD_END, .as.end = *end};
        ost_recorder_put(recorder, &record);
        write_all(recorder);
    }
    ost_recorder_state state;
    ost_recorder_state_get(recorder, &state);
    ost_status status = OST_OK;
    if (state.failing)
        status = ost_fail(err, OST_ERR_IO, "%s: recording failed: %s; %llu records are in the file, %llu are not",
                          recorder->name, state.reason, (unsigned long long)state.written,
                          (unsigned long long)(state.put - state.written + state.lost));
    else if (state.lost)
        status = ost_fail(err, OST_ERR_IO, "%s: %llu of %llu records were lost: the disk was too slow", recorder->name,
                          (unsigned long long)state.lost, (unsigned long long)(state.put + state.lost));
    recorder_free(recorder);
    return status;
}
