/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"

enum { TEXT = 400 };

/* Writes the number of results with each verdict, for example "46 equal, 0 differs, ...". */
static void counts_of(const json_t *summary, char text[TEXT])
{
    size_t n = 0;
    for (int v = 0; v < CASE_VERDICTS; v++)
        n += (size_t)snprintf(text + n, TEXT - n, "%s%lld %s", v ? ", " : "",
                              (long long)json_integer_value(json_object_get(json_object_get(summary, "results"),
                                                                            case_verdict_name((case_verdict)v))),
                              case_verdict_name((case_verdict)v));
}

/* Writes the name and the digest of the file in row `row` of the table in folder.c. Sets *there to false if the file is
   absent or if the log need not contain its digest. */
static ost_status bound_file(const char *folder, size_t row, char text[TEXT], bool *there, ost_error *err)
{
    folder_about about;
    ost_digest digest;
    ost_error why = {0};
    ost_file file;
    int64_t size;
    char hex[OST_DIGEST_HEX];
    const char *name = folder_name(row);
    *there = false;
    if (!folder_describe(name, &about) || !about.bound)
        return OST_OK;
    if (folder_open(folder, name, &file, &why) != OST_OK)
        return file.absent ? OST_OK : ost_fail(err, why.status, "%s", why.text);
    close(file.fd);
    const ost_status status = folder_digest(folder, name, &digest, &size, err);
    snprintf(text, TEXT, "%s %s", name, ost_digest_hex(&digest, hex));
    *there = status == OST_OK;
    return status;
}

ost_status log_end(bundle *b, const json_t *summary, ost_error *err)
{
    char text[TEXT];
    counts_of(summary, text);
    ost_status status = bundle_log(b, "results", err, "%s", text);
    for (size_t row = 0; folder_name(row) && status == OST_OK; row++) {
        bool there;
        status = bound_file(bundle_folder(b), row, text, &there, err);
        if (status == OST_OK && there)
            status = bundle_log(b, "file", err, "%s", text);
    }
    return status == OST_OK ? bundle_log(b, "ended", err, "files written") : status;
}

/* ------------------------------------------------------- checking the log */

typedef struct reader {
    char *at;   /* start of the part of the text that has not been read yet */
    int number; /* number of the line that was read last */
    char *time, *action, *detail;
    char last_time[32];
    bundle_problem *problem;
    void *user;
    int *found;
} reader;

static void report(reader *r, const char *format, ...) OST_PRINTF(2, 3);
static void report(reader *r, const char *format, ...)
{
    char text[2 * TEXT], plain[2 * TEXT];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    r->problem(r->user, BUNDLE_DIFFERENT, BUNDLE_LOG, limits_printable(text, plain, sizeof plain));
    ++*r->found;
}

/* Splits the next line into its four fields at its tabs. At the end of the log, or if the line does not have this form,
   reports that an entry with this action is expected and returns false. */
static bool next_line(reader *r, const char *action)
{
    char *stop = strchr(r->at, '\n'), *field[3];
    r->number++;
    if (!*r->at || !stop) {
        report(r, *r->at ? "line %d is cut off; expected an entry '%s'" : "has no line %d; expected an entry '%s'",
               r->number, action);
        return false;
    }
    *stop = '\0';
    /* the fields time, action and detail; the digest of the previous line precedes them */
    for (int i = 0; i < 3; i++) {
        field[i] = strchr(i ? field[i - 1] : r->at, '\t');
        if (!field[i]) {
            report(r, "line %d has fewer than four fields, separated by tabs; expected an entry '%s'", r->number,
                   action);
            return false;
        }
        *field[i]++ = '\0';
    }
    r->time = field[0], r->action = field[1], r->detail = field[2];
    r->at = stop + 1;
    return true;
}

/* Checks that the time has the form 2026-11-22T21:36:00Z and is not before the time of the previous line. */
static void check_time(reader *r)
{
    static const char form[] = "0000-00-00T00:00:00Z";
    bool ok = strlen(r->time) == sizeof form - 1;
    for (size_t i = 0; ok && i < sizeof form - 1; i++)
        ok = form[i] == '0' ? r->time[i] >= '0' && r->time[i] <= '9' : r->time[i] == form[i];
    if (!ok || strcmp(r->time, r->last_time) < 0)
        report(r, "line %d: '%.30s' is no time, or is before that of the line before", r->number, r->time);
    snprintf(r->last_time, sizeof r->last_time, "%.31s", r->time);
}

/* Checks that the next line has this action and this detail. If `detail` is NULL, any detail is accepted. */
static bool expect(reader *r, const char *action, const char *detail)
{
    if (!next_line(r, action))
        return false;
    check_time(r);
    if (strcmp(r->action, action) != 0) {
        report(r, "line %d: is '%.40s'; '%s' is expected", r->number, r->action, action);
        return false;
    }
    if (detail && strcmp(r->detail, detail) != 0)
        report(r, "line %d: '%s' says '%.150s'; the bundle's files give '%.150s'", r->number, action, r->detail,
               detail);
    return true;
}

static ost_status check_lines(reader *r, const char *folder, const json_t *protocol, const json_t *summary,
                              ost_error *err)
{
    char text[TEXT], hex[OST_DIGEST_HEX];
    ost_digest digest;
    int64_t size;
    ost_status status = folder_digest(folder, EVIDENCE_PROTOCOL, &digest, &size, err);
    if (status != OST_OK)
        return status;
    snprintf(text, sizeof text, "osteon %.40s", evidence_text(protocol, "version"));
    bool ok = expect(r, "begun", text) && expect(r, "protocol frozen", ost_digest_hex(&digest, hex));
    if (ok && strstr(r->at, "\tmerged\t"))
        ok = expect(r, "merged", NULL);
    counts_of(summary, text);
    ok = ok && expect(r, "results", text);
    for (size_t row = 0; ok && folder_name(row) && status == OST_OK; row++) {
        bool there;
        status = bound_file(folder, row, text, &there, err);
        if (status == OST_OK && there)
            ok = expect(r, "file", text);
    }
    if (status == OST_OK && ok && expect(r, "ended", "files written") && *r->at)
        report(r, "goes on behind 'ended'");
    return status;
}

ost_status log_check(const char *folder, const json_t *protocol, const json_t *summary, bundle_problem *problem,
                     void *user, int *found, ost_error *err)
{
    char *log;
    size_t size;
    ost_status status = bundle_find(folder, BUNDLE_LOG, &log, &size, err);
    if (status != OST_OK || !log)
        return status;
    reader r = {.at = log, .problem = problem, .user = user, .found = found};
    if (strlen(log) != size)
        report(&r, "has a NUL in it");
    else
        status = check_lines(&r, folder, protocol, summary, err);
    free(log);
    return status;
}
