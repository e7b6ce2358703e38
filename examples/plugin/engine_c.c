/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Contains the arithmetic in C in two variants. In one variant, products and sums are rounded separately.
 * In the other variant, every MUL_ADD is rounded once, as if the compiler contracted expressions.
 *
 *   plugin:thesis_f32.so                 contract=off
 *   plugin:thesis_f32.so,contract=on     fmaf
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"

#define FUNCTION static inline
#define GLOBAL
#define FLOOR floorf
#define CEIL ceilf
#define ROUND roundf
#define TIES_TO_EVEN rintf
#define LEAST fminf
#define MOST fmaxf

/* The functions of thesis_f32.cl are included once for each variant, under different names. */
#include "engine_c_names.h"

#define WAY(name) name##_apart
#define MUL_ADD(a, b, c) ((a) * (b) + (c))
#include "thesis_f32.cl"
#undef MUL_ADD
#undef WAY

#define WAY(name) name##_fused
#define MUL_ADD(a, b, c) fmaf(a, b, c)
#include "thesis_f32.cl"
#undef WAY

const char engine_name[] = "thesis-f32";
const char engine_about[] = "the thesis' float arithmetic written out in C";

struct engine {
    int fused;
};

int32_t engine_open(const char *options, engine **out, ost_plugin_error *error)
{
    char contract[8];
    if (!option(options, "contract", contract, sizeof contract) ||
        (contract[0] && strcmp(contract, "on") != 0 && strcmp(contract, "off") != 0) ||
        (options[0] && strncmp(options, "contract=", 9) != 0))
        return plugin_fail(error, OST_PLUGIN_USAGE, "'%.60s': the one option is contract=on or contract=off", options);
    *out = calloc(1, sizeof **out);
    if (!*out)
        return plugin_fail(error, OST_PLUGIN_MEMORY, "no memory");
    (*out)->fused = strcmp(contract, "on") == 0;
    return OST_PLUGIN_OK;
}

void engine_close(engine *e)
{
    free(e);
}

int32_t engine_index(engine *e, const float first_last_size[9], const float *samples, size_t count, thesis_rect *rect,
                     int *index, ost_plugin_error *error)
{
    (void)e; /* `e` selects the contraction, but no operation of this function can be contracted */
    (void)error;
    for (int a = 0; a < 3; a++)
        rect->axis[a] = thesis_rect_axis_apart(first_last_size[3 * a], first_last_size[3 * a + 1],
                                               first_last_size[3 * a + 2]);
    for (size_t s = 0; s < count; s++)
        index[s] = thesis_index_apart(*rect, samples[4 * s], samples[4 * s + 1], samples[4 * s + 2]);
    return OST_PLUGIN_OK;
}

int32_t engine_layers(engine *e, float cubic, float rect, size_t count, int *layer, ost_plugin_error *error)
{
    (void)error;
    for (size_t z = 0; z < count; z++)
        layer[z] = e->fused ? thesis_layer_fused((int)z, cubic, rect) : thesis_layer_apart((int)z, cubic, rect);
    return OST_PLUGIN_OK;
}

int32_t engine_minimum(engine *e, const float least[3], float size, float minimum[3], ost_plugin_error *error)
{
    (void)error;
    for (int a = 0; a < 3; a++)
        minimum[a] = e->fused ? thesis_minimum_fused(least[a], size) : thesis_minimum_apart(least[a], size);
    return OST_PLUGIN_OK;
}

int32_t engine_solid(engine *e, const thesis_grid *grid, const float *corners, int mark, uint8_t *solid,
                     ost_plugin_error *error)
{
    int *count = calloc((size_t)grid->dims[0], sizeof *count);
    if (!count)
        return plugin_fail(error, OST_PLUGIN_MEMORY, "no memory for a row of %d voxels", grid->dims[0]);
    for (int k = 0; k < grid->dims[2]; k++)
        for (int j = 0; j < grid->dims[1]; j++) {
            uint8_t *row = solid + (size_t)grid->dims[0] * ((size_t)j + (size_t)grid->dims[1] * (size_t)k);
            if (e->fused)
                thesis_row_fused(*grid, corners, j, k, mark, count, row);
            else
                thesis_row_apart(*grid, corners, j, k, mark, count, row);
        }
    free(count);
    return OST_PLUGIN_OK;
}

int32_t engine_pose(engine *e, thesis_boxes *x, const uint8_t *tool, uint8_t *marks, ost_plugin_error *error)
{
    (void)error;
    *x = e->fused ? thesis_share_fused(*x) : thesis_share_apart(*x);
    const int n = x->chunk_size, *d = x->bone_dims;
    for (int k = x->chunk_lo[2] * n; k < x->chunk_hi[2] * n && k < d[2]; k++)
        for (int j = x->chunk_lo[1] * n; j < x->chunk_hi[1] * n && j < d[1]; j++)
            for (int i = x->chunk_lo[0] * n; i < x->chunk_hi[0] * n && i < d[0]; i++) {
                uint8_t *mark = marks + (size_t)i + (size_t)d[0] * ((size_t)j + (size_t)d[1] * (size_t)k);
                *mark = e->fused ? thesis_mark_fused(*x, tool, i, j, k, *mark)
                                 : thesis_mark_apart(*x, tool, i, j, k, *mark);
            }
    return OST_PLUGIN_OK;
}
