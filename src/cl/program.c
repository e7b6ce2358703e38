/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Builds a program for the device of the backend, or loads it from the cache.
 *
 *   cache has a binary --> the driver accepts it --> done
 *          | no                  | no
 *          '---------> source <--'   built; the binary is stored if this saves time
 *
 * The log of a failed build may be long and has no fixed format.  The error message
 * contains the first line of the log that contains "error".
 */
#include "cl/cl.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/cache.h"

/*
 * Selects a line of a log for the error message. This is the first line that contains "error" or, if there is none, the
 * first line that is not empty.
 */
static void shorten(const char *log, char *out, size_t size)
{
    const char *best = NULL, *first = NULL;
    for (const char *p = log; *p && !best;) {
        size_t length = strcspn(p, "\r\n");
        if (length > 0 && !first)
            first = p;
        for (size_t i = 0; i + 5 <= length && !best; i++)
            if (strncmp(p + i, "error", 5) == 0 || strncmp(p + i, "Error", 5) == 0)
                best = p;
        p += length;
        p += strspn(p, "\r\n");
    }
    best = best ? best : first;
    snprintf(out, size, "%.*s", best ? (int)strcspn(best, "\r\n") : 0, best ? best : "");
}

static ost_status build_failed(cl_backend *b, cl_program program, cl_int code, ost_error *err)
{
    char line[280] = "";
    size_t size = 0;
    if (b->cl->clGetProgramBuildInfo(program, b->device.id, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) == CL_SUCCESS &&
        size > 0 && size < 1 << 24) {
        char *log = calloc(1, size + 1);
        if (log &&
            b->cl->clGetProgramBuildInfo(program, b->device.id, CL_PROGRAM_BUILD_LOG, size, log, NULL) == CL_SUCCESS)
            shorten(log, line, sizeof line);
        free(log);
    }
    ost_status status = ost_cl_fail(err, b->device.name, code, "clBuildProgram", "");
    if (line[0] && err) {
        char text[OST_ERROR_TEXT];
        snprintf(text, sizeof text, "%s", err->text);
        return ost_fail(err, status, "%.340s; its log: %s", text, line);
    }
    return status;
}

static bool from_binary(cl_backend *b, const ost_cl_cache *cache, const char *options, cl_program *out)
{
    size_t size;
    unsigned char *binary = ost_cl_cache_load(cache, &size);
    if (!binary)
        return false;
    const unsigned char *binaries[1] = {binary};
    cl_int taken = CL_SUCCESS, code = CL_SUCCESS;
    cl_program program = b->cl->clCreateProgramWithBinary(b->context, 1, &b->device.id, &size, binaries, &taken, &code);
    free(binary);
    if (program && code == CL_SUCCESS && taken == CL_SUCCESS &&
        b->cl->clBuildProgram(program, 1, &b->device.id, options, NULL, NULL) == CL_SUCCESS) {
        *out = program;
        return true;
    }
    if (program)
        b->cl->clReleaseProgram(program);
    return false;
}

/*
 * Returns true if the binary of a program that was built from its source should be stored.
 *
 * PoCL compiles all kernels of a program when its binary is requested, which takes longer than everything else in the
 * first start of a command. Without this request, PoCL compiles a kernel when the kernel is launched, and stores the
 * result in its own cache. The binary of the first program of a process is therefore not requested. Thus a command,
 * which opens one backend, compiles only the kernels that it launches. In a process that opens several backends, the
 * stored binary saves more time than the request takes. POCL_KERNEL_CACHE=0 switches PoCL's own cache off.
 */
static bool pays_to_store(const cl_backend *b)
{
    static atomic_bool later_program;
    const char *own_cache = getenv("POCL_KERNEL_CACHE");
    const bool compiles_late = strcmp(b->device.platform_name, "Portable Computing Language") == 0 &&
                               !(own_cache && strcmp(own_cache, "0") == 0);
    return atomic_exchange(&later_program, true) || !compiles_late;
}

/* Stores the binary of a program in the cache. A failure is ignored, because the program can be built again. */
static void store_binary(cl_backend *b, const ost_cl_cache *cache, cl_program program)
{
    size_t size = 0;
    if (b->cl->clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, NULL) != CL_SUCCESS || size == 0)
        return;
    unsigned char *binary = calloc(1, size);
    unsigned char *binaries[1] = {binary};
    if (binary && b->cl->clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof binaries, binaries, NULL) == CL_SUCCESS)
        ost_cl_cache_store(cache, binary, size);
    free(binary);
}

ost_status ost_cl_build(cl_backend *b, const char *const *sources, size_t count, const char *options, cl_program *out,
                        bool *from_cache, ost_error *err)
{
    *out = NULL;
    ost_cl_cache cache;
    ost_status status = ost_cl_key(&b->device, sources, count, options, &cache, err);
    if (status != OST_OK)
        return status;
    *from_cache = from_binary(b, &cache, options, out);
    if (*from_cache)
        return OST_OK;

    cl_int code = CL_SUCCESS;
    const char **texts = malloc(count * sizeof *texts);
    if (!texts)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the kernels' sources");
    for (size_t i = 0; i < count; i++)
        texts[i] = sources[i];
    cl_program program = b->cl->clCreateProgramWithSource(b->context, (cl_uint)count, texts, NULL, &code);
    free(texts);
    if (!program || code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clCreateProgramWithSource", "");
    code = b->cl->clBuildProgram(program, 1, &b->device.id, options, NULL, NULL);
    if (code != CL_SUCCESS) {
        status = build_failed(b, program, code, err);
        b->cl->clReleaseProgram(program);
        return status;
    }
    if (pays_to_store(b))
        store_binary(b, &cache, program);
    *out = program;
    return OST_OK;
}
