/* SPDX-License-Identifier: Apache-2.0 */
#include "app/replay/session_info.h"

#include "app/input/load.h"
#include "app/common/result.h"
#include "app/common/print.h"

static void put_summary(const app_state *app, const ost_session *session)
{
    const ost_session_summary *s = ost_session_summary_of(session);
    char missing[OST_SESSION_MISSING];
    json_t *o = app->result;
    put_integer(o, "ticks", (int64_t)s->ticks);
    put_integer(o, "replayable_ticks", (int64_t)s->complete_ticks);
    put_real(o, "seconds", s->ticks ? (double)(s->last_t_ns - s->first_t_ns) * 1e-9 : 0);
    put_bool(o, "ended", s->ended);
    put_integer(o, "records", (int64_t)s->records);
    put_integer(o, "lost_records", (int64_t)s->lost_records);
    put_integer(o, "missing_records", (int64_t)s->missing_records);
    put_integer(o, "damaged_bytes", (int64_t)s->damaged_bytes);
    put_integer(o, "cut_bytes", (int64_t)s->cut_bytes);
    put_text(o, "missing", ost_session_missing(session, missing));
}

static void put_header(const app_state *app, const ost_session_header *header)
{
    json_t *keys = json_object();
    for (int i = 0; i < ost_session_header_count(header); i++) {
        const char *key, *value;
        ost_session_header_entry(header, i, &key, &value);
        put_text(keys, key, value);
        print_line(app, "  %s: %s", key, value);
    }
    put(app->result, "header", keys);
}

ost_status info_session(const app_state *app, const char *name, const char *repaired, ost_error *err)
{
    ost_session *session;
    ost_status status = load_session(app, name, &session, err);
    if (status != OST_OK)
        return status;
    const ost_session_summary *s = ost_session_summary_of(session);
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    put_text(app->result, "kind", "session");
    const char *format = ost_session_header_get(ost_session_header_of(session), "format");
    put_text(app->result, "format", format ? format : "osteon session");
    put(app->result, "dims", json_pack("[I]", (json_int_t)s->ticks));
    print_line(app, "%s: a session of %s ticks in %.3f s, %s", name, format_count(a, (int64_t)s->ticks),
               s->ticks ? (double)(s->last_t_ns - s->first_t_ns) * 1e-9 : 0.0, format_bytes(b, (int64_t)s->file_bytes));
    put_summary(app, session);
    put_header(app, ost_session_header_of(session));
    if (repaired) {
        status = ost_session_repair(session, repaired, err);
        if (status == OST_OK) {
            put_text(app->result, "repaired", repaired);
            print_line(app, "%s: the undamaged part, %s records", repaired, format_count(a, (int64_t)s->records));
        }
    }
    ost_session_close(session);
    return status;
}

ost_status export_session(const app_state *app, const char *name, const char *out, ost_error *err)
{
    ost_session *session;
    ost_status status = load_session(app, name, &session, err);
    if (status != OST_OK)
        return status;
    char a[FORMAT_TEXT];
    put_text(app->result, "in", name);
    put_text(app->result, "out", out);
    put_summary(app, session);
    status = ost_session_write_csv(session, out, err);
    if (status == OST_OK)
        print_line(app, "%s: a table of %s ticks", out,
                   format_count(a, (int64_t)ost_session_summary_of(session)->ticks));
    ost_session_close(session);
    return status;
}
