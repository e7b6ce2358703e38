/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of the voxelizer by triangle (AR-VOX), and the kernel that computes the cells of a tool. The removal
 * kernels read these cells.
 *
 *   ost_vox_steps   for every row that a triangle owns, adds +1 or -1 at the first
 *                   centre that is not left of the crossing
 *   ost_vox_fill    computes the running sum of a row; a voxel is solid if its sum is not 0
 *   ost_vox_tiles   for CPUs: both steps for a tile of rows per item (voxelize_cpu.cl)
 *
 * Ranges.  L = 2^20 and coordinates lie in [0, L].  For an edge a -> b, E = dy (Z - az) - dz (Y - ay), with
 * |dy|, |dz| <= L and |Z - az| <= L + 2^9 (a centre). E is computed only for rows within the triangle's bounds, where
 * |E| < 2^42. |nx|, |ny|, |nz| <= 2^41. The position of a crossing, times nx, is K = nx ax - ny (Y - ay) - nz (Z - az).
 * K is a sum of three terms of at most 2^61, so K and its partial sums stay below 2^63. (In fact, each |n| is twice the
 * area of a triangle in a square of side L, so |n| <= 2^40, and the sums stay below 2^62.) nx 2^f <= 2^51, and K / nx
 * lies in [0, L], so K - nx 2^(f-1) >= -2^50. A count is at most the number of triangles, 2^26.
 */

/* Returns the coordinate of the centre of voxel i along one axis, in units of 2^-f voxels. */
static long ost_centre(int i, int f)
{
    return ((2l * i + 1) * (1l << f)) / 2;
}

/* ost_first_centre returns the index of the first centre that is not below m. ost_last_centre returns the index of the
   last centre that is not above m, which may be -1. 0 <= m <= dims 2^f. */
static int ost_first_centre(int m, int f)
{
    return (int)(((uint)m + (1u << (f - 1)) - 1u) >> f);
}

static int ost_last_centre(int m, int f)
{
    return (int)(((uint)m + (1u << (f - 1))) >> f) - 1;
}

/* Returns true if a triangle owns the points on its edge, where E = 0 (AR-VOX-2). dy and dz must not both be 0. */
static int ost_owns_edge(long dy, long dz)
{
    return dz < 0 || (dz == 0 && dy > 0);
}

/* A triangle that is oriented so that its projection runs counter-clockwise. */
typedef struct ost_triangle {
    long a[3], b[3], c[3];
    /* ranges of the voxel centres within the triangle's bounds */
    int i_first, i_last, j_first, j_last, k_first, k_last;
    long nx, ny, nz;
    int step; /* change of the winding number at a crossing, +1 or -1 */
    /* 1 if centres on the edge ab (on0), bc (on1) or ca (on2) belong to the triangle */
    int on0, on1, on2;
} ost_triangle;

