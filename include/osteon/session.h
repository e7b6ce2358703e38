/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sessions: everything that went into a world, tick by tick, and what came of
 * it, in a file that is written while it happens (docs/session.md).
 *
 *   tick --put--> ring --> writer thread --> blocks, appended --> SESSION
 *                                                                    |
 *   the same ticks, on any backend  <------- ost_session_next <------'
 *
 * A session holds inputs, not voxels: bone and tools are named by their
 * digests, and the same ticks through ost_world_step give the same grids.
 * Each tick carries a digest of what its step did, so that a replay knows the
 * first tick that went another way.
 *
 * The file is only ever appended to.  A killed process or a power cut loses
 * the last 100 ms at most; damage anywhere loses the block it hits, and the
 * reader says which ticks are missing.
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
 * What a session says of itself: keys [a-z0-9_.]{1,40} and values of any
 * bytes but NUL up to OST_SESSION_VALUE, in the order in which they were set.  docs/session.md
 * lists the keys with a meaning.
 */
enum { OST_SESSION_KEY = 41, OST_SESSION_VALUE = 4096, OST_SESSION_KEYS_MAX = 128 };
typedef struct ost_session_header ost_session_header;

OST_API ost_status ost_session_header_create(ost_session_header **out, ost_error *err);
OST_API void ost_session_header_free(ost_session_header *header); /* NULL is allowed */
/* Setting a key again replaces its value. OST_ERR_RANGE when key or value breaks the rule, or there are too many. */
OST_API ost_status ost_session_header_set(ost_session_header *header, const char *key, const char *value, ost_error *err);
/* NULL when it is not there; lives until header is changed. */
OST_API const char *ost_session_header_get(const ost_session_header *header, const char *key);
OST_API int ost_session_header_count(const ost_session_header *header);
OST_API void ost_session_header_entry(const ost_session_header *header, int index, const char **key, const char **value);

/* --------------------------------------------------------------- records */

enum {
    OST_TICK_REMOVAL = 1,   /* it ran a removal event */
    OST_TICK_MET = 2,       /* the boxes of bone and tool met */
    OST_TICK_FORCE = 4,     /* the force was given to the device */
    OST_TICK_DECLARED = 8,  /* the device had no new pose: the last one was taken */
    OST_TICK_LIFTED = 16    /* the tool was lifted before this tick (path.h); written from tick.lifted and read into it */
};

typedef struct ost_session_tick {
    uint64_t number; /* from 0; a number that is left out was lost */
    ost_tick tick;   /* what went into the world */
    uint32_t flags, buttons;
    /* What came of it. */
    uint64_t digest;         /* ost_step_digest (sim.h) */
    uint32_t removed, touched; /* voxels; at most 2^32 - 1 is said */
    uint16_t poses;          /* of the sweep */
    uint16_t fault;          /* 0, or why the device gets no force (haptics.h) */
    /* Live only, else zero. */
    int32_t force_un[3];     /* micronewtons, in the bone's frame */
    int32_t torque_unm[3];   /* micronewton metres about the tool's origin */
    uint32_t wake_ns, exec_ns; /* how late the tick began, and how long it took */
    uint32_t missed;         /* ticks that were skipped before this one */
} ost_session_tick;

enum { OST_SESSION_TEXT = 104 };
typedef struct ost_session_note {
    int64_t t_ns;
    char text[OST_SESSION_TEXT]; /* a line; cut when longer */
} ost_session_note;

/* The last record of a session that was ended and not cut off. */
typedef struct ost_session_end {
    uint64_t ticks, removals, removed_voxels; /* as the world counted them */
    bool has_root;
    ost_digest root; /* of the bone then */
} ost_session_end;

typedef enum ost_record_kind { OST_RECORD_TICK = 1, OST_RECORD_NOTE = 2, OST_RECORD_END = 3 } ost_record_kind;

typedef struct ost_record {
    ost_record_kind kind;
    union {
        ost_session_tick tick;
        ost_session_note note;
        ost_session_end end;
    } as;
} ost_record;

/* --------------------------------------------------------------- reading */

/* What is in the file and what is not. */
typedef struct ost_session_summary {
    uint64_t file_bytes, blocks, records, ticks;
    uint64_t first_tick, last_tick; /* numbers; meaningless without ticks */
    int64_t first_t_ns, last_t_ns;
    bool ended;                    /* it has its end record */
    uint64_t whole_ticks;          /* from the first on, before anything is missing: these replay */
    uint64_t lost_records;         /* the recorder had no room for them, as it says itself */
    uint64_t damaged_bytes;        /* in the middle */
    uint64_t missing_records;      /* that damage hit */
    uint64_t cut_bytes;            /* behind the last whole block */
    bool header_damaged;           /* one of the two copies */
} ost_session_summary;

