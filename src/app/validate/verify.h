/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon verify`.
 *
 *   cmd_verify.c   the options
 *   verify.c       checks the files, the signatures and, with --rerun, the cases of a bundle
 */
#ifndef OST_APP_VALIDATE_VERIFY_H
#define OST_APP_VALIDATE_VERIFY_H

#include "app/common/options.h"
#include "app/validate/user_files.h"

typedef struct verify_args {
    const char *folder;  /* the bundle */
    const char *backend; /* backend on which --rerun also runs the cases; NULL if --backend is not given */
    bool rerun;
    user_files own;
    option_list trust;     /* keys of --trust */
    const char *authority; /* certificates of --timestamp-ca, or NULL */
} verify_args;

/*
 * Checks the bundle and reports the result. Returns OST_ERR_DIFFER if the bundle was changed after it was written, and
 * OST_ERR_INPUT if a file is missing or cannot be read.
 */
ost_status verify_bundle(app_state *app, const verify_args *args, ost_error *err);

#endif
