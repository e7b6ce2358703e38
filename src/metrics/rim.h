/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_METRICS_RIM_H
#define OST_METRICS_RIM_H

#include <osteon/metrics.h>

/* Computes the fields rim_*, width_* and height_* from the maps in *m. */
void ost_metrics_rim(ost_metrics *m);

#endif
