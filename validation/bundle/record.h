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
 * differ, the merged file has an object {"1/3": ...}.
 */
#ifndef OST_VALIDATION_RECORD_H
#define OST_VALIDATION_RECORD_H

#include "validation/bundle/evidence.h"

/* Known anomalies of this release (docs/qualification/known-anomalies.csv), as compiled in. */
#define KNOWN_ANOMALIES_FILE "known-anomalies.csv"

/* Writes the collected files. `program` is the path of the executable file of this process. */
ost_status record_put(const char *program, const subject_list *subjects, const json_t *common, evidence_sink *sink,
                      void *user, ost_error *err);

/* Merges the collected files of the bundles in a folder. Returns OST_ERR_INPUT if the bundles were made by different
   builds. */
ost_status record_merge(const char *folder, evidence_sink *sink, void *user, ost_error *err);

/* Derives the remaining files from the files of the bundle in a folder. */
ost_status record_derive(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                         void *user, ost_error *err);

#endif
