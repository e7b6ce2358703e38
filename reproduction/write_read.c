/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the files of a result. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"
#include "reproduction/write.h"
#include "reproduction/write_json.h"

ost_status write_path(char path[WRITE_PATH], const char *folder, const char *name, ost_error *err)
{
    const int n = snprintf(path, WRITE_PATH, "%s/%s", folder, name);
    return n > 0 && n < WRITE_PATH ? OST_OK : ost_fail(err, OST_ERR_RANGE, "%.80s: the path is too long", folder);
}

ost_status write_read(const char *folder, const char *id, result *out, bool *absent, ost_error *err)
{
    enum { JSON_MAX = 1 << 26, PICTURE_MAX = 1 << 27 };
    char path[WRITE_PATH], name[WRITE_NAME];
    char *bytes = NULL;
    size_t size = 0;
    result_init(out, id, "", NULL);
    snprintf(name, sizeof name, "%.55s.json", id);
    ost_status status = write_path(path, folder, name, err);
    if (status == OST_OK)
        status = ost_file_read(path, JSON_MAX, &bytes, &size, absent, err);
    if (status == OST_OK)
        status = write_json_parse(bytes, size, path, out, err);
    free(bytes);
    for (size_t i = 0; i < out->picture_count && status == OST_OK; i++) {
        char *picture = NULL;
        status = write_path(path, folder, out->picture[i].file, err);
        if (status == OST_OK)
            status = ost_file_read(path, PICTURE_MAX, &picture, &out->picture[i].size, NULL, err);
        out->picture[i].bytes = (uint8_t *)picture;
    }
    if (status == OST_OK && strcmp(out->id, id) != 0)
        status = ost_fail(err, OST_ERR_INPUT, "%s: its item is '%s'", name, out->id);
    return status;
}
