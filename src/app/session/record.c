/* SPDX-License-Identifier: Apache-2.0 */
#include "app/session/record.h"

ost_status session_record(const char *name, const session_setup *setup, ost_backend *backend, const ost_bone *bone,
                          ost_tool *const *tools, const char *device, const session_key *more,
                          const ost_recorder_options *options, ost_recorder **out, ost_error *err)
{
    ost_session_header *header;
    ost_status status = session_keys_make(setup, backend, bone, tools, device, &header, err);
    if (status != OST_OK)
        return status;
    for (; status == OST_OK && more && more->key; more++)
        status = ost_session_header_set(header, more->key, more->value, err);
    if (status == OST_OK)
        status = ost_recorder_open(name, header, options, out, err);
    ost_session_header_free(header);
    return status;
}
