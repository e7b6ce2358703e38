/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes environment.json. The file describes the system, the processor, the number of cores, the rounding mode, the
 * locale, and the environment variables that affect drivers and threads. It also contains the compiler, the program's
 * version, and the SHA-256 of the program's own file.
 */
#ifndef OST_VALIDATION_ENVIRONMENT_H
#define OST_VALIDATION_ENVIRONMENT_H

#define ENVIRONMENT_FILE "environment.json"
#define TIMES_FILE "times.json"

#include <jansson.h>
#include <osteon/status.h>

/* Makes the content of environment.json; the caller owns *out. `program` is the path of this program's file. */
ost_status environment_of(const char *program, json_t **out, ost_error *err);

#endif
