/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens the backend that --backend and --threads select. The default is the backend "cpu" with the best instruction set
 * and all cores. --threads N is short for the backend option threads=N. The reference accepts any N but always uses one
 * thread.
 */
#ifndef OST_APP_COMMON_BACKEND_CHOICE_H
#define OST_APP_COMMON_BACKEND_CHOICE_H

#include "app/common/app.h"

/* Returns true if the value of --backend selects the backend `name`, whatever its options are. */
bool backend_is(const app_state *app, const char *name);

ost_status backend_choose(const app_state *app, ost_backend **out, ost_error *err);

#endif
