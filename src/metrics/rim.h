/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_RIM_H
#define OST_METRICS_RIM_H

#include <osteon/metrics.h>

/* From the maps that are there into rim_*, width_* and height_*. */
void ost_metrics_rim(ost_metrics *m);

#endif
