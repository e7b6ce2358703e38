/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A table that contains, for each OpenCL error, the status and what the user can do:
 *
 *   memory refused              OST_ERR_MEMORY       a smaller bone, or the `cpu` backend
 *   device gone, build refused  OST_ERR_UNAVAILABLE  another device or driver
 *   anything else               OST_ERR_INTERNAL     a wrong call by this backend
 *
 * CL_OUT_OF_RESOURCES means that memory is exhausted or, on GPUs, that a kernel was stopped. The
 * two causes cannot be distinguished, so the text names both.
 */
#include "cl/error.h"

#include <stdio.h>

typedef struct cl_error_text {
    cl_int code;
    const char *name;
    ost_status status;
    const char *cause; /* probable cause of the error code; NULL if the name of the code is clear */
} cl_error_text;

/* The table of errors. Error codes of extensions are written as numbers, because not all headers define them. */
static const cl_error_text errors[] = {
    {CL_DEVICE_NOT_FOUND, "CL_DEVICE_NOT_FOUND", OST_ERR_UNAVAILABLE, "no such device"},
    {CL_DEVICE_NOT_AVAILABLE, "CL_DEVICE_NOT_AVAILABLE", OST_ERR_UNAVAILABLE, "the device is gone or in use"},
    {CL_COMPILER_NOT_AVAILABLE, "CL_COMPILER_NOT_AVAILABLE", OST_ERR_UNAVAILABLE, "the driver has no compiler"},
    {CL_MEM_OBJECT_ALLOCATION_FAILURE, "CL_MEM_OBJECT_ALLOCATION_FAILURE", OST_ERR_MEMORY,
     "not enough memory on the device"},
    {CL_OUT_OF_RESOURCES, "CL_OUT_OF_RESOURCES", OST_ERR_MEMORY,
     "not enough memory on the device, or it stopped the work"},
    {CL_OUT_OF_HOST_MEMORY, "CL_OUT_OF_HOST_MEMORY", OST_ERR_MEMORY, "the driver has no memory left"},
    {CL_BUILD_PROGRAM_FAILURE, "CL_BUILD_PROGRAM_FAILURE", OST_ERR_UNAVAILABLE,
     "the driver's compiler refused the kernels"},
    {CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST, "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST", OST_ERR_UNAVAILABLE,
     "earlier work on the device failed"},
    {CL_INVALID_VALUE, "CL_INVALID_VALUE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_PLATFORM, "CL_INVALID_PLATFORM", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_DEVICE, "CL_INVALID_DEVICE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_CONTEXT, "CL_INVALID_CONTEXT", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_COMMAND_QUEUE, "CL_INVALID_COMMAND_QUEUE", OST_ERR_UNAVAILABLE, "the device was lost"},
    {CL_INVALID_MEM_OBJECT, "CL_INVALID_MEM_OBJECT", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_BINARY, "CL_INVALID_BINARY", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_BUILD_OPTIONS, "CL_INVALID_BUILD_OPTIONS", OST_ERR_UNAVAILABLE,
     "the driver's compiler refused its options"},
    {CL_INVALID_PROGRAM, "CL_INVALID_PROGRAM", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_PROGRAM_EXECUTABLE, "CL_INVALID_PROGRAM_EXECUTABLE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_KERNEL_NAME, "CL_INVALID_KERNEL_NAME", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_KERNEL, "CL_INVALID_KERNEL", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_ARG_INDEX, "CL_INVALID_ARG_INDEX", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_ARG_VALUE, "CL_INVALID_ARG_VALUE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_ARG_SIZE, "CL_INVALID_ARG_SIZE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_KERNEL_ARGS, "CL_INVALID_KERNEL_ARGS", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_WORK_GROUP_SIZE, "CL_INVALID_WORK_GROUP_SIZE", OST_ERR_USAGE,
     "the device does not take this workgroup="},
    {CL_INVALID_WORK_ITEM_SIZE, "CL_INVALID_WORK_ITEM_SIZE", OST_ERR_USAGE, "the device does not take this workgroup="},
    {CL_INVALID_GLOBAL_WORK_SIZE, "CL_INVALID_GLOBAL_WORK_SIZE", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_EVENT, "CL_INVALID_EVENT", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_OPERATION, "CL_INVALID_OPERATION", OST_ERR_INTERNAL, NULL},
    {CL_INVALID_BUFFER_SIZE, "CL_INVALID_BUFFER_SIZE", OST_ERR_MEMORY, "more than the device takes in one buffer"},
    {-1001, "CL_PLATFORM_NOT_FOUND_KHR", OST_ERR_UNAVAILABLE, "no driver is installed, or none can be loaded"},
    {-9999, "CL_NVIDIA_ILLEGAL_BUFFER_ACCESS", OST_ERR_UNAVAILABLE, "the device stopped the work and was lost"},
};

static const cl_error_text *find(cl_int code)
{
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++)
        if (errors[i].code == code)
            return &errors[i];
    return NULL;
}

const char *ost_cl_error_name(cl_int code)
{
    const cl_error_text *text = find(code);
    return text ? text->name : "an unknown error";
}

ost_status ost_cl_fail(ost_error *err, const char *device, cl_int code, const char *call, const char *what)
{
    const cl_error_text *text = find(code);
    const char *cause = text ? text->cause : NULL;
    return ost_fail(err, text ? text->status : OST_ERR_INTERNAL, "OpenCL device '%.120s': %s%s%.80s%s: %s (%d)%s%s",
                    device, call, what[0] ? " (" : "", what, what[0] ? ")" : "", ost_cl_error_name(code), (int)code,
                    cause ? ": " : "", cause ? cause : "");
}
