/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mistakes that all backends could have in common do not show when they are
 * compared with each other.  These checks compare the reference with what is
 * known without any program:
 *
 *   golden     small grids, worked out by hand from docs/arithmetic.md
 *   volume     bodies whose volume a formula gives
 *   relation   two computations that must agree whatever the voxels are
 *
 * They take well under a second, and every campaign makes them anew.  What
 * cannot be done by the program itself is named with the test that does it.
 */
#ifndef OST_VALIDATION_COMMON_H
#define OST_VALIDATION_COMMON_H

#include <stdbool.h>
#include <stdint.h>

#include <jansson.h>
#include <osteon/status.h>

#define COMMON_FILE "common.json"

/*
 * {passed, failed, checks: [{name, kind, what, requirements, expected, got, passed}], by_the_tests: [{what, tests}]}.
 * OST_OK also when a check fails.  The caller's reference.
 */
ost_status common_check(uint64_t seed, json_t **out, ost_error *err);
bool common_proved(const json_t *common);

#endif
