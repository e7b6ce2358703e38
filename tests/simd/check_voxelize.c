/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels vox_mark and vox_keys with triangles of every kind in tiles.
 *
 * A mesh need not be closed, because a kernel marks each triangle separately. The kinds of triangles are:
 *
 *   - small triangles and slivers
 *   - triangles with corners and edges on the centres of rows
 *   - triangles across the entire grid
 *   - triangles at the upper end of the grid along x
 *   - triangles with the largest extents that vector lanes allow
 *   - flat triangles
 *
 * A crossing at the upper end of the grid along x has no bit and is written to the spill list. A crossing
 * whose bit is already set in the plane is written to this list, too.
 */
#include <stdlib.h>
#include <string.h>

#include "cpu/kernels.h"
#include "cpu/voxelize/voxelize.h"
#include "simd/check.h"

static int32_t least32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* ----------------------------------------------------------------- a mesh */

static int32_t within(int64_t v, int32_t end)
{
    return (int32_t)(v < 0 ? 0 : v > end ? end : v);
}

/*
 * Makes a triangle whose extents ex, ey and ez are the largest that vector lanes allow, or one unit larger.
 * The limit is (ex + w) ey ez <= OST_VOX_SMALL, where w is the width of a voxel.
 */
static void corners_at_the_limit(check *c, int f, const int32_t end[3], int32_t (*corner)[3])
{
    const int64_t y = check_range(c, end[1] / 2, end[1]), z = check_range(c, end[2] / 2, end[2]);
    const int32_t x = within(OST_VOX_SMALL / (y * z) - (1 << f) + check_range(c, 0, 1), end[0]);
    const int32_t size[3] = {x, (int32_t)y, (int32_t)z};
    for (int a = 0; a < 3; a++) {
        const int32_t at = (int32_t)check_range(c, 0, end[a] - size[a]);
        const int first = (int)check_range(c, 0, 2);
        for (int i = 0; i < 3; i++)
            corner[(first + i) % 3][a] = at + (i == 0 ? 0 : i == 1 ? size[a] : (int32_t)check_range(c, 0, size[a]));
    }
}

/* Makes the corners of one triangle. On each axis a, their coordinates are in [0, end[a]]. */
static void some_corners(check *c, int f, const int32_t end[3], int32_t (*corner)[3])
{
    const int32_t w = 1 << f;
    const int kind = (int)check_range(c, 0, 7);
    int64_t size = (int64_t)w * check_range(c, 1, 6);
    int32_t at[3];
    for (int a = 0; a < 3; a++)
        at[a] = (int32_t)check_range(c, 0, end[a]);
    if (kind == 3) /* a triangle across the entire grid */
        size = end[0] > end[1] ? end[0] : end[1];
    if (kind == 4) {
        corners_at_the_limit(c, f, end, corner);
        return;
    }
    if (kind == 5)
        at[0] = end[0];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            int64_t v = at[a] + check_range(c, -size, size);
            if (kind == 2) /* on the lattice of the rows' centres, or one unit away from this lattice */
                v = v / w * w + w / 2 + (check_chance(c, 8) ? check_range(c, -1, 1) : 0);
            corner[i][a] = within(v, end[a]);
        }
    if (kind == 6) /* a sliver */
        for (int a = 0; a < 3; a++)
            corner[2][a] = within(corner[check_range(c, 0, 1)][a] + check_range(c, -1, 1), end[a]);
    if (kind == 7) { /* a triangle that is flat along an axis */
        const int64_t a = check_range(c, 0, 2);
        corner[1][a] = corner[2][a] = corner[0][a];
    }
}

