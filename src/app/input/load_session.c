/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/print.h"
#include "app/input/load.h"

ost_status load_session(const app_state *app, const char *name, ost_session **out, ost_error *err)
{
    char missing[OST_SESSION_MISSING];
    ost_status status = ost_session_open(name, out, err);
    if (status == OST_OK && ost_session_missing(*out, missing)[0])
        warn(app, "%s: %s", name, missing);
    return status;
}

ost_status load_session_path(const app_state *app, const char *name, ost_path *out, ost_error *err)
{
    ost_session *session;
    ost_status status = load_session(app, name, &session, err);
    if (status != OST_OK)
        return status;
    status = ost_session_path(session, out, err);
    ost_session_close(session);
    return status;
}
