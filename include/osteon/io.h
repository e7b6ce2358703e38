/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files in and out.
 *
 * Input is hostile: every reader gives one line that names the file, the line
 * or offset, the value, and what was expected; memory stays bounded by the
 * grid that results, never by the size of the file.
 * Output appears under its name only when it is whole: it is written beside
 * its place under another name, synced, and renamed.
 *
 * The kind of file is found by its content where it has a signature, else by
 * its name.  Text is read in the C locale, whatever the program's.
 */
#ifndef OSTEON_IO_H
#define OSTEON_IO_H

#include <osteon/backend.h>
#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Called now and then with the share done in [0, 1]; returning false cancels (OST_ERR_CANCELLED). */
typedef bool ost_progress(void *user, const char *stage, double share);

typedef enum ost_file_kind {
    OST_FILE_UNKNOWN,
    OST_FILE_CT_TEXT,
    OST_FILE_NRRD,
    OST_FILE_NIFTI,
    OST_FILE_MESH,
    OST_FILE_PATH_CSV,
    OST_FILE_SESSION /* session.h */
} ost_file_kind;

OST_API ost_status ost_file_kind_find(const char *path, ost_file_kind *out, ost_error *err);

/* --------------------------------------------------------------- volumes */

/* What was done to a volume on its way in, for people and records. */
typedef struct ost_volume_report {
    char type[24];             /* of the file's elements: "int16", "float32", ... */
    char encoding[24];         /* "raw", "gzip", "text" */
    char orientation[16];      /* as the file had it, e.g. "LPS", "RAS"; "" when it said nothing */
    bool reoriented;           /* axes flipped or permuted to LPS+ */
    bool assumed;              /* the file does not state where its axes point: they were taken as LPS */
    bool resampled;            /* an oblique grid, resampled because it was asked for */
    bool labels;               /* a label map: NIfTI intent 1002, or a NRRD with keys Segment0_... (3D Slicer) */
    uint64_t rounded_values;   /* non-integer densities rounded RHE */
    uint64_t clamped_values;   /* densities beyond int16: saturated only when allowed, else an error */
} ost_volume_report;

/* Which of a NIfTI's two transforms places the grid. AUTO: by their codes; an error where they disagree by more than a voxel. */
typedef enum ost_nifti_form { OST_FORM_AUTO, OST_FORM_QFORM, OST_FORM_SFORM } ost_nifti_form;

typedef struct ost_volume_options {
    bool clamp;             /* saturate densities beyond int16 instead of refusing */
    bool resample_oblique;  /* resample an oblique NIfTI or NRRD (nearest) instead of refusing */
    char orientation[4];    /* where the axes of a file without orientation point, e.g. "RAS"; "": not stated */
    ost_nifti_form form;
} ost_volume_options;

/* NRRD or NIfTI, to int16 with axes to LPS+. options may be NULL (all false), report may be NULL. */
OST_API ost_status ost_volume_read(const char *path, const ost_volume_options *options, ost_volume *out, ost_volume_report *report,
                                   ost_error *err);
/* The geometry, the meta and the report alone, without the voxels. Each may be NULL. */
OST_API ost_status ost_volume_read_header(const char *path, ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                                          ost_error *err);

typedef struct ost_write_options {
    bool compress;        /* gzip for .nrrd; .nii.gz always is */
    int text_decimals;    /* for .txt: 0 = as many as the positions need, else this many (up to 9) */
} ost_write_options;

/* By the name: .nrrd, .nii, .nii.gz, .txt (thesis text: every voxel a line "x y z density"). options may be NULL. */
OST_API ost_status ost_volume_write(const char *path, const ost_volume *volume, const ost_write_options *options, ost_error *err);

OST_API ost_status ost_tool_volume_read(const char *path, ost_tool_volume *out, ost_error *err);
OST_API ost_status ost_tool_volume_write(const char *path, const ost_tool_volume *tool, ost_error *err); /* .nrrd */

/* ---------------------------------------------------------------- meshes */

typedef enum ost_unit { OST_UNIT_AUTO, OST_UNIT_MM, OST_UNIT_CM, OST_UNIT_M, OST_UNIT_INCH, OST_UNIT_UM } ost_unit;

typedef struct ost_mesh_report {
    char format[24];           /* "STL (binary)", "OBJ", ... */
    size_t file_triangles;     /* before polygons were split and non-triangles dropped */
    size_t bodies;             /* parts in the file, joined here */
    double bounds_mm[6];       /* min x y z, max x y z */
} ost_mesh_report;

/*
 * The most triangles that are read of a file, and a third of the most vertices.  assimp needs up
 * to 230 bytes for a triangle of a text format: 2 GB with so many.  Larger files are refused
 * before that memory is allocated.
 */
enum { OST_MESH_FILE_TRIANGLES_MAX = 1 << 23 };

/*
 * By assimp.  AUTO takes the file's numbers as millimetres and refuses an
 * implausible size (largest extent under 1 mm or over 1 m), naming the units
 * that would make sense; a unit given is believed.  NaN, infinity, no
 * triangles, indices out of range are errors.
 */
OST_API ost_status ost_mesh_read(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report, ost_error *err);
/* Binary STL with a plain header; normals from the vertices. */
OST_API ost_status ost_mesh_write_stl(const char *path, const ost_mesh *mesh, ost_error *err);

