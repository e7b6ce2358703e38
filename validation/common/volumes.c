/* SPDX-License-Identifier: Apache-2.0 */
/* Checks bodies whose volume is given by a formula. If the borders of a body lie between voxel centres, the volume of
   its voxels must be exact. Otherwise, the volume may deviate by at most the volume of the border's voxels. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/common/lab.h"

#define PI 3.14159265358979323846

/* Checks a box of 7 x 5 x 3 mm with voxels of 0.5 mm. Its faces lie on voxel borders, so 14 x 10 x 6 centres are
   inside. */
static void box(lab *l)
{
    ost_mesh mesh;
    ost_tool_volume v;
    lab_box(l, (ost_pm3){LAB_MM, -2 * LAB_MM, 3 * LAB_MM}, (ost_pm3){8 * LAB_MM, 3 * LAB_MM, 6 * LAB_MM}, false, &mesh);
    lab_voxelize(l, &mesh, NULL, LAB_MM / 2, &v);
    const long long solid = l->status == OST_OK ? (long long)ost_tool_volume_count(&v, OST_TOOL_CUTTING) : 0;
    lab_record(l, "volume", "box", "AR-VOX-4 AR-TOOL-2 REQ-VOLUME", "a box of 7 x 5 x 3 mm in voxels of 0.5 mm",
               solid == 840, "840 voxels, 105 mm3", "%lld voxels", solid);
    ost_tool_volume_free(&v);
    ost_mesh_free(&mesh);
}

/* Makes a mesh of a ball from circles of latitude and longitude. The poles lie on the z axis. */
static void ball_mesh(lab *l, double radius_mm, int around, int rings, ost_mesh *out)
{
    *out = (ost_mesh){.vertex_count = 0};
    const size_t poles = (size_t)around * (size_t)(rings - 1), triangles = 2 * (size_t)around * (size_t)(rings - 1);
    if (l->status == OST_OK)
        l->status = ost_mesh_init(out, poles + 2, triangles, l->err);
    if (l->status != OST_OK)
        return;
    size_t t = 0;
    for (int r = 1; r < rings; r++)
        for (int a = 0; a < around; a++) {
            const double polar = PI * r / rings, turn = 2 * PI * a / around;
            out->vertices[(r - 1) * around + a] = (ost_pm3){llrint(radius_mm * 1e9 * sin(polar) * cos(turn)),
                                                            llrint(radius_mm * 1e9 * sin(polar) * sin(turn)),
                                                            llrint(radius_mm * 1e9 * cos(polar))};
        }
    out->vertices[poles] = (ost_pm3){0, 0, llrint(radius_mm * 1e9)};
    out->vertices[poles + 1] = (ost_pm3){0, 0, -llrint(radius_mm * 1e9)};
    for (int a = 0; a < around; a++) {
        const uint32_t b = (uint32_t)((a + 1) % around), c = (uint32_t)a, last = (uint32_t)((rings - 2) * around);
        out->triangles[t][0] = (uint32_t)poles, out->triangles[t][1] = c, out->triangles[t++][2] = b;
        out->triangles[t][0] = (uint32_t)poles + 1, out->triangles[t][1] = last + b, out->triangles[t++][2] = last + c;
        for (int r = 0; r + 2 < rings; r++) {
            const uint32_t up = (uint32_t)(r * around), down = (uint32_t)((r + 1) * around);
            out->triangles[t][0] = up + c, out->triangles[t][1] = down + c, out->triangles[t++][2] = down + b;
            out->triangles[t][0] = up + c, out->triangles[t][1] = down + b, out->triangles[t++][2] = up + b;
        }
    }
}

/*
 * Checks the volume of a ball with a radius of 10 mm in voxels of 0.5 mm.
 *
 * If a voxel's centre is more than half a voxel diagonal below the surface, the voxel lies completely inside the ball.
 * If its centre is more than half a diagonal above the surface, the voxel lies completely outside. The volume of the
 * voxels is therefore between the volumes of two balls, whose radii are half a diagonal smaller and half a diagonal
 * larger than 10 mm. The smaller radius is also reduced by the mesh's sagitta.
 */
