/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Section 3.2.6 of the thesis leaves open whether a finer grid of the tool cuts more accurately. This item measures the
 * accuracy with tools whose exact shape is known: a ball and a cylinder, in random poses, in a bone that is full of
 * active voxels.
 *
 *   removed:  the voxels that an event with the tool's grid removes
 *   inside:   the voxels whose centre is inside the exact solid at the same pose
 *
 *   A   volume of the voxels that are only in one of these two sets          error of the tool's grid alone
 *   B   volume in which the removed voxels, as cubes, and the solid differ   total error
 *   C   volume in which the voxels inside, as cubes, and the solid differ    error of the bone's grid alone
 *
 * An error is a volume divided by the area of the solid's surface, that is, the mean distance between the cut surface
 * and the exact surface. Volumes within a voxel are computed from SUB^3 points. The tools' meshes have SEGMENTS
 * segments, so they differ from the solids by less than 0.1 um.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/phantom.h>

#include "bench/inputs.h"
#include "reproduction/item.h"

enum { TOOL, BONE_VOXEL, TOOL_VOXEL, RATIO, VOXELS, GRID, BONE, TOTAL, MOST, VOLUME, DIFFERENT };
enum { POSES = 12, POSES_QUICK = 2, SUB = 5, SEGMENTS = 720, DENSITY = 1000, MARGIN = 3 };
#define SEED UINT64_C(20260326)
#define PI 3.14159265358979323846

/* A solid in the frame of the tool: a ball whose lowest point is the origin, or a cylinder from z = 0 to z = length. */
typedef struct solid {
    const char *name;
    ost_tool_kind kind;
    ost_tool_part part;
    double radius, length; /* in mm; length is 0 for a ball */
} solid;

static const solid solids[] = {{"ball, 10 mm", OST_TOOL_BURR, OST_TOOL_HEAD, 5, 0},
                               {"cylinder, 6 x 30 mm", OST_TOOL_PEG, OST_TOOL_COMPLETE, 3, 30}};

/* Returns the signed distance of a point from the surface of the solid. The distance is negative inside. */
static double distance_from(const solid *s, const double p[3])
{
    const double across = sqrt(p[0] * p[0] + p[1] * p[1]);
    if (s->length == 0)
        return sqrt(across * across + (p[2] - s->radius) * (p[2] - s->radius)) - s->radius;
    const double side = across - s->radius, end = fabs(p[2] - s->length / 2) - s->length / 2;
    if (side <= 0 && end <= 0)
        return fmax(side, end);
    return sqrt(fmax(side, 0) * fmax(side, 0) + fmax(end, 0) * fmax(end, 0));
}

static double volume_of(const solid *s)
{
    return s->length == 0 ? 4.0 / 3 * PI * pow(s->radius, 3) : PI * s->radius * s->radius * s->length;
}

static double area_of(const solid *s)
{
    return s->length == 0 ? 4 * PI * s->radius * s->radius : 2 * PI * s->radius * (s->length + s->radius);
}

/* ------------------------------------------------------------------- poses */

/* Returns a random number from 0 to 1 (splitmix64). */
static double draw(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* Returns a random pose with a uniformly distributed rotation. The solid is in the middle of a bone of side^3 voxels,
   displaced by a random fraction of a voxel. */
static ost_status draw_pose(const solid *s, int32_t side, double voxel, uint64_t *state, ost_pose *out, ost_error *err)
{
    const double u = draw(state), a = 2 * PI * draw(state), b = 2 * PI * draw(state);
    const double q[4] = {sqrt(u) * cos(b), sqrt(1 - u) * sin(a), sqrt(1 - u) * cos(a), sqrt(u) * sin(b)};
    const double middle = s->length == 0 ? s->radius : s->length / 2;
    /* The solid's centre is (0, 0, middle) in the tool's frame. */
    const double turned[3] = {2 * (q[1] * q[3] + q[0] * q[2]) * middle, 2 * (q[2] * q[3] - q[0] * q[1]) * middle,
                              (q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]) * middle};
    double t[3];
    for (int i = 0; i < 3; i++)
        t[i] = voxel * ((side - 1) / 2.0 + draw(state) - 0.5) - turned[i];
    return ost_pose_from_doubles(t, q, out, err);
}

