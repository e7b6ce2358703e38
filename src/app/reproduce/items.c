/* SPDX-License-Identifier: Apache-2.0 */
#include "app/reproduce/reproduce.h"

#include <stdio.h>
#include <string.h>

#include "app/common/print.h"
#include "app/common/result.h"

static ost_status select_item(const app_state *app, const char *name, bool chosen[REPRODUCE_ITEMS_MAX], ost_error *err)
{
    const reproduction_item *item = reproduction_find(name);
    if (item) {
        chosen[item - reproduction_items] = true;
        return OST_OK;
    }
    for (const reproduction_absent *absent = reproduction_missing; absent->id; absent++)
        if (strcmp(absent->id, name) == 0)
            return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: %s", name, absent->reason);
    const char *ids[REPRODUCE_ITEMS_MAX];
    int count = 0;
    for (const reproduction_item *i = reproduction_items; i->id; i++)
        ids[count++] = i->id;
    const char *near = nearest_name(name, ids, count);
    if (near)
        return usage_error(app, err, "'%s' is not an item; did you mean %s? --list shows all", name, near);
    return usage_error(app, err, "'%s' is not an item; --list shows all", name);
}

ost_status reproduce_select_items(const app_state *app, const char *text, bool chosen[REPRODUCE_ITEMS_MAX],
                                  ost_error *err)
{
    const bool all = !text || strcmp(text, "all") == 0;
    for (int i = 0; i < REPRODUCE_ITEMS_MAX && all; i++)
        chosen[i] = true;
    ost_status status = OST_OK;
    for (const char *at = all ? "" : text; *at && status == OST_OK;) {
        const size_t length = strcspn(at, ",");
        char name[RESULT_KEY];
        snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), at);
        status = select_item(app, name, chosen, err);
        at += length + (at[length] == ',');
    }
    if (!all && !*text)
        return usage_error(app, err, "no item given; --list shows all");
    return status;
}

void reproduce_list_items(app_state *app)
{
    json_t *items = json_array(), *missing = json_array();
    for (const reproduction_item *item = reproduction_items; item->id; item++) {
        json_t *o = json_object();
        put_text(o, "name", item->id);
        put_text(o, "title", item->title);
        put_text(o, "kind", reproduction_kind_names[item->kind]);
        append(items, o);
        print_line(app, "%-14s %-9s %s", item->id, reproduction_kind_names[item->kind], item->title);
    }
    for (const reproduction_absent *absent = reproduction_missing; absent->id; absent++) {
        json_t *o = json_object();
        put_text(o, "name", absent->id);
        put_text(o, "title", absent->title);
        put_text(o, "reason", absent->reason);
        append(missing, o);
        print_line(app, "%-14s %-9s %s: %s", absent->id, "missing", absent->title, absent->reason);
    }
    put(app->result, "items", items);
    put(app->result, "missing", missing);
}
