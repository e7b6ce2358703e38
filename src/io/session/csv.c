/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a session as a table for spreadsheets, pandas and similar programs. */
#include <inttypes.h>

#include "io/outfile.h"
#include "io/path_csv.h"
#include "io/session/reader.h"

static ost_status put_tick_line(ost_outfile *out, const ost_session_tick *t, ost_error *err)
{
    ost_status status = ost_path_put_tick(out, &t->tick, true, err);
    if (status != OST_OK)
        return status;
    return ost_outfile_printf(
        out, err,
        ",%" PRIu64 ",%d,%d,%u,%u,%u,%016" PRIx64 ",%d,%d,%" PRIu32 ",%u,%" PRId32 ",%" PRId32 ",%" PRId32 ",%" PRId32
        ",%" PRId32 ",%" PRId32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%d,%" PRId32 "\n",
        t->number, (t->flags & OST_TICK_REMOVAL) != 0, (t->flags & OST_TICK_MET) != 0, (unsigned)t->poses,
        (unsigned)t->removed, (unsigned)t->touched, t->digest, (t->flags & OST_TICK_FORCE) != 0,
        (t->flags & OST_TICK_DECLARED) != 0, t->buttons, (unsigned)t->fault, t->force_un[0], t->force_un[1],
        t->force_un[2], t->torque_unm[0], t->torque_unm[1], t->torque_unm[2], t->wake_ns, t->exec_ns, t->missed,
        t->tick.lifted, t->tick.rpm);
}

/* Writes a note as a comment line. Control characters, which could end the line, are replaced by blanks. */
static ost_status put_note(ost_outfile *out, const ost_session_note *note, ost_error *err)
{
    char text[OST_SESSION_TEXT];
    memcpy(text, note->text, sizeof text);
    text[sizeof text - 1] = '\0';
    for (char *p = text; *p; p++)
        if ((unsigned char)*p < 32 || *p == 127)
            *p = ' ';
    return ost_outfile_printf(out, err, "# %" PRId64 " ns: %s\n", note->t_ns, text);
}

ost_status ost_session_write_csv(ost_session *session, const char *path, ost_error *err)
{
    ost_outfile *out;
    ost_status status = ost_outfile_open(path, &out, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_printf(
        out, err,
        "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,tick,removal,met,poses,removed_voxels,touched_voxels,digest,"
        "force_given,declared,buttons,fault,force_x_un,force_y_un,force_z_un,torque_x_unm,torque_y_unm,torque_z_unm,"
        "wake_ns,exec_ns,missed,lifted,rpm\n");
    ost_session_rewind(session);
    for (bool more = true; status == OST_OK;) {
        ost_record record;
        status = ost_session_next(session, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind == OST_RECORD_TICK)
            status = put_tick_line(out, &record.as.tick, err);
        else if (record.kind == OST_RECORD_NOTE)
            status = put_note(out, &record.as.note, err);
    }
    ost_session_rewind(session);
    if (status == OST_OK)
        return ost_outfile_commit(out, err);
    ost_outfile_discard(out);
    return status;
}
