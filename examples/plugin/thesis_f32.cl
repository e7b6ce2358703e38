/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The arithmetic of the thesis as printed, in float32. The file is both C and OpenCL C:
 * engine_c.c includes it, and engine_cl.c passes it to an OpenCL compiler, which also
 * compiles the kernels at the end of the file.
 *
 *   Alg. 2.1   least corner of a tool's grid           thesis_minimum
 *   Alg. 2.3   bounds and dims of the rect grid        thesis_rect_axis
 *   Alg. 2.4   a sample's voxel                        thesis_index
 *   Alg. 2.5   the rect layer of a cubic layer         thesis_layer
 *   section 2.3  the voxel centres inside the mesh     thesis_row
 *   Alg. 2.8   the box that bone and tool share        thesis_share
 *   Alg. 2.9   the chunks of this box
 *   Alg. 2.10  a bone voxel's tool voxel               thesis_class
 *
 * MUL_ADD(a, b, c) is a * b + c. It marks the expressions that a compiler may
 * contract, so that they are rounded once instead of twice. An OpenCL compiler may
 * contract them unless its options forbid it; in engine_c.c, the option contract=
 * decides.
 *
 * The thesis does not define when a row intersects a triangle; this file uses edge
 * functions with the tie rule of AR-VOX-2, in floats. The thesis also does not
 * define how round() rounds a tie: this file rounds it to even in Alg. 2.1, as in
 * Table 3.5, and away from zero in Alg. 2.3. A voxel's position is its centre, and
 * chunk ranges are half-open. docs/design/thesis-notes.md states the reasons.
 */
#ifdef __OPENCL_VERSION__
#ifdef THESIS_CONTRACT_OFF
#pragma OPENCL FP_CONTRACT OFF
#endif
#define FUNCTION
#define GLOBAL __global
#define MUL_ADD(a, b, c) ((a) * (b) + (c))
#define FLOOR floor
#define CEIL ceil
#define ROUND round
#define TIES_TO_EVEN rint
#define LEAST fmin
#define MOST fmax
#endif

#ifndef THESIS_TYPES
#define THESIS_TYPES
/* Bounds and dims of one axis of the rect grid. */
typedef struct thesis_axis {
    float minimum, size;
    int dims;
} thesis_axis;

typedef struct thesis_rect {
    thesis_axis axis[3];
} thesis_rect;

/*
 * The boxes of the bone and of the tool, and the matrix that maps bone positions to tool positions. Positions are
 * relative to the centres of the boxes, in millimetres.
 */
typedef struct thesis_boxes {
    float matrix[12]; /* three rows of four */
    float bone[3], tool[3]; /* half extents of the boxes */
    float bone_voxel, tool_voxel;
    int bone_dims[3], tool_dims[3];
    int chunk_size;
    int chunk_lo[3], chunk_hi[3]; /* half-open */
} thesis_boxes;

typedef struct thesis_grid {
    float minimum[3];
    float size;
    int dims[3];
    int parity;
    int triangles;
} thesis_grid;
#endif

FUNCTION float thesis_floor_multiple(float x, float m)
{
    return FLOOR(x / m) * m;
}

FUNCTION float thesis_ceil_multiple(float x, float m)
{
    return CEIL(x / m) * m;
}

/* ------------------------------------------------------------- Algs. 2.3, 2.4 */

FUNCTION thesis_axis thesis_rect_axis(float first, float last, float size)
{
    const float minimum = thesis_floor_multiple(first, size), maximum = thesis_ceil_multiple(last, size);
    thesis_axis axis;
    axis.minimum = minimum;
    axis.size = size;
    axis.dims = (int)ROUND((maximum - minimum) / size);
    return axis;
}

/* Implements Alg. 1.1 with the dims of Alg. 2.3. Returns -1 if the index lies outside the array. */
FUNCTION int thesis_index(thesis_rect r, float x, float y, float z)
{
    const int i = (int)((x - r.axis[0].minimum) / r.axis[0].size);
    const int j = (int)((y - r.axis[1].minimum) / r.axis[1].size);
    const int k = (int)((z - r.axis[2].minimum) / r.axis[2].size);
    const long number = (long)i + (long)j * r.axis[0].dims + (long)k * r.axis[0].dims * r.axis[1].dims;
    return number < 0 || number >= (long)r.axis[0].dims * r.axis[1].dims * r.axis[2].dims ? -1 : (int)number;
}

