/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes and reads a session's header: the bone and the tools, the options with which they were loaded, and the
 * options of the world. Verbs that record write the header, and verbs that replay read it. docs/spec/session.md
 * describes the keys.
 */
#ifndef OST_APP_SESSION_KEYS_H
#define OST_APP_SESSION_KEYS_H

#include "app/input/load.h"

#include <osteon/metrics.h>

/* Everything that a session's header states about its world. The header does not contain the voxels. */
typedef struct session_setup {
    const char *bone; /* name of the bone; the strings of this struct are borrowed from the caller or from the header */
    option_list tools;
    ct_options ct;
    tool_options how;
    bool sweep_off;
    int64_t removal_period_ns;
    ost_density_classes classes;
    const ost_metrics_plan *plan; /* NULL if there is no plan; session_keys_read does not set it */
} session_setup;

/*
 * Makes a header. Must be called before the first tick, because the header contains digests of `bone` and `tools`.
 * `device` is "path" or the name of a driver.
 */
ost_status session_keys_make(const session_setup *setup, ost_backend *backend, const ost_bone *bone,
                             ost_tool *const *tools, const char *device, ost_session_header **out, ost_error *err);

/*
 * Reads a header. If a key is missing or invalid, returns OST_ERR_INPUT with a message that names the session and the
 * key. The strings in *out are valid as long as `header` exists.
 */
ost_status session_keys_read(const char *session, const ost_session_header *header, session_setup *out, ost_error *err);

/*
 * Compares the digests of the bone and the tools with those in the header. Returns OST_ERR_INPUT if one of them
 * differs.
 */
ost_status session_keys_check(const char *session, const ost_session_header *header, const session_setup *setup,
                              const ost_bone *bone, ost_tool *const *tools, ost_error *err);

#endif
