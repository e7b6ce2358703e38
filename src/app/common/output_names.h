/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Protects the files that the arguments of a verb name from being replaced by an output of the same run.
 */
#ifndef OST_APP_COMMON_OUTPUT_NAMES_H
#define OST_APP_COMMON_OUTPUT_NAMES_H

#include "app/common/options.h"

/*
 * Returns OST_ERR_USAGE if the value of an OPTION_OUTPUT names an existing regular file that another argument names
 * too, or the same path as another OPTION_OUTPUT. Names are compared after symbolic and hard links are followed. In
 * `argv`, an argument may be a path, --NAME=PATH, or a path with a suffix, as in labels.nrrd:3. `options` must contain
 * the values of `argv`.
 */
ost_status output_names_check(const option *options, int argc, char **argv, ost_error *err);

#endif
