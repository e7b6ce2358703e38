/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the arithmetic of the thesis as printed, in float32. If `fused` is true,
 * fmaf computes each product together with the addition that follows it, as in the
 * code of a compiler that contracts expressions.
 *
 *   Alg. 2.1   bounds and centres of a tool's voxels      dense_thesis_bounds, _row
 *   Alg. 2.3   the rect grid's dims                       dense_thesis_rect
 *   Alg. 2.4   a sample's index
 *   Alg. 2.5   the layer of a cubic voxel                 dense_thesis_layer
 *   Alg. 2.6   densities are copied as they are           bone.c, store and free_empty_chunks
 *   Alg. 2.8   the intersection of two boxes              dense_thesis_pose
 *   Alg. 2.9   its chunks
 *   Alg. 2.10  the voxels of these chunks
 *
 * The thesis does not specify some details, which are chosen here: the intersection
 * of a triangle and a row (edge functions with the tie rule of AR-VOX-2, all in
 * floats), ties of round() away from zero, the half voxel of a centre, and the
 * half-open range of chunks (docs/design/thesis-notes.md). Integers of the function
 * table are converted to the nearest float: vertices from the lattice, matrices from
 * the map.
 */
#include "validation/dense/parts.h"

#include <math.h>

static float millimetres(double pm)
{
    return (float)(pm / 1e9);
}

static float times_plus(float a, float b, float c, bool fused)
{
    return fused ? fmaf(a, b, c) : a * b + c;
}

static float floor_multiple(float x, float m)
{
    return floorf(x / m) * m;
}

static float ceil_multiple(float x, float m)
{
    return ceilf(x / m) * m;
}

/* ---------------------------------------------------------------- import */

/* Computes a sample's voxel by Alg. 2.4: converts its index (Alg. 1.1) with the dims of Alg. 2.3. Each of these dims is
   one too small if positions are multiples of the voxel size. */
bool dense_thesis_rect(const ost_geometry *g, const ost_sample *sample, int64_t at[3])
{
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    const ost_pm o[3] = {g->origin.x, g->origin.y, g->origin.z}, s[3] = {g->spacing.x, g->spacing.y, g->spacing.z},
                 p[3] = {sample->x, sample->y, sample->z};
    int64_t dims[3], index[3];
    for (int a = 0; a < 3; a++) {
        const float size = millimetres((double)s[a]), first = millimetres((double)o[a]),
                    last = millimetres((double)(o[a] + (n[a] - 1) * s[a]));
        const float minimum = floor_multiple(first, size), maximum = ceil_multiple(last, size);
        dims[a] = (int64_t)roundf((maximum - minimum) / size);
        index[a] = (int64_t)((millimetres((double)p[a]) - minimum) / size);
    }
    const int64_t number = index[0] + index[1] * dims[0] + index[2] * dims[0] * dims[1];
    if (number < 0 || number >= dims[0] * dims[1] * dims[2])
        return false;
    at[0] = number % dims[0];
    at[1] = number / dims[0] % dims[1];
    at[2] = number / (dims[0] * dims[1]);
    return at[0] < n[0] && at[1] < n[1] && at[2] < n[2];
}

int64_t dense_thesis_layer(int32_t z, ost_pm cubic, ost_pm rect, bool fused)
{
    const float c = millimetres((double)cubic), r = millimetres((double)rect), at = (float)z;
    const int previous = (int)(((at - 1) * c) / r), current = (int)((at * c) / r);
    const float back = (float)previous * r;
    const float ratio = times_plus(at, c, -back, fused) / c;
    const int chosen = ratio >= 0.5f ? current : previous;
    return chosen < 0 ? 0 : chosen;
}

/* ------------------------------------------------------------------ tool */

static float vertex(const ost_snapped_mesh *mesh, uint32_t v, int a)
{
    const ost_pm corner[3] = {mesh->grid.corner.x, mesh->grid.corner.y, mesh->grid.corner.z};
    const double unit = (double)mesh->grid.voxel / (double)(1 << mesh->fraction_bits);
    return millimetres((double)corner[a] + mesh->vertices[v][a] * unit);
}

