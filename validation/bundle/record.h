/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the files of a bundle that are not evidence of the comparison:
 *
 *   record_put     requirements.csv, known-anomalies.csv, tools.json, devices.json, common.json; these
 *                  files are compiled in, or collected on the machine
 *   record_merge   the same files, from the bundles of shards
 *   record_derive  trace.csv, sbom.spdx.json, soup.csv, junit.xml; these are derived from the files
 *                  above, environment.json, times.json and the cases; verify derives them again
 *
 * If shards ran on equal machines, their tools.json and devices.json are equal and are written once. If the files
 * differ, the merged file contains an object {"1/3": ...} with the file of each shard.
 */
#ifndef OST_VALIDATION_RECORD_H
#define OST_VALIDATION_RECORD_H

#include "validation/bundle/evidence.h"

/* The known anomalies of this release, compiled in from docs/qualification/known-anomalies.csv. */
#define KNOWN_ANOMALIES_FILE "known-anomalies.csv"

/* Writes the files that describe the environment. `program` is the path of the running executable. */
ost_status record_put(const char *program, const subject_list *subjects, const json_t *common, evidence_sink *sink,
                      void *user, ost_error *err);

/* Merges the collected files of the bundles in a folder. Returns OST_ERR_INPUT if the bundles were made by different
   builds. */
ost_status record_merge(const char *folder, evidence_sink *sink, void *user, ost_error *err);

/* Writes the files that are derived from files that the folder already contains. */
ost_status record_derive(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                         void *user, ost_error *err);

#endif
