/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sessions: a file that records the inputs of a world and the results of its steps,
 * tick by tick, while they happen (docs/spec/session.md).
 *
 *   tick --put--> ring --> writer thread --> blocks, appended --> SESSION
 *                                                                    |
 *   the same ticks, on any backend  <------- ost_session_next <------'
 *
 * A session contains inputs, not voxels: bone and tools are identified by their
 * digests, and the same ticks through ost_world_step give the same grids.  Each tick
 * has a digest of the results of its step, so that a replay can find the first tick
 * that differs.
 *
 * The file is only ever appended to.  A killed process or a power cut loses at most
 * the last 100 ms; damage loses the blocks that it affects, and the reader reports
 * which ticks are missing.
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
 * The description of a session: keys [a-z0-9_.]{1,40} and values of any bytes but NUL
 * up to OST_SESSION_VALUE, in the order in which they were set.  docs/spec/session.md lists
 * the keys with a meaning.
 */
enum { OST_SESSION_KEY = 41, OST_SESSION_VALUE = 4096, OST_SESSION_KEYS_MAX = 128 };
typedef struct ost_session_header ost_session_header;

/* Creates an empty header. The caller frees it. */
OST_API ost_status ost_session_header_create(ost_session_header **out, ost_error *err);
/* Frees a header. NULL is allowed. */
OST_API void ost_session_header_free(ost_session_header *header);
/* Sets or replaces a key's value. Returns OST_ERR_RANGE if key or value is not allowed, or there are too many keys. */
OST_API ost_status ost_session_header_set(ost_session_header *header, const char *key, const char *value,
                                          ost_error *err);
/* Returns the value, or NULL if there is none. The pointer is valid until header is changed. */
OST_API const char *ost_session_header_get(const ost_session_header *header, const char *key);
/* Returns the number of keys of a header. */
OST_API int ost_session_header_count(const ost_session_header *header);
/*
 * Returns key and value of an index in the order in which they were set; valid until the header is
 * changed or freed.
 */
OST_API void ost_session_header_entry(const ost_session_header *header, int index, const char **key,
                                      const char **value);

/* --------------------------------------------------------------- records */

enum {
    OST_TICK_REMOVAL = 1,   /* the tick executed a removal event */
    OST_TICK_MET = 2,       /* the boxes of bone and tool intersected */
    OST_TICK_FORCE = 4,     /* the force was written to the device */
    OST_TICK_DECLARED = 8,  /* the device had no new pose; the last one was used */
    OST_TICK_LIFTED = 16    /* the tool was lifted before this tick (path.h); in files only, from and to tick.lifted */
};

typedef struct ost_session_tick {
    uint64_t number; /* from 0; a missing number means a lost tick */
    ost_tick tick;   /* the input of the world */
    uint32_t flags, buttons;
    /* The results. */
    uint64_t digest;         /* ost_step_digest (sim.h) */
    uint32_t removed, touched; /* numbers of voxels, at most 2^32 - 1 each */
    uint16_t poses;          /* number of poses of the sweep */
    uint16_t fault;          /* 0, or the reason why the device gets no force (haptics.h) */
    /* Only in live operation, else zero. */
    int32_t force_un[3];     /* micronewtons, in the bone's frame */
    int32_t torque_unm[3];   /* micronewton metres about the tool's origin */
    uint32_t wake_ns, exec_ns; /* delay with which the tick began, and its duration */
    uint32_t missed;         /* number of ticks that were skipped before this one */
} ost_session_tick;

enum { OST_SESSION_TEXT = 104 };
/* A line of text at a time, for instance a fault. */
typedef struct ost_session_note {
    int64_t t_ns;
    char text[OST_SESSION_TEXT]; /* one line; truncated if longer */
} ost_session_note;

/* The last record of a session that was ended normally and not truncated. */
typedef struct ost_session_end {
    uint64_t ticks, removals, removed_voxels; /* as counted by the world */
    bool has_root;
    ost_digest root; /* the bone's digest at the end */
} ost_session_end;

/* The kind of a record. */
typedef enum ost_record_kind { OST_RECORD_TICK = 1, OST_RECORD_NOTE = 2, OST_RECORD_END = 3 } ost_record_kind;

/* A record of a session; kind selects the member of as. */
typedef struct ost_record {
    ost_record_kind kind;
    union {
        ost_session_tick tick;
        ost_session_note note;
        ost_session_end end;
    } as;
} ost_record;

/* --------------------------------------------------------------- reading */

