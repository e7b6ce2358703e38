/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shards to a whole: the bundles that lie in a folder, one for each of
 * --shard 1/N to N/N, become the one that a single run would have left, byte
 * for byte but for the files that vary from run to run anyway.
 *
 * Every shard is checked first (check.h).  They must come from one campaign:
 * protocols equal but for the shard and its cases.
 */
#ifndef OST_VALIDATION_MERGE_H
#define OST_VALIDATION_MERGE_H

#include "validation/bundle/bundle.h"

typedef struct merged {
    json_t *protocol, *cases;     /* of the whole; owned */
    json_t *environment, *times;  /* {"1/3": ...}; owned */
    json_t *faults;               /* the first shard's sensitivity.json, NULL when it has none; owned */
    json_t *suite, *suite_limit;  /* the first shard's suite.json and its part of the protocol, NULL when it has none; owned */
    int shards;
} merged;

/* OST_ERR_INPUT naming the bundle that is broken, missing, there twice, or of another campaign. */
ost_status merge_read(const char *folder, merged *out, ost_error *err);
void merge_free(merged *m);

#endif
