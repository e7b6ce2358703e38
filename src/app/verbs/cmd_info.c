/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon info`: describes a file, using its header if it has one.
 */
#include <string.h>
#include <sys/stat.h>

#include "app/common/backend_choice.h"
#include "app/input/load.h"
#include "app/input/patient.h"
#include "app/input/proposal.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/replay/session_info.h"
#include "app/verbs/info_dicom.h"
#include "core/file.h"
#include "io/stack/read.h"

static void put_geometry(const app_state *app, const ost_geometry *g)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    double size[3] = {g->dims.x * ost_pm_to_mm(g->spacing.x), g->dims.y * ost_pm_to_mm(g->spacing.y),
                      g->dims.z * ost_pm_to_mm(g->spacing.z)};
    put_dims(app->result, "dims", g->dims);
    put_mm3(app->result, "spacing_mm", g->spacing);
    put_mm3(app->result, "origin_mm", g->origin);
    put(app->result, "size_mm", json_pack("[f,f,f]", size[0], size[1], size[2]));
    put_integer(app->result, "voxels", ost_dims_count(g->dims));
    print_line(app, "  %s voxels of %s, %.4g x %.4g x %.4g mm", format_dims(a, g->dims), format_spacing(b, g->spacing),
               size[0], size[1], size[2]);
    print_line(app, "  first voxel at %s", format_point(a, g->origin));
}

static void print_meta(const app_state *app, const ost_meta *meta)
{
    put_meta(app->result, "meta", meta);
    for (int i = 0; i < meta->count; i++)
        print_line(app, "  %s: %s", meta->entry[i].key, meta->entry[i].value);
}

static ost_status info_volume(const app_state *app, const char *name, const char *format, bool digest, ost_error *err)
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
    put_geometry(app, &geometry);
    print_meta(app, &meta);
    if ((status = angles_report(app, &meta, err)) != OST_OK)
        return ost_fail_context(err, "%s", name);
    if (!digest)
        load_warn_orientation(app, name, &meta);
    if (!digest)
        return OST_OK;

    loaded_volume loaded;
    ost_digest root;
    status = load_volume(app, name, &loaded, err);
    if (status != OST_OK)
        return status;
    int64_t solid = 0, count = ost_dims_count(loaded.volume.geometry.dims);
    for (int64_t v = 0; v < count; v++)
        solid += loaded.volume.voxels[v] >= loaded.threshold;
    ost_backend *backend = NULL;
    if (loaded.kind == LOAD_TOOL) {
        ost_tool *tool = NULL;
        status = backend_choose(app, &backend, err);
        const tool_options how = TOOL_OPTIONS_DEFAULT;
        if (status == OST_OK)
            status = load_tool(app, backend, name, NULL, &how, &tool, NULL, err);
        if (status == OST_OK)
            status = ost_tool_digest(tool, &root, err);
        ost_tool_free(tool);
    } else if (loaded.kind == LOAD_BONE) {
        ost_bone *bone = NULL;
        status = backend_choose(app, &backend, err);
        if (status == OST_OK)
            status = ost_bone_create(backend, &loaded.volume.geometry, 32, loaded.threshold, &bone, err);
        if (status == OST_OK)
            status = ost_bone_upload(bone, 0, loaded.volume.geometry.dims.z, loaded.volume.voxels, err);
        if (status == OST_OK)
            status = ost_bone_digest(bone, NULL, &root, err);
        ost_bone_free(bone);
    } else {
        status = ost_digest_volume(OST_GRID_RECT, &loaded.volume, &root, err);
    }
    ost_backend_close(backend);
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

/* Lists the series of a DICOM folder, and describes the series that would be read. */
static ost_status info_folder(const app_state *app, const char *name, const dicom_options *dicom, bool digest,
                              ost_error *err)
{
    ost_volume_options options = {.clamp = false};
    ost_geometry geometry;
    ost_volume volume = {0};
    ost_digest root;
    bool found;
    load_dicom_options(dicom, &options);
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "DICOM");
    ost_status status = info_dicom(app, name, &options, &found, &geometry, err);
    if (status != OST_OK)
        return status;
    if (found)
        put_geometry(app, &geometry);
    if (!digest)
        return OST_OK;
    status = ost_volume_read(name, &options, &volume, NULL, err);
    if (status == OST_OK)
        status = ost_digest_volume(OST_GRID_RECT, &volume, &root, err);
    ost_volume_free(&volume);
    if (status == OST_OK) {
        char hex[OST_DIGEST_HEX];
        put_digest(app->result, "sha256", &root);
        print_line(app, "  grid %s", ost_digest_hex(&root, hex));
    }
    return status;
}

/*
 * Describes a CT given as text. Such a file has no header, so the complete file is read, and its voxels are
 * discarded.
 */
static ost_status info_text(const app_state *app, const char *name, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_import_result r = {0};
    const ct_options ct = CT_OPTIONS_DEFAULT;
    char text[FORMAT_TEXT];
    ost_status status = backend_choose(app, &backend, err);
    if (status == OST_OK)
        status = load_bone(app, backend, name, &ct, false, &bone, &r, err);
    ost_bone_free(bone);
    ost_backend_close(backend);
    if (status != OST_OK)
        return status;
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "text");
    put_integer(app->result, "samples", (int64_t)r.scatter.samples);
    print_line(app, "%s: a CT as text, %s lines of x y z density", name,
               format_count(text, (int64_t)r.scatter.samples));
    put_geometry(app, &r.rect);
    print_meta(app, &r.meta);
    return OST_OK;
}

/* Describes a stack of slices. Such a stack states neither spacing nor position. */
static ost_status info_stack(const app_state *app, const char *name, ost_error *err)
{
    ost_stack_facts facts;
    char text[FORMAT_TEXT];
    const ost_status status = ost_stack_describe(name, &facts, err);
    if (status != OST_OK)
        return status;
    put_text(app->result, "kind", "ct");
    put_text(app->result, "format", "stack");
    put_text(app->result, "element_type", facts.type);
    put_text(app->result, "encoding", facts.encoding);
    put_dims(app->result, "dims", facts.dims);
    put(app->result, "pixel_mm", json_pack("[f,f]", facts.pixel_mm[0], facts.pixel_mm[1]));
    print_line(app, "%s: a stack of %d slices, %s, %s", name, facts.dims.z, facts.type, facts.encoding);
    print_line(app, "  %s voxels; osteon import --spacing states their size", format_dims(text, facts.dims));
    if (facts.pixel_mm[0] > 0 && facts.pixel_mm[1] > 0)
        print_line(app, "  its first slice states %.6g x %.6g mm per pixel, which may be wrong", facts.pixel_mm[0],
                   facts.pixel_mm[1]);
    return OST_OK;
}

static ost_status info_mesh(const app_state *app, const char *name, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_mesh_report report = {0};
    ost_pm3 lo, hi;
    size_t open_edges = 0;
    /* Any unit will do, because the file's own numbers are printed. */
    progress_show(NULL, "reading the mesh", 0);
    ost_status status = ost_mesh_read(name, OST_UNIT_MM, &mesh, &report, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_mesh_open_edges(&mesh, &open_edges, err);
    if (status == OST_OK) {
        char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
        double volume = ost_mesh_volume_mm3(&mesh);
        put_text(app->result, "kind", "mesh");
        put_text(app->result, "format", report.format);
        put_integer(app->result, "triangles", (int64_t)mesh.triangle_count);
        put_integer(app->result, "vertices", (int64_t)mesh.vertex_count);
        put_integer(app->result, "bodies", (int64_t)report.bodies);
        put_integer(app->result, "open_edges", (int64_t)open_edges);
        put(app->result, "bounds_mm",
            json_pack("[[f,f,f],[f,f,f]]", ost_pm_to_mm(lo.x), ost_pm_to_mm(lo.y), ost_pm_to_mm(lo.z),
                      ost_pm_to_mm(hi.x), ost_pm_to_mm(hi.y), ost_pm_to_mm(hi.z)));
        put(app->result, "dims",
            json_pack("[f,f,f]", ost_pm_to_mm(hi.x - lo.x), ost_pm_to_mm(hi.y - lo.y), ost_pm_to_mm(hi.z - lo.z)));
        put_real(app->result, "volume_mm3", volume);
        print_line(app, "%s: a mesh, %s, %s triangles, %zu part%s, %s", name, report.format,
                   format_count(a, (int64_t)mesh.triangle_count), report.bodies, report.bodies == 1 ? "" : "s",
                   open_edges ? "not closed" : "closed");
        print_line(app, "  from %s to %s, if its unit is the millimetre", format_point(b, lo), format_point(c, hi));
        print_line(app, "  volume %.4g mm3, %s open edge%s", volume, format_count(a, (int64_t)open_edges),
                   open_edges == 1 ? "" : "s");
    }
    ost_mesh_free(&mesh);
    return status;
}

static ost_status info_path(const app_state *app, const char *name, ost_error *err)
{
    ost_path path = {0};
    ost_path_report report;
    ost_status status = ost_path_read(name, NULL, &path, &report, err);
    if (status != OST_OK)
        return status;
    int32_t tools = 0;
    double seconds = path.count ? (double)(path.ticks[path.count - 1].t_ns - path.ticks[0].t_ns) * 1e-9 : 0;
    for (size_t i = 0; i < path.count; i++)
        tools = path.ticks[i].tool + 1 > tools ? path.ticks[i].tool + 1 : tools;
    char a[FORMAT_TEXT];
    put_text(app->result, "kind", "path");
    put_text(app->result, "format", "CSV");
    put(app->result, "dims", json_pack("[I]", (json_int_t)path.count));
    put_integer(app->result, "ticks", (int64_t)path.count);
    put_real(app->result, "seconds", seconds);
    put_integer(app->result, "tools", tools);
    put_integer(app->result, "gaps", (int64_t)report.gaps);
    put_integer(app->result, "lost_rows", (int64_t)report.lost_rows);
    print_line(app, "%s: a path of %s ticks in %.3f s, for %d tool%s", name, format_count(a, (int64_t)path.count),
               seconds, tools, tools == 1 ? "" : "s");
    if (report.gaps || report.lost_rows)
        print_line(app, "  %zu rows without a pose; the tool is lifted %zu time%s on its way", report.lost_rows,
                   report.gaps, report.gaps == 1 ? "" : "s");
    ost_path_free(&path);
    return OST_OK;
}

static ost_status set_facts(const app_state *app, const char *name, ost_file_kind kind, const option_list *sets,
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

ost_status cmd_info(app_state *app, int argc, char **argv, ost_error *err)
{
    const char *name = NULL, *repaired = NULL;
    bool digest = false;
    dicom_options dicom = {.series = NULL};
    option_list sets = {0};
    const operand operands[] = {{"FILE", &name, "no file given"}, {0}};
    const option options[] = {
        {.name = "digest", .kind = OPTION_FLAG, .out = &digest,
         .help = "read the entire file: number of solid voxels, SHA-256 of the grid and of the file"},
        {.name = "set", .kind = OPTION_LIST, .out = &sets, .value = "KEY=VALUE",
         .help = "set a fact in the header of a bone or CT and leave its voxels: at=X,Y,Z, axis=X,Y,Z, side=left "
                 "or right, trigonum=X,Y,Z, inferior-angle=X,Y,Z; an empty VALUE removes the fact; may repeat"},
        DICOM_OPTIONS(dicom),
        {.name = "repair", .kind = OPTION_OUTPUT, .out = &repaired, .value = "FILE",
         .help = "write the complete ticks of a session that was cut off or damaged as a new session"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "FILE [--digest] [--set KEY=VALUE] [--repair FILE]",
        .about = "Describes a file: a CT, a bone, a tool grid, a mesh, a path or a session. Only the\n"
                 "header of a volume is read. A session is read completely, and its missing parts are\n"
                 "listed. For a folder of DICOM files, the series are listed.",
        .operands = operands,
        .streams = true,
        .options = options,
        .example =
            "  osteon info scapula.nrrd\n  osteon info scan/\n"
            "  osteon info scapula.nrrd --set side=left\n  osteon info reamer.stl --json\n"
            "  osteon info cut-off.session --repair whole.session",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    ost_file_kind kind;
    if ((status = ost_file_kind_find(name, &kind, err)) != OST_OK)
        return status;
    if (repaired && kind != OST_FILE_SESSION)
        return usage_error(app, err, "--repair needs a session; %s is not a session", name);
    if ((dicom.series || dicom.even_slices || dicom.untilt) && kind != OST_FILE_DICOM)
        return usage_error(app, err, "--series, --even-slices and --untilt need DICOM; %s is not DICOM", name);
    if (sets.count && ost_file_is_stream(name))
        return usage_error(app, err, "--set needs a file; %s is standard input", name);
    if (sets.count && (status = set_facts(app, name, kind, &sets, err)) != OST_OK)
        return status;
    struct stat st;
    put_text(app->result, "file", name);
    const bool readable = stat(name, &st) == 0, folder = readable && S_ISDIR(st.st_mode);
    if (readable && !folder)
        put_integer(app->result, "file_bytes", st.st_size);
    switch (kind) {
    case OST_FILE_NRRD: status = info_volume(app, name, "NRRD", digest, err); break;
    case OST_FILE_NIFTI: status = info_volume(app, name, "NIfTI", digest, err); break;
    case OST_FILE_METAIMAGE: status = info_volume(app, name, "MetaImage", digest, err); break;
    case OST_FILE_DICOM: status = info_folder(app, name, &dicom, digest, err); break;
    case OST_FILE_STACK: status = info_stack(app, name, err); break;
    case OST_FILE_CT_TEXT: status = info_text(app, name, err); break;
    case OST_FILE_MESH: status = info_mesh(app, name, err); break;
    case OST_FILE_PATH_CSV: status = info_path(app, name, err); break;
    case OST_FILE_SESSION: status = info_session(app, name, repaired, err); break;
    case OST_FILE_UNKNOWN: status = ost_fail(err, OST_ERR_INPUT, "%s: unknown kind of file; expected a CT, a bone, a "
                                             "mesh, a tool grid, a path or a session", name); break;
    }
    if (status != OST_OK || !digest || folder || kind == OST_FILE_STACK)
        return status;
    ost_digest file;
    if ((status = file_digest(name, &file, err)) == OST_OK)
        put_digest(app->result, "file_sha256", &file);
    return status;
}