/* Loads a triangle. Returns false if the triangle has no crossing in the slices k0 <= k < k1. */
static int ost_triangle_load(ost_triangle *t, __global const int *vertices, __global const uint *triangles,
                             size_t number, int f, int k0, int k1)
{
    for (int i = 0; i < 3; i++) {
        t->a[i] = vertices[3 * (size_t)triangles[3 * number] + (size_t)i];
        t->b[i] = vertices[3 * (size_t)triangles[3 * number + 1] + (size_t)i];
        t->c[i] = vertices[3 * (size_t)triangles[3 * number + 2] + (size_t)i];
    }
    const int z_least = ost_least((int)t->a[2], ost_least((int)t->b[2], (int)t->c[2]));
    const int z_most = ost_greatest((int)t->a[2], ost_greatest((int)t->b[2], (int)t->c[2]));
    t->k_first = ost_greatest(ost_first_centre(z_least, f), k0);
    t->k_last = ost_least(ost_last_centre(z_most, f), k1 - 1);
    if (t->k_first > t->k_last)
        return 0;

    t->nx = (t->b[1] - t->a[1]) * (t->c[2] - t->a[2]) - (t->b[2] - t->a[2]) * (t->c[1] - t->a[1]);
    t->ny = (t->b[2] - t->a[2]) * (t->c[0] - t->a[0]) - (t->b[0] - t->a[0]) * (t->c[2] - t->a[2]);
    t->nz = (t->b[0] - t->a[0]) * (t->c[1] - t->a[1]) - (t->b[1] - t->a[1]) * (t->c[0] - t->a[0]);
    if (t->nx == 0)
        return 0;
    t->step = -1;
    if (t->nx < 0) { /* nx < 0: in the direction of x, the row enters the mesh, so the winding number increases */
        for (int i = 0; i < 3; i++) {
            const long swap = t->b[i];
            t->b[i] = t->c[i];
            t->c[i] = swap;
        }
        t->nx = -t->nx;
        t->ny = -t->ny;
        t->nz = -t->nz;
        t->step = 1;
    }
    const int y_least = ost_least((int)t->a[1], ost_least((int)t->b[1], (int)t->c[1]));
    const int y_most = ost_greatest((int)t->a[1], ost_greatest((int)t->b[1], (int)t->c[1]));
    const int x_least = ost_least((int)t->a[0], ost_least((int)t->b[0], (int)t->c[0]));
    const int x_most = ost_greatest((int)t->a[0], ost_greatest((int)t->b[0], (int)t->c[0]));
    t->i_first = ost_first_centre(x_least, f);
    t->i_last = ost_last_centre(x_most, f);
    t->j_first = ost_first_centre(y_least, f);
    t->j_last = ost_last_centre(y_most, f);
    t->on0 = ost_owns_edge(t->b[1] - t->a[1], t->b[2] - t->a[2]);
    t->on1 = ost_owns_edge(t->c[1] - t->b[1], t->c[2] - t->b[2]);
    t->on2 = ost_owns_edge(t->a[1] - t->c[1], t->a[2] - t->c[2]);
    return 1;
}

/*
 * Returns the index of the first centre that is not left of the triangle's crossing with row (j, k), at most dims[0].
 * Returns -1 if the triangle does not own the row.
 */
static int ost_triangle_crossing(const ost_triangle *t, int j, int k, int f)
{
    const long y = ost_centre(j, f), z = ost_centre(k, f), width = 1l << f;
    const long e0 = (t->b[1] - t->a[1]) * (z - t->a[2]) - (t->b[2] - t->a[2]) * (y - t->a[1]);
    const long e1 = (t->c[1] - t->b[1]) * (z - t->b[2]) - (t->c[2] - t->b[2]) * (y - t->b[1]);
    const long e2 = (t->a[1] - t->c[1]) * (z - t->c[2]) - (t->a[2] - t->c[2]) * (y - t->c[1]);
    if (e0 < 0 || e1 < 0 || e2 < 0 || (e0 == 0 && !t->on0) || (e1 == 0 && !t->on1) || (e2 == 0 && !t->on2))
        return -1;
    /*
     * The crossing lies within the triangle's bounds, so the result is one of the centres i_first to i_last + 1.
     * Bisection is used, because 64-bit division is slow. The variable `crossing` is the distance of the crossing from
     * centre 0, times nx.
     */
    const long crossing = t->nx * t->a[0] - t->ny * (y - t->a[1]) - t->nz * (z - t->a[2]) - t->nx * (width / 2);
    int least = t->i_first, most = t->i_last + 1;
    while (least < most) {
        const int middle = (least + most) / 2;
        if (t->nx * width * middle >= crossing) /* the product is below 2^60, because nx < 2^40 and i 2^f <= 2^20 */
            most = middle;
        else
            least = middle + 1;
    }
    return least;
}

#if OST_FOR & 1
__kernel void ost_vox_steps(__global const ost_cl_vox *vox, __global const int *vertices,
                            __global const uint *triangles, volatile __global int *steps)
{
    ost_triangle t;
    if (get_global_id(0) >= vox->triangles || get_global_id(1) >= vox->bands ||
        !ost_triangle_load(&t, vertices, triangles, get_global_id(0), vox->fraction, vox->k0, vox->k1))
        return;
    for (int k = t.k_first + (int)get_global_id(1); k <= t.k_last; k += (int)vox->bands)
        for (int j = t.j_first; j <= t.j_last; j++) {
            const int i = ost_triangle_crossing(&t, j, k, vox->fraction);
            const ulong row = (ulong)j + (ulong)vox->dims[1] * (ulong)(k - vox->k0);
            if (i >= 0)
                atomic_add(&steps[row * ((ulong)vox->dims[0] + 1) + (ulong)i], t.step);
        }
}

