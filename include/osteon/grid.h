/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Dense grids with dims, spacing, origin, and int16 densities.
 *
 * Voxel (i, j, k) is element i + dims.x * (j + dims.y * k): x fastest
 * (thesis, Alg. 1.1).  Its centre is origin + (i*sx, j*sy, k*sz), in the
 * bone's frame: the CT's physical frame, LPS+, picometres.
 *
 * Ranges (AR-GRID): 1 <= dims <= 16384 per axis and at most 2^36 voxels;
 * 1 um <= spacing <= 100 mm; every voxel centre is within +-8 m.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_GRID_H
#define OSTEON_GRID_H

#include <osteon/length.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of voxels along the three axes. */
typedef struct ost_dims {
    int32_t x, y, z;
} ost_dims;

/* The grid of a volume: dims, spacing and origin in picometres (AR-GRID). */
typedef struct ost_geometry {
    ost_dims dims;
    ost_pm3 spacing;
    ost_pm3 origin; /* centre of voxel (0, 0, 0) */
} ost_geometry;

enum { OST_DIM_MAX = 16384 };
#define OST_SPACING_MIN (OST_PM_PER_MM / 1000)
#define OST_SPACING_MAX (100 * OST_PM_PER_MM)

/* Returns the number of voxels, x * y * z. The product does not overflow for dims within AR-GRID. */
OST_API int64_t ost_dims_count(ost_dims dims);
/*
 * Returns OST_ERR_RANGE if a value is outside the ranges of AR-GRID. In the error message, `what` is the name of
 * the grid.
 */
OST_API ost_status ost_geometry_check(const ost_geometry *geometry, const char *what, ost_error *err);
/* Returns true if dims, spacing and origin are equal. */
OST_API bool ost_geometry_equal(const ost_geometry *a, const ost_geometry *b);

/*
 * Facts about a grid that are stored in a file's header, such as the position of the glenoid, the threshold of the
 * bone and the arithmetic version. When a grid is copied from file to file, its facts are also copied. Facts do not
 * affect the voxels. A key matches the pattern [a-z0-9_]{1,40}. A value is one printable line of up to 200 bytes
 * without surrounding blanks. There are at most OST_META_MAX entries. If an existing key is set again, its value is
 * replaced, and the entry keeps its position (AR-FILE-8).
 */
enum { OST_META_MAX = 32, OST_META_KEY = 41, OST_META_VALUE = 201 };
/* Facts in the order in which they were set. Zero-initialise the struct before use. */
typedef struct ost_meta {
    int count;
    struct {
        char key[OST_META_KEY];
        char value[OST_META_VALUE];
    } entry[OST_META_MAX];
} ost_meta;

/* Returns the value of key, or NULL if key is not set. The pointer is valid until meta is changed. */
OST_API const char *ost_meta_get(const ost_meta *meta, const char *key);
/*
 * Returns true if key is "dims", "spacing_mm" or "origin_mm". These keys describe the geometry of a grid and are
 * never written as facts.
 */
OST_API bool ost_meta_key_is_geometry(const char *key);
/* Sets the value of a fact. Returns OST_ERR_RANGE if key or value is not allowed, or if meta is full. */
OST_API ost_status ost_meta_set(ost_meta *meta, const char *key, const char *value, ost_error *err);

/* Keys with a defined meaning. Lengths are decimal numbers in mm; vectors have the form "x y z". */
#define OST_META_KIND "kind"                   /* "ct", "bone" or "tool" */
#define OST_META_ARITHMETIC "arithmetic"       /* version of docs/spec/arithmetic.md */
#define OST_META_THRESHOLD "threshold"         /* threshold of a bone */
#define OST_META_RESAMPLE "resample"           /* rule by which the CT was resampled: "linear", "nearest" or "thesis" */
#define OST_META_GLENOID_AT "glenoid_at_mm"    /* centre of the glenoid's face */
#define OST_META_GLENOID_AXIS "glenoid_axis"   /* inward axis of the glenoid, not necessarily of unit length */
#define OST_META_SIDE "side"                   /* "left" or "right" */
#define OST_META_TRIGONUM "trigonum_mm"       /* point at which the scapular spine meets the medial border */
#define OST_META_INFERIOR_ANGLE "inferior_angle_mm" /* lowest point of the scapula */
/* "stated XYZ" or "assumed LPS"; set only if the CT's file contains no orientation (AR-FILE-6) */
#define OST_META_ORIENTATION "orientation"
#define OST_META_TOOL_CORNER "tool_corner_mm"  /* exact corner of a tool's grid, MinVoxelCoords in Alg. 2.1 */

/* A dense grid of densities in host memory. */
typedef struct ost_volume {
    ost_geometry geometry;
    ost_meta meta;
    int16_t *voxels; /* owned; ost_dims_count(dims) elements */
} ost_volume;

/*
 * Allocates a volume filled with zeros. Returns OST_ERR_RANGE if geometry is outside the ranges of AR-GRID, and
 * OST_ERR_MEMORY if memory is exhausted. After an error, *volume has no voxels but can still be freed. The caller frees
 * the voxels with ost_volume_free.
 */
OST_API ost_status ost_volume_init(ost_volume *volume, const ost_geometry *geometry, ost_error *err);
/* Frees the voxels of a volume, which is then empty. */
OST_API void ost_volume_free(ost_volume *volume);

#ifdef __cplusplus
}
#endif
#endif
