/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Dense grids: dims, spacing, origin, and int16 densities.
 *
 * Voxel (i, j, k) is element i + dims.x * (j + dims.y * k): x fastest
 * (thesis, Alg. 1.1).  Its centre is origin + (i*sx, j*sy, k*sz), in the
 * bone's frame: the CT's physical frame, LPS+, picometres.
 *
 * Ranges (AR-GRID): 1 <= dims <= 16384 an axis and at most 2^36 voxels;
 * 1 um <= spacing <= 100 mm; every voxel centre within +-8 m.
 */
#ifndef OSTEON_GRID_H
#define OSTEON_GRID_H

#include <osteon/length.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ost_dims {
    int32_t x, y, z;
} ost_dims;

typedef struct ost_geometry {
    ost_dims dims;
    ost_pm3 spacing;
    ost_pm3 origin; /* centre of voxel (0, 0, 0) */
} ost_geometry;

enum { OST_DIM_MAX = 16384 };
#define OST_SPACING_MIN (OST_PM_PER_MM / 1000)
#define OST_SPACING_MAX (100 * OST_PM_PER_MM)

OST_API int64_t ost_dims_count(ost_dims dims);
/* OST_ERR_RANGE, naming what, when a range above does not hold. */
OST_API ost_status ost_geometry_check(const ost_geometry *geometry, const char *what, ost_error *err);
OST_API bool ost_geometry_equal(const ost_geometry *a, const ost_geometry *b);

/*
 * Facts that travel with a grid from file to file but decide no voxel: where
 * the glenoid is, which threshold made the bone, which arithmetic.  Keys are
 * [a-z0-9_]{1,40}, values one printable line of up to 200 bytes, without the
 * blanks around it.  At most OST_META_MAX entries; setting a key again gives
 * it the new value in its old position (AR-FILE-8).
 */
enum { OST_META_MAX = 32, OST_META_KEY = 41, OST_META_VALUE = 201 };
typedef struct ost_meta {
    int count;
    struct {
        char key[OST_META_KEY];
        char value[OST_META_VALUE];
    } entry[OST_META_MAX];
} ost_meta;

/* The value or NULL. The pointer lives as long as meta is not changed. */
OST_API const char *ost_meta_get(const ost_meta *meta, const char *key);
/* Returns true for dims, spacing_mm and origin_mm, which files give as a grid's own and never write as facts. */
OST_API bool ost_meta_key_is_geometry(const char *key);
/* OST_ERR_RANGE when key or value breaks the rule above or meta is full. */
OST_API ost_status ost_meta_set(ost_meta *meta, const char *key, const char *value, ost_error *err);

/* Keys with a meaning, all lengths decimal mm, vectors "x y z". */
#define OST_META_KIND "kind"                   /* "ct", "bone" or "tool" */
#define OST_META_ARITHMETIC "arithmetic"       /* version of docs/arithmetic.md */
#define OST_META_THRESHOLD "threshold"         /* of a bone */
#define OST_META_RESAMPLE "resample"           /* how the bone's voxels came from a CT: "linear", "nearest" or "thesis" */
#define OST_META_GLENOID_AT "glenoid_at_mm"    /* centre of the glenoid's face */
#define OST_META_GLENOID_AXIS "glenoid_axis"   /* inward direction, need not be unit */
#define OST_META_SIDE "side"                   /* "left" or "right" */
#define OST_META_TRIGONUM "trigonum_mm"       /* where the scapular spine meets the medial border */
#define OST_META_INFERIOR_ANGLE "inferior_angle_mm" /* the scapula's lowest point */
#define OST_META_ORIENTATION "orientation"     /* "stated XYZ" or "assumed LPS": the CT's file had none (AR-FILE-6) */
#define OST_META_TOOL_CORNER "tool_corner_mm"  /* MinVoxelCoords of Alg. 2.1, exact */

typedef struct ost_volume {
    ost_geometry geometry;
    ost_meta meta;
    int16_t *voxels; /* owned; ost_dims_count(dims) elements */
} ost_volume;

/* Zero-filled. On failure *volume has no voxels and free is still safe. */
OST_API ost_status ost_volume_init(ost_volume *volume, const ost_geometry *geometry, ost_error *err);
OST_API void ost_volume_free(ost_volume *volume);

#ifdef __cplusplus
}
#endif
#endif
