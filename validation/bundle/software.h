/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lists the software of others that this program runs with, for two readers:
 *
 *   tools.json --software_write--> sbom.spdx.json   SPDX 2.3, for tools
 *                                  soup.csv         software of unknown provenance (IEC 62304):
 *                                                   purpose, licence, limits
 *
 * Both follow from tools.json and the table of known libraries in software.c,
 * so a check of a bundle derives them again.
 */
#ifndef OST_VALIDATION_SOFTWARE_H
#define OST_VALIDATION_SOFTWARE_H

#include "validation/bundle/evidence.h"

#define SBOM_FILE "sbom.spdx.json"
#define SOUP_FILE "soup.csv"

/* Writes the bill of materials. For one run, `tools` is the result of tools_of. For merged shards, `tools` has the
   form {"1/3": result of tools_of, ...}. */
ost_status software_write(json_t *tools, evidence_sink *sink, void *user, ost_error *err);

#endif
