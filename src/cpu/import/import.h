/* SPDX-License-Identifier: Apache-2.0 */
/* The import's stages on the CPU backend and how many threads they get. */
#ifndef OST_CPU_IMPORT_H
#define OST_CPU_IMPORT_H

#include "cpu/cpu.h"

/* Fewer voxels than this are copied before a second thread has woken up. */
enum { OST_CPU_SERIAL_VOXELS = 1 << 17 };

static inline int ost_cpu_threads(const cpu_backend *backend, int64_t voxels)
{
    return voxels < OST_CPU_SERIAL_VOXELS ? 1 : backend->threads;
}

ost_status ost_cpu_ct_to_rect(ost_grid *rect, const ost_sample *samples, size_t count, int64_t first_line, ost_duplicates duplicates,
                              ost_scatter_report *report, ost_error *err);
ost_status ost_cpu_rect_to_cubic(const ost_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err);

ost_status ost_cpu_cubic_to_chunks(const ost_grid *cubic, int chunk_size, int32_t threshold, ost_bone **out, ost_error *err);

#endif
