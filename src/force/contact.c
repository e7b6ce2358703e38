/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the points that touch bone (touch), or whose elastic layer is compressed by bone (press).
 *
 *   touch                         press
 *      tool   |/////|               tool   |/////|
 *             '--.--'                      '--.--'
 *      a voxel   | v outward        . . . . . | . . . . surface of the bone
 *      ########  x  ###########     #### layer| ^ depth
 *      ######## bone ##########     ##########x | ####
 *
 * Two voxel centres are projected onto the inward normal of a point: that of the
 * last active voxel and that of the next voxel, which is not active.  The surface of
 * the bone lies half-way between the two projections.  McNeely, Puterbaugh and Troy (1999)
 * use a tangent plane through the centre of the voxel; here the plane is at the
 * border of the voxel.
 */
#include "force/contact.h"

#include <math.h>
#include <string.h>

#include "core/backend.h"
#include "core/vector.h"

/* distance from the axis, in m; a point nearer to the axis gets the cutting speed at this distance */
#define NEAR_AXIS 1e-3

/* Vectors of four elements; the compiler chooses the registers. */
typedef float four __attribute__((vector_size(16)));
typedef int32_t four_integers __attribute__((vector_size(16)));

/* Maximum reach of a tool in voxels. Beyond this reach, positions in float are not accurate enough. */
#define REACH_MAX 32768.0

