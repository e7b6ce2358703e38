/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes files.
 *
 * Input files may be malicious. Every reader reports an error in one line that contains the file, the line or
 * offset, the value, and the expected value. Memory is bounded by the size of the resulting grid, not by the size
 * of the file. An output file appears under its name only when it is complete. Until then, it is an unnamed or
 * temporary file in the same folder; it gets its name after it has been synced.
 *
 * The signature in a file's content or, without a signature, the file's name determines the kind of the file. Text is
 * read in the C locale, regardless of the program's locale.
 *
 * Read errors: a function that reads a file returns OST_ERR_IO if the system cannot open or read the file,
 * OST_ERR_INPUT if the content is wrong, OST_ERR_RANGE if the content is larger than supported, and OST_ERR_UNAVAILABLE
 * if a library or program that this format requires is missing.
 *
 * Write errors: a function that writes a file returns OST_ERR_USAGE if the file name is empty, OST_ERR_IO if the system
 * cannot create, write or rename the file, and OST_ERR_UNAVAILABLE if a library that this format requires is missing.
 *
 * All functions also return OST_ERR_MEMORY if memory is exhausted. The comments of the functions name all other errors.
 *
 * Threads: the functions share no state. Several threads may read and write files at the same time, and may read the
 * same file. Meshes are parsed one after the other, because assimp shares the message of its last error among all
 * threads. An object may be used by one thread at a time, or read by several. A backend and its bones may be used by
 * one thread at a time (backend.h), so two threads that import at the same time need two backends. Some functions
 * create threads of their own, but all callbacks are called on the calling thread.
 */
#ifndef OSTEON_IO_H
#define OSTEON_IO_H

#include <osteon/backend.h>
#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The kind of a file's content. */
typedef enum ost_file_kind {
    OST_FILE_UNKNOWN,
    OST_FILE_CT_TEXT,
    OST_FILE_NRRD,
    OST_FILE_NIFTI,
    OST_FILE_MESH,
    OST_FILE_PATH_CSV,
    OST_FILE_SESSION, /* a recorded operation; see session.h */
    OST_FILE_METAIMAGE,
    OST_FILE_DICOM, /* a DICOM file, or any folder that is not a stack */
    OST_FILE_STACK  /* slices as TIFF or PNG: a folder, a pattern with '*', or one file */
} ost_file_kind;

/*
 * Determines the kind of a file by the signature in its content or, without a signature, by its name. A folder is a
 * stack if all its regular files are TIFF or PNG; any other folder has the kind OST_FILE_DICOM, and its files are not
 * examined further. Returns OST_ERR_INPUT for a format that osteon does not read, for example a compressed file; the
 * message names a program that converts the file. The other errors are read errors.
 */
OST_API ost_status ost_file_kind_find(const char *path, ost_file_kind *out, ost_error *err);

/* --------------------------------------------------------------- volumes */

/* The properties of a DICOM series that was read. docs/reference/dicom.md describes how the files, images and pixels
 * that are counted here are treated. */
typedef struct ost_dicom_report {
    int64_t images;         /* number of slices that were read; 0 if the volume is not DICOM */
    int64_t other_files;    /* number of files without a DICOM image, which were ignored */
    int64_t localizers;     /* number of localizer images of the series, which were ignored */
    int64_t doubled;        /* number of images with the same position and pixels as another image */
    int64_t interpolated;   /* number of interpolated slices; interpolation is an option */
    ost_pm largest_gap;     /* maximum distance between neighbouring slices */
    ost_pm thickness;       /* SliceThickness; 0 if it is not stated or differs between the images */
    ost_pm sheared;         /* distance by which slices were shifted to remove a tilt; shifting is an option */
    uint64_t padded;        /* number of pixels that had a padding value and were set to air */
    bool lossy;             /* true if the pixels were compressed with loss */
    bool no_rescale;        /* true if the files contain no rescale slope and intercept */
    char modality[17];      /* "CT" */
} ost_dicom_report;

