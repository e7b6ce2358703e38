/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lines that audit.log must have, in this order:
 *
 *   begun            osteon VERSION
 *   protocol frozen  SHA-256 of protocol.json, before the first case runs
 *   merged           N shards of ...                              (only in a merged bundle)
 *   results          the counts of results.json
 *   file             NAME SHA-256, for each file that folder.c marks as bound, sorted by name
 *   ended            files written
 *
 * The `file` lines bind the measured files (tools, bill of materials, devices,
 * environment, times) to the run of this log, so that a file from another run is detected.
 * The chain (bundle.h) binds the lines to each other.
 */
#ifndef OST_VALIDATION_LOG_H
#define OST_VALIDATION_LOG_H

#include "validation/bundle/bundle.h"

/* Writes the line "results" and all lines after it. All files except report and manifest must already be in the
   folder. */
ost_status log_end(bundle *b, const json_t *summary, ost_error *err);

/* Reports each line of the log that is not consistent with the files of the bundle. */
ost_status log_check(const char *folder, const json_t *protocol, const json_t *summary, bundle_problem *problem,
                     void *user, int *found, ost_error *err);

#endif