/* Transforms a point of the bone's frame into the tool's frame. */
static void to_tool(const double t[3], const double q[4], const double bone[3], double out[3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double d[3] = {bone[0] - t[0], bone[1] - t[1], bone[2] - t[2]};
    const double m[3][3] = {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}};
    for (int i = 0; i < 3; i++)
        out[i] = m[0][i] * d[0] + m[1][i] * d[1] + m[2][i] * d[2];
}

/* --------------------------------------------------------------- measuring */

typedef struct sums {
    double grid, bone, total;      /* volumes of the errors A, C and B (see above) in mm^3, summed over the poses */
    /*
     * `removed` is the removed volume in mm^3. `voxels` is the number of voxels that are in only one of the two sets,
     * and `worst` is the greatest distance in mm from the centre of such a voxel to the solid's surface.
     */
    double removed, worst, voxels;
    int poses;
} sums;

typedef struct job {
    const reproduction *r;
    const solid *solid;
    ost_geometry bone;
    double voxel; /* mm */
    int16_t *full, *after;
    ost_error *err;
} job;

/* Returns the fraction of a voxel's volume that lies inside the solid. The voxel's centre is `centre`. */
static double share_inside(const job *j, const double t[3], const double q[4], const double centre[3])
{
    int inside = 0;
    for (int k = 0; k < SUB; k++)
        for (int l = 0; l < SUB; l++)
            for (int m = 0; m < SUB; m++) {
                double p[3];
                const double at[3] = {centre[0] + j->voxel * ((m + 0.5) / SUB - 0.5),
                                      centre[1] + j->voxel * ((l + 0.5) / SUB - 0.5),
                                      centre[2] + j->voxel * ((k + 0.5) / SUB - 0.5)};
                to_tool(t, q, at, p);
                inside += distance_from(j->solid, p) <= 0;
            }
    return (double)inside / (SUB * SUB * SUB);
}

/* Compares the removed voxels with the solid at the pose, and adds the errors to *sum. */
static void compare(const job *j, const ost_pose *pose, sums *sum)
{
    const ost_dims d = j->bone.dims;
    const double cube = pow(j->voxel, 3), reach = j->voxel * sqrt(3) / 2;
    double t[3], q[4];
    ost_pose_to_doubles(pose, t, q);
    const int16_t *after = j->after;
    for (int32_t z = 0; z < d.z; z++)
        for (int32_t y = 0; y < d.y; y++)
            for (int32_t x = 0; x < d.x; x++) {
                const double centre[3] = {j->voxel * x, j->voxel * y, j->voxel * z};
                const bool removed = *after++ == 0;
                double p[3];
                to_tool(t, q, centre, p);
                const double away = distance_from(j->solid, p);
                const bool inside = away <= 0;
                sum->removed += removed ? cube : 0;
                if (removed != inside) {
                    sum->grid += cube;
                    sum->voxels++;
                    sum->worst = fmax(sum->worst, fabs(away));
                }
                const double share = fabs(away) > reach ? inside : share_inside(j, t, q, centre);
                sum->bone += cube * (inside ? 1 - share : share);
                sum->total += cube * (removed ? 1 - share : share);
            }
    sum->poses++;
}

/* Removes voxels from a full bone at random poses. The poses are the same for every size of tool voxels. */
static ost_status run_poses(job *j, ost_backend *backend, ost_tool *tool, sums *sum)
{
    const ost_tool_geometry *grid = ost_tool_geometry_get(tool);
    const ost_density_classes classes = ost_density_classes_default();
    const ost_dims d = j->bone.dims;
    uint64_t state = SEED;
    ost_bone *bone = NULL;
    ost_removal_report report = {.count = 0};
    ost_status status = ost_bone_create(backend, &j->bone, 32, MODEL_THRESHOLD, &bone, j->err);
    const int poses = j->r->bench.quick ? POSES_QUICK : POSES;
    for (int i = 0; i < poses && status == OST_OK; i++) {
        ost_pose pose;
        ost_map map;
        const ost_voxel_box box = {.hi = {d.x, d.y, d.z}};
        const ost_removal_event event = {.pose_count = 1, .maps = &map, .boxes = &box, .classes = &classes};
        status = ost_bone_upload(bone, 0, d.z, j->full, j->err);
        if (status == OST_OK)
            status = draw_pose(j->solid, d.x, j->voxel, &state, &pose, j->err);
        if (status == OST_OK)
            status = ost_map_make(&pose, &j->bone, grid, &map, j->err);
        if (status == OST_OK)
            status = ost_bone_remove(bone, tool, &event, &report, j->err);
        if (status == OST_OK)
            status = ost_bone_download(bone, 0, d.z, j->after, j->err);
        if (status == OST_OK)
            compare(j, &pose, sum);
    }
    ost_removal_report_free(&report);
    ost_bone_free(bone);
    return status;
}

