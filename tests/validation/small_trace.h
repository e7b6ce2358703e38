/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Traces of small scenes, in which the tests search for differences.
 */
#ifndef OST_TESTS_SMALL_TRACE_H
#define OST_TESTS_SMALL_TRACE_H

#include "harness.h"

#include <unistd.h>

#include "io/scratch_group.h"
#include "validation/perform.h"

enum { PATH = 4200, SCENES = 3 };

/* Runs the scene on the backend and closes the backend. Opens the trace of the run as *out and removes its file. */
static inline ost_status traced(ost_backend *backend, const scene *s, const char *name, trace *out)
{
    char path[PATH];
    trace_writer *w;
    ost_error why = {0}, err = {0};
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_ok(trace_create(path, &w, &err));
    assert_ok(perform(backend, s, 0, w, NULL, NULL, &why, &err));
    assert_ok(trace_close(w, &err));
    ost_backend_close(backend);
    assert_ok(trace_open(path, out, &err));
    unlink(path);
    return OST_OK;
}

/* Makes the small scene with the given number and seed, and opens the trace of the reference as *ref. */
static inline void traced_small(int number, uint64_t seed, scene *s, trace *ref)
{
    const plan_case c = {.family = PLAN_SMALL,
                         .number = number,
                         .seed = seed,
                         .id = {'s', 'm', 'a', 'l', 'l', '/', (char)('0' + number)}};
    ost_backend *backend;
    ost_error err = {0};
    assert_ok(scene_make(&c, s, &err));
    assert_ok(ost_backend_open("ref", &backend, &err));
    traced(backend, s, "ref", ref);
}

#endif