/* The conversions that were applied to a volume when it was read. */
typedef struct ost_volume_report {
    char type[24];             /* type of the file's elements: "int16", "float32", ... */
    char encoding[24];         /* "raw", "gzip", "zlib" or "text" */
    char orientation[16];      /* orientation stored in the file, e.g. "LPS" or "RAS"; "" if it contains none */
    bool reoriented;           /* true if axes were flipped or permuted to LPS+ */
    bool assumed;              /* true if LPS was assumed, because the file contains no orientation */
    bool resampled;            /* true if the grid was oblique and was resampled; resampling is an option */
    /* True for a label map. A label map is a NIfTI file with intent 1002, or an NRRD file with keys Segment0_... (3D
     * Slicer). */
    bool labels;
    uint64_t rounded_values;   /* number of densities that were not integers and were rounded half to even */
    uint64_t clamped_values;   /* number of densities outside int16, which were saturated */
    ost_dicom_report dicom;
    uint64_t nan_values;       /* number of NaN values, which were replaced by -1024; the replacement is an option */
    /* pixel size given in the first slice of a stack, for information only; 0 if the slice contains none */
    double pixel_mm[2];
} ost_volume_report;

/*
 * The transform of a NIfTI file (sform or qform) that determines the grid's position. AUTO selects a transform
 * according to the codes in the file. With AUTO, it is an error if the two transforms differ by more than a voxel.
 */
typedef enum ost_nifti_form { OST_FORM_AUTO, OST_FORM_QFORM, OST_FORM_SFORM } ost_nifti_form;

typedef struct ost_volume_options {
    /* True to saturate densities outside the range of int16, which are otherwise an error. */
    bool clamp;
    bool resample_oblique;  /* true to resample an oblique grid (nearest), which is otherwise an error */
    char orientation[4];    /* orientation to assume for a file that contains none, e.g. "RAS"; "" for LPS */
    ost_nifti_form form;
    const char *series;     /* for DICOM: number, description or UID of the series; NULL selects the only volume */
    bool even_slices; /* for DICOM: true to resample unevenly spaced slices (linear), which are otherwise an error */
    bool untilt;            /* for DICOM: true to shear tilted slices back (linear), which are otherwise an error */
    bool nan_as_air;        /* true to convert NaN to -1024 HU, the density of air; NaN is otherwise an error */
    ost_pm3 stack_spacing;  /* for a stack: spacing of columns, rows and slices, which
                             * is not read from the files */
    ost_progress *progress; /* called with the stage "reading"; may be NULL */
    void *progress_user;
} ost_volume_options;

/*
 * Reads an NRRD, NIfTI or MetaImage file, a multi-frame DICOM file, a DICOM series in a folder, or a stack, as
 * int16 with axes in LPS+. options may be NULL, which means that all options are false; report may be NULL. A stack
 * requires options->stack_spacing. The caller frees *out with ost_volume_free; *out need not be initialised.
 *
 * Returns OST_ERR_USAGE if an option does not apply to the format of the file or contradicts its header, or if
 * options->stack_spacing is missing, and OST_ERR_CANCELLED if the progress function returns false. The other errors are
 * read errors. After an error, *out has no voxels.
 *
 * DICOM is parsed by separate processes, which have ended when the function returns. Meanwhile, the program must not
 * ignore SIGCHLD or wait for any child process (waitpid with -1).
 */
OST_API ost_status ost_volume_read(const char *path, const ost_volume_options *options, ost_volume *out,
                                   ost_volume_report *report, ost_error *err);
/* Reads geometry, meta and report, but not the voxels. Each of the three pointers may be NULL. The errors are those of
 * ost_volume_read without options. */
OST_API ost_status ost_volume_read_header(const char *path, ost_geometry *geometry, ost_meta *meta,
                                          ost_volume_report *report, ost_error *err);

