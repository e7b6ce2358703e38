/* SPDX-License-Identifier: Apache-2.0 */
/* Converts poses to doubles for pictures, forces and devices. The arithmetic of voxels does not use these functions. */
#include <osteon/pose.h>

#include <math.h>

void ost_pose_to_doubles(const ost_pose *pose, double t_mm[3], double q[4])
{
    t_mm[0] = ost_pm_to_mm(pose->t.x);
    t_mm[1] = ost_pm_to_mm(pose->t.y);
    t_mm[2] = ost_pm_to_mm(pose->t.z);
    q[0] = (double)pose->qw / OST_Q30_ONE;
    q[1] = (double)pose->qx / OST_Q30_ONE;
    q[2] = (double)pose->qy / OST_Q30_ONE;
    q[3] = (double)pose->qz / OST_Q30_ONE;
}

/* Computes the largest component of q first, and divides by it to compute the others (Shepperd 1978). */
void ost_quaternion_of_columns(const double c[3][3], double q[4])
{
    const double trace = c[0][0] + c[1][1] + c[2][2];
    int large = -1;
    double most = trace;
    for (int a = 0; a < 3; a++)
        if (c[a][a] > most) {
            most = c[a][a];
            large = a;
        }
    if (large < 0) {
        const double w = 0.5 * sqrt(1 + trace);
        q[0] = w;
        q[1] = (c[1][2] - c[2][1]) / (4 * w);
        q[2] = (c[2][0] - c[0][2]) / (4 * w);
        q[3] = (c[0][1] - c[1][0]) / (4 * w);
        return;
    }
    const int i = large, j = (i + 1) % 3, k = (i + 2) % 3;
    const double v = 0.5 * sqrt(1 + c[i][i] - c[j][j] - c[k][k]);
    q[0] = (c[j][k] - c[k][j]) / (4 * v);
    q[1 + i] = v;
    q[1 + j] = (c[i][j] + c[j][i]) / (4 * v);
    q[1 + k] = (c[k][i] + c[i][k]) / (4 * v);
}
