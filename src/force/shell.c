/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts the surface of a tool to points.
 *
 *   faces between solid and empty voxels        cells of c voxels
 *        .--.--.                                .-----.-----.
 *     .--|##|##|    each face: its centre, and  | . . |  .  |   the points of a cell
 *     |##|##|##|    the inward normal there     |. .  |.  . |   are merged into one
 *
 * The normal is the gradient of the solid fraction within a ball of REACH voxels.
 * A face of area s^2 represents the area s^2 |e . n| of the surface, where e is the
 * direction of the face; the sum over the steps of a slanted surface is its true
 * area.  The size of the cells is increased until there are few enough points.
 * Faces of a cell with opposite directions, as on a thin wall, are not merged.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/force.h>

enum { REACH = 5, SIDES = 6 };
#define M_PER_PM 1e-12 /* metres per picometre */

typedef struct sum {
    double area, at[3], inward[3];
    double cutting; /* area of the cutting faces */
} sum;

static bool solid(const ost_tool_volume *t, int x, int y, int z)
{
    const ost_dims d = t->geometry.dims;
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z &&
           t->voxels[(size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z)] != OST_TOOL_VOID;
}

/*
 * Computes the unit vector toward the solid side at the face between voxel v and its neighbour
 * in direction e.
 */
static void inward_at(const ost_tool_volume *t, const int v[3], const int e[3], double out[3])
{
    double g[3] = {-1e-6 * e[0], -1e-6 * e[1], -1e-6 * e[2]};
    for (int z = -REACH; z <= REACH + 1; z++)
        for (int y = -REACH; y <= REACH + 1; y++)
            for (int x = -REACH; x <= REACH + 1; x++) {
                /* d is relative to the centre of the face, which lies half a voxel along e. */
                const double d[3] = {x - 0.5 * e[0], y - 0.5 * e[1], z - 0.5 * e[2]};
                const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if (square > REACH * REACH || !solid(t, v[0] + x, v[1] + y, v[2] + z))
                    continue;
                for (int a = 0; a < 3; a++)
                    g[a] += d[a];
            }
    const double size = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    for (int a = 0; a < 3; a++)
        out[a] = g[a] / size;
}

static int side_of(const double n[3])
{
    int axis = 0;
    for (int a = 1; a < 3; a++)
        axis = fabs(n[a]) > fabs(n[axis]) ? a : axis;
    return 2 * axis + (n[axis] > 0);
}

typedef struct cells {
    ost_dims dims;
    int size;
    sum *sums; /* owned; SIDES per cell */
} cells;

static void add_face(const ost_tool_volume *t, const int v[3], const int e[3], bool cutting, cells *c)
{
    double n[3];
    inward_at(t, v, e, n);
    const double s = (double)t->geometry.voxel * M_PER_PM;
    const double share = fabs(n[0] * e[0] + n[1] * e[1] + n[2] * e[2]), area = s * s * share;
    const ost_pm3 corner = t->geometry.corner;
    const double from[3] = {(double)corner.x * M_PER_PM, (double)corner.y * M_PER_PM, (double)corner.z * M_PER_PM};
    const int64_t cell = v[0] / c->size + (int64_t)c->dims.x * (v[1] / c->size + (int64_t)c->dims.y * (v[2] / c->size));
    sum *to = &c->sums[cell * SIDES + side_of(n)];
    to->area += area;
    to->cutting += cutting ? area : 0;
    for (int a = 0; a < 3; a++) {
        to->at[a] += area * (from[a] + (v[a] + 0.5 + 0.5 * e[a]) * s);
        to->inward[a] += area * n[a];
    }
}

static void add_faces(const ost_tool_volume *t, cells *c)
{
    static const int directions[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    const ost_dims d = t->geometry.dims;
    size_t i = 0;
    for (int z = 0; z < d.z; z++)
        for (int y = 0; y < d.y; y++)
            for (int x = 0; x < d.x; x++, i++)
                for (int k = 0; k < 6 && t->voxels[i] != OST_TOOL_VOID; k++) {
                    const int *e = directions[k], v[3] = {x, y, z};
                    if (!solid(t, x + e[0], y + e[1], z + e[2]))
                        add_face(t, v, e, t->voxels[i] == OST_TOOL_CUTTING, c);
                }
}

static bool cells_open(const ost_tool_volume *t, int size, cells *c)
{
    const ost_dims d = t->geometry.dims;
    c->size = size;
    c->dims = (ost_dims){(d.x + size - 1) / size, (d.y + size - 1) / size, (d.z + size - 1) / size};
    c->sums = calloc((size_t)ost_dims_count(c->dims) * SIDES, sizeof *c->sums);
    return c->sums != NULL;
}

static size_t take(const cells *c, ost_shell_point *points, size_t capacity)
{
    size_t count = 0;
    for (int64_t i = 0; i < ost_dims_count(c->dims) * SIDES; i++) {
        const sum *s = &c->sums[i];
        const double *n = s->inward, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (s->area <= 0 || length <= 0)
            continue;
        if (points && count < capacity) {
            points[count] = (ost_shell_point){.area = length, .cutting = 2 * s->cutting >= s->area};
            for (int a = 0; a < 3; a++) {
                points[count].at[a] = s->at[a] / s->area;
                points[count].inward[a] = n[a] / length;
            }
        }
        count++;
    }
    return count;
}

ost_status ost_shell_make(const ost_tool_volume *tool, ost_shell *out, ost_error *err)
{
    *out = (ost_shell){0};
    const ost_dims d = tool->geometry.dims;
    const int most = d.x > d.y ? (d.x > d.z ? d.x : d.z) : d.y > d.z ? d.y : d.z;
    ost_shell_point *points = malloc(OST_SHELL_MAX * sizeof *points);
    if (!points)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool's shell");
    /*
     * The first cell size is estimated from the surface of the box. The size is then increased
     * until the points fit.
     */
    const double faces = 2.0 * ((double)d.x * d.y + (double)d.y * d.z + (double)d.x * d.z);
    for (int size = 1 + (int)sqrt(faces / OST_SHELL_MAX / 2); size <= 2 * most; size += 1 + size / 8) {
        cells c;
        if (!cells_open(tool, size, &c)) {
            free(points);
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool's shell");
        }
        add_faces(tool, &c);
        const size_t count = take(&c, points, OST_SHELL_MAX);
        free(c.sums);
        if (count == 0)
            break;
        if (count <= OST_SHELL_MAX) {
            *out = (ost_shell){count, points};
            return OST_OK;
        }
    }
    free(points);
    return ost_fail(err, OST_ERR_INPUT, "a tool without a solid voxel has no surface");
}

void ost_shell_free(ost_shell *shell)
{
    free(shell->points);
    *shell = (ost_shell){0};
}
