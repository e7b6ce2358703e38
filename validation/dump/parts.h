/* SPDX-License-Identifier: Apache-2.0 */
/* Names of files and positions of voxels, for reading and writing dumps. This header is included only in
   validation/dump. */
#ifndef OST_VALIDATION_DUMP_PARTS_H
#define OST_VALIDATION_DUMP_PARTS_H

#include "validation/dump/dump.h"

enum { DUMP_PATH = 4096, DUMP_FORMAT = 1 };

ost_status dump_join(char path[DUMP_PATH], const char *folder, const char *name, ost_error *err);
/* Writes the name of a record's file without its extension, such as "rect", "tool-0", "tick-12" or "steps-12". */
void dump_stage_name(const trace_record *r, char name[40]);
/* Returns true if the record of a stage is one complete grid and a dump may contain this grid. The record of a tick,
   in contrast, consists of the changed leaves. */
bool dump_is_grid(trace_stage stage);
/* Returns the index of voxel (x, y, z) in a grid of dims d that is stored with x fastest. */
size_t dump_voxel_index(ost_dims d, int32_t x, int32_t y, int32_t z);
/* Copies a block's voxels into a bone of dims d. Ignores a block that does not lie completely inside the bone. */
void dump_copy_block(const trace_block_view *b, ost_dims d, int16_t *bone);

/*
 * Reads the file of a snap or steps record (steps.c) and writes its words to the writer's current record.
 * If the dump lacks the file or the reference's record has no words, sets *there to false and writes
 * nothing.
 */
ost_status dump_read_steps(const char *folder, const trace_record *ref, trace_writer *w, bool *there, ost_error *err);
/* Writes the file of a snap or steps record. If the record has no words, no file is written. */
ost_status dump_write_steps(const char *folder, const trace_record *record, ost_error *err);

#endif
