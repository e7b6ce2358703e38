/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a campaign runs: an ordered list of cases, fixed by tier, seed and
 * shard before anything runs.  The list is part of the protocol, and its text
 * is hashed into the evidence.
 *
 *   tier, seed, shard I/N --plan_make--> cases "family/number"
 *
 *   import/N     a random CT as samples in any order: scatter, resampling,
 *                chunks (Algs. 2.3-2.6); lattices, duplicates, thresholds
 *   mesh/N       tools from simple to hostile: closed, open, slivers, covers
 *                twice, not cutting; by winding and parity (Alg. 2.1, section 2.3)
 *   poses/N      unrelated poses, on borders and quarter turns among them (Algs. 2.8-2.10)
 *   sweep/N      fast motion: many poses an event
 *   session/N    slow cutting for many ticks, tools changed in between
 *   operation/N  the built-in peg hole and reaming on a phantom's glenoid
 *   steps/N      sweep, map, motor and snapping alone: ties, ends of the range; no voxel
 *   reach/N      what only size or place brings about: a sparse bone of more than
 *                2^22 voxels, a tool wider than 512, rods, slices, far origins,
 *                samples that are refused, a gap between the parts of a tool
 *   static/N     the thesis' static events, when they are asked for by name
 *   user/N       the user's own files (user_store.h), from 1 on; behind all others
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
    PLAN_STATIC, /* by name alone: the static events of Tables 3.3 to 3.5 */
    PLAN_SMALL, /* in no plan: scenes of a few milliseconds that hold every stage, for sensitivity.h */
    PLAN_USER,  /* of the user's own files */
    PLAN_FAMILIES
} plan_family;

struct scene_cut;  /* locate/cut.h */
struct user_store; /* user_store.h */

/* The user's own cases: how many, and what they are; without a store they have names alone. */
typedef struct plan_user {
    int count;
    const struct user_store *store; /* borrowed; NULL: they cannot be made */
} plan_user;

enum { PLAN_ID = 32 };
typedef struct plan_case {
    plan_family family;
    int number;       /* within the family, from 0; of the user's own from 1 */
    plan_tier tier;   /* sizes grow with it */
    uint64_t seed;    /* the campaign's */
    char id[PLAN_ID]; /* "session/3" */
    struct scene_cut *cut; /* what of it is kept, NULL: all; owned where the plan came from a file */
    const struct user_store *store; /* of the user's own; borrowed */
} plan_case;

typedef struct plan {
    plan_tier tier;
    uint64_t seed;
    int shard, shards; /* 1 <= shard <= shards */
    const char *only;  /* as given to plan_make, borrowed */
    const char *file;  /* where the cases came from (locate/case_file.h), borrowed; NULL: from the tier */
    const struct user_store *user; /* of the user's own cases, borrowed; NULL: none are there */
    int count;
    plan_case *cases; /* owned; case k of the whole list belongs to shard 1 + k mod shards */
    int whole;        /* cases of all shards */
} plan;

const char *plan_tier_name(plan_tier tier);
const char *plan_family_name(plan_family family);
/* What a family is for, a line for people. */
const char *plan_family_about(plan_family family);

/* only: NULL, or keeps the cases whose id begins with it. user: NULL for none. */
ost_status plan_make(plan_tier tier, uint64_t seed, int shard, int shards, const char *only, const plan_user *user, plan *out, ost_error *err);
void plan_free(plan *p);

/* The case of this name; false when the tier has none. */
bool plan_find(plan_tier tier, uint64_t seed, const char *id, const plan_user *user, plan_case *out);

/* About what a case's trace takes on the disk; measured, and more than enough for generated ones. */
uint64_t plan_trace_bytes(const plan_case *c);

#endif
