/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Generates spongy bone and foam: the part of space that remains when cells are cut out.
 *
 *      .---. .----.       Points are scattered on a lattice.  The cell of a point
 *     ( p1  X  p2  )      is the space that is nearer to this point than to all
 *      `--./ \ .--'       other points.  Where two cells meet, there may be a wall;
 *          | p3 |         where three cells meet, there is a strut:
 *
 *                           d2 = (F2 - F1) / 2 |p2 - p1|     exact distance to the wall
 *                           d3 = (F3 - F1) / 2 |p3 - p1|     distance to the next wall
 *
 * F1 <= F2 <= F3 are the squared distances to the three nearest points.  d2 is
 * small close to a wall; d2 and d3 are both small close to a strut.  A hash of two
 * cells decides whether there is a wall between the cells.  Bone has about half of
 * the walls, which are the plates between its rods.  Foam has most of the walls;
 * where a wall is missing, there is a window between two cells.
 *
 * Voxels are computed in small blocks.  For each block, the computation uses only
 * the points that can be among the three points nearest to a voxel of the block.
 */
#include <math.h>
#include <string.h>

#include "phantom/noise.h"
#include "phantom/scan.h"
#include "phantom/shape.h"

typedef struct recipe {
    double cell;       /* distance between points of the lattice in mm */
    double stretch;    /* ratio of a cell's length along z, the direction of the load, to its width */
    double jitter;     /* maximum displacement of a point, in cell widths */
    double strut;      /* radius of a strut in mm */
    double wall;       /* half thickness of a wall in mm */
    double walls;      /* fraction of the pairs of neighbouring cells that have a wall between them */
    double radius;     /* radius in mm of a core drilled along z; 0 for a block */
    int solid, grain;  /* solid: density of the solid, HU; grain: variation of this density with position, HU */
    int filling;       /* density of the filling between the struts, HU */
    int noise;         /* twice the standard deviation of the noise, HU */
} recipe;

/*
 * Bone has walls and struts 0.15 to 0.25 mm thick, spaces of 0.6 to 0.9 mm, and marrow in the spaces. Foam has cells of
 * 1 to 2 mm, filled with air. With a core radius of 5.0 mm, the three outermost columns of chunks at each corner of the
 * box are empty. Thus 88 of the 100 chunks in each layer are not empty, as in Table 3.2 (1060 of 1200, 1669 of 1900).
 */
static const recipe BLOCK_OF_BONE = {0.95, 1.25, 0.85, 0.105, 0.075, 0.45, 0, 1350, 300, 10, 70};
static const recipe CORE_OF_BONE = {1.0, 1.2, 0.85, 0.1, 0.075, 0.4, 5.0, 1350, 300, 10, 70};
static const recipe CORE_OF_FOAM = {1.45, 1.0, 0.8, 0.13, 0.045, 0.7, 5.0, 420, 60, -985, 50};

enum { NEAR_MAX = 1024, ACTIVE = 120 };

typedef struct seedling {
    double x, y, z;
    uint64_t id;
    double far2; /* squared distance from the point to the block's middle */
} seedling;

/*
 * Lists the points that can be among the three nearest points of a voxel in a block. `middle` is the centre of the
 * block and `half` is half of its diagonal, both in cell widths. Returns the number of points, at most NEAR_MAX.
 */
static int gather(const recipe *r, uint64_t seed, ost_v3 middle, double half, seedling out[NEAR_MAX])
{
    int64_t lo[3], hi[3];
    const double at[3] = {middle.x, middle.y, middle.z};
    for (int a = 0; a < 3; a++) {
        lo[a] = ost_floor64(at[a] - half) - 2;
        hi[a] = ost_floor64(at[a] + half) + 2;
    }
    int n = 0;
    double nearest[3] = {1e30, 1e30, 1e30};
    for (int64_t k = lo[2]; k <= hi[2]; k++)
        for (int64_t j = lo[1]; j <= hi[1]; j++)
            for (int64_t i = lo[0]; i <= hi[0] && n < NEAR_MAX; i++) {
                seedling *s = &out[n++];
                s->id = ost_hash3(seed + 51, i, j, k);
                s->x = (double)i + 0.5 + r->jitter * (ost_unit(s->id, 0) - 0.5);
                s->y = (double)j + 0.5 + r->jitter * (ost_unit(s->id, 1) - 0.5);
                s->z = (double)k + 0.5 + r->jitter * (ost_unit(ost_mix64(s->id), 0) - 0.5);
                ost_v3 d = ost_v3_sub((ost_v3){s->x, s->y, s->z}, middle);
                s->far2 = ost_v3_dot(d, d);
                for (int a = 0; a < 3; a++)
                    if (s->far2 < nearest[a]) {
                        double t = nearest[a];
                        nearest[a] = s->far2;
                        for (int b = a + 1; b < 3; b++) {
                            double u = nearest[b];
                            nearest[b] = t;
                            t = u;
                        }
                        break;
                    }
            }
    /*
     * A voxel is at most the length `half` away from the middle of the block. Its distance to any
     * point, and its distance to the third nearest point, therefore differ by at most `half` from
     * those of the middle.
     */
    double reach = sqrt(nearest[2]) + 2 * half;
    int kept = 0;
    for (int i = 0; i < n; i++) {
        if (out[i].far2 > reach * reach)
            continue;
        /* Sorts the points by ascending distance, so that distance() can skip most of them. */
        seedling s = out[i];
        int slot = kept++;
        for (; slot > 0 && out[slot - 1].far2 > s.far2; slot--)
            out[slot] = out[slot - 1];
        out[slot] = s;
    }
    return kept;
}

/* Returns true if there is a wall between two cells. The ids are added, so the order of the cells has no effect. */
static bool has_wall(const recipe *r, const seedling *a, const seedling *b)
{
    return ost_unit(ost_mix64(a->id + b->id), 1) < r->walls;
}

/* Returns the distance in mm from p (in cell widths) to the solid. The distance is negative inside the solid. */
static double distance(const recipe *r, const seedling *near, int count, ost_v3 p)
{
    const seedling *first = near, *second = near, *third = near;
    double f1 = 1e30, f2 = 1e30, f3 = 1e30;
    for (int i = 0; i < count; i++) {
        double x = p.x - near[i].x, y = p.y - near[i].y, z = p.z - near[i].z, f = x * x + y * y + z * z;
        if (f >= f3)
            continue;
        if (f < f1) {
            f3 = f2, third = second;
            f2 = f1, second = first;
            f1 = f, first = &near[i];
        } else if (f < f2) {
            f3 = f2, third = second;
            f2 = f, second = &near[i];
        } else {
            f3 = f, third = &near[i];
        }
    }
    ost_v3 a = {second->x - first->x, second->y - first->y, second->z - first->z};
    ost_v3 b = {third->x - first->x, third->y - first->y, third->z - first->z};
    double la = ost_v3_length(a), lb = ost_v3_length(b);
    double d2 = r->cell * (f2 - f1) / (2 * la), d3 = r->cell * (f3 - f1) / (2 * lb);
    /*
     * The axis of the strut is the intersection of the planes of the two walls. It is the same line for each of the
     * three cells.
     */
    double between = ost_v3_dot(a, b) / (la * lb), sharp = ost_max(1 - between * between, 0.04);
    double solid = sqrt(ost_max(d2 * d2 + d3 * d3 - 2 * d2 * d3 * between, 0) / sharp) - r->strut;
    if (has_wall(r, first, second))
        solid = ost_blend(solid, d2 - r->wall, 0.06);
    if (has_wall(r, first, third))
        solid = ost_blend(solid, d3 - r->wall, 0.06);
    return solid;
}

typedef struct corer {
    const ost_scan *scan;
    const recipe *recipe;
    ost_v3 centre; /* centre of the box in mm */
    double blur;   /* mean spacing in mm before scaling; passed to ost_scan_cover as the width */
} corer;

/* Returns the position of a voxel's centre in mm before scaling. */
static ost_v3 position_of(const corer *c, double i, double j, double k)
{
    const ost_pm3 *s = &c->scan->volume->geometry.spacing;
    double by = c->scan->scale;
    return (ost_v3){(i + 0.5) * ost_pm_to_mm(s->x) / by, (j + 0.5) * ost_pm_to_mm(s->y) / by,
                    (k + 0.5) * ost_pm_to_mm(s->z) / by};
}

static ost_v3 in_cells(const recipe *r, ost_v3 p)
{
    return (ost_v3){p.x / r->cell, p.y / r->cell, p.z / (r->cell * r->stretch)};
}

static void core_block(void *user, const int lo[3], const int hi[3])
{
    const corer *c = user;
    seedling near[NEAR_MAX];
    const recipe *r = c->recipe;
    const ost_geometry *g = &c->scan->volume->geometry;
    uint64_t seed = c->scan->seed;
    ost_v3 a = position_of(c, lo[0], lo[1], lo[2]), b = position_of(c, hi[0] - 1, hi[1] - 1, hi[2] - 1);
    ost_v3 middle = ost_v3_mad(a, ost_v3_sub(b, a), 0.5);
    double half = 0.5 * ost_v3_length(ost_v3_sub(b, a)) / r->cell + 1e-9;
    int count = -1;
    for (int k = lo[2]; k < hi[2]; k++)
        for (int j = lo[1]; j < hi[1]; j++) {
            int16_t *row = c->scan->volume->voxels + (size_t)g->dims.x * ((size_t)j + (size_t)g->dims.y * (size_t)k);
            for (int i = lo[0]; i < hi[0]; i++) {
                ost_v3 p = position_of(c, i, j, k);
                double hu = r->filling, outside = -1;
                if (r->radius > 0) {
                    double x = p.x - c->centre.x, y = p.y - c->centre.y;
                    outside = sqrt(x * x + y * y) - r->radius;
                }
                if (outside < c->blur) {
                    if (count < 0)
                        count = gather(r, seed, in_cells(r, middle), half, near);
                    double d = distance(r, near, count, in_cells(r, p));
                    double solid = ost_scan_cover(d, c->blur);
                    if (solid > 0) {
                        double grain = ost_value_noise(seed + 52, p.x / 0.7, p.y / 0.7, p.z / 0.7) - 0.5;
                        hu += (r->solid + r->grain * grain - hu) * solid;
                    }
                }
                if (outside > -c->blur)
                    hu += (-1000 - hu) * (1 - ost_scan_cover(outside, c->blur));
                double noise = r->noise * ost_bell(ost_hash3(seed + 53, i, j, k));
                row[i] = hu >= ACTIVE ? ost_hu(hu + noise, ACTIVE, 3071) : ost_hu(hu + noise, -1024, ACTIVE - 1);
            }
        }
}

ost_status ost_scan_core(const ost_scan *scan, ost_phantom_kind kind, ost_error *err)
{
    const ost_geometry *g = &scan->volume->geometry;
    const recipe *r = kind == OST_PHANTOM_FOAM          ? &CORE_OF_FOAM
                      : kind == OST_PHANTOM_TRABECULAR2 ? &CORE_OF_BONE
                                                        : &BLOCK_OF_BONE;
    corer c = {.scan = scan, .recipe = r};
    const int dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const double spacing[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    c.blur = (spacing[0] + spacing[1] + spacing[2]) / 3 / scan->scale;
    c.centre = position_of(&c, 0.5 * dims[0] - 0.5, 0.5 * dims[1] - 0.5, 0);
    return ost_scan_blocks(scan, 0.26, core_block, &c, err);
}
