/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A session is a file that records the inputs of a world and the results of its
 * steps, tick by tick, while the world runs (docs/spec/session.md).
 *
 *   tick --put--> ring --> writer thread --> blocks, appended --> SESSION
 *                                                                    |
 *   the same ticks, on any backend  <------- ost_session_next <------'
 *
 * A session contains inputs, not voxels: bone and tools are identified by their digests, and
 * ost_world_step produces the same grids from the same ticks.  Each tick contains a digest of the
 * results of its step, so that a replay can find the first tick that differs.
 *
 * Data is only appended to the file.  If the process is killed or the power fails, at
 * most the last 100 ms are lost.  If the file is damaged, only the affected blocks are
 * lost, and the reader reports which ticks are missing.
 *
 * Threads: a header or an open session may be used by one thread at a time.  The comments of the
 * recorder's functions state on which threads they may be called.
 */
#ifndef OSTEON_SESSION_H
#define OSTEON_SESSION_H

#include <osteon/digest.h>
#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- header */

/*
 * The description of a session, as keys and values in the order in which they were set. A key matches the pattern
 * [a-z0-9_.]{1,40}. A value has up to OST_SESSION_VALUE bytes other than NUL. docs/spec/session.md lists the keys
 * with a defined meaning.
 */
enum { OST_SESSION_KEY = 41, OST_SESSION_VALUE = 4096, OST_SESSION_KEYS_MAX = 128 };
typedef struct ost_session_header ost_session_header;

/* Creates an empty header. The only error is OST_ERR_MEMORY. The caller frees *out with ost_session_header_free. */
OST_API ost_status ost_session_header_create(ost_session_header **out, ost_error *err);
/* Frees a header. NULL is allowed. */
OST_API void ost_session_header_free(ost_session_header *header);
/* Sets the value of a key. Returns OST_ERR_RANGE if key or value is not allowed, or if there are too many keys, and
 * OST_ERR_MEMORY if memory is exhausted. */
OST_API ost_status ost_session_header_set(ost_session_header *header, const char *key, const char *value,
                                          ost_error *err);
/* Returns the value of key, or NULL if key is not set. The pointer is valid until header is changed. */
OST_API const char *ost_session_header_get(const ost_session_header *header, const char *key);
/* Returns the number of keys of a header. */
OST_API int ost_session_header_count(const ost_session_header *header);
/*
 * Stores a key and its value in *key and *value. `index` is the position of the key, counted from 0, in the order in
 * which the keys were set. The strings are valid until the header is changed or freed.
 */
OST_API void ost_session_header_entry(const ost_session_header *header, int index, const char **key,
                                      const char **value);

/* --------------------------------------------------------------- records */

enum {
    OST_TICK_REMOVAL = 1,   /* set if the tick executed a removal event */
    OST_TICK_MET = 2,       /* set if the boxes of bone and tool intersected */
    OST_TICK_FORCE = 4,     /* set if the force was written to the device */
    OST_TICK_DECLARED = 8,  /* set if the device had no new pose, so that the last pose was used */
    /* Set if the tool was lifted before this tick (path.h). This bit is used only in files, where it stores
     * tick.lifted. */
    OST_TICK_LIFTED = 16
};

typedef struct ost_session_tick {
    uint64_t number; /* number of the tick, counted from 0; if a number is missing, its record was lost */
    ost_tick tick;   /* input of the world */
    uint32_t flags, buttons;
    /* The results of the step. */
    uint64_t digest;         /* ost_step_digest (sim.h) */
    uint32_t removed, touched; /* number of removed voxels and number of touched voxels, each at most 2^32 - 1 */
    uint16_t poses;          /* number of poses of the sweep */
    /* The fault, an ost_fault (operation.h); 0 if there is none. During a fault, the device receives no force. */
    uint16_t fault;
    /* The following members are set only in a live operation; otherwise, they are zero. */
    int32_t force_un[3];     /* force in micronewtons, in the bone's frame */
    int32_t torque_unm[3];   /* torque in micronewton metres about the tool's origin */
    uint32_t wake_ns, exec_ns; /* delay from the due time of the tick to its start, and duration of the tick */
    uint32_t missed;         /* number of ticks that were skipped before this tick */
} ost_session_tick;