static ost_status make_tool(const solid *s, ost_pm voxel, ost_backend *backend, ost_tool **out, ost_error *err)
{
    const ost_pm um = OST_PM_PER_MM / 1000;
    const ost_tool_options options = {.diameter = (ost_pm)(2000 * s->radius) * um,
                                      .length = (ost_pm)(1000 * s->length) * um,
                                      .segments = SEGMENTS,
                                      .part = s->part};
    return bench_tool_make(backend, s->kind, &options, voxel, out, err);
}

static void add_row(result *out, const job *j, ost_pm voxel, const ost_tool *tool, const sums *sum)
{
    const double area = area_of(j->solid) * sum->poses, mm = ost_pm_to_mm(voxel);
    result_add_row(out);
    result_set_text(out, TOOL, "%s; bone %.3g mm", j->solid->name, j->voxel);
    result_set(out, BONE_VOXEL, j->voxel);
    result_set(out, TOOL_VOXEL, mm);
    result_set(out, RATIO, mm / j->voxel);
    result_set(out, VOXELS, (double)ost_dims_count(ost_tool_geometry_get(tool)->dims));
    result_set(out, GRID, 1e3 * sum->grid / area);
    result_set(out, BONE, 1e3 * sum->bone / area);
    result_set(out, TOTAL, 1e3 * sum->total / area);
    result_set(out, MOST, 1e3 * sum->worst);
    result_set(out, VOLUME, 100 * (sum->removed / (volume_of(j->solid) * sum->poses) - 1));
    result_set(out, DIFFERENT, sum->voxels / sum->poses);
}

static ost_status run_case(const reproduction *r, result *out, const solid *s, ost_pm bone_voxel, ost_backend *backend,
                           ost_error *err)
{
    static const ost_pm voxels[] = {OST_PM_PER_MM, 3 * OST_PM_PER_MM / 4, OST_PM_PER_MM / 2, OST_PM_PER_MM / 4,
                                    OST_PM_PER_MM / 8};
    job j = {.r = r, .solid = s, .voxel = ost_pm_to_mm(bone_voxel), .err = err};
    const double longest = s->length == 0 ? 2 * s->radius : sqrt(s->length * s->length + 4 * s->radius * s->radius);
    const int32_t side = (int32_t)ceil(longest / j.voxel) + 2 * MARGIN + (int32_t)ceil(2 / j.voxel);
    j.bone = (ost_geometry){.dims = {side, side, side}, .spacing = {bone_voxel, bone_voxel, bone_voxel}};
    const size_t count = (size_t)ost_dims_count(j.bone.dims);
    j.full = malloc(count * sizeof *j.full);
    j.after = malloc(count * sizeof *j.after);
    ost_status status = j.full && j.after ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone");
    for (size_t i = 0; i < count && status == OST_OK; i++)
        j.full[i] = DENSITY;
    for (size_t v = 0; v < sizeof voxels / sizeof voxels[0] && status == OST_OK; v++) {
        ost_tool *tool = NULL;
        sums sum = {.poses = 0};
        reproduction_show(r, "accuracy of the cut", (double)v / 5);
        status = make_tool(s, voxels[v], backend, &tool, err);
        if (status == OST_OK)
            status = run_poses(&j, backend, tool, &sum);
        if (status == OST_OK)
            add_row(out, &j, voxels[v], tool, &sum);
        ost_tool_free(tool);
    }
    free(j.full);
    free(j.after);
    return status;
}

/*
 * Returns the cells of the first row with these voxel sizes of the bone and the tool, in mm. The first such row
 * belongs to the ball. Returns NULL if there is none.
 */
