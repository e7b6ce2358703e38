/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the values of metrics.h in the order of their dependencies. Lengths are in millimetres. */
#include <osteon/metrics.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/vector.h"
#include "core/fit.h"
#include "metrics/frame.h"
#include "metrics/rim.h"
#include "metrics/tool_way.h"

enum { MAP = OST_METRICS_MAP, CELLS = MAP * MAP, SLABS = 64, HARD_HU = 650, FLOOR_MIN = 200, RIM = 2 };
#define OUTSIDE_MM 12.0 /* rays start at this distance outside the face */
#define INSIDE_MM 45.0
#define PLATE_MM 4.5
#define MARGIN_MM 1.0
#define WINDOW_MM 0.5   /* a reamer's axis is averaged over the deepest half millimetre */
/*
 * Minimum depth at which the hole's wall is measured. At a depth of less than WALL_MM, a search for the nearest voxel
 * outside the bone would find the space in front of the face.
 */
#define ENTRY_MM 6.0
#define WALL_MM 6.0
#define DEG (180 / 3.14159265358979323846)

typedef struct work {
    const ost_volume *before, *after;
    int threshold;
    const ost_metrics_plan *plan;
    ost_metrics *out;
    double spacing, origin[3];
    ost_plan_frame frame;
    int32_t dims[3];
    ost_scapular scapular; /* valid if out->scapular is true */
    /* owned array; 1 for voxels that a drill may have removed; NULL if no tool is a drill */
    uint8_t *mark;
    double (*floor)[3]; /* owned array; points of the floor in the coordinates u, v, w */
    size_t floor_count;
} work;

static ost_status set_up(work *k, const ost_metrics_motion *motion, ost_error *err)
{
    const ost_geometry *g = &k->before->geometry, *h = &k->after->geometry;
    if (memcmp(&g->dims, &h->dims, sizeof g->dims) != 0 || memcmp(&g->spacing, &h->spacing, sizeof g->spacing) != 0 ||
        memcmp(&g->origin, &h->origin, sizeof g->origin) != 0)
        return ost_fail(err, OST_ERR_USAGE, "metrics need the same grid before and after");
    if (g->spacing.x != g->spacing.y || g->spacing.x != g->spacing.z)
        return ost_fail(err, OST_ERR_USAGE, "metrics need a grid of cubic voxels");
    if (!(ost_vector_dot(k->plan->axis, k->plan->axis) > 0) ||
        !isfinite(ost_vector_dot(k->plan->axis, k->plan->axis)) || !(k->plan->depth_mm >= 0))
        return ost_fail(err, OST_ERR_USAGE, "a plan needs an axis and a depth");
    k->spacing = ost_pm_to_mm(g->spacing.x);
    const ost_pm origin[3] = {g->origin.x, g->origin.y, g->origin.z},
                 at[3] = {k->plan->at.x, k->plan->at.y, k->plan->at.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        k->origin[a] = ost_pm_to_mm(origin[a]);
        k->frame.at[a] = ost_pm_to_mm(at[a]);
        k->dims[a] = dims[a];
        k->frame.w[a] = k->plan->axis[a];
    }
    ost_vector_unit(k->frame.w, 2);
    /* v is the direction perpendicular to w that is nearest to superior, or to anterior if w is almost vertical. */
    const double up[3] = {0, fabs(k->frame.w[2]) > 0.9 ? -1 : 0, fabs(k->frame.w[2]) > 0.9 ? 0 : 1};
    ost_vector_cross(up, k->frame.w, k->frame.u);
    ost_vector_unit(k->frame.u, 2);
    ost_vector_cross(k->frame.w, k->frame.u, k->frame.v);
    bool drill = false;
    for (int i = 0; motion && i < motion->tool_count; i++)
        drill |= motion->tools[i].kind == OST_METRICS_DRILL;
    k->floor = malloc(CELLS * sizeof *k->floor);
    k->mark = drill ? calloc((size_t)ost_dims_count(g->dims), 1) : NULL;
    if (k->mark)
        ost_tool_way_mark(motion, g, k->mark);
    return k->floor && (k->mark || !drill) ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for metrics");
}

static int64_t index_of(const work *k, const int32_t v[3])
{
    return v[0] + k->dims[0] * (v[1] + (int64_t)k->dims[1] * v[2]);
}