enum { OST_SESSION_TEXT = 104 };
/* A line of text with a time, for instance the description of a fault. */
typedef struct ost_session_note {
    int64_t t_ns;
    char text[OST_SESSION_TEXT]; /* one line of text, which is truncated if it is too long */
} ost_session_note;

/* The last record of a session. It is missing if the session was not ended normally or is truncated. */
typedef struct ost_session_end {
    uint64_t ticks, removals, removed_voxels; /* totals of the world */
    bool has_root;
    ost_digest root; /* digest of the bone at the end */
} ost_session_end;

/* The kind of a record. */
typedef enum ost_record_kind { OST_RECORD_TICK = 1, OST_RECORD_NOTE = 2, OST_RECORD_END = 3 } ost_record_kind;

/* A record of a session; `kind` selects the member of `as`. */
typedef struct ost_record {
    ost_record_kind kind;
    union {
        ost_session_tick tick;
        ost_session_note note;
        ost_session_end end;
    } as;
} ost_record;

/* --------------------------------------------------------------- reading */

/* The content of a session file, and the amount of data that is missing. */
typedef struct ost_session_summary {
    uint64_t file_bytes, blocks, records, ticks;
    uint64_t first_tick, last_tick; /* numbers of the first and the last tick; undefined if there are no ticks */
    int64_t first_t_ns, last_t_ns;
    bool ended;                    /* true if the end record is present */
    uint64_t complete_ticks;       /* number of ticks before the first missing tick; only these ticks can be replayed */
    /*
     * Number of records that were lost because the ring of the recorder had no free slot. The recorder writes this
     * number to the file.
     */
    uint64_t lost_records;
    uint64_t damaged_bytes;        /* number of damaged bytes before the last valid block */
    uint64_t missing_records;      /* number of records lost because of the damaged bytes */
    uint64_t cut_bytes;            /* number of bytes after the last valid block */
    bool header_damaged;           /* true if one of the two copies of the header is damaged */
} ost_session_summary;

typedef struct ost_session ost_session;

/*
 * Opens a session, and reads and checks every block.  Returns OST_ERR_INPUT if the file
 * is not a session or if both copies of the header are damaged; all other damage is
 * reported in the summary.  A session can be read while it is being written.  Returns
 * OST_ERR_RANGE if ost_session_header_set rejects a key of the header, OST_ERR_IO if the
 * file cannot be opened or read, and OST_ERR_MEMORY if memory is exhausted.  The caller
 * closes *out with ost_session_close.
 */
OST_API ost_status ost_session_open(const char *path, ost_session **out, ost_error *err);
/* Closes a session. NULL is allowed. */
OST_API void ost_session_close(ost_session *session);
/* Returns the header of an open session; valid until the session is closed. */
OST_API const ost_session_header *ost_session_header_of(const ost_session *session);
/* Returns the summary of an open session; valid until the session is closed. */
OST_API const ost_session_summary *ost_session_summary_of(const ost_session *session);
/*
 * Reads the next valid record in the order of the file. Missing records are skipped. After the last record, *more
 * is false. Returns OST_ERR_IO if the file cannot be read, or if it has changed since it was opened.
 */
OST_API ost_status ost_session_next(ost_session *session, ost_record *out, bool *more, ost_error *err);
/* Moves the reader to the start, so that the next call of ost_session_next returns the first record. */
OST_API void ost_session_rewind(ost_session *session);
enum { OST_SESSION_MISSING = 512 };
/* Writes one sentence for each kind of missing data to `text`, or "" if nothing is missing. Returns `text`. */
OST_API const char *ost_session_missing(const ost_session *session, char text[OST_SESSION_MISSING]);

/*
 * Copies the ticks that can be replayed (complete_ticks) to *out, as a path. Returns OST_ERR_INPUT if there are none or
 * more than OST_PATH_TICKS_MAX, OST_ERR_MEMORY if memory is exhausted, and the errors of ost_session_next. Afterwards,
 * the reader is at the start of the session. The caller frees *out with ost_path_free.
 */
