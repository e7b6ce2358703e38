/* SPDX-License-Identifier: Apache-2.0 */
/* The definition of the model of voxel_methods.h, for the source files of the measurements and for tests. */
#ifndef OST_BENCH_VOXEL_MODEL_H
#define OST_BENCH_VOXEL_MODEL_H

#include "bench/voxel_methods.h"
#include "render/points/frame.h"

enum { BENCH_VOXEL_THRESHOLD = 120, BENCH_VOXEL_RADIUS = 38 /* 18 mm in voxels of 0.47 mm */ };

struct bench_voxel_model {
    ost_volume rect, cubic; /* owned */
    ost_surface surface;    /* surface of the cubic grid; owned */
    double radius;          /* radius in voxels of the ball that removes bone */
};

/* Converts a series from nanoseconds to another unit, returns its figures, and frees the series. */
bench_figures bench_voxel_figures(bench_series *series, double unit);

#endif
