/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/shim.h"

static enum shim_call armed;
static int countdown;
static bool failed, loses, late;
static shim_count objects[SHIM_OBJECTS];
const char *const shim_object_names[SHIM_OBJECTS] = {"contexts", "queues", "programs", "kernels", "buffers", "events"};

const char *const shim_names[SHIM_COUNT] = {
#define SHIM_NAME(name, code) #name,
    SHIM_CALLS(SHIM_NAME)
#undef SHIM_NAME
};

static const cl_int codes[SHIM_COUNT] = {
#define SHIM_CODE(name, code) code,
    SHIM_CALLS(SHIM_CODE)
#undef SHIM_CODE
};

void shim_fail(enum shim_call call, int n, bool lost)
{
    armed = call;
    countdown = n;
    failed = false;
    loses = lost;
    late = false;
}

void shim_fail_late(enum shim_call call, int n)
{
    shim_fail(call, n, true);
    late = true;
}

bool shim_failed(void)
{
    return failed;
}

/* Returns true for the calls that use the queue. Once a device is lost, all of these calls fail. */
bool shim_goes_to_queue(enum shim_call call)
{
    return call == SHIM_clEnqueueReadBuffer || call == SHIM_clEnqueueWriteBuffer || call == SHIM_clEnqueueCopyBuffer ||
           call == SHIM_clEnqueueFillBuffer || call == SHIM_clEnqueueNDRangeKernel || call == SHIM_clFinish;
}

static bool refuses(enum shim_call call)
{
    if (call == armed && countdown > 0 && --countdown == 0) {
        failed = true;
        return true;
    }
    return failed && loses && shim_goes_to_queue(call);
}

