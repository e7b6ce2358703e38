/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes files.
 *
 * Input is treated as hostile: every reader reports errors in one line that names
 * the file, the line or offset, the value, and what was expected. Memory is bounded
 * by the resulting grid, never by the size of the file.
 * An output file appears under its name only when it is complete: it is written in
 * the same folder under another name or none, synced, and then given its name.
 *
 * The kind of a file is determined by its content if it has a signature, else by its
 * name.  Text is read in the C locale, whatever the program's.
 */
#ifndef OSTEON_IO_H
#define OSTEON_IO_H

#include <osteon/backend.h>
#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Called from time to time with the share done in [0, 1]. Return false to cancel the operation (OST_ERR_CANCELLED). */
typedef bool ost_progress(void *user, const char *stage, double share);

/* The kind of a file's content. */
typedef enum ost_file_kind {
    OST_FILE_UNKNOWN,
    OST_FILE_CT_TEXT,
    OST_FILE_NRRD,
    OST_FILE_NIFTI,
    OST_FILE_MESH,
    OST_FILE_PATH_CSV,
    OST_FILE_SESSION /* session.h */
} ost_file_kind;

/*
 * Determines the kind of a file by its content or, without a signature, by its name. Returns
 * OST_ERR_INPUT, with the program that converts it, for a format that osteon does not read: DICOM,
 * MetaImage, TIFF, compressed files and others.
 */
OST_API ost_status ost_file_kind_find(const char *path, ost_file_kind *out, ost_error *err);

/* --------------------------------------------------------------- volumes */

/* The conversions that were applied to a volume when it was read. */
typedef struct ost_volume_report {
    char type[24];             /* type of the file's elements: "int16", "float32", ... */
    char encoding[24];         /* "raw", "gzip", "text" */
    char orientation[16];      /* orientation in the file, e.g. "LPS", "RAS"; "" if it states none */
    bool reoriented;           /* axes were flipped or permuted to LPS+ */
    bool assumed;              /* the file states no orientation; LPS was assumed */
    bool resampled;            /* the grid was oblique and has been resampled, as requested */
    bool labels;               /* a label map: NIfTI intent 1002, or a NRRD with keys Segment0_... (3D Slicer) */
    uint64_t rounded_values;   /* number of non-integer densities, rounded RHE */
    uint64_t clamped_values;   /* number of densities beyond int16 that were saturated; an error unless allowed */
} ost_volume_report;

/*
 * Selects which of a NIfTI's two transforms places the grid. AUTO: by their codes; it is an error if they disagree by
 * more than a voxel.
 */
typedef enum ost_nifti_form { OST_FORM_AUTO, OST_FORM_QFORM, OST_FORM_SFORM } ost_nifti_form;

typedef struct ost_volume_options {
    bool clamp;             /* saturate densities beyond int16 instead of refusing */
    bool resample_oblique;  /* resample an oblique NIfTI or NRRD (nearest) instead of refusing */
    char orientation[4];    /* orientation of a file that states none, e.g. "RAS"; "": not given */
    ost_nifti_form form;
} ost_volume_options;

/* Reads NRRD or NIfTI as int16 with axes in LPS+. options may be NULL (all false), report may be NULL. */
OST_API ost_status ost_volume_read(const char *path, const ost_volume_options *options, ost_volume *out,
                                   ost_volume_report *report, ost_error *err);
/* Reads only the geometry, the meta and the report, without the voxels. Each may be NULL. */
OST_API ost_status ost_volume_read_header(const char *path, ost_geometry *geometry, ost_meta *meta,
                                          ost_volume_report *report, ost_error *err);

typedef struct ost_write_options {
    bool compress;        /* use gzip in .nrrd; .nii.gz always does */
    int text_decimals;    /* for .txt: 0 = as many as the positions need, else the number, up to 9 */
} ost_write_options;

/*
 * Writes a volume. The name selects the format: .nrrd, .nii, .nii.gz, .txt (thesis text: one line "x y z density" per
 * voxel). options may be NULL.
 */
OST_API ost_status ost_volume_write(const char *path, const ost_volume *volume, const ost_write_options *options,
                                    ost_error *err);

