/* SPDX-License-Identifier: Apache-2.0 */
/* The model of voxel_methods.h, shared by the files that measure it. */
#ifndef OST_BENCH_VOXEL_MODEL_H
#define OST_BENCH_VOXEL_MODEL_H

#include "bench/voxel_methods.h"
#include "render/points/frame.h"

enum { BENCH_VOXEL_THRESHOLD = 120, BENCH_VOXEL_RADIUS = 38 /* voxels: 18 mm at 0.47 mm */ };

struct bench_voxel_model {
    ost_volume rect, cubic; /* owned */
    ost_surface surface;    /* of the cubic grid; owned */
    double radius;          /* of the ball that removes bone, in voxels */
};

/* Returns the figures of a series of nanoseconds in another unit, and frees the series. */
bench_figures bench_voxel_figures(bench_series *series, double unit);

#endif
