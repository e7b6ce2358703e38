/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What goes into a bundle besides the comparison's own evidence:
 *
 *   record_put     requirements.csv, known-anomalies.csv, tools.json, devices.json, common.json: built in, or found out on the machine
 *   record_merge   the same from the bundles of shards
 *   record_derive  trace.csv, sbom.spdx.json, soup.csv, junit.xml: follow from those, environment.json, times.json and the
 *                  cases; verify derives them again
 *
 * tools.json and devices.json of shards that ran on equal machines are equal
 * and stand once; of others there is an object {"1/3": ...}.
 */
#ifndef OST_VALIDATION_RECORD_H
#define OST_VALIDATION_RECORD_H

#include "validation/bundle/evidence.h"

/* Known anomalies of this release (docs/qualification/known-anomalies.csv), as built in. */
#define KNOWN_ANOMALIES_FILE "known-anomalies.csv"

/* program: this program's file. */
ost_status record_put(const char *program, const subject_list *subjects, const json_t *common, evidence_sink *sink, void *user, ost_error *err);

/* Of the bundles that lie in folder. OST_ERR_INPUT when they are of different builds. */
ost_status record_merge(const char *folder, evidence_sink *sink, void *user, ost_error *err);

/* From the files of the bundle in folder. */
ost_status record_derive(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                         void *user, ost_error *err);

#endif
