/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Dumps: grids that another program made of the cases, as files, compared as
 * if it were a backend.  docs/dumps.md has the format for those who write one.
 *
 *   DIR/dump.json                 which cases, of which campaign
 *   DIR/import-0/rect.raw         or .nrrd; cubic, chunks, tool-0, tick-12, final
 *
 *   reference's trace, DIR --dump_trace--> a trace to compare with it
 *   trace --dump_write--> DIR
 *
 * What a dump does not have is not compared: its trace gets the reference's
 * record there, marked (trace.h).  Reports are never in a dump.
 */
#ifndef OST_VALIDATION_DUMP_H
#define OST_VALIDATION_DUMP_H

#include "validation/compare.h"
#include "validation/plan.h"

enum { DUMP_NAME = 200 };
typedef struct dump_head {
    plan_tier tier;
    uint64_t seed;
    char only[PLAN_ID];       /* "" is all */
    char program[DUMP_NAME];  /* who made it, a line */
} dump_head;

/* OST_ERR_INPUT with the file and what is wrong in it. */
ost_status dump_read_head(const char *folder, dump_head *out, ost_error *err);

/*
 * The dump of the plan's cases [first, end) as a trace file, ref and ranges
 * those of the reference's trace.  A case of which nothing was dumped has no
 * record in it.  compared[i] of p->count: records of case i.
 */
ost_status dump_trace(const char *folder, const plan *p, int first, int end, const trace *ref, const compare_range *ranges, const char *path, uint64_t *compared,
                      ost_error *err);

/* The folder must not exist. */
ost_status dump_write(const char *folder, const char *program, const plan *p, const trace *t, ost_error *err);

/* A case's folder: "import-0". */
void dump_case_folder(const char *id, char name[PLAN_ID]);

#endif
