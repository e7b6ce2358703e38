/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the velocity of a tool that is pulled by springs and resisted by the
 * points of its shell.  The resistance of a point is proportional to the speed of
 * its advance into bone; a point resists only while it presses.
 *
 *   spring u  +  sum over pressing points of  b (given + j . u) j  =  pull
 *
 * For each point, b is the resistance, and `given` + j . u is the speed of advance. With
 * the point's position r and outward normal n, u and j are:
 *
 *   3 components   u = velocity of the tool                         j = n
 *   6 components   u = velocity and angular velocity of the tool    j = n and r x n
 *
 * The pressing points are found by iteration: each solution determines the points that
 * press in the next solution.
 */
#ifndef OST_FORCE_BALANCE_H
#define OST_FORCE_BALANCE_H

#include <osteon/force.h>

typedef struct balance {
    int axes;              /* number of components of u: 3 or 6 */
    double spring[6];      /* coefficient of the springs for each component of u */
    double pull[6];
    size_t count;          /* number of points */
    double b[OST_SHELL_MAX]; /* resistance of each point in N s/m */
    /* part of each point's speed of advance, in m/s, that does not depend on u */
    double given[OST_SHELL_MAX];
    double j[6][OST_SHELL_MAX];
    double advance[OST_SHELL_MAX]; /* speed of advance of each point in the solution, in m/s */
} balance;

/*
 * Solves for u and sets the speed of advance of each point. A point whose speed of advance is not positive does not
 * press.
 */
void ost_balance_solve(balance *e, double u[6]);

#endif