/* Content of a session file, and what is missing from it. */
typedef struct ost_session_summary {
    uint64_t file_bytes, blocks, records, ticks;
    uint64_t first_tick, last_tick; /* numbers; undefined if there are no ticks */
    int64_t first_t_ns, last_t_ns;
    bool ended;                    /* the end record is present */
    uint64_t complete_ticks;       /* ticks from the first on, before any is missing: these can be replayed */
    /* records for which the recorder's ring had no free slot, as it has recorded itself */
    uint64_t lost_records;
    uint64_t damaged_bytes;        /* damaged bytes before the last valid block */
    uint64_t missing_records;      /* records lost by that damage */
    uint64_t cut_bytes;            /* bytes after the last valid block */
    bool header_damaged;           /* one of the two copies is damaged */
} ost_session_summary;

typedef struct ost_session ost_session;

/*
 * Opens a session, and reads and checks every block.  Returns OST_ERR_INPUT if the file
 * is not a session or both copies of the header are damaged; all other damage is
 * reported in the summary.  A session can be read while it is being written.
 */
OST_API ost_status ost_session_open(const char *path, ost_session **out, ost_error *err);
/* Closes a session. NULL is allowed. */
OST_API void ost_session_close(ost_session *session);
/* Returns the header of an open session; valid until it is closed. */
OST_API const ost_session_header *ost_session_header_of(const ost_session *session);
/* Returns the summary of an open session; valid until it is closed. */
OST_API const ost_session_summary *ost_session_summary_of(const ost_session *session);
/* Reads the next valid record; *more is false after the last. Records are in their order; missing ones are skipped. */
OST_API ost_status ost_session_next(ost_session *session, ost_record *out, bool *more, ost_error *err);
/* Makes ost_session_next return the first tick again. */
OST_API void ost_session_rewind(ost_session *session);
enum { OST_SESSION_MISSING = 512 };
/* Writes one sentence for each kind of missing data into text; "" if nothing is missing. Returns text. */
OST_API const char *ost_session_missing(const ost_session *session, char text[OST_SESSION_MISSING]);

/* Returns the ticks that can be replayed (complete_ticks) as a path. The caller frees it. */
OST_API ost_status ost_session_path(ost_session *session, ost_path *out, ost_error *err);
/* Writes all valid blocks to a new session, which appears complete or not at all; the session's file is not changed. */
OST_API ost_status ost_session_repair(ost_session *session, const char *out, ost_error *err);
/*
 * Writes a table for other programs, one line per tick: the columns of a path, then all others
 * (docs/spec/session.md).
 */
OST_API ost_status ost_session_write_csv(ost_session *session, const char *out, ost_error *err);

/* -------------------------------------------------------------- recording */

/*
 * A recorder: one thread puts records, the recorder's own writer thread writes them.
 * put is wait-free: no lock, no allocation, no system call; if the ring is full, it
 * counts the record as lost and returns false.  If the disk is slow or full, the
 * writer thread repeats the write, and ost_recorder_state reports the failure.
 */
typedef struct ost_recorder ost_recorder;

typedef struct ost_recorder_options {
    uint32_t capacity; /* capacity of the ring in records; a power of two; 0: 65536, which is 65 s at 1 kHz and 8 MB */
    bool no_sync;    /* do not sync: a power cut may lose more data, a kill does not */
} ost_recorder_options;

typedef struct ost_recorder_state {
    uint64_t put, written, lost; /* numbers of records; put does not include the lost ones */
    uint64_t written_bytes;
    bool failing;                /* the last attempt to write failed and will be repeated */
    char reason[160];            /* the reason, if failing */
} ost_recorder_state;

/* Creates or replaces path, writes the header and starts the writer thread. options may be NULL. */
OST_API ost_status ost_recorder_open(const char *path, const ost_session_header *header,
                                     const ost_recorder_options *options, ost_recorder **out, ost_error *err);
/* Puts a record. Called only by the one thread that puts; wait-free. Returns false if the record was lost. */
OST_API bool ost_recorder_put(ost_recorder *recorder, const ost_record *record);
/*
 * Puts a record, and waits until a slot is free; for callers without a deadline. Returns false, and the record is
 * lost, if the ring stays full and the disk fails for ten seconds.
 */
OST_API bool ost_recorder_put_waiting(ost_recorder *recorder, const ost_record *record);
/* Returns the recorder's state. May be called from any thread. */
OST_API void ost_recorder_state_get(ost_recorder *recorder, ost_recorder_state *out);
/*
 * Writes the waiting records and then end (NULL: no end record, as in a truncated
 * session), and frees the recorder in any case.  Returns OST_ERR_IO if records could
 * not be written or were lost; the file contains all others.
 */
OST_API ost_status ost_recorder_close(ost_recorder *recorder, const ost_session_end *end, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
