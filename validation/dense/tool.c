/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts a mesh to a tool grid (AR-VOX), row by row as in docs/spec/arithmetic.md. The code
 * determines for every triangle whether the triangle owns the row. For every voxel of the row, it
 * then determines whether the crossing is at the voxel's centre or at a lower x coordinate.
 */
#include "validation/dense/parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ost_status dense_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    const size_t count = (size_t)ost_dims_count(volume->geometry.dims);
    dense_tool *tool = calloc(1, sizeof *tool);
    if (!tool)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool");
    tool->base = (ost_tool){.backend = backend, .geometry = volume->geometry};
    tool->voxels = calloc(count, 1);
    if (!tool->voxels) {
        free(tool);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool of %zu voxels", count);
    }
    if (volume->voxels)
        memcpy(tool->voxels, volume->voxels, count);
    *out = &tool->base;
    return OST_OK;
}

ost_status dense_tool_download(const ost_tool *tool, ost_tool_volume *volume, ost_error *err)
{
    (void)err;
    memcpy(volume->voxels, ((const dense_tool *)tool)->voxels, (size_t)ost_dims_count(tool->geometry.dims));
    return OST_OK;
}

void dense_tool_free(ost_tool *base)
{
    free(((dense_tool *)base)->voxels);
    free(base);
}

/* ------------------------------------------------------------- one row */

/* Specifies how a call reads its meshes: correctly, or with a deliberate mistake. */
typedef struct manner {
    deviant *m;
    bool own;     /* true if the mistake of m belongs to this stage */
    bool corners; /* true to sample voxels at their corners instead of their centres */
    size_t triangles_lost;
    float thesis_minimum[3];
    uint64_t first_item; /* number of the first unit of the current mesh; units of an earlier mesh have lower numbers */
} manner;

/* The counts of triangles in one row of voxels. */
typedef struct row {
    int32_t *count;  /* for each voxel, the winding number (AR-VOX-3); dims.x elements */
    uint32_t *times; /* for each voxel, the number of crossings (AR-VOX-5); dims.x elements */
    int64_t total;
    uint64_t owners;
} row;

static int64_t sample_at(const manner *how, const ost_snapped_mesh *mesh, int32_t i)
{
    return how->corners ? (int64_t)i << mesh->fraction_bits : (2 * (int64_t)i + 1) << (mesh->fraction_bits - 1);
}

/* Applies the rule of AR-VOX-2 to one edge. */
static bool owned_right(const int32_t *a, const int32_t *b, int64_t y, int64_t z)
{
    const int64_t dy = (int64_t)b[1] - a[1], dz = (int64_t)b[2] - a[2];
    const int64_t e = dy * (z - a[2]) - dz * (y - a[1]);
    if (e != 0)
        return e > 0;
    return dz != 0 ? dz < 0 : dy > 0;
}

static bool owned(deviant *m, uint64_t item, const int32_t *a, const int32_t *b, int64_t y, int64_t z)
{
    const int64_t dy = (int64_t)b[1] - a[1], dz = (int64_t)b[2] - a[2];
    int64_t e = dy * (z - a[2]) - dz * (y - a[1]);
    if (deviates(m, DEVIATION_CONTRACTED_MULTIPLY_ADD, item)) {
        const float fused = fmaf((float)dy, (float)(z - a[2]), -((float)dz * (float)(y - a[1])));
        e = fused > 0 ? 1 : fused < 0 ? -1 : 0;
    }
    if (e != 0)
        return e > 0;
    if (deviates(m, DEVIATION_OWNED_EDGE_TWICE, item))
        return true;
    if (deviates(m, DEVIATION_MISSING_EDGE, item))
        return false;
    if (deviates(m, DEVIATION_FLIPPED_TIE, item))
        return dz != 0 ? dz > 0 : dy < 0;
    return dz != 0 ? dz < 0 : dy > 0;
}

static int32_t least(int32_t a, int32_t b, int32_t c)
{
    return a < b ? (a < c ? a : c) : b < c ? b : c;
}

static int32_t most(int32_t a, int32_t b, int32_t c)
{
    return a > b ? (a > c ? a : c) : b > c ? b : c;
}

