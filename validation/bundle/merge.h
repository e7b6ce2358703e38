/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Merges the bundles of shards. A folder contains one bundle for each of --shard 1/N to N/N. The merged
 * bundle is the bundle that a single run would have written, byte for byte except for the files that differ
 * from run to run.
 *
 * Every shard is checked first (check.h). All shards must come from one campaign: their protocols must be
 * equal except for the shard's number and its cases.
 */
#ifndef OST_VALIDATION_MERGE_H
#define OST_VALIDATION_MERGE_H

#include "validation/bundle/bundle.h"

typedef struct merged {
    json_t *protocol, *cases;     /* owned; protocol and cases of all shards together */
    json_t *environment, *times;  /* {"1/3": ...}; owned */
    json_t *faults;               /* owned; sensitivity.json of the first shard, or NULL */
    /* owned; suite.json of the first shard, and the member "suite" of its protocol; NULL if absent */
    json_t *suite, *suite_limit;
    int shards;
} merged;

/* Reads and merges the bundles in a folder. For OST_ERR_INPUT, the error line names the bundle that is invalid,
   missing, duplicated, or from another campaign. */
ost_status merge_read(const char *folder, merged *out, ost_error *err);
void merge_free(merged *m);

#endif
