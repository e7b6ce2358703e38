/* SPDX-License-Identifier: Apache-2.0 */
#include "app/import/import.h"

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/input/proposal.h"
#include "app/picture/previews.h"

ost_status import_ct(app_state *app, const import_args *args, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result result = {0};
    ost_bone_info info;
    ost_digest file;
    const ost_write_options write = {.compress = args->compress, .progress = progress_show};
    segment_job job;
    ct_options ct = args->ct;
    ost_status status = segment_job_init(&job, app, &args->segment, err);
    if (status != OST_OK)
        return status;
    if (segment_is_given(&args->segment)) {
        ct.labels = segment_job_labels;
        ct.labels_user = &job;
    }
    status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, args->name, &ct, true, &bone, &result, err);
    if (status == OST_OK)
        status = patient_take(app, &args->patient, bone, args->name, &result.cubic, &result.meta, err);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK && info.active_voxels == 0)
        warn(app,
             result.volume.labels
                 ? "%s: no voxel has %d HU or more; the bone is empty; the CT is a label map: pass it to --mask, or "
                   "pass --threshold 1 to import its labels as bone"
                 : "%s: no voxel has %d HU or more; the bone is empty",
             args->name, info.threshold);
    if (status == OST_OK)
        import_warn_size(app, args->name, &result);
    if (status == OST_OK && args->preview)
        status = preview_import(app, args->preview, args->name, args->out, &ct, bone, &result, err);
    if (status == OST_OK)
        status = ost_bone_write(args->out, bone, &result.meta, &write, err);
    if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK) {
        put_text(app->result, "in", args->name);
        put_text(app->result, "out", args->out);
        import_put_result(app, &result, &info);
        put_digest(app->result, "file_sha256", &file);
        if (args->preview)
            put_text(app->result, "preview", args->preview);
        if (ct.labels)
            segment_job_report(&job, args->name);
        import_print_result(app, args->name, args->out, &result, &info);
        status = angles_report(app, &result.meta, err);
    }
    segment_job_free(&job);
    ost_bone_free(bone);
    ost_backend_close(backend);
    return status;
}
