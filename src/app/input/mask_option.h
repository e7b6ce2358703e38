/* SPDX-License-Identifier: Apache-2.0 */
/* Parses the value of --mask: FILE[:LABEL,...]. */
#ifndef OST_APP_INPUT_MASK_OPTION_H
#define OST_APP_INPUT_MASK_OPTION_H

#include "app/common/options.h"

/*
 * Stores the file, the label numbers and the label names in *out. If the complete text is the name of an existing file,
 * there are no labels. Otherwise, the file name ends at the first colon for which the text before it is the name of an
 * existing file. If there is no such colon, the file name ends at the last colon. The strings in *out are valid until
 * the next call.
 */
ost_status mask_option_parse(const app_state *app, const char *text, ost_import_options *out, ost_error *err);

#endif
