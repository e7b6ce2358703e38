/* SPDX-License-Identifier: Apache-2.0 */
#include <osteon/status.h>

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config.h"

#include "core/printable.h"

static const struct {
    const char *name;
    const char *text;
    int exit_status;
} statuses[] = {
#define OST_STATUS_ROW(name, exit_status, text) {#name, text, exit_status},
    OST_STATUS_LIST(OST_STATUS_ROW)
#undef OST_STATUS_ROW
};

enum { STATUS_COUNT = sizeof statuses / sizeof statuses[0] };

static unsigned known(ost_status status)
{
    return (unsigned)status < STATUS_COUNT ? (unsigned)status : (unsigned)OST_ERR_INTERNAL;
}

const char *ost_status_name(ost_status status)
{
    return statuses[known(status)].name;
}

const char *ost_status_text(ost_status status)
{
    return statuses[known(status)].text;
}

int ost_status_exit(ost_status status)
{
    return statuses[known(status)].exit_status;
}

ost_status ost_fail(ost_error *err, ost_status status, const char *format, ...)
{
    if (err) {
        va_list args;
        va_start(args, format);
        err->status = status;
        vsnprintf(err->text, sizeof err->text, format, args);
        va_end(args);
        ost_make_printable(err->text);
    }
    return status;
}

ost_status ost_fail_context(ost_error *err, const char *format, ...)
{
    if (!err)
        return OST_ERR_INTERNAL;
    char prefix[OST_ERROR_TEXT];
    char remainder[OST_ERROR_TEXT];
    va_list args;
    va_start(args, format);
    vsnprintf(prefix, sizeof prefix, format, args);
    va_end(args);
    ost_make_printable(prefix);
    memcpy(remainder, err->text, sizeof remainder);
    size_t used = strnlen(prefix, sizeof prefix);
    memcpy(err->text, prefix, used);
    snprintf(err->text + used, sizeof err->text - used, ": %s", remainder);
    return err->status;
}

const char *ost_version(void)
{
    return PACKAGE_VERSION;
}

int ost_version_number(void)
{
    return OST_VERSION;
}
