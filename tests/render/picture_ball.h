/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A volume that contains a ball, and access to the pixels of a picture, for the tests of pictures made without a
 * display.
 */
#ifndef OST_TESTS_PICTURE_BALL_H
#define OST_TESTS_PICTURE_BALL_H

#include "harness.h"

#include <osteon/picture.h>

/*
 * Returns a ball of 1000 HU with a radius of 8 mm, in a box of 24 x 20 x 16 mm with voxels of
 * 0.5 x 0.5 x 1 mm. If `bitten`, its front (y < 8 mm) is removed.
 */
static inline ost_volume ball_of_slices(bool bitten)
{
    ost_error err = {0};
    ost_volume v;
    ost_geometry g = {{48, 40, 16}, {OST_PM_PER_MM / 2, OST_PM_PER_MM / 2, OST_PM_PER_MM}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int k = 0; k < 16; k++)
        for (int j = 0; j < 40; j++)
            for (int i = 0; i < 48; i++) {
                double x = 0.5 * i - 12, y = 0.5 * j - 10, z = k - 8;
                v.voxels[i + 48 * (j + 40 * k)] = x * x + y * y + z * z < 64 && !(bitten && j < 16) ? 1000 : 0;
            }
    return v;
}

static inline const uint8_t *pixel(const ost_picture *p, int x, int y)
{
    return p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
}

#endif