/* Returns the density at (u, v, w), or 0 outside the grid. */
static int density_at(const work *k, const ost_volume *volume, double u, double v, double w)
{
    int32_t at[3];
    for (int a = 0; a < 3; a++) {
        const double i = floor(
            (k->frame.at[a] + u * k->frame.u[a] + v * k->frame.v[a] + w * k->frame.w[a] - k->origin[a]) / k->spacing +
            0.5);
        if (!(i >= 0 && i < k->dims[a]))
            return 0;
        at[a] = (int32_t)i;
    }
    return volume->voxels[index_of(k, at)];
}

/*
 * Returns the position w at which a ray along w first meets bone, with an error of at most half a step. Returns NAN if
 * the ray meets no bone.
 */
static double ray(const work *k, const ost_volume *volume, double u, double v, double from)
{
    const double step = fmax(k->spacing / 4, 0.05);
    for (double w = from; w < INSIDE_MM; w += step)
        if (density_at(k, volume, u, v, w) >= k->threshold)
            return w - step / 2;
    return NAN;
}

/*
 * Returns the mean position w at which four rays through a cell of the map meet bone. With four rays, both voxels
 * contribute to a cell on their border. Returns NAN if fewer than two rays meet bone.
 */
static double surface(const work *k, const ost_volume *volume, double u, double v)
{
    double sum = 0;
    int met = 0;
    for (int i = 0; i < 4; i++) {
        const double w = ray(k, volume, u + (i % 2 - 0.5) * OST_METRICS_PITCH_MM / 2,
                             v + (i / 2 - 0.5) * OST_METRICS_PITCH_MM / 2, -OUTSIDE_MM);
        sum += isnan(w) ? 0 : w;
        met += !isnan(w);
    }
    return met >= 2 ? sum / met : NAN;
}

static double at_cell(int i)
{
    return (i - MAP / 2) * OST_METRICS_PITCH_MM;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool is_floor(const work *k, int i)
{
    return !isnan(k->out->depth_mm[i]) && !isnan(k->out->after_mm[i]) && !k->out->drilled[i];
}

/*
 * Stores the points of the floor's cells, except near the floor's rim: all cells within RIM cells of a stored cell
 * belong to the floor. Near the rim, cells from which very little bone was removed do not count as floor; the
 * remaining, deeper cells would distort the fit.
 */
static void leave_rim(work *k)
{
    k->floor_count = 0;
    for (int y = RIM; y < MAP - RIM; y++)
        for (int x = RIM; x < MAP - RIM; x++) {
            bool within = true;
            for (int dy = -RIM; dy <= RIM && within; dy++)
                for (int dx = -RIM; dx <= RIM && within; dx++)
                    within = is_floor(k, x + dx + MAP * (y + dy));
            if (within)
                memcpy(k->floor[k->floor_count++],
                       (double[3]){at_cell(x), at_cell(y), (double)k->out->after_mm[x + MAP * y]}, sizeof k->floor[0]);
        }
}

/*
 * Returns true if the cell or a neighbouring cell is drilled. Some rays of such a cell enter the hole, so the mean
 * depth of the cell is neither that of the floor nor that of the hole.
 */
static bool at_hole(const work *k, int i)
{
    const int x = i % MAP, y = i / MAP;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++)
            if (x + dx >= 0 && x + dx < MAP && y + dy >= 0 && y + dy < MAP && k->out->drilled[x + dx + MAP * (y + dy)])
                return true;
    return false;
}

static bool is_drilled(const work *k, int64_t i)
{
    return k->mark && k->mark[i];
}

