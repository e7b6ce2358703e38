/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon reproduce`: reproduces the tables and figures of the thesis (reproduction/item.h).
 *
 *   items --run--> result --> files --.
 *   --merge DIR: files of other runs -+--> report.html
 */
#include "app/reproduce/reproduce.h"

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
    bool chosen[REPRODUCE_ITEMS_MAX] = {false};
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.list) {
        reproduce_list_items(app);
        return OST_OK;
    }
    status = reproduce_select_items(app, args.items, chosen, err);
    if (status != OST_OK)
        return status;
    if (!args.out)
        return usage_error(app, err, "--out DIR is missing");
    if (args.merge.count && args.ct.count)
        return usage_error(app, err, "--ct has no effect with --merge, which measures nothing");
    return reproduce_items(app, &args, chosen, err);
}
