/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What differs between two grids, top down.
 *
 *   verdict   equal or not
 *   geometry  dims, spacing, origin
 *   chunks    which blocks differ, and how much
 *   kinds     removed, added, changed, below: per voxel, exactly one of them
 *   patterns  what the difference as a whole looks like (diff_pattern.c)
 *   voxels    the first ones, with both values
 *
 * A voxel is solid at the threshold or more (a tool's: when not void).
 */
#ifndef OST_APP_DIFF_COMPARE_H
#define OST_APP_DIFF_COMPARE_H

#include "app/load.h"
#include "validation/locate/pattern.h"

typedef enum diff_kind {
    DIFF_REMOVED, /* solid in A only */
    DIFF_ADDED,   /* solid in B only */
    DIFF_CHANGED, /* solid in both, another density */
    DIFF_BELOW,   /* solid in neither, another density */
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
    bool rounded_geometry; /* spacing or origin is the same only as a float32 */
    bool equal;
    int64_t count[DIFF_KIND_COUNT], different;
    ost_voxel_box box; /* around all differences */
    int32_t busiest[3]; /* on each axis the slice with most differences */
    int chunk_size;
    ost_dims chunk_dims;
    size_t chunk_count;
    diff_chunk *chunks; /* owned: those that differ, in grid order */
    size_t first_count;
    diff_voxel *first; /* owned: the first `limit` in grid order */
    const char *class; /* what it looks like first of all; NULL: there is nothing to classify */
    int pattern_count;
    diff_pattern patterns[DIFF_PATTERN_MAX];
} diff_result;

/* Zero-initialise *out; free it in any case. Without equal dims no voxel is compared. */
ost_status diff_compare(const loaded_volume *a, const loaded_volume *b, int chunk_size, size_t limit, diff_result *out, ost_error *err);
void diff_free(diff_result *result);

/* Adds the patterns that hold; in diff_pattern.c. */
void diff_patterns(const loaded_volume *a, const loaded_volume *b, diff_result *result);

const char *diff_kind_name(diff_kind kind);
const char *diff_kind_text(diff_kind kind);
diff_kind diff_kind_of(int16_t a, int16_t b, int32_t threshold_a, int32_t threshold_b);

/* diff_bundles.c: two folders of evidence by their digests. */
bool diff_is_folder(const char *path);
ost_status diff_bundles(const app_state *app, const char *a, const char *b, int64_t limit, ost_error *err);

/* diff_picture.c: three slices through the busiest voxel, differences coloured over A's and B's densities. */
ost_status diff_picture(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out, ost_error *err);

/* diff_html.c: one page that needs nothing else. */
ost_status diff_html(const char *path, const char *name_a, const char *name_b, const loaded_volume *a, const loaded_volume *b,
                     const diff_result *result, ost_error *err);

#endif
