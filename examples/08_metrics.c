/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Example 08: measures the outcome of an operation from the bone before and after
 * it and from a plan.
 *
 *   08_metrics BEFORE.nrrd AFTER.nrrd DEPTH_MM
 *
 * DEPTH_MM is the planned depth of reaming at the glenoid's centre.
 */
#include <osteon/osteon.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    static ost_metrics metrics; /* contains maps of 81 x 81 cells, which are too large for some stacks */
    ost_error err = {OST_OK, ""};
    ost_volume before, after;
    ost_glenoid glenoid;
    ost_metrics_plan plan;
    ost_pm depth = 0;
    const ost_density_classes classes = ost_density_classes_default();
    const char *threshold;
    ost_status status;

    if (argc != 4) {
        fprintf(stderr, "usage: 08_metrics BEFORE.nrrd AFTER.nrrd DEPTH_MM\n");
        return 2;
    }
    memset(&before, 0, sizeof before);
    memset(&after, 0, sizeof after);
    memset(&plan, 0, sizeof plan);

    status = ost_pm_parse(argv[3], &depth, &err);
    if (!status)
        status = ost_volume_read(argv[1], NULL, &before, NULL, &err);
    if (!status)
        status = ost_volume_read(argv[2], NULL, &after, NULL, &err);
    if (!status)
        status = ost_glenoid_from_meta(&before.meta, &glenoid, &err);
    if (!status) {
        plan.at = glenoid.at;
        memcpy(plan.axis, glenoid.axis, sizeof plan.axis);
        plan.left = glenoid.left;
        plan.depth_mm = ost_pm_to_mm(depth);
        threshold = ost_meta_get(&before.meta, OST_META_THRESHOLD);
        /* NULL, because the motion of the tools is unknown; the metrics that are computed from poses are therefore
           absent */
        status = ost_metrics_make(&before, &after, threshold ? atoi(threshold) : 120, &classes, &plan, NULL, &metrics,
                                  &err);
    }

    if (status)
        fprintf(stderr, "08_metrics: %s\n", err.text);
    else {
        printf("%.3f mm3 removed\n", metrics.removed_mm3);
        for (int c = 0; c < classes.count; c++)
            printf("  %-10s %.3f mm3\n", classes.name[c], metrics.removed_by_class_mm3[c]);
        printf("%.2f mm deep on average, %.2f mm at most\n", metrics.depth_mean_mm, metrics.depth_max_mm);
    }
    ost_volume_free(&after);
    ost_volume_free(&before);
    return ost_status_exit(status);
}
