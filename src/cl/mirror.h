/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The mirror of a bone, which is a copy of its voxels in host memory. In a tick, the force computation reads single
 * voxels from the mirror.
 *
 *   first read     downloads all slices                                       allocates memory
 *   removal        its report names the chunks that it changed; they are      no transfer
 *                  entered in a list
 *   next read      reads the occupancy of the listed chunks and removes the   one wait for the device
 *                  voxels that the device has removed; then reads voxels
 *
 * A removal only makes voxels inactive, so the occupancy of a chunk (n^3 / 8 bytes) is sufficient, and the densities
 * (2 n^3 bytes) are transferred only once. The mirror is up to date at every read, so the force does not depend on
 * the backend. After an upload of slices, the mirror is freed, and the next read downloads the bone again.
 *
 * sample.c makes, updates and reads the mirror.
 */
#ifndef OST_CL_MIRROR_H
#define OST_CL_MIRROR_H

#include "cl/objects.h"
#include "core/chunk_grid.h"

struct cl_mirror {
    ost_chunk_grid grid;
    int32_t *changed; /* owned; numbers of the chunks that removals have changed since the last update */
    size_t count;
    bool *listed;     /* owned; for each chunk, true if its number is in `changed` */
    uint32_t *words;  /* owned; occupancy words of up to `at_once` chunks */
    size_t at_once;
};

/* Creates the mirror of a bone. The mirror contains no voxels yet. On failure, bone->mirror is NULL. */
ost_status ost_cl_mirror_make(cl_bone *bone, ost_error *err);
/* Frees the mirror of a bone. Does nothing if the bone has no mirror. */
void ost_cl_mirror_free(cl_bone *bone);
/* Returns the host memory of a bone's mirror in bytes; 0 without a mirror. */
int64_t ost_cl_mirror_bytes(const cl_bone *bone);
/* Records that a removal has changed a chunk. The function does nothing if the bone has no mirror. */
void ost_cl_mirror_changed(cl_bone *bone, size_t chunk);

#endif
