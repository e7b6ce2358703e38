/* SPDX-License-Identifier: Apache-2.0 */
/* Parses the value of --mask: FILE[:LABEL,...]. */
#ifndef OST_APP_INPUT_MASK_OPTION_H
#define OST_APP_INPUT_MASK_OPTION_H

#include "app/common/options.h"

/*
 * Stores the file, the numbers and the names of labels in *out. If the complete text is the name of a file, it contains
 * no labels; otherwise the file ends before the first colon whose preceding text is the name of a file, or before the
 * last colon. The strings in *out are valid until the next call.
 */
ost_status mask_option_parse(const app_state *app, const char *text, ost_import_options *out, ost_error *err);

#endif
