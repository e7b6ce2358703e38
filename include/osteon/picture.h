/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures without a display: slices through a volume and a shaded view of
 * its surface.  Nothing here affects the removal of voxels.
 */
#ifndef OSTEON_PICTURE_H
#define OSTEON_PICTURE_H

#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/* 8-bit RGB, row 0 at the top. */
typedef struct ost_picture {
    int width, height;
    uint8_t *rgb; /* owned; 3 * width * height */
} ost_picture;

/* Allocates a picture filled with zeros. On failure *picture has no pixels and can still be freed. */
OST_API ost_status ost_picture_init(ost_picture *picture, int width, int height, ost_error *err);
/* Frees the pixels of a picture, which is then empty. */
OST_API void ost_picture_free(ost_picture *picture);
/* Writes the picture as a PNG file. Returns OST_ERR_UNAVAILABLE if the library was built without libpng. */
OST_API ost_status ost_picture_write_png(const char *path, const ost_picture *picture, ost_error *err);
/* Encodes the picture as a PNG in memory, for embedding; the caller frees *bytes with free(). */
OST_API ost_status ost_picture_encode_png(const ost_picture *picture, uint8_t **bytes, size_t *size, ost_error *err);

/*
 * Options of ost_picture_slices, which draws three slices through a voxel (axial,
 * coronal, sagittal; radiological convention, isotropic pixels).
 */
typedef struct ost_slices_options {
    int32_t at[3];        /* voxel; -1: the middle of the grid, or of the removed voxels if before is not NULL */
    int32_t threshold;    /* voxels at or above this density are active; 0: 120 */
    int level, width;     /* level and width of the window in HU; 0, 0: 400, 1800 */
    int pixels;           /* pixels of the longest side of a slice; 0: 480 */
    bool unoriented;      /* the patient's directions are unknown and are not drawn */
} ost_slices_options;
/*
 * Draws the slices.  before may be NULL; voxels that are active in before but not in volume are coloured.  The caller
 * owns *out.
 */
OST_API ost_status ost_picture_slices(const ost_volume *volume, const ost_volume *before,
                                      const ost_slices_options *options, ost_picture *out, ost_error *err);

/*
 * Options of ost_picture_view.  The angle of view is 45 degrees; lengths are to scale in the plane
 * through the centre of the view.
 */
typedef struct ost_view_options {
    double direction[3];  /* from the eye into the scene, in the bone's frame; 0 0 0: posterior (0 1 0) in LPS */
    double up[3];         /* upward direction in the bone's frame; 0 0 0: superior (0 0 1) */
    int32_t threshold;    /* voxels at or above this density are active; 0: 120 */
    int width, height;    /* pixels; 0, 0: 800, 800 */
    double centre_mm[3];  /* used if extent_mm > 0 */
    double extent_mm;     /* height of the view in the plane through the centre; 0: the complete bone */
    bool tool;            /* the volume is a tool and is drawn as steel */
    bool unoriented;      /* the patient's directions are unknown and are not drawn */
    bool no_legend;       /* legend, scale and directions are not drawn */
    int threads;          /* 0: one for each processor */
} ost_view_options;
/*
 * Draws a view of the active voxels, as osteon render does (render.h), with a scale bar and the patient's directions.
 * The voxels must be cubes.  If before is not NULL, the surface exposed since then is coloured by its depth below the
 * earlier surface, and a legend is drawn.  The caller owns *out.
 */
OST_API ost_status ost_picture_view(const ost_volume *volume, const ost_volume *before, const ost_view_options *options,
                                    ost_picture *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
