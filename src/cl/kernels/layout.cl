/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reports the layout of the structs of shared.h on the device: their sizes and the
 * offsets of selected members.  The host compares these numbers with its own before it
 * uses the device for anything else.
 *
 *   ost_layout(base, out)   one item
 *
 *   base  ulong[32]   never read; only addresses within the buffer are computed
 *   out   uint[26]    in the order of src/cl/layout.c
 */
#define OST_CL_AT(type, member)                                                                                        \
    (uint)((__global const char *)&((__global const type *)base)->member - (__global const char *)base)

__kernel void ost_layout(__global const ulong *base, __global uint *out)
{
    if (get_global_id(0) != 0)
        return;
    out[0] = (uint)sizeof(ost_cl_sample);
    out[1] = OST_CL_AT(ost_cl_sample, line);
    out[2] = (uint)sizeof(ost_cl_scatter);
    out[3] = OST_CL_AT(ost_cl_scatter, count);
    out[4] = (uint)sizeof(ost_cl_scatter_report);
    out[5] = OST_CL_AT(ost_cl_scatter_report, conflict_had);
    out[6] = (uint)sizeof(ost_cl_cubic);
    out[7] = OST_CL_AT(ost_cl_cubic, slab);
    out[8] = (uint)sizeof(ost_cl_bone);
    out[9] = OST_CL_AT(ost_cl_bone, threshold);
    out[10] = (uint)sizeof(ost_cl_vox);
    out[11] = OST_CL_AT(ost_cl_vox, tool_class);
    out[12] = (uint)sizeof(ost_cl_tiles);
    out[13] = OST_CL_AT(ost_cl_tiles, pass);
    out[14] = (uint)sizeof(ost_cl_tool);
    out[15] = OST_CL_AT(ost_cl_tool, axis);
    out[16] = (uint)sizeof(ost_cl_event);
    out[17] = OST_CL_AT(ost_cl_event, border);
    out[18] = (uint)sizeof(ost_cl_block);
    out[19] = OST_CL_AT(ost_cl_block, entries);
    out[20] = (uint)sizeof(ost_cl_entry);
    out[21] = OST_CL_AT(ost_cl_entry, pose);
    out[22] = (uint)sizeof(ost_cl_pose);
    out[23] = OST_CL_AT(ost_cl_pose, skip);
    out[24] = (uint)sizeof(ost_cl_block_report);
    out[25] = OST_CL_AT(ost_cl_block_report, touched);
}
