/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declares the slots `snap` and `steps` of osteon/plugin.h, for a plugin that computes snapping,
 * sweep and map itself.
 */
#ifndef EXAMPLE_STEPS_H
#define EXAMPLE_STEPS_H

#include <osteon/plugin.h>

int32_t example_snap(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry,
                     const ost_plugin_raw_mesh *mesh, ost_plugin_snapped *made, ost_plugin_error *error);
int32_t example_steps(ost_plugin_instance *self, const ost_plugin_steps *in, ost_plugin_error *error);

#endif