/* Reads a tool grid from uint8 NRRD. *out need not be initialised; the caller frees it by ost_tool_volume_free. */
OST_API ost_status ost_tool_volume_read(const char *path, ost_tool_volume *out, ost_error *err);
/* Writes a tool grid as uint8 NRRD. The file appears complete or not at all. */
OST_API ost_status ost_tool_volume_write(const char *path, const ost_tool_volume *tool, ost_error *err);

/* ---------------------------------------------------------------- meshes */

/* The unit of a mesh file's coordinates; AUTO is millimetres if the size is plausible. */
typedef enum ost_unit { OST_UNIT_AUTO, OST_UNIT_MM, OST_UNIT_CM, OST_UNIT_M, OST_UNIT_INCH, OST_UNIT_UM } ost_unit;

typedef struct ost_mesh_report {
    char format[24];           /* "STL (binary)", "OBJ", ... */
    size_t file_triangles;     /* number of faces before polygons were divided and lines and points omitted */
    size_t bodies;             /* number of parts in the file, which are joined here */
    double bounds_mm[6];       /* min x y z, max x y z */
} ost_mesh_report;

/*
 * The greatest number of triangles of a file that is read, and a third of the greatest number of
 * vertices.  assimp needs up to 230 bytes for a triangle of a text format, which is 2 GB for so
 * many.  Larger files are refused before that memory is allocated.
 */
enum { OST_MESH_FILE_TRIANGLES_MAX = 1 << 23 };

/*
 * Reads a mesh with assimp.  AUTO takes the file's numbers as millimetres and refuses
 * an implausible size (greatest extent less than 1 mm or more than 1 m) with a message
 * that names the plausible units; any other unit is used without that check.  NaN,
 * infinity, no triangles and indices out of range are errors.
 */
OST_API ost_status ost_mesh_read(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report,
                                 ost_error *err);
/* Writes binary STL without attributes; normals are computed from the vertices. */
OST_API ost_status ost_mesh_write_stl(const char *path, const ost_mesh *mesh, ost_error *err);

/* ----------------------------------------------------------------- paths */

/*
 * A path file is text `t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm]`, or with
 * x_m,y_m,z_m in metres; plain or gzip; decimals exact; t strictly increasing (AR-PATH-1 to 3).
 * A row with nan in its pose is not a tick, and the tick after it begins lifted.
 */
typedef struct ost_path_report {
    size_t rows, lost_rows;   /* number of all rows, and of those without a pose */
    size_t gaps;              /* number of ticks that begin lifted */
    int64_t begin_ns, end_ns; /* times of the first and the last row, with a pose or without */
} ost_path_report;

/* Reads a path. options and report may be NULL. */
OST_API ost_status ost_path_read(const char *path, const ost_path_options *options, ost_path *out,
                                 ost_path_report *report, ost_error *err);
/* Calls ost_path_read without options and report. */
OST_API ost_status ost_path_read_csv(const char *path, ost_path *out, ost_error *err);
/* Writes a path with the columns lifted and rpm, and tool if one is not 0. */
OST_API ost_status ost_path_write_csv(const char *path, const ost_path *in, ost_error *err);

/* ------------------------------------------------------------- landmarks */

typedef enum ost_landmark_role {
    OST_LANDMARK_OTHER,          /* a label without a role */
    OST_LANDMARK_GLENOID,        /* glenoid, glenoid centre (center), GC: the centre of the face */
    OST_LANDMARK_AXIS_POINT,     /* axis, axis point, glenoid axis: a point in the bone, straight in from the centre */
    OST_LANDMARK_TRIGONUM,       /* trigonum, trigonum spinae (scapulae), root of spine, spine root, TS */
    OST_LANDMARK_INFERIOR_ANGLE  /* inferior angle, angulus inferior, AI, IA */
} ost_landmark_role;

/* Returns the role of a label, without regard to case, blanks, '-' and '_'. */
OST_API ost_landmark_role ost_landmark_role_of(const char *label);

enum { OST_LANDMARK_LABEL = 64 };
typedef struct ost_landmark {
    char label[OST_LANDMARK_LABEL]; /* truncated if longer; control characters are '?' */
    ost_landmark_role role;
    ost_pm3 at;                     /* LPS */
} ost_landmark;

/* Landmarks in the order of their file. */
typedef struct ost_landmarks {
    int count;
    ost_landmark *items; /* owned */
} ost_landmarks;