void dense_thesis_bounds(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, bool fused,
                         float minimum[3])
{
    const ost_snapped_mesh *meshes[] = {cutting, noncutting};
    const float size = millimetres((double)cutting->grid.voxel), half = size / 2;
    for (int a = 0; a < 3; a++) {
        float least = INFINITY;
        for (int i = 0; i < 2; i++)
            for (size_t t = 0; meshes[i] && t < meshes[i]->triangle_count; t++)
                for (int v = 0; v < 3; v++)
                    least = fminf(least, vertex(meshes[i], meshes[i]->triangles[t][v], a));
        minimum[a] = isinf(least) ? 0 : times_plus(roundf((least - half) / size), size, -size, fused);
    }
}

static bool float_owned(const float a[3], const float b[3], float y, float z, bool fused)
{
    const float dy = b[1] - a[1], dz = b[2] - a[2];
    const float e = times_plus(dy, z - a[2], -(dz * (y - a[1])), fused);
    if (e != 0)
        return e > 0;
    return dz != 0 ? dz < 0 : dy > 0;
}

/* Returns x * y - z * w. If `fused` is true, x * y is not rounded before the subtraction. */
static float cross(float x, float y, float z, float w, bool fused)
{
    return times_plus(x, y, -(z * w), fused);
}

void dense_thesis_row(const ost_snapped_mesh *mesh, const float minimum[3], int32_t j, int32_t k, bool fused,
                      int32_t *count, uint32_t *times, int64_t *total, uint64_t *owners)
{
    const float size = millimetres((double)mesh->grid.voxel);
    const float y = times_plus((float)j + 0.5f, size, minimum[1], fused),
                z = times_plus((float)k + 0.5f, size, minimum[2], fused);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        float p[3][3], u[3], w[3];
        for (int v = 0; v < 3; v++)
            for (int a = 0; a < 3; a++)
                p[v][a] = vertex(mesh, mesh->triangles[t][v], a);
        for (int a = 0; a < 3; a++) {
            u[a] = p[1][a] - p[0][a];
            w[a] = p[2][a] - p[0][a];
        }
        float normal[3] = {cross(u[1], w[2], u[2], w[1], fused), cross(u[2], w[0], u[0], w[2], fused),
                           cross(u[0], w[1], u[1], w[0], fused)};
        if (normal[0] == 0)
            continue;
        const bool turned = normal[0] < 0;
        const float *a = p[0], *b = turned ? p[2] : p[1], *c = turned ? p[1] : p[2];
        if (!float_owned(a, b, y, z, fused) || !float_owned(b, c, y, z, fused) || !float_owned(c, a, y, z, fused))
            continue;
        const float sign = turned ? -1.0f : 1.0f;
        const int delta = turned ? 1 : -1;
        *total += delta;
        ++*owners;
        for (int32_t i = 0; i < mesh->grid.dims.x; i++) {
            const float x = times_plus((float)i + 0.5f, size, minimum[0], fused);
            const float side = times_plus(normal[0], x - a[0],
                                          times_plus(normal[1], y - a[1], normal[2] * (z - a[2]), fused), fused);
            if (sign * side >= 0) {
                count[i] += delta;
                times[i]++;
            }
        }
    }
}

/* --------------------------------------------------------------- removal */

/* The transform from the bone's box to the tool's box. Coordinates are relative to the centres of the boxes. */
typedef struct boxes {
    float matrix[3][4];
    float bone[3], tool[3]; /* half extents of the boxes */
    float bone_voxel, tool_voxel;
    int32_t chunk_lo[3], chunk_hi[3]; /* half-open range of the chunks that the tool can reach */
} boxes;

/* Returns the dot product a . (x, y, z, 1). */
static float dot4(const float a[4], const float p[3], bool fused)
{
    return times_plus(a[0], p[0], times_plus(a[1], p[1], times_plus(a[2], p[2], a[3], fused), fused), fused);
}

/* Computes the range of chunks by Algs. 2.8 and 2.9. The tool's corners are transformed to the bone's frame, clamped to
   the bone's box and converted to chunk indices. */