/* ----------------------------------------------------------------- paths */

/*
 * Text `t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm]`, or with x_m,y_m,z_m in
 * metres; plain or gzip; decimals exact; t strictly increasing (AR-PATH-1 to 3).
 * A row with nan in its pose is no tick, and the tick after it begins lifted.
 */
typedef struct ost_path_report {
    size_t rows, lost_rows;   /* all, and those without a pose */
    size_t gaps;              /* ticks that begin lifted */
    int64_t begin_ns, end_ns; /* of the first and the last row, with a pose or without */
} ost_path_report;

/* options and report may be NULL. */
OST_API ost_status ost_path_read(const char *path, const ost_path_options *options, ost_path *out, ost_path_report *report, ost_error *err);
/* ost_path_read with neither. */
OST_API ost_status ost_path_read_csv(const char *path, ost_path *out, ost_error *err);
/* With columns tool, where one is not 0, lifted and rpm. */
OST_API ost_status ost_path_write_csv(const char *path, const ost_path *in, ost_error *err);

/* ------------------------------------------------------------- landmarks */

typedef enum ost_landmark_role {
    OST_LANDMARK_OTHER,          /* a label without a meaning here */
    OST_LANDMARK_GLENOID,        /* glenoid, glenoid centre (center), GC: the centre of the face */
    OST_LANDMARK_AXIS_POINT,     /* axis, axis point, glenoid axis: a point in the bone, straight in from there */
    OST_LANDMARK_TRIGONUM,       /* trigonum, trigonum spinae (scapulae), root of spine, spine root, TS */
    OST_LANDMARK_INFERIOR_ANGLE  /* inferior angle, angulus inferior, AI, IA */
} ost_landmark_role;

/* The meaning of a label; case, blanks, '-' and '_' do not matter. */
OST_API ost_landmark_role ost_landmark_role_of(const char *label);

enum { OST_LANDMARK_LABEL = 64 };
typedef struct ost_landmark {
    char label[OST_LANDMARK_LABEL]; /* cut there; control characters as '?' */
    ost_landmark_role role;
    ost_pm3 at;                     /* LPS */
} ost_landmark;

typedef struct ost_landmarks {
    int count;
    ost_landmark *items; /* owned */
} ost_landmarks;

/*
 * Reads 3D Slicer's .mrk.json and .fcsv, in the coordinate system that they
 * state, or a CSV label,x,y,z (LPS, mm).  Two positions of one role are an
 * error, as is a file without landmarks. *out is empty on failure.
 */
OST_API ost_status ost_landmarks_read(const char *path, ost_landmarks *out, ost_error *err);
OST_API void ost_landmarks_free(ost_landmarks *landmarks);

/*
 * Replaces the facts of a volume's file by these, whole or not at all, and
 * leaves its voxels: in a NRRD the osteon_ lines of the header, in a NIfTI that
 * was written here its comment.  OST_ERR_INPUT for other files.
 */
OST_API ost_status ost_volume_write_meta(const char *path, const ost_meta *meta, ost_error *err);

/* ---------------------------------------------------------------- import */

typedef struct ost_import_options {
    ost_pm3 spacing;          /* 0 = found; for text and to override a file's own */
    ost_pm cubic;             /* 0 = the rect grid's x spacing */
    int32_t threshold;        /* 0 = the file's own when it is a bone, else 120 */
    int chunk_size;           /* 0 = 32 */
    bool has_resample;        /* false: linear, for a label map nearest */
    ost_resample resample;    /* if has_resample */
    ost_duplicates duplicates;
    ost_volume_options volume;
    bool crop;                /* keep only voxels lo <= (i, j, k) < hi of the rect grid */
    ost_voxel_box crop_box;
    int threads;              /* for reading text; 0 = all */
    bool digests;             /* SHA-256 of every stage (costs a pass over each) */
    ost_progress *progress;   /* may be NULL */
    void *progress_user;
} ost_import_options;

enum { OST_STAGES_MAX = 8 };
typedef struct ost_stage {
    char name[16];       /* "samples" (text only), "rect", "cubic", "chunks" */
    double time_ms;
    bool has_digest;
    ost_digest digest;
} ost_stage;

typedef struct ost_import_result {
    ost_file_kind kind;
    ost_geometry rect;
    ost_geometry cubic;
    ost_meta meta;                 /* carried over from the file; kind, threshold and resample set */
    ost_resample resample;         /* the rule that was used */
    ost_volume_report volume;      /* for NRRD and NIfTI */
    ost_scatter_report scatter;    /* for text */
    bool spacing_inferred[3];
    uint64_t rounded_positions;    /* decimals with more than nine places */
    int stage_count;
    ost_stage stages[OST_STAGES_MAX];
} ost_import_result;

/* Any CT (or a bone that import wrote) to a bone on the backend. options may be NULL. */
OST_API ost_status ost_import(ost_backend *backend, const char *path, const ost_import_options *options, ost_bone **out,
                              ost_import_result *result, ost_error *err);

/* A bone as int16 NRRD (or by name .nii, .nii.gz, .txt): the cubic grid, meta, kind = bone, threshold, arithmetic. */
OST_API ost_status ost_bone_write(const char *path, const ost_bone *bone, const ost_meta *meta, const ost_write_options *options,
                                  ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
