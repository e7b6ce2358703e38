/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The path of a reaming: one or more --path joined in the order given.
 *
 *   --tool peg --path builtin:peg-hole --tool reamer --path builtin:glenoid-ream
 *
 * Path k is moved with tool k (with the only tool, if there is one); a CSV
 * whose ninth column names other tools than 0 is taken at its word.  Each path
 * begins 1 ms after the one before it ended.
 */
#ifndef OST_APP_REAM_PATH_H
#define OST_APP_REAM_PATH_H

#include "app/options.h"

typedef struct target_options {
    ost_pm3 at;
    bool at_given;
    double axis[3];
    bool axis_given;
    int side; /* place in "left|right" */
    bool side_given;
    size_t press_ticks; /* of builtin:glenoid-press; 0: a minute */
} target_options;

/* The built-in paths' target: the options, and for what they leave out the bone's own. */
ost_status target_find(const app_state *app, const target_options *options, const ost_meta *meta, const char *bone, ost_glenoid *out,
                       ost_error *err);

ost_status ream_path_make(const app_state *app, const option_list *paths, const target_options *target, const ost_meta *meta, const char *bone,
                          const ost_tool_geometry *const *tools, int tool_count, ost_path *out, ost_error *err);

/* The period of a rate of removal; 0 without one: every tick removes. */
ost_status ream_period(const app_state *app, const option_decimal *rate, int64_t *period_ns, ost_error *err);

#endif