typedef struct ost_session ost_session;

/*
 * Reads and checks every block.  OST_ERR_INPUT when this is no session or both
 * copies of the header are damaged; all other damage is in the summary.  A
 * session that is being written can be read.
 */
OST_API ost_status ost_session_open(const char *path, ost_session **out, ost_error *err);
OST_API void ost_session_close(ost_session *session); /* NULL is allowed */
OST_API const ost_session_header *ost_session_header_of(const ost_session *session);
OST_API const ost_session_summary *ost_session_summary_of(const ost_session *session);
/* The next whole record; *more is false behind the last. Records keep their order; what is missing is left out. */
OST_API ost_status ost_session_next(ost_session *session, ost_record *out, bool *more, ost_error *err);
OST_API void ost_session_rewind(ost_session *session);
/* One sentence for each thing that is missing, into text; "" when nothing is. */
enum { OST_SESSION_MISSING = 512 };
OST_API const char *ost_session_missing(const ost_session *session, char text[OST_SESSION_MISSING]);

/* The ticks that replay (whole_ticks) as a path. */
OST_API ost_status ost_session_path(ost_session *session, ost_path *out, ost_error *err);
/* All whole blocks as a new session, whole under its name or not there; path is not changed. */
OST_API ost_status ost_session_repair(ost_session *session, const char *out, ost_error *err);
/* A table for other programs, a tick a line: the columns of a path, then the rest (docs/session.md). */
OST_API ost_status ost_session_write_csv(ost_session *session, const char *out, ost_error *err);

/* For Foxglove and whatever else reads MCAP: poses, ticks, forces, notes. */
OST_API ost_status ost_session_write_mcap(ost_session *session, const char *out, ost_error *err);
/* Which voxels went, in groups that went together: a session says how many, and a replay which. */
typedef struct ost_session_voxel {
    int32_t at[3];
    uint32_t group; /* ascending */
    int16_t density;
} ost_session_voxel;
typedef struct ost_session_voxels {
    size_t groups, count;
    double *t_s; /* of each group */
    ost_session_voxel *voxels;
} ost_session_voxels;

/* For the tools of volumetric_drilling: its recordings' layout, version 3, without pictures. voxels may be NULL: they are not known. */
OST_API ost_status ost_session_write_hdf5(ost_session *session, const char *out, const ost_session_voxels *voxels, ost_error *err);

/* -------------------------------------------------------------- recording */

/*
 * One thread puts, a thread of the recorder's own writes.  put is wait-free:
 * no lock, no allocation, no call of the system; without room it counts the
 * record as lost and returns false.  A disk that is slow or full is tried
 * again and again meanwhile, and ost_recorder_state says so.
 */
typedef struct ost_recorder ost_recorder;

typedef struct ost_recorder_options {
    uint32_t room;   /* records that wait for the writer; a power of two; 0: 65536, 65 s at 1 kHz, 8 MB */
    bool no_sync;    /* do not ask the disk to write at once: a power cut may lose more, a kill not */
} ost_recorder_options;

typedef struct ost_recorder_state {
    uint64_t put, written, lost; /* records; put does not count the lost ones */
    uint64_t written_bytes;
    bool failing;                /* the last attempt to write failed; it is tried again */
    char reason[160];            /* then: why */
} ost_recorder_state;

/* Creates or replaces path and writes the header. options may be NULL. */
OST_API ost_status ost_recorder_open(const char *path, const ost_session_header *header, const ost_recorder_options *options,
                                     ost_recorder **out, ost_error *err);
/* By the one thread that puts. */
OST_API bool ost_recorder_put(ost_recorder *recorder, const ost_record *record);
/* For work that has time: waits until there is room. False, and lost, when the disk has failed for that long: ten seconds. */
OST_API bool ost_recorder_put_patiently(ost_recorder *recorder, const ost_record *record);
/* From any thread. */
OST_API void ost_recorder_state_get(ost_recorder *recorder, ost_recorder_state *out);
/*
 * Writes what waits, then end (NULL: none, as if cut off), and frees the
 * recorder in any case.  OST_ERR_IO when something could not be written or
 * was lost; the file keeps all that was.
 */
OST_API ost_status ost_recorder_close(ost_recorder *recorder, const ost_session_end *end, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