/* A series in a folder of DICOM files. All strings are printable. A string is "" if the files do not contain it. */
typedef struct ost_dicom_series {
    bool numbered;            /* true if number is valid */
    int32_t number;           /* SeriesNumber */
    char description[65];     /* SeriesDescription, which may contain names */
    char uid[65];             /* SeriesInstanceUID */
    char modality[17], kernel[65];
    int64_t images;           /* number of images that can be slices, that is, neither localizers nor colour images */
    int64_t localizers;       /* number of localizer images */
    /* True if ost_volume_read can read the series with the options that were passed to ost_dicom_list_read. */
    bool is_volume;
    ost_geometry geometry;    /* valid if `is_volume` is true */
    char orientation[4];      /* directions of the axes, e.g. "LPS"; valid if `is_volume` is true */
    ost_pm thickness;         /* SliceThickness; 0 if it is not stated or differs between the images */
    /*
     * The error that prevents reading the series. "" if there is no such error or if the series has fewer than two
     * images.
     */
    char fault[OST_ERROR_TEXT];
} ost_dicom_series;

/* The series of a folder, in the order of their first files. */
typedef struct ost_dicom_list {
    size_t count;
    ost_dicom_series *items; /* owned */
    /* Index of the series that ost_volume_read reads with the same options; -1 if there is none. */
    int64_t selected;
    int64_t files, other_files; /* number of all files, and number of files without a DICOM image */
} ost_dicom_list;

/*
 * Lists the series of a folder of DICOM files, or of one DICOM file, without reading pixels. options may be
 * NULL. Returns read errors only; *out is then empty. An error that prevents reading a series is stored in `fault`. The
 * caller frees *out with ost_dicom_list_free. The rule about child processes is that of ost_volume_read.
 */
OST_API ost_status ost_dicom_list_read(const char *path, const ost_volume_options *options, ost_dicom_list *out,
                                       ost_error *err);
/* Frees a list, which is then empty. */
OST_API void ost_dicom_list_free(ost_dicom_list *list);

typedef struct ost_write_options {
    bool compress;        /* true to compress .nrrd with gzip; .nii.gz is always compressed */
    int text_decimals;    /* number of decimals in .txt, up to 9; 0 selects the smallest number that represents all
                           * positions exactly */
    /* for .txt: true to omit voxels of density 0; the grid read from the file is then the bounding box of the remaining
     * voxels */
    bool omit_empty;
    ost_progress *progress; /* called with the stage "writing"; may be NULL; not used for .txt */
    void *progress_user;
} ost_write_options;

/*
 * Writes a volume. The file name selects the format: .nrrd, .nii, .nii.gz, .mha or .txt (the text format of the
 * thesis, with one line "x y z density" per voxel). If the kind of the volume is "labels", the file is a label map that
 * 3D Slicer opens as a segmentation: an NRRD file has a group of fields for each label, and a NIfTI file has the intent
 * 1002. options may be NULL.
 *
 * Returns OST_ERR_USAGE if the file name has a different ending, if the volume has no voxels, or if
 * options->text_decimals is out of range or too small for the positions. Returns OST_ERR_RANGE if the geometry is
 * outside the ranges of AR-GRID, OST_ERR_INPUT if options->omit_empty leaves no voxel, and OST_ERR_CANCELLED if the
 * progress function returns false. The other errors are write errors.
 */
OST_API ost_status ost_volume_write(const char *path, const ost_volume *volume, const ost_write_options *options,
                                    ost_error *err);

/*
 * Reads a tool grid from a uint8 NRRD file. *out need not be initialised. Returns OST_ERR_INPUT if the elements are not
 * uint8, the voxels are not cubes, or a voxel is not 0, 1 or 2. The other errors are read errors. After an error, *out
 * has no voxels. The caller frees *out with ost_tool_volume_free.
 */
OST_API ost_status ost_tool_volume_read(const char *path, ost_tool_volume *out, ost_error *err);
/* Writes a tool grid as a uint8 NRRD file. The file appears only when it is complete. Returns OST_ERR_USAGE if the file
 * name does not end in .nrrd or the tool has no voxels, and OST_ERR_RANGE if tool->meta has no room for the facts kind,
 * arithmetic and tool_corner. The other errors are write errors. */
OST_API ost_status ost_tool_volume_write(const char *path, const ost_tool_volume *tool, ost_error *err);

/* ---------------------------------------------------------------- meshes */

