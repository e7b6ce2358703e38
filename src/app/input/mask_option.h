/* SPDX-License-Identifier: Apache-2.0 */
/* Parses the value of --mask: FILE[:LABEL,...]. */
#ifndef OST_APP_INPUT_MASK_OPTION_H
#define OST_APP_INPUT_MASK_OPTION_H

#include "app/common/options.h"

/*
 * Stores the file, the label numbers and the label names in *out. If `text` is the name of an existing file, there are
 * no labels. Otherwise, the file name ends at a colon: the first colon that follows the name of an existing file, or
 * the last colon if there is no such file. The strings in *out are valid until the next call.
 */
ost_status mask_option_parse(const app_state *app, const char *text, ost_import_options *out, ost_error *err);

#endif
