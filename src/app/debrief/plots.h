/* SPDX-License-Identifier: Apache-2.0 */
/* Draws the pictures of a debrief's page: maps and charts as SVG, slices and a view as embedded PNG. */
#ifndef OST_APP_DEBRIEF_PLOTS_H
#define OST_APP_DEBRIEF_PLOTS_H

#include "app/debrief/debrief.h"
#include "app/common/html.h"

void debrief_depth_map(html_page *p, const debrief *d, const ost_metrics *m);
/*
 * Draws two profiles through the face, one across and one upward. Each profile shows the surface before the
 * operation, after the operation, and as planned.
 */
void debrief_profiles(html_page *p, const debrief *d, const ost_metrics *m);
void debrief_pictures(html_page *p, const debrief *d, const ost_volume *after, int threshold);
/* Draws charts of the removed bone and of the force over time. */
void debrief_charts(html_page *p, const debrief *d);

#endif
