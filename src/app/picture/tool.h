/* SPDX-License-Identifier: Apache-2.0 */
/* Adds a tool to a viewer: its voxels and, if the tool was loaded from a mesh, the mesh too. */
#ifndef OST_APP_PICTURE_TOOL_H
#define OST_APP_PICTURE_TOOL_H

#include "app/input/load.h"
#include "render/viewer.h"

/* Adds `tool`, which load_tool must have loaded with the same name and options. */
ost_status picture_add_tool(ost_viewer *viewer, const ost_tool *tool, const char *name, const tool_options *options,
                            ost_error *err);

#endif