/* The unit of the coordinates in a mesh file. AUTO means millimetres, and the size is checked for plausibility. */
typedef enum ost_unit { OST_UNIT_AUTO, OST_UNIT_MM, OST_UNIT_CM, OST_UNIT_M, OST_UNIT_INCH, OST_UNIT_UM } ost_unit;

typedef struct ost_mesh_report {
    char format[24];           /* "STL (binary)", "OBJ", ... */
    /* Number of faces in the file, before polygons are divided into triangles, and before lines and points are
     * omitted. */
    size_t file_triangles;
    size_t bodies;             /* number of separate meshes in the file, which are joined into one mesh */
    double bounds_mm[6];       /* minimum x, y, z and maximum x, y, z */
} ost_mesh_report;

/*
 * Maximum number of triangles in a mesh file. The maximum number of vertices is three times as large. For a text
 * format, assimp needs up to 230 bytes per triangle, which is 2 GB for a file at the limit. Larger files are rejected
 * before this memory is allocated.
 */
enum { OST_MESH_FILE_TRIANGLES_MAX = 1 << 23 };

/*
 * Reads a mesh with assimp. AUTO interprets the numbers in the file as millimetres. With AUTO, a maximum extent of less
 * than 1 mm or more than 1 m is an error, and the message lists the plausible units. With any other unit, the size is
 * not checked. NaN, infinity, coordinates beyond 8 m, a mesh without triangles and indices out of range are errors. All
 * these errors are OST_ERR_INPUT. Returns OST_ERR_RANGE if the mesh has more than OST_MESH_FILE_TRIANGLES_MAX
 * triangles, and OST_ERR_USAGE for an unknown unit. The other errors are read errors. report may be NULL. After an
 * error, *out is empty. The caller frees *out with ost_mesh_free.
 */
OST_API ost_status ost_mesh_read(const char *path, ost_unit unit, ost_mesh *out, ost_mesh_report *report,
                                 ost_error *err);
/*
 * Writes a binary STL file without attributes; normals are computed from the vertices. Returns OST_ERR_RANGE if the
 * mesh has more than OST_MESH_TRIANGLES_MAX triangles, and OST_ERR_USAGE if a vertex index is out of range. The other
 * errors are write errors.
 */
OST_API ost_status ost_mesh_write_stl(const char *path, const ost_mesh *mesh, ost_error *err);

/* ----------------------------------------------------------------- paths */

/*
 * The report of ost_path_read. A path file is CSV text, plain or gzip, with the columns
 * `t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm]`, or with x_m,y_m,z_m in metres. Decimals are read exactly, and
 * t strictly increases (AR-PATH-1 to 3). A row with nan in its pose is not a tick; the next tick is lifted (path.h).
 */
typedef struct ost_path_report {
    size_t rows, lost_rows;   /* number of all rows, and number of rows without a pose */
    size_t gaps;              /* number of lifted ticks */
    int64_t begin_ns, end_ns; /* times of the first and the last row, with or without a pose */
} ost_path_report;

/* Reads a path. options and report may be NULL. Returns read errors only, for example OST_ERR_RANGE for a path with too
 * many rows. After an error, *out is empty. The caller frees *out with ost_path_free. */
OST_API ost_status ost_path_read(const char *path, const ost_path_options *options, ost_path *out,
                                 ost_path_report *report, ost_error *err);
/* Reads a path as ost_path_read does if options and report are NULL. The errors are the same. The caller frees *out
 * with ost_path_free. */
OST_API ost_status ost_path_read_csv(const char *path, ost_path *out, ost_error *err);
/* Writes a path with the columns `lifted` and `rpm`. If any tool index is not 0, the column `tool` is also written.
 * Returns write errors only. */
OST_API ost_status ost_path_write_csv(const char *path, const ost_path *in, ost_error *err);

/* ------------------------------------------------------------- landmarks */

typedef enum ost_landmark_role {
    OST_LANDMARK_OTHER,          /* a landmark whose label has no role */
    OST_LANDMARK_GLENOID,        /* centre of the glenoid's face; labels: glenoid, glenoid centre (center), GC */
    OST_LANDMARK_AXIS_POINT,     /* point in the bone on the glenoid's axis; labels: axis, axis point, glenoid axis */
    OST_LANDMARK_TRIGONUM,       /* labels: trigonum, trigonum spinae (scapulae), root of spine, spine root, TS */
    OST_LANDMARK_INFERIOR_ANGLE  /* labels: inferior angle, angulus inferior, AI, IA */
} ost_landmark_role;

