/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A dump is a folder of files with the grids that another program computed from the cases. The grids are
 * compared like the results of a backend. docs/spec/dumps.md describes the format for the authors of such
 * programs.
 *
 *   DIR/dump.json                 the campaign, and the cases from which the dump was made
 *   DIR/import-0/rect.raw         or .nrrd; cubic, chunks, tool-0, tick-12, final
 *
 *   reference's trace, DIR --dump_trace--> a trace to compare with it
 *   trace --dump_write--> DIR
 *
 * Grids that a dump lacks are not compared. In place of missing grids, the trace of a dump contains the
 * reference's records, which are marked as stand-ins (trace.h). A dump never contains reports.
 */
#ifndef OST_VALIDATION_DUMP_H
#define OST_VALIDATION_DUMP_H

#include "validation/compare.h"
#include "validation/plan.h"

enum { DUMP_NAME = 200 };
typedef struct dump_head {
    plan_tier tier;
    uint64_t seed;
    /* prefix of the identifiers of the cases in the dump (plan_make); "" means all cases */
    char only[PLAN_ID];
    char program[DUMP_NAME];  /* name of the program that made the dump, in one line */
} dump_head;

/* Reads dump.json. Returns OST_ERR_INPUT if it is not valid; the error line names the file and the mistake. */
ost_status dump_read_head(const char *folder, dump_head *out, ost_error *err);

/*
 * Writes the results that a dump contains for the plan's cases [first, end) as a trace file. `ref` is the
 * reference's trace, and `ranges` contains the ranges of the cases in this trace. A case without any file in
 * the dump gets no record. `compared` has p->count elements; compared[i] is set to the number of records of
 * case i that the dump provides.
 */
ost_status dump_trace(const char *folder, const plan *p, int first, int end, const trace *ref,
                      const compare_range *ranges, const char *path, uint64_t *compared, ost_error *err);

/* Writes the grids of a trace as a dump, to a folder that must not exist yet. */
ost_status dump_write(const char *folder, const char *program, const plan *p, const trace *t, ost_error *err);

/* Writes the name of the folder of a case; for the identifier "import/0", this is "import-0". */
void dump_case_folder(const char *id, char name[PLAN_ID]);

#endif
