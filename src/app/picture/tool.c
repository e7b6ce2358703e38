/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/tool.h"

ost_status picture_add_tool(ost_viewer *viewer, const ost_tool *tool, const char *name, const tool_options *options,
                            ost_error *err)
{
    ost_tool_volume volume = {0};
    ost_mesh parts[LOAD_TOOL_PARTS];
    int count = 0;
    ost_status status = ost_tool_download(tool, &volume, err);
    if (status == OST_OK)
        status = ost_viewer_add_tool(viewer, &volume, err);
    ost_tool_volume_free(&volume);
    if (status == OST_OK)
        status = load_tool_parts(name, options, parts, &count, err);
    if (status == OST_OK && count)
        status = ost_viewer_smooth_tool(viewer, parts, count, err);
    for (int i = 0; i < count; i++)
        ost_mesh_free(&parts[i]);
    return status;
}
