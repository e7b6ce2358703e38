/* SPDX-License-Identifier: Apache-2.0 */
/* Cuts that separate two bones: balls and half spaces (AR-SEG-3). */
#ifndef OST_SEGMENT_CUT_H
#define OST_SEGMENT_CUT_H

#include <osteon/segment.h>

/* Returns OST_ERR_RANGE if a value in a cut exceeds the ranges given in segment.h. */
ost_status ost_segment_cut_check(const ost_segment_cut *cut, ost_error *err);
/* Clears in[x] for each voxel of row (y, z) whose centre lies in the cut. */
void ost_segment_cut_row(const ost_segment_cut *cut, const ost_geometry *g, int32_t y, int32_t z, bool *in);

#endif
