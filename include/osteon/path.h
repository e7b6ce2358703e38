/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A path: what a tool does over time.  A row is a tick; t strictly increases.
 * Rows carry the index of the tool in use, so that a path may switch tools.
 */
#ifndef OSTEON_PATH_H
#define OSTEON_PATH_H

#include <stdbool.h>

#include <osteon/pose.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_tick {
    int64_t t_ns; /* nanoseconds */
    int32_t tool; /* index into the world's tools */
    ost_pose pose;
    bool lifted;  /* the tool was lifted before this tick: nothing is swept from the tick before (AR-SWEEP-5) */
} ost_tick;

typedef struct ost_path {
    size_t count;
    ost_tick *ticks; /* owned */
} ost_path;

enum { OST_PATH_TICKS_MAX = 100000000 };

/* Uninitialised rows. */
OST_API ost_status ost_path_init(ost_path *path, size_t count, ost_error *err);
OST_API void ost_path_free(ost_path *path);

#ifdef __cplusplus
}
#endif
#endif
