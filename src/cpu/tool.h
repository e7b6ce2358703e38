/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tool of the CPU backend: the reference's tool, and tables that are derived from its
 * voxels at the first event with a bone (cpu/remove/shape.h).
 */
#ifndef OST_CPU_TOOL_H
#define OST_CPU_TOOL_H

#include "cpu/ref/ref.h"
#include "cpu/remove/shape.h"

typedef struct cpu_shapes {
    /*
     * The tables of class 1 (`cutting`) and of class 2 (`touching`). `touching` is computed only if `touches` is true.
     */
    ost_shape cutting, touching;
    bool touches;                /* true if the tool has non-cutting voxels (class 2) */
} cpu_shapes;

typedef struct cpu_tool {
    ref_tool ref;
    /* owned tables for the size of bone voxels in the last call of ost_cpu_tool_prepare; NULL before the first call */
    cpu_shapes *shapes;
} cpu_tool;

/*
 * Converts a tool of the reference into a cpu_tool. The tool is reallocated, so *tool may change. On failure the
 * tool is freed and *tool is NULL.
 */
ost_status ost_cpu_tool_adopt(ost_tool **tool, ost_error *err);
ost_status ost_cpu_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
void ost_cpu_tool_free(ost_tool *tool);

/* Computes the tool's tables for bones with this voxel size, unless the tool already has these tables. */
ost_status ost_cpu_tool_prepare(const cpu_tool *tool, ost_pm bone_voxel, ost_error *err);

#endif
