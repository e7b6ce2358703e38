/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The backend that others implement: include/osteon/plugin.h, seen from the
 * host.
 *
 *   plugin:FILE.so,options --load.c--> table --adapt.c--> ost_backend_ops
 *
 * Nothing a plugin says is believed before it was looked at: statuses, objects
 * and reports are checked here, so that a mistake in a plugin is a line of
 * text and not a riddle further on.
 */
#ifndef OST_PLUGIN_PLUGIN_H
#define OST_PLUGIN_PLUGIN_H

#include <osteon/plugin.h>

#include "core/backend.h"

enum { PLUGIN_NAME = 64 };

/* Loads FILE and copies its table, which then has no NULL slot. The file stays loaded. */
ost_status ost_plugin_load(const char *file, ost_plugin *table, char name[PLUGIN_NAME], ost_error *err);

#endif
