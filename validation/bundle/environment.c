/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/environment.h"

#include <fenv.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "config.h"

#include "core/file.h"
#include "validation/bundle/libraries.h"
#include "validation/bundle/limits.h"

extern char **environ;

#if defined __clang__
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif

/* Searches a file for the first line that begins with `name`, such as "name : value", and copies the value from this
   line. The result is "" if the file or such a line does not exist. */
static ost_status line_of(const char *path, const char *name, char text[], size_t size, ost_error *err)
{
    char line[4096];
    FILE *file;
    bool absent;
    text[0] = '\0';
    ost_status status = ost_file_stream(path, &file, &absent, err);
    if (status != OST_OK)
        return absent ? OST_OK : status;
    while (fgets(line, sizeof line, file)) {
        const size_t length = strlen(name);
        const char *value = strncmp(line, name, length) == 0 ? strpbrk(line + length, ":=") : NULL;
        if (!value)
            continue;
        value += 1 + strspn(value + 1, " \t\"");
        snprintf(text, size, "%.*s", (int)strcspn(value, "\"\n"), value);
        break;
    }
    if (ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot be read", path);
    fclose(file);
    return status;
}

/* Makes a JSON object of the environment variables that affect drivers, compilers or thread pools. */
static json_t *variables(void)
{
    static const char *const steering[] = {"OST", "OMP_",  "GOMP_",    "KMP_",   "POCL_", "OCL_",
                                           "CL_", "CUDA_", "RUSTICL_", "LIBGL_", "MESA_", "EMBREE_",
                                           "LC_", "LANG",  "MALLOC_",  "LD_"};
    json_t *o = json_object();
    for (char **v = environ; *v; v++)
        for (size_t i = 0; i < sizeof steering / sizeof steering[0]; i++)
            if (strncmp(*v, steering[i], strlen(steering[i])) == 0) {
                char name[128];
                const char *value = strchr(*v, '=');
                if (!value || value - *v >= (ptrdiff_t)sizeof name)
                    continue;
                snprintf(name, sizeof name, "%.*s", (int)(value - *v), *v);
                json_t *text = json_string(value + 1);
                json_object_set_new(o, name, text ? text : json_string("(not UTF-8)"));
                break;
            }
    return o;
}

ost_status environment_of(const char *program, json_t **out, ost_error *err)
{
    char model[256], flags[4096], microcode[64], system_name[256], hex[OST_DIGEST_HEX];
    struct utsname u;
    int64_t size;
    ost_status status = libraries_digest(program, hex, &size, err);
    *out = NULL;
    if (status == OST_OK)
        status = line_of("/proc/cpuinfo", "model name", model, sizeof model, err);
    if (status == OST_OK)
        status = line_of("/proc/cpuinfo", "flags", flags, sizeof flags, err);
    if (status == OST_OK)
        status = line_of("/proc/cpuinfo", "microcode", microcode, sizeof microcode, err);
    if (status == OST_OK)
        status = line_of("/etc/os-release", "PRETTY_NAME", system_name, sizeof system_name, err);
    if (status != OST_OK)
        return status;
    uname(&u);
    char host[sizeof u.nodename];
    limits_printable(u.nodename, host, sizeof host);
    *out = json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:s,s:I,s:s,s:s,s:s,s:s,s:s,s:o}", "host", host, "system",
                     system_name, "kernel", u.release, "machine", u.machine, "processor", model, "processor_flags",
                     flags, "microcode", microcode, "libc",
#if defined __GLIBC__
                     "glibc",
#else
                     "",
#endif
                     "cores_online", (json_int_t)sysconf(_SC_NPROCESSORS_ONLN), "compiler", COMPILER, "program_sha256",
                     hex, "program_version", PACKAGE_VERSION, "locale", setlocale(LC_ALL, NULL), "rounding",
                     fegetround() == FE_TONEAREST ? "to nearest" : "not to nearest", "variables", variables());
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for the environment");
}