#define STATUS(name, parameters, arguments)                                         \
    static cl_int name##_shim parameters                                            \
    {                                                                               \
        return refuses(SHIM_##name) ? codes[SHIM_##name] : ost_cl_loader.name arguments; \
    }
/* Defines a shim for a function whose last parameter may receive an event. The parameter `wait` is true if the
   function returns only after all work is done. */
#define ENQUEUE(name, wait, parameters, arguments)                       \
    static cl_int name##_shim parameters                                 \
    {                                                                    \
        if (refuses(SHIM_##name))                                        \
            return late && !(wait) ? CL_SUCCESS : codes[SHIM_##name];    \
        const cl_int code = ost_cl_loader.name arguments;                \
        objects[SHIM_EVENT].created += code == CL_SUCCESS && event;      \
        return code;                                                     \
    }
#define RELEASE(type, name, kind)                                      \
    static cl_int name##_shim(type object)                             \
    {                                                                  \
        const cl_int code = ost_cl_loader.name(object);                \
        objects[kind].released += code == CL_SUCCESS;                  \
        return code;                                                   \
    }
/* Defines a shim for a function that creates an object and stores the error code in its last parameter. */
#define OBJECT(type, name, kind, parameters, arguments)  \
    static type name##_shim parameters             \
    {                                              \
        if (!refuses(SHIM_##name)) {               \
            type object = ost_cl_loader.name arguments; \
            objects[kind].created += object != NULL; \
            return object;                         \
        }                                          \
        *code = codes[SHIM_##name];                \
        return NULL;                               \
    }

STATUS(clGetPlatformIDs, (cl_uint capacity, cl_platform_id *ids, cl_uint *count), (capacity, ids, count))
STATUS(clGetDeviceIDs,
       (cl_platform_id platform, cl_device_type type, cl_uint capacity, cl_device_id *ids, cl_uint *count),
       (platform, type, capacity, ids, count))
STATUS(clGetDeviceInfo, (cl_device_id device, cl_device_info what, size_t capacity, void *value, size_t *size),
       (device, what, capacity, value, size))
OBJECT(cl_context, clCreateContext, SHIM_CONTEXT,
       (const cl_context_properties *properties, cl_uint count, const cl_device_id *devices,
        void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *), void *user, cl_int *code),
       (properties, count, devices, notify, user, code))
OBJECT(cl_command_queue, clCreateCommandQueue, SHIM_QUEUE,
       (cl_context context, cl_device_id device, cl_command_queue_properties properties, cl_int *code),
       (context, device, properties, code))
OBJECT(cl_program, clCreateProgramWithSource, SHIM_PROGRAM,
       (cl_context context, cl_uint count, const char **texts, const size_t *lengths, cl_int *code),
       (context, count, texts, lengths, code))
OBJECT(cl_program, clCreateProgramWithBinary, SHIM_PROGRAM,
       (cl_context context, cl_uint count, const cl_device_id *devices, const size_t *lengths,
        const unsigned char **binaries, cl_int *taken, cl_int *code),
       (context, count, devices, lengths, binaries, taken, code))
STATUS(clBuildProgram,
       (cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
        void(CL_CALLBACK *notify)(cl_program, void *), void *user),
       (program, count, devices, options, notify, user))
OBJECT(cl_kernel, clCreateKernel, SHIM_KERNEL, (cl_program program, const char *name, cl_int *code),
       (program, name, code))
STATUS(clGetKernelWorkGroupInfo,
       (cl_kernel kernel, cl_device_id device, cl_kernel_work_group_info what, size_t capacity, void *value,
        size_t *size),
       (kernel, device, what, capacity, value, size))
STATUS(clSetKernelArg, (cl_kernel kernel, cl_uint index, size_t size, const void *value), (kernel, index, size, value))
OBJECT(cl_mem, clCreateBuffer, SHIM_BUFFER,
       (cl_context context, cl_mem_flags flags, size_t size, void *host, cl_int *code),
       (context, flags, size, host, code))
ENQUEUE(clEnqueueReadBuffer, wait,
        (cl_command_queue queue, cl_mem buffer, cl_bool wait, size_t offset, size_t size, void *to, cl_uint count,
         const cl_event *after, cl_event *event),
        (queue, buffer, wait, offset, size, to, count, after, event))
ENQUEUE(clEnqueueWriteBuffer, wait,
        (cl_command_queue queue, cl_mem buffer, cl_bool wait, size_t offset, size_t size, const void *from,
         cl_uint count, const cl_event *after, cl_event *event),
        (queue, buffer, wait, offset, size, from, count, after, event))
ENQUEUE(clEnqueueCopyBuffer, false,
        (cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset, size_t size,
         cl_uint count, const cl_event *after, cl_event *event),
        (queue, from, to, from_offset, to_offset, size, count, after, event))
ENQUEUE(clEnqueueFillBuffer, false,
        (cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_size, size_t offset, size_t size,
         cl_uint count, const cl_event *after, cl_event *event),
        (queue, buffer, pattern, pattern_size, offset, size, count, after, event))
ENQUEUE(clEnqueueNDRangeKernel, false,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dims, const size_t *offset, const size_t *global,
         const size_t *local, cl_uint count, const cl_event *after, cl_event *event),
        (queue, kernel, dims, offset, global, local, count, after, event))
/*
 * A lost device must not access the host's memory after the loss is reported. Therefore this shim first waits for the
 * device, even if it reports a failure afterwards.
 */
static cl_int clFinish_shim(cl_command_queue queue)
{
    const cl_int code = clFinish(queue);
    return refuses(SHIM_clFinish) ? codes[SHIM_clFinish] : code;
}

RELEASE(cl_context, clReleaseContext, SHIM_CONTEXT)
RELEASE(cl_command_queue, clReleaseCommandQueue, SHIM_QUEUE)
RELEASE(cl_program, clReleaseProgram, SHIM_PROGRAM)
RELEASE(cl_kernel, clReleaseKernel, SHIM_KERNEL)
RELEASE(cl_mem, clReleaseMemObject, SHIM_BUFFER)

shim_count shim_objects(enum shim_object kind)
{
    return objects[kind];
}

long shim_alive(void)
{
    long alive = 0;
    for (int kind = 0; kind < SHIM_OBJECTS; kind++)
        alive += objects[kind].created - objects[kind].released;
    return alive;
}

const ost_cl_api shim = {
    .clGetPlatformInfo = clGetPlatformInfo,
    .clReleaseContext = clReleaseContext_shim,
    .clReleaseCommandQueue = clReleaseCommandQueue_shim,
    .clGetProgramInfo = clGetProgramInfo,
    .clGetProgramBuildInfo = clGetProgramBuildInfo,
    .clReleaseProgram = clReleaseProgram_shim,
    .clReleaseKernel = clReleaseKernel_shim,
    .clReleaseMemObject = clReleaseMemObject_shim,
    .clFlush = clFlush,
#define SHIM_SLOT(name, code) .name = name##_shim,
    SHIM_CALLS(SHIM_SLOT)
#undef SHIM_SLOT
};