/* Returns the role of a label. Case, blanks, '-' and '_' are ignored. */
OST_API ost_landmark_role ost_landmark_role_of(const char *label);

enum { OST_LANDMARK_LABEL = 64 };
typedef struct ost_landmark {
    char label[OST_LANDMARK_LABEL]; /* label, truncated if longer; control characters are replaced by '?' */
    ost_landmark_role role;
    ost_pm3 at;                     /* position in LPS */
} ost_landmark;

/* Landmarks in the order of their file. */
typedef struct ost_landmarks {
    int count;
    ost_landmark *items; /* owned */
} ost_landmarks;

/*
 * Reads landmarks from .mrk.json and .fcsv files of 3D Slicer, in the coordinate system stated in the file, or from
 * a CSV file with lines label,x,y,z (LPS, mm). Returns OST_ERR_INPUT if the file contains no landmarks, or two
 * positions for one role. The other errors are read errors. After an error, *out is empty. The caller frees *out with
 * ost_landmarks_free.
 */
OST_API ost_status ost_landmarks_read(const char *path, ost_landmarks *out, ost_error *err);
/*
 * Writes landmarks as a .mrk.json file of 3D Slicer, in LPS. ost_landmarks_read reads exactly the same positions from
 * this file. Returns OST_ERR_INPUT if a label is not UTF-8 or if memory for the text is exhausted. The other errors are
 * write errors.
 */
OST_API ost_status ost_landmarks_write(const char *path, const ost_landmarks *landmarks, ost_error *err);
/* Frees landmarks, which are then empty. */
OST_API void ost_landmarks_free(ost_landmarks *landmarks);

/*
 * Replaces the header facts in the file of a volume. In an NRRD file, the facts are the osteon_ lines of the header; in
 * a NIfTI file written by osteon, they are in a comment. Returns OST_ERR_INPUT for all other files. The other errors
 * are read errors and write errors. The voxels do not change. After an error, the file is unchanged.
 */
OST_API ost_status ost_volume_write_meta(const char *path, const ost_meta *meta, ost_error *err);

/* ---------------------------------------------------------------- import */

enum { OST_MASK_LABELS_MAX = 128 };
/*
 * Makes a label map of a CT, for example with ost_segment_volume. `threshold` is the threshold of the import.
 * Initialises *labels with the CT's grid; ost_import frees *labels. The facts in labels->meta are added to the facts of
 * the bone.
 */
typedef ost_status ost_import_labels(void *user, const ost_volume *ct, int32_t threshold, ost_volume *labels,
                                     ost_error *err);
/* Options of an import. A zero-initialised struct selects the defaults. */
typedef struct ost_import_options {
    /* Spacing that replaces the spacing in the file. If 0, the spacing is read from the file or, for text,
     * inferred. For a stack, volume.stack_spacing is used instead. */
    ost_pm3 spacing;
    ost_pm cubic;             /* spacing of the cubic grid; 0 selects the x spacing of the rect grid */
    /* Threshold. 0 selects the threshold stored in the file if the file is a bone, and otherwise 120. */
    int32_t threshold;
    int chunk_size;           /* side length of a chunk in voxels; 0 selects 32 */
    /* True if `resample` selects the resampling rule. Otherwise, the rule is linear or, for a label map, nearest. */
    bool has_resample;
    ost_resample resample;    /* resampling rule; used only if has_resample is true */
    ost_duplicates duplicates;
    ost_volume_options volume;
    bool crop;                /* true to import only the voxels of the rect grid within crop_box */
    ost_voxel_box crop_box;
    int threads;              /* number of threads that read text; 0 selects one for each processor */
    /* True to compute the SHA-256 of every stage's grid, which takes one pass over each grid. */
    bool digests;
    ost_progress *progress;   /* may be NULL */
    void *progress_user;
    /* File name of a label map on the CT's grid (AR-SEG-6). If NULL, the complete CT is imported. */
    const char *mask;
    int16_t mask_labels[OST_MASK_LABELS_MAX]; /* the labels that are selected */
    /*
     * Names of further selected labels. Their values are read from the file mask_names_file. If mask_names_file is
     * NULL, they are read from the header of the label map (NRRD of 3D Slicer, NIfTI of TotalSegmentator).
     */
    const char *mask_names[OST_MASK_LABELS_MAX];
    int mask_name_count;
    const char *mask_names_file;
    /* number of elements of mask_labels; if it is 0 and no names are given, all labels except 0 are selected */
    int mask_label_count;
    bool mask_fill;           /* true to set selected voxels below the threshold to the threshold */
    /*
     * Function that is called after the mask was applied, or NULL. The bone consists of the voxels to which the
     * function assigns a label. The label map is applied like a mask of which all labels are selected, with mask_fill
     * set. Not supported for CTs given as text.
     */
    ost_import_labels *labels;
    void *labels_user;
} ost_import_options;