/* Marks the cells through which a drill removed bone. */
static void mark_cells(work *k)
{
    int64_t i = 0;
    for (int32_t z = 0; k->mark && z < k->dims[2]; z++)
        for (int32_t y = 0; y < k->dims[1]; y++)
            for (int32_t x = 0; x < k->dims[0]; x++, i++) {
                if (!k->mark[i] || k->before->voxels[i] < k->threshold || k->after->voxels[i] >= k->threshold)
                    continue;
                const double p[3] = {k->origin[0] + x * k->spacing - k->frame.at[0],
                                     k->origin[1] + y * k->spacing - k->frame.at[1],
                                     k->origin[2] + z * k->spacing - k->frame.at[2]};
                const int half = (int)ceil(k->spacing / OST_METRICS_PITCH_MM / 2);
                const long u = lrint(ost_vector_dot(p, k->frame.u) / OST_METRICS_PITCH_MM) + MAP / 2,
                           v = lrint(ost_vector_dot(p, k->frame.v) / OST_METRICS_PITCH_MM) + MAP / 2;
                for (long b = v - half; b <= v + half; b++)
                    for (long a = u - half; a <= u + half; a++)
                        if (a >= 0 && b >= 0 && a < MAP && b < MAP)
                            k->out->drilled[a + MAP * b] = true;
            }
}

/* Computes the maps. Computes the floor from the cells in which bone was removed, but not by a drill. */
static void walk_voxels(work *k)
{
    ost_metrics *o = k->out;
    double depth[CELLS], sum = 0;
    size_t cells = 0;
#pragma omp parallel for schedule(dynamic, 64)
    for (int i = 0; i < CELLS; i++) {
        const double u = at_cell(i % MAP), v = at_cell(i / MAP);
        const double old = surface(k, k->before, u, v), now = isnan(old) ? NAN : surface(k, k->after, u, v);
        o->before_mm[i] = (float)old;
        o->after_mm[i] = (float)now;
        o->depth_mm[i] = NAN;
        if (isnan(old) || !(isnan(now) || now - old > k->spacing / 8))
            continue;
        o->depth_mm[i] = (float)((isnan(now) ? INSIDE_MM : now) - old);
    }
    for (int i = 0; i < CELLS; i++) {
        if (!is_floor(k, i) || at_hole(k, i))
            continue;
        const double below = (double)o->after_mm[i] - k->plan->depth_mm;
        depth[cells++] = (double)o->depth_mm[i];
        sum += (double)o->depth_mm[i];
        o->over_percent += below > MARGIN_MM;
        o->over_max_mm = fmax(o->over_max_mm, below);
    }
    if (cells == 0)
        return;
    o->over_percent *= 100.0 / (double)cells;
    qsort(depth, cells, sizeof depth[0], ascending);
    leave_rim(k);
    o->floor_mm2 = (double)cells * OST_METRICS_PITCH_MM * OST_METRICS_PITCH_MM;
    o->depth_mean_mm = sum / (double)cells;
    o->depth_p95_mm = depth[(cells - 1) * 95 / 100];
    o->depth_max_mm = depth[cells - 1];
}

/*
 * Computes by how many degrees the outward direction deviates from lateral: *back is the angle towards posterior, and
 * *up is the angle towards superior. Both are measured in the planes of the CT.
 */
static void angles(const work *k, const double inward[3], double *back, double *up)
{
    const double lateral = k->plan->left ? -inward[0] : inward[0];
    *back = atan2(-inward[1], lateral) * DEG;
    *up = atan2(-inward[2], lateral) * DEG;
}

static void fit_floor(work *k)
{
    ost_metrics *o = k->out;
    double c[3], radius, gaps[CELLS];
    if (k->floor_count < FLOOR_MIN || !ost_fit_sphere((const double(*)[3])k->floor, k->floor_count, c, &radius) ||
        c[2] > 0)
        return;
    double square = 0, contact = 0;
    for (size_t i = 0; i < k->floor_count; i++) {
        const double *p = k->floor[i], d[3] = {p[0] - c[0], p[1] - c[1], p[2] - c[2]},
                     gap = sqrt(ost_vector_dot(d, d)) - radius;
        square += gap * gap;
        contact += fabs(gap) <= fmax(OST_METRICS_CONTACT_UM * 1e-3, 0.6 * k->spacing);
        gaps[i] = gap;
    }
    qsort(gaps, k->floor_count, sizeof gaps[0], ascending);
    /* Ignores the largest 1 % of the gaps, which may be at edges of voxels. */
    o->gap_max_mm = fmax(0, gaps[(k->floor_count - 1) * 99 / 100]);
    o->sphere = true;
    o->sphere_mm = radius;
    o->fit_rms_mm = sqrt(square / (double)k->floor_count);
    o->contact_percent = 100 * contact / (double)k->floor_count;
    o->centre_depth_mm = c[2] + sqrt(fmax(0, radius * radius - c[0] * c[0] - c[1] * c[1]));
}