/*
 * Reads landmarks from 3D Slicer's .mrk.json and .fcsv, in the coordinate system that
 * they state, or from a CSV label,x,y,z (LPS, mm).  Two positions with one role are an
 * error, as is a file without landmarks. *out is empty on failure.
 */
OST_API ost_status ost_landmarks_read(const char *path, ost_landmarks *out, ost_error *err);
/* Frees landmarks, which are then empty. */
OST_API void ost_landmarks_free(ost_landmarks *landmarks);

/*
 * Replaces the facts in a volume's file, completely or not at all, and does not change
 * its voxels: the osteon_ lines of a NRRD's header, or the comment of a NIfTI that
 * osteon has written.  Returns OST_ERR_INPUT for other files.
 */
OST_API ost_status ost_volume_write_meta(const char *path, const ost_meta *meta, ost_error *err);

/* ---------------------------------------------------------------- import */

enum { OST_MASK_LABELS_MAX = 128 };
/* Options of an import; zero for the defaults. */
typedef struct ost_import_options {
    ost_pm3 spacing;          /* 0 = inferred; for text, and to override a file's own */
    ost_pm cubic;             /* spacing of the cubic grid; 0 = the rect grid's x spacing */
    int32_t threshold;        /* 0 = the file's own if it is a bone, else 120 */
    int chunk_size;           /* 0 = 32 */
    bool has_resample;        /* false: linear, or nearest for a label map */
    ost_resample resample;    /* used if has_resample */
    ost_duplicates duplicates;
    ost_volume_options volume;
    bool crop;                /* import only voxels lo <= (i, j, k) < hi of the rect grid */
    ost_voxel_box crop_box;
    int threads;              /* number of threads that read text; 0 = all */
    bool digests;             /* compute the SHA-256 of every stage (costs a pass over each) */
    ost_progress *progress;   /* may be NULL */
    void *progress_user;
    const char *mask;         /* a label map on the CT's grid, NRRD or NIfTI; NULL: the complete CT (AR-SEG-6) */
    int16_t mask_labels[OST_MASK_LABELS_MAX]; /* the labels that are selected */
    int mask_label_count;     /* 0: all labels but 0 */
    bool mask_fill;           /* selected voxels below the threshold get its density */
} ost_import_options;

/* The effect of a mask, in voxels of the CT. */
typedef struct ost_mask_report {
    uint64_t selected;        /* number of voxels whose label is selected */
    uint64_t removed;         /* number of other voxels of the threshold or more, which became 0 */
    uint64_t filled;          /* number of selected voxels that got the threshold's density */
} ost_mask_report;

enum { OST_STAGES_MAX = 8 };
/* The time and, on request, the digest of a stage of an import. */
typedef struct ost_stage {
    char name[16];       /* "samples" (text only), "rect", "cubic", "chunks" */
    double time_ms;
    bool has_digest;
    ost_digest digest;
} ost_stage;

/* The results of an import: geometries, facts, counts and stages. */
typedef struct ost_import_result {
    ost_file_kind kind;
    ost_geometry rect;
    ost_geometry cubic;
    ost_meta meta;                 /* copied from the file; kind, threshold and resample are set */
    ost_resample resample;         /* the rule that was used */
    ost_volume_report volume;      /* for NRRD and NIfTI */
    ost_scatter_report scatter;    /* for text */
    bool spacing_inferred[3];
    uint64_t rounded_positions;    /* coordinates with more than nine decimals */
    int stage_count;
    ost_stage stages[OST_STAGES_MAX];
    ost_mask_report mask;          /* 0 without a mask */
} ost_import_result;

/*
 * Imports a CT, or a bone that was written by import, as a bone on the backend. options and result may be NULL. The
 * caller owns *out.
 */
OST_API ost_status ost_import(ost_backend *backend, const char *path, const ost_import_options *options, ost_bone **out,
                              ost_import_result *result, ost_error *err);

/*
 * Writes a bone's cubic grid as int16 NRRD, or by the name as .nii, .nii.gz or .txt, with meta and the facts kind =
 * bone, threshold and arithmetic. meta and options may be NULL.
 */
OST_API ost_status ost_bone_write(const char *path, const ost_bone *bone, const ost_meta *meta,
                                  const ost_write_options *options, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
