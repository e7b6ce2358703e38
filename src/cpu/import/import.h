/* SPDX-License-Identifier: Apache-2.0 */
/* Declares the slots of the CPU backend that import a CT: from samples to chunks. */
#ifndef OST_CPU_IMPORT_H
#define OST_CPU_IMPORT_H

#include "cpu/cpu.h"

ost_status ost_cpu_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line,
                              ost_duplicates duplicates, ost_scatter_report *report, ost_error *err);
ost_status ost_cpu_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                 ost_error *err);

ost_status ost_cpu_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out,
                                   ost_error *err);

#endif
