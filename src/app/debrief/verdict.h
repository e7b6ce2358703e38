/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares each figure of a debrief with its tolerance and summarizes the results in one line: the grade, the figure
 * that exceeds its tolerance by the largest factor, and the outcome of the operation.
 */
#ifndef OST_APP_DEBRIEF_VERDICT_H
#define OST_APP_DEBRIEF_VERDICT_H

#include "app/debrief/debrief.h"

typedef enum level { GOOD, WATCH, BAD, NONE } level;

/* Names of the grades: "As planned", "Near the plan", "Off the plan", "Far off the plan". */
enum { VERDICT_GRADES = 4 };
extern const char *const verdict_grades[VERDICT_GRADES];

/* limits between the grades, in degrees, mm, mm3 and % (docs/reference/metrics.md) */
enum { AIM_DEG = 2, WATCH_DEG = 5, PLATE_GOOD = 50, PLATE_WATCH = 25 };

enum { REMARKS = 16, REMARK = 160, VERDICT_LINE = 512 };

typedef struct verdict {
    level tilt, version, inclination, depth, entry, over, plate, contact, gap, hole_angle, hole_entry, wall, plunge;
    level worst;
    int grade;      /* grade of the operation, an index in verdict_grades */
    double times;   /* the greatest ratio of a figure to its tolerance */
    int count;
    char remark[REMARKS][REMARK];
    level of[REMARKS];
    char line[VERDICT_LINE]; /* ASCII */
} verdict;

void verdict_make(const debrief *d, const ost_metrics *m, verdict *out);

#endif
