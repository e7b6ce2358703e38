/* SPDX-License-Identifier: Apache-2.0 */
#include "app/reproduce/reproduce.h"

#include <string.h>
#include <unistd.h>

#include "app/common/progress.h"

/* Parses the values of --ct, which are MODEL=FILE or, for the scapula, only FILE. */
static ost_status select_cts(const app_state *app, const option_list *given, const char *ct[MODELS], ost_error *err)
{
    for (int i = 0; i < given->count; i++) {
        const char *text = given->value[i], *file = text;
        int id = MODEL_SCAPULA;
        for (int m = 0; m < MODELS; m++) {
            const size_t length = strlen(model_words[m]);
            if (strncmp(text, model_words[m], length) == 0 && text[length] == '=') {
                id = m;
                file = text + length + 1;
            }
        }
        if (!*file)
            return usage_error(app, err, "--ct '%s': expected MODEL=FILE or FILE", text);
        /* A FILE may contain '='. */
        const size_t word = strcspn(text, "=/");
        if (file == text && text[word] == '=' && access(text, F_OK) != 0)
            return usage_error(app, err, "--ct '%s': '%.*s' is not a model; expected foam, core-2, core-1, scapula or "
                               "glenoid", text, (int)word, text);
        if (ct[id])
            return usage_error(app, err, "--ct '%s': the model %s has a CT already", text, model_words[id]);
        ct[id] = file;
    }
    return OST_OK;
}

/* Returns true if the failure concerns only this item, so that other items may still be measured on this machine. */
static bool only_this_item(ost_status status)
{
    return status == OST_ERR_UNAVAILABLE || status == OST_ERR_IO || status == OST_ERR_MEMORY ||
           status == OST_ERR_RANGE || status == OST_ERR_INPUT || status == OST_ERR_USAGE;
}

ost_status reproduce_measure(app_state *app, const reproduce_args *args, const bool chosen[REPRODUCE_ITEMS_MAX],
                             reproduce_run *run, ost_error *err)
{
    reproduction r = {.bench = {.backend = app->backend,
                                .quick = args->quick,
                                .threads = app->threads ? (int)app->threads : bench_cpus()},
                      .progress = progress_show};
    ost_status status = select_cts(app, &args->ct, r.models.ct, err);
    if (status == OST_OK)
        status = reproduction_begin(&r, err);
    if (status == OST_OK)
        status = reproduce_make_folder(args->out, err);
    for (const reproduction_item *item = reproduction_items; item->id && status == OST_OK; item++) {
        if (!chosen[item - reproduction_items])
            continue;
        ost_error why = {.status = OST_OK};
        report_entry *e = &run->entry[run->count];
        result *to = &run->results[run->count++];
        *e = (report_entry){.item = item, .result = to};
        progress_show(NULL, item->id, 0);
        result_init(to, item->id, item->title, &r.machine);
        status = item->run(&r, to, &why);
        if (status == OST_OK) {
            status = reproduce_finish_item(app, args, run, e, err);
        } else if (only_this_item(status)) {
            e->result = NULL;
            memcpy(e->reason, why.text, sizeof e->reason);
            reproduce_report_item(app, item->id, NULL, NULL, why.text);
            if (!run->reason[0])
                memcpy(run->reason, why.text, sizeof run->reason);
            status = OST_OK;
        } else {
            *err = why;
        }
    }
    reproduction_end(&r);
    return status;
}
