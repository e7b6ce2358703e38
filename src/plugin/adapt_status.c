/* SPDX-License-Identifier: Apache-2.0 */
/* Converts a plugin's statuses and error messages for the host, and the host's geometries for a plugin. */
#include "plugin/adapt.h"

ost_status ost_adapt_heard(const plugin_backend *b, const char *slot, int32_t status, plugin_error_sink *t, bool *lost,
                           ost_error *err)
{
    static const ost_status statuses[] = {[OST_PLUGIN_OK] = OST_OK,
                                          [OST_PLUGIN_USAGE] = OST_ERR_USAGE,
                                          [OST_PLUGIN_RANGE] = OST_ERR_RANGE,
                                          [OST_PLUGIN_MEMORY] = OST_ERR_MEMORY,
                                          [OST_PLUGIN_UNAVAILABLE] = OST_ERR_UNAVAILABLE,
                                          [OST_PLUGIN_FAILED] = OST_ERR_UNAVAILABLE,
                                          [OST_PLUGIN_LOST] = OST_ERR_UNAVAILABLE};
    t->text[sizeof t->text - 1] = '\0';
    if (status == OST_PLUGIN_OK)
        return OST_OK;
    if (status < 0 || status > OST_PLUGIN_LOST)
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "plugin %s: %s returned %d, which is not a status of the plugin interface", b->name, slot,
                        (int)status);
    if (status == OST_PLUGIN_LOST && lost)
        *lost = true;
    return ost_fail(err, statuses[status], "plugin %s: %s: %s", b->name, slot, t->text[0] ? t->text :
                    "failed without a message");
}

ost_status ost_adapt_no_object(const plugin_backend *b, const char *slot, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: %s returned success but no object", b->name, slot);
}

ost_status ost_adapt_is_lost(const plugin_backend *b, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "plugin %s: an earlier call failed and the object was lost", b->name);
}

ost_plugin_geometry ost_adapt_geometry(const ost_geometry *g)
{
    return (ost_plugin_geometry){.size = sizeof(ost_plugin_geometry),
                                 .dims = {g->dims.x, g->dims.y, g->dims.z},
                                 .spacing_pm = {g->spacing.x, g->spacing.y, g->spacing.z},
                                 .origin_pm = {g->origin.x, g->origin.y, g->origin.z}};
}
