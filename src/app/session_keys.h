/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A session's header, written by the verbs that record and read by those that
 * do it again: which bone and tools, how they were read, what the world was
 * told.  docs/session.md has the keys.
 */
#ifndef OST_APP_SESSION_KEYS_H
#define OST_APP_SESSION_KEYS_H

#include "app/load.h"

#include <osteon/metrics.h>

/* All that a world needs and that is not a voxel. */
typedef struct session_setup {
    const char *bone; /* names: borrowed from whoever gave them, or from the header */
    option_list tools;
    ct_options ct;
    tool_options how;
    bool sweep_off;
    int64_t removal_period_ns;
    ost_density_classes classes;
    const ost_metrics_plan *plan; /* NULL: none is known; session_keys_read leaves it so (app/glenoid_plan.h) */
} session_setup;

/* bone and tools as they are before the first tick; device is "path" or a driver's name. */
ost_status session_keys_make(const session_setup *setup, ost_backend *backend, const ost_bone *bone, ost_tool *const *tools,
                             const char *device, ost_session_header **out, ost_error *err);

/* OST_ERR_INPUT naming session and key when one is missing or cannot be. Texts live as long as header. */
ost_status session_keys_read(const char *session, const ost_session_header *header, session_setup *out, ost_error *err);

/* OST_ERR_INPUT unless these are the bone and the tools that the header names by their digests. */
ost_status session_keys_check(const char *session, const ost_session_header *header, const session_setup *setup, const ost_bone *bone,
                              ost_tool *const *tools, ost_error *err);

#endif
