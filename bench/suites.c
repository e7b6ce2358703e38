/* SPDX-License-Identifier: Apache-2.0 */
/* The list of suites. */
#include "bench/bench.h"

const bench_suite bench_suites[] = {
    {"removal", bench_removal}, {"tick", bench_tick},         {"transfer", bench_transfer},
    {"parse", bench_parse},     {"voxelize", bench_voxelize}, {"candidates", bench_candidates},
    {"opencl", bench_opencl},   {"render", bench_render},     {"servo", bench_servo},
    {NULL, NULL},
};
