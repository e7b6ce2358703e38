/* SPDX-License-Identifier: Apache-2.0 */
/*
 * After an operation: metrics on standard output and in the JSON, and a page
 * with pictures that needs nothing else.
 *
 *   debrief_begin: the bone as it is --> ... the operation ... --> debrief_end: metrics, page
 */
#ifndef OST_APP_DEBRIEF_H
#define OST_APP_DEBRIEF_H

#include "app/app.h"

#include <osteon/metrics.h>

/* Zero-initialise; debrief_free in any case. */
typedef struct debrief {
    ost_volume before;
    ost_metrics_plan plan;
    double *force_n; /* owned; of each tick, as felt; NULL when nobody felt any */
    double *t_s;     /* owned */
    size_t count, room;
} debrief;

/* What was planned: depth_mm at the centre. glenoid is where and which way. */
ost_status debrief_begin(const ost_bone *bone, const ost_glenoid *glenoid, double depth_mm, debrief *out, ost_error *err);
/* A tick's force on the hand, N. */
ost_status debrief_force(debrief *d, double t_s, double n, ost_error *err);
/* file: the page. name: of what was done, for its title. */
ost_status debrief_end(const app_state *app, const debrief *d, const ost_bone *bone, const ost_density_classes *classes, const char *name,
                       const char *file, ost_error *err);
void debrief_free(debrief *d);

/* debrief_html.c */
ost_status debrief_page(const char *file, const char *name, const debrief *d, const ost_volume *after, const ost_density_classes *classes,
                        int threshold, const ost_metrics *m, ost_error *err);

#endif
