/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/voxel_blocks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/memory_stream.h"

enum { WIDTH = 640, HEIGHT = 520, MARGIN = 12 };

/*
 * A parallel projection. The viewer looks from the octant opposite to the direction into the bone. At most three faces
 * of each voxel are visible, one per axis. Voxels are drawn from far to near.
 */
typedef struct projection {
    const ost_volume *volume;
    const ost_voxel_box *box;
    int32_t threshold;
    int sign[3];        /* for each axis, the side that faces the viewer: 1 or -1 */
    double axis[3][2];  /* displacement in the picture for 1 mm along an axis */
    double spacing[3];  /* mm */
    double scale, x, y; /* pixels per mm, and the position of the box's first corner in the picture */
} projection;

static bool is_active(const projection *p, const int32_t at[3])
{
    const ost_dims d = p->volume->geometry.dims;
    for (int a = 0; a < 3; a++)
        if (at[a] < p->box->lo[a] || at[a] >= p->box->hi[a])
            return false;
    return p->volume->voxels[at[0] + d.x * (at[1] + (int64_t)d.y * at[2])] >= p->threshold;
}

/*
 * Computes the position of a corner in the picture. The corner is given in voxels, relative to the box's first corner.
 */
static void project(const projection *p, const double corner[3], double out[2])
{
    for (int i = 0; i < 2; i++)
        out[i] = p->axis[0][i] * corner[0] * p->spacing[0] + p->axis[1][i] * corner[1] * p->spacing[1] +
                 p->axis[2][i] * corner[2] * p->spacing[2];
}

static void fit(projection *p)
{
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    p->scale = 1;
    for (int i = 0; i < 8; i++) {
        double corner[3], at[2];
        for (int a = 0; a < 3; a++)
            corner[a] = i >> a & 1 ? p->box->hi[a] - p->box->lo[a] : 0;
        project(p, corner, at);
        for (int b = 0; b < 2; b++) {
            lo[b] = fmin(lo[b], at[b]);
            hi[b] = fmax(hi[b], at[b]);
        }
    }
    p->scale = fmin((WIDTH - 2 * MARGIN) / (hi[0] - lo[0]), (HEIGHT - 2 * MARGIN) / (hi[1] - lo[1]));
    p->x = (WIDTH - p->scale * (lo[0] + hi[0])) / 2;
    p->y = (HEIGHT - p->scale * (lo[1] + hi[1])) / 2;
}

static void face(FILE *to, const projection *p, const int32_t at[3], int axis)
{
    /* Colours of the faces perpendicular to x, y and z. */
    static const char *const fill[3] = {"#b9ad97", "#9c917d", "#efe7d8"};
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    static const int ring[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    fputs("<path d=\"", to);
    for (int i = 0; i < 4; i++) {
        double corner[3], out[2];
        for (int a = 0; a < 3; a++)
            corner[a] = at[a] - p->box->lo[a];
        corner[axis] += p->sign[axis] > 0;
        corner[b] += ring[i][0];
        corner[c] += ring[i][1];
        project(p, corner, out);
        fprintf(to, "%c%.1f %.1f", i ? 'L' : 'M', p->x + p->scale * out[0], p->y + p->scale * out[1]);
    }
    fprintf(to, "Z\" fill=\"%s\"/>\n", fill[axis]);
}

static void draw_voxels(FILE *to, const projection *p)
{
    int32_t at[3], i[3], count[3];
    for (int a = 0; a < 3; a++)
        count[a] = p->box->hi[a] - p->box->lo[a];
    for (i[2] = 0; i[2] < count[2]; i[2]++)
        for (i[1] = 0; i[1] < count[1]; i[1]++)
            for (i[0] = 0; i[0] < count[0]; i[0]++) {
                for (int a = 0; a < 3; a++)
                    at[a] = p->sign[a] > 0 ? p->box->lo[a] + i[a] : p->box->hi[a] - 1 - i[a];
                if (!is_active(p, at))
                    continue;
                for (int a = 0; a < 3; a++) {
                    int32_t next[3] = {at[0], at[1], at[2]};
                    next[a] += p->sign[a];
                    if (!is_active(p, next))
                        face(to, p, at, a);
                }
            }
}

/* Draws a scale bar of 2 mm at the lower edge of the picture. */
static void draw_scale(FILE *to, const projection *p)
{
    /* in the picture, 1 mm along the x axis has a horizontal extent of cos(30 deg) mm */
    const double length = 2 * p->scale * sqrt(3) / 2;
    fprintf(to,
            "<path d=\"M%d %dv6h%.1fv-6\" fill=\"none\" stroke=\"#222\" stroke-width=\"1.4\"/>"
            "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">2 mm</text>\n",
            MARGIN, HEIGHT - 14, length, MARGIN + length / 2, HEIGHT - 18);
}

ost_status voxel_blocks_draw(const ost_volume *volume, const ost_voxel_box *box, int32_t threshold,
                             const double inward[3], uint8_t **svg, size_t *size, ost_error *err)
{
    const double cosine = sqrt(3) / 2, sine = 0.5;
    const ost_pm3 s = volume->geometry.spacing;
    projection p = {.volume = volume,
                    .box = box,
                    .threshold = threshold,
                    .spacing = {ost_pm_to_mm(s.x), ost_pm_to_mm(s.y), ost_pm_to_mm(s.z)}};
    for (int a = 0; a < 3; a++)
        p.sign[a] = inward[a] > 0 ? -1 : 1;
    p.sign[2] = 1; /* the viewer is above the bone, so z points up in the picture */
    /* In the picture, one of the axes x and y runs towards the viewer to the lower left, and the other to the lower
       right. `side` is chosen so that the picture is not mirrored. */
    const int side = p.sign[0] * p.sign[1];
    p.axis[0][0] = -cosine * p.sign[0] * side;
    p.axis[0][1] = sine * p.sign[0];
    p.axis[1][0] = cosine * p.sign[1] * side;
    p.axis[1][1] = sine * p.sign[1];
    p.axis[2][1] = -1;
    ost_memory_stream memory;
    FILE *to = ost_memory_stream_open(&memory);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a drawing of voxels");
    fit(&p);
    fprintf(to,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\" role=\"img\" "
            "font-family=\"Arial, Liberation Sans, DejaVu Sans, sans-serif\" font-size=\"13\" fill=\"#222222\">\n"
            "<title>voxels</title><rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n"
            "<g stroke=\"#4a4335\" stroke-width=\"0.6\" stroke-linejoin=\"round\">\n",
            WIDTH, HEIGHT, WIDTH, HEIGHT, WIDTH, HEIGHT);
    draw_voxels(to, &p);
    fputs("</g>\n", to);
    draw_scale(to, &p);
    fputs("</svg>\n", to);
    if (!ost_memory_stream_close(to, &memory))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a drawing of voxels");
    *svg = (uint8_t *)memory.bytes;
    *size = memory.size;
    return OST_OK;
}
