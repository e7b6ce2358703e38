/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the differences between two grids, from the verdict down to single voxels.
 *
 *   verdict   equal or not
 *   geometry  dims, spacing, origin
 *   chunks    which chunks differ, and in how many voxels
 *   kinds     each voxel that differs is removed, added, changed, or below the threshold in both grids
 *   patterns  the shape of all differences together (pattern.c)
 *   voxels    the first voxels that differ, with both values
 *
 * A voxel is solid if its density is at least the threshold. A voxel of a tool is solid if it is not empty.
 */
#ifndef OST_APP_DIFF_COMPARE_H
#define OST_APP_DIFF_COMPARE_H

#include "app/input/load.h"
#include "difference/pattern.h"

typedef enum diff_kind {
    DIFF_REMOVED, /* solid in A only */
    DIFF_ADDED,   /* solid in B only */
    DIFF_CHANGED, /* solid in both grids, with different densities */
    DIFF_BELOW,   /* solid in neither grid, with different densities */
    DIFF_KIND_COUNT
} diff_kind;

typedef struct diff_voxel {
    int32_t at[3];
    int16_t a, b;
} diff_voxel;

typedef struct diff_chunk {
    int32_t at[3];
    int64_t count[DIFF_KIND_COUNT], different;
    int64_t solid_a, solid_b;
    diff_voxel first;
} diff_chunk;

typedef struct diff_pattern {
    const char *name;
    char text[200];
} diff_pattern;

enum { DIFF_PATTERN_MAX = PATTERNS + 3 };

typedef struct diff_result {
    bool same_dims, same_spacing, same_origin;
    bool rounded_geometry; /* true if rounding to float32 can explain the differences of spacing and origin */
    bool equal;
    int64_t count[DIFF_KIND_COUNT], different;
    ost_voxel_box box; /* smallest box that contains all differing voxels */
    int32_t busiest[3]; /* for each axis, the slice with the most differing voxels */
    int chunk_size;
    ost_dims chunk_dims;
    size_t chunk_count;
    diff_chunk *chunks; /* owned; chunks that differ, in grid order */
    size_t first_count;
    diff_voxel *first; /* owned; the first `limit` voxels that differ, in grid order */
    /* class of the difference: the name of the first pattern that holds; NULL if nothing is classified */
    const char *class;
    int pattern_count;
    diff_pattern patterns[DIFF_PATTERN_MAX];
} diff_result;

/*
 * Compares two volumes. Voxels are compared only if the dims are equal. The caller zero-initializes *out and calls
 * diff_free, even after an error.
 */
ost_status diff_compare(const loaded_volume *a, const loaded_volume *b, int chunk_size, size_t limit, diff_result *out,
                        ost_error *err);
void diff_free(diff_result *result);

/* Adds the patterns that hold to the result (pattern.c). */
void diff_patterns(const loaded_volume *a, const loaded_volume *b, diff_result *result);

const char *diff_kind_name(diff_kind kind);
const char *diff_kind_text(diff_kind kind);
diff_kind diff_kind_of(int16_t a, int16_t b, int32_t threshold_a, int32_t threshold_b);

/* Compares two bundles by the digests in them (bundles.c). */
bool diff_is_folder(const char *path);
ost_status diff_bundles(const app_state *app, const char *a, const char *b, int64_t limit, ost_error *err);

/*
 * Draws, for each axis, the slice with the most differing voxels. The differences are coloured over the densities of A
 * (picture.c).
 */
ost_status diff_picture(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out,
                        ost_error *err);
/*
 * Draws the surface of B around the voxel at result->busiest. If B's file contains the glenoid's axis, the view is
 * along this axis. Otherwise, the view is toward the bone's middle. diff_has_view must be true.
 */
ost_status diff_view(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out,
                     ost_error *err);
/* Returns true if both files are bones or CTs on the same cubic grid, and B lacks voxels of A. */
bool diff_has_view(const loaded_volume *a, const loaded_volume *b, const diff_result *result);
/* Returns true if the orientation of the grid's axes in the patient is not known. */
bool diff_unoriented(const loaded_volume *in);

/* Writes the result as a self-contained HTML page (html.c). */
ost_status diff_html(const char *path, const char *name_a, const char *name_b, const loaded_volume *a,
                     const loaded_volume *b, const diff_result *result, ost_error *err);

#endif
