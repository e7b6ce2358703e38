/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/tools.h"

#include <stdio.h>
#include <string.h>

#include "config.h"

#include "core/file.h"
#include "validation/bundle/built.h"
#include "validation/bundle/libraries.h"

/* Converts a string such as "zlib 1.2.13;jansson 2.14;" to a JSON object with a version for each name. */
static json_t *built_with(void)
{
    json_t *o = json_object();
    for (const char *at = BUILT_LIBRARIES; *at;) {
        const size_t all = strcspn(at, ";"), name = strcspn(at, " ");
        char key[64] = "";
        if (name < all && name < sizeof key) {
            memcpy(key, at, name);
            json_object_set_new(o, key, json_stringn(at + name + 1, all - name - 1));
        }
        at += all + (at[all] == ';');
    }
    return o;
}

const char *tools_commit(void)
{
    return BUILT_COMMIT;
}

/* Reads the name of the distribution (the field ID of os-release), which is a part of package URLs. On a system
   without this file, sets `name` to "". */
static ost_status distribution_of(char name[32], ost_error *err)
{
    static const char path[] = "/etc/os-release";
    char line[256];
    FILE *file;
    bool absent;
    name[0] = '\0';
    ost_status status = ost_file_stream(path, &file, &absent, err);
    if (status != OST_OK)
        return absent ? OST_OK : status;
    while (fgets(line, sizeof line, file))
        if (strncmp(line, "ID=", 3) == 0) {
            const char *at = line + 3 + strspn(line + 3, "\"");
            snprintf(name, 32, "%.*s", (int)strspn(at, "abcdefghijklmnopqrstuvwxyz0123456789._-"), at);
        }
    if (ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot be read", path);
    fclose(file);
    return status;
}

ost_status tools_of(const char *program, json_t **out, ost_error *err)
{
    char hex[OST_DIGEST_HEX], distribution[32];
    int64_t size;
    json_t *libraries;
    *out = NULL;
    ost_status status = distribution_of(distribution, err);
    if (status == OST_OK)
        status = libraries_digest(program, hex, &size, err);
    if (status == OST_OK)
        status = libraries_loaded(&libraries, err);
    if (status != OST_OK)
        return status;
    *out = json_pack("{s:{s:s,s:s,s:s,s:s,s:s,s:o},s:{s:s,s:s,s:s,s:I,s:s},s:o}", "build", "commit", BUILT_COMMIT,
                     "source_date", BUILT_DATE, "cc", BUILT_CC, "compiler", BUILT_COMPILER, "cflags", BUILT_CFLAGS,
                     "headers", built_with(), "program", "name", PACKAGE_NAME, "version", PACKAGE_VERSION, "sha256",
                     hex, "size", (json_int_t)size, "distribution", distribution, "libraries", libraries);
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for " TOOLS_FILE);
}