void ost_turn_of(const double q[4], double turn[3][3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3], n = w * w + x * x + y * y + z * z;
    const double m[3][3] = {{(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n},
                            {2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n},
                            {2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n}};
    memcpy(turn, m, sizeof m);
}

void ost_into_bone(const contact_pose *pose, const double v[3], double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = ost_vector_dot(pose->turn[a], v);
}

void ost_into_tool(const contact_pose *pose, const double v[3], double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = pose->turn[0][a] * v[0] + pose->turn[1][a] * v[1] + pose->turn[2][a] * v[2];
}

void ost_contact_shell_make(const ost_shell *shell, const ost_force_params *params, double spacing, contact_shell *out)
{
    memset(out, 0, sizeof *out);
    out->count = shell->count;
    for (size_t i = 0; i < shell->count; i++) {
        const ost_shell_point *p = &shell->points[i];
        const double radius = sqrt(p->at[0] * p->at[0] + p->at[1] * p->at[1]);
        for (int a = 0; a < 3; a++) {
            out->at[a][i] = (float)p->at[a];
            out->inward[a][i] = (float)p->inward[a];
            out->outside[a][i] = (float)(p->at[a] - spacing * p->inward[a]);
        }
        /* Viewed along -z, the tool rotates clockwise (AR-MOTOR): a point at (x, y) moves along (y, -x). */
        out->against[0][i] = radius > 0 ? (float)(-p->at[1] / radius) : 0;
        out->against[1][i] = radius > 0 ? (float)(p->at[0] / radius) : 0;
        out->area[i] = (float)p->area;
        out->edge[i] = p->cutting;
        const double away = sqrt(ost_vector_dot(p->at, p->at)) + spacing;
        out->reach = away > out->reach ? away : out->reach;
    }
    ost_contact_shell_speed(out, params);
}

void ost_contact_shell_speed(contact_shell *shell, const ost_force_params *params)
{
    for (size_t i = 0; i < shell->count; i++) {
        const double x = shell->at[0][i], y = shell->at[1][i], radius = sqrt(x * x + y * y);
        const double spin = params->speed * (radius > NEAR_AXIS ? radius : NEAR_AXIS),
                     rigid = shell->area[i] * OST_RIGID;
        shell->cutting[i] = shell->edge[i] && spin > 0;
        const double give = shell->cutting[i] ? shell->area[i] * params->energy / (params->cutting_ratio * spin)
                                              : rigid;
        shell->spin[i] = (float)spin;
        shell->give[i] = (float)(give < rigid ? give : rigid);
    }
}

/*
 * Maps the tool's frame to the bone's voxels: on axis a, the voxel that contains a point p has the index
 * origin[a] + floor(to[a] . p + part[a]).
 * The large part, `origin`, is an integer; the remaining terms are floats.
 */
typedef struct to_voxels {
    float to[3][3], part[3]; /* the elements of `part` are from 0 to 1 */
    int32_t origin[3];
} to_voxels;

/*
 * Computes the map for a pose. Returns false if the pose is not finite, if the tool's reach is REACH_MAX or more, or if
 * the tool cannot overlap the grid. The reach is increased by `more` metres.
 */
static bool map_make(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, double more,
                     to_voxels *map)
{
    const ost_geometry *g = &bone->geometry;
    const double s = (double)g->spacing.x * OST_M_PER_PM, reach = (shell->reach + more) / s + 2;
    const ost_pm origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    if (!(reach < REACH_MAX))
        return false;
    for (int a = 0; a < 3; a++) {
        const double base = (pose->at[a] - (double)origin[a] * OST_M_PER_PM) / s + 0.5;
        if (!(base + reach > 0 && base - reach < dims[a]))
            return false;
        map->origin[a] = (int32_t)(base + REACH_MAX) - (int32_t)REACH_MAX;
        map->part[a] = (float)(base - map->origin[a]);
        for (int b = 0; b < 3; b++)
            map->to[a][b] = (float)(pose->turn[a][b] / s);
    }
    return true;
}

/*
 * Computes the positions of `count` points in voxels relative to map->origin, four at a time.
 * Elements after the last point are set to the position of the tool's origin.
 */
static void positions(const to_voxels *map, const float (*at)[OST_SHELL_MAX], size_t count, contact *c)
{
    for (int a = 0; a < 3; a++) {
        const float x = map->to[a][0], y = map->to[a][1], z = map->to[a][2], part = map->part[a];
        for (size_t i = 0; i < count; i += 4) {
            four p[3];
            memcpy(&p[0], &at[0][i], sizeof p[0]);
            memcpy(&p[1], &at[1][i], sizeof p[1]);
            memcpy(&p[2], &at[2][i], sizeof p[2]);
            const four position = p[0] * x + p[1] * y + p[2] * z + part;
            memcpy(&c->position[a][i], &position, sizeof position);
        }
    }
}

/*
 * Computes the voxel of each position by rounding down. The conversion to integers truncates toward
 * 0, so for negative positions the result can be one too high; the comparison corrects this.
 */
static void voxels_at(const to_voxels *map, size_t count, contact *c)
{
    for (int a = 0; a < 3; a++)
        for (size_t i = 0; i < count; i += 4) {
            four position;
            memcpy(&position, &c->position[a][i], sizeof position);
            const four_integers cut = __builtin_convertvector(position, four_integers);
            const four_integers v = cut + (four_integers)(__builtin_convertvector(cut, four) > position) +
                                    map->origin[a];
            memcpy(&c->voxel[a][i], &v, sizeof v);
        }
}

static ost_status sample_bone(const ost_bone *bone, size_t count, contact *c, ost_error *err)
{
    const int32_t *const at[3] = {c->voxel[0], c->voxel[1], c->voxel[2]};
    return ost_bone_sample(bone, count, at, c->found, err);
}

ost_status ost_contact_touch(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, contact *c,
                             ost_error *err)
{
    to_voxels map;
    c->count = 0;
    if (!map_make(bone, shell, pose, 0, &map))
        return OST_OK;
    positions(&map, shell->outside, shell->count, c);
    voxels_at(&map, shell->count, c);
    ost_status status = sample_bone(bone, shell->count, c, err);
    if (status != OST_OK)
        return status;
    size_t n = 0;
    for (size_t i = 0; i < shell->count; i++) {
        c->which[n] = (uint16_t)i;
        c->density[n] = c->found[i];
        n += c->found[i] != 0;
    }
    c->count = n;
    return OST_OK;
}

/* Computes the displacement in voxels that corresponds to 1 m along the inward normal of point i of the shell. */
static void inward_in_voxels(const to_voxels *map, const contact_shell *shell, size_t i, double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = (double)map->to[a][0] * shell->inward[0][i] + (double)map->to[a][1] * shell->inward[1][i] +
                 (double)map->to[a][2] * shell->inward[2][i];
}

ost_status ost_contact_press(const ost_bone *bone, const contact_shell *shell, const contact_pose *pose, double layer,
                             contact *c, ost_error *err)
{
    const double s = (double)bone->geometry.spacing.x * OST_M_PER_PM;
    /* `walking` contains the indices of the points in the shell, and `slot` their indices among the touching points */
    uint16_t walking[OST_SHELL_MAX], slot[OST_SHELL_MAX];
    to_voxels map;
    c->count = 0;
    if (!map_make(bone, shell, pose, layer, &map))
        return OST_OK;
    positions(&map, shell->at, shell->count, c);
    size_t left = shell->count;
    for (size_t i = 0; i < left; i++)
        walking[i] = (uint16_t)i;
    /*
     * Moves all points that are still in bone inward, by half a voxel per step. The first step
     * determines which points touch bone.
     */
    bool first = true;
    for (double step = -layer; left > 0 && step < layer; step += s / 2, first = false) {
        for (size_t k = 0; k < left; k++) {
            double along[3];
            inward_in_voxels(&map, shell, walking[k], along);
            for (int a = 0; a < 3; a++)
                c->voxel[a][k] = (int32_t)floor(c->position[a][walking[k]] + step * along[a]) + map.origin[a];
        }
        ost_status status = sample_bone(bone, left, c, err);
        if (status != OST_OK)
            return status;
        size_t kept = 0;
        for (size_t k = 0; k < left; k++) {
            const size_t i = walking[k];
            /* `plane` is the distance along the normal from the point to the voxel's centre. */
            double along[3], plane = 0;
            inward_in_voxels(&map, shell, i, along);
            for (int a = 0; a < 3; a++)
                plane += (c->voxel[a][k] - map.origin[a] + 0.5 - c->position[a][i]) * along[a] * s * s;
            if (c->found[k] == 0) {
                /*
                 * The point has left the bone. A point that is outside the bone at the first step does not touch
                 * bone.
                 */
                if (!first)
                    c->depth[slot[k]] = (c->depth[slot[k]] + plane) / 2 + layer;
                continue;
            }
            const size_t to = first ? c->count++ : slot[k];
            if (first) {
                c->which[to] = (uint16_t)i;
                c->density[to] = c->found[k];
            }
            c->depth[to] = plane;
            slot[kept] = (uint16_t)to;
            walking[kept++] = (uint16_t)i;
        }
        left = kept;
    }
    for (size_t k = 0; k < left; k++)
        c->depth[slot[k]] = 2 * layer;
    for (size_t k = 0; k < c->count; k++)
        c->depth[k] = c->depth[k] < 0 ? 0 : c->depth[k];
    return OST_OK;
}
