/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon info`: describes a file, using its header if it has one.
 */
#include <sys/stat.h>

#include "app/common/result.h"
#include "app/info/info.h"
#include "app/replay/session_info.h"
#include "core/file.h"

static ost_status describe(const app_state *app, const char *name, ost_file_kind kind, const dicom_options *dicom,
                           const char *repaired, bool digest, ost_error *err)
{
    switch (kind) {
    case OST_FILE_NRRD: return info_volume(app, name, "NRRD", digest, err);
    case OST_FILE_NIFTI: return info_volume(app, name, "NIfTI", digest, err);
    case OST_FILE_METAIMAGE: return info_volume(app, name, "MetaImage", digest, err);
    case OST_FILE_DICOM: return info_folder(app, name, dicom, digest, err);
    case OST_FILE_STACK: return info_stack(app, name, err);
    case OST_FILE_CT_TEXT: return info_text(app, name, err);
    case OST_FILE_MESH: return info_mesh(app, name, err);
    case OST_FILE_PATH_CSV: return info_path(app, name, err);
    case OST_FILE_SESSION: return info_session(app, name, repaired, err);
    case OST_FILE_UNKNOWN: break;
    }
    return ost_fail(err, OST_ERR_INPUT, "%s: unknown kind of file; expected a CT, a bone, a mesh, a tool grid, a path "
                    "or a session", name);
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
    if (sets.count && (status = info_set_facts(app, name, kind, &sets, err)) != OST_OK)
        return status;
    struct stat st;
    put_text(app->result, "file", name);
    const bool readable = stat(name, &st) == 0, folder = readable && S_ISDIR(st.st_mode);
    if (readable && S_ISREG(st.st_mode)) /* a stream has no size */
        put_integer(app->result, "file_bytes", st.st_size);
    status = describe(app, name, kind, &dicom, repaired, digest, err);
    if (status != OST_OK || !digest || folder || kind == OST_FILE_STACK)
        return status;
    ost_digest file;
    if ((status = file_digest(name, &file, err)) == OST_OK)
        put_digest(app->result, "file_sha256", &file);
    return status;
}
