/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the velocity of a tool that is pulled by springs and held by points.
 * A point resists in proportion to its advance into bone, and only while it
 * presses.
 *
 *   spring u  +  sum over pressing points of  b (given + j . u) j  =  pull
 *
 * u is the tool's velocity, or the velocity and the angular velocity; j of a
 * point is its outward normal n, or n and r x n, so that j . u is its advance.
 * Which points press is found by iteration: each solution determines the set for
 * the next.
 */
#ifndef OST_FORCE_BALANCE_H
#define OST_FORCE_BALANCE_H

#include <osteon/force.h>

typedef struct balance {
    int axes;              /* 3 or 6 */
    double spring[6];      /* coefficient of the springs for each axis of u */
    double pull[6];
    size_t count;          /* points */
    double b[OST_SHELL_MAX];
    double given[OST_SHELL_MAX]; /* m/s: advance that does not depend on u */
    double j[6][OST_SHELL_MAX];
    double advance[OST_SHELL_MAX]; /* m/s, at the solution */
} balance;

/* Solves for u and sets each point's advance. A point with an advance of 0 or less does not press. */
void ost_balance_solve(balance *e, double u[6]);

#endif
