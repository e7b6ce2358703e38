/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks that the structs shared by host and device have the same layout on both. The sizes on the host are asserted in
 * kernels/shared.h, and a kernel reports the sizes on the device. Each member that is not checked lies between two
 * members that are checked.
 */
#include "cl/cl.h"

#include <stddef.h>

#define ENTRY(type, member) {#type, sizeof(type)}, {#type "." #member, offsetof(type, member)}

static const struct {
    const char *what;
    size_t value;
} expected[] = {
    ENTRY(ost_cl_sample, line),
    ENTRY(ost_cl_scatter, count),
    ENTRY(ost_cl_scatter_report, conflict_had),
    ENTRY(ost_cl_cubic, slab),
    ENTRY(ost_cl_bone, threshold),
    ENTRY(ost_cl_vox, tool_class),
    ENTRY(ost_cl_tiles, pass),
    ENTRY(ost_cl_tool, axis),
    ENTRY(ost_cl_event, border),
    ENTRY(ost_cl_block, entries),
    ENTRY(ost_cl_entry, pose),
    ENTRY(ost_cl_pose, skip),
    ENTRY(ost_cl_block_report, touched),
};

enum { COUNT = sizeof expected / sizeof expected[0], BUFFER_BYTES = 256 };

/* These public structs and constants are copied to the device without conversion, so they must be identical. */
_Static_assert(sizeof(ost_sample) == sizeof(ost_cl_sample) &&
                   offsetof(ost_sample, density) == offsetof(ost_cl_sample, density) &&
                   offsetof(ost_sample, line) == offsetof(ost_cl_sample, line),
               "samples go up as they are");
_Static_assert((int)OST_DUPLICATES_ERROR == (int)OST_CL_DUPLICATES_ERROR &&
                   (int)OST_DUPLICATES_FIRST == (int)OST_CL_DUPLICATES_FIRST &&
                   (int)OST_DUPLICATES_LAST == (int)OST_CL_DUPLICATES_LAST &&
                   (int)OST_DUPLICATES_MAX == (int)OST_CL_DUPLICATES_MAX,
               "rules for duplicates");
_Static_assert((int)OST_RESAMPLE_LINEAR == (int)OST_CL_RESAMPLE_LINEAR &&
                   (int)OST_RESAMPLE_NEAREST == (int)OST_CL_RESAMPLE_NEAREST &&
                   (int)OST_RESAMPLE_THESIS == (int)OST_CL_RESAMPLE_THESIS,
               "rules for resampling");
_Static_assert((int)OST_FILL_WINDING == (int)OST_CL_FILL_WINDING && (int)OST_FILL_PARITY == (int)OST_CL_FILL_PARITY,
               "rules for filling");
_Static_assert(OST_CLASS_MAX == OST_CL_CLASSES, "density classes");

ost_status ost_cl_layout_check(cl_backend *b, ost_error *err)
{
    cl_mem reserved = NULL, out = NULL;
    cl_uint found[COUNT] = {0};
    ost_status status = ost_cl_buffer_zero(b, BUFFER_BYTES, "layout", &reserved, err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, sizeof found, "layout", &out, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_layout, 1, 1, 1, err, OST_CL_ARG(reserved), OST_CL_ARG(out));
    if (status == OST_OK)
        status = ost_cl_read(b, out, 0, sizeof found, found, err);
    for (int i = 0; i < COUNT && status == OST_OK; i++)
        if (found[i] != expected[i].value)
            status = ost_fail(
                err, OST_ERR_UNAVAILABLE,
                "OpenCL device '%.120s' is refused: its compiler lays out %s as %u bytes, the host as %zu",
                b->device.name, expected[i].what, (unsigned)found[i], expected[i].value);
    ost_cl_buffer_free(b, &out);
    ost_cl_buffer_free(b, &reserved);
    return status;
}
