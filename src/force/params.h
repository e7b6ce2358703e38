/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_FORCE_PARAMS_H
#define OST_FORCE_PARAMS_H

#include <osteon/force.h>

/* If a parameter is outside its bounds, returns OST_ERR_RANGE and writes the name of the parameter to err. */
ost_status ost_force_params_check(const ost_force_params *params, ost_error *err);

#endif