static void add_triangle(const manner *how, const ost_snapped_mesh *mesh, size_t t, int32_t j, int32_t k, row *to)
{
    deviant *m = how->m;
    const uint64_t item = how->first_item + t;
    const int32_t *v0 = mesh->vertices[mesh->triangles[t][0]], *v1 = mesh->vertices[mesh->triangles[t][1]],
                  *v2 = mesh->vertices[mesh->triangles[t][2]];
    const int32_t here[3] = {0, j, k};
    const int64_t y = sample_at(how, mesh, j), z = sample_at(how, mesh, k);
    if (!how->own && (y < least(v0[1], v1[1], v2[1]) || y > most(v0[1], v1[1], v2[1]) ||
                      z < least(v0[2], v1[2], v2[2]) || z > most(v0[2], v1[2], v2[2])))
        /* only a mistake can cause a triangle to own a row that lies beyond all three corners of the triangle */
        return;
    const int64_t right_area =
        (int64_t)(v1[1] - v0[1]) * (v2[2] - v0[2]) - (int64_t)(v2[1] - v0[1]) * (v1[2] - v0[2]);
    int64_t area = right_area;
    if (deviates(m, DEVIATION_NARROW_AREA, item))
        area = (int32_t)(uint32_t)(uint64_t)right_area;
    if (area == 0)
        return;
    int delta = -1;
    if (area < 0) {
        const int32_t *exchanged = v1;
        v1 = v2;
        v2 = exchanged;
        delta = 1;
        if (deviates(m, DEVIATION_CULLED_BACK_FACES, item)) {
            deviant_acted(m, item, NULL);
            return;
        }
    }
    if ((area < 0) != (right_area < 0))
        deviant_acted(m, item, NULL);
    const bool right = !how->own ||
                       (owned_right(v0, v1, y, z) && owned_right(v1, v2, y, z) && owned_right(v2, v0, y, z));
    const bool mine = owned(m, item, v0, v1, y, z) && owned(m, item, v1, v2, y, z) && owned(m, item, v2, v0, y, z);
    if (how->own && mine != right)
        deviant_acted(m, item, here);
    if (!mine)
        return;

    int64_t u[3], w[3];
    for (int a = 0; a < 3; a++) {
        u[a] = (int64_t)v1[a] - v0[a];
        w[a] = (int64_t)v2[a] - v0[a];
    }
    const int64_t normal[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    const bool excluded = deviates(m, DEVIATION_EXCLUDED_CROSSING, item);
    to->total += delta;
    to->owners++;
    for (int32_t i = 0; i < mesh->grid.dims.x; i++) {
        const int64_t x = sample_at(how, mesh, i);
        const int64_t side = normal[0] * (x - v0[0]) + normal[1] * (y - v0[1]) + normal[2] * (z - v0[2]);
        if (side == 0 && excluded) {
            deviant_acted(m, item, (const int32_t[3]){i, j, k});
            continue;
        }
        if (side >= 0) {
            to->count[i] += delta;
            to->times[i]++;
        }
    }
}

/* ------------------------------------------------------------- all rows */

/* Writes the solid voxels of one mesh. If the mistake UNCLEARED_COUNTS is made in a row, the counts of the
   previous row are not cleared. */
static void add_mesh(const manner *how, const ost_snapped_mesh *mesh, ost_fill_rule rule, uint8_t tool_class,
                     const row *r, uint8_t *voxels, ost_voxelize_report *report)
{
    const ost_dims d = mesh->grid.dims;
    const size_t lost = mesh->triangle_count < how->triangles_lost ? 0 : how->triangles_lost;
    bool fused;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++) {
            const uint64_t item = (uint64_t)(j + (int64_t)d.y * k);
            row now = {.count = r->count, .times = r->times};
            if (item > 0 && deviates(how->m, DEVIATION_UNCLEARED_COUNTS, item)) {
                for (int32_t i = 0; i < d.x; i++)
                    if (now.times[i]) {
                        deviant_acted(how->m, item, (const int32_t[3]){0, j, k});
                        break;
                    }
            } else {
                memset(now.count, 0, (size_t)d.x * sizeof *now.count);
                memset(now.times, 0, (size_t)d.x * sizeof *now.times);
            }
            if (deviant_thesis(how->m, &fused))
                dense_thesis_row(mesh, how->thesis_minimum, j, k, fused, now.count, now.times, &now.total, &now.owners);
            else
                for (size_t t = 0; t < mesh->triangle_count - lost; t++)
                    add_triangle(how, mesh, t, j, k, &now);
            if (rule == OST_FILL_WINDING ? now.total != 0 : now.owners % 2 != 0) {
                if (!deviates(how->m, DEVIATION_FILLED_LEAK, item)) {
                    report->leaking_rows++;
                    continue;
                }
                deviant_acted(how->m, item, (const int32_t[3]){0, j, k});
            }
            for (int32_t i = 0; i < d.x; i++)
                if (rule == OST_FILL_WINDING ? now.count[i] != 0 : now.times[i] % 2 != 0)
                    voxels[dense_at(d, i, j, k)] = tool_class;
        }
}

