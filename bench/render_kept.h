/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rows render/frame/VIEW/1. They measure the frames of a window while a reamer cuts and the camera
 * does not move. osteon draws only the parts of the frame that changed. The baseline draws the
 * complete frame.
 */
#ifndef OST_BENCH_RENDER_KEPT_H
#define OST_BENCH_RENDER_KEPT_H

#include "bench/bench.h"

#include <osteon/sim.h>

#include "core/isa.h"

/* Returns true if the filter may select a row with a name of the form render/frame/VIEW/1. */
bool bench_kept_wanted(const char *filter);
ost_status bench_kept(const bench_options *options, bench_table *table, const ost_volume *bone,
                      const ost_glenoid *glenoid, int32_t threshold, ost_isa isa, ost_error *err);

#endif
