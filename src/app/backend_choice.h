/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --backend and --threads to a backend.  The default is "cpu", which chooses
 * instruction set and threads by itself; --threads N is the short form of its
 * option threads=N.  The reference has one thread, which any N allows.
 */
#ifndef OST_APP_BACKEND_CHOICE_H
#define OST_APP_BACKEND_CHOICE_H

#include "app/app.h"

/* Whether --backend names this one, with options or without. */
bool backend_is(const app_state *app, const char *name);

ost_status backend_choose(const app_state *app, ost_backend **out, ost_error *err);

#endif
