/* SPDX-License-Identifier: Apache-2.0 */
#include "app/reproduce/reproduce.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

ost_status reproduce_make_folder(const char *folder, ost_error *err)
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

void reproduce_report_item(app_state *app, const char *id, const result *r, const write_files *files,
                           const char *reason)
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

ost_status reproduce_finish_item(app_state *app, const reproduce_args *args, reproduce_run *run, report_entry *e,
                                 ost_error *err)
{
    write_files files;
    ost_status status = write_result(args->out, e->result, &files, err);
    if (status != OST_OK)
        return status;
    reproduce_report_item(app, e->item->id, e->result, &files, "");
    run->measured++;
    return OST_OK;
}
