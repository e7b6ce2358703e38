/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The numeric fingerprint of a device.  It is computed each time the device is opened.
 *
 *   integers  products, carries, shifts, quotients, bits and atomics, for all pairs
 *             of edge values and for random values: if a word differs from the
 *             host's, the device is refused
 *   turns     the number of iterations that a loop may have; a device that ends
 *             long loops gets the kernel set for GPUs; a device that ends even the
 *             loops of that set is refused
 *   floats    for information only: whether sums are fused, whether denormals are
 *             flushed, and so on
 */
#include "cl/cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cl/embedded.h"
#include "cl/fingerprint_expect.h"

static const char *const names[OST_CL_FINGERPRINT] = {
    "ulong * ulong",
    "mul_hi(ulong)",
    "mul_hi(long)",
    "uint * uint widened",
    "int * int widened",
    "the square of 24 bits >> 32",
    "(long)int * 100",
    "mul_hi(uint)",
    "mul_hi(int)",
    "uint * uint",
    "128-bit product >> 20",
    "ulong + ulong",
    "the carry of ulong + ulong",
    "ulong - ulong",
    "ulong < ulong",
    "the carry of uint + uint",
    "ulong << n",
    "ulong >> n",
    "rotate(ulong)",
    "uint << n, uint >> n",
    "ulong / ulong",
    "ulong % ulong",
    "long / long",
    "long % long",
    "uint / uint",
    "int / int",
    "rounding division",
    "clz, popcount",
    "signed and unsigned order",
    "short and char widened",
    "ulong narrowed",
    "a 64-bit mixture",
};

static const uint64_t edges[] = {
    0,
    1,
    2,
    3,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0x8000,
    0xffff,
    0xffffff,
    0x7fffffff,
    0x80000000,
    0xffffffff,
    0x100000000,
    0x7fffffffffffffff,
    0x8000000000000000,
    0xffffffff00000000,
    0xaaaaaaaaaaaaaaaa,
    0x5555555555555555,
    0xfffffffffffffffe,
    0xffffffffffffffff,
};

enum { EDGES = sizeof edges / sizeof edges[0], RANDOM = 800, PAIRS = EDGES * EDGES + RANDOM };

/* Returns the next word of splitmix64. The seed is fixed, so that the words are the same on every machine. */
static uint64_t next_word(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static void fill_pairs(uint64_t in[2 * PAIRS])
{
    uint64_t state = 1;
    for (int i = 0; i < EDGES * EDGES; i++) {
        in[2 * i] = edges[i / EDGES];
        in[2 * i + 1] = edges[i % EDGES];
    }
    for (int i = 2 * EDGES * EDGES; i < 2 * PAIRS; i++)
        in[i] = next_word(&state);
}

static ost_status wrong(const cl_backend *b, const char *what, uint64_t found, uint64_t expected, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "OpenCL device '%.120s' is refused: wrong integer result: %s gives 0x%llx, expected 0x%llx; try "
                    "another version of its driver (this one: %.60s)", b->device.name, what,
                    (unsigned long long)found, (unsigned long long)expected, b->device.driver);
}

static ost_status check_words(const cl_backend *b, const uint64_t *in, const uint64_t *out, ost_error *err)
{
    for (int i = 0; i < PAIRS; i++) {
        uint64_t expected[OST_CL_FINGERPRINT];
        ost_cl_fingerprint_expect(in[2 * i], in[2 * i + 1], expected);
        for (int k = 0; k < OST_CL_FINGERPRINT; k++) {
            const uint64_t found = out[(size_t)i * OST_CL_FINGERPRINT + (size_t)k];
            if (found != expected[k]) {
                char what[120];
                snprintf(what, sizeof what, "%s of 0x%llx and 0x%llx", names[k], (unsigned long long)in[2 * i],
                         (unsigned long long)in[2 * i + 1]);
                return wrong(b, what, found, expected[k], err);
            }
        }
    }
    return OST_OK;
}

