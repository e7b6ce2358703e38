/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --backend and --threads to a backend.
 *
 * The default is "cpu".  While the library has no backend of that name the
 * scalar reference stands in for it: the grids are the same to the bit by
 * contract, only the time differs.  As soon as the library lists a "cpu", the
 * stand-in is out of use; `osteon devices` says which it is.
 */
#ifndef OST_APP_BACKEND_CHOICE_H
#define OST_APP_BACKEND_CHOICE_H

#include "app/app.h"

/* Whether "cpu" means the reference in this build. */
bool backend_cpu_stands_in(void);

ost_status backend_choose(const app_state *app, ost_backend **out, ost_error *err);

#endif
