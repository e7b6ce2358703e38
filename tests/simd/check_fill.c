/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels vox_fill and vox_expand, which convert crossings to solid bits and solid bits to
 * classes.
 *
 * The contract of vox_fill leaves a choice: a variant may report all rows of a block as unproven if one row
 * is unproven, or if the first crossing enters the mesh in some rows and leaves it in others. The bits of
 * unproven rows are unspecified and not counted. Therefore bits are compared only in rows that both the
 * scalar function and the variant report as proven. After ost_vox_fill_unproven has filled the unproven rows,
 * the bits of all rows must be equal.
 */
#include <string.h>

#include "cpu/kernels.h"
#include "cpu/voxelize/voxelize.h"
#include "simd/check.h"

/* ----------------------------------------------------------------- vox_fill */

typedef struct fill_arguments {
    ost_vox_tile tile;
    size_t first_row, rows;
    uint64_t *bits;
    uint64_t count;
} fill_arguments;

static void call_fill(check_fn *kernel, void *with)
{
    fill_arguments *a = with;
    a->count = ((ost_vox_fill_fn *)kernel)(&a->tile, a->first_row, a->rows, a->bits);
}

/*
 * Makes the crossings of one row. The values of `kind` are:
 *
 *   0  no crossings
 *   1  crossings that alternately enter and leave the mesh
 *   2  as 1, but the last crossing may be missing, as in an open mesh
 *   3  random crossings
 *   4  a crossing at every centre
 *   5  crossings with both signs at the same centre
 *
 * If the mesh is inside out, the caller exchanges the planes.
 */
static void some_row(check *c, int32_t nx, int kind, uint64_t *plus, uint64_t *minus)
{
    bool inside = false;
    const int64_t rare = kind == 4 ? 1 : check_range(c, 2, 40);
    for (int32_t i = 0; i < nx && kind > 0; i++) {
        if (rng_next(&c->rng) % (uint64_t)rare != 0)
            continue;
        const uint64_t bit = UINT64_C(1) << (i % 64);
        if (kind == 5) {
            plus[i / 64] |= bit;
            minus[i / 64] |= bit;
        } else if (kind == 3 ? check_chance(c, 2) : !inside) {
            plus[i / 64] |= bit;
        } else {
            minus[i / 64] |= bit;
        }
        inside = !inside;
    }
    if (kind == 1 && inside) { /* The row must end outside the mesh. */
        const uint64_t bit = UINT64_C(1) << ((nx - 1) % 64);
        /* If the row enters the mesh at its last centre, this crossing is removed; otherwise, the row leaves there. */
        if (plus[(nx - 1) / 64] & bit)
            plus[(nx - 1) / 64] &= ~bit;
        else
            minus[(nx - 1) / 64] |= bit;
    }
}

/* Returns the number of set bits in the proven rows. */
static uint64_t bits_set(const fill_arguments *a, size_t words)
{
    uint64_t n = 0;
    for (size_t i = 0; i < a->rows * words; i++)
        if (!(a->tile.row_state[a->first_row + i / words] & OST_VOX_UNPROVEN))
            n += (uint64_t)__builtin_popcountll(a->bits[i]);
    return n;
}

/*
 * For a row whose crossings alternate, returns 1 if the first crossing enters the mesh, 2 if it leaves the
 * mesh, and 0 if there is no crossing.
 */
static unsigned first_crossing(const uint64_t *plus, const uint64_t *minus, size_t words)
{
    for (size_t w = 0; w < words; w++) {
        const uint64_t x = plus[w] ^ minus[w];
        if (x)
            return plus[w] & x & -x ? 1 : 2;
    }
    return 0;
}

/*
 * Returns true if the block that contains this row may be reported as unproven. This is allowed if a row of
 * the block is unproven, or if the first crossing enters the mesh in some rows and leaves it in others.
 */
static bool block_is_open(const ost_vox_tile *tile, size_t first_row, size_t rows, size_t row, const uint64_t *before,
                          size_t plane_words)
{
    const size_t words = tile->row_bits / 64, in_block = words < OST_VOX_BLOCK ? OST_VOX_BLOCK / words : 1;
    const size_t begin = first_row + (row - first_row) / in_block * in_block;
    unsigned first = 0;
    for (size_t r = begin; r < begin + in_block && r < first_row + rows; r++) {
        if (tile->row_state[r] & OST_VOX_UNPROVEN)
            return true;
        first |= first_crossing(before + r * words, before + plane_words + r * words, words);
    }
    return first == 3;
}

