/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The backend and the scratch folder of the tests that import files as bones, and the volumes that these tests write.
 * Every test runs on all backends of tests/backends.h.
 */
#ifndef OST_TESTS_IMPORT_BONE_H
#define OST_TESTS_IMPORT_BONE_H

#include "backends.h"

#include <osteon/io.h>

#include "io/scratch_group.h"

#include "ct_text.h"

static ost_backend *backend;

static inline int set_up(void **state)
{
    scratch_set_up(state);
    return open_test_backend((void **)&backend);
}

static inline int tear_down(void **state)
{
    ost_backend_close(backend);
    return scratch_tear_down(state);
}

static inline const char *in_folder(const char *name)
{
    static char path[4][600];
    static int next;
    char *to = path[next++ % 4];
    snprintf(to, sizeof path[0], "%s/%s", folder, name);
    return to;
}

static inline ost_volume make_volume(ost_geometry g)
{
    ost_error err = {0};
    ost_volume volume;
    assert_ok(ost_volume_init(&volume, &g, &err));
    int16_t *v = volume.voxels;
    for (int k = 0; k < g.dims.z; k++)
        for (int j = 0; j < g.dims.y; j++)
            for (int i = 0; i < g.dims.x; i++)
                *v++ = (int16_t)ct_density(i, j, k);
    assert_ok(ost_meta_set(&volume.meta, OST_META_KIND, "ct", &err));
    assert_ok(ost_meta_set(&volume.meta, OST_META_SIDE, "left", &err));
    return volume;
}

static inline ost_status import(const char *path, const ost_import_options *options, ost_import_result *result,
                                ost_error *err)
{
    ost_bone *bone;
    ost_status status = ost_import(backend, path, options, &bone, result, err);
    ost_bone_free(bone);
    return status;
}

#endif
