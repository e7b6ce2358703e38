/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A deviant is the state of a deviation while a backend runs with it. The functions below determine where
 * the mistake is made and record its effects. A stage takes a deviant, or NULL to compute without a
 * mistake. Code that calls these functions must therefore give correct results if the deviant is NULL.
 */
#ifndef OST_VALIDATION_DENSE_DEVIANT_H
#define OST_VALIDATION_DENSE_DEVIANT_H

#include <osteon/grid.h>

#include "validation/dense/deviation.h"

typedef struct deviant {
    deviation how;
    deviation_record record;
    uint64_t calls[DEVIATION_STAGES];
    /* stage of the current call */
    deviation_stage stage;
    uint64_t call;
    ost_dims dims;
    int chunk_size; /* edge length of a chunk in voxels; 0 before there are chunks */
} deviant;

/* Begins the next call of a stage and makes it the current call. The call processes a grid with these dims.
   Does nothing if m is NULL. */
void deviant_begin(deviant *m, deviation_stage stage, ost_dims dims, int chunk_size);
/* Makes an earlier call of the stage the current call again. Does nothing if m is NULL. */
void deviant_return(deviant *m, deviation_stage stage, uint64_t call, ost_dims dims, int chunk_size);

/* Returns true if the deviation is of this kind and its mistake is made in unit `item` of the current call. Returns
   false if m is NULL. */
bool deviates(const deviant *m, deviation_kind kind, uint64_t item);
/* Returns true if a mistake can be made in this stage. The stage then also runs without the mistake, which shows
   what the mistake changed. Returns false if m is NULL. */
bool deviant_in(const deviant *m, deviation_stage stage);
/* Returns a pseudo-random number for further random choices. The number depends on unit `item` of the current call. m
   must not be NULL. */
uint64_t deviant_draw(const deviant *m, uint64_t item);
/* Returns true if the float arithmetic of the thesis is used. Sets *fused to true if the multiply-adds of this
   arithmetic are fused. m may be NULL. */
bool deviant_thesis(const deviant *m, bool *fused);

/* Records that the mistake changed an intermediate value while unit `item` of the stage was computed. `voxel` may
   be NULL. */
void deviant_acted(deviant *m, uint64_t item, const int32_t voxel[3]);
/* Records that the mistake has changed this voxel of the result. */
void deviant_changed_voxel(deviant *m, const int32_t voxel[3]);
/* Records that the report of the current call is not correct. `chunk` is -1 if the difference is not in the line of a
   chunk. */
void deviant_changed_report(deviant *m, int64_t chunk);

#endif
