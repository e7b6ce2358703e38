/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the reason why the loader reports no platform, for a message to the user.  A
 * loader silently skips drivers that it cannot load.  The functions of this file read
 * the .icd files in the loader's folder and try to load the driver library that each
 * file names.  An .icd file consists of one line with the name of the library.
 */
#include "cl/choice.h"

#include <dirent.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

/* Returns true, and writes the reason, if the driver that this .icd file names cannot be loaded. */
static bool broken(const char *path, const char *file, char *reason, size_t size)
{
    char line[512] = "";
    FILE *f;
    (void)ost_file_stream(path, &f, NULL, NULL);
    if (!f || !fgets(line, sizeof line, f))
        line[0] = 0;
    if (f)
        fclose(f);
    line[strcspn(line, "\r\n")] = 0;
    if (!line[0]) {
        snprintf(reason, size, "the OpenCL driver file %.80s names no library", file);
        return true;
    }
    void *library = dlopen(line, RTLD_LAZY | RTLD_LOCAL);
    if (library) {
        dlclose(library);
        return false;
    }
    const char *why = dlerror();
    snprintf(reason, size, "the OpenCL driver of %.80s cannot be loaded: %.140s", file, why ? why : line);
    return true;
}

void ost_cl_icd_reason(char *reason, size_t size)
{
    const char *given = getenv("OCL_ICD_VENDORS");
    const char *folder = given && given[0] ? given : "/etc/OpenCL/vendors";
    snprintf(reason, size, "the OpenCL loader found no driver in %.100s; install one, e.g. Debian's pocl-opencl-icd",
             folder);
    if (ends_with(folder, ".icd")) {
        broken(folder, folder, reason, size);
        return;
    }
    DIR *dir = opendir(folder);
    if (!dir)
        return;
    for (const struct dirent *entry; (entry = readdir(dir));) {
        char path[1024];
        if (!ends_with(entry->d_name, ".icd") ||
            snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) >= (int)sizeof path)
            continue;
        if (broken(path, entry->d_name, reason, size))
            break;
    }
    closedir(dir);
}
