/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the files of a bundle. */
#include "validation/bundle/bundle.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "core/file.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"

static ost_status read_file(const char *folder, const char *name, char **bytes, size_t *size, bool *absent,
                            ost_error *err)
{
    ost_file file;
    *bytes = NULL;
    *size = 0;
    ost_status status = folder_open(folder, name, &file, err);
    *absent = file.absent;
    if (status != OST_OK)
        return status;
    status = ost_file_bytes(name, &file, bytes, size, err);
    close(file.fd);
    return status;
}

ost_status bundle_read(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err)
{
    bool absent;
    return read_file(folder, name, bytes, size, &absent, err);
}

ost_status bundle_find(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err)
{
    bool absent = false;
    ost_error why = {0};
    const ost_status status = read_file(folder, name, bytes, size, &absent, &why);
    return status == OST_OK || absent ? OST_OK : ost_fail(err, status, "%s", why.text);
}

ost_status bundle_find_json(const char *folder, const char *name, json_t **out, ost_error *err)
{
    char *bytes, where[2 * BUNDLE_PATH];
    size_t size;
    *out = NULL;
    ost_status status = bundle_find(folder, name, &bytes, &size, err);
    snprintf(where, sizeof where, "%s/%s", folder, name);
    if (status == OST_OK && bytes)
        status = limits_parse(where, bytes, size, out, err);
    free(bytes);
    return status;
}

ost_status bundle_read_json(const char *folder, const char *name, json_t **out, ost_error *err)
{
    const ost_status status = bundle_find_json(folder, name, out, err);
    return status != OST_OK || *out
               ? status
               : ost_fail(err, OST_ERR_INPUT, "%s/%s: is missing; expected a complete bundle", folder, name);
}
