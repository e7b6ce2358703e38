/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/devices.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"
#include "core/isa.h"

typedef struct device_visit {
    const subject_list *subjects;
    json_t *list;
} device_visit;

static json_t *facts_of(const char *lines)
{
    json_t *o = json_object();
    while (*lines) {
        const size_t all = strcspn(lines, "\n"), name = strcspn(lines, "=");
        char key[64] = "";
        if (name < all && name < sizeof key) {
            memcpy(key, lines, name);
            json_object_set_new(o, key, json_stringn(lines + name + 1, all - name - 1));
        }
        lines += all + (lines[all] == '\n');
    }
    return o;
}

static void add_device(const ost_device_info *device, void *user)
{
    device_visit *v = user;
    bool compared = false;
    for (int s = 0; s < v->subjects->count; s++)
        compared |= v->subjects->subjects[s].available && strcmp(v->subjects->subjects[s].device, device->spec) == 0;
    json_array_append_new(v->list, json_pack("{s:s,s:s,s:s,s:b,s:s,s:b,s:s,s:o}", "backend", device->spec, "platform",
                                             device->platform, "name", device->name, "usable", device->available,
                                             "reason", device->reason ? device->reason : "", "compared", compared,
                                             "fingerprint", device->available && device->notes ? device->notes : "",
                                             "driver_says", facts_of(device->facts ? device->facts : "")));
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for " DEVICES_FILE);
}

/* Reads the first line of a file. */
static ost_status first_line(const char *path, char line[], int size, ost_error *err)
{
    FILE *file;
    ost_status status = ost_file_stream(path, &file, NULL, err);
    if (status != OST_OK)
        return status;
    if (!fgets(line, size, file))
        line[0] = '\0';
    if (ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot be read", path);
    fclose(file);
    line[strcspn(line, "\r\n")] = '\0';
    return status;
}

/* Lists the OpenCL drivers that the loader uses, in a form such as {"pocl.icd": "libpocl.so.2"}. The libraries
   themselves are listed in tools.json. */
static ost_status drivers(json_t **out, ost_error *err)
{
    const char *given = getenv("OCL_ICD_VENDORS"), *folder = given && *given ? given : "/etc/OpenCL/vendors";
    char *names[64];
    size_t count = 0;
    ost_status status = OST_OK;
    DIR *dir = opendir(folder);
    if (!dir && errno != ENOENT && errno != ENOTDIR)
        status = ost_fail(err, errno == ENOMEM ? OST_ERR_MEMORY : OST_ERR_IO, "%s: %s", folder, strerror(errno));
    for (struct dirent *e; status == OST_OK && dir && (e = readdir(dir)) && count < sizeof names / sizeof names[0];)
        if (strlen(e->d_name) > 4 && strcmp(e->d_name + strlen(e->d_name) - 4, ".icd") == 0) {
            names[count] = strdup(e->d_name);
            if (!names[count])
                status = no_memory(err);
            else
                count++;
        }
    if (dir)
        closedir(dir);
    qsort(names, count, sizeof *names, by_name);
    *out = json_object();
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        char path[1024], line[512];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        status = first_line(path, line, sizeof line, err);
        if (status == OST_OK && json_object_set_new(*out, names[i], json_string(line)) != 0 &&
            json_object_set_new(*out, names[i], json_string("(not UTF-8)")) != 0)
            status = no_memory(err);
    }
    for (size_t i = 0; i < count; i++)
        free(names[i]);
    if (status == OST_OK && !*out)
        status = no_memory(err);
    if (status != OST_OK) {
        json_decref(*out);
        *out = NULL;
    }
    return status;
}

ost_status devices_of(const subject_list *subjects, json_t **out, ost_error *err)
{
    device_visit v = {subjects, json_array()};
    json_t *sets = json_array(), *list = NULL;
    bool has_opencl = false;
    ost_status status = OST_OK;
    *out = NULL;
    for (int i = 0; i < OST_ISA_COUNT; i++)
        if (ost_isa_available((ost_isa)i))
            json_array_append_new(sets, json_string(ost_isa_name((ost_isa)i)));
    for (int s = 0; s < subjects->count; s++)
        has_opencl |= strncmp(subjects->subjects[s].spec, "cl", 2) == 0;
    for (int i = 0; has_opencl && i < ost_backend_count() && status == OST_OK; i++) {
        ost_backend_info info;
        status = ost_backend_describe(i, &info, err);
        if (status == OST_OK && strcmp(info.name, "cl") == 0 && info.available)
            status = ost_backend_devices(i, add_device, &v, err);
    }
    if (status == OST_OK && has_opencl)
        status = drivers(&list, err);
    if (status == OST_OK)
        *out = json_pack("{s:{s:O},s:{s:b,s:s,s:o,s:O}}", "cpu", "instruction_sets", sets, "opencl", "asked_for",
                         has_opencl, "not_compared_because", subjects->opencl ? "" : subjects->no_opencl, "drivers",
                         has_opencl ? list : json_object(), "devices", v.list);
    json_decref(v.list);
    json_decref(sets);
    if (status == OST_OK && !*out)
        status = no_memory(err);
    return status;
}
