/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dense/deviant.h"

#include <string.h>

static const deviation_about table[] = {
    {.name = "none", .unit = "", .what = "", .cause = "", .survives = "", .stage = DEVIATION_EVERY},
#define DEVIATION_ROW(kind, name, stage, unit, what, cause, survives)                                                  \
    {name, unit, what, cause, survives, DEVIATION_##stage},
    DEVIATION_LIST(DEVIATION_ROW)
#undef DEVIATION_ROW
};

const deviation_about *deviation_describe(deviation_kind kind)
{
    return &table[kind];
}

const char *deviation_stage_name(deviation_stage stage)
{
    static const char *const names[] = {"rect", "cubic", "chunks", "tool", "remove", "every"};
    return names[stage];
}

/* ------------------------------------------------------ the current call */

void deviant_return(deviant *m, deviation_stage stage, uint64_t call, ost_dims dims, int chunk_size)
{
    if (!m)
        return;
    m->stage = stage;
    m->call = call;
    m->dims = dims;
    m->chunk_size = chunk_size;
}

void deviant_begin(deviant *m, deviation_stage stage, ost_dims dims, int chunk_size)
{
    if (m)
        deviant_return(m, stage, m->calls[stage]++, dims, chunk_size);
}

/* The finalizer of the generator splitmix64. */
static uint64_t mixed(uint64_t z)
{
    z += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

uint64_t deviant_draw(const deviant *m, uint64_t item)
{
    return mixed(mixed(mixed(m->how.seed ^ (uint64_t)m->how.kind << 56) ^ m->call) ^ item);
}

bool deviates(const deviant *m, deviation_kind kind, uint64_t item)
{
    if (!m || m->how.kind != kind)
        return false;
    return m->how.one_in <= 1 || deviant_draw(m, item) % m->how.one_in == 0;
}

bool deviant_in(const deviant *m, deviation_stage stage)
{
    return m && (table[m->how.kind].stage == stage || table[m->how.kind].stage == DEVIATION_EVERY);
}

bool deviant_thesis(const deviant *m, bool *fused)
{
    *fused = m && m->how.kind == DEVIATION_THESIS_F32_FMA;
    return *fused || (m && m->how.kind == DEVIATION_THESIS_F32);
}

/* ------------------------------------------------------------- positions */

static int64_t number(const ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return x + (int64_t)d.x * (y + (int64_t)d.y * z);
}

/* Returns the index of the cube of n^3 voxels that contains voxel v. */
static int64_t cube(const ost_dims d, int32_t n, const int32_t v[3])
{
    return number((ost_dims){(d.x + n - 1) / n, (d.y + n - 1) / n, (d.z + n - 1) / n}, v[0] / n, v[1] / n, v[2] / n);
}

static deviation_position position(const deviant *m, int64_t item, const int32_t *v, int64_t chunk)
{
    deviation_position p = {
        .stage = m->stage, .call = m->call, .item = item, .voxel = {-1, -1, -1}, .leaf = -1, .chunk = chunk};
    if (v) {
        memcpy(p.voxel, v, sizeof p.voxel);
        p.leaf = cube(m->dims, 32, v);
        p.chunk = m->chunk_size ? cube(m->dims, m->chunk_size, v) : -1;
    }
    return p;
}

/* Increments *times. *kept stores the first call that has an effect, with the lowest voxel, the lowest leaf and the
   lowest chunk of that call. Returns false and does not change *kept if p is from a later call. */
static bool first(const deviant *m, uint64_t *times, deviation_position *kept, deviation_position p)
{
    if ((*times)++ == 0) {
        *kept = p;
        return true;
    }
    if (kept->stage != p.stage || kept->call != p.call)
        return false;
    if (p.leaf >= 0 && (kept->leaf < 0 || number(m->dims, p.voxel[0], p.voxel[1], p.voxel[2]) <
                                              number(m->dims, kept->voxel[0], kept->voxel[1], kept->voxel[2])))
        memcpy(kept->voxel, p.voxel, sizeof kept->voxel);
    if (p.leaf >= 0 && (kept->leaf < 0 || p.leaf < kept->leaf))
        kept->leaf = p.leaf;
    if (p.chunk >= 0 && (kept->chunk < 0 || p.chunk < kept->chunk))
        kept->chunk = p.chunk;
    return true;
}

void deviant_acted(deviant *m, uint64_t item, const int32_t voxel[3])
{
    first(m, &m->record.acted, &m->record.first_acted, position(m, (int64_t)item, voxel, -1));
}

/* The float arithmetic of the thesis has no intermediate values that could be compared with correct values. Therefore
   each changed position also counts as a position where the deviation acted. */
void deviant_changed_voxel(deviant *m, const int32_t voxel[3])
{
    bool fused;
    if (deviant_thesis(m, &fused))
        deviant_acted(m, 0, voxel);
    if (first(m, &m->record.changed, &m->record.first_changed, position(m, -1, voxel, -1)))
        m->record.voxels = true;
}

void deviant_changed_report(deviant *m, int64_t chunk)
{
    bool fused;
    if (deviant_thesis(m, &fused))
        deviant_acted(m, 0, NULL);
    if (first(m, &m->record.changed, &m->record.first_changed, position(m, -1, NULL, chunk)))
        m->record.report = true;
}