__kernel void ost_vox_fill(__global const ost_cl_vox *vox, __global int *steps, __global uchar *classes,
                           volatile __global uint *leaks)
{
    if (get_global_id(0) >= (size_t)vox->dims[1] || get_global_id(1) >= (size_t)(vox->k1 - vox->k0))
        return;
    const int n = vox->dims[0], parity = vox->rule == OST_CL_FILL_PARITY;
    const ulong j = get_global_id(0), k = get_global_id(1);
    const ulong from = (j + (ulong)vox->dims[1] * k) * ((ulong)n + 1);
    const ulong to = (j + (ulong)vox->dims[1] * (k + (ulong)vox->k0)) * (ulong)n;
    int total = 0;
    for (int i = 0; i <= n; i++)
        total += steps[from + (ulong)i];
    const int leaks_here = parity ? total % 2 != 0 : total != 0;
    if (leaks_here)
        atomic_inc(leaks);
    int winding = 0;
    for (int i = 0; i <= n; i++) {
        winding += steps[from + (ulong)i];
        steps[from + (ulong)i] = 0;
        if (i < n && !leaks_here && (parity ? winding % 2 != 0 : winding != 0))
            classes[to + (ulong)i] = (uchar)vox->tool_class;
    }
}

__kernel void ost_vox_count(__global const ost_cl_vox *vox, __global const uchar *classes,
                            volatile __global uint *counts)
{
    if (get_global_id(0) >= (size_t)vox->dims[1] || get_global_id(1) >= (size_t)(vox->k1 - vox->k0))
        return;
    const ulong k = get_global_id(1) + (ulong)vox->k0;
    const ulong from = ((ulong)get_global_id(0) + (ulong)vox->dims[1] * k) * (ulong)vox->dims[0];
    uint solid = 0, cutting = 0;
    for (int i = 0; i < vox->dims[0]; i++) {
        const uchar found = classes[from + (ulong)i];
        solid += found != 0 ? 1u : 0u;
        cutting += found == 1 ? 1u : 0u;
    }
    if (solid > 0)
        atomic_add(&counts[2 * k], solid);
    if (cutting > 0)
        atomic_add(&counts[2 * k + 1], cutting);
}
#endif

/*
 * Computes the reach of each cell along one more axis.  After axis 0, the reach of a cell refers to
 * its row, after axis 1 to its slice, and after axis 2 to the grid.  A cell has a new reach of at
 * least r if every cell at a distance d < r along the new axis has the same class and an old reach
 * of at least r.  Otherwise, its new reach is below r.  Therefore the new reach is the least of these
 * numbers: the cell's own old reach; d for each neighbour of a different class; and max(d, old reach
 * of the neighbour) for each neighbour of the same class.  Cells outside the grid are treated as
 * empty cells with unlimited reach.
 */
__kernel void ost_tool_reach(__global const ost_cl_tool *tool, __global const uchar *from, __global uchar *to)
{
    const int nx = tool->dims[0], ny = tool->dims[1], nz = tool->dims[2], axis = tool->axis;
    if (get_global_id(0) >= (size_t)nx || get_global_id(1) >= (size_t)ny || get_global_id(2) >= (size_t)nz)
        return;
    const ulong slice = (ulong)nx * (ulong)ny;
    const ulong here = get_global_id(0) + (ulong)nx * get_global_id(1) + slice * get_global_id(2);
    const ulong stride = axis == 0 ? 1 : axis == 1 ? (ulong)nx : slice;
    const int at = (int)get_global_id(axis == 0 ? 0u : axis == 1 ? 1u : 2u);
    const int n = axis == 0 ? nx : axis == 1 ? ny : nz;
    const int own = from[here] & 3;
    int reach = axis == 0 ? OST_CL_REACH_MAX : from[here] >> 2;
    for (int d = 1; d < reach; d++)
        for (int side = 0; side < 2; side++) {
            const int there = side ? at + d : at - d;
            int limit = OST_CL_REACH_MAX;
            if (there < 0 || there >= n) {
                limit = own == 0 ? OST_CL_REACH_MAX : d;
            } else {
                const uchar cell = side ? from[here + (ulong)d * stride] : from[here - (ulong)d * stride];
                if ((cell & 3) != own)
                    limit = d;
                else if (axis > 0)
                    limit = ost_greatest(d, cell >> 2);
            }
            reach = ost_least(reach, limit);
        }
    to[here] = (uchar)(own | reach << 2);
}