static void ball(lab *l)
{
    enum { AROUND = 96, RINGS = 48 };
    const double r = 10, s = 0.5, d = s * sqrt(3) / 2, inner = r * cos(PI / AROUND) * cos(PI / (2.0 * RINGS));
    const double least = 4.0 / 3 * PI * pow(inner - d, 3), most = 4.0 / 3 * PI * pow(r + d, 3);
    char expected[120];
    ost_mesh mesh;
    ost_tool_volume v;
    ball_mesh(l, r, AROUND, RINGS, &mesh);
    lab_voxelize(l, &mesh, NULL, LAB_MM / 2, &v);
    const double got = l->status == OST_OK ? (double)ost_tool_volume_count(&v, OST_TOOL_CUTTING) * s * s * s : 0,
                 mesh_volume = l->status == OST_OK ? ost_mesh_volume_mm3(&mesh) : 0;
    snprintf(expected, sizeof expected, "between %.1f and %.1f mm3; the mesh has %.1f", least, most, mesh_volume);
    lab_record(l, "volume", "ball", "AR-VOX-4 REQ-VOLUME",
               "a ball of 10 mm radius as 9,024 triangles in voxels of 0.5 mm: the volume is exact to half a voxel "
               "diagonal at the surface",
               got >= least && got <= most, expected, "%.1f mm3, %+.2f %% of the mesh's", got,
               mesh_volume > 0 ? 100 * (got / mesh_volume - 1) : 0.0);
    ost_tool_volume_free(&v);
    ost_mesh_free(&mesh);
}

/* Checks a cube of 4 mm that moves from x = 2 to x = 26 in steps of less than a voxel. It must remove 28 x 4 x 4
   voxels of 1 mm, without a gap. */
static void slot(lab *l)
{
    enum { STEPS = 61 };
    ost_pose poses[STEPS];
    const ost_geometry g = lab_cube(40, 12, 12, LAB_MM);
    for (int k = 0; k < STEPS; k++)
        poses[k] = (ost_pose){{2 * LAB_MM + k * 24 * (LAB_MM / (STEPS - 1)), 4 * LAB_MM, 4 * LAB_MM}, 1 << 30, 0, 0, 0};
    poses[STEPS - 1].t.x = 26 * LAB_MM;
    ost_tool *tool = lab_tool(l, (ost_dims){8, 8, 8}, LAB_MM / 2, (ost_pm3){0, 0, 0}, OST_TOOL_CUTTING);
    const unsigned long long gone = lab_removed(l, &g, tool, poses, STEPS, 400);
    ost_tool_free(tool);
    lab_record(l, "volume", "slot", "AR-REM-1 AR-REM-2 AR-REM-8",
               "a cube of 4 mm moved by 24 mm through a bone of 1 mm voxels", gone == 28 * 4 * 4, "448 voxels, 448 mm3",
               "%llu voxels", gone);
}

/* Checks a cube with an edge of 8 mm that is rotated by 45 degrees about z. In each of the 8 layers of bone voxels,
   the cube contains the integer points with |x| + |y| <= 4 sqrt 2 = 5.66 around its centre. There are 61 such
   points. */
static void turned(lab *l)
{
    ost_pose pose;
    const ost_geometry g = lab_cube(21, 21, 21, LAB_MM);
    const double q[4] = {0.9238795325112867, 0, 0, 0.3826834323650898}, at[3] = {10, 10, 10};
    if (l->status == OST_OK)
        l->status = ost_pose_from_doubles(at, q, &pose, l->err);
    ost_tool *tool = lab_tool(l, (ost_dims){16, 16, 16}, LAB_MM / 2, (ost_pm3){-4 * LAB_MM, -4 * LAB_MM, -4 * LAB_MM},
                              OST_TOOL_CUTTING);
    const unsigned long long gone = l->status == OST_OK ? lab_removed(l, &g, tool, &pose, 1, 400) : 0;
    ost_tool_free(tool);
    lab_record(l, "volume", "turned cube", "AR-REM-1 AR-MAP-1 AR-POSE-4",
               "a cube of 8 mm turned by 45 degrees: |x| + |y| <= 5 in 8 layers", gone == 61 * 8, "488 voxels",
               "%llu voxels", gone);
}

void lab_volumes(lab *l)
{
    box(l);
    ball(l);
    slot(l);
    turned(l);
}
