/* SPDX-License-Identifier: Apache-2.0 */
/* Formats a tick as text, for all functions that write tables of ticks. */
#ifndef OST_IO_PATH_CSV_H
#define OST_IO_PATH_CSV_H

#include <osteon/path.h>

#include "io/outfile.h"

/*
 * Writes a tick as "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz", followed by ",tool" if `tools` is true. Times and lengths are
 * exact decimals; quaternion components have ten decimals. No newline is written.
 */
ost_status ost_path_put_tick(ost_outfile *out, const ost_tick *tick, bool tools, ost_error *err);

#endif
