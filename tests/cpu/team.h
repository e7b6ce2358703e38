/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Functions that open the reference and the CPU backend with every instruction set of this machine and with
 * several thread counts, and functions that generate tools of several shapes. The CPU backends divide events
 * of any size among their threads.
 */
#ifndef OST_TESTS_CPU_TEAM_H
#define OST_TESTS_CPU_TEAM_H

#include "ref/scene.h"

#include "core/isa.h"
#include "cpu/cpu.h"

/* ------------------------------------------------------------- backends */

enum { BACKENDS_MAX = 20, THREADS = 4 };
typedef struct team {
    ost_backend *ref;
    ost_backend *cpu[BACKENDS_MAX];
    char name[BACKENDS_MAX][40];
    int count;
} team;

static inline int open_team(void **state)
{
    team *t = calloc(1, sizeof *t);
    if (!t || ost_backend_open("ref", &t->ref, NULL) != OST_OK)
        return 1;
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        for (int i = 0; i < THREADS && ost_isa_available((ost_isa)isa); i++) {
            static const int threads[THREADS] = {1, 2, 3, 7};
            snprintf(t->name[t->count], sizeof t->name[0], "cpu:isa=%s,threads=%d", ost_isa_name((ost_isa)isa),
                     threads[i]);
            if (ost_backend_open(t->name[t->count], &t->cpu[t->count], NULL) != OST_OK)
                return 1;
            ((cpu_backend *)t->cpu[t->count])->sharing->least[OST_PATH_REMOVAL] = 0;
            t->count++;
        }
    *state = t;
    return 0;
}

/*
 * Returns true if backend i is tested in the round `turn`. Each round tests every instruction set
 * with one thread count; with OST_TEST_LONG=1, each round tests all backends.
 */
static inline bool has_turn(int i, int turn)
{
    const char *lengthy = getenv("OST_TEST_LONG");
    return (lengthy && strcmp(lengthy, "1") == 0) || i % THREADS == turn % THREADS;
}

static inline int close_team(void **state)
{
    team *t = *state;
    for (int i = 0; i < t->count; i++)
        ost_backend_close(t->cpu[i]);
    ost_backend_close(t->ref);
    free(t);
    return 0;
}

/* ---------------------------------------------------------------- scenes */

typedef enum form { HEMISPHERE, PEG, TOOTHED_SHELL, PLATE, NOISE, SOLID, EMPTY, FORMS } form;

static inline uint8_t form_at(form f, test_rng *rng, const int32_t d[3], int32_t x, int32_t y, int32_t z)
{
    /* Distances from the centre are doubled, so that they are integers. */
    const int64_t cx = 2 * x + 1 - d[0], cy = 2 * y + 1 - d[1], r = d[0] < d[1] ? d[0] : d[1];
    const int64_t flat = cx * cx + cy * cy, high = 2 * z + 1;
    switch (f) {
    case HEMISPHERE:
        return flat + high * high <= r * r ? OST_TOOL_CUTTING : OST_TOOL_VOID;
    case PEG:
        return flat <= r * r / 9 ? (z < d[2] / 2 ? OST_TOOL_CUTTING : OST_TOOL_NONCUTTING) : OST_TOOL_VOID;
    case TOOTHED_SHELL: {
        const int64_t all = flat + high * high;
        if (all > r * r)
            return OST_TOOL_VOID;
        if (all < (r - 6) * (r - 6))
            return OST_TOOL_NONCUTTING;
        return (x / 2 + y / 3 + z) % 3 ? OST_TOOL_CUTTING : OST_TOOL_VOID;
    }
    case PLATE:
        return z == d[2] / 2 ? OST_TOOL_CUTTING : OST_TOOL_VOID;
    case NOISE:
        return (uint8_t)(rng_range(rng, 0, 9) < 5 ? 1 : rng_range(rng, 0, 2) == 2 ? 2 : 0);
    case SOLID:
        return OST_TOOL_CUTTING;
    case EMPTY:
    case FORMS:
        break;
    }
    return OST_TOOL_VOID;
}

static inline ost_tool_volume random_form(test_rng *rng, ost_pm voxel, int32_t dim_max)
{
    ost_error err = {0};
    ost_tool_volume volume;
    const form f = (form)rng_range(rng, 0, FORMS - 1);
    int32_t d[3];
    for (int a = 0; a < 3; a++)
        d[a] = (int32_t)rng_range(rng, 1, dim_max);
    if (f <= TOOTHED_SHELL)
        d[0] = d[1] = d[2] = (int32_t)rng_range(rng, dim_max / 3 + 1, dim_max);
    const ost_pm3 corner = {-voxel * d[0] / 2, -voxel * d[1] / 2, rng_range(rng, 0, 1) ? 0 : -voxel * d[2] / 2};
    assert_ok(ost_tool_volume_init(&volume, &(ost_tool_geometry){{d[0], d[1], d[2]}, voxel, corner}, &err));
    uint8_t *v = volume.voxels;
    for (int32_t z = 0; z < d[2]; z++)
        for (int32_t y = 0; y < d[1]; y++)
            for (int32_t x = 0; x < d[0]; x++)
                *v++ = form_at(f, rng, d, x, y, z);
    return volume;
}

#endif
