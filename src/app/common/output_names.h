/* SPDX-License-Identifier: Apache-2.0 */
/* Prevents an output of a verb from replacing a file that another argument names. */
#ifndef OST_APP_COMMON_OUTPUT_NAMES_H
#define OST_APP_COMMON_OUTPUT_NAMES_H

#include "app/common/options.h"

/*
 * Returns OST_ERR_USAGE if an OPTION_OUTPUT names an existing regular file that another argument also names, even
 * through a link, or if two OPTION_OUTPUTs name the same path. In `argv`, an argument may be a path, --NAME=PATH, or a
 * path with a suffix, as in labels.nrrd:3. `options` must contain the values parsed from `argv`.
 */
ost_status output_names_check(const option *options, int argc, char **argv, ost_error *err);

#endif
