/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/output_names.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "io/outfile.h"

static bool is_file(const char *path, const struct stat *file)
{
    struct stat st;
    return stat(path, &st) == 0 && st.st_dev == file->st_dev && st.st_ino == file->st_ino;
}

/* Returns true if `value` is a path of the file with the status `file`, or such a path followed by ':' and a suffix. */
static bool names_file(const char *value, const struct stat *file)
{
    char path[4096];
    const char *colon = strrchr(value, ':');
    if (is_file(value, file))
        return true;
    snprintf(path, sizeof path, "%.*s", colon ? (int)(colon - value) : 0, value);
    return colon && is_file(path, file);
}

/* Returns VALUE if the argument has the form --NAME=VALUE, otherwise the complete argument. */
static const char *value_of(const char *word)
{
    const char *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    return equals ? equals + 1 : word;
}

static const char *path_of(const option *o)
{
    const char *path = o->kind == OPTION_OUTPUT ? *(const char **)o->out : NULL;
    return path && !ost_outfile_is_stdout(path) ? path : NULL;
}

ost_status output_names_check(const option *options, int argc, char **argv, ost_error *err)
{
    for (const option *o = options; o->name; o++) {
        struct stat file;
        const char *path = path_of(o);
        if (!path)
            continue;
        const bool regular = stat(path, &file) == 0 && S_ISREG(file.st_mode);
        for (const option *p = options; p < o; p++)
            if (path_of(p) && strcmp(path_of(p), path) == 0 && (regular || stat(path, &file) != 0))
                return ost_fail(err, OST_ERR_USAGE, "--%s and --%s both name %s; pass two files", p->name, o->name,
                                path);
        for (int i = 1; regular && i < argc; i++)
            if (value_of(argv[i]) != path && names_file(value_of(argv[i]), &file))
                return ost_fail(err, OST_ERR_USAGE,
                                "--%s %s: argument '%s' names the same file, which would be lost; pass another file",
                                o->name, path, argv[i]);
    }
    return OST_OK;
}
