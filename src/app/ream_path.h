/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The path of a reaming: one or more --path joined in the order given.
 *
 *   --tool peg --path builtin:peg-hole --tool reamer --path builtin:glenoid-ream
 *
 * Path k moves tool k (the only tool, if there is one); a file whose ticks name
 * other tools than 0 moves those.  Each path begins 1 ms after the one before it
 * ended, lifted (docs/arithmetic.md, AR-PATH-6).
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

/*
 * Finds the glenoid: by the options, and by the bone's header where they are
 * not given; the side also by the axis.  OST_ERR_USAGE when something is not
 * set, OST_ERR_INPUT when the side, the axis and the header contradict each other.
 */
ost_status target_find(const app_state *app, const target_options *options, const ost_meta *meta, const char *bone, ost_glenoid *out,
                       ost_error *err);

/* The side as stated by --side or else by the header, which must not contradict each other. */
ost_status target_side(const target_options *options, const ost_meta *meta, const char *bone, ost_side *out, ost_error *err);

/* How often the paths lift a tool on their way, and their rows without a pose. */
typedef struct ream_gaps {
    size_t gaps, lost_rows;
} ream_gaps;

#define MAX_GAP_OPTION(text)                                                                            \
    {.name = "max-gap", .kind = OPTION_TEXT, .out = &(text), .value = "MS[,MM]",                        \
     .help = "rows of a path farther apart than this are a gap, across which nothing is\ncut; off: none " \
             "(default: 50 ms and 5 mm, or 10 times what is usual in the path)"}

/* Reads what --max-gap says; text may be NULL. */
ost_status ream_max_gap(const app_state *app, const char *text, ost_path_options *out, ost_error *err);
void ream_say_gaps(const app_state *app, const ream_gaps *gaps);

ost_status ream_path_make(const app_state *app, const option_list *paths, const target_options *target, const ost_meta *meta, const char *bone,
                          const ost_tool_geometry *const *tools, int tool_count, const ost_path_options *gaps, ost_path *out, ream_gaps *counted,
                          ost_error *err);

/* The period of a rate of removal; 0 without one: every tick removes. */
ost_status ream_period(const app_state *app, const option_decimal *rate, int64_t *period_ns, ost_error *err);

#endif
