/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A smooth approximation of the active voxels, for pictures only.
 *
 *   volume >= threshold --weight--> 0..255 --blur--> level 0 --halve--> level 1 --> ...
 *
 * It is cropped to the active voxels, with a margin of empty samples.  A cut
 * through bone leaves a hard border (full density next to zero), and a resampled
 * grid has steps; the blur removes both from the shading.  Higher levels are
 * means over 2^k samples: the amount of bone around a point at that distance.
 */
#ifndef OST_RENDER_FIELD_H
#define OST_RENDER_FIELD_H

#include <osteon/grid.h>

enum { OST_FIELD_LEVELS = 7, OST_FIELD_BRICK = 8 };

typedef struct ost_field_level {
    int n[3];
    uint8_t *v; /* owned */
} ost_field_level;

typedef struct ost_field {
    double origin_mm[3], step_mm[3]; /* of level 0: centre of its first sample, spacing of its samples */
    int levels;
    ost_field_level level[OST_FIELD_LEVELS];
    int bricks[3];
    uint8_t *brick_max; /* owned; maximum over 8^3 samples of level 0 and one more on each side */
} ost_field;

typedef void ost_field_pick(const void *user, size_t voxel, uint8_t *weight);

/*
 * ost_field_bounds computes the box lo <= v < hi of the voxels at or above the threshold; returns false if there are none.
 * ost_field_init makes the field over that box, with the weights that pick returns for the volume's element index.
 */
bool ost_field_bounds(const ost_volume *volume, int32_t threshold, int lo[3], int hi[3]);
ost_status ost_field_init(ost_field *field, const ost_volume *volume, const int lo[3], const int hi[3], ost_field_pick *pick,
                          const void *user, int levels, ost_error *err);
void ost_field_free(ost_field *field);

/* Returns the trilinear value at p, 0 outside; p is in samples of level 0 (x, y, z). */
float ost_field_at(const ost_field *field, int level, const float p[3]);

#endif