/* The effect of a mask, in numbers of CT voxels. */
typedef struct ost_mask_report {
    uint64_t selected;        /* number of voxels whose label is selected */
    uint64_t removed;         /* number of voxels at or above the threshold that are not selected and were set to 0 */
    uint64_t filled;          /* number of selected voxels whose density was set to the threshold */
} ost_mask_report;

enum { OST_STAGES_MAX = 8 };
/* A stage of an import: its duration and, if requested, its digest. */
typedef struct ost_stage {
    char name[16];       /* one of "samples" (text only), "rect", "cubic" and "chunks" */
    double time_ms;
    bool has_digest;
    ost_digest digest;
} ost_stage;

/* The results of an import: geometries, header facts, counts and stages. */
typedef struct ost_import_result {
    ost_file_kind kind;
    ost_geometry rect;
    ost_geometry cubic;
    /* Header facts copied from the file. The import itself sets the facts `kind`, `threshold` and `resample`. */
    ost_meta meta;
    ost_resample resample;         /* the resampling rule that was used */
    ost_volume_report volume;      /* set for NRRD, NIfTI, MetaImage, DICOM and stacks */
    ost_scatter_report scatter;    /* set for CTs given as text */
    bool spacing_inferred[3];
    uint64_t rounded_positions;    /* number of coordinates with more than nine decimals */
    int stage_count;
    ost_stage stages[OST_STAGES_MAX];
    ost_mask_report mask;          /* zero if there is no mask */
    ost_mask_report labels;        /* zero if the function `labels` is NULL */
} ost_import_result;

/*
 * Imports a CT, or a bone written by ost_bone_write, as a bone of the backend. options and result may be NULL. The
 * caller frees *out with ost_bone_free.
 *
 * Returns OST_ERR_USAGE if backend or path is NULL, if an option does not apply to the format of the file, if the rule
 * for resampling or the size of a chunk is unknown, or if the function `labels` makes no label map on the grid of the
 * CT. Returns OST_ERR_RANGE if another option is out of range, OST_ERR_INPUT if the mask does not fit the CT or selects
 * no voxel, and OST_ERR_CANCELLED if a progress function returns false. Returns the error of the function `labels`. The
 * other errors are read errors of the CT, of the mask and of mask_names_file, and backend errors (backend.h). The rule
 * about child processes is that of ost_volume_read.
 */
OST_API ost_status ost_import(ost_backend *backend, const char *path, const ost_import_options *options, ost_bone **out,
                              ost_import_result *result, ost_error *err);

/*
 * Writes the cubic grid of a bone as int16. The header contains meta and the facts kind = bone, threshold and
 * arithmetic. The file name selects the format: .nrrd, .nii, .nii.gz, .mha or .txt. meta and options may be NULL.
 * Returns OST_ERR_RANGE if meta has no room for the three facts. The other errors are those of ost_volume_write, and
 * backend errors (backend.h).
 */
OST_API ost_status ost_bone_write(const char *path, const ost_bone *bone, const ost_meta *meta,
                                  const ost_write_options *options, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
