/* SPDX-License-Identifier: Apache-2.0 */
/* Begins a recording, for `osteon ream` and `osteon sim`. */
#ifndef OST_APP_SESSION_RECORD_H
#define OST_APP_SESSION_RECORD_H

#include "app/session/keys.h"

typedef struct session_key {
    const char *key, *value;
} session_key;

/*
 * Begins a session in the file `name`. Its header contains the keys made from `setup` and `device`, and the keys in
 * `more`, an array that ends with a NULL key. Must be called immediately before the first tick, so that an existing
 * session with this name remains unchanged if an earlier step fails. `more` and `options` may be NULL.
 */
ost_status session_record(const char *name, const session_setup *setup, ost_backend *backend, const ost_bone *bone,
                          ost_tool *const *tools, const char *device, const session_key *more,
                          const ost_recorder_options *options, ost_recorder **out, ost_error *err);

#endif
