/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks the reference against results that do not depend on any program. A comparison of backends with each other
 * cannot find a mistake that all backends have in common. There are three kinds of checks:
 *
 *   golden     small grids, computed by hand from docs/spec/arithmetic.md
 *   volume     bodies whose volume is given by a formula
 *   relation   two computations that must give the same value for each voxel
 *
 * The checks take well under a second, and every campaign runs them. Checks that an installed program
 * cannot perform are listed with the test that performs them.
 */
#ifndef OST_VALIDATION_COMMON_H
#define OST_VALIDATION_COMMON_H

#include <stdbool.h>
#include <stdint.h>

#include <jansson.h>
#include <osteon/status.h>

#define COMMON_FILE "common.json"

/*
 * Runs the checks. A failed check is not an error: the function still returns OST_OK. The caller owns *out:
 * {passed, failed, checks: [{name, kind, what, requirements, expected, got, passed}], by_the_tests: [{what, tests}]}.
 */
ost_status common_check(uint64_t seed, json_t **out, ost_error *err);
bool common_proved(const json_t *common);

#endif
