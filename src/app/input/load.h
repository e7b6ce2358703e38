/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Loads a bone or a tool from any supported file.
 *
 *   bone   builtin:scapula (a phantom), a CT, or a bone that import wrote
 *   tool   builtin:reamer, a mesh, or a tool that voxelize wrote
 *   volume any voxels, in host memory and unchanged: for diff and export
 *
 * All verbs that load files share the same options for loading.
 */
#ifndef OST_APP_INPUT_LOAD_H
#define OST_APP_INPUT_LOAD_H

#include "app/common/options.h"

typedef struct dicom_options {
    const char *series; /* value of --series; NULL if the option is not given */
    bool even_slices, untilt;
} dicom_options;

/* The rows of the DICOM options in a verb's option table. */
#define DICOM_OPTIONS(d)                                                                                         \
    {.name = "series", .kind = OPTION_TEXT, .out = &(d).series, .value = "NUMBER|TEXT|UID",                      \
     .help = "series of a DICOM folder, by number, description or UID (default: the only one that is a volume; " \
             "osteon info lists them)"},                                                                         \
    {.name = "even-slices", .kind = OPTION_FLAG, .out = &(d).even_slices,                                        \
     .help = "interpolate DICOM slices with uneven distances or gaps onto even ones (default: refuse them)"},    \
    {.name = "untilt", .kind = OPTION_FLAG, .out = &(d).untilt,                                                  \
     .help = "correct the shear of DICOM slices from a tilted gantry (default: refuse them)"}

typedef struct ct_options {
    ost_pm3 spacing;
    ost_pm cubic;
    int64_t threshold; /* threshold; 0 selects the threshold that a bone's file stores, or 120 for any other file */
    const char *crop;
    int chunk; /* index in "16|32|64" */
    int resample; /* an ost_resample, from "linear|nearest|thesis"; negative if the file determines the rule */
    int duplicates; /* an ost_duplicates, from "error|first|last|max" */
    bool clamp, nan_as_air, resample_oblique;
    const char *orientation; /* value of --orientation; NULL if the option is not given */
    int form;                /* an ost_nifti_form, from "auto|qform|sform" */
    const char *mask;        /* FILE[:LABEL,...], where a LABEL is a number or a name; NULL if not given */
    const char *mask_names;  /* file of label names; NULL if not given */
    dicom_options dicom;
    bool mask_fill;
    /* function that labels the bones of the CT, so that one of them can be selected; NULL imports the complete CT */
    ost_import_labels *labels;
    void *labels_user;
} ct_options;

#define CT_OPTIONS_DEFAULT {.chunk = 1, .resample = -1}

/* The rows of the CT options in a verb's option table. */
#define CT_OPTIONS(c)                                                                                            \
    {.name = "spacing", .kind = OPTION_LENGTHS, .out = &(c).spacing, .value = "MM[,MM,MM]",                      \
     .help = "voxel spacing of the CT (default: as in the file; of a text, derived from its positions); required " \
             "for a stack of TIFF or PNG slices: columns, rows, slices"},                                        \
    {.name = "threshold", .kind = OPTION_INTEGER, .out = &(c).threshold, .value = "HU", .min = 1, .max = 32767,  \
     .help = "lowest density of bone (default: as in the bone's file, else 120)"},                               \
    {.name = "cubic", .kind = OPTION_LENGTH, .out = &(c).cubic, .value = "MM",                                   \
     .help = "edge length of the bone's cubic voxels (default: the CT's spacing along x)"},                      \
    {.name = "crop", .kind = OPTION_TEXT, .out = &(c).crop, .value = "I:I,J:J,K:K",                              \
     .help = "voxels of the CT to read along each axis, first:end, counted from 0; end is excluded"},            \
    {.name = "resample", .kind = OPTION_CHOICE, .out = &(c).resample, .value = "linear|nearest|thesis",          \
     .help = "value of a cubic voxel: interpolated linearly, from the nearest voxel of the CT, or by the rule "  \
             "of the thesis (default: linear; nearest for a label map)"},                                        \
    {.name = "duplicates", .kind = OPTION_CHOICE, .out = &(c).duplicates, .value = "error|first|last|max",       \
     .help = "density to use if a text contains a voxel twice with different densities (default: error)"},       \
    {.name = "clamp", .kind = OPTION_FLAG, .out = &(c).clamp,                                                    \
     .help = "clamp densities outside the range of int16 (default: refuse the CT)"},                             \
    {.name = "nan-as-air", .kind = OPTION_FLAG, .out = &(c).nan_as_air,                                          \
     .help = "convert NaN, a voxel without a value, to -1024 HU (default: refuse the CT)"},                      \
    {.name = "resample-oblique", .kind = OPTION_FLAG, .out = &(c).resample_oblique,                              \
     .help = "resample a rotated CT onto the patient's axes (default: refuse the CT)"},                          \
    {.name = "orientation", .kind = OPTION_TEXT, .out = &(c).orientation, .value = "XYZ",                        \
     .help = "directions of the axes of a CT whose file does not state them, such as LPS or RAS (default: LPS, " \
             "with a warning)"},                                                                                 \
    DICOM_OPTIONS((c).dicom),                                                                                    \
    {.name = "form", .kind = OPTION_CHOICE, .out = &(c).form, .value = "auto|qform|sform",                       \
     .help = "transform of a NIfTI that places the CT (default: auto; required if the two disagree)"},           \
    {.name = "chunk", .kind = OPTION_CHOICE, .out = &(c).chunk, .value = "16|32|64",                             \
     .help = "edge length of a chunk in voxels (default: 32); no voxel depends on it"}

typedef struct tool_options {
    ost_pm voxel;
    int unit; /* an ost_unit, from "auto|mm|cm|m|inch|um" */
    int rule; /* an ost_fill_rule, from "winding|parity" */
} tool_options;

