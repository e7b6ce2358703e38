/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of the voxelizer for NEON. They process two triangles or sixteen classes at once.
 *
 * vox_fill has no NEON variant. It subtracts with borrow, for which NEON has no instruction, and the
 * scalar loop already subtracts 64 voxels at once.
 */
#include "core/neon.h"
#include "cpu/kernels.h"
#include "cpu/voxelize/voxelize.h"

/* --------------------------------------------------- triangles in lanes */

#define LANES 2
typedef float64x2_t vd;
typedef uint64x2_t vm;
typedef int32x2_t vi;

/*
 * The option -ffp-contract=off prevents fused multiply-add instructions. Even with these instructions, the results
 * would be the same, because every product that is summed here is exact.
 */
#define vd_set(x) vdupq_n_f64(x)
#define vd_add vaddq_f64
#define vd_sub vsubq_f64
#define vd_mul vmulq_f64
#define vd_div vdivq_f64
#define vd_min vminq_f64
#define vd_max vmaxq_f64
#define vd_floor vrndmq_f64
#define vd_ceil vrndpq_f64
#define vd_sel(m, yes, no) vbslq_f64(m, yes, no)
#define vd_lt vcltq_f64
#define vd_le vcleq_f64
#define vd_eq vceqq_f64
#define vm_and vandq_u64
#define vm_or vorrq_u64
#define vm_andnot(a, b) vbicq_u64(a, b)
#define vm_bits(m) ((unsigned)((vgetq_lane_u64(m, 0) & 1) | (vgetq_lane_u64(m, 1) & 2)))
#define vm_first(n) vcltq_f64((float64x2_t){0, 1}, vd_set(n))
#define vi_load(p) vreinterpret_s32_u32(vld1_u32(p))
#define vi_store(p, v) vst1_u32(p, vreinterpret_u32_s32(v))
#define vi_from_vd(a) vmovn_s64(vcvtq_s64_f64(a))
#define vd_from_vi(a) vcvtq_f64_s64(vmovl_s32(a))

/* Loads one corner of each triangle. Reads only the twelve bytes of each vertex, because memory after the last vertex
   may not be readable. */
static inline void vi_vertices(const ost_snapped_mesh *mesh, const uint32_t *const *v, int corner, vi *xyz)
{
    const int32_t *p = mesh->vertices[v[0][corner]], *q = mesh->vertices[v[1][corner]];
    const int32x2_t xy0 = vld1_s32(p), xy1 = vld1_s32(q);
    xyz[0] = vzip1_s32(xy0, xy1);
    xyz[1] = vzip2_s32(xy0, xy1);
    xyz[2] = vld1_lane_s32(q + 2, vld1_dup_s32(p + 2), 1);
}

static inline size_t emit_bits(uint32_t *out, vi v, unsigned lanes)
{
    const size_t first = lanes & 1, second = lanes >> 1;
    out[0] = (uint32_t)vget_lane_s32(v, 0);
    out[first] = (uint32_t)vget_lane_s32(v, 1);
    return first + second;
}

#define emit(out, v, m) emit_bits(out, v, vm_bits(m))

/* Loads y and z of one corner of both triangles. */
static inline int32x4_t yz_of_both(const ost_snapped_mesh *mesh, const uint32_t *t, int corner)
{
    return vcombine_s32(vld1_s32(mesh->vertices[mesh->triangles[t[0]][corner]] + 1),
                        vld1_s32(mesh->vertices[mesh->triangles[t[1]][corner]] + 1));
}

/*
 * Returns one bit per triangle; it is set if the triangle's bounds contain the centre of a row. The
 * coordinates are compared as integers and are not transposed.
 */
static inline unsigned bounds_meet_rows(const ost_vox_tile *tile, const uint32_t *t)
{
    const int32x4_t h = vdupq_n_s32(1 << (tile->f - 1)), h1 = vdupq_n_s32((1 << (tile->f - 1)) - 1),
                    f = vdupq_n_s32(-tile->f);
    const int32x4_t a = yz_of_both(tile->mesh, t, 0), b = yz_of_both(tile->mesh, t, 1),
                    c = yz_of_both(tile->mesh, t, 2);
    const int32x4_t lo = vminq_s32(vminq_s32(a, b), c), hi = vmaxq_s32(vmaxq_s32(a, b), c);
    const uint32x4_t some = vcleq_s32(vshlq_s32(vaddq_s32(lo, h1), f), vshlq_s32(vsubq_s32(hi, h), f));
    return vm_bits(vceqq_u64(vreinterpretq_u64_u32(some), vdupq_n_u64(UINT64_MAX)));
}

