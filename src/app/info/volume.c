/* SPDX-License-Identifier: Apache-2.0 */
#include "app/info/info.h"

#include <string.h>

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/result.h"
#include "app/input/patient.h"
#include "app/input/proposal.h"

static ost_status digest_grid(const app_state *app, const char *name, const loaded_volume *loaded, ost_digest *root,
                              ost_error *err)
{
    ost_status status = OST_OK;
    ost_backend *backend = NULL;
    if (loaded->kind == LOAD_TOOL) {
        ost_tool *tool = NULL;
        status = backend_choose(app, &backend, err);
        const tool_options how = TOOL_OPTIONS_DEFAULT;
        if (status == OST_OK)
            status = load_tool(app, backend, name, NULL, &how, &tool, NULL, err);
        if (status == OST_OK)
            status = ost_tool_digest(tool, root, err);
        ost_tool_free(tool);
    } else if (loaded->kind == LOAD_BONE) {
        ost_bone *bone = NULL;
        status = backend_choose(app, &backend, err);
        if (status == OST_OK)
            status = ost_bone_create(backend, &loaded->volume.geometry, 32, loaded->threshold, &bone, err);
        if (status == OST_OK)
            status = ost_bone_upload(bone, 0, loaded->volume.geometry.dims.z, loaded->volume.voxels, err);
        if (status == OST_OK)
            status = ost_bone_digest(bone, NULL, root, err);
        ost_bone_free(bone);
    } else {
        status = ost_digest_volume(OST_GRID_RECT, &loaded->volume, root, err);
    }
    ost_backend_close(backend);
    return status;
}

/* Reads the voxels, and prints the number of solid ones and the digest of the grid that a verb would make from them. */
static ost_status digest_volume(const app_state *app, const char *name, ost_error *err)
{
    loaded_volume loaded;
    ost_digest root;
    ost_status status = load_volume(app, name, &loaded, err);
    if (status != OST_OK)
        return status;
    int64_t solid = 0, count = ost_dims_count(loaded.volume.geometry.dims);
    for (int64_t v = 0; v < count; v++)
        solid += loaded.volume.voxels[v] >= loaded.threshold;
    status = digest_grid(app, name, &loaded, &root, err);
    ost_volume_free(&loaded.volume);
    if (status != OST_OK)
        return status;
    char hex[OST_DIGEST_HEX], text[FORMAT_TEXT];
    put_integer(app->result, "solid_voxels", solid);
    put_digest(app->result, "sha256", &root);
    print_line(app, "  %s solid voxels", format_count(text, solid));
    print_line(app, "  grid %s", ost_digest_hex(&root, hex));
    return OST_OK;
}

ost_status info_volume(const app_state *app, const char *name, const char *format, bool digest, ost_error *err)
{
    ost_geometry geometry;
    ost_meta meta = {0};
    ost_volume_report report = {0};
    ost_status status = ost_volume_read_header(name, &geometry, &meta, &report, err);
    if (status != OST_OK)
        return status;
    const char *kind = ost_meta_get(&meta, OST_META_KIND);
    if (!kind)
        kind = "ct";
    put_text(app->result, "kind", kind);
    put_text(app->result, "format", format);
    put_text(app->result, "element_type", report.type);
    put_text(app->result, "encoding", report.encoding);
    put_text(app->result, "orientation", report.orientation);
    const char *shown = strcmp(kind, "ct") == 0 ? "CT" : strcmp(kind, "labels") == 0 ? "label map" : kind;
    print_line(app, "%s: a %s in %s, %s, %s%s%s", name, shown, format, report.type,
               report.encoding, report.orientation[0] ? ", axes to " : "", report.orientation);
    put_bool(app->result, "orientation_assumed", report.assumed);
    info_put_geometry(app, &geometry);
    info_print_meta(app, &meta);
    if ((status = angles_report(app, &meta, err)) != OST_OK)
        return ost_fail_context(err, "%s", name);
    if (!digest)
        load_warn_orientation(app, name, &meta);
    return digest ? digest_volume(app, name, err) : OST_OK;
}

ost_status info_set_facts(const app_state *app, const char *name, ost_file_kind kind, const option_list *sets,
                          ost_error *err)
{
    ost_geometry geometry;
    ost_meta meta;
    if (kind != OST_FILE_NRRD && kind != OST_FILE_NIFTI)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: --set needs a bone or a CT in NRRD or NIfTI; pass these values to 'osteon import'",
                        name);
    ost_status status = ost_volume_read_header(name, &geometry, &meta, NULL, err);
    if (status == OST_OK)
        status = patient_set(app, sets, name, &geometry, &meta, err);
    return status == OST_OK ? ost_volume_write_meta(name, &meta, err) : status;
}
