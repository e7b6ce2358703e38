/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ordered list of the cases of a campaign. It depends only on tier, seed and shard, and is complete
 * before any case runs. The list is part of the protocol, and the SHA-256 of its text is part of the
 * evidence.
 *
 *   tier, seed, shard I/N --plan_make--> cases "family/number"
 *
 *   import/N     a random CT as samples in any order: scatter, resampling,
 *                chunks (Algs. 2.3-2.6); lattices, duplicates, thresholds
 *   mesh/N       tools from simple to degenerate: closed, open, slivers, solids that
 *                occur twice, parts that do not cut; by winding and parity (Alg. 2.1, section 2.3)
 *   poses/N      unrelated poses, including poses on borders and quarter turns (Algs. 2.8-2.10)
 *   sweep/N      fast motion: many poses per event
 *   session/N    slow cutting for many ticks, with changes of tool
 *   operation/N  the built-in peg hole and reaming on a phantom's glenoid
 *   steps/N      only sweep, map, motor and snapping, without voxels: ties, ends of the range
 *   reach/N      situations that need a certain size or position: a sparse bone of
 *                more than 2^22 voxels, a tool wider than 512, rods, slices, far
 *                origins, samples that are refused, a gap between the parts of a tool
 *   static/N     the static events of the thesis; only if requested by name
 *   user/N       the user's own files (user_store.h), numbered from 1; after all others
 */
#ifndef OST_VALIDATION_PLAN_H
#define OST_VALIDATION_PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

typedef enum plan_tier { PLAN_SMOKE, PLAN_STANDARD, PLAN_FULL, PLAN_TIERS } plan_tier;

typedef enum plan_family {
    PLAN_IMPORT,
    PLAN_MESH,
    PLAN_POSES,
    PLAN_SWEEP,
    PLAN_SESSION,
    PLAN_OPERATION,
    PLAN_STEPS,
    PLAN_REACH,
    PLAN_STATIC, /* the static events of Tables 3.3 to 3.5 of the thesis, only if requested by name */
    PLAN_SMALL, /* not in a plan: scenes that run for a few milliseconds and pass through every stage (sensitivity.h) */
    PLAN_USER,  /* cases from the user's own files */
    PLAN_FAMILIES
} plan_family;

struct scene_cut;  /* locate/cut.h */
struct user_store; /* user_store.h */

/* The user's own cases: their number and contents. If `store` is NULL, only the names of the cases are available. */
typedef struct plan_user {
    int count;
    const struct user_store *store; /* borrowed; the user's files; NULL if all cases are generated */
} plan_user;

enum { PLAN_ID = 32 };
typedef struct plan_case {
    plan_family family;
    int number;       /* number of the case in its family, counted from 0, or from 1 in PLAN_USER */
    plan_tier tier;   /* tier of the campaign; higher tiers have larger cases */
    uint64_t seed;
    char id[PLAN_ID]; /* "session/3" */
    /* part of the case that is run; NULL means the complete case; owned by the plan if read from a file */
    struct scene_cut *cut;
    const struct user_store *store; /* borrowed; the user's files, for PLAN_USER */
} plan_case;

typedef struct plan {
    plan_tier tier;
    uint64_t seed;
    int shard, shards; /* number of this shard, 1 <= shard <= shards */
    const char *only;  /* borrowed; prefix of the identifiers of the cases, or NULL (plan_make) */
    /* file from which the cases were read (locate/case_file.h); borrowed; NULL if the tier determines the cases */
    const char *file;
    const struct user_store *user; /* borrowed; the user's own cases, or NULL */
    int count;
    plan_case *cases; /* owned; cases of this shard: case k of the complete list belongs to shard 1 + k mod shards */
    int total;        /* number of cases of all shards together */
} plan;

const char *plan_tier_name(plan_tier tier);
const char *plan_family_name(plan_family family);
/* Returns one sentence that describes a family of cases. */
const char *plan_family_about(plan_family family);

/* Generates the plan of one shard. If `only` is not NULL, cases whose id does not begin with it are omitted.
   `user` is NULL if there are no cases of the user. */
ost_status plan_make(plan_tier tier, uint64_t seed, int shard, int shards, const char *only, const plan_user *user,
                     plan *out, ost_error *err);
void plan_free(plan *p);

/* Generates the case with an identifier. Returns false if the tier has no such case. */
bool plan_find(plan_tier tier, uint64_t seed, const char *id, const plan_user *user, plan_case *out);

/* Returns an estimate of the size of a case's trace in bytes. The estimate is based on measurements. The traces of most
   generated cases are considerably smaller than the estimate. */
uint64_t plan_trace_bytes(const plan_case *c);

#endif