/* ------------------------------------------------------------------ Alg. 2.5 */

FUNCTION int thesis_layer(int layer, float cubic, float rect)
{
    const float z = (float)layer;
    const int previous = (int)(((z - 1) * cubic) / rect);
    const int current = (int)((z * cubic) / rect);
    float ratio = MUL_ADD(z, cubic, -((float)previous * rect));
    ratio /= cubic;
    return ratio >= 0.5f ? current : previous;
}

/* ------------------------------------------------------------------ Alg. 2.1 */

FUNCTION float thesis_minimum(float least, float size)
{
    const float half_size = size / 2;
    return MUL_ADD(TIES_TO_EVEN((least - half_size) / size), size, -size);
}

/* Returns x y - z w. */
FUNCTION float thesis_cross(float x, float y, float z, float w)
{
    return MUL_ADD(x, y, -(z * w));
}

FUNCTION int thesis_owned(float ay, float az, float by, float bz, float y, float z)
{
    const float dy = by - ay, dz = bz - az;
    const float e = MUL_ADD(dy, z - az, -(dz * (y - ay)));
    if (e != 0)
        return e > 0;
    return dz != 0 ? dz < 0 : dy > 0;
}

/*
 * Processes row (j, k) of the tool's grid: sets solid[i] to `mark` if the voxel's centre
 * is inside the mesh. `corners` contains nine floats per triangle.
 */
FUNCTION void thesis_row(thesis_grid g, GLOBAL const float *corners, int j, int k, int mark, GLOBAL int *count,
                         GLOBAL unsigned char *solid)
{
    const float y = MUL_ADD((float)j + 0.5f, g.size, g.minimum[1]), z = MUL_ADD((float)k + 0.5f, g.size, g.minimum[2]);
    for (int i = 0; i < g.dims[0]; i++)
        count[i] = 0;
    for (int t = 0; t < g.triangles; t++) {
        GLOBAL const float *a = corners + 9 * t, *b = a + 3, *c = a + 6;
        const float u0 = b[0] - a[0], u1 = b[1] - a[1], u2 = b[2] - a[2];
        const float w0 = c[0] - a[0], w1 = c[1] - a[1], w2 = c[2] - a[2];
        const float n0 = thesis_cross(u1, w2, u2, w1), n1 = thesis_cross(u2, w0, u0, w2),
                    n2 = thesis_cross(u0, w1, u1, w0);
        if (n0 == 0)
            continue;
        GLOBAL const float *second = n0 < 0 ? c : b, *third = n0 < 0 ? b : c;
        if (!thesis_owned(a[1], a[2], second[1], second[2], y, z) ||
            !thesis_owned(second[1], second[2], third[1], third[2], y, z) ||
            !thesis_owned(third[1], third[2], a[1], a[2], y, z))
            continue;
        const float sign = n0 < 0 ? -1.0f : 1.0f;
        for (int i = 0; i < g.dims[0]; i++) {
            const float x = MUL_ADD((float)i + 0.5f, g.size, g.minimum[0]);
            const float side = MUL_ADD(n0, x - a[0], MUL_ADD(n1, y - a[1], n2 * (z - a[2])));
            if (sign * side >= 0)
                count[i] += n0 < 0 ? 1 : -1;
        }
    }
    for (int i = 0; i < g.dims[0]; i++)
        if (g.parity ? count[i] & 1 : count[i] != 0)
            solid[i] = (unsigned char)mark;
}

/* ---------------------------------------------------------- Algs. 2.8 to 2.10 */

/* Clamps the tool's corners to the bone's box, and computes the range of chunks that encloses them. */
FUNCTION thesis_boxes thesis_share(thesis_boxes x)
{
    const float n = (float)x.chunk_size;
    for (int b = 0; b < 3; b++) {
        float lo = 0, hi = 0;
        for (int corner = 0; corner < 8; corner++) {
            float at = 0;
            for (int a = 0; a < 3; a++) /* the inverse of a rotation is its transpose */
                at = MUL_ADD(x.matrix[4 * a + b], (corner >> a & 1 ? x.tool[a] : -x.tool[a]) - x.matrix[4 * a + 3], at);
            at = LEAST(MOST(at, -x.bone[b]), x.bone[b]);
            lo = corner ? LEAST(lo, at) : at;
            hi = corner ? MOST(hi, at) : at;
        }
        x.chunk_lo[b] = (int)(thesis_floor_multiple((lo + x.bone[b]) / x.bone_voxel, n) / n);
        x.chunk_hi[b] = (int)(thesis_ceil_multiple((hi + x.bone[b]) / x.bone_voxel, n) / n);
    }
    return x;
}

