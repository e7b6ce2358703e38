/* SPDX-License-Identifier: Apache-2.0 */
/*
 * environment.json: system, processor, threads, rounding state, locale, the
 * environment variables that affect drivers and threads, compiler and flags, and
 * the SHA-256 of the program's own file.
 */
#ifndef OST_VALIDATION_ENVIRONMENT_H
#define OST_VALIDATION_ENVIRONMENT_H

#define ENVIRONMENT_FILE "environment.json"
#define TIMES_FILE "times.json"

#include <jansson.h>
#include <osteon/status.h>

/* Makes the content of environment.json; the caller owns *out. program: this program's file. */
ost_status environment_of(const char *program, json_t **out, ost_error *err);

#endif