static void check_rows(check *c, fill_arguments a[2], uint64_t *const before, size_t plane_words, size_t words,
                       bool keep)
{
    const size_t all = ost_vox_rows(&a[0].tile), first = a[0].first_row, rows = a[0].rows;
    for (int i = 0; i < 2; i++)
        check_that(c, a[i].count == bits_set(&a[i], words), "%s returns %llu, but sets %llu bits in proven rows",
                   i == 0 ? "the scalar kernel" : "the kernel", (unsigned long long)a[i].count,
                   (unsigned long long)bits_set(&a[i], words));
    for (size_t r = 0; r < all && c->result == CHECK_GOOD; r++) {
        const bool mine = r >= first && r < first + rows;
        const bool open = a[1].tile.row_state[r] & OST_VOX_UNPROVEN;
        if (!mine)
            check_that(c, a[0].tile.row_state[r] == a[1].tile.row_state[r],
                       "the kernel changes the state of row %zu, which it must not process", r);
        else if (a[0].tile.row_state[r] & OST_VOX_UNPROVEN)
            check_that(c, open, "the kernel reports row %zu as proven, but it is unproven", r);
        else if (open)
            check_that(c, block_is_open(&a[0].tile, first, rows, r, before, plane_words),
                       "the kernel reports row %zu as unproven, but all rows of its block are proven", r);
        else
            check_same(c, "bits of a proven row", CHECK_BITS, a[0].bits + (r - first) * words,
                       a[1].bits + (r - first) * words, words);
        check_that(c, (a[0].tile.row_state[r] | OST_VOX_UNPROVEN) == (a[1].tile.row_state[r] | OST_VOX_UNPROVEN),
                   "the kernel changes the state of row %zu to %d", r, a[1].tile.row_state[r]);
        for (size_t plane = 0; plane < 2 && c->result == CHECK_GOOD; plane++) {
            const uint64_t *was = before + plane * plane_words + r * words,
                           *is = a[1].tile.planes + plane * plane_words + r * words;
            static const uint64_t zeros[OST_TOOL_DIM_MAX / 64];
            check_same(c, mine && !open && !keep ? "planes of a row to be cleared" : "planes of a row to be kept",
                       CHECK_BITS, mine && !open && !keep ? zeros : was, is, words);
        }
    }
    bool any = keep;
    for (size_t r = first; r < first + rows; r++)
        any = any || (a[1].tile.row_state[r] & OST_VOX_UNPROVEN);
    check_that(c, a[1].tile.any_unproven == any, "any_unproven is %d", a[1].tile.any_unproven);
}

