/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the velocity of a tool that is pulled by springs and resisted by the
 * points of its shell.  The resistance of a point is proportional to the speed of
 * its advance into bone; a point resists only while it presses.
 *
 *   spring u  +  sum over pressing points of  b (given + j . u) j  =  pull
 *
 * u is the velocity of the tool, or its velocity and angular velocity. For each point, b is the resistance, and j is
 * the outward normal n or, with the angular velocity, n and r x n, where r is the point's position. given + j . u is
 * the point's speed of advance. An iteration finds the set of pressing points: each solution determines the set for the
 * next solution.
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