static const result_cell *row_of(const result *out, double bone, double tool)
{
    for (size_t i = 0; i < out->row_count; i++)
        if (fabs(out->row[i].cell[BONE_VOXEL].value - bone) < 1e-6 &&
            fabs(out->row[i].cell[TOOL_VOXEL].value - tool) < 1e-6)
            return out->row[i].cell;
    return NULL;
}

static void judge(result *out)
{
    const result_cell *a = row_of(out, 0.47, 1), *b = row_of(out, 0.47, 0.5), *c = row_of(out, 0.47, 0.25),
                      *d = row_of(out, 0.47, 0.125);
    if (!a || !b || !c || !d)
        return;
    result_add_finding(
        out, RESULT_ANSWERED, "section 3.2.6",
        "Open question: does a finer voxel grid of the tool cut more accurately?",
        "%s, but only down to about half of a bone voxel. For the ball in a bone of 0.47 mm, the tool's "
        "grid alone displaces the cut by %.0f, %.0f, %.0f and %.0f um with tool voxels of 1, 0.5, 0.25 and "
        "0.125 mm. The bone's own voxels displace it by %.0f um, so that the total error is %.0f, %.0f, %.0f "
        "and %.0f um: 0.5 mm to 0.25 mm gains %.0f %%, a step further %.0f %%.",
        c[GRID].value < b[GRID].value && b[GRID].value < a[GRID].value ? "Yes" : "Not always", a[GRID].value,
        b[GRID].value, c[GRID].value, d[GRID].value, b[BONE].value, a[TOTAL].value, b[TOTAL].value, c[TOTAL].value,
        d[TOTAL].value, 100 * (1 - c[TOTAL].value / b[TOTAL].value), 100 * (1 - d[TOTAL].value / c[TOTAL].value));
}

ost_status item_accuracy(reproduction *r, result *out, ost_error *err)
{
    static const ost_pm bones[] = {47 * OST_PM_PER_MM / 100, OST_PM_PER_MM / 4};
    ost_backend *backend = NULL;
    result_add_column(out, "case", "solid", "text");
    result_add_column(out, "bone_voxel_mm", "bone voxel", "mm");
    result_add_column(out, "tool_voxel_mm", "tool voxel", "mm");
    result_add_column(out, "ratio", "tool voxel / bone voxel", "");
    result_add_column(out, "tool_voxels", "voxels of the tool's grid", "");
    result_add_column(out, "tool_grid_error_um", "error of the tool's grid", "um");
    result_add_column(out, "bone_grid_error_um", "error of the bone's grid", "um");
    result_add_column(out, "total_error_um", "total error", "um");
    result_add_column(out, "worst_um", "farthest wrong voxel", "um");
    result_add_column(out, "volume_percent", "removed volume, deviation", "%");
    result_add_column(out, "wrong_voxels", "wrong voxels per event", "");
    ost_status status = bench_backend(&r->bench, r->bench.threads, &backend, err);
    for (size_t s = 0; s < sizeof solids / sizeof solids[0]; s++)
        for (size_t b = 0; b < sizeof bones / sizeof bones[0] && status == OST_OK; b++)
            if (!r->bench.quick || b == 0)
                status = run_case(r, out, &solids[s], bones[b], backend, err);
    ost_backend_close(backend);
    if (status == OST_OK && !out->out_of_memory)
        judge(out);
    result_add_remark(
        out,
        "An error is the volume between the cut and the exact solid divided by the solid's area: the mean "
        "distance of the two surfaces. %d random poses per row, the same for every tool voxel, seed "
        "%llu. The error of the bone's grid remains with an exact tool, because a voxel is removed "
        "completely or not at all.",
        r->bench.quick ? POSES_QUICK : POSES, (unsigned long long)SEED);
    result_plot *p = result_add_plot(out, RESULT_PLOT_LINES, "Total error of the cut", "edge of a tool voxel (mm)",
                                     "mean distance from the exact surface (um)");
    p->x = TOOL_VOXEL;
    p->group = TOOL;
    p->value[p->values++] = TOTAL;
    p->log_x = true;
    p = result_add_plot(out, RESULT_PLOT_LINES, "Error of the tool's grid alone", "edge of a tool voxel (mm)",
                        "mean distance (um)");
    p->x = TOOL_VOXEL;
    p->group = TOOL;
    p->value[p->values++] = GRID;
    p->log_x = p->log_y = true;
    return status;
}
