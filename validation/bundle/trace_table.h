/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the traceability table, which relates requirements, tests, results and files in both directions:
 *
 *   docs/requirements.csv --docs/check-requirements --table, at build time--> requirements.csv of a bundle
 *   requirements.csv, cases, common.json, suite.json --trace_table_write--> trace.csv
 *
 * trace.csv has a row for each requirement. The row lists the requirement's tests, the stages or checks of
 * this bundle that cover the requirement, their results, and the files that contain the results. Rows for
 * orphans follow: requirements without any test, tests that no requirement names, and results of this
 * bundle that no requirement needs.
 */
#ifndef OST_VALIDATION_TRACE_TABLE_H
#define OST_VALIDATION_TRACE_TABLE_H

#include "validation/bundle/evidence.h"

#define REQUIREMENTS_FILE "requirements.csv"
#define TRACE_FILE "trace.csv"

/*
 * Returns a copy of the table that is compiled in, or NULL if memory is exhausted. The caller frees the copy with
 * free().
 */
char *trace_requirements(void);

/* Writes trace.csv. `requirements` is the text of the bundle's requirements.csv. `common` and `suite` are the contents
   of common.json and suite.json, or NULL. */
ost_status trace_table_write(const char *requirements, const json_t *cases, const json_t *common, const json_t *suite,
                             evidence_sink *sink, void *user, ost_error *err);

#endif
