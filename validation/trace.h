/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trace contains all results of one backend for a list of cases, in order. The results are stored as
 * bytes, so that the results of two backends can be compared with memcmp.
 *
 *   case, rect, cubic, resample, chunks, tool 0, tool 1, ..., tick 0, tick 1, ..., final,
 *   case, ...
 *
 * A record is a head of 32 bytes and a body:
 *
 *   head   "OSTR", u32 stage, u32 case, u32 item, u64 body bytes, u64 flags
 *   body   u64 count, count words of 64 bits         the report
 *          u64 count, count blocks                   voxels
 *   block  i32 lo[3], i32 dims[3], u32 voxel bytes, u32 0, the voxels, x fastest
 *
 * All numbers are little-endian.  item is the number of the tool or tick.
 * trace_word_name returns the names of the words, for the description of a
 * difference.
 *
 * A tick's blocks are the leaves of 32^3 voxels that changed since the last record of the bone. Therefore,
 * if all records of two traces up to a tick are equal, the bones at that tick are equal. Traces are files,
 * so that the results of a backend are preserved if it crashes.
 */
#ifndef OST_VALIDATION_TRACE_H
#define OST_VALIDATION_TRACE_H

#include <string.h>

#include <osteon/digest.h>

typedef enum trace_stage {
    TRACE_CASE,    /* words: the input's SHA-256, which proves that all backends got the same input */
    TRACE_RECT,
    TRACE_CUBIC,
    TRACE_RESAMPLE, /* the cubic grid, resampled a second time; no later stage uses the result */
    TRACE_CHUNKS,
    TRACE_SNAP,    /* words: a tool's grid and its meshes' vertices on it (steps_record.h) */
    TRACE_TOOL,
    TRACE_COLLIDE,
    TRACE_STEPS,   /* words: the poses of a tick's event and the map of each pose (steps_record.h) */
    TRACE_TICK,
    TRACE_SAMPLE,  /* words: densities of single voxels (even items) or a hash of each chunk's occupancy (odd items) */
    TRACE_UPLOAD,  /* counts, digest and voxels of a second bone, made by uploading the first bone's slices */
    TRACE_FINAL,
    /* A stage failed and ended the case. The record has one word, the status, and a block with the bytes of the error
       line. */
    TRACE_FAILED,
    /* end of the list; its words are described in paths.h; an end record with item TRACE_TIMES precedes it */
    TRACE_END,
    TRACE_STAGES
} trace_stage;

enum { TRACE_TIMES = 1 }; /* item of the end record whose words are the running times of the cases in microseconds */

const char *trace_stage_name(trace_stage stage);
/* Returns the number of words that precede the lines of the chunks in a report. The last of these words is the number
   of lines. Returns 0 if the stage has no such report. */
size_t trace_report_head(trace_stage stage);
/* Returns the name of a word: for example "active voxels", or "voxels of class 2 in a chunk" for a word in a chunk's
   line, or "report word 7" for a word without a name. line_words is the number of words in a chunk's line, or 0 if
   unknown. The returned string may be in the buffer `text`. */
enum { TRACE_WORD = 48 };
const char *trace_word_name(trace_stage stage, size_t word, uint64_t line_words, char text[TRACE_WORD]);

/* ---------------------------------------------------------- writing a trace */

typedef struct trace_writer trace_writer;

/* Creates or replaces the file `path`. */
ost_status trace_create(const char *path, trace_writer **out, ost_error *err);
/* Writes the remaining bytes and closes the file. Returns OST_ERR_IO if any bytes could not be written. */
ost_status trace_close(trace_writer *w, ost_error *err);

/* These functions write a record. They are called in this order: trace_begin, trace_word for each word, trace_block
   for each block, trace_end. */
void trace_begin(trace_writer *w, trace_stage stage, uint32_t case_index, uint32_t item);
void trace_word(trace_writer *w, uint64_t value);
/* Returns a buffer for the block's voxels; NULL if memory is exhausted. The caller fills the buffer before the next
   call. */
void *trace_block(trace_writer *w, const int32_t lo[3], ost_dims dims, uint32_t voxel_bytes);
ost_status trace_end(trace_writer *w, ost_error *err);

/* Sets the flags of the current record. */
void trace_flags(trace_writer *w, uint64_t flags);

/* ---------------------------------------------------------- reading a trace */

/*
 * The flags of a record:
 *
 *   TRACE_STAND_IN  the record takes the place of missing data and is not compared: a dump (dump.h) may be
 *                   incomplete, and a backend need not implement every function
 *   TRACE_NO_WORDS  the words are copied from the reference, because a dump has no reports
 *   TRACE_BOUNDS    the record contains bounds (trace_word_is_bound)
 *   TRACE_MADE      the backend computed the contents of the record itself instead of receiving them
 */
enum { TRACE_STAND_IN = 1, TRACE_NO_WORDS = 2, TRACE_BOUNDS = 4, TRACE_MADE = 8 };

/*
 * docs/spec/arithmetic.md prescribes no box and no range of chunks (AR-REM-5). In place of the box (TRACE_STEPS) or
 * the range of chunks (TRACE_TICK), a record with TRACE_BOUNDS contains the smallest bounds that a backend must
 * cover. compare.c compares these words by calling trace_word_holds.
 */
bool trace_word_is_bound(trace_stage stage, size_t word);
/* Returns true if the word with this index in `is` covers the bound in `least`. If the word is not a bound, returns
   true if both words are equal. */
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
    const uint8_t *bytes; /* the mapped file; owned */
    size_t size;
    size_t count;
    trace_record *records; /* owned */
    bool complete;         /* true if the last record is TRACE_END and no further bytes follow */
} trace;

/* Maps a trace and builds the index of its records. If the file ends within a record, that record is ignored. */
ost_status trace_open(const char *path, trace *out, ost_error *err);
void trace_free(trace *t);

/* Finds the words of a record's body. Returns false if the body is not well formed. */
bool trace_words(const trace_record *r, uint64_t *count, const uint8_t **words);
static inline uint64_t trace_word_at(const uint8_t *words, uint64_t index)
{
    uint64_t word;
    memcpy(&word, words + 8 * index, sizeof word);
    return word;
}
/* Finds the next block. The caller sets *at to 0 before the first call. Returns false after the last block, or if the
   body is not well formed. */
bool trace_next_block(const trace_record *r, size_t *at, trace_block_view *out);

#endif
