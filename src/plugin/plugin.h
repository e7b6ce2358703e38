/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The backend `plugin`, which calls external implementations: the host's side of the interface include/osteon/plugin.h.
 *
 *   plugin:FILE.so,options --load.c--> table --adapt.c--> ost_backend_ops
 *
 * The backend checks the statuses, objects and reports that a plugin returns, so that an error in a plugin is reported
 * at once and does not cause a wrong result later.
 */
#ifndef OST_PLUGIN_PLUGIN_H
#define OST_PLUGIN_PLUGIN_H

#include <osteon/plugin.h>

#include "core/backend.h"

enum { PLUGIN_NAME = 64 };

/* Loads a plugin's file and copies its function table to *table. On success, no mandatory function of the copy is
   NULL. The file remains loaded. */
ost_status ost_plugin_load(const char *file, ost_plugin *table, char name[PLUGIN_NAME], ost_error *err);

#endif
