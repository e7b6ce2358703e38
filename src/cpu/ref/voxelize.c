/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the voxel centres inside a closed mesh, in the steps that AR-VOX defines.
 *
 * For every row (j, k), a line along x passes through the centres of the row's voxels.
 * Where the line enters the mesh, the winding number increases by one; where the line
 * leaves the mesh, the winding number decreases by one:
 *
 *        enter                 leave
 *   . . . |+1 o   o   o   o   o |-1 .   .        o  winding != 0: solid
 *
 * A line crosses the triangles whose projections on (y, z) own the line.  For each crossing, the
 * triangle's step, +1 or -1, is added to a difference array of one slice, at the first centre that
 * is not left of the crossing.  A running sum along x gives every winding number.  The last sum
 * must be zero, because a line that enters a closed mesh also leaves it.  Otherwise the mesh is not
 * closed in this row: the row is counted as a leak and remains empty.
 *
 * Ownership.  The triangle is oriented so that its projection runs counter-clockwise.  For each
 * edge a -> b, E = (by - ay)(Z - az) - (bz - az)(Y - ay) is positive for points (Y, Z) left of the
 * edge.  The triangle owns the line through (Y, Z) if E > 0 for all three edges.  If E = 0, the
 * point lies on the edge and is replaced by the point (Y + e, Z + e^2) for an infinitesimal e > 0.
 * With dy = by - ay and dz = bz - az, this point has E = dy e^2 - dz e, which is positive iff
 * dz < 0, or dz = 0 and dy > 0.  The replacement is the same for all triangles and lies on no edge.
 * Therefore a line through a shared edge or vertex is owned once, however many triangles share it,
 * and a closed mesh never leaks.
 *
 * Ranges.  L = 2^20; every coordinate is in [0, L], so no difference exceeds L in magnitude.
 *   E    two products of differences: |E| <= 2 L^2 = 2^41
 *   n    the cross product of two edges; a component is twice the area of a
 *        triangle within a square of side L: |n| <= L^2 = 2^40, and nx >= 1 here
 *   K    = nx ax - ny (Y - ay) - nz (Z - az); K and every partial sum are at
 *        most 3 L^3 < 2^62 in magnitude.  K / nx is the crossing's x, in [0, dims.x 2^f].
 *   nx 2^f <= 2^50, and K - nx 2^(f-1) >= -2^49.
 * So int64 suffices throughout.  A winding number is at most 2^26.
 */
#include "cpu/ref/voxelize.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"

enum { X, Y, Z };

typedef struct slice {
    ost_dims dims;
    int f;
    int32_t k;
    /* (dims.x + 1) * dims.y elements; element dims.x of a row is for crossings after the row's last centre */
    int32_t *steps;
} slice;

/* Returns the coordinate of the centre of voxel i along one axis, in units of 2^-f voxels. */
static int64_t centre(int32_t i, int f)
{
    return ((int64_t)i << f) + (1 << (f - 1));
}

static bool owns(const int32_t *a, const int32_t *b, int64_t y, int64_t z)
{
    int64_t dy = b[Y] - a[Y], dz = b[Z] - a[Z];
    int64_t e = dy * (z - a[Z]) - dz * (y - a[Y]);
    return e > 0 || (e == 0 && (dz < 0 || (dz == 0 && dy > 0)));
}

static int32_t least3(int32_t a, int32_t b, int32_t c)
{
    int32_t m = a < b ? a : b;
    return m < c ? m : c;
}

static int32_t greatest3(int32_t a, int32_t b, int32_t c)
{
    int32_t m = a > b ? a : b;
    return m > c ? m : c;
}

