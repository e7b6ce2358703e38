/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tool of the CPU backend: one bit per voxel and class, and tables that are derived from
 * these bits at the first event with a bone (cpu/remove/shape.h).
 */
#ifndef OST_CPU_TOOL_H
#define OST_CPU_TOOL_H

#include "core/backend.h"
#include "cpu/remove/shape.h"

typedef struct cpu_shapes {
    /*
     * The tables of class 1 (`cutting`) and of class 2 (`touching`). `touching` is computed only if the tool has voxels
     * of class 2.
     */
    ost_shape cutting, touching;
} cpu_shapes;

typedef struct cpu_tool {
    ost_tool base;
    /*
     * Owned bits of the voxels of class 1 (`cutting`) and of class 2 (`noncutting`). A row has ost_vox_words words, and
     * rows are ordered by (z, y). The bits after a row's last voxel are 0. `noncutting` is NULL if the tool has no
     * voxel of class 2.
     */
    uint64_t *cutting, *noncutting;
    /* owned tables for the size of bone voxels in the last call of ost_cpu_tool_prepare */
    cpu_shapes *shapes;
} cpu_tool;

/*
 * Creates a tool whose bits are not initialised. The caller must write all words of `cutting` and, if `both` is true,
 * of `noncutting`; otherwise `noncutting` is NULL.
 */
ost_status ost_cpu_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, bool both, cpu_tool **out,
                               ost_error *err);
ost_status ost_cpu_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
ost_status ost_cpu_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err);
void ost_cpu_tool_free(ost_tool *tool);

/* Computes the tool's tables for bones with this voxel size, unless the tool already has these tables. */
ost_status ost_cpu_tool_prepare(const cpu_tool *tool, ost_pm bone_voxel, ost_error *err);

#endif
