/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the --help text of a verb from its table of options. */
#ifndef OST_APP_COMMON_HELP_H
#define OST_APP_COMMON_HELP_H

#include "app/common/options.h"

void help_print(const app_state *app, const usage_text *usage, const option *common);
/* Prints a verb's options for shell completion. The script completion/bash/osteon calls `osteon VERB --complete`. */
void help_print_candidates(const usage_text *usage, const option *common);

#endif
