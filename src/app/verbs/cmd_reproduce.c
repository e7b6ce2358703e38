/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon reproduce`: reproduces the tables and figures of the thesis (reproduction/item.h).
 *
 *   items --run--> result --> files --.
 *   --merge DIR: files of other runs -+--> report.html
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/options.h"
#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "reproduction/report.h"
#include "reproduction/write.h"

enum { ITEMS_MAX = 64 };

typedef struct reproduce_args {
    const char *items, *out;
    bool quick, list;
    option_list merge, ct;
} reproduce_args;

/* The items of a run, in the order of the thesis. */
typedef struct reproduce_run {
    int count;
    report_entry entry[ITEMS_MAX];
    result results[ITEMS_MAX];
    int measured;
    char reason[OST_ERROR_TEXT]; /* reason for the first failure to measure an item */
} reproduce_run;

/* --------------------------------------------------------------- arguments */

static ost_status select_item(const app_state *app, const char *name, bool chosen[ITEMS_MAX], ost_error *err)
{
    const reproduction_item *item = reproduction_find(name);
    if (item) {
        chosen[item - reproduction_items] = true;
        return OST_OK;
    }
    for (const reproduction_absent *absent = reproduction_missing; absent->id; absent++)
        if (strcmp(absent->id, name) == 0)
            return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: %s", name, absent->reason);
    const char *ids[ITEMS_MAX];
    int count = 0;
    for (const reproduction_item *i = reproduction_items; i->id; i++)
        ids[count++] = i->id;
    const char *near = nearest_name(name, ids, count);
    if (near)
        return usage_error(app, err, "'%s' is not an item; did you mean %s? --list shows all", name, near);
    return usage_error(app, err, "'%s' is not an item; --list shows all", name);
}

/* Selects the items in a list such as "table-3.3,figure-3.2". Selects all items if the text is "all" or NULL. */
static ost_status select_items(const app_state *app, const char *text, bool chosen[ITEMS_MAX], ost_error *err)
{
    const bool all = !text || strcmp(text, "all") == 0;
    for (int i = 0; i < ITEMS_MAX && all; i++)
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

static ost_status make_folder(const char *folder, ost_error *err)
{
    struct stat st;
    if (mkdir(folder, 0777) == 0)
        return OST_OK;
    const int why = errno;
    if (why == EEXIST && stat(folder, &st) == 0 && S_ISDIR(st.st_mode))
        return OST_OK;
    return ost_fail(err, OST_ERR_IO, "%s: cannot make the folder: %s", folder,
                    why == EEXIST ? "is a file" : strerror(why));
}

/* -------------------------------------------------------------------- list */

static void list_items(app_state *app)
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

/* --------------------------------------------------------------- measuring */

static void report_item(app_state *app, const char *id, const result *r, const write_files *files, const char *reason)
{
    json_t *o = json_object(), *names = json_array();
    put_text(o, "name", id);
    put_bool(o, "measured", r != NULL);
    if (!r)
        put_text(o, "reason", reason);
    for (int i = 0; r && i < files->count; i++)
        append(names, json_string(files->name[i]));
    put(o, "files", names);
    append(json_object_get(app->result, "items"), o);
    progress_clear();
    if (!r)
        print_line(app, "%-14s not measured: %s", id, reason);
    else
        print_line(app, "%-14s %zu rows, %d plots, %zu pictures", id, r->row_count, r->plot_count, r->picture_count);
    for (size_t i = 0; r && i < r->finding_count; i++)
        print_line(app, "  %s: %s", result_verdict_names[r->finding[i].verdict], r->finding[i].claim);
}

/* Adds a measured or merged result to the run and writes its files. */
static ost_status finish_item(app_state *app, const reproduce_args *args, reproduce_run *run, report_entry *e,
                              ost_error *err)
{
    write_files files;
    ost_status status = write_result(args->out, e->result, &files, err);
    if (status != OST_OK)
        return status;
    report_item(app, e->item->id, e->result, &files, "");
    run->measured++;
    return OST_OK;
}

/* Returns true if the failure concerns only this item, so that other items may still be measured on this machine. */
static bool only_this_item(ost_status status)
{
    return status == OST_ERR_UNAVAILABLE || status == OST_ERR_IO || status == OST_ERR_MEMORY ||
           status == OST_ERR_RANGE || status == OST_ERR_INPUT || status == OST_ERR_USAGE;
}

static ost_status measure(app_state *app, const reproduce_args *args, const bool chosen[ITEMS_MAX], reproduce_run *run,
                          ost_error *err)
{
    reproduction r = {.bench = {.backend = app->backend,
                                .quick = args->quick,
                                .threads = app->threads ? (int)app->threads : bench_cpus()},
                      .progress = progress_show};
    ost_status status = select_cts(app, &args->ct, r.models.ct, err);
    if (status == OST_OK)
        status = reproduction_begin(&r, err);
    if (status == OST_OK)
        status = make_folder(args->out, err);
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
            status = finish_item(app, args, run, e, err);
        } else if (only_this_item(status)) {
            e->result = NULL;
            memcpy(e->reason, why.text, sizeof e->reason);
            report_item(app, item->id, NULL, NULL, why.text);
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

/* ----------------------------------------------------------------- merging */

/* Merges an item from all folders that contain it. If there is no such folder, the result names no machine. */
static ost_status merge_item(const reproduce_args *args, const reproduction_item *item, result *out, ost_error *err)
{
    ost_status status = OST_OK;
    bool any = false;
    for (int i = 0; i < args->merge.count && status == OST_OK; i++) {
        result one;
        bool absent = false;
        status = write_read(args->merge.value[i], item->id, &one, &absent, err);
        if (absent) {
            *err = (ost_error){.status = OST_OK};
            result_free(&one);
            status = OST_OK;
            continue;
        }
        if (status == OST_OK && !any) {
            *out = one;
            any = true;
            continue;
        }
        if (status == OST_OK)
            status = result_merge(out, &one, err);
        result_free(&one);
    }
    return status;
}

static ost_status merge(app_state *app, const reproduce_args *args, const bool chosen[ITEMS_MAX], reproduce_run *run,
                        ost_error *err)
{
    ost_status status = OST_OK;
    for (const reproduction_item *item = reproduction_items; item->id && status == OST_OK; item++) {
        result *to = &run->results[run->count];
        report_entry *e = &run->entry[run->count];
        if (!chosen[item - reproduction_items])
            continue;
        status = merge_item(args, item, to, err);
        if (status != OST_OK || to->machine_count == 0)
            continue;
        *e = (report_entry){.item = item, .result = to};
        status = run->count++ == 0 ? make_folder(args->out, err) : OST_OK;
        if (status == OST_OK)
            status = finish_item(app, args, run, e, err);
    }
    if (status == OST_OK && run->measured == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: contains no result of osteon reproduce", args->merge.value[0]);
    return status;
}

static ost_status run_items(app_state *app, const reproduce_args *args, const bool chosen[ITEMS_MAX], ost_error *err)
{
    reproduce_run *run = calloc(1, sizeof *run);
    if (!run)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the results");
    put(app->result, "items", json_array());
    ost_status status =
        args->merge.count ? merge(app, args, chosen, run, err) : measure(app, args, chosen, run, err);
    if (status == OST_OK)
        status = reproduction_report(args->out, run->entry, (size_t)run->count, err);
    if (status == OST_OK) {
        char path[WRITE_PATH];
        status = write_path(path, args->out, "report.html", err);
        put_text(app->result, "report", path);
        put_integer(app->result, "measured", run->measured);
        put_integer(app->result, "not_measured", run->count - run->measured);
        print_line(app, "%s: %d items", path, run->measured);
    }
    if (status == OST_OK && run->measured == 0) {
        app->answered = true;
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "no item could be measured: %s", run->reason);
    }
    for (int i = 0; i < run->count; i++)
        result_free(&run->results[i]);
    free(run);
    return status;
}

ost_status cmd_reproduce(app_state *app, int argc, char **argv, ost_error *err)
{
    reproduce_args args = {.items = NULL};
    const option options[] = {
        {.name = "out",
         .kind = OPTION_TEXT,
         .out = &args.out,
         .value = "DIR",
         .help = "folder for the output files; it is created if it does not exist"},
        {.name = "quick",
         .kind = OPTION_FLAG,
         .out = &args.quick,
         .help = "use few repetitions and small inputs, to check that everything runs"},
        {.name = "list",
         .kind = OPTION_FLAG,
         .out = &args.list,
         .help = "list the items, and the tables and figures that cannot be reproduced, with the reason"},
        {.name = "merge",
         .kind = OPTION_LIST,
         .out = &args.merge,
         .value = "DIR",
         .help = "measure nothing: merge the results of another run, from any machine or device; may repeat"},
        {.name = "ct",
         .kind = OPTION_LIST,
         .out = &args.ct,
         .value = "[MODEL=]FILE",
         .help = "use a CT instead of the model foam, core-2, core-1, scapula (default) or glenoid; may repeat"},
        {.name = NULL}};
    const operand operands[] = {{"ITEM", &args.items, NULL}, {NULL, NULL, NULL}};
    const usage_text usage = {
        .synopsis = "[ITEM[,ITEM...]|all] --out DIR [options]",
        .about = "Reproduces the tables and figures of the thesis as CSV, JSON, plots and pictures,\n"
                 "each with the thesis' own values next to those of this machine, and writes a\n"
                 "report.",
        .operands = operands,
        .options = options,
        .notes = "An item is a table or a figure: table-3.3, figure-3.10 or fig-3.10. Its files are\n"
                 "ITEM.json, ITEM.csv, ITEM.svg and pictures; report.html shows all items of the run.\n"
                 "The items of the kind `times` differ between machines; all others do not.\n"
                 "The report of all items takes minutes; --quick takes less than two.\n"
                 "Exit status 0: items were measured; 2: wrong usage; 3: no item could be measured on\n"
                 "this machine, or the backend is not available.",
        .example = "  osteon reproduce all --out thesis\n"
                   "  osteon reproduce table-3.3,table-3.4 --out chunks --backend cl\n"
                   "  osteon reproduce --out both --merge thesis --merge other-machine/thesis",
    };
    ost_status status;
    bool chosen[ITEMS_MAX] = {false};
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.list) {
        list_items(app);
        return OST_OK;
    }
    status = select_items(app, args.items, chosen, err);
    if (status != OST_OK)
        return status;
    if (!args.out)
        return usage_error(app, err, "--out DIR is missing");
    if (args.merge.count && args.ct.count)
        return usage_error(app, err, "--ct has no effect with --merge, which measures nothing");
    return run_items(app, &args, chosen, err);
}
