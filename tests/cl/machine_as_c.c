/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A machine (machine.h) that runs the kernels compiled as C. Items are called one after the other. No
 * kernel may rely on the order of items, so the i-th call runs item (i * stride + offset) modulo N, with
 * stride coprime to N. The range is larger than requested, because a device may round it up. Each argument
 * is copied to an allocation of exactly its size, so that the address sanitizer detects every access
 * outside it.
 */
#include "cl/machine.h"

#include "cl/opencl_c.h"

/*
 * The value of OST_ROWS. It is a variable here, so that one build covers all values; on devices
 * it is a build option.
 */
static int test_rows = 4;
#define OST_ROWS test_rows

#include "cl/kernels/common.h"

#include "cl/kernels/chunks.cl"
#include "cl/kernels/chunks_cpu.cl"
#include "cl/kernels/fingerprint.cl"
#include "cl/kernels/import.cl"
#include "cl/kernels/remove.cl"
#include "cl/kernels/remove_cpu.cl"
#include "cl/kernels/voxelize.cl"
#include "cl/kernels/voxelize_cpu.cl"

#define B(i) args[i].data
#define U(i) args[i].number
#define I(i) ((int)args[i].number)

static void call(enum test_kernel kernel, const kernel_arg *args)
{
    switch (kernel) {
    case K_ost_ct_claim: ost_ct_claim(B(0), B(1), B(2), B(3), B(4)); break;
    case K_ost_ct_place: ost_ct_place(B(0), B(1), B(2), B(3), B(4), B(5)); break;
    case K_ost_ct_check: ost_ct_check(B(0), B(1), B(2), B(3), B(4), B(5)); break;
    case K_ost_ct_report_first_bad: ost_ct_report_first_bad(B(0), B(1), B(2), B(3)); break;
    case K_ost_ct_had: ost_ct_had(B(0), B(1), B(2), B(3)); break;
    case K_ost_cubic_sources: ost_cubic_sources(B(0), B(1)); break;
    case K_ost_cubic_gather: ost_cubic_gather(B(0), B(1), B(2), B(3)); break;
    case K_ost_cubic_linear: ost_cubic_linear(B(0), B(1), B(2), B(3)); break;
    case K_ost_chunk_scan: ost_chunk_scan(B(0), I(1), I(2), I(3), I(4), B(5), B(6), B(7)); break;
    case K_ost_chunk_scan_layers: ost_chunk_scan_layers(B(0), I(1), I(2), I(3), I(4), B(5), B(6), B(7)); break;
    case K_ost_chunk_store: ost_chunk_store(B(0), I(1), I(2), I(3), I(4), B(5), B(6), B(7), B(8), B(9)); break;
    case K_ost_chunk_store_layers:
        ost_chunk_store_layers(B(0), I(1), I(2), I(3), I(4), B(5), B(6), B(7), B(8), B(9));
        break;
    case K_ost_chunk_load: ost_chunk_load(B(0), I(1), I(2), B(3), B(4), B(5)); break;
    case K_ost_chunk_load_rows: ost_chunk_load_rows(B(0), I(1), I(2), B(3), B(4), B(5)); break;
    case K_ost_chunk_count: ost_chunk_count(B(0), U(1), U(2), B(3), B(4)); break;
    case K_ost_vox_steps: ost_vox_steps(B(0), B(1), B(2), B(3)); break;
    case K_ost_vox_fill: ost_vox_fill(B(0), B(1), B(2), B(3)); break;
    case K_ost_vox_count: ost_vox_count(B(0), B(1), B(2)); break;
    case K_ost_vox_tiles: ost_vox_tiles(B(0), B(1), B(2), B(3), B(4), B(5), B(6), B(7), B(8)); break;
    case K_ost_tool_reach: ost_tool_reach(B(0), B(1), B(2)); break;
    case K_ost_tool_windows: ost_tool_windows(B(0), B(1), B(2)); break;
    case K_ost_remove: ost_remove(B(0), B(1), B(2), B(3), B(4)); break;
    case K_ost_remove_blocks: ost_remove_blocks(B(0), B(1), B(2), B(3), B(4), B(5)); break;
    case K_ost_fingerprint: ost_fingerprint(U(0), B(1), B(2)); break;
    case K_ost_fingerprint_atomics: ost_fingerprint_atomics(U(0), B(1), B(2)); break;
    case K_ost_fingerprint_turns: ost_fingerprint_turns(U(0), B(1)); break;
    case K_COUNT: break;
    }
}

typedef struct machine_c {
    machine base;
    test_rng rng;
} machine_c;

static uint64_t common_divisor(uint64_t a, uint64_t b)
{
    while (b) {
        const uint64_t r = a % b;
        a = b;
        b = r;
    }
    return a;
}

static void run_items(machine *base, enum test_kernel kernel, const kernel_arg *args, const size_t range[3])
{
    machine_c *m = (machine_c *)base;
    test_rows = base->rows;
    uint64_t size[3], all = 1;
    for (int a = 0; a < 3; a++) {
        /* A dimension of 1 is not extended, because kernels may ignore the index along this dimension. */
        size[a] = range[a] + (uint64_t)(range[a] > 1 ? rng_range(&m->rng, 0, 2) : 0);
        all *= size[a];
    }
    if (all == 0)
        return;
    uint64_t stride, at = (uint64_t)rng_range(&m->rng, 0, (int64_t)all - 1);
    do
        stride = (uint64_t)rng_range(&m->rng, 1, (int64_t)all);
    while (common_divisor(stride, all) != 1);
    for (uint64_t i = 0; i < all; i++) {
        test_item[0] = at % size[0];
        test_item[1] = at / size[0] % size[1];
        test_item[2] = at / size[0] / size[1];
        call(kernel, args);
        at = (at + stride) % all;
    }
}

static void launch(machine *base, enum test_kernel kernel, const kernel_arg *args, unsigned count,
                   const size_t range[3])
{
    enum { ARGS = 12 };
    kernel_arg copies[ARGS];
    assert_true(count <= ARGS);
    for (unsigned i = 0; i < count; i++) {
        copies[i] = args[i];
        if (args[i].bytes == 0)
            continue;
        copies[i].data = malloc(args[i].bytes);
        assert_non_null(copies[i].data);
        memcpy(copies[i].data, args[i].data, args[i].bytes);
    }
    run_items(base, kernel, copies, range);
    for (unsigned i = 0; i < count; i++)
        if (args[i].bytes > 0) {
            /* Inputs are copied back as well, because the kernel must not change them. */
            memcpy(args[i].data, copies[i].data, args[i].bytes);
            free(copies[i].data);
        }
}

machine *machine_as_c(uint64_t seed, int rows)
{
    machine_c *m = calloc(1, sizeof *m);
    assert_non_null(m);
    snprintf(m->base.name, sizeof m->base.name, "kernels as C, %d rows an item", rows);
    m->base.rows = rows;
    m->base.launch = launch;
    m->rng.state = seed;
    return &m->base;
}