OST_API ost_status ost_session_path(ost_session *session, ost_path *out, ost_error *err);
/*
 * Writes all valid blocks to a new session file, which appears only when it is complete. The file of the open session
 * is not changed. Returns OST_ERR_USAGE if the name `out` is empty, OST_ERR_IO if the new file cannot be written,
 * OST_ERR_MEMORY if memory is exhausted, and the errors of ost_session_next. Afterwards, the reader is at the start of
 * the session.
 */
OST_API ost_status ost_session_repair(ost_session *session, const char *out, ost_error *err);
/*
 * Writes a CSV table for other programs, with one line per tick. The columns of a path come first, followed by all
 * other columns (docs/spec/session.md). The errors are those of ost_session_repair. Afterwards, the reader is at the
 * start of the session.
 */
OST_API ost_status ost_session_write_csv(ost_session *session, const char *out, ost_error *err);

/* -------------------------------------------------------------- recording */

/*
 * A recorder: one thread puts records into a ring, and the writer thread of the recorder
 * writes them to the file.  Putting a record is wait-free: it takes no lock, allocates no
 * memory and makes no system call.  If the ring is full, the record is counted as lost.  If
 * the disk is slow or full, the writer thread repeats the write, and ost_recorder_state
 * reports the failure.
 */
typedef struct ost_recorder ost_recorder;

typedef struct ost_recorder_options {
    uint32_t capacity; /* capacity of the ring in records, a power of two; 0 selects 65536 (65 s at 1 kHz, 8 MB) */
    /*
     * If true, the file is not synced. More data may then be lost if the power fails, but not if the process is
     * killed.
     */
    bool no_sync;
} ost_recorder_options;

typedef struct ost_recorder_state {
    uint64_t put, written, lost; /* numbers of records put into the ring, written to the file, and lost */
    uint64_t written_bytes;
    bool failing;                /* true if the last attempt to write failed; the write will be repeated */
    char reason[160];            /* the reason for the failure, if `failing` is true */
} ost_recorder_state;

/*
 * Creates or replaces the file `path`, writes the header and starts the writer thread. options may be NULL. Returns
 * OST_ERR_IO if the file cannot be created or written, is a symbolic link, or is in use by another recorder. Returns
 * OST_ERR_USAGE if the capacity is not a power of two up to 2^24, OST_ERR_RANGE if the header needs more than 512 kB,
 * OST_ERR_UNAVAILABLE if no thread can be created, and OST_ERR_MEMORY if memory is exhausted. The caller frees *out
 * with ost_recorder_close. The header is copied to the file; it need not outlive the call.
 */
OST_API ost_status ost_recorder_open(const char *path, const ost_session_header *header,
                                     const ost_recorder_options *options, ost_recorder **out, ost_error *err);
/*
 * Puts a record into the ring. The function is wait-free. Only one thread may put records. Returns false if the record
 * was lost.
 */
OST_API bool ost_recorder_put(ost_recorder *recorder, const ost_record *record);
/*
 * Waits until the ring has a free slot, and then puts a record into the ring. Intended for callers without a deadline.
 * If the ring remains full and the disk fails for ten seconds, the record is lost and the function returns false.
 */
OST_API bool ost_recorder_put_waiting(ost_recorder *recorder, const ost_record *record);
/* Copies the state of the recorder to *out. May be called on any thread. */
OST_API void ost_recorder_state_get(ost_recorder *recorder, ost_recorder_state *out);
/*
 * Writes the records that are still in the ring, and then the end record. If `end` is NULL, no end record is
 * written, as in a truncated session. Frees the recorder, even after an error. Returns OST_ERR_IO if records could
 * not be written or were lost; the file contains all other records. While the function runs, no other thread may use
 * the recorder. NULL is allowed for recorder.
 */
OST_API ost_status ost_recorder_close(ost_recorder *recorder, const ost_session_end *end, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
