/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Builds the list of devices. If a device is rejected, its entry contains the reason.
 *
 *   loader -- no platform                      icd.c finds the reason
 *      |
 *   platform -- no device                      one entry represents the platform
 *      |
 *   device -- not available, no compiler, OpenCL before 1.2, big-endian,
 *      |      no 64-bit integers: rejected because of what the driver reports
 *   fingerprint.c: rejected because of its results
 *
 * 64-bit integers are part of the full profile. In the embedded profile they are
 * optional (cles_khr_int64).
 */
#include "cl/choice.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The maximum number of platforms, and of devices per platform. A driver that reports more than this is defective. */
enum { PLATFORMS_MAX = 64, DEVICES_MAX = 256 };

/* Removes leading and trailing blanks, and replaces control characters with '?'. */
static void tidy(char *text)
{
    size_t start = strspn(text, " \t\r\n");
    size_t length = strlen(text);
    while (length > start && strchr(" \t\r\n", text[length - 1]))
        length--;
    length -= length > start ? start : length;
    memmove(text, text + start, length);
    text[length] = 0;
    for (char *p = text; *p; p++)
        if ((unsigned char)*p < ' ' || *p == 0x7f)
            *p = '?';
}

/*
 * Sets `out` to the beginning of a string that the driver reports for a platform, or to "" if the driver reports none.
 * Drivers reject a buffer that is too small, so the complete string is read first and then truncated.
 */
static void platform_text(const ost_cl_api *cl, cl_platform_id platform, cl_platform_info what, char out[OST_CL_NAME])
{
    size_t size = 0;
    out[0] = 0;
    if (cl->clGetPlatformInfo(platform, what, 0, NULL, &size) != CL_SUCCESS || size == 0 || size > 1 << 20)
        return;
    char *text = calloc(1, size + 1);
    if (text && cl->clGetPlatformInfo(platform, what, size, text, NULL) == CL_SUCCESS)
        snprintf(out, OST_CL_NAME, "%s", text);
    free(text);
    tidy(out);
}

/* Returns the complete string that the driver reports for a device, or NULL. The caller frees the string. */
static char *device_text(const ost_cl_api *cl, cl_device_id device, cl_device_info what)
{
    size_t size = 0;
    if (cl->clGetDeviceInfo(device, what, 0, NULL, &size) != CL_SUCCESS || size == 0 || size > 1 << 20)
        return NULL;
    char *text = calloc(1, size + 1);
    if (text && cl->clGetDeviceInfo(device, what, size, text, NULL) != CL_SUCCESS) {
        free(text);
        return NULL;
    }
    return text;
}

static void device_name(const ost_cl_api *cl, cl_device_id device, cl_device_info what, char out[OST_CL_NAME])
{
    char *text = device_text(cl, device, what);
    snprintf(out, OST_CL_NAME, "%s", text ? text : "");
    free(text);
    tidy(out);
}

static bool device_flag(const ost_cl_api *cl, cl_device_id device, cl_device_info what)
{
    cl_bool flag = CL_FALSE;
    return cl->clGetDeviceInfo(device, what, sizeof flag, &flag, NULL) == CL_SUCCESS && flag;
}

/* Returns the version that follows the prefix, as an integer: 12 if the text is "OpenCL 1.2 ..." and the prefix is
   "OpenCL ". Returns 0 if the text has a different form. */
static int version_of(const char *text, const char *prefix)
{
    size_t length = strlen(prefix);
    if (strncmp(text, prefix, length) != 0)
        return 0;
    const char *p = text + length;
    if (p[0] < '0' || p[0] > '9' || p[1] != '.' || p[2] < '0' || p[2] > '9')
        return 0;
    return 10 * (p[0] - '0') + p[2] - '0';
}

static bool has_word(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (const char *p = words; (p = strstr(p, word)); p += length)
        if ((p == words || p[-1] == ' ') && (p[length] == ' ' || p[length] == 0))
            return true;
    return false;
}

static void refuse(ost_cl_device *device, const char *reason)
{
    snprintf(device->reason, sizeof device->reason, "%s", reason);
}

