/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The backend for external implementations: include/osteon/plugin.h on the
 * host's side.
 *
 *   plugin:FILE.so,options --load.c--> table --adapt.c--> ost_backend_ops
 *
 * No result of a plugin is used unchecked: statuses, objects and reports are
 * checked here, so that an error in a plugin gives a message and not a wrong
 * result later.
 */
#ifndef OST_PLUGIN_PLUGIN_H
#define OST_PLUGIN_PLUGIN_H

#include <osteon/plugin.h>

#include "core/backend.h"

enum { PLUGIN_NAME = 64 };

/* Loads `file` and copies its table; in the copy no mandatory slot is NULL. The file stays loaded. */
ost_status ost_plugin_load(const char *file, ost_plugin *table, char name[PLUGIN_NAME], ost_error *err);

#endif