static inline vi least(vi a, vi b, vi c)
{
    return vmin_s32(vmin_s32(a, b), c);
}

static inline vi greatest(vi a, vi b, vi c)
{
    return vmax_s32(vmax_s32(a, b), c);
}

static inline vi keys_lanes(const ost_vox_plan *plan, vi ay, vi by, vi cy, vi az, vi bz, vi cz)
{
    const vi h = vdup_n_s32(1 << (plan->f - 1)), h1 = vdup_n_s32((1 << (plan->f - 1)) - 1);
    /* The shift counts are negative, because NEON has no other shift to the right by a variable count. */
    const vi f = vdup_n_s32(-plan->f), sy = vdup_n_s32(-plan->shift_y), sz = vdup_n_s32(-plan->shift_z);
    const vi j0 = vshl_s32(vadd_s32(least(ay, by, cy), h1), f), k0 = vshl_s32(vadd_s32(least(az, bz, cz), h1), f);
    const vi j1 = vshl_s32(vsub_s32(greatest(ay, by, cy), h), f), k1 = vshl_s32(vsub_s32(greatest(az, bz, cz), h), f);
    const vi ty = vshl_s32(j0, sy), tz = vshl_s32(k0, sz);
    const uint32x2_t none = vorr_u32(vcgt_s32(j0, j1), vcgt_s32(k0, k1));
    const uint32x2_t one = vand_u32(vceq_s32(ty, vshl_s32(j1, sy)), vceq_s32(tz, vshl_s32(k1, sz)));
    uint32x2_t key = vreinterpret_u32_s32(vmla_s32(ty, tz, vdup_n_s32(plan->tiles_y)));
    key = vbsl_u32(one, key, vdup_n_u32(OST_VOX_KEY_MANY));
    return vreinterpret_s32_u32(vbsl_u32(none, vdup_n_u32(OST_VOX_KEY_NONE), key));
}

#include "cpu/voxelize/lanes.h"

void ost_vox_mark_neon(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    mark(tile, list, count);
}

void ost_vox_keys_neon(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                       uint32_t *keys)
{
    keys_of(plan, mesh, first, count, keys);
}

/* ---------------------------------------------------------------- classes */

/*
 * Returns 16 bytes; byte i is -1 if bit i of the parameter is set, and 0 otherwise. Each byte receives a
 * copy of the byte that contains its bit, and is tested for this bit.
 */
static inline uint8x16_t spread(uint64_t bits)
{
    const uint8x16_t from = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
    const uint8x16_t own = vcombine_u8(ost_neon_own_bits(), ost_neon_own_bits());
    return vtstq_u8(vqtbl1q_u8(vreinterpretq_u8_u16(vdupq_n_u16((uint16_t)bits)), from), own);
}

static inline uint8x16_t classes_of(const uint64_t *cutting, const uint64_t *noncutting, size_t word, unsigned shift)
{
    uint8x16_t v = vandq_u8(spread(cutting[word] >> shift), vdupq_n_u8(OST_TOOL_CUTTING));
    if (noncutting)
        v = vorrq_u8(v, vandq_u8(spread(noncutting[word] >> shift), vdupq_n_u8(OST_TOOL_NONCUTTING)));
    return v;
}

/* Ignores `stream`, because the NEON intrinsics have no stores that bypass the caches. */
void ost_vox_expand_neon(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                         bool stream, uint8_t *voxels)
{
    (void)stream;
    const size_t full = (size_t)nx / 16, remainder = (size_t)nx % 16;
    for (size_t r = 0; r < rows; r++, voxels += nx) {
        const size_t first = r * (size_t)words;
        for (size_t h = 0; h < full; h++)
            vst1q_u8(voxels + 16 * h, classes_of(cutting, noncutting, first + h / 4, 16 * (h % 4)));
        if (remainder) {
            uint8_t last[16];
            vst1q_u8(last, classes_of(cutting, noncutting, first + full / 4, 16 * (full % 4)));
            memcpy(voxels + 16 * full, last, remainder);
        }
    }
}