static void examine(const ost_cl_api *cl, ost_cl_device *d)
{
    char version[OST_CL_NAME], language[OST_CL_NAME], profile[OST_CL_NAME];
    device_name(cl, d->id, CL_DEVICE_NAME, d->name);
    device_name(cl, d->id, CL_DRIVER_VERSION, d->driver);
    device_name(cl, d->id, CL_DEVICE_VERSION, version);
    device_name(cl, d->id, CL_DEVICE_OPENCL_C_VERSION, language);
    device_name(cl, d->id, CL_DEVICE_PROFILE, profile);
    char *extensions = device_text(cl, d->id, CL_DEVICE_EXTENSIONS);
    const bool wide = strcmp(profile, "FULL_PROFILE") == 0 || (extensions && has_word(extensions, "cles_khr_int64"));
    free(extensions);

    bool answered = cl->clGetDeviceInfo(d->id, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof d->max_buffer, &d->max_buffer,
                                        NULL) == CL_SUCCESS;
    answered = answered &&
               cl->clGetDeviceInfo(d->id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof d->memory, &d->memory, NULL) == CL_SUCCESS;
    answered = answered && cl->clGetDeviceInfo(d->id, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof d->max_workgroup,
                                               &d->max_workgroup, NULL) == CL_SUCCESS;

    cl_device_type type = 0;
    answered = answered && cl->clGetDeviceInfo(d->id, CL_DEVICE_TYPE, sizeof type, &type, NULL) == CL_SUCCESS;
    /*
     * Mesa's llvmpipe reports a CPU but ends long loops early. fingerprint.c would detect this only after the kernel
     * set for CPUs was built, and the set for GPUs would then be built too. Testing the name avoids the first of these
     * two builds.
     */
    d->cpu = (type & CL_DEVICE_TYPE_CPU) != 0 && !strstr(d->name, "llvmpipe");

    if (!answered || !d->name[0])
        refuse(d, "the driver does not say what the device is");
    else if (!device_flag(cl, d->id, CL_DEVICE_AVAILABLE))
        refuse(d, "the driver says that the device is not available");
    else if (!device_flag(cl, d->id, CL_DEVICE_COMPILER_AVAILABLE))
        refuse(d, "the driver has no compiler");
    else if (version_of(version, "OpenCL ") < 12 || version_of(language, "OpenCL C ") < 12)
        snprintf(d->reason, sizeof d->reason, "OpenCL 1.2 is needed; it has '%.60s' and '%.60s'", version, language);
    else if (!device_flag(cl, d->id, CL_DEVICE_ENDIAN_LITTLE))
        refuse(d, "a little-endian device is needed: grids and reports are little-endian bytes");
    else if (!wide)
        refuse(d, "it has no 64-bit integers (embedded profile without cles_khr_int64)");
}

static ost_cl_device *append(ost_cl_devices *devices)
{
    ost_cl_device *more = realloc(devices->list, (devices->count + 1) * sizeof *more);
    if (!more)
        return NULL;
    devices->list = more;
    memset(&more[devices->count], 0, sizeof *more);
    return &more[devices->count++];
}

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for the list of OpenCL devices");
}

static ost_status list_platform(const ost_cl_api *cl, cl_platform_id platform, int index, ost_cl_devices *out,
                                ost_error *err)
{
    cl_device_id ids[DEVICES_MAX];
    cl_uint count = 0;
    cl_int code = cl->clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, DEVICES_MAX, ids, &count);
    if (code != CL_SUCCESS)
        count = 0;
    if (count > DEVICES_MAX)
        count = DEVICES_MAX;
    for (cl_uint i = 0; i < (count ? count : 1); i++) {
        ost_cl_device *d = append(out);
        if (!d)
            return no_memory(err);
        d->platform = platform;
        d->platform_index = index;
        d->device_index = (int)i;
        platform_text(cl, platform, CL_PLATFORM_NAME, d->platform_name);
        platform_text(cl, platform, CL_PLATFORM_VERSION, d->platform_version);
        if (count) {
            d->id = ids[i];
            examine(cl, d);
        } else {
            snprintf(d->reason, sizeof d->reason, "the platform has no device (clGetDeviceIDs: %s)",
                     code == CL_SUCCESS ? "none" : ost_cl_error_name(code));
        }
    }
    return OST_OK;
}

ost_status ost_cl_devices_list(const ost_cl_api *cl, ost_cl_devices *out, ost_error *err)
{
    memset(out, 0, sizeof *out);
    cl_platform_id platforms[PLATFORMS_MAX];
    cl_uint count = 0;
    cl_int code = cl->clGetPlatformIDs(PLATFORMS_MAX, platforms, &count);
    if (code != CL_SUCCESS || count == 0) {
        ost_cl_icd_reason(out->reason, sizeof out->reason);
        return OST_OK;
    }
    ost_status status = OST_OK;
    for (cl_uint i = 0; i < count && i < PLATFORMS_MAX && status == OST_OK; i++)
        status = list_platform(cl, platforms[i], (int)i, out, err);
    if (status != OST_OK)
        ost_cl_devices_free(out);
    return status;
}

