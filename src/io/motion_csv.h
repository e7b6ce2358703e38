/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The motion of a tracked body, as trackers write it:
 *
 *   t_s,x_m,y_m,z_m,qw,qx,qy,qz[,...]
 *   0.0035,0.094771,-0.562000,1.223709,0.6,0,-0.8,0
 *   0.0070,0.094771,-0.562000,1.223709,nan,nan,nan,nan      it was not seen
 *
 * Metres and a unit quaternion, w first; what stands behind the eighth column
 * is not read.  Plain, or packed by gzip.
 */
#ifndef OST_IO_MOTION_CSV_H
#define OST_IO_MOTION_CSV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

typedef struct motion_row {
    int64_t t_ns;      /* strictly increasing, within a day of zero */
    double at[3];      /* m, within 100 m */
    double q[4];       /* of length 1; all 0 when the body was not seen */
} motion_row;

typedef struct motion {
    size_t count;      /* at least one row in which the body was seen */
    motion_row *rows;  /* owned */
} motion;

/* Rows of an hour and ten minutes at 1 kHz: 268 MB. */
enum { MOTION_ROWS_MAX = 1 << 22 };

ost_status motion_read_csv(const char *path, motion *out, ost_error *err);
void motion_free(motion *motion);
bool motion_seen(const motion_row *row);

#endif
