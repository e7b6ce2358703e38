/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Records the information that a driver reports about itself and a device, as lines "CL_DEVICE_VENDOR=...". The names
 * are defined by OpenCL. Values that are not text are decimal numbers; bit fields are hexadecimal. The lines have no
 * effect on the choice of a device or on any result. They are the same in every run on a machine, because they include
 * neither the time nor the free memory.
 */
#include "cl/choice.h"
#include "core/memory_stream.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum fact_kind { TEXT, UINT, ULONG, SIZE, BITS, BUS } fact_kind;

static const struct {
    const char *name;
    cl_uint what;
    fact_kind kind;
} of_platform[] = {
    {"CL_PLATFORM_NAME", CL_PLATFORM_NAME, TEXT},
    {"CL_PLATFORM_VENDOR", CL_PLATFORM_VENDOR, TEXT},
    {"CL_PLATFORM_VERSION", CL_PLATFORM_VERSION, TEXT},
    {"CL_PLATFORM_PROFILE", CL_PLATFORM_PROFILE, TEXT},
}, of_device[] = {
    {"CL_DEVICE_NAME", CL_DEVICE_NAME, TEXT},
    {"CL_DEVICE_VENDOR", CL_DEVICE_VENDOR, TEXT},
    {"CL_DEVICE_VENDOR_ID", CL_DEVICE_VENDOR_ID, UINT},
    {"CL_DEVICE_TYPE", CL_DEVICE_TYPE, BITS},
    {"CL_DEVICE_VERSION", CL_DEVICE_VERSION, TEXT},
    {"CL_DRIVER_VERSION", CL_DRIVER_VERSION, TEXT},
    {"CL_DEVICE_OPENCL_C_VERSION", CL_DEVICE_OPENCL_C_VERSION, TEXT},
    {"CL_DEVICE_PROFILE", CL_DEVICE_PROFILE, TEXT},
    {"CL_DEVICE_ADDRESS_BITS", CL_DEVICE_ADDRESS_BITS, UINT},
    {"CL_DEVICE_MAX_COMPUTE_UNITS", CL_DEVICE_MAX_COMPUTE_UNITS, UINT},
    {"CL_DEVICE_MAX_WORK_GROUP_SIZE", CL_DEVICE_MAX_WORK_GROUP_SIZE, SIZE},
    {"CL_DEVICE_GLOBAL_MEM_SIZE", CL_DEVICE_GLOBAL_MEM_SIZE, ULONG},
    {"CL_DEVICE_MAX_MEM_ALLOC_SIZE", CL_DEVICE_MAX_MEM_ALLOC_SIZE, ULONG},
    {"CL_DEVICE_LOCAL_MEM_SIZE", CL_DEVICE_LOCAL_MEM_SIZE, ULONG},
    {"CL_DEVICE_ERROR_CORRECTION_SUPPORT", CL_DEVICE_ERROR_CORRECTION_SUPPORT, UINT},
    {"CL_DEVICE_ENDIAN_LITTLE", CL_DEVICE_ENDIAN_LITTLE, UINT},
    {"CL_DEVICE_SINGLE_FP_CONFIG", CL_DEVICE_SINGLE_FP_CONFIG, BITS},
    {"CL_DEVICE_DOUBLE_FP_CONFIG", 0x1032, BITS},
    {"CL_DEVICE_EXECUTION_CAPABILITIES", CL_DEVICE_EXECUTION_CAPABILITIES, BITS},
    {"CL_DEVICE_PCI_BUS_INFO_KHR", 0x410f, BUS},
    {"CL_DEVICE_EXTENSIONS", CL_DEVICE_EXTENSIONS, TEXT},
};

typedef union fact {
    cl_uint uint;
    cl_ulong ulong;
    size_t size;
    cl_uint bus[4]; /* domain, bus, device, function */
    char text[16384];
} fact;

static void put_line(FILE *to, const char *name, fact_kind kind, fact *v, size_t size)
{
    static const size_t sizes[] = {[UINT] = sizeof v->uint,
                                   [ULONG] = sizeof v->ulong,
                                   [SIZE] = sizeof v->size,
                                   [BITS] = sizeof v->ulong,
                                   [BUS] = sizeof v->bus};
    if (kind != TEXT && size != sizes[kind])
        return; /* The driver has no such property, or returned a value of an unexpected size. */
    fprintf(to, "%s=", name);
    switch (kind) {
    case TEXT:
        v->text[size < sizeof v->text ? size : sizeof v->text - 1] = '\0';
        for (char *end = v->text + strlen(v->text); end > v->text && (unsigned char)end[-1] <= ' ';)
            *--end = '\0';
        for (const char *c = v->text; *c; c++)
            fputc((unsigned char)*c < ' ' || (unsigned char)*c > '~' ? '?' : *c, to);
        break;
    case UINT: fprintf(to, "%lu", (unsigned long)v->uint); break;
    case ULONG: fprintf(to, "%llu", (unsigned long long)v->ulong); break;
    case SIZE: fprintf(to, "%zu", v->size); break;
    case BITS: fprintf(to, "0x%llx", (unsigned long long)v->ulong); break;
    case BUS:
        fprintf(to, "%04x:%02x:%02x.%x", (unsigned)v->bus[0], (unsigned)v->bus[1], (unsigned)v->bus[2],
                (unsigned)v->bus[3]);
        break;
    }
    fputc('\n', to);
}

char *ost_cl_facts(const ost_cl_api *cl, const ost_cl_device *device)
{
    ost_memory_stream made;
    size_t got;
    fact *v = malloc(sizeof *v);
    FILE *to = v ? ost_memory_stream_open(&made) : NULL;
    if (!to) {
        free(v);
        return NULL;
    }
    for (size_t i = 0; i < sizeof of_platform / sizeof of_platform[0]; i++) {
        memset(v, 0, sizeof *v);
        got = 0;
        if (cl->clGetPlatformInfo(device->platform, of_platform[i].what, sizeof *v - 1, v, &got) == CL_SUCCESS)
            put_line(to, of_platform[i].name, of_platform[i].kind, v, got);
    }
    for (size_t i = 0; device->id && i < sizeof of_device / sizeof of_device[0]; i++) {
        memset(v, 0, sizeof *v);
        got = 0;
        if (cl->clGetDeviceInfo(device->id, of_device[i].what, sizeof *v - 1, v, &got) == CL_SUCCESS)
            put_line(to, of_device[i].name, of_device[i].kind, v, got);
    }
    free(v);
    return ost_memory_stream_close(to, &made) ? made.bytes : NULL;
}