void ost_cl_devices_free(ost_cl_devices *devices)
{
    free(devices->list);
    devices->list = NULL;
    devices->count = 0;
}

/* --------------------------------------------------------------- options */

static bool is_number(const char *text)
{
    return text[0] && strspn(text, "0123456789") == strlen(text) && strlen(text) < 10;
}

/*
 * Returns true if the value of the option platform= or device= selects the platform or device with this index and name.
 * The value "" selects every index, a number selects one index, and any other text selects the names that contain the
 * text.
 */
static bool fits(const char *wanted, int index, const char *name)
{
    if (!wanted[0])
        return true;
    if (is_number(wanted))
        return strtol(wanted, NULL, 10) == index;
    size_t length = strlen(wanted);
    for (; *name; name++)
        if (strncasecmp(name, wanted, length) == 0)
            return true;
    return false;
}

bool ost_cl_options_match(const ost_cl_options *options, const ost_cl_device *device)
{
    if (!fits(options->platform, device->platform_index, device->platform_name))
        return false;
    return device->id ? fits(options->device, device->device_index, device->name) : !options->device[0];
}

static ost_status set_option(const char *key, size_t key_length, const char *value, size_t length, ost_cl_options *out,
                             ost_error *err)
{
    char text[OST_CL_NAME];
    snprintf(text, sizeof text, "%.*s", (int)(length < sizeof text ? length : sizeof text - 1), value);
    const bool known = (key_length == 8 && strncmp(key, "platform", 8) == 0) ||
                       (key_length == 6 && strncmp(key, "device", 6) == 0);
    if (known && (length == 0 || length >= sizeof text))
        return ost_fail(err, OST_ERR_USAGE, "backend cl: %.*s=%.40s; expected a number or a part of its name",
                        (int)key_length, key, text);
    if (known) {
        snprintf(key_length == 8 ? out->platform : out->device, OST_CL_NAME, "%s", text);
        return OST_OK;
    }
    if (key_length == 9 && strncmp(key, "workgroup", 9) == 0) {
        long n = is_number(text) ? strtol(text, NULL, 10) : 0;
        if (n < 1 || n > 65536)
            return ost_fail(err, OST_ERR_USAGE,
                            "backend cl: workgroup=%.40s; expected a number of work items from 1 to 65536", text);
        out->workgroup = (size_t)n;
        return OST_OK;
    }
    if (key_length == 7 && strncmp(key, "staging", 7) == 0) {
        long n = is_number(text) ? strtol(text, NULL, 10) : 0;
        if (n < 1024)
            return ost_fail(err, OST_ERR_USAGE,
                            "backend cl: staging=%.40s; expected a number of bytes from 1024 to 999999999", text);
        out->staging = (size_t)n;
        return OST_OK;
    }
    if (key_length == 5 && strncmp(key, "order", 5) == 0) {
        long n = is_number(text) ? strtol(text, NULL, 10) : 0;
        if (n < 1)
            return ost_fail(err, OST_ERR_USAGE, "backend cl: order=%.40s; expected a seed from 1 to 999999999", text);
        out->order = (unsigned)n;
        return OST_OK;
    }
    if (key_length == 7 && strncmp(key, "kernels", 7) == 0) {
        out->kernels = strcmp(text, "cpu") == 0   ? OST_CL_SET_CPU
                       : strcmp(text, "gpu") == 0 ? OST_CL_SET_GPU
                                                  : OST_CL_SET_AUTO;
        if (out->kernels == OST_CL_SET_AUTO)
            return ost_fail(err, OST_ERR_USAGE, "backend cl: kernels=%.40s; expected cpu or gpu", text);
        return OST_OK;
    }
    return ost_fail(err, OST_ERR_USAGE, "backend cl: unknown option '%.*s'; expected platform=, device=, workgroup=, "
                    "kernels=, staging= and order=", (int)(key_length < 40 ? key_length : 40), key);
}

ost_status ost_cl_options_read(const char *text, ost_cl_options *out, ost_error *err)
{
    *out = (ost_cl_options){.workgroup = 0};
    ost_status status = OST_OK;
    while (*text && status == OST_OK) {
        size_t length = strcspn(text, ",");
        size_t key = strcspn(text, "=,");
        const char *value = text[key] == '=' ? text + key + 1 : text + key;
        status = set_option(text, key, value, (size_t)(text + length - value), out, err);
        text += length + (text[length] == ',');
    }
    return status;
}
