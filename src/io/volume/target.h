/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The destination of a file's voxels: a volume in memory, or functions that receive the voxels slice by slice. With
 * functions, the complete volume need not be in memory.
 */
#ifndef OST_IO_VOLUME_TARGET_H
#define OST_IO_VOLUME_TARGET_H

#include <osteon/grid.h>

typedef struct ost_target {
    ost_volume *volume; /* receives geometry, meta and voxels; if NULL, the functions are called instead */
    /* Called once, before the first slice. */
    ost_status (*begin)(void *user, const ost_geometry *geometry, ost_error *err);
    /* Called once for every slice z of the geometry, in any order. The voxels are valid only during the call. */
    ost_status (*slice)(void *user, int32_t z, const int16_t *voxels, ost_error *err);
    void *user;
} ost_target;

#endif
