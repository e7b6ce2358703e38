/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The machine, for the record: system, processor, threads, rounding state,
 * locale, the variables that steer drivers and threads, compiler and flags,
 * and the program's own file by its SHA-256.
 */
#ifndef OST_VALIDATION_ENVIRONMENT_H
#define OST_VALIDATION_ENVIRONMENT_H

#define ENVIRONMENT_FILE "environment.json"
#define TIMES_FILE "times.json"

#include <jansson.h>
#include <osteon/status.h>

/* program: this program's file. The caller's reference. */
ost_status environment_of(const char *program, json_t **out, ost_error *err);

#endif
