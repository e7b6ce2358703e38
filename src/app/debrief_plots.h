/* SPDX-License-Identifier: Apache-2.0 */
/* The pictures of a debrief's page: maps and charts as SVG, slices and a view as PNG within it. */
#ifndef OST_APP_DEBRIEF_PLOTS_H
#define OST_APP_DEBRIEF_PLOTS_H

#include "app/debrief.h"
#include "app/html.h"

void debrief_depth_map(html_page *p, const debrief *d, const ost_metrics *m);
/* The face cut across and upward: before, after, planned. */
void debrief_profiles(html_page *p, const debrief *d, const ost_metrics *m);
void debrief_pictures(html_page *p, const debrief *d, const ost_volume *after, int threshold);
/* Bone and force over time. */
void debrief_charts(html_page *p, const debrief *d);

#endif
