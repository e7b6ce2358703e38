/* SPDX-License-Identifier: Apache-2.0 */
#include "force/balance.h"

#include <math.h>
#include <string.h>

/* maximum number of iterations; the last solution is used even if the set of pressing points has changed again */
enum { SETS = 8 };

/*
 * Solves m * u = b with a Cholesky decomposition in place. m must be symmetric and positive definite; only its upper
 * triangle is read.
 */
static void solve(int n, double m[6][6], const double b[6], double u[6])
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            for (int c = i; c < n; c++)
                m[i][c] -= m[k][i] * m[k][c];
        const double root = sqrt(m[i][i]);
        for (int c = i; c < n; c++)
            m[i][c] /= root;
    }
    for (int i = 0; i < n; i++) {
        double sum = b[i];
        for (int k = 0; k < i; k++)
            sum -= m[k][i] * u[k];
        u[i] = sum / m[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        double sum = u[i];
        for (int c = i + 1; c < n; c++)
            sum -= m[i][c] * u[c];
        u[i] = sum / m[i][i];
    }
}

/*
 * Adds the terms of the pressing points to m and rhs. Callers pass n as a constant, 3 or 6, so that the compiler
 * unrolls the loops.
 */
static inline __attribute__((always_inline)) void add_points(const balance *e, const double share[], const int n,
                                                             double m[6][6], double rhs[6])
{
    for (size_t i = 0; i < e->count; i++) {
        const double b = share[i], pushed = b * e->given[i];
        for (int a = 0; a < n; a++) {
            const double part = b * e->j[a][i];
            rhs[a] -= pushed * e->j[a][i];
            for (int c = a; c < n; c++)
                m[a][c] += part * e->j[c][i];
        }
    }
}

void ost_balance_solve(balance *e, double u[6])
{
    double share[OST_SHELL_MAX]; /* resistance b of each point in N s/m; 0 if the point does not press */
    memcpy(share, e->b, e->count * sizeof *share);
    for (int set = 0; set < SETS; set++) {
        double m[6][6] = {{0}}, rhs[6];
        size_t changed = 0;
        for (int a = 0; a < e->axes; a++) {
            m[a][a] = e->spring[a];
            rhs[a] = e->pull[a];
        }
        if (e->axes == 3)
            add_points(e, share, 3, m, rhs);
        else
            add_points(e, share, 6, m, rhs);
        solve(e->axes, m, rhs, u);
        for (size_t i = 0; i < e->count; i++) {
            double advance = e->given[i];
            for (int a = 0; a < e->axes; a++)
                advance += e->j[a][i] * u[a];
            const double is = advance > 0 ? e->b[i] : 0;
            changed += is != share[i];
            share[i] = is;
            e->advance[i] = advance;
        }
        if (changed == 0)
            return;
    }
}
