/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws pictures without a display: slices through a volume, and a shaded view of its surface. The functions do not
 * affect the removal of voxels.
 *
 * Threads: the functions share no state; a volume that is passed as const may be read by several threads.
 */
#ifndef OSTEON_PICTURE_H
#define OSTEON_PICTURE_H

#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A picture with 8 bits per colour channel (RGB). Row 0 is at the top. */
typedef struct ost_picture {
    int width, height;
    uint8_t *rgb; /* owned; 3 * width * height */
} ost_picture;

/* Allocates a picture filled with zeros. Returns OST_ERR_RANGE if the width or the height is not within 1 to 16384
 * pixels, and OST_ERR_MEMORY if memory is exhausted. After an error, *picture has no pixels but can still be freed. The
 * caller frees the pixels with ost_picture_free. */
OST_API ost_status ost_picture_init(ost_picture *picture, int width, int height, ost_error *err);
/* Frees the pixels of a picture, which is then empty. */
OST_API void ost_picture_free(ost_picture *picture);
/* Writes the picture as a PNG file, which appears only when it is complete. The errors are those of
 * ost_picture_encode_png, OST_ERR_USAGE if the file name is empty, and OST_ERR_IO if the file cannot be written. */
OST_API ost_status ost_picture_write_png(const char *path, const ost_picture *picture, ost_error *err);
/* Encodes the picture as a PNG in memory, for embedding in a page. Returns OST_ERR_UNAVAILABLE if the library was built
 * without libpng, OST_ERR_USAGE if the picture has no pixels, and OST_ERR_MEMORY if memory is exhausted; *bytes is then
 * NULL. The caller frees *bytes with free(). */
OST_API ost_status ost_picture_encode_png(const ost_picture *picture, uint8_t **bytes, size_t *size, ost_error *err);

/*
 * Options of ost_picture_slices, which draws the axial, coronal and sagittal slices through a voxel, with isotropic
 * pixels and in the radiological convention.
 */
typedef struct ost_slices_options {
    /* Indices of the voxel through which the slices pass. -1 selects the middle of the removed voxels or, if
     * `before` is NULL, the middle of the grid. */
    int32_t at[3];
    int32_t threshold;    /* voxels at or above this density are active; 0 selects 120 */
    /* Level and width of the grey-scale window in HU. If both are 0, they are set to 400 and 1800. */
    int level, width;
    int pixels;           /* length of the longest side of a slice in pixels; 0 selects 480 */
    bool unoriented;      /* true if the patient's directions are unknown, so that they are not drawn */
} ost_slices_options;
/*
 * Draws the slices. If `before` is not NULL, voxels that are active in `before` but not in `volume` are coloured.
 * Returns OST_ERR_USAGE if a volume has no voxels, if the geometries of the volumes differ, or if options->width is
 * less than 1, unless options->level and options->width are both 0. Returns OST_ERR_RANGE if the grid does not contain
 * the voxel options->at, or if the picture is larger than ost_picture_init accepts. Returns OST_ERR_MEMORY if memory is
 * exhausted. The caller frees *out with ost_picture_free.
 */
OST_API ost_status ost_picture_slices(const ost_volume *volume, const ost_volume *before,
                                      const ost_slices_options *options, ost_picture *out, ost_error *err);

/*
 * Options of ost_picture_view. The angle of view is 45 degrees. The scale bar is valid in the plane through the
 * centre of the view.
 */
typedef struct ost_view_options {
    /* Direction of view, from the eye into the scene, in the bone's frame. (0, 0, 0) selects the
     * posterior direction, which is (0, 1, 0) in LPS. */
    double direction[3];
    double up[3];         /* upward direction in the bone's frame; (0, 0, 0) selects superior, which is (0, 0, 1) */
    int32_t threshold;    /* voxels at or above this density are active; 0 selects 120 */
    int width, height;    /* size of the picture in pixels; if both are 0, they are set to 800 */
    double centre_mm[3];  /* centre of the view; used only if extent_mm > 0 */
    /* Height of the view in the plane through its centre. With 0, the view shows the complete bone. */
    double extent_mm;
    bool tool;            /* true if the volume is a tool, which is drawn as steel */
    bool unoriented;      /* true if the patient's directions are unknown, so that they are not drawn */
    bool no_legend;       /* true to omit the legend, the scale bar and the patient's directions */
    int threads;          /* number of threads; 0 selects one for each processor */
} ost_view_options;
/*
 * Draws a view of the active voxels with a scale bar and the patient's directions, as `osteon render` does (render.h).
 * The voxels must be cubes. If `before` is not NULL, the newly exposed surface is coloured by its depth below the
 * surface of `before`, and a legend is drawn. Returns OST_ERR_USAGE if a volume has no voxels, if the geometries of the
 * volumes differ, or if options->direction and options->up are parallel. Returns OST_ERR_RANGE if the voxels are not
 * cubes, if the width or the height is not within 1 to OST_FRAME_MAX pixels, or if the camera is too far away, and
 * OST_ERR_MEMORY if memory is exhausted. If the instruction set in the environment variable OSTEON_ISA is unknown,
 * returns OST_ERR_USAGE; if this machine lacks it, returns OST_ERR_UNAVAILABLE. The caller frees *out with
 * ost_picture_free.
 */
OST_API ost_status ost_picture_view(const ost_volume *volume, const ost_volume *before, const ost_view_options *options,
                                    ost_picture *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
