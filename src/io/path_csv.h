/* SPDX-License-Identifier: Apache-2.0 */
/* A tick as text, for everybody who writes a table of them. */
#ifndef OST_IO_PATH_CSV_H
#define OST_IO_PATH_CSV_H

#include <osteon/path.h>

#include "io/outfile.h"

/* "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz", with ",tool" behind it; decimals exact, no newline. */
ost_status ost_path_put_tick(ost_outfile *out, const ost_tick *tick, bool tools, ost_error *err);

#endif
