/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Requirements, tests, results and files, in both directions:
 *
 *   docs/requirements.csv --docs/check-requirements --table, at build time--> requirements.csv of a bundle
 *   requirements.csv, cases, common.json, suite.json --trace_write--> trace.csv
 *
 * trace.csv has a row for each requirement: its tests, which stages or checks
 * of this very bundle bear on it and how they came out, and the files that
 * say so.  After them stand the orphans: requirements without any test, tests
 * that no requirement names, and results of this bundle that none needs.
 */
#ifndef OST_VALIDATION_TRACE_TABLE_H
#define OST_VALIDATION_TRACE_TABLE_H

#include "validation/bundle/evidence.h"

#define REQUIREMENTS_FILE "requirements.csv"
#define TRACE_FILE "trace.csv"

/* The table that is built in; free() it. NULL without memory. */
char *trace_requirements(void);

/* requirements: the bundle's file; common, suite: the bundle's common.json and suite.json, or NULL. */
ost_status trace_table_write(const char *requirements, const json_t *cases, const json_t *common, const json_t *suite,
                             evidence_sink *sink, void *user, ost_error *err);

#endif
