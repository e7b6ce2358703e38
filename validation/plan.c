/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/user_store.h"

static const struct {
    const char *name, *about;
    int count[PLAN_TIERS];
    int named; /* number of cases if the family is requested by name; 0 means as many as in the tier */
} families[PLAN_FAMILIES] = {
    [PLAN_IMPORT] = {"import", "random CTs: scatter, resampling, chunks", {8, 48, 240}, 0},
    [PLAN_MESH] = {"mesh", "tools from simple to hostile meshes", {8, 48, 240}, 0},
    [PLAN_POSES] = {"poses", "unrelated poses, borders and quarter turns", {5, 24, 120}, 0},
    [PLAN_SWEEP] = {"sweep", "fast motion, many poses an event", {2, 12, 60}, 0},
    [PLAN_SESSION] = {"session", "slow cutting with changes of tool", {2, 8, 40}, 0},
    [PLAN_OPERATION] = {"operation", "the built-in peg hole and reaming", {1, 2, 4}, 0},
    [PLAN_STEPS] = {"steps",
                    "sweep, map, motor and snapping alone, at ties and the ends of the range",
                    {6, 24, 120},
                    0},
    [PLAN_REACH] = {"reach",
                    "large sparse bones, wide tools, rods, slices, far origins, refused samples, gaps, lone voxels",
                    {6, 12, 24},
                    0},
    [PLAN_STATIC] = {"static",
                     "the static events of the thesis' Tables 3.3 to 3.5, when asked for by name",
                     {0, 0, 0},
                     8},
    [PLAN_SMALL] = {"small", "all stages in a few milliseconds, for the sensitivity proof", {0, 0, 0}, 0},
    [PLAN_USER] = {"user", "the user's own files", {0, 0, 0}, 0},
};

const char *plan_tier_name(plan_tier tier)
{
    static const char *const names[] = {"smoke", "standard", "full"};
    return names[tier];
}

const char *plan_family_name(plan_family family)
{
    return families[family].name;
}

const char *plan_family_about(plan_family family)
{
    return families[family].about;
}

static int count_of(int f, plan_tier tier, const char *only)
{
    const int named = only && strncmp(only, families[f].name, strlen(families[f].name)) == 0 ? families[f].named : 0;
    return named ? named : families[f].count[tier];
}

ost_status plan_make(plan_tier tier, uint64_t seed, int shard, int shards, const char *only, const plan_user *user,
                     plan *out, ost_error *err)
{
    int capacity = user ? user->count : 0;
    for (int f = 0; f < PLAN_FAMILIES; f++)
        capacity += count_of(f, tier, only);
    *out = (plan){
        .tier = tier, .seed = seed, .shard = shard, .shards = shards, .only = only, .user = user ? user->store : NULL};
    out->cases = malloc((size_t)capacity * sizeof *out->cases);
    if (!out->cases)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a plan of %d cases", capacity);
    for (int f = 0; f < PLAN_FAMILIES; f++)
        for (int n = 0; n < count_of(f, tier, only); n++) {
            plan_case c = {.family = (plan_family)f, .number = n, .tier = tier, .seed = seed};
            snprintf(c.id, sizeof c.id, "%s/%d", families[f].name, n);
            if (only && strncmp(c.id, only, strlen(only)) != 0)
                continue;
            if (out->total++ % shards == shard - 1)
                out->cases[out->count++] = c;
        }
    for (int n = 1; user && n <= user->count; n++) {
        plan_case c = {.family = PLAN_USER, .number = n, .tier = tier, .seed = seed, .store = user->store};
        snprintf(c.id, sizeof c.id, "%s/%d", families[PLAN_USER].name, n);
        if ((!only || strncmp(c.id, only, strlen(only)) == 0) && out->total++ % shards == shard - 1)
            out->cases[out->count++] = c;
    }
    if (!out->total) {
        plan_free(out);
        return ost_fail(err, OST_ERR_USAGE,
                        strncmp(only, "user", 4) == 0 && !(user && user->count)
                            ? "no case of tier %s has a name that starts with '%s'; pass --ct, --tool or --path"
                            : "no case of tier %s has a name that starts with '%s'",
                        plan_tier_name(tier), only);
    }
    return OST_OK;
}

bool plan_find(plan_tier tier, uint64_t seed, const char *id, const plan_user *user, plan_case *out)
{
    plan all;
    ost_error none = {0};
    bool there = false;
    if (plan_make(tier, seed, 1, 1, NULL, user, &all, &none) != OST_OK)
        return false;
    for (int i = 0; i < all.count && !there; i++)
        if (strcmp(all.cases[i].id, id) == 0) {
            *out = all.cases[i];
            there = true;
        }
    plan_free(&all);
    return there;
}

void plan_free(plan *p)
{
    for (int i = 0; p->file && i < p->count; i++)
        free(p->cases[i].cut);
    free(p->cases);
    p->cases = NULL;
    p->count = 0;
}

uint64_t plan_trace_bytes(const plan_case *c)
{
    static const uint64_t megabytes[PLAN_FAMILIES][PLAN_TIERS] = {
        [PLAN_IMPORT] = {2, 5, 5},  [PLAN_MESH] = {3, 3, 3},          [PLAN_POSES] = {4, 30, 30},
        [PLAN_SWEEP] = {5, 20, 20}, [PLAN_SESSION] = {50, 250, 1200}, [PLAN_OPERATION] = {100, 350, 1000},
        [PLAN_SMALL] = {1, 1, 1},   [PLAN_STEPS] = {2, 2, 2},         [PLAN_REACH] = {90, 90, 90},
    };
    return c->family == PLAN_USER ? user_trace_bytes(c->store, c->number) : megabytes[c->family][c->tier] << 20;
}
