/* SPDX-License-Identifier: Apache-2.0 */
/*
 *   touch                         press
 *      tool   |/////|               tool   |/////|
 *             '--.--'                      '--.--'
 *      a voxel   | v outward        . . . . . | . . . . surface of the bone
 *      ########  x  ###########     #### layer| ^ depth
 *      ######## bone ##########     ##########x | ####
 *
 * Bone begins half-way between the centres of the last active voxel on the way
 * inward and of the first that is not, projected on the normal: the plane
 * through a voxel of McNeely, Puterbaugh and Troy (1999), moved to where the
 * voxel ends.
 */
#include "force/contact.h"

#include <math.h>

#include "core/backend.h"

double ost_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void ost_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

void ost_contact_turn(const ost_shell *shell, const ost_pose *pose, contact *out)
{
    double w = pose->qw, x = pose->qx, y = pose->qy, z = pose->qz;
    const double n = w * w + x * x + y * y + z * z;
    const double m[3][3] = {{(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n},
                            {2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n},
                            {2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n}};
    out->count = shell->count;
    for (int a = 0; a < 3; a++)
        out->axis[a] = m[a][2];
    for (size_t i = 0; i < shell->count; i++) {
        const ost_shell_point *from = &shell->points[i];
        contact_point *p = &out->points[i];
        *p = (contact_point){.area = from->area, .cutting = from->cutting};
        for (int a = 0; a < 3; a++) {
            p->r[a] = ost_dot(m[a], from->at);
            p->inward[a] = ost_dot(m[a], from->inward);
        }
    }
}

/* The voxel that at + r + inward * step lies in. Far away is beyond every grid and fits an int. */
static ost_dims voxel_at(const ost_geometry *g, const double at[3], const contact_point *p, double step)
{
    const int64_t origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    const double s = (double)g->spacing.x * OST_M_PER_PM;
    int32_t v[3];
    for (int a = 0; a < 3; a++) {
        const double index = floor((at[a] + p->r[a] + p->inward[a] * step - (double)origin[a] * OST_M_PER_PM) / s + 0.5);
        v[a] = index > -1e6 && index < 1e6 ? (int32_t)index : -1;
    }
    return (ost_dims){v[0], v[1], v[2]};
}

ost_status ost_contact_touch(const ost_bone *bone, const double at[3], contact *c, int *touching, ost_error *err)
{
    const double s = (double)bone->geometry.spacing.x * OST_M_PER_PM;
    *touching = 0;
    for (size_t i = 0; i < c->count; i++)
        c->voxels[i] = voxel_at(&bone->geometry, at, &c->points[i], -s);
    ost_status status = ost_bone_sample(bone, c->count, c->voxels, c->densities, err);
    for (size_t i = 0; i < c->count && status == OST_OK; i++) {
        c->points[i].density = c->densities[i];
        *touching += c->densities[i] != 0;
    }
    return status;
}

ost_status ost_contact_press(const ost_bone *bone, const double at[3], double layer, contact *c, int *touching, ost_error *err)
{
    const ost_geometry *g = &bone->geometry;
    const int64_t origin[3] = {g->origin.x, g->origin.y, g->origin.z};
    const double s = (double)g->spacing.x * OST_M_PER_PM;
    ost_status status = OST_OK;
    size_t left = c->count;
    *touching = 0;
    for (size_t i = 0; i < left; i++)
        c->which[i] = (uint16_t)i;
    /* Step by step inward, all points that are still in bone at once. before: the plane of the last active voxel. */
    for (double step = -layer; left > 0 && step < layer; step += s / 2) {
        for (size_t k = 0; k < left; k++)
            c->voxels[k] = voxel_at(g, at, &c->points[c->which[k]], step);
        status = ost_bone_sample(bone, left, c->voxels, c->densities, err);
        if (status != OST_OK)
            return status;
        size_t kept = 0;
        for (size_t k = 0; k < left; k++) {
            contact_point *p = &c->points[c->which[k]];
            const int32_t v[3] = {c->voxels[k].x, c->voxels[k].y, c->voxels[k].z};
            double plane = 0;
            for (int a = 0; a < 3; a++)
                plane += ((double)origin[a] * OST_M_PER_PM + v[a] * s - at[a] - p->r[a]) * p->inward[a];
            if (c->densities[k] == 0) {
                /* Out of the bone; one that never was in it touches nothing. */
                if (p->density)
                    p->depth = (p->depth + plane) / 2 + layer;
                continue;
            }
            *touching += p->density == 0;
            p->density = p->density ? p->density : c->densities[k];
            p->depth = plane;
            c->which[kept++] = c->which[k];
        }
        left = kept;
    }
    for (size_t k = 0; k < left; k++)
        c->points[c->which[k]].depth = 2 * layer;
    for (size_t i = 0; i < c->count; i++)
        c->points[i].depth = c->points[i].density == 0 || c->points[i].depth < 0 ? 0 : c->points[i].depth;
    return OST_OK;
}
