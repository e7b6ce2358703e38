/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trace: everything one backend made of a list of cases, in order, as bytes
 * that two backends can be compared by.
 *
 *   case, rect, cubic, chunks, tool 0, tool 1, ..., tick 0, tick 1, ..., final,
 *   case, ...
 *
 * A record is a head of 32 bytes and a body:
 *
 *   head   "OSTR", u32 stage, u32 case, u32 item, u64 body bytes, u64 flags
 *   body   u64 count, count words of 64 bits         what was reported
 *          u64 count, count blocks                   voxels
 *   block  i32 lo[3], i32 dims[3], u32 voxel bytes, u32 0, the voxels, x fastest
 *
 * all little-endian.  item is the tool's number or the tick's.  Which words a
 * stage has is said by trace_word_name, so that a difference can be named.
 *
 * A tick's blocks are the leaves of 32^3 voxels that changed since the last
 * record of the bone; so equal records up to a tick mean equal bones at it.
 * Traces go to files: a backend that crashes leaves what it had made.
 */
#ifndef OST_VALIDATION_TRACE_H
#define OST_VALIDATION_TRACE_H

#include <osteon/digest.h>

typedef enum trace_stage {
    TRACE_CASE,    /* words: the input's SHA-256, so that all are seen to be given the same */
    TRACE_RECT,
    TRACE_CUBIC,
    TRACE_CHUNKS,
    TRACE_SNAP,    /* words: a tool's grid and its meshes' vertices on it (steps_record.h) */
    TRACE_TOOL,
    TRACE_COLLIDE,
    TRACE_STEPS,   /* words: which poses a tick's event has, and the map of each (steps_record.h) */
    TRACE_TICK,
    TRACE_SAMPLE,  /* words: densities of single voxels (even items), a hash of each chunk's occupancy (odd ones) */
    TRACE_UPLOAD,  /* a second bone, uploaded in slices of the first */
    TRACE_FINAL,
    TRACE_FAILED,  /* words: the status; a block of bytes: the line; the case ended there */
    TRACE_END,     /* the list was worked off: paths.h says what it has; before it one of item TRACE_TIMES */
    TRACE_STAGES
} trace_stage;

enum { TRACE_TIMES = 1 }; /* item of an end record whose words are the microseconds of each case of the list */

const char *trace_stage_name(trace_stage stage);
/* How many words a report has before its chunks' lines, the last of them the number of lines; 0: the stage has none. */
size_t trace_report_head(trace_stage stage);
/* "active voxels"; of a chunk's line of so many words (0: not known) "voxels of class 2 in a chunk"; others "report word 7". */
enum { TRACE_WORD = 48 };
const char *trace_word_name(trace_stage stage, size_t word, uint64_t line_words, char text[TRACE_WORD]);

/* ------------------------------------------------------------------ writing */

typedef struct trace_writer trace_writer;

/* path is created or replaced. */
ost_status trace_create(const char *path, trace_writer **out, ost_error *err);
/* Writes what is left and closes; OST_ERR_IO when something was not written. */
ost_status trace_close(trace_writer *w, ost_error *err);

/* A record is begun, given its words, then its blocks, and ended. */
void trace_begin(trace_writer *w, trace_stage stage, uint32_t case_index, uint32_t item);
void trace_word(trace_writer *w, uint64_t value);
/* Room for the block's voxels, to be filled before the next call; NULL when there is no memory. */
void *trace_block(trace_writer *w, const int32_t lo[3], ost_dims dims, uint32_t voxel_bytes);
ost_status trace_end(trace_writer *w, ost_error *err);

/* Of the record that was begun. */
void trace_flags(trace_writer *w, uint64_t flags);

/* ------------------------------------------------------------------ reading */

/*
 * A dump (dump.h) need not have everything: its trace gets the reference's
 * records where it says nothing, marked as such and compared with nothing.
 */
enum { TRACE_STANDS_IN = 1, TRACE_NO_WORDS = 2, TRACE_BOUNDS = 4, TRACE_MADE = 8 }; /* MADE: by the backend itself, not handed to it */

/*
 * The text states no box and no range of chunks (AR-REM-5).  A record with
 * TRACE_BOUNDS has in their words what they must hold: a box (TRACE_STEPS),
 * a range of chunks (TRACE_TICK); compare.c then compares by trace_word_holds.
 */
bool trace_word_is_bound(trace_stage stage, size_t word);
/* words are those of a record: word i of `is` holds that of `least`, or is no bound and equal to it. */
bool trace_word_holds(trace_stage stage, size_t word, const uint8_t *is, const uint8_t *least);

typedef struct trace_block_view {
    int32_t lo[3];
    ost_dims dims;
    uint32_t voxel_bytes;
    const uint8_t *voxels;
} trace_block_view;

typedef struct trace_record {
    trace_stage stage;
    uint32_t case_index, item;
    const uint8_t *body;
    uint64_t body_bytes, flags;
} trace_record;

typedef struct trace {
    const uint8_t *bytes; /* the mapped file */
    size_t size;
    size_t count;
    trace_record *records; /* owned */
    bool whole;            /* ended by TRACE_END and nothing after it */
} trace;

/* A file that ends in the middle of a record is read up to it. */
ost_status trace_open(const char *path, trace *out, ost_error *err);
void trace_free(trace *t);

/* Words of a body; false when it is not well formed. */
bool trace_words(const trace_record *r, uint64_t *count, const uint8_t **words);
uint64_t trace_word_at(const uint8_t *words, uint64_t index);
/* Walks the blocks: *at is 0 at first; false after the last, or where the body is not well formed. */
bool trace_next_block(const trace_record *r, size_t *at, trace_block_view *out);

#endif
