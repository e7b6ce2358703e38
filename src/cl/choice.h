/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Platforms and devices: which are present, which of them may decide voxels, and
 * which one the user's options select.
 *
 *   "platform=Portable,device=1,workgroup=64,kernels=gpu,staging=65536"
 *
 * platform and device are numbers in the loader's order (a device's within its
 * platform) or a part of the name, in upper or lower case.  Without them the
 * first device that passes all checks is used.  The other options belong to the
 * opened backend and change no result: every device can run either kernel set.
 */
#ifndef OST_CL_CHOICE_H
#define OST_CL_CHOICE_H

#include <stdbool.h>
#include <stddef.h>

#include "cl/error.h"

enum { OST_CL_NAME = 160, OST_CL_REASON = 256 };

typedef struct ost_cl_device {
    cl_platform_id platform;
    cl_device_id id; /* NULL: the entry represents a platform without devices */
    int platform_index, device_index;
    char platform_name[OST_CL_NAME], platform_version[OST_CL_NAME];
    char name[OST_CL_NAME], driver[OST_CL_NAME];
    cl_ulong max_buffer; /* limit for one buffer, in bytes */
    cl_ulong memory;     /* total memory, in bytes */
    size_t max_workgroup;
    bool cpu; /* few strong cores: OST_CL_SET_AUTO selects the kernel set for CPUs */
    char reason[OST_CL_REASON]; /* why it is refused; "" if nothing that the driver reports excludes it */
} ost_cl_device;

typedef struct ost_cl_devices {
    size_t count;
    ost_cl_device *list; /* owned */
    char reason[OST_CL_REASON]; /* why there is no platform, if there is none */
} ost_cl_devices;

/* Sets all of *out, also on failure. */
ost_status ost_cl_devices_list(const ost_cl_api *cl, ost_cl_devices *out, ost_error *err);
void ost_cl_devices_free(ost_cl_devices *devices);

/* The two kernel sets, with the values of OST_FOR (kernels/shared.h); AUTO selects by the device's type. */
typedef enum ost_cl_set { OST_CL_SET_AUTO = 0, OST_CL_SET_GPU = 1, OST_CL_SET_CPU = 2 } ost_cl_set;

typedef struct ost_cl_options {
    char platform[OST_CL_NAME], device[OST_CL_NAME]; /* "": any */
    size_t workgroup;                                /* 0: the backend's own choice */
    size_t staging; /* limit in bytes on what a stage transfers or processes at a time; 0: each stage's own limit */
    unsigned order; /* seed of another order of work items (OST_ORDER of kernels/common.h); 0: the device's own */
    ost_cl_set kernels;
} ost_cl_options;

ost_status ost_cl_options_read(const char *text, ost_cl_options *out, ost_error *err);
/* Returns true if the options platform and device select this device. */
bool ost_cl_options_match(const ost_cl_options *options, const ost_cl_device *device);

/* Returns lines "CL_DEVICE_VENDOR=..." about the platform and the device, for the record, to be freed by the
   caller. NULL if out of memory. */
char *ost_cl_facts(const ost_cl_api *cl, const ost_cl_device *device);

/* Writes why the loader reports no platform, as far as its folder of drivers shows it. */
void ost_cl_icd_reason(char *reason, size_t size);

#endif
