/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the cylinder for a peg hole, which is the second tool of the thesis. Its flat ends are at z = 0 and z =
 * length.
 */
#include "phantom/tool_shape.h"

ost_status ost_tool_make_peg(const ost_tool_options *options, ost_mesh *out, ost_error *err)
{
    ost_skin skin;
    ost_status status = ost_skin_init(&skin, out, options->segments, 2, 0, options->length, err);
    if (status != OST_OK)
        return status;
    ost_skin_circle(&skin, options->diameter / 2, 0);
    ost_skin_circle(&skin, options->diameter / 2, options->length);
    return OST_OK;
}
