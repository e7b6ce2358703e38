/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A deviation at work: whether it strikes here, and noting what it did.  A
 * stage takes a deviant, or NULL to be right; what asks it must be right for
 * NULL.
 */
#ifndef OST_VALIDATION_DENSE_DEVIANT_H
#define OST_VALIDATION_DENSE_DEVIANT_H

#include <osteon/grid.h>

#include "validation/dense/deviation.h"

typedef struct deviant {
    deviation how;
    deviation_record record;
    uint64_t calls[DEVIATION_STAGES];
    /* of the call that runs */
    deviation_stage stage;
    uint64_t call;
    ost_dims dims;
    int chunk_size; /* 0 where there are no chunks */
} deviant;

/* A new call of the stage on a grid of these dims. */
void deviant_begin(deviant *m, deviation_stage stage, ost_dims dims, int chunk_size);
/* Back to an earlier call of it. */
void deviant_return(deviant *m, deviation_stage stage, uint64_t call, ost_dims dims, int chunk_size);

/* Whether the mistake is of this kind, and made in this unit of this call. */
bool deviates(const deviant *m, deviation_kind kind, uint64_t item);
/* A mistake may be made in this stage. Where none can be, the stage need not be run without it as well. */
bool deviant_in(const deviant *m, deviation_stage stage);
/* A number drawn for this unit, for what else is left to chance. */
uint64_t deviant_draw(const deviant *m, uint64_t item);
/* The thesis' floats are at work; *fused says whether multiply-adds are. */
bool deviant_thesis(const deviant *m, bool *fused);

/* voxel may be NULL. */
void deviant_acted(deviant *m, uint64_t item, const int32_t voxel[3]);
void deviant_changed_voxel(deviant *m, const int32_t voxel[3]);
/* chunk is -1 when it is not that of one chunk. */
void deviant_changed_report(deviant *m, int64_t chunk);

#endif
