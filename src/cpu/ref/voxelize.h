/* SPDX-License-Identifier: Apache-2.0 */
/* The reference voxelizer (AR-VOX). voxels has room for all of the grid; everything in it and in report is written. */
#ifndef OST_CPU_REF_VOXELIZE_H
#define OST_CPU_REF_VOXELIZE_H

#include <osteon/backend.h>

/* noncutting may be NULL, else it is on the same grid. report may be NULL. */
ost_status ost_ref_voxelize(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, ost_fill_rule rule,
                            ost_voxelize_report *report, uint8_t *voxels, ost_error *err);

#endif
