/* SPDX-License-Identifier: Apache-2.0 */
#include "core/fit.h"

#include <math.h>

#include "core/vector.h"

/* Solves n linear equations by Gauss-Jordan elimination with pivoting. m has n rows and n + 1 columns. */
static bool eliminate(double m[4][5], int n, double x[4])
{
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c + 1; r < n; r++)
            pivot = fabs(m[r][c]) > fabs(m[pivot][c]) ? r : pivot;
        if (fabs(m[pivot][c]) < 1e-9)
            return false;
        for (int k = 0; k <= n; k++) {
            const double swap = m[c][k];
            m[c][k] = m[pivot][k];
            m[pivot][k] = swap;
        }
        for (int r = 0; r < n; r++) {
            const double share = m[r][c] / m[c][c];
            for (int k = c; k <= n && r != c; k++)
                m[r][k] -= share * m[c][k];
        }
    }
    for (int c = 0; c < n; c++)
        x[c] = m[c][n] / m[c][c];
    return true;
}

bool ost_fit_sphere(const double (*points)[3], size_t count, double centre[3], double *radius)
{
    double mean[3] = {0}, m[4][5] = {{0}}, x[4];
    if (count < 4)
        return false;
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            mean[a] += points[i][a] / (double)count;
    for (size_t i = 0; i < count; i++) {
        const double p[3] = {points[i][0] - mean[0], points[i][1] - mean[1], points[i][2] - mean[2]};
        const double row[5] = {2 * p[0], 2 * p[1], 2 * p[2], 1, p[0] * p[0] + p[1] * p[1] + p[2] * p[2]};
        for (int r = 0; r < 4; r++)
            for (int c = 0; c < 5; c++)
                m[r][c] += row[r] * row[c] / (double)count;
    }
    if (!eliminate(m, 4, x))
        return false;
    const double square = x[3] + x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    for (int a = 0; a < 3; a++)
        centre[a] = x[a] + mean[a];
    *radius = square > 0 ? sqrt(square) : 0;
    return square > 0;
}

bool ost_fit_plane(const double (*points)[3], size_t count, const double along[3], double normal[3], double mean[3])
{
    /*
     * u and v are unit vectors perpendicular to `along` and to each other. u is also perpendicular to the coordinate
     * axis that is least parallel to `along`.
     */
    int least = 0;
    for (int a = 1; a < 3; a++)
        least = fabs(along[a]) < fabs(along[least]) ? a : least;
    double u[3], v[3], axis[3] = {least == 0, least == 1, least == 2}, m[4][5] = {{0}}, x[4];
    ost_vector_cross(along, axis, u);
    (void)ost_vector_unit(u, 0);
    ost_vector_cross(along, u, v);
    for (int a = 0; a < 3; a++)
        mean[a] = 0;
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            mean[a] += points[i][a] / (double)count;
    for (size_t i = 0; i < count; i++) {
        const double p[3] = {points[i][0] - mean[0], points[i][1] - mean[1], points[i][2] - mean[2]};
        const double row[3] = {ost_vector_dot(p, u), ost_vector_dot(p, v), ost_vector_dot(p, along)};
        for (int r = 0; r < 2; r++)
            for (int c = 0; c < 3; c++)
                m[r][c] += row[r] * row[c] / (double)count;
    }
    /*
     * In the coordinates relative to the mean, the plane's equation is (distance along `along`) = x0 (distance along u)
     * + x1 (distance along v). The function `eliminate` expects the right-hand side in column n.
     */
    if (count < 3 || !eliminate(m, 2, x))
        return false;
    for (int a = 0; a < 3; a++)
        normal[a] = along[a] - x[0] * u[a] - x[1] * v[a];
    (void)ost_vector_unit(normal, 0);
    return true;
}