static void share(boxes *x, const dense_bone *bone, bool fused)
{
    const float n = (float)bone->base.chunk_size;
    float lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = INFINITY;
        hi[a] = -INFINITY;
    }
    for (int corner = 0; corner < 8; corner++)
        for (int b = 0; b < 3; b++) {
            float at = 0;
            for (int a = 0; a < 3; a++) /* inverts the rotation by transposing its matrix */
                at = times_plus(x->matrix[a][b], (corner >> a & 1 ? x->tool[a] : -x->tool[a]) - x->matrix[a][3], at,
                                fused);
            at = fminf(fmaxf(at, -x->bone[b]), x->bone[b]);
            lo[b] = fminf(lo[b], at);
            hi[b] = fmaxf(hi[b], at);
        }
    for (int b = 0; b < 3; b++) {
        x->chunk_lo[b] = (int32_t)(floor_multiple((lo[b] + x->bone[b]) / x->bone_voxel, n) / n);
        x->chunk_hi[b] = (int32_t)(ceil_multiple((hi[b] + x->bone[b]) / x->bone_voxel, n) / n);
    }
}

static boxes boxes_of(const dense_bone *bone, const dense_tool *tool, const ost_map *map, bool fused)
{
    const ost_geometry *g = &bone->base.geometry;
    const ost_tool_geometry *t = &tool->base.geometry;
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z}, d[3] = {t->dims.x, t->dims.y, t->dims.z};
    boxes x = {.bone_voxel = millimetres((double)g->spacing.x), .tool_voxel = millimetres((double)t->voxel)};
    for (int a = 0; a < 3; a++) {
        x.bone[a] = (float)n[a] * x.bone_voxel / 2;
        x.tool[a] = (float)d[a] * x.tool_voxel / 2;
    }
    const double voxel = (double)t->voxel / 1e9, unit = (double)dense_int128(map->divisor) * (1 << 20);
    for (int a = 0; a < 3; a++) {
        double centre = (double)dense_int128(map->origin[a]) / unit;
        for (int b = 0; b < 3; b++) {
            const double column = (double)dense_int128(map->column[b][a]) / unit;
            x.matrix[a][b] = (float)(column * (double)t->voxel / (double)g->spacing.x);
            centre += (n[b] - 1) * 0.5 * column;
        }
        x.matrix[a][3] = (float)((centre - d[a] * 0.5) * voxel);
    }
    share(&x, bone, fused);
    return x;
}

/* Returns the class of the tool voxel in which a bone voxel lies. */
static uint8_t class_at(const boxes *x, const dense_tool *tool, int32_t i, int32_t j, int32_t k, bool fused)
{
    const ost_dims dims = tool->base.geometry.dims;
    const int32_t v[3] = {i, j, k}, d[3] = {dims.x, dims.y, dims.z};
    float p[3];
    int32_t at[3];
    for (int b = 0; b < 3; b++)
        p[b] = times_plus((float)v[b] + 0.5f, x->bone_voxel, -x->bone[b], fused);
    for (int a = 0; a < 3; a++) {
        const float q = dot4(x->matrix[a], p, fused);
        if (q < -x->tool[a] || q > x->tool[a])
            return OST_TOOL_VOID;
        at[a] = (int32_t)((q + x->tool[a]) / x->tool_voxel);
        if (at[a] >= d[a])
            return OST_TOOL_VOID;
    }
    return tool->voxels[dense_at(dims, at[0], at[1], at[2])];
}

void dense_thesis_pose(const dense_bone *bone, const dense_tool *tool, const ost_map *map, bool fused,
                       dense_marks marks)
{
    const ost_dims d = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size;
    const boxes x = boxes_of(bone, tool, map, fused);
    for (int32_t k = x.chunk_lo[2] * n; k < x.chunk_hi[2] * n && k < d.z; k++)
        for (int32_t j = x.chunk_lo[1] * n; j < x.chunk_hi[1] * n && j < d.y; j++)
            for (int32_t i = x.chunk_lo[0] * n; i < x.chunk_hi[0] * n && i < d.x; i++) {
                if (!bone->active[dense_at(d, i, j, k)])
                    continue;
                dense_mark(bone, marks, (const int32_t[3]){i, j, k}, class_at(&x, tool, i, j, k, fused));
            }
}
