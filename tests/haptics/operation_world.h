/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A world with a bone and a peg, in which tests run operations.
 */
#ifndef OST_TESTS_OPERATION_WORLD_H
#define OST_TESTS_OPERATION_WORLD_H

#include "ref/scene.h"

#include <osteon/operation.h>

#define MM OST_PM_PER_MM

typedef struct fixture {
    ost_geometry g;
    ost_bone *bone;
    ost_tool *tool;
    ost_world *world;
} fixture;

/* Makes a bone of 40 x 20 x 20 mm with 1 mm voxels and a peg of 2 x 2 x 6 mm. */
static inline fixture make_fixture(ost_backend *backend)
{
    ost_error err = {0};
    fixture r = {.g = cubic_geometry(40, 20, 20, MM, (ost_pm3){0, 0, 0})};
    int16_t *full = malloc(voxel_count(&r.g) * sizeof *full);
    assert_non_null(full);
    for (size_t i = 0; i < voxel_count(&r.g); i++)
        full[i] = (int16_t)(120 + i % 1000);
    r.bone = bone_of(backend, &r.g, 16, full);
    free(full);
    r.tool = solid_tool(backend, (ost_tool_geometry){{4, 4, 12}, 500 * UM, {-MM, -MM, 0}}, OST_TOOL_CUTTING);
    assert_ok(ost_world_create(r.bone, NULL, &r.world, &err));
    assert_ok(ost_world_add_tool(r.world, "peg", r.tool, NULL, &err));
    return r;
}

static inline void free_fixture(fixture *r)
{
    ost_world_free(r->world);
    ost_tool_free(r->tool);
    ost_bone_free(r->bone);
}

#endif
