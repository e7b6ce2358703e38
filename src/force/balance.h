/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How fast a tool goes that is pulled by springs and held by points which
 * answer to their advance, each of them only while it presses.
 *
 *   spring u  +  sum over pressing points of  b (given + j . u) j  =  pull
 *
 * u is the tool's velocity, or that and its turn; j of a point is its outward
 * normal n, or that and r x n, so that j . u is its advance.  Which points
 * press is found by trying: each solution says which do.
 */
#ifndef OST_FORCE_BALANCE_H
#define OST_FORCE_BALANCE_H

#include <osteon/force.h>

typedef struct balance {
    int axes;              /* 3 or 6 */
    double spring[6];      /* what the springs answer to each axis of u */
    double pull[6];
    size_t count;          /* points */
    double b[OST_SHELL_MAX];
    double given[OST_SHELL_MAX]; /* m/s: its advance by what is not solved for */
    double j[6][OST_SHELL_MAX];
    double advance[OST_SHELL_MAX]; /* m/s, of the solution */
} balance;

/* u of the balance, and each point's advance; a point that does not advance does not press. */
void ost_balance_solve(balance *e, double u[6]);

#endif
