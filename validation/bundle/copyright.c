/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/copyright.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/file.h"

enum { LINE = 512, LINES_MAX = 20000 };

/* Debian's short name, without case, and SPDX's identifier. */
static const char *const names[][2] = {
    {"Expat", "MIT"},
    {"MIT", "MIT"},
    {"ISC", "ISC"},
    {"Zlib", "Zlib"},
    {"X11", "X11"},
    {"CC0-1.0", "CC0-1.0"},
    {"CC0", "CC0-1.0"},
    {"BSL-1.0", "BSL-1.0"},
    {"Boost-1.0", "BSL-1.0"},
    {"BSD-2-clause", "BSD-2-Clause"},
    {"BSD-3-clause", "BSD-3-Clause"},
    {"BSD-4-clause", "BSD-4-Clause"},
    {"Apache-2.0", "Apache-2.0"},
    {"MPL-1.1", "MPL-1.1"},
    {"MPL-2.0", "MPL-2.0"},
    {"Artistic-2.0", "Artistic-2.0"},
    {"Python-2.0", "Python-2.0"},
    {"curl", "curl"},
    {"libpng", "Libpng"},
    {"NCSA", "NCSA"},
    {"GPL-1+", "GPL-1.0-or-later"},
    {"GPL-2", "GPL-2.0-only"},
    {"GPL-2.0", "GPL-2.0-only"},
    {"GPL-2+", "GPL-2.0-or-later"},
    {"GPL-2.0+", "GPL-2.0-or-later"},
    {"GPL-3", "GPL-3.0-only"},
    {"GPL-3.0", "GPL-3.0-only"},
    {"GPL-3+", "GPL-3.0-or-later"},
    {"GPL-3.0+", "GPL-3.0-or-later"},
    {"LGPL-2", "LGPL-2.0-only"},
    {"LGPL-2+", "LGPL-2.0-or-later"},
    {"LGPL-2.0+", "LGPL-2.0-or-later"},
    {"LGPL-2.1", "LGPL-2.1-only"},
    {"LGPL-2.1+", "LGPL-2.1-or-later"},
    {"LGPL-3", "LGPL-3.0-only"},
    {"LGPL-3+", "LGPL-3.0-or-later"},
    {"LGPL-3.0+", "LGPL-3.0-or-later"},
};

static const char *identifier_of(const char *name)
{
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (strcasecmp(names[i][0], name) == 0)
            return names[i][1];
    return NULL;
}

void copyright_spdx(const char *debian, char out[COPYRIGHT_LICENCE])
{
    char words[COPYRIGHT_LICENCE], *remainder = NULL;
    size_t used = 0;
    bool operand = true;
    out[0] = '\0';
    if (strlen(debian) >= sizeof words)
        return;
    memcpy(words, debian, strlen(debian) + 1);
    for (char *word = strtok_r(words, " \t", &remainder); word;
         word = strtok_r(NULL, " \t", &remainder), operand = !operand) {
        const char *text = operand                    ? identifier_of(word)
                           : strcmp(word, "and") == 0 ? "AND"
                           : strcmp(word, "or") == 0  ? "OR"
                                                      : NULL;
        const int n = text ? snprintf(out + used, COPYRIGHT_LICENCE - used, "%s%s", used ? " " : "", text) : -1;
        if (n < 0 || used + (size_t)n >= COPYRIGHT_LICENCE) {
            out[0] = '\0';
            return;
        }
        used += (size_t)n;
    }
    if (operand)
        out[0] = '\0';
}

/* Returns the text after "NAME:" if the line has this field, otherwise NULL. */
static const char *field(const char *line, const char *name)
{
    const size_t length = strlen(name);
    return strncasecmp(line, name, length) == 0 && line[length] == ':'
               ? line + length + 1 + strspn(line + length + 1, " \t")
               : NULL;
}

ost_status copyright_of(const char *package, char out[COPYRIGHT_LICENCE], ost_error *err)
{
    char path[300], line[LINE];
    FILE *file;
    bool all = false, known = false, absent;
    out[0] = '\0';
    if (!*package || strchr(package, '/') ||
        snprintf(path, sizeof path, "/usr/share/doc/%s/copyright", package) >= (int)sizeof path)
        return OST_OK;
    ost_status status = ost_file_stream(path, &file, &absent, err);
    if (status != OST_OK)
        return absent ? OST_OK : status;
    for (int i = 0; i < LINES_MAX && fgets(line, sizeof line, file); i++) {
        const char *value;
        line[strcspn(line, "\r\n")] = '\0';
        if (i == 0)
            known = field(line, "Format") && strstr(line, "copyright-format/1.0");
        if (!known)
            break;
        if (!*line)
            all = false;
        if ((value = field(line, "Files")))
            all = strcmp(value, "*") == 0;
        if (all && (value = field(line, "License"))) {
            copyright_spdx(value, out);
            break;
        }
    }
    if (ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot be read", path);
    fclose(file);
    return status;
}