static void some_mesh(check *c, int f, ost_dims dims, size_t triangles, ost_snapped_mesh *out)
{
    const int32_t end[3] = {dims.x << f, dims.y << f, dims.z << f};
    const size_t vertices = 3 * triangles;
    int32_t (*vertex)[3] = check_input(c, "mesh->vertices", vertices, sizeof *vertex, sizeof(int32_t));
    uint32_t (*triangle)[3] = check_input(c, "mesh->triangles", triangles, sizeof *triangle, sizeof(uint32_t));
    for (size_t t = 0; t < triangles; t++) {
        some_corners(c, f, end, &vertex[3 * t]);
        for (uint32_t i = 0; i < 3; i++)
            triangle[t][i] = (uint32_t)(3 * t) + i;
        /* The triangle shares vertices with earlier triangles, or is the previous triangle in reverse order. */
        if (t > 0 && check_chance(c, 6))
            for (uint32_t i = 0; i < 3; i++)
                triangle[t][i] = check_chance(c, 2) ? (uint32_t)check_range(c, 0, (int64_t)(3 * t) + 2)
                                                    : triangle[t - 1][2 - i];
    }
    *out = (ost_snapped_mesh){.grid = {.dims = dims},
                              .fraction_bits = f,
                              .vertex_count = vertices,
                              .vertices = vertex,
                              .triangle_count = triangles,
                              .triangles = triangle};
}

static ost_dims some_dims(check *c, int f, int32_t most)
{
    const int32_t limit = least32((1 << 20) >> f, OST_TOOL_DIM_MAX);
    ost_dims d = {(int32_t)check_range(c, 1, least32(limit, check_chance(c, 4) ? 700 : most)),
                  (int32_t)check_range(c, 1, least32(limit, most)), (int32_t)check_range(c, 1, least32(limit, most))};
    if (check_chance(c, 16))
        d = (ost_dims){limit, least32(limit, 3), least32(limit, 2)};
    return d;
}

/* ----------------------------------------------------------------- vox_mark */

typedef struct mark_arguments {
    ost_vox_tile tile;
    const uint32_t *list;
    size_t count;
} mark_arguments;

static void call_mark(check_fn *kernel, void *with)
{
    mark_arguments *a = with;
    ((ost_vox_mark_fn *)kernel)(&a->tile, a->list, a->count);
}

/* Chooses a part [lo, hi) of [from, to), often the complete range. */
static void some_part(check *c, int32_t from, int32_t to, int32_t *lo, int32_t *hi)
{
    *lo = from;
    *hi = to;
    if (check_chance(c, 2)) {
        *lo = (int32_t)check_range(c, from, to - 1);
        *hi = (int32_t)check_range(c, *lo + 1, to);
    }
}

static void compare_tiles(check *c, const ost_vox_tile *expected, const ost_vox_tile *got, size_t plane_words)
{
    const size_t rows = ost_vox_rows(expected), stride = (size_t)expected->nx + 1;
    check_same(c, "planes", CHECK_BITS, expected->planes, got->planes, 2 * plane_words);
    check_same(c, "row_state", CHECK_U8, expected->row_state, got->row_state, rows);
    check_that(c, expected->any_unproven == got->any_unproven, "any_unproven is %d, expected %d", got->any_unproven,
               expected->any_unproven);
    for (size_t r = 0; r < rows && c->result == CHECK_GOOD; r++)
        if (expected->row_state[r] & OST_VOX_SPILLED)
            check_same(c, "spill of a row", CHECK_I32, expected->spill + r * stride, got->spill + r * stride, stride);
}

