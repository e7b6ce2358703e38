/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/report/triplet.h"

#include <stdlib.h>
#include <string.h>

/* LEAST is the smallest width that is shown, and MARGIN is the width of the border around the differences; both are in
   voxels. PANEL is the length of the longest side of all panels, and GAP is the distance between panels; both are in
   pixels. */
enum { LEAST = 32, MARGIN = 6, PANEL = 288, GAP = 8 };

static int16_t at_voxel(const ost_volume *v, const int32_t at[3])
{
    const ost_dims d = v->geometry.dims;
    return v->voxels[(size_t)at[0] + (size_t)d.x * ((size_t)at[1] + (size_t)d.y * (size_t)at[2])];
}

bool triplet_of(const ost_volume *reference, const ost_volume *got, bool tool, triplet *out)
{
    const ost_dims d = reference->geometry.dims;
    const int32_t size[3] = {d.x, d.y, d.z};
    int32_t hi[3] = {-1, -1, -1};
    int64_t *slices[3] = {NULL, NULL, NULL};
    bool differs = false;
    *out = (triplet){.reference = reference, .got = got, .tool = tool, .lo = {d.x, d.y, d.z}};
    for (int a = 0; a < 3; a++)
        slices[a] = calloc((size_t)size[a], sizeof *slices[a]);
    if (slices[0] && slices[1] && slices[2]) {
        size_t v = 0;
        for (int32_t z = 0; z < d.z; z++)
            for (int32_t y = 0; y < d.y; y++)
                for (int32_t x = 0; x < d.x; x++, v++) {
                    if (reference->voxels[v] == got->voxels[v])
                        continue;
                    const int32_t at[3] = {x, y, z};
                    differs = true;
                    for (int a = 0; a < 3; a++) {
                        slices[a][at[a]]++;
                        out->lo[a] = at[a] < out->lo[a] ? at[a] : out->lo[a];
                        hi[a] = at[a] > hi[a] ? at[a] : hi[a];
                    }
                }
        for (int a = 0; a < 3 && differs; a++) {
            for (int32_t i = 0; i < size[a]; i++)
                out->at[a] = slices[a][i] > slices[a][out->at[a]] ? i : out->at[a];
            int32_t n = hi[a] + 1 - out->lo[a] + 2 * MARGIN, lo = out->lo[a] - MARGIN;
            if (n < LEAST) {
                lo -= (LEAST - n) / 2;
                n = LEAST;
            }
            n = n > size[a] ? size[a] : n;
            out->lo[a] = lo < 0 ? 0 : lo > size[a] - n ? size[a] - n : lo;
            out->n[a] = n;
        }
    }
    for (int a = 0; a < 3; a++)
        free(slices[a]);
    return differs;
}

static uint8_t grey_of(const triplet *t, int32_t value)
{
    int32_t grey = t->tool ? value * 110 : (value + 500) * 255 / 1800;
    grey = grey < 0 ? 0 : grey > 255 ? 255 : grey;
    return (uint8_t)grey;
}

/* Chooses the pattern and the colour of pixel (x, y) of a differing voxel. They show whether the voxel is solid
   only in the reference, is solid only in the other volume, or has a different value. */
static void mark(const triplet *t, int32_t ref, int32_t got, int x, int y, uint8_t rgb[3])
{
    static const uint8_t only_ref[2][3] = {{194, 47, 39}, {255, 255, 255}}, only_got[3] = {36, 103, 189},
                         other[2][3] = {{226, 164, 0}, {34, 34, 34}};
    const int32_t solid = t->tool ? 1 : 120;
    if (ref >= solid && got < solid)
        memcpy(rgb, only_ref[(x + y) % 6 < 2], 3);
    else if (got >= solid && ref < solid)
        memcpy(rgb, only_got, 3);
    else
        memcpy(rgb, other[y % 6 < 2], 3);
}

static void draw_panel(const triplet *t, picture_role role, int across, int down, int left, int width, int height,
                       ost_picture *out)
{
    int32_t at[3] = {t->at[0], t->at[1], t->at[2]};
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const int row = down == 2 ? height - 1 - y : y; /* z points up in the picture, so rows are reversed */
            at[across] = t->lo[across] + (int32_t)((int64_t)x * t->n[across] / width);
            at[down] = t->lo[down] + (int32_t)((int64_t)row * t->n[down] / height);
            const int16_t ref = at_voxel(t->reference, at), got = at_voxel(t->got, at);
            uint8_t *rgb = out->rgb + 3 * ((size_t)y * (size_t)out->width + (size_t)(left + x));
            uint8_t grey = grey_of(t, role == PICTURE_GOT ? got : ref);
            if (role == PICTURE_DIFFERENCE) /* densities are drawn paler, so that the marks stand out */
                grey = (uint8_t)(170 + grey / 4);
            memset(rgb, grey, 3);
            if (role == PICTURE_DIFFERENCE && ref != got)
                mark(t, ref, got, x, y, rgb);
        }
}

ost_status triplet_draw(const triplet *t, picture_role role, ost_picture *out, ost_error *err)
{
    static const int axes[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    const int32_t longest = t->n[0] > t->n[1]   ? (t->n[0] > t->n[2] ? t->n[0] : t->n[2])
                            : t->n[1] > t->n[2] ? t->n[1]
                                                : t->n[2];
    int width[3], height[3], total = 2 * GAP, tallest = 1;
    for (int i = 0; i < 3; i++) {
        width[i] = (int)((int64_t)PANEL * t->n[axes[i][0]] / longest);
        height[i] = (int)((int64_t)PANEL * t->n[axes[i][1]] / longest);
        width[i] = width[i] < 1 ? 1 : width[i];
        height[i] = height[i] < 1 ? 1 : height[i];
        total += width[i];
        tallest = height[i] > tallest ? height[i] : tallest;
    }
    ost_status status = ost_picture_init(out, total, tallest, err);
    if (status != OST_OK)
        return status;
    memset(out->rgb, 255, 3 * (size_t)total * (size_t)tallest);
    for (int i = 0, left = 0; i < 3; left += width[i] + GAP, i++)
        draw_panel(t, role, axes[i][0], axes[i][1], left, width[i], height[i], out);
    return OST_OK;
}
