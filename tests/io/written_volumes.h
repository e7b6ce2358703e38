/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Helpers for the tests that write volumes, tools and bones. They fill volumes with random densities, parse lengths in
 * mm, and read complete files.
 */
#ifndef OST_TESTS_WRITTEN_VOLUMES_H
#define OST_TESTS_WRITTEN_VOLUMES_H

#include "backends.h"
#include "volume_files.h"

#include "io/volume/input.h"

static inline ost_pm pm(const char *text)
{
    ost_error err = {0};
    ost_pm value;
    assert_ok(ost_pm_parse(text, &value, &err));
    return value;
}

static inline void make_volume(ost_volume *v, const ost_geometry *g, test_rng *rng)
{
    ost_error err = {0};
    assert_ok(ost_volume_init(v, g, &err));
    for (int64_t i = 0; i < ost_dims_count(g->dims); i++)
        v->voxels[i] = (int16_t)rng_range(rng, -32768, 32767);
}

static inline char *read_all(const char *path, size_t *size)
{
    ost_error err = {0};
    ost_input *input;
    assert_ok(ost_input_open(path, &input, &err));
    char *data = malloc((size_t)ost_input_file_bytes(input) + 1);
    assert_non_null(data);
    assert_ok(ost_input_read(input, data, (size_t)ost_input_file_bytes(input), size, &err));
    data[*size] = 0;
    ost_input_close(input);
    return data;
}

#endif