static void test_mark(check *c)
{
    const int f = check_chance(c, 2) ? 10 : (int)check_range(c, 1, 10);
    const ost_dims dims = some_dims(c, f, check_chance(c, 6) ? 100 : 24);
    const size_t triangles = check_chance(c, 2) ? (size_t)check_range(c, 1, 20) : (size_t)check_range(c, 1, 60);
    ost_snapped_mesh mesh;
    some_mesh(c, f, dims, triangles, &mesh);
    uint32_t *list = NULL;
    size_t count = triangles;
    if (check_chance(c, 2)) {
        count = (size_t)check_range(c, 0, (int64_t)triangles);
        list = check_input(c, "list", count, sizeof *list, sizeof *list);
        for (size_t i = 0; i < count; i++)
            list[i] = (uint32_t)check_range(c, 0, (int64_t)triangles - 1);
    }
    ost_vox_tile tile = {.mesh = &mesh, .f = f, .nx = dims.x};
    some_part(c, 0, dims.y, &tile.j0, &tile.j1);
    some_part(c, 0, dims.z, &tile.k0, &tile.k1);
    const size_t rows = ost_vox_rows(&tile), words = (size_t)ost_vox_words(dims.x);
    const size_t plane_words = (rows * words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK;
    tile.row_bits = 64 * (uint32_t)words;
    tile.minus = 64 * (uint32_t)plane_words;
    void *planes[2], *row_state[2];
    check_outputs(c, "planes", 2 * plane_words, sizeof(uint64_t), 64, planes);
    check_outputs(c, "row_state", rows, 1, 1, row_state);
    memset(planes[0], 0, 16 * plane_words);
    if (check_chance(c, 3)) /* These bits represent the marks of earlier triangles. */
        for (size_t w = 0; w < 2 * plane_words; w++)
            if (w % plane_words < rows * words) {
                const int64_t bits = dims.x - (int64_t)(w % plane_words % words) * 64;
                ((uint64_t *)planes[0])[w] = rng_next(&c->rng) & rng_next(&c->rng) &
                                             (bits >= 64 ? UINT64_MAX
                                              : bits > 0 ? (UINT64_C(1) << bits) - 1
                                                         : 0);
            }
    memcpy(planes[1], planes[0], 16 * plane_words);
    mark_arguments a[2];
    for (int i = 0; i < 2; i++) {
        memset(row_state[i], 0, rows);
        a[i] = (mark_arguments){tile, list, count};
        a[i].tile.planes = planes[i];
        a[i].tile.row_state = row_state[i];
    }
    check_note(c, "%zu of %zu triangles%s, grid %d x %d x %d, f %d, tile %d..%d, %d..%d", count, triangles,
               list ? " by list" : "", dims.x, dims.y, dims.z, f, tile.j0, tile.j1, tile.k0, tile.k1);
    if (check_both(c, call_mark, &a[0], &a[1]))
        compare_tiles(c, &a[0].tile, &a[1].tile, plane_words);
    free(a[0].tile.spill);
    free(a[1].tile.spill);
}

/* ----------------------------------------------------------------- vox_keys */

typedef struct keys_arguments {
    const ost_vox_plan *plan;
    const ost_snapped_mesh *mesh;
    size_t first, count;
    uint32_t *keys;
} keys_arguments;

static void call_keys(check_fn *kernel, void *with)
{
    const keys_arguments *a = with;
    ((ost_vox_keys_fn *)kernel)(a->plan, a->mesh, a->first, a->count, a->keys);
}

static void test_keys(check *c)
{
    const int f = (int)check_range(c, 1, 10);
    const ost_dims dims = some_dims(c, f, 200);
    const size_t triangles = (size_t)check_range(c, 1, 60);
    ost_snapped_mesh mesh;
    some_mesh(c, f, dims, triangles, &mesh);
    ost_vox_plan plan = {.dims = dims, .f = f, .words = ost_vox_words(dims.x)};
    plan.shift_y = (int32_t)check_range(c, 0, 8);
    plan.shift_z = (int32_t)check_range(c, 0, 8);
    plan.tiles_y = (dims.y + (1 << plan.shift_y) - 1) >> plan.shift_y;
    plan.tiles_z = (dims.z + (1 << plan.shift_z) - 1) >> plan.shift_z;
    const size_t first = (size_t)check_range(c, 0, (int64_t)triangles);
    const size_t count = check_chance(c, 2) ? triangles - first
                                            : (size_t)check_range(c, 0, (int64_t)(triangles - first));
    void *keys[2];
    check_outputs(c, "keys", count, sizeof(uint32_t), sizeof(uint32_t), keys);
    check_note(c, "triangles %zu to %zu of %zu, grid %d x %d x %d, f %d, tiles of 2^%d x 2^%d", first, first + count,
               triangles, dims.x, dims.y, dims.z, f, plan.shift_y, plan.shift_z);
    keys_arguments a = {&plan, &mesh, first, count, keys[0]}, b = {&plan, &mesh, first, count, keys[1]};
    if (check_both(c, call_keys, &a, &b))
        check_same(c, "keys", CHECK_U32, keys[0], keys[1], count);
}

/* -------------------------------------------------------------------- bench */

enum { SIDE = 128, F = 10, ACROSS = 96 };

/* Makes a wavy surface of 2 ACROSS^2 triangles. */
static void sheet(ost_snapped_mesh *out)
{
    static int32_t vertices[(ACROSS + 1) * (ACROSS + 1)][3];
    static uint32_t triangles[2 * ACROSS * ACROSS][3];
    size_t v = 0, t = 0;
    for (int32_t z = 0; z <= ACROSS; z++)
        for (int32_t y = 0; y <= ACROSS; y++, v++) {
            vertices[v][0] = (SIDE << F) / 2 + (y * z * 37 % 4001) - 2000;
            vertices[v][1] = (int32_t)((int64_t)y * (SIDE << F) / ACROSS);
            vertices[v][2] = (int32_t)((int64_t)z * (SIDE << F) / ACROSS);
        }
    for (uint32_t z = 0; z < ACROSS; z++)
        for (uint32_t y = 0; y < ACROSS; y++) {
            const uint32_t a = y + (ACROSS + 1) * z, b = a + 1, c = a + ACROSS + 1, d = c + 1;
            memcpy(triangles[t++], (uint32_t[3]){a, b, c}, sizeof triangles[0]);
            memcpy(triangles[t++], (uint32_t[3]){b, d, c}, sizeof triangles[0]);
        }
    *out = (ost_snapped_mesh){.grid = {.dims = {SIDE, SIDE, SIDE}},
                              .fraction_bits = F,
                              .vertex_count = v,
                              .vertices = vertices,
                              .triangle_count = t,
                              .triangles = triangles};
}

static void clear_planes(void *with)
{
    const ost_vox_tile *tile = &((const mark_arguments *)with)->tile;
    memset(tile->planes, 0, tile->minus / 4);
}

static void bench_mark(check_bench *b)
{
    static _Alignas(64) uint64_t planes[2 * SIDE * SIDE * 2];
    static uint8_t row_state[SIDE * SIDE];
    ost_snapped_mesh mesh;
    sheet(&mesh);
    mark_arguments a = {
        .tile =
            {.mesh = &mesh, .f = F, .nx = SIDE, .j1 = SIDE, .k1 = SIDE, .row_bits = 128, .minus = 128 * SIDE * SIDE},
        .count = mesh.triangle_count};
    a.tile.planes = planes;
    a.tile.row_state = row_state;
    bench_time(b, "18432 triangles of two rows' size", call_mark, clear_planes, &a, (double)mesh.triangle_count,
               "triangle");
    free(a.tile.spill);
}

static void bench_keys(check_bench *b)
{
    static uint32_t keys[2 * ACROSS * ACROSS];
    ost_snapped_mesh mesh;
    sheet(&mesh);
    const ost_vox_plan plan = {.dims = mesh.grid.dims,
                               .f = F,
                               .words = 2,
                               .shift_y = 5,
                               .shift_z = 5,
                               .tiles_y = SIDE / 32,
                               .tiles_z = SIDE / 32};
    keys_arguments a = {&plan, &mesh, 0, mesh.triangle_count, keys};
    bench_time(b, "18432 triangles, 16 tiles", call_keys, NULL, &a, (double)mesh.triangle_count, "triangle");
}

CHECK_CPU_SLOT(vox_mark)
CHECK_CPU_SLOT(vox_keys)
extern const check_kernel check_vox_mark, check_vox_keys;
const check_kernel check_vox_mark = {
    .name = "vox_mark", .of = vox_mark_of, .test = test_mark, .bench = bench_mark, .cases = 1500};
const check_kernel check_vox_keys = {
    .name = "vox_keys", .of = vox_keys_of, .test = test_keys, .bench = bench_keys, .cases = 600};
