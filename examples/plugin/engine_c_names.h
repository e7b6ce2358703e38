/* SPDX-License-Identifier: Apache-2.0 */
/* Renames the functions of thesis_f32.cl with the macro WAY, so that a C file can include thesis_f32.cl twice. */
#define thesis_floor_multiple WAY(thesis_floor_multiple)
#define thesis_ceil_multiple WAY(thesis_ceil_multiple)
#define thesis_rect_axis WAY(thesis_rect_axis)
#define thesis_index WAY(thesis_index)
#define thesis_layer WAY(thesis_layer)
#define thesis_minimum WAY(thesis_minimum)
#define thesis_cross WAY(thesis_cross)
#define thesis_owned WAY(thesis_owned)
#define thesis_row WAY(thesis_row)
#define thesis_share WAY(thesis_share)
#define thesis_tool_voxel WAY(thesis_tool_voxel)
#define thesis_mark WAY(thesis_mark)