/* Adds the steps of one triangle at its crossings with the rows of one slice. */
static void add_triangle(const slice *s, const int32_t *a, const int32_t *b, const int32_t *c)
{
    const int64_t z = centre(s->k, s->f);
    if (z < least3(a[Z], b[Z], c[Z]) || z > greatest3(a[Z], b[Z], c[Z]))
        return;

    int64_t u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (int64_t)b[i] - a[i];
        v[i] = (int64_t)c[i] - a[i];
    }
    int64_t nx = u[Y] * v[Z] - u[Z] * v[Y];
    int64_t ny = u[Z] * v[X] - u[X] * v[Z];
    int64_t nz = u[X] * v[Y] - u[Y] * v[X];
    if (nx == 0)
        return;
    int32_t step = -1;
    if (nx < 0) { /* the line enters the mesh here, so the winding number increases */
        const int32_t *swap = b;
        b = c;
        c = swap;
        nx = -nx;
        ny = -ny;
        nz = -nz;
        step = 1;
    }

    const int64_t half = 1 << (s->f - 1), width = INT64_C(1) << s->f;
    const int64_t first = ost_ceil_div(least3(a[Y], b[Y], c[Y]) - half, width);
    const int64_t last = ost_floor_div(greatest3(a[Y], b[Y], c[Y]) - half, width);
    assert(first >= 0 && last < s->dims.y);
    for (int32_t j = (int32_t)first; j <= last; j++) {
        const int64_t y = centre(j, s->f);
        if (!owns(a, b, y, z) || !owns(b, c, y, z) || !owns(c, a, y, z))
            continue;
        /* nx times the x coordinate of the crossing */
        const int64_t crossing = nx * a[X] - ny * (y - a[Y]) - nz * (z - a[Z]);
        const int64_t i = ost_ceil_div(crossing - nx * half, nx * width);
        assert(i >= 0 && i <= s->dims.x);
        s->steps[(int64_t)j * (s->dims.x + 1) + i] += step;
    }
}

/* Sums the steps of one row and sets the row's solid voxels to tool_class. Returns false if the row leaks. */
static bool fill_row(const int32_t *steps, int32_t n, ost_fill_rule rule, uint8_t tool_class, uint8_t *row)
{
    const int32_t mask = rule == OST_FILL_PARITY ? 1 : -1;
    int32_t winding = 0;
    for (int32_t i = 0; i <= n; i++)
        winding += steps[i];
    if (winding & mask)
        return false;
    for (int32_t i = 0; i < n; i++) {
        /* `winding` starts at the total of the row's steps. The total is 0 or, with the parity rule, even, so it does
           not affect the test. */
        winding += steps[i];
        if (winding & mask)
            row[i] = tool_class;
    }
    return true;
}

static void add_mesh(slice *s, const ost_snapped_mesh *mesh, ost_fill_rule rule, uint8_t tool_class, uint8_t *plane,
                     ost_voxelize_report *report)
{
    const size_t stride = (size_t)s->dims.x + 1;
    memset(s->steps, 0, stride * (size_t)s->dims.y * sizeof *s->steps);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->triangles[t];
        add_triangle(s, mesh->vertices[v[0]], mesh->vertices[v[1]], mesh->vertices[v[2]]);
    }
    for (int32_t j = 0; j < s->dims.y; j++)
        if (!fill_row(s->steps + (size_t)j * stride, s->dims.x, rule, tool_class,
                      plane + (size_t)j * (size_t)s->dims.x))
            report->leaking_rows++;
}

ost_status ost_ref_voxelize(const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting, ost_fill_rule rule,
                            ost_voxelize_report *report, uint8_t *voxels, ost_error *err)
{
    slice s = {.dims = cutting->grid.dims, .f = cutting->fraction_bits};
    ost_voxelize_report sums = {0};
    assert(s.f >= 1 && s.f <= 10 && s.dims.x <= OST_TOOL_DIM_MAX && s.dims.y <= OST_TOOL_DIM_MAX);
    assert(!noncutting || (noncutting->fraction_bits == s.f && noncutting->grid.dims.x == s.dims.x &&
                           noncutting->grid.dims.y == s.dims.y && noncutting->grid.dims.z == s.dims.z));
    const size_t steps = ((size_t)s.dims.x + 1) * (size_t)s.dims.y;
    const size_t plane_size = (size_t)s.dims.x * (size_t)s.dims.y;
    s.steps = malloc(steps * sizeof *s.steps);
    if (!s.steps)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a slice of %d x %d voxels", s.dims.x, s.dims.y);

    for (s.k = 0; s.k < s.dims.z; s.k++) {
        uint8_t *plane = voxels + (size_t)s.k * plane_size;
        memset(plane, OST_TOOL_VOID, plane_size);
        if (noncutting)
            add_mesh(&s, noncutting, rule, OST_TOOL_NONCUTTING, plane, &sums);
        /* The cutting mesh is added last, so a voxel that is solid in both meshes becomes cutting. */
        add_mesh(&s, cutting, rule, OST_TOOL_CUTTING, plane, &sums);
        for (size_t i = 0; i < plane_size; i++) {
            sums.solid_voxels += plane[i] != OST_TOOL_VOID;
            sums.cutting_voxels += plane[i] == OST_TOOL_CUTTING;
        }
    }
    free(s.steps);
    if (report)
        *report = sums;
    return OST_OK;
}