#define TOOL_OPTIONS_DEFAULT {.voxel = OST_PM_PER_MM / 2}

#define TOOL_OPTIONS(t)                                                                                        \
    {.name = "voxel", .kind = OPTION_LENGTH, .out = &(t).voxel, .value = "MM",                                 \
     .help = "edge length of the tool's voxels (default: 0.5)"},                                               \
    {.name = "unit", .kind = OPTION_CHOICE, .out = &(t).unit, .value = "auto|mm|cm|m|inch|um",                 \
     .help = "unit of the mesh's coordinates (default: auto, which is millimetres if the size is plausible)"}, \
    {.name = "rule", .kind = OPTION_CHOICE, .out = &(t).rule, .value = "winding|parity",                       \
     .help = "rule for the inside of a mesh: winding number not zero (default), or odd number of crossings"}

/* Figures about the mesh from which a tool was loaded. They are zero if the file is a tool grid. */
typedef struct tool_report {
    ost_mesh_report mesh;
    size_t triangles, dropped_triangles;
    double mesh_volume_mm3;
    size_t open_edges;
    ost_voxelize_report voxels;
    ost_digest snapped;
    double time_ms; /* duration of the voxelization, excluding the time to read the file */
} tool_report;

/* Returns the part of a name after "builtin:", or NULL if the name is a file name. */
const char *builtin_name(const char *name);

ost_status load_bone(const app_state *app, ost_backend *backend, const char *name, const ct_options *ct, bool digests,
                     ost_bone **out, ost_import_result *result, ost_error *err);

/* Returns a word for the type of a file, such as "NRRD" or "text". For OST_FILE_UNKNOWN, returns "built in". */
const char *load_kind_name(ost_file_kind kind);

/* Converts the parsed options of a verb to options of ost_import. */
ost_status load_import_options(const app_state *app, const ct_options *ct, bool digests, ost_import_options *out,
                               ost_error *err);
/* Converts the parsed DICOM options to options of ost_volume_read. */
void load_dicom_options(const dicom_options *options, ost_volume_options *out);
/* Prints a warning for each irregularity of a DICOM series that the reader found. */
void load_warn_dicom(const app_state *app, const char *name, const ost_dicom_report *r);
/* Warns if the orientation of a file was assumed, either now or when the file was imported. */
void load_warn_orientation(const app_state *app, const char *name, const ost_meta *meta);
/* Prints a warning for each conversion during an import that the user may not expect. */
void load_warn_import(const app_state *app, const char *name, const ost_import_result *r);

enum { LOAD_UNITS_TEXT = 200 };
/*
 * Suggests other units for a mesh whose size is `mm` millimetres. Writes ": it would be ..." with each unit for which
 * the size would be from 20 to 600 mm. Writes "" if there is no such unit. Returns `out`.
 */
char *load_other_units(char out[LOAD_UNITS_TEXT], double mm);

ost_status load_mesh(const char *name, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err);

/* Loads a tool. `noncutting` is the name of a second mesh on the same grid, or NULL. `report` may be NULL. */
ost_status load_tool(const app_state *app, ost_backend *backend, const char *name, const char *noncutting,
                     const tool_options *options, ost_tool **out, tool_report *report, ost_error *err);

enum { LOAD_TOOL_PARTS = 2 };
/*
 * Loads the meshes of a tool's parts, in the frame of the tool, for drawing. Sets *count to the number of meshes; the
 * caller frees each mesh with ost_mesh_free. *count is 0 after an error, and for a tool grid, which has no mesh.
 */
ost_status load_tool_parts(const char *name, const tool_options *options, ost_mesh parts[LOAD_TOOL_PARTS], int *count,
                           ost_error *err);

typedef enum load_kind { LOAD_CT, LOAD_BONE, LOAD_TOOL } load_kind;
typedef struct loaded_volume {
    load_kind kind;
    ost_volume volume;             /* voxels; the value of a tool's voxel is its class: 0, 1 or 2 */
    ost_tool_geometry tool;        /* valid if `kind` is LOAD_TOOL */
    /* Lowest value of a solid voxel: the stored threshold for a bone, 1 for a tool, 120 for any other volume. */
    int32_t threshold;
} loaded_volume;

/*
 * Loads a volume: NRRD, NIfTI, MetaImage, DICOM, a CT given as text, or builtin:NAME. A CT given as text is imported
 * as a bone, so its densities below the threshold become 0. The caller frees the volume with
 * ost_volume_free(&out->volume).
 */
ost_status load_volume(const app_state *app, const char *name, loaded_volume *out, ost_error *err);

/*
 * If the volume is a CT whose voxels are not cubes, imports it as `osteon import` does. Any other volume remains
 * unchanged.
 */
ost_status loaded_to_bone(const app_state *app, const char *name, loaded_volume *volume, ost_error *err);

/* Copies a bone's voxels into host memory. */
ost_status bone_to_volume(const ost_bone *bone, const ost_meta *meta, ost_volume *out, ost_error *err);

/*
 * Opens a session and warns if its recording is incomplete or damaged. The caller closes *out with ost_session_close.
 */
ost_status load_session(const app_state *app, const char *name, ost_session **out, ost_error *err);
/* Reads the ticks of a session up to the first gap in the tick numbers. Warns as load_session does. */
ost_status load_session_path(const app_state *app, const char *name, ost_path *out, ost_error *err);

/*
 * Checks that `path` has one of the extensions in `ends`, such as "nrrd|nii|nii.gz|txt", and that its folder exists.
 * Called before any work is done. An existing file is later replaced without a warning.
 */
ost_status out_check(app_state *app, const char *path, const char *ends, ost_error *err);
bool ends_with(const char *path, const char *end);

#endif
