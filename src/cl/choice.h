/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the available platforms and devices, determines which devices may be used, and selects a
 * device by the user's options.
 *
 *   "platform=Portable,device=1,workgroup=64,kernels=gpu,staging=65536"
 *
 * The value of the `platform` or `device` option is a part of the name, regardless of case, or a
 * number: the index of the platform in the loader's order, or of the device within its platform.
 * Without these two options, the first device that passes all checks is used.
 * The other options affect the speed, but not the results.
 */
#ifndef OST_CL_CHOICE_H
#define OST_CL_CHOICE_H

#include <stdbool.h>
#include <stddef.h>

#include "cl/error.h"

enum { OST_CL_NAME = 160, OST_CL_REASON = 256 };

typedef struct ost_cl_device {
    cl_platform_id platform;
    cl_device_id id; /* NULL if the entry is a platform that has no devices */
    int platform_index, device_index;
    char platform_name[OST_CL_NAME], platform_version[OST_CL_NAME];
    char name[OST_CL_NAME], driver[OST_CL_NAME];
    cl_ulong max_buffer; /* maximum size of one buffer, in bytes */
    cl_ulong memory;     /* total memory, in bytes */
    size_t max_workgroup;
    bool cpu; /* true if the device has few, strong cores; OST_CL_SET_AUTO then selects the kernel set for CPUs */
    /* the reason why the backend rejects the device; "" if it accepts the device */
    char reason[OST_CL_REASON];
} ost_cl_device;

typedef struct ost_cl_devices {
    size_t count;
    ost_cl_device *list; /* owned */
    char reason[OST_CL_REASON]; /* if the list is empty, the reason why no platform was found */
} ost_cl_devices;

/* Lists all platforms and devices. Sets all members of *out, even on failure. */
ost_status ost_cl_devices_list(const ost_cl_api *cl, ost_cl_devices *out, ost_error *err);
void ost_cl_devices_free(ost_cl_devices *devices);

/*
 * The two kernel sets, with the values of OST_FOR (kernels/shared.h). OST_CL_SET_AUTO selects a kernel set by the
 * device type.
 */
typedef enum ost_cl_set { OST_CL_SET_AUTO = 0, OST_CL_SET_GPU = 1, OST_CL_SET_CPU = 2 } ost_cl_set;

typedef struct ost_cl_options {
    /* name, part of the name, or index, for the platform and for the device; "" selects any */
    char platform[OST_CL_NAME], device[OST_CL_NAME];
    size_t workgroup;                                /* number of work items per work group; 0 selects the default */
    /* maximum number of bytes that a stage transfers or processes at a time; 0 selects the stage's own limit */
    size_t staging;
    /* seed of the permutation of work items (OST_ORDER of kernels/common.h); 0 for no permutation */
    unsigned order;
    ost_cl_set kernels;
} ost_cl_options;

ost_status ost_cl_options_read(const char *text, ost_cl_options *out, ost_error *err);
/* Returns true if a device matches the `platform` and `device` options. */
bool ost_cl_options_match(const ost_cl_options *options, const ost_cl_device *device);

/*
 * Returns lines such as "CL_DEVICE_VENDOR=..." that describe the platform and the device. The caller frees the
 * text. Returns NULL if memory is exhausted.
 */
char *ost_cl_facts(const ost_cl_api *cl, const ost_cl_device *device);

/*
 * Writes the reason why the loader reports no platform. The reason names the first driver in the loader's driver folder
 * that cannot be loaded. If no such driver is found, the reason is a hint to install a driver.
 */
void ost_cl_icd_reason(char *reason, size_t size);

#endif
