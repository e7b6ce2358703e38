/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Marks and sorts small triangles in the lanes of vectors of doubles. The source is the
 * same for every width of vectors. The file that includes this one defines
 *
 *   LANES                 number of triangles processed at once
 *   vd, vm, vi            LANES doubles, a mask of LANES, LANES int32
 *   vd_set vd_add vd_sub vd_mul vd_div vd_min vd_max vd_floor vd_ceil vd_sel(m, yes, no)
 *   vd_lt vd_le vd_eq     comparisons
 *   vm_and vm_or vm_andnot(a, b) = a without b, vm_bits, vm_first(n)
 *   vi_load vi_store; vi_from_vd vd_from_vi   conversions of integer values
 *   least greatest        of three vi
 *   vi_vertices(mesh, v, corner, xyz)  coordinates of a corner of LANES triangles; reads
 *                                      nothing after the last vertex
 *   keys_lanes                       one key per triangle, from the y and z of LANES triangles
 *   emit(out, v, m)       stores the lanes of v that are set in m, one after the other, and returns
 *                         their number; LANES int32 may be written
 *   emit_bits             like emit, except that m is an integer with one bit per lane
 *   bounds_meet_rows(tile, t)        one bit per triangle, set if a row's centre is in the triangle's bounds
 *
 * No value is approximate: every value is an integer, an integer + 1/4, or a quotient (see "Quotients"). With w = 2^f,
 * h = w / 2 and the extents ex, ey, ez <= 2^20 of a triangle, the triangle is small if
 *
 *   V = (ex + w) ey ez <= 2^49 = OST_VOX_SMALL
 *
 * The comparison is correct in doubles too, because the product is exact up to 2^53
 * and rounding preserves order. For a small triangle, with the symbols of mark.c and
 * with Y, Z in the triangle's bounds,
 *
 *   normal    |nx| <= ey ez, |ny| <= ex ez, |nz| <= ex ey: twice the area of a
 *             triangle in a rectangle; at most 2^40
 *   rows      dz w dj <= C; dj counts the rows from j', the first row of the bounds in
 *             the tile, and Y' is the y of the centres of row j';
 *             C = dy (Z - az) - dz (Y' - ay) - t: |C| <= 2 ey ez + 1 <= 2^41 + 1
 *   crossing  M = nx (ax - A w - h) - ny (Y - ay) - nz (Z - az), |ax - A w - h| <= h:
 *             |M| <= ey ez h + 2 ex ey ez <= 2 V <= 2^50; in an owned row, which
 *             crosses within the bounds, |M| <= ey ez h + nx ex <= V <= 2^49
 * All of these, their quarters and their steps from row to row are exact in
 * doubles (2^53).
 *
 * Quotients. dj <= floor(C / D) is computed as floor((C + 1/4) (1 / D)), D = dz w. (C + 1/4) / D differs from every
 * integer by at least 1 / (4 |D|). The two roundings change it by at most 2^-51 times its magnitude, which is less than
 * 1 / (4 |D|), because |C| + 1/4 < 2^49. Therefore the floor is exact. For dz < 0, the quarter moves the quotient down,
 * so that it is below the integer above it by the same margin: dj >= ceil((C + 1/4) (1 / D)). For dz = 0 the reciprocal
 * is replaced by a positive number that is large enough for the quotient to be beyond all rows. The quotient has the
 * sign of C + 1/4, which is never 0.
 * i = A + ceil(M / (nx w)) is computed as A + ceil((M - 1/4) (1 / (nx w))). The quotient differs from the nearest
 * integer by at least 1 / (4 nx w). In an owned row, the rounding error is less: it is at most 2^-52 (1 + 2^-54) times
 * a magnitude of at most (2^49 + 1/4) / (nx w). The result of a lane is not used if the lane has no triangle or its
 * triangle does not own the row.
 *
 * ost_vox_mark_triangle processes the other triangles: triangles that are not small, and
 * triangles that may have a crossing after the last centre of a row.
 */
#include <string.h>

#include "core/conditions.h"
#include "cpu/voxelize/voxelize.h"

enum { BUFFER = 1024 };

/* The plane bits that still have to be set, by their bit numbers. */
typedef struct pending {
    uint32_t bit[BUFFER + 2 * LANES];
    size_t count;
} pending;

static inline void set_pending(ost_vox_tile *tile, pending *p)
{
    for (size_t i = 0; i < p->count; i++)
        ost_vox_mark_bit(tile, p->bit[i]);
    p->count = 0;
}

/* The same edge (ab, bc or ca) of LANES triangles. */
typedef struct lane_edge {
    vd c;     /* C + 1/4 in the current slice (C: mark.c) */
    vd dc;    /* difference of C between neighbouring slices */
    vd r;     /* 1 / D */
    vm lower; /* D < 0 */
} lane_edge;

static inline lane_edge lane_edge_from(vd ay, vd az, vd by, vd bz, vd y, vd z, vd w)
{
    const vd zero = vd_set(0), dy = vd_sub(by, ay), dz = vd_sub(bz, az);
    const vm level = vd_eq(dz, zero), down = vd_lt(dz, zero);
    const vm tie = vm_or(down, vm_and(level, vd_lt(zero, dy)));
    const vd c = vd_sub(vd_mul(dy, vd_sub(z, az)), vd_mul(dz, vd_sub(y, ay)));
    return (lane_edge){
        .c = vd_add(c, vd_sel(tie, vd_set(0.25), vd_set(-0.75))),
        .dc = vd_mul(dy, w),
        .r = vd_sel(level, vd_set(1e30), vd_div(vd_set(1), vd_mul(dz, w))),
        .lower = down,
    };
}

static inline void lane_clip(lane_edge *e, vd *lo, vd *hi)
{
    const vd q = vd_mul(e->c, e->r);
    *lo = vd_sel(e->lower, vd_max(*lo, q), *lo);
    *hi = vd_sel(e->lower, *hi, vd_min(*hi, q));
    e->c = vd_add(e->c, e->dc);
}

static inline vd vd_least(vd a, vd b, vd c)
{
    return vd_min(vd_min(a, b), c);
}

static inline vd vd_greatest(vd a, vd b, vd c)
{
    return vd_max(vd_max(a, b), c);
}

/* Loads the corners of LANES triangles. The function is always inlined, so that its results stay in registers. */
static inline __attribute__((always_inline)) void corners(const ost_snapped_mesh *mesh, const uint32_t *t, vi a[3],
                                                          vi b[3], vi c[3])
{
    const uint32_t *v[LANES];
    for (int i = 0; i < LANES; i++)
        v[i] = mesh->triangles[t[i]];
    vi_vertices(mesh, v, 0, a);
    vi_vertices(mesh, v, 1, b);
    vi_vertices(mesh, v, 2, c);
}

/*
 * Marks the crossings of the triangles t[0] to t[lanes - 1].  The parameter `lanes` is a
 * number and not a mask of lanes, because gcc 12 does not clear the upper halves of
 * registers in a function that has a vector argument.
 */
static inline void mark_lanes(ost_vox_tile *tile, const uint32_t *t, int lanes, pending *p)
{
    vm valid = vm_first(lanes);
    const double w_ = (double)(1 << tile->f), h_ = w_ / 2;
    const vd w = vd_set(w_), h = vd_set(h_), per_w = vd_set(1 / w_), zero = vd_set(0), one = vd_set(1);
    vi a[3], b[3], c[3];
    corners(tile->mesh, t, a, b, c);

    /* Bounds of the triangles in rows and slices, clipped to the tile. */
    const vd ay = vd_from_vi(a[1]), az = vd_from_vi(a[2]);
    vd by = vd_from_vi(b[1]), bz = vd_from_vi(b[2]);
    vd cy = vd_from_vi(c[1]), cz = vd_from_vi(c[2]);
    const vd y_min = vd_least(ay, by, cy), y_max = vd_greatest(ay, by, cy);
    const vd z_min = vd_least(az, bz, cz), z_max = vd_greatest(az, bz, cz);
    const vd j0 = vd_max(vd_ceil(vd_mul(vd_sub(y_min, h), per_w)), vd_set(tile->j0));
    const vd k0 = vd_max(vd_ceil(vd_mul(vd_sub(z_min, h), per_w)), vd_set(tile->k0));
    /* j_count + 1 is the number of rows in the bounds, and k_count + 1 is the number of slices */
    const vd j_count = vd_sub(vd_min(vd_floor(vd_mul(vd_sub(y_max, h), per_w)), vd_set(tile->j1 - 1)), j0);
    const vd k_count = vd_sub(vd_min(vd_floor(vd_mul(vd_sub(z_max, h), per_w)), vd_set(tile->k1 - 1)), k0);
    valid = vm_and(valid, vm_and(vd_le(zero, j_count), vd_le(zero, k_count)));
    if (!vm_bits(valid))
        return;

    const vd ax = vd_from_vi(a[0]), bx = vd_from_vi(b[0]), cx = vd_from_vi(c[0]);
    const vd x_min = vd_least(ax, bx, cx), x_max = vd_greatest(ax, bx, cx);
    const vd volume = vd_mul(vd_mul(vd_add(vd_sub(x_max, x_min), w), vd_sub(y_max, y_min)), vd_sub(z_max, z_min));
    const vm small = vm_and(vd_le(volume, vd_set((double)OST_VOX_SMALL)),
                            vd_le(x_max, vd_set((tile->nx - 1) * w_ + h_)));
    const vm others = vm_andnot(valid, small);
    for (unsigned bits = vm_bits(others); bits; bits &= bits - 1)
        ost_vox_mark_triangle(tile, t[__builtin_ctz(bits)]);
    valid = vm_and(valid, small);

    /* Computes the normals, and exchanges corners so that all triangles are counter-clockwise. */
    const vd ux = vd_sub(bx, ax), uy = vd_sub(by, ay), uz = vd_sub(bz, az);
    const vd vx = vd_sub(cx, ax), vy = vd_sub(cy, ay), vz = vd_sub(cz, az);
    vd nx = vd_sub(vd_mul(uy, vz), vd_mul(uz, vy));
    vd ny = vd_sub(vd_mul(uz, vx), vd_mul(ux, vz));
    vd nz = vd_sub(vd_mul(ux, vy), vd_mul(uy, vx));
    valid = vm_andnot(valid, vd_eq(nx, zero));
    const vm enters = vd_lt(nx, zero);
    const vd turn = vd_sel(enters, vd_set(-1), one);
    nx = vd_mul(nx, turn);
    ny = vd_mul(ny, turn);
    nz = vd_mul(nz, turn);
    const vd swap_y = by, swap_z = bz;
    by = vd_sel(enters, cy, by);
    bz = vd_sel(enters, cz, bz);
    cy = vd_sel(enters, swap_y, cy);
    cz = vd_sel(enters, swap_z, cz);

    const vd y = vd_add(vd_mul(j0, w), h), z = vd_add(vd_mul(k0, w), h);
    lane_edge ab = lane_edge_from(ay, az, by, bz, y, z, w), bc = lane_edge_from(by, bz, cy, cz, y, z, w),
              ca = lane_edge_from(cy, cz, ay, az, y, z, w);
    const vd home = vd_floor(vd_mul(ax, per_w));
    const vd per_nx = vd_div(one, vd_mul(nx, w)), ny_w = vd_mul(ny, w), nz_w = vd_mul(nz, w);
    vd m = vd_sub(vd_mul(nx, vd_sub(vd_sub(ax, vd_mul(home, w)), h)),
                  vd_add(vd_add(vd_mul(ny, vd_sub(y, ay)), vd_mul(nz, vd_sub(z, az))), vd_set(0.25)));

    /* The number of the bit for voxel `home` of row (j0, k). The number is below 2^31, so the double is exact. */
    const vd row_bits = vd_set(tile->row_bits), slice_bits = vd_set((double)tile->row_bits * (tile->j1 - tile->j0));
    vd bit = vd_add(
        vd_add(vd_mul(vd_sub(k0, vd_set(tile->k0)), slice_bits), vd_mul(vd_sub(j0, vd_set(tile->j0)), row_bits)),
        vd_add(home, vd_sel(enters, zero, vd_set(tile->minus))));
    for (vd k = zero;; k = vd_add(k, one)) {
        const vm here = vm_and(valid, vd_le(k, k_count));
        if (!vm_bits(here))
            return;
        vd lo = zero, hi = j_count;
        lane_clip(&ab, &lo, &hi);
        lane_clip(&bc, &lo, &hi);
        lane_clip(&ca, &lo, &hi);
        lo = vd_ceil(lo);
        vd row_m = vd_sub(m, vd_mul(lo, ny_w)), row_bit = vd_add(bit, vd_mul(lo, row_bits));
        for (vm owned = vm_and(here, vd_le(lo, hi)); vm_bits(owned); owned = vm_and(owned, vd_le(lo, hi))) {
            const vd i = vd_ceil(vd_mul(row_m, per_nx));
            p->count += emit(p->bit + p->count, vi_from_vd(vd_add(row_bit, i)), owned);
            if (p->count > BUFFER)
                set_pending(tile, p);
            row_m = vd_sub(row_m, ny_w);
            row_bit = vd_add(row_bit, row_bits);
            lo = vd_add(lo, one);
        }
        m = vd_sub(m, nz_w);
        bit = vd_add(bit, slice_bits);
    }
}

static inline void mark_list(ost_vox_tile *tile, const uint32_t *list, size_t count, pending *p)
{
    size_t i = 0;
    for (; i + LANES <= count; i += LANES)
        mark_lanes(tile, list + i, LANES, p);
    if (i < count) {
        uint32_t t[LANES];
        for (size_t l = 0; l < LANES; l++) /* fills unused lanes with the last triangle */
            t[l] = list[i + l < count ? i + l : count - 1];
        mark_lanes(tile, t, (int)(count - i), p);
    }
}

/*
 * Marks the crossings of the triangles 0 to count - 1. Triangles whose bounds contain no centre of a row are
 * dropped first, so that no lane is empty.
 */
static inline void mark_all(ost_vox_tile *tile, size_t count, pending *p)
{
    uint32_t listed[3 * LANES];
    size_t n = 0, i = 0;
    for (; i + LANES <= count; i += LANES) {
        uint32_t t[LANES];
        for (uint32_t l = 0; l < LANES; l++)
            t[l] = (uint32_t)i + l;
        n += emit_bits(listed + n, vi_load(t), bounds_meet_rows(tile, t));
        if (n >= LANES) {
            n -= LANES;
            mark_lanes(tile, listed + n, LANES, p);
        }
    }
    mark_list(tile, listed, n, p);
    for (; i < count; i++)
        ost_vox_mark_triangle(tile, (uint32_t)i);
}

static inline void mark(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    pending p;
    p.count = 0;
    if (list)
        mark_list(tile, list, count, &p);
    else
        mark_all(tile, count, &p);
    set_pending(tile, &p);
}

static inline void keys_of(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                           uint32_t *keys)
{
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        uint32_t t[LANES];
        vi a[3], b[3], c[3];
        for (uint32_t l = 0; l < LANES; l++)
            t[l] = (uint32_t)(first + i) + l;
        corners(mesh, t, a, b, c);
        vi_store(keys + i, keys_lanes(plan, a[1], b[1], c[1], a[2], b[2], c[2]));
    }
    ost_vox_keys_scalar(plan, mesh, first + i, count - i, keys + i);
}
