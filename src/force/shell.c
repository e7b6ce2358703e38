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
 * area.  The size of the cells is increased until there are at most OST_SHELL_MAX points.
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
    double cutting; /* area of those faces that cut */
} sum;

static bool solid(const ost_tool_volume *t, int x, int y, int z)
{
    const ost_dims d = t->geometry.dims;
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z &&
           t->voxels[(size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z)] != OST_TOOL_VOID;
}

static const int directions[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

/* The voxels within REACH of a face's centre, relative to the solid voxel at the face, in the order of summation. */
typedef struct ball {
    int count;
    int8_t at[(2 * REACH + 2) * (2 * REACH + 2) * (2 * REACH + 2)][3];
} ball;

static void ball_of(const int e[3], ball *out)
{
    out->count = 0;
    for (int z = -REACH; z <= REACH + 1; z++)
        for (int y = -REACH; y <= REACH + 1; y++)
            for (int x = -REACH; x <= REACH + 1; x++) {
                /* The centre of the face lies half a voxel along e. */
                const double d[3] = {x - 0.5 * e[0], y - 0.5 * e[1], z - 0.5 * e[2]};
                if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > REACH * REACH)
                    continue;
                int8_t *at = out->at[out->count++];
                at[0] = (int8_t)x;
                at[1] = (int8_t)y;
                at[2] = (int8_t)z;
            }
}

/*
 * Computes the unit vector toward the solid side at the face between voxel v and its neighbour
 * in direction e.
 */
static void inward_at(const ost_tool_volume *t, const int v[3], const int e[3], const ball *b, double out[3])
{
    double g[3] = {-1e-6 * e[0], -1e-6 * e[1], -1e-6 * e[2]};
    for (int i = 0; i < b->count; i++) {
        const int8_t *at = b->at[i];
        if (!solid(t, v[0] + at[0], v[1] + at[1], v[2] + at[2]))
            continue;
        for (int a = 0; a < 3; a++)
            g[a] += at[a] - 0.5 * e[a];
    }
    const double size = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    for (int a = 0; a < 3; a++)
        out[a] = g[a] / size;
}

/* A face of the surface: the solid voxel at the face, the number of the face's direction, and the inward normal. */
typedef struct face {
    int32_t v[3];
    uint8_t direction;
    bool cutting;
    double inward[3];
} face;

typedef struct faces {
    size_t count, capacity;
    face *face; /* owned */
} faces;

static bool find_faces(const ost_tool_volume *t, faces *out)
{
    const ost_dims d = t->geometry.dims;
    size_t i = 0;
    for (int z = 0; z < d.z; z++)
        for (int y = 0; y < d.y; y++)
            for (int x = 0; x < d.x; x++, i++)
                for (int k = 0; k < 6 && t->voxels[i] != OST_TOOL_VOID; k++) {
                    const int *e = directions[k];
                    if (solid(t, x + e[0], y + e[1], z + e[2]))
                        continue;
                    if (out->count == out->capacity) {
                        const size_t capacity = out->capacity ? 2 * out->capacity : 4096;
                        face *grown = realloc(out->face, capacity * sizeof *grown);
                        if (!grown)
                            return false;
                        out->face = grown;
                        out->capacity = capacity;
                    }
                    out->face[out->count++] = (face){
                        .v = {x, y, z}, .direction = (uint8_t)k, .cutting = t->voxels[i] == OST_TOOL_CUTTING};
                }
    return true;
}

/* Computes the normals of all faces. They do not depend on the size of the cells. */
static void find_normals(const ost_tool_volume *t, const faces *f)
{
    ball balls[6];
    for (int k = 0; k < 6; k++)
        ball_of(directions[k], &balls[k]);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < (int64_t)f->count; i++) {
        face *one = &f->face[i];
        inward_at(t, one->v, directions[one->direction], &balls[one->direction], one->inward);
    }
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
    sum *sums; /* owned; SIDES elements per cell */
} cells;

static void add_face(const ost_tool_volume *t, const face *f, cells *c)
{
    const int32_t *const v = f->v;
    const int *const e = directions[f->direction];
    const double *const n = f->inward;
    const double s = (double)t->geometry.voxel * M_PER_PM;
    const double share = fabs(n[0] * e[0] + n[1] * e[1] + n[2] * e[2]), area = s * s * share;
    const ost_pm3 corner = t->geometry.corner;
    const double from[3] = {(double)corner.x * M_PER_PM, (double)corner.y * M_PER_PM, (double)corner.z * M_PER_PM};
    const int64_t cell = v[0] / c->size + (int64_t)c->dims.x * (v[1] / c->size + (int64_t)c->dims.y * (v[2] / c->size));
    sum *to = &c->sums[cell * SIDES + side_of(n)];
    to->area += area;
    to->cutting += f->cutting ? area : 0;
    for (int a = 0; a < 3; a++) {
        to->at[a] += area * (from[a] + (v[a] + 0.5 + 0.5 * e[a]) * s);
        to->inward[a] += area * n[a];
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

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool's shell");
}

/* Merges the faces into at most OST_SHELL_MAX points. */
static ost_status merge(const ost_tool_volume *tool, const faces *f, ost_shell_point *points, size_t *count,
                        ost_error *err)
{
    const ost_dims d = tool->geometry.dims;
    const int most = d.x > d.y ? (d.x > d.z ? d.x : d.z) : d.y > d.z ? d.y : d.z;
    /*
     * The first cell size is estimated from the surface of the box. The size is then increased
     * until there are at most OST_SHELL_MAX points.
     */
    const double sides = 2.0 * ((double)d.x * d.y + (double)d.y * d.z + (double)d.x * d.z);
    for (int size = 1 + (int)sqrt(sides / OST_SHELL_MAX / 2); size <= 2 * most; size += 1 + size / 8) {
        cells c;
        if (!cells_open(tool, size, &c))
            return no_memory(err);
        for (size_t i = 0; i < f->count; i++)
            add_face(tool, &f->face[i], &c);
        *count = take(&c, points, OST_SHELL_MAX);
        free(c.sums);
        if (*count == 0)
            break;
        if (*count <= OST_SHELL_MAX)
            return OST_OK;
    }
    return ost_fail(err, OST_ERR_INPUT, "a tool without a solid voxel has no surface");
}

ost_status ost_shell_make(const ost_tool_volume *tool, ost_shell *out, ost_error *err)
{
    faces f = {0};
    *out = (ost_shell){0};
    ost_shell_point *points = malloc(OST_SHELL_MAX * sizeof *points);
    ost_status status = points && find_faces(tool, &f) ? OST_OK : no_memory(err);
    if (status == OST_OK) {
        find_normals(tool, &f);
        status = merge(tool, &f, points, &out->count, err);
    }
    free(f.face);
    if (status == OST_OK) {
        out->points = points;
        return OST_OK;
    }
    out->count = 0;
    free(points);
    return status;
}

void ost_shell_free(ost_shell *shell)
{
    free(shell->points);
    *shell = (ost_shell){0};
}