static ost_status check_counters(const cl_backend *b, const uint64_t *in, const uint32_t *counters, ost_error *err)
{
    uint32_t expected[OST_CL_FINGERPRINT_COUNTERS];
    ost_cl_fingerprint_expect_atomics(in, 2 * PAIRS, expected);
    for (int k = 0; k < OST_CL_FINGERPRINT_COUNTERS; k++)
        if (counters[k] != expected[k]) {
            char what[60];
            snprintf(what, sizeof what, "atomic counter %d over %d work items", k, 2 * PAIRS);
            return wrong(b, what, counters[k], expected[k], err);
        }
    return OST_OK;
}

static ost_status check_turns(cl_backend *b, const uint32_t turns[2], ost_error *err)
{
    uint32_t x = 0;
    for (uint32_t n = 0; n < turns[0] && n < OST_CL_TURNS; n++)
        x = OST_CL_NEXT_TURN(x);
    if (turns[0] > OST_CL_TURNS || x != turns[1])
        return wrong(b, "a loop", turns[1], x, err);
    b->turns = turns[0];
    if (b->turns >= OST_CL_TURNS_LEAST)
        return OST_OK;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "OpenCL device '%.120s' is refused: it ends a loop after %u iterations without an error; "
                    "expected at least %u; try another version of its driver (this one: %.60s)", b->device.name,
                    (unsigned)b->turns, (unsigned)OST_CL_TURNS_LEAST, b->device.driver);
}

ost_status ost_cl_fingerprint_check(cl_backend *b, ost_error *err)
{
    cl_mem in_buffer = NULL, out_buffer = NULL, counter_buffer = NULL, turns_buffer = NULL;
    const size_t in_bytes = 2 * PAIRS * sizeof(uint64_t),
                 out_bytes = (size_t)PAIRS * OST_CL_FINGERPRINT * sizeof(uint64_t);
    uint32_t counters[OST_CL_FINGERPRINT_COUNTERS] = {[5] = UINT32_MAX, [7] = UINT32_MAX};
    uint32_t turns[2] = {0};
    cl_uint pairs = PAIRS, words = 2 * PAIRS, end = 0;
    for (uint32_t n = 0; n < OST_CL_TURNS; n++)
        end = OST_CL_NEXT_TURN(end);
    ost_status status = OST_OK;
    uint64_t *in = malloc(in_bytes), *out = malloc(out_bytes);
    if (!in || !out) {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the fingerprint of an OpenCL device");
        goto done;
    }
    fill_pairs(in);
    status = ost_cl_buffer(b, in_bytes, in, "fingerprint", &in_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, out_bytes, "fingerprint", &out_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof counters, counters, "fingerprint", &counter_buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_fingerprint, PAIRS, 1, 1, err, OST_CL_ARG(pairs), OST_CL_ARG(in_buffer),
                               OST_CL_ARG(out_buffer));
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_fingerprint_atomics, 2 * PAIRS, 1, 1, err, OST_CL_ARG(words),
                               OST_CL_ARG(in_buffer), OST_CL_ARG(counter_buffer));
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, sizeof turns, "fingerprint", &turns_buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_fingerprint_turns, 1, 1, 1, err, OST_CL_ARG(end), OST_CL_ARG(turns_buffer));
    if (status == OST_OK)
        status = ost_cl_read(b, out_buffer, 0, out_bytes, out, err);
    if (status == OST_OK)
        status = ost_cl_read(b, counter_buffer, 0, sizeof counters, counters, err);
    if (status == OST_OK)
        status = ost_cl_read(b, turns_buffer, 0, sizeof turns, turns, err);
    if (status == OST_OK)
        status = check_words(b, in, out, err);
    if (status == OST_OK)
        status = check_counters(b, in, counters, err);
    if (status == OST_OK)
        status = check_turns(b, turns, err);
done:
    ost_cl_buffer_free(b, &turns_buffer);
    ost_cl_buffer_free(b, &counter_buffer);
    ost_cl_buffer_free(b, &out_buffer);
    ost_cl_buffer_free(b, &in_buffer);
    free(out);
    free(in);
    return status;
}

/* ---------------------------------------------------------------- floats */