static void voxelize(deviant *m, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                     ost_fill_rule rule, const row *r, uint8_t *voxels, ost_voxelize_report *report)
{
    const int64_t count = ost_dims_count(cutting->grid.dims);
    manner how = {.m = m, .own = deviant_in(m, DEVIATION_TOOL)};
    bool fused;
    *report = (ost_voxelize_report){0};
    if (deviant_thesis(m, &fused))
        dense_thesis_bounds(cutting, noncutting, fused, how.thesis_minimum);
    if (deviates(m, DEVIATION_CORNER_FOR_CENTRE, 0)) {
        how.corners = true;
        deviant_acted(m, 0, NULL);
    }
    if (deviates(m, DEVIATION_PARITY_FOR_WINDING, 0)) {
        rule = rule == OST_FILL_WINDING ? OST_FILL_PARITY : OST_FILL_WINDING;
        deviant_acted(m, 0, NULL);
    }
    const bool lost = deviates(m, DEVIATION_TRIANGLES_LOST, 0),
               on_top = noncutting && deviates(m, DEVIATION_NONCUTTING_ON_TOP, 0);
    if (on_top)
        deviant_acted(m, 0, NULL);
    for (int pass = 0; pass < 2; pass++) {
        const bool cuts = (pass == 1) != on_top; /* the second pass overwrites voxels of the first */
        const ost_snapped_mesh *mesh = cuts ? cutting : noncutting;
        if (!mesh)
            continue;
        how.first_item = cuts ? 0 : UINT64_C(1) << 32;
        how.triangles_lost = lost ? mesh->triangle_count % 64 : 0;
        if (how.triangles_lost)
            deviant_acted(m, 0, NULL);
        add_mesh(&how, mesh, rule, cuts ? OST_TOOL_CUTTING : OST_TOOL_NONCUTTING, r, voxels, report);
    }
    for (int64_t v = 0; v < count; v++) {
        report->solid_voxels += voxels[v] != OST_TOOL_VOID;
        report->cutting_voxels += voxels[v] == OST_TOOL_CUTTING;
    }
}

static void note_changes(deviant *m, const ost_dims d, const uint8_t *made, const uint8_t *right,
                         const ost_voxelize_report *a, const ost_voxelize_report *b)
{
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++)
            for (int32_t i = 0; i < d.x; i++)
                if (*made++ != *right++)
                    deviant_changed_voxel(m, (const int32_t[3]){i, j, k});
    if (a->solid_voxels != b->solid_voxels || a->cutting_voxels != b->cutting_voxels ||
        a->leaking_rows != b->leaking_rows)
        deviant_changed_report(m, -1);
}

ost_status dense_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                          ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    deviant *m = dense_of(backend)->deviant;
    const bool twice = deviant_in(m, DEVIATION_TOOL);
    const ost_dims d = cutting->grid.dims;
    const ost_tool_volume empty = {.geometry = cutting->grid};
    ost_tool *right = NULL;
    const row r = {.count = malloc((size_t)d.x * sizeof *r.count), .times = malloc((size_t)d.x * sizeof *r.times)};
    ost_status status = r.count && r.times ? OST_OK
                                           : ost_fail(err, OST_ERR_MEMORY, "out of memory for a row of %d voxels", d.x);
    if (status == OST_OK)
        status = dense_tool_upload(backend, &empty, out, err);
    if (status == OST_OK && twice)
        status = dense_tool_upload(backend, &empty, &right, err);
    if (status == OST_OK) {
        ost_voxelize_report without;
        uint8_t *voxels = ((dense_tool *)*out)->voxels;
        deviant_begin(m, DEVIATION_TOOL, d, 0);
        voxelize(m, cutting, noncutting, rule, &r, voxels, report);
        if (twice) {
            voxelize(NULL, cutting, noncutting, rule, &r, ((dense_tool *)right)->voxels, &without);
            note_changes(m, d, voxels, ((dense_tool *)right)->voxels, report, &without);
            dense_tool_free(right);
        }
    } else if (*out) {
        dense_tool_free(*out);
        *out = NULL;
    }
    free(r.count);
    free(r.times);
    return status;
}
