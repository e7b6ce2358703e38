/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tool on the CPU backend: the reference's, and the tables that removal
 * derives from its voxels when it first meets a bone (cpu/remove/shape.h).
 */
#ifndef OST_CPU_TOOL_H
#define OST_CPU_TOOL_H

#include "cpu/ref/ref.h"
#include "cpu/remove/shape.h"

typedef struct cpu_shapes {
    ost_shape cutting, touching; /* of classes 1 and 2; touching only if there are such voxels */
    bool touches;                /* whether there are */
} cpu_shapes;

typedef struct cpu_tool {
    ref_tool ref;
    cpu_shapes *shapes; /* owned; tables of the last bone voxel that was asked for */
} cpu_tool;

/* Takes a tool that the reference's functions made; *tool may move. On failure it is freed. */
ost_status ost_cpu_tool_adopt(ost_tool **tool, ost_error *err);
ost_status ost_cpu_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err);
void ost_cpu_tool_free(ost_tool *tool);

/* Makes the tables for bones of this voxel, unless they are there. */
ost_status ost_cpu_tool_prepare(const cpu_tool *tool, ost_pm bone_voxel, ost_error *err);

#endif
