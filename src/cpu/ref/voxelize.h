/* SPDX-License-Identifier: Apache-2.0 */
/* The reference voxelizer (AR-VOX). */
#ifndef OST_CPU_REF_VOXELIZE_H
#define OST_CPU_REF_VOXELIZE_H

#include <osteon/backend.h>

/*
 * Voxelizes the cutting and the noncutting mesh of a tool. If `noncutting` is not NULL, it must be snapped to the same
 * grid as the cutting mesh. `voxels` has capacity for the entire grid. The function writes all voxels and, unless
 * report is NULL, *report.
 */
ost_status ost_ref_voxelize(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, ost_fill_rule rule,
                            ost_voxelize_report *report, uint8_t *voxels, ost_error *err);

#endif
