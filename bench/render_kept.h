/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rows render/frame/VIEW/1: what a window shows while a reamer cuts and the eye
 * stays where it is, drawn where it changed and, as the baseline, drawn whole.
 */
#ifndef OST_BENCH_RENDER_KEPT_H
#define OST_BENCH_RENDER_KEPT_H

#include "bench/bench.h"

#include <osteon/sim.h>

#include "core/isa.h"

/* Whether the filter may want one of its rows. */
bool bench_kept_wanted(const char *filter);
ost_status bench_kept(const bench_options *options, bench_table *table, const ost_volume *bone, const ost_glenoid *glenoid, int32_t threshold,
                      ost_isa isa, ost_error *err);

#endif