/* Returns the index of the tool voxel that contains the centre of bone voxel (i, j, k). Returns -1 if this centre lies
   outside the tool's grid. */
FUNCTION int thesis_tool_voxel(thesis_boxes x, int i, int j, int k)
{
    const float p0 = MUL_ADD((float)i + 0.5f, x.bone_voxel, -x.bone[0]);
    const float p1 = MUL_ADD((float)j + 0.5f, x.bone_voxel, -x.bone[1]);
    const float p2 = MUL_ADD((float)k + 0.5f, x.bone_voxel, -x.bone[2]);
    int at[3];
    for (int a = 0; a < 3; a++) {
        const float q = MUL_ADD(
            x.matrix[4 * a], p0,
            MUL_ADD(x.matrix[4 * a + 1], p1, MUL_ADD(x.matrix[4 * a + 2], p2, x.matrix[4 * a + 3])));
        if (q < -x.tool[a] || q > x.tool[a])
            return -1;
        at[a] = (int)((q + x.tool[a]) / x.tool_voxel);
        if (at[a] >= x.tool_dims[a])
            return -1;
    }
    return at[0] + x.tool_dims[0] * (at[1] + x.tool_dims[1] * at[2]);
}

/* Combines the mark of a pose with the previous mark. Mark 1 (cutting) takes precedence over mark 2 (not cutting). */
FUNCTION unsigned char thesis_mark(thesis_boxes x, GLOBAL const unsigned char *tool, int i, int j, int k,
                                   unsigned char was)
{
    const int at = thesis_tool_voxel(x, i, j, k);
    const unsigned char found = at < 0 ? 0 : tool[at];
    return found == 1 || was == 0 ? found : was;
}

#ifdef __OPENCL_VERSION__
/* --------------------------------------------------------------------- kernels */

__kernel void rect_dims(__global const float *first_last_size, __global thesis_rect *out)
{
    for (int a = 0; a < 3; a++)
        out->axis[a] = thesis_rect_axis(first_last_size[3 * a], first_last_size[3 * a + 1], first_last_size[3 * a + 2]);
}

/*
 * In the thesis, this kernel also writes the densities. If two samples lie in one voxel, the
 * work item that is executed last determines the density. In this plugin, the host writes
 * the densities in the order of the samples.
 */
__kernel void rect_index(__global const thesis_rect *r, __global const float4 *samples, __global int *index)
{
    const float4 s = samples[get_global_id(0)];
    index[get_global_id(0)] = thesis_index(*r, s.x, s.y, s.z);
}

__kernel void cubic_layer(float cubic, float rect, __global int *layer)
{
    layer[get_global_id(0)] = thesis_layer((int)get_global_id(0), cubic, rect);
}

__kernel void tool_minimum(float x, float y, float z, float size, __global float *minimum)
{
    minimum[0] = thesis_minimum(x, size);
    minimum[1] = thesis_minimum(y, size);
    minimum[2] = thesis_minimum(z, size);
}

__kernel void tool_rows(__global const thesis_grid *g, __global const float *corners, int mark, __global int *count,
                        __global uchar *solid)
{
    const int row = (int)get_global_id(0);
    thesis_row(*g, corners, row % g->dims[1], row / g->dims[1], mark, count + (size_t)row * g->dims[0],
               solid + (size_t)row * g->dims[0]);
}

__kernel void share(__global thesis_boxes *x)
{
    *x = thesis_share(*x);
}

__kernel void chunk(__global const thesis_boxes *x, __global const uchar *tool, int cx, int cy, int cz,
                    __global uchar *marks)
{
    const int n = x->chunk_size;
    const int i = cx * n + (int)get_global_id(0), j = cy * n + (int)get_global_id(1),
              k = cz * n + (int)get_global_id(2);
    if (i >= x->bone_dims[0] || j >= x->bone_dims[1] || k >= x->bone_dims[2])
        return;
    __global uchar *mark = marks + (size_t)i +
                           (size_t)x->bone_dims[0] * ((size_t)j + (size_t)x->bone_dims[1] * (size_t)k);
    *mark = thesis_mark(*x, tool, i, j, k, *mark);
}
#endif