/*
 * Computes depth, tilt and entry from the poses of the reamer. Computes version and inclination of the plan and of the
 * reamer, and their differences.
 */
static void measure_axis(work *k, const ost_metrics_motion *motion)
{
    ost_metrics *o = k->out;
    const ost_tool_way way = motion ? ost_tool_way_of(motion, OST_METRICS_REAMER, &k->frame, WINDOW_MM)
                                    : (ost_tool_way){0};
    o->scapular = ost_scapular_frame(k->plan, &k->scapular);
    if (o->scapular)
        ost_scapular_angles(&k->scapular, k->frame.w, &o->version_planned_deg, &o->inclination_planned_deg);
    else
        angles(k, k->frame.w, &o->version_planned_deg, &o->inclination_planned_deg);
    if (!way.cut)
        return;
    o->reamed = true;
    o->reach_mm = way.reach_mm;
    o->tilt_deg = way.tilt_deg;
    o->entry_mm = way.entry_mm;
    if (o->scapular)
        ost_scapular_angles(&k->scapular, way.axis, &o->version_deg, &o->inclination_deg);
    else
        angles(k, way.axis, &o->version_deg, &o->inclination_deg);
    o->version_error_deg = o->version_deg - o->version_planned_deg;
    o->inclination_error_deg = o->inclination_deg - o->inclination_planned_deg;
}

/*
 * Counts all removed voxels by class and position. Increases slabs[i] by the volume in mm^3 that drills removed from i
 * to i + 1 mm below the plan's centre.
 */
static ost_status count_voxels(work *k, const ost_density_classes *classes, double slabs[SLABS], ost_error *err)
{
    ost_metrics *o = k->out;
    const double mm3 = k->spacing * k->spacing * k->spacing, reach = MAP / 2 * OST_METRICS_PITCH_MM;
    double plate = 0, remaining = 0;
    int64_t i = 0, removed = 0;
    for (int32_t z = 0; z < k->dims[2]; z++)
        for (int32_t y = 0; y < k->dims[1]; y++)
            for (int32_t x = 0; x < k->dims[0]; x++, i++) {
                const int was = k->before->voxels[i];
                if (was < k->threshold)
                    continue;
                const bool gone = k->after->voxels[i] < k->threshold;
                if (!gone && was < HARD_HU)
                    continue;
                const double p[3] = {k->origin[0] + x * k->spacing - k->frame.at[0],
                                     k->origin[1] + y * k->spacing - k->frame.at[1],
                                     k->origin[2] + z * k->spacing - k->frame.at[2]};
                const double u = ost_vector_dot(p, k->frame.u), v = ost_vector_dot(p, k->frame.v),
                             w = ost_vector_dot(p, k->frame.w);
                const bool on_map = fabs(u) <= reach && fabs(v) <= reach;
                const int cell = on_map ? (int)lrint(u / OST_METRICS_PITCH_MM) + MAP / 2 +
                                              MAP * ((int)lrint(v / OST_METRICS_PITCH_MM) + MAP / 2)
                                        : 0;
                if (on_map && was >= HARD_HU) {
                    const double below = w - (double)o->before_mm[cell];
                    if (is_floor(k, cell) && below >= -k->spacing && below <= PLATE_MM) {
                        plate += mm3;
                        remaining += gone ? 0 : mm3;
                    }
                }
                if (!gone)
                    continue;
                int c = classes->count - 1;
                while (c > 0 && was < classes->border[c])
                    c--;
                o->removed_by_class_mm3[c] += mm3;
                removed++;
                if (is_drilled(k, i)) {
                    if (w > 0 && (int)w < SLABS)
                        slabs[(int)w] += mm3;
                } else if (w > k->plan->depth_mm + MARGIN_MM)
                    o->over_mm3 += mm3;
            }
    o->removed_mm3 = (double)removed * mm3;
    o->plate_mm3 = plate;
    o->plate_kept_percent = plate > 0 ? 100 * remaining / plate : 0;
    return removed ? OST_OK : ost_fail(err, OST_ERR_INPUT, "no bone was removed, so there is nothing to measure");
}

