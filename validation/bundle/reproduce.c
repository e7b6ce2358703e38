/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/reproduce.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/locate/minimise.h"

bool reproduce_name_ok(const char *name)
{
    const size_t head = strlen("cases/"), length = strlen(name),
                 plain = head < length ? strspn(name + head, "abcdefghijklmnopqrstuvwxyz0123456789-") : 0;
    return strncmp(name, "cases/", head) == 0 && plain > 0 && strcmp(name + head + plain, ".json") == 0;
}

static void name_of(const char *id, int backend, char name[96])
{
    char plain[PLAN_ID];
    size_t n = 0;
    for (; id[n] && n < sizeof plain - 1; n++)
        plain[n] = (char)((id[n] >= 'a' && id[n] <= 'z') || (id[n] >= '0' && id[n] <= '9') ? id[n] : '-');
    plain[n] = '\0';
    snprintf(name, 96, "cases/%s-backend-%d.json", plain, backend);
}

static case_result *result_of(const campaign *c, int i, int s)
{
    return &c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s];
}

/* Returns true if an earlier case of this backend differs in the same stage and its difference has the same class. */
static bool seen_before(const campaign *c, int i, int s)
{
    const case_result *r = result_of(c, i, s);
    for (int k = 0; k < i; k++) {
        const case_result *o = result_of(c, k, s);
        if (o->verdict == CASE_DIFFERS && o->found && o->difference.stage == r->difference.stage &&
            (o->found->class && r->found->class ? strcmp(o->found->class, r->found->class) == 0
                                                : o->found->class == r->found->class))
            return true;
    }
    return false;
}

static ost_status put_case(const campaign *c, int i, int s, const minimised *m, evidence_sink *sink, void *user,
                           ost_error *err)
{
    finding *f = result_of(c, i, s)->found;
    const compare_difference *d = &m->difference;
    json_t *o = case_to_json(&c->plan->cases[i], &m->cut);
    json_t *shows = json_pack("{s:s,s:s,s:i,s:s}", "backend", c->subjects->subjects[s].spec, "stage",
                              trace_stage_name(d->stage), "item", (int)d->item, "class",
                              m->found.class ? m->found.class : "");
    if (d->kind == COMPARE_VOXEL) {
        json_object_set_new(shows, "voxel", json_pack("[i,i,i]", d->voxel[0], d->voxel[1], d->voxel[2]));
        json_object_set_new(shows, "reference", json_integer(d->voxel_ref));
        json_object_set_new(shows, "got", json_integer(d->voxel_got));
    }
    json_object_set_new(o, "shows", shows);
    char *text = o ? json_dumps(o, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
    json_decref(o);
    if (!text)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a case");
    name_of(c->plan->cases[i].id, s, f->reproduce);
    minimised_text(m, f->small);
    const size_t size = strlen(text);
    text[size] = '\n'; /* The terminating NUL is replaced by a newline. */
    ost_status status = sink(user, f->reproduce, text, size + 1, err);
    free(text);
    return status;
}

ost_status reproduce(campaign *c, const char *program, const char *folder,
                     void (*show)(void *user, const char *what, double share), void *show_user, evidence_sink *sink,
                     void *user, ost_error *err)
{
    ost_status status = OST_OK;
    int made = 0;
    for (int s = 1; s < c->subjects->count; s++)
        for (int i = 0; i < c->plan->count && made < REPRODUCED && status == OST_OK; i++) {
            const case_result *r = result_of(c, i, s);
            minimised m;
            bool done;
            if (r->verdict != CASE_DIFFERS || !r->found || seen_before(c, i, s))
                continue;
            if (show)
                show(show_user, "making differences small", (double)made / REPRODUCED);
            made++;
            status = minimise(&c->plan->cases[i], c->subjects->subjects[s].spec, &r->difference, r->found, program,
                              folder, &m, &done, err);
            if (status == OST_OK && done)
                status = put_case(c, i, s, &m, sink, user, err);
        }
    return status;
}
