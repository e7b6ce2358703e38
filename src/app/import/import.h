/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon import`.
 *
 *   cmd_import.c   parses the options
 *   run.c          reads the CT, makes the bone and writes it
 *   report.c       reports the result
 */
#ifndef OST_APP_IMPORT_IMPORT_H
#define OST_APP_IMPORT_IMPORT_H

#include "app/input/load.h"
#include "app/input/patient.h"
#include "app/input/segment_options.h"

typedef struct import_args {
    const char *name, *out, *preview; /* files: the CT, the bone, and the picture of --preview */
    ct_options ct;
    segment_options segment;
    patient_options patient;
    bool compress;
} import_args;

/* Makes a bone from the CT, writes the bone and reports the result. */
ost_status import_ct(app_state *app, const import_args *args, ost_error *err);

/*
 * Warns if a grid is too small or too large for a patient's bone. The warning names the units that would make the size
 * plausible. Such a size is not an error, because a micro-CT may be this small. A phantom is marked in its header and
 * causes no warning.
 */
void import_warn_size(const app_state *app, const char *name, const ost_import_result *r);

/* Stores the result of an import in the JSON object of the verb. */
void import_put_result(const app_state *app, const ost_import_result *r, const ost_bone_info *info);
/* Prints the result of an import. */
void import_print_result(const app_state *app, const char *ct, const char *out, const ost_import_result *r,
                         const ost_bone_info *info);

#endif
