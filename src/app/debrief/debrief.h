/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the debrief after an operation. The metrics are printed on standard output and stored in the JSON object. A
 * self-contained page shows them with pictures.
 *
 *   debrief_begin: copies the bone --> ... the operation ... --> debrief_end: metrics, page
 */
#ifndef OST_APP_DEBRIEF_DEBRIEF_H
#define OST_APP_DEBRIEF_DEBRIEF_H

#include "app/common/app.h"

#include <osteon/metrics.h>

/* A debrief. Zero-initialise the struct before use, and free it with debrief_free, even after an error. */
typedef struct debrief {
    ost_volume before;
    ost_metrics_plan plan;
    ost_metrics_tool tools[OST_WORLD_TOOLS_MAX];
    int tool_count;
    ost_motion *motion; /* owned; one element per tick */
    size_t count, capacity;
    ost_technique technique;
} debrief;

/*
 * Begins a debrief and copies the bone. `tools` is an array of `count` tools; a tick refers to a tool by its index in
 * this array.
 */
ost_status debrief_begin(const ost_bone *bone, const ost_metrics_plan *plan, ost_tool *const *tools, int count,
                         debrief *out, ost_error *err);
/* Adds a tick. The caller must add ticks in ascending order. */
ost_status debrief_tick(debrief *d, const ost_session_tick *tick, ost_error *err);
/* Adds the first `count` ticks of a session. */
ost_status debrief_session(debrief *d, ost_session *session, uint64_t count, ost_error *err);
/*
 * Computes and reports the metrics, and writes the page. `name` is the name of the input, for the page's title.
 * `file` is the file name of the page.
 */
ost_status debrief_end(const app_state *app, debrief *d, const ost_bone *bone, const ost_density_classes *classes,
                       const char *name, const char *file, ost_error *err);
void debrief_free(debrief *d);

/* Writes the page of a debrief (html.c). */
struct verdict;
ost_status debrief_page(const char *file, const char *name, const debrief *d, const ost_volume *after,
                        const ost_density_classes *classes, int threshold, const ost_metrics *m,
                        const struct verdict *v, ost_error *err);

#endif