/*
 * Returns the thickness of the hole's wall: the distance from the hole to the nearest voxel that
 * was not bone before the operation. Only voxels of the hole at ENTRY_MM or deeper are used. The
 * result is at most WALL_MM.
 */
static double wall_of(const work *k)
{
    const int reach = (int)ceil(WALL_MM / k->spacing);
    double nearest = WALL_MM * WALL_MM;
    int64_t i = 0;
    for (int32_t z = 0; z < k->dims[2]; z++)
        for (int32_t y = 0; y < k->dims[1]; y++)
            for (int32_t x = 0; x < k->dims[0]; x++, i++) {
                if (k->before->voxels[i] < k->threshold || k->after->voxels[i] >= k->threshold)
                    continue;
                const double p[3] = {k->origin[0] + x * k->spacing - k->frame.at[0],
                                     k->origin[1] + y * k->spacing - k->frame.at[1],
                                     k->origin[2] + z * k->spacing - k->frame.at[2]};
                if (!is_drilled(k, i) || ost_vector_dot(p, k->frame.w) < ENTRY_MM)
                    continue;
                for (int dz = -reach; dz <= reach; dz++)
                    for (int dy = -reach; dy <= reach; dy++)
                        for (int dx = -reach; dx <= reach; dx++) {
                            const double square = (double)(dx * dx + dy * dy + dz * dz) * k->spacing * k->spacing;
                            const int32_t v[3] = {x + dx, y + dy, z + dz};
                            if (square >= nearest)
                                continue;
                            const bool inside = v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[0] < k->dims[0] &&
                                                v[1] < k->dims[1] && v[2] < k->dims[2];
                            /* Voxels beyond the grid are not counted, because a scan may end in bone. */
                            if (inside && k->before->voxels[index_of(k, v)] < k->threshold)
                                nearest = square;
                        }
            }
    return sqrt(nearest);
}

static void measure_hole(work *k, const ost_metrics_motion *motion, const double slabs[SLABS])
{
    ost_metrics *o = k->out;
    const ost_tool_way way = k->mark ? ost_tool_way_of(motion, OST_METRICS_DRILL, &k->frame, INFINITY)
                                     : (ost_tool_way){0};
    double sum = 0;
    int complete = 0;
    if (!way.cut || way.reach_mm <= 0)
        return;
    /*
     * Uses the slabs below the reamed floor and above the tip. A slab with less than 0.9 of the largest volume is
     * excluded, because the hole is partly outside the bone or the scan there.
     */
    const double from = fmax(o->reamed ? o->reach_mm : 0, 0) + 1;
    double most = 0;
    for (int i = (int)from; i < SLABS; i++)
        most = fmax(most, slabs[i]);
    for (int i = (int)from; i < SLABS && i + 1 <= way.reach_mm; i++) {
        sum += slabs[i] > 0.9 * most ? slabs[i] : 0;
        complete += slabs[i] > 0.9 * most;
    }
    o->hole = true;
    o->hole_depth_mm = way.reach_mm;
    o->hole_angle_deg = way.tilt_deg;
    o->hole_entry_mm = way.entry_mm;
    o->hole_diameter_mm = complete ? 2 * sqrt(sum / complete * cos(way.tilt_deg / DEG) / 3.14159265358979323846) : NAN;
    o->hole_wall_mm = wall_of(k);
    /* The hole is open to the outside if a neighbouring voxel was not bone before the operation. */
    o->hole_breach = o->hole_wall_mm < 1.01 * k->spacing;
}

ost_status ost_metrics_make(const ost_volume *before, const ost_volume *after, int threshold,
                            const ost_density_classes *classes, const ost_metrics_plan *plan,
                            const ost_metrics_motion *motion, ost_metrics *out, ost_error *err)
{
    work k = {.before = before, .after = after, .threshold = threshold, .plan = plan, .out = out};
    double slabs[SLABS] = {0};
    *out = (ost_metrics){0};
    ost_status status = set_up(&k, motion, err);
    if (status == OST_OK) {
        mark_cells(&k);
        walk_voxels(&k);
        status = count_voxels(&k, classes, slabs, err);
    }
    if (status == OST_OK) {
        measure_axis(&k, motion);
        fit_floor(&k);
        measure_hole(&k, motion, slabs);
        ost_metrics_rim(out);
    }
    free(k.floor);
    free(k.mark);
    return status;
}
