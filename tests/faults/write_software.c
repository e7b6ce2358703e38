/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The program write_software writes a bundle's lists of software into the current folder. The program walk (walk.c)
 * runs write_software and makes each allocation of write_software fail in turn. If Jansson cannot allocate memory,
 * write_software exits with an error, as the command osteon does.
 *
 * Exit status: 0 if both files were written, otherwise 2 with a line on standard error.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/software.h"

static ost_status write_file(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    (void)user;
    FILE *to = fopen(name, "wb");
    bool written = to && fwrite(bytes, 1, size, to) == size;
    if (to && fclose(to) != 0)
        written = false;
    return written ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: cannot be written", name);
}

/* Returns a string that is long enough to make the output streams grow several times. */
static const char *long_text(void)
{
    enum { LONG = 20000 };
    static char text[LONG + 1];
    memset(text, 'm', LONG);
    return text;
}

static json_t *library(const char *soname, const char *package, const char *version, bool linked)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:b}", "soname", soname, "file", soname, "sha256", "01", "package",
                     package, "version", version, "maintainer", long_text(), "linked", linked);
}

static json_t *tools(void)
{
    return json_pack("{s:{s:s, s:s, s:s}, s:{s:s, s:s, s:s, s:{s:s}}, s:[o, o]}", /**/
                     "program", "version", "1.0", "sha256", "00", "distribution", "debian", /**/
                     "build", "compiler", "gcc 14", "commit", "0", "source_date", "2026-01-01T00:00:00Z", "headers",
                     "embree", "4.3", /**/
                     "libraries", library("libz.so.1", "zlib1g", "1:1.3", true), library("libnone.so", "", "", false));
}

static void *ending_malloc(size_t size)
{
    void *p = malloc(size);
    if (p)
        return p;
    fputs("osteon: no memory for a JSON object\n", stderr);
    _exit(2);
}

int main(void)
{
    json_set_alloc_funcs(ending_malloc, free);
    ost_error err = {0};
    json_t *input = tools();
    const ost_status status = input ? software_write(input, write_file, NULL, &err)
                                    : ost_fail(&err, OST_ERR_MEMORY, "no memory for the input");
    json_decref(input);
    if (status != OST_OK)
        fprintf(stderr, "osteon: %s\n", err.text);
    return status == OST_OK ? 0 : 2;
}
