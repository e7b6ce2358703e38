/* SPDX-License-Identifier: Apache-2.0 */
/* Sets of bone voxels in a box, and the differences between two sets. */
#include "reproduction/methods/method.h"

#include <stdlib.h>

size_t method_box_count(const ost_voxel_box *box)
{
    size_t count = 1;
    for (int a = 0; a < 3; a++)
        count *= box->lo[a] < box->hi[a] ? (size_t)(box->hi[a] - box->lo[a]) : 0;
    return count;
}

ost_status method_set_init(method_set *set, const ost_voxel_box *box, ost_error *err)
{
    const size_t count = method_box_count(box);
    *set = (method_set){.box = *box, .in = calloc(count + 1, 1)};
    return set->in ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a set of %zu voxels", count);
}

void method_set_free(method_set *set)
{
    free(set->in);
    *set = (method_set){.in = NULL};
}

size_t method_set_row(const method_set *set, int32_t j, int32_t k)
{
    const ost_voxel_box *b = &set->box;
    return (size_t)(b->hi[0] - b->lo[0]) *
           ((size_t)(j - b->lo[1]) + (size_t)(b->hi[1] - b->lo[1]) * (size_t)(k - b->lo[2]));
}

void method_set_add_removed(method_set *set, const methods_scene *scene, const int16_t *voxels)
{
    const ost_voxel_box *b = &set->box;
    const ost_dims d = scene->event.bone.dims;
    if (method_box_count(b) == 0)
        return;
    for (int32_t k = b->lo[2]; k < b->hi[2]; k++)
        for (int32_t j = b->lo[1]; j < b->hi[1]; j++) {
            const size_t at = method_set_row(set, j, k);
            const int16_t *row = scene->voxels + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k) + b->lo[0];
            for (size_t i = 0; i < (size_t)(b->hi[0] - b->lo[0]); i++)
                if (row[i] != 0 && voxels[at + i] == 0)
                    set->in[at + i] = 1;
        }
}

bool method_set_inside(const method_set *set, size_t index)
{
    const ost_voxel_box *b = &set->box;
    const size_t size[3] = {(size_t)(b->hi[0] - b->lo[0]), (size_t)(b->hi[1] - b->lo[1]),
                            (size_t)(b->hi[2] - b->lo[2])};
    const size_t position[3] = {index % size[0], index / size[0] % size[1], index / size[0] / size[1]};
    const size_t stride[3] = {1, size[0], size[0] * size[1]};
    if (!set->in[index])
        return false;
    for (int a = 0; a < 3; a++)
        if (position[a] == 0 || position[a] + 1 == size[a] || !set->in[index - stride[a]] ||
            !set->in[index + stride[a]])
            return false;
    return true;
}

void method_set_compare(const method_set *expected, const method_set *set, method_difference *out)
{
    const size_t count = method_box_count(&expected->box);
    *out = (method_difference){0};
    for (size_t v = 0; v < count; v++) {
        out->expected += expected->in[v];
        out->removed += set->in[v];
        out->extra += set->in[v] && !expected->in[v];
        if (!expected->in[v] || set->in[v])
            continue;
        out->missed++;
        out->missed_inside += method_set_inside(expected, v);
    }
}
