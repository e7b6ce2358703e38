/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon ream`: its arguments, its resources and its functions.
 *
 *   cmd_ream.c   parses the arguments
 *   operate.c    loads the inputs, calls the other parts in order
 *   run.c        executes the ticks, with failover to another backend
 *   record.c     records the operation
 *   report.c     reports the results
 */
#ifndef OST_APP_REAM_REAM_H
#define OST_APP_REAM_REAM_H

#include "app/common/app.h"
#include "app/debrief/debrief.h"
#include "app/input/glenoid_plan.h"
#include "app/input/load.h"
#include "app/input/start_check.h"

typedef struct ream_args {
    const char *bone, *out, *record, *classes_text;
    option_list tools, paths;
    ct_options ct;
    tool_options how;
    glenoid_plan_options plan;
    const char *debrief, *max_gap;
    ost_path_options gaps; /* options for gaps, parsed from max_gap */
    option_decimal rate;
    int64_t period_ns; /* time between two removals, from --rate; 0 means that every tick removes bone */
    int64_t rpm;
    bool rpm_given;
    ost_density_classes classes; /* density classes, parsed from classes_text; if count is 0, the defaults apply */
    int sweep; /* index in "off|on" */
    bool compress, no_failover, strict;
} ream_args;

/* Everything that a run has allocated or opened. ream_free frees it. */
typedef struct ream_job {
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_bone_info before, after;
    ost_digest root;   /* digest of the bone after the last tick */
    ost_tool *tools[OPTION_LIST_MAX];
    ost_path path;
    ream_gaps gaps;
    ost_world *world;
    ost_recorder *recorder; /* open while the operation is recorded, otherwise NULL */
    uint32_t *tick_ns; /* duration of each step in ns */
    double run_ms;
    bool met;          /* true if the tool's box overlapped the bone's box in at least one tick */
    ost_metrics_plan plan;
    bool planned;      /* true if `plan` is valid */
    debrief debrief;   /* the debrief; empty unless --debrief is given */
    start_checked site;
    bool failed_over;  /* true if the requested backend failed and another one continued */
} ream_job;

/* Loads the inputs, executes and reports the operation, and writes its files. */
ost_status ream_operate(const app_state *app, const ream_args *args, ost_error *err);

/* Starts the recording if --record is given. The world must exist. */
ost_status ream_record_begin(const ream_args *args, ream_job *j, ost_error *err);
/* Records a tick. Errors are reported when the recorder is closed. */
ost_status ream_record_tick(ream_job *j, size_t number, const ost_step_result *step, ost_error *err);
void ream_record_note(const ream_job *j, size_t tick, const char *text);
/* Completes the recording and reports the name of its file. */
ost_status ream_record_end(const app_state *app, const ream_args *args, ream_job *j, ost_error *err);

/*
 * Returns true if the device may have caused the failure. If the device did not cause it, the same error would occur on
 * the `cpu` backend.
 */
bool ream_may_fail_over(const app_state *app, const ream_args *args, const ream_job *j, ost_status status);
/*
 * Moves the world to the `cpu` backend after a failure of the device. *err describes the failure. `ticks` is the number
 * of ticks completed so far.
 */
ost_status ream_fail_over(const app_state *app, ream_job *j, size_t ticks, ost_error *err);
/* Executes all ticks. */
ost_status ream_run(const app_state *app, const ream_args *args, ream_job *j, ost_error *err);

/* Reads all data for the report from the backend and then writes the bone, so that a failure of the backend leaves no
   file. */
ost_status ream_take_results(const ream_args *args, ream_job *j, ost_error *err);
/* Prints the results of the run, and adds them to the verb's JSON object. */
ost_status ream_report(const app_state *app, const ream_args *args, ream_job *j, ost_error *err);

#endif
