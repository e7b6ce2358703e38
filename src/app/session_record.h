/* SPDX-License-Identifier: Apache-2.0 */
/* A recording begins: by osteon ream, and by osteon sim. */
#ifndef OST_APP_SESSION_RECORD_H
#define OST_APP_SESSION_RECORD_H

#include "app/session_keys.h"

typedef struct session_key {
    const char *key, *value;
} session_key;

/*
 * Opens name with the header of setup and device, and the keys more, up to
 * one that is NULL.  To be called when the first tick is next: a mistake
 * before leaves an old session of that name as it was.  more and options may
 * be NULL.
 */
ost_status session_record(const char *name, const session_setup *setup, ost_backend *backend, const ost_bone *bone, ost_tool *const *tools,
                          const char *device, const session_key *more, const ost_recorder_options *options, ost_recorder **out, ost_error *err);

#endif
