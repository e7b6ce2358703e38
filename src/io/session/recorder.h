/* SPDX-License-Identifier: Apache-2.0 */
/* For tests: opens a recorder on a sink that the test provides. */
#ifndef OST_IO_SESSION_RECORDER_H
#define OST_IO_SESSION_RECORDER_H

#include "io/session/write.h"

/* Opens a recorder. `name` is used in messages. The caller owns the sink, which must outlive the recorder. */
ost_status ost_recorder_open_sink(const char *name, const session_sink *sink, const ost_session_header *header,
                                  const ost_recorder_options *options, ost_recorder **out, ost_error *err);

#endif
