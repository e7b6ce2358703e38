/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks the setup before an operation begins, and counts the voxels removed on the near side of
 * the face (docs/reference/metrics.md).
 *
 *   start_check  --warnings, or with --strict an error-->  the operation  -->  start_check_end
 */
#ifndef OST_APP_INPUT_START_CHECK_H
#define OST_APP_INPUT_START_CHECK_H

#include "app/common/options.h"

#include <osteon/metrics.h>
#include <osteon/sim.h>

typedef struct start_checked {
    ost_glenoid glenoid;
    bool known;         /* true if the position of the glenoid is known, so that voxels can be counted */
    /*
     * Number of voxels on the near side of the face before the operation; after start_check_end, the number of these
     * voxels that were removed.
     */
    int64_t near_side;
} start_checked;

/*
 * The input of start_check. `tools` has one element for each name. first[i] is the first pose of tool i, or NULL if
 * tool i is not used. `plan` is NULL if there is no plan.
 */
typedef struct start_setup {
    const char *bone_name;
    const ost_bone *bone;
    const ost_metrics_plan *plan;
    const option_list *names;
    ost_tool *const *tools;
    const ost_pose *first[OPTION_LIST_MAX];
    bool strict;
} start_setup;

#define STRICT_OPTION(strict)                                                                                 \
    {.name = "strict", .kind = OPTION_FLAG, .out = &(strict),                                                 \
     .help = "refuse to start if bone lies in front of the glenoid, the axis does not point into bone, or a " \
             "tool overlaps bone at its first pose (default: warn)"}

/* Finds the first pose of each tool of a path. */
void start_poses(const ost_path *path, const ost_pose *first[OPTION_LIST_MAX]);

/* Warns of each problem that is found. If `strict` is set, the first problem is returned as OST_ERR_INPUT. */
ost_status start_check(const app_state *app, const start_setup *setup, start_checked *out, ost_error *err);
/* Counts the voxels that were removed on the near side of the glenoid's face. */
ost_status start_check_end(start_checked *checked, const ost_bone *bone, ost_error *err);
/* Reports near_side_voxels and near_side_mm3. The parameter mm3 is the volume of one voxel. */
void start_check_report(const app_state *app, const start_checked *checked, double mm3);

#endif