static void test_fill(check *c)
{
    static const int32_t widths[] = {1,   2,   63,  64,  65,  127,  128,  129,  200,  255,
                                     256, 257, 500, 512, 513, 1000, 1024, 1537, 4095, 4096};
    const int32_t nx = check_chance(c, 2) ? widths[check_range(c, 0, 19)] : (int32_t)check_range(c, 1, 300);
    const size_t words = (size_t)ost_vox_words(nx), in_block = words < OST_VOX_BLOCK ? OST_VOX_BLOCK / words : 1;
    const size_t all = (size_t)check_range(c, 1, words > 16 ? 5 : 40);
    const size_t plane_words = (all * words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK;
    /* The range begins at a block's first row and ends at the end of a block or of the tile. */
    size_t first = check_chance(c, 2) ? 0 : (size_t)check_range(c, 0, (int64_t)all - 1) / in_block * in_block,
           rows = all - first;
    if (check_chance(c, 2) && rows > in_block)
        rows = (size_t)check_range(c, 1, (int64_t)(rows / in_block)) * in_block;
    const bool keep = check_chance(c, 4), parity = check_chance(c, 2), inside_out = check_chance(c, 3);

    void *planes[2], *row_state[2], *bits[2];
    check_outputs(c, "planes", 2 * plane_words, sizeof(uint64_t), 64, planes);
    check_outputs(c, "row_state", all, 1, 1, row_state);
    check_outputs(c, "bits", (rows * words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK, sizeof(uint64_t), 64,
                  bits);
    uint64_t *before = check_input(c, "planes before", 2 * plane_words, sizeof *before, sizeof *before);
    int32_t *spill = check_input(c, "spill", all * ((size_t)nx + 1), sizeof *spill, sizeof *spill);
    memset(before, 0, 2 * plane_words * sizeof *before);
    memset(spill, 0, all * ((size_t)nx + 1) * sizeof *spill);
    memset(row_state[0], 0, all);
    /* If one_kind is below 6, all rows are of this kind; otherwise, each row has its own kind. */
    const int one_kind = (int)check_range(c, 0, 12);
    for (size_t r = 0; r < all; r++) {
        const int kind = one_kind < 6 ? one_kind : check_chance(c, 4) ? (int)check_range(c, 0, 5) : one_kind % 2;
        const bool swap = inside_out != check_chance(c, 8);
        some_row(c, nx, kind, before + (swap ? plane_words : 0) + r * words,
                 before + (swap ? 0 : plane_words) + r * words);
        if (keep && check_chance(c, 3)) {
            ((uint8_t *)row_state[0])[r] = OST_VOX_SPILLED;
            spill[r * ((size_t)nx + 1) + (size_t)check_range(c, 0, nx)] = (int32_t)check_range(c, -2, 2);
        }
    }
    memcpy(row_state[1], row_state[0], all);
    fill_arguments a[2];
    for (int i = 0; i < 2; i++) {
        memcpy(planes[i], before, 2 * plane_words * sizeof *before);
        a[i] = (fill_arguments){.tile = {.nx = nx,
                                         .j1 = (int32_t)all,
                                         .k1 = 1,
                                         .row_bits = 64 * (uint32_t)words,
                                         .minus = 64 * (uint32_t)plane_words},
                                .first_row = first,
                                .rows = rows,
                                .bits = bits[i]};
        a[i].tile.planes = planes[i];
        a[i].tile.row_state = row_state[i];
        a[i].tile.spill = spill;
        a[i].tile.any_unproven = keep;
    }
    check_note(c,
               "rows %zu to %zu of %zu, %d voxels in %zu words, parity %d, inside out %d, unproven before %d, kind %d",
               first, first + rows, all, nx, words, parity, inside_out, keep, one_kind);
    if (!check_both(c, call_fill, &a[0], &a[1]))
        return;
    check_rows(c, a, before, plane_words, words, keep);
    if (c->result != CHECK_GOOD)
        return;
    uint64_t leaking[2] = {0, 0};
    for (int i = 0; i < 2; i++)
        if (a[i].tile.any_unproven)
            a[i].count += (uint64_t)ost_vox_fill_unproven(
                &a[i].tile, first, rows, parity ? OST_FILL_PARITY : OST_FILL_WINDING, a[i].bits, &leaking[i]);
    check_same(c, "bits after the unproven rows are summed", CHECK_BITS, bits[0], bits[1], rows * words);
    check_that(c, a[0].count == a[1].count && leaking[0] == leaking[1],
               "%llu solid voxels and %llu leaking rows, expected %llu and %llu", (unsigned long long)a[1].count,
               (unsigned long long)leaking[1], (unsigned long long)a[0].count, (unsigned long long)leaking[0]);
}

/* --------------------------------------------------------------- vox_expand */

typedef struct expand_arguments {
    const uint64_t *cutting, *noncutting;
    size_t rows;
    int words;
    int32_t nx;
    bool stream;
    uint8_t *voxels;
} expand_arguments;

static void call_expand(check_fn *kernel, void *with)
{
    const expand_arguments *a = with;
    ((ost_vox_expand_fn *)kernel)(a->cutting, a->noncutting, a->rows, a->words, a->nx, a->stream, a->voxels);
}

/* The unused bits after the last voxel of a row are random. */
static void test_expand(check *c)
{
    const int32_t nx = c->number < 260 ? c->number + 1 : (int32_t)check_range(c, 1, check_chance(c, 8) ? 4096 : 600);
    const int words = ost_vox_words(nx);
    const size_t rows = (size_t)check_range(c, 0, words > 16 ? 3 : 20), count = rows * (size_t)words;
    uint64_t *cutting = check_input(c, "cutting", count, sizeof *cutting, sizeof *cutting);
    uint64_t *noncutting = check_chance(c, 2)
                               ? check_input(c, "noncutting", count, sizeof *noncutting, sizeof *noncutting)
                               : NULL;
    const int kind = (int)check_range(c, 0, 3);
    for (size_t w = 0; w < count; w++) {
        cutting[w] = kind == 0 ? UINT64_MAX : kind == 1 ? 0 : rng_next(&c->rng);
        if (noncutting)
            noncutting[w] = (kind == 3 ? rng_next(&c->rng) : UINT64_MAX) & ~cutting[w];
    }
    void *voxels[2];
    check_outputs(c, "voxels", rows * (size_t)nx, 1, check_chance(c, 2) ? 64 : 1, voxels);
    const bool stream = check_chance(c, 2);
    check_note(c, "%zu rows of %d voxels in %d words, %s, stream %d", rows, nx, words,
               noncutting ? "two classes" : "one class", stream);
    expand_arguments a = {cutting, noncutting, rows, words, nx, stream, voxels[0]}, b = a;
    b.voxels = voxels[1];
    if (check_both(c, call_expand, &a, &b))
        check_same(c, "voxels", CHECK_U8, voxels[0], voxels[1], rows * (size_t)nx);
}

/* -------------------------------------------------------------------- bench */

enum { ROWS = 1024, WORDS = 4 };

typedef struct fill_bench {
    fill_arguments arguments; /* must be the first member, because calls receive a pointer to it */
    const uint64_t *planes;
} fill_bench;

static void restore_planes(void *with)
{
    fill_bench *f = with;
    memcpy(f->arguments.tile.planes, f->planes, 2 * ROWS * WORDS * 8);
}

static void bench_fill(check_bench *b)
{
    static _Alignas(64) uint64_t marked[2 * ROWS * WORDS], planes[2 * ROWS * WORDS], bits[ROWS * WORDS];
    static uint8_t row_state[ROWS];
    for (size_t r = 0; r < ROWS; r++) {
        marked[r * WORDS + 1] = UINT64_C(1) << (r % 64);
        marked[(ROWS + r) * WORDS + 2] = UINT64_C(1) << (r % 61);
    }
    fill_bench f = {
        .arguments = {.tile = {.nx = 256, .j1 = ROWS, .k1 = 1, .row_bits = 256, .minus = 256 * ROWS}, .rows = ROWS}};
    f.arguments.tile.planes = planes;
    f.arguments.tile.row_state = row_state;
    f.arguments.bits = bits;
    f.planes = marked;
    bench_time(b, "1024 rows of 256, two crossings", call_fill, restore_planes, &f, ROWS * 256.0, "voxel");
}

static void bench_expand(check_bench *b)
{
    static uint64_t cutting[64 * WORDS], noncutting[64 * WORDS];
    static _Alignas(64) uint8_t voxels[64 * 256];
    for (size_t i = 0; i < 64 * WORDS; i++) {
        cutting[i] = i % 3 ? UINT64_C(0xffff00000000) : 0;
        noncutting[i] = ~cutting[i] >> 20;
    }
    expand_arguments a = {cutting, noncutting, 64, WORDS, 256, false, voxels};
    bench_time(b, "64 rows of 256, two classes", call_expand, NULL, &a, 64 * 256, "voxel");
    a.nx = 250;
    bench_time(b, "64 rows of 250, two classes", call_expand, NULL, &a, 64 * 250, "voxel");
}

CHECK_CPU_SLOT(vox_fill)
CHECK_CPU_SLOT(vox_expand)
extern const check_kernel check_vox_fill, check_vox_expand;
const check_kernel check_vox_fill = {
    .name = "vox_fill", .of = vox_fill_of, .test = test_fill, .bench = bench_fill, .cases = 1500};
const check_kernel check_vox_expand = {
    .name = "vox_expand", .of = vox_expand_of, .test = test_expand, .bench = bench_expand, .cases = 900};