/* Bit patterns of the inputs a, b and c of the kernel in kernels/fingerprint_float.cl. */
enum { FLOATS = 4 };
static const uint32_t float_in[3 * FLOATS] = {
    0x3f800800, 0x3f800800, 0xbf800000, /* a = b = 1 + 2^-12, c = -1: a * b + c shows whether the sum is fused */
    0x3f800000, 0x40400000, 0x00000000, /* 1 / 3 */
    /*
     * For a = 0.5, the kernel multiplies a by the smallest normal number. The product shows whether denormals are
     * flushed to 0.
     */
    0x3f000000, 0x3f800000, 0x00000000,
    0x501502f9, 0x3f800000, 0x00000000, /* 1e10, to int */
};

static ost_status run_floats(cl_backend *b, cl_program program, uint32_t out[FLOATS * OST_CL_FLOATS], ost_error *err)
{
    cl_mem in_buffer = NULL, out_buffer = NULL;
    const cl_uint count = FLOATS;
    const size_t global = FLOATS;
    cl_int code = CL_SUCCESS;
    cl_kernel kernel = b->cl->clCreateKernel(program, "ost_fingerprint_float", &code);
    if (!kernel || code != CL_SUCCESS)
        return ost_cl_fail(err, b->device.name, code, "clCreateKernel", "ost_fingerprint_float");
    ost_status status = ost_cl_buffer(b, sizeof float_in, float_in, "fingerprint", &in_buffer, err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, FLOATS * OST_CL_FLOATS * sizeof *out, "fingerprint", &out_buffer, err);
    if (status == OST_OK) {
        b->cl->clSetKernelArg(kernel, 0, sizeof count, &count);
        b->cl->clSetKernelArg(kernel, 1, sizeof in_buffer, &in_buffer);
        b->cl->clSetKernelArg(kernel, 2, sizeof out_buffer, &out_buffer);
        code = b->cl->clEnqueueNDRangeKernel(b->queue, kernel, 1, NULL, &global, NULL, 0, NULL, NULL);
        if (code != CL_SUCCESS)
            status = ost_cl_fail(err, b->device.name, code, "clEnqueueNDRangeKernel", "ost_fingerprint_float");
    }
    if (status == OST_OK)
        status = ost_cl_read(b, out_buffer, 0, FLOATS * OST_CL_FLOATS * sizeof *out, out, err);
    ost_cl_buffer_free(b, &out_buffer);
    ost_cl_buffer_free(b, &in_buffer);
    b->cl->clReleaseKernel(kernel);
    return status;
}

void ost_cl_fingerprint_floats(cl_backend *b, char *notes, size_t size)
{
    uint32_t out[FLOATS * OST_CL_FLOATS] = {0};
    cl_program program = NULL;
    bool from_cache;
    ost_error err = {0};
    ost_digest digest;
    char hex[OST_DIGEST_HEX] = "";
    ost_status status = ost_cl_build(b, ost_cl_floats, ost_cl_floats_count, "", &program, &from_cache, &err);
    if (status == OST_OK)
        status = run_floats(b, program, out, &err);
    if (program)
        b->cl->clReleaseProgram(program);
    if (status == OST_OK)
        status = ost_digest_bytes(out, sizeof out, &digest, &err);
    if (status != OST_OK) {
        snprintf(notes, size, "integers are correct; floats unknown: %.160s", err.text);
        return;
    }
    char loops[64] = "";
    if (b->turns < OST_CL_TURNS)
        snprintf(loops, sizeof loops, ", loops end after %u turns", (unsigned)b->turns);
    ost_digest_hex(&digest, hex);
    snprintf(notes, size,
             "integers are correct%s; floats (no voxel depends on them): a*b+c %s, 1/3 %s, denormals %s, 1e10 to int "
             "0x%x; %.16s",
             loops, out[0] == 0x3a000000 ? "rounded twice" : "fused",
             out[OST_CL_FLOATS + 3] == 0x3eaaaaab ? "correctly rounded" : "inexact",
             out[2 * OST_CL_FLOATS + 7] == 0x00400000 ? "kept" : "flushed", (unsigned)out[3 * OST_CL_FLOATS + 13], hex);
}
