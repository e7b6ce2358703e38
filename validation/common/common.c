/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/common/common.h"

#include "validation/common/lab.h"

/* Lists the checks that an installed program cannot perform. They are performed by `make check` in the source tree. */
static json_t *by_the_tests(void)
{
    static const struct {
        const char *what, *tests;
    } list[] = {
        {"an independent implementation of docs/spec/arithmetic.md in Python with exact fractions: import, tools, "
         "paths, sweeps, maps and removal, voxel by voxel",
         "tests/oracle/check_pipeline.py tests/oracle/check_events.py"},
        {"the numbers of the thesis, computed again", "tests/oracle/check_thesis.py"},
        {"readers of CTs, meshes and paths, on files with known content and on damaged files",
         "tests/io tests/mesh tests/fuzz"},
        {"mirrors, quarter turns and permutations of axes", "tests/ref/test_remove.c"},
    };
    json_t *rows = json_array();
    for (size_t i = 0; i < sizeof list / sizeof list[0]; i++)
        json_array_append_new(rows, json_pack("{s:s,s:s}", "what", list[i].what, "tests", list[i].tests));
    return rows;
}

ost_status common_check(uint64_t seed, json_t **out, ost_error *err)
{
    lab l = {.checks = json_array(), .seed = seed, .err = err};
    json_int_t passed = 0;
    *out = NULL;
    l.status = ost_backend_open("ref", &l.backend, err);
    if (l.status == OST_OK) {
        lab_golden(&l);
        lab_volumes(&l);
        lab_relations(&l);
    }
    ost_backend_close(l.backend);
    for (size_t i = 0; i < json_array_size(l.checks); i++)
        passed += json_is_true(json_object_get(json_array_get(l.checks, i), "passed"));
    if (l.status == OST_OK) {
        *out = json_pack("{s:I,s:I,s:s,s:O,s:o}", "passed", passed, "failed",
                         (json_int_t)json_array_size(l.checks) - passed, "on",
                         "the scalar reference; the cases show which backends are equal to it", "checks", l.checks,
                         "by_the_tests", by_the_tests());
        if (!*out)
            l.status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the checks");
    }
    json_decref(l.checks);
    return l.status;
}

bool common_proved(const json_t *common)
{
    return json_integer_value(json_object_get(common, "passed")) > 0 &&
           json_integer_value(json_object_get(common, "failed")) == 0;
}
