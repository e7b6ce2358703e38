/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The state of a deviation in use. These functions determine where the mistake is made and record
 * its effects. A stage takes a deviant, or NULL to compute without a mistake. Code that calls these
 * functions must therefore give correct results if the deviant is NULL.
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
    int chunk_size; /* 0 if there are no chunks */
} deviant;

/* Called when the stage begins to process a grid with these dims; this call of the stage becomes the current call.
   Does nothing if m is NULL. */
void deviant_begin(deviant *m, deviation_stage stage, ost_dims dims, int chunk_size);
/* Makes an earlier call of the stage the current call again. Does nothing if m is NULL. */
void deviant_return(deviant *m, deviation_stage stage, uint64_t call, ost_dims dims, int chunk_size);

/* Returns true if the mistake is of this kind and is made in this unit of the current call. Returns false if m is
   NULL. */
bool deviates(const deviant *m, deviation_kind kind, uint64_t item);
/* Returns true if a mistake can be made in this stage. Returns false if m is NULL. If the result is true, the stage is
   also run without the mistake, to determine what the mistake changed. */
bool deviant_in(const deviant *m, deviation_stage stage);
/* Returns a pseudo-random number that depends on this unit of the current call and serves for further random choices. m
   must not be NULL. */
uint64_t deviant_draw(const deviant *m, uint64_t item);
/* Returns true if the float arithmetic of the thesis is used. *fused receives true if its multiply-adds are fused.
   m may be NULL. */
bool deviant_thesis(const deviant *m, bool *fused);

/* Records that the mistake changed a value inside the algorithm in this unit. voxel may be NULL. */
void deviant_acted(deviant *m, uint64_t item, const int32_t voxel[3]);
/* Records that a voxel of the call's result is not correct. */
void deviant_changed_voxel(deviant *m, const int32_t voxel[3]);
/* Records that the call's report is not correct. chunk is -1 if the difference is not in the line of one chunk. */
void deviant_changed_report(deviant *m, int64_t chunk);

#endif
