/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Three slices, on each axis the one with most differences, next to each other:
 *
 *   axial (x right, y down) | coronal (x right, z up) | sagittal (y right, z up)
 *
 * Grey is the greater of the two densities, dimmed. Removed voxels are red, added ones blue,
 * changed ones amber, those below the threshold violet. Pixels are square in millimetres.
 */
#include "app/diff_compare.h"

#include <math.h>
#include <string.h>

enum { PANEL = 420, GAP = 8 };

typedef struct panel {
    int u, v;      /* bone axes to the right and down */
    bool v_up;
    int width, height;
} panel;

static void panel_size(panel *p, const double size[3])
{
    double longest = size[p->u] > size[p->v] ? size[p->u] : size[p->v];
    p->width = (int)lround(PANEL * size[p->u] / longest);
    p->height = (int)lround(PANEL * size[p->v] / longest);
    p->width = p->width < 1 ? 1 : p->width;
    p->height = p->height < 1 ? 1 : p->height;
}

static void colour_of(const loaded_volume *a, const loaded_volume *b, int64_t v, uint8_t rgb[3])
{
    static const uint8_t colour[DIFF_KIND_COUNT][3] = {{214, 60, 52}, {38, 120, 214}, {230, 160, 30}, {150, 90, 190}};
    int16_t va = a->volume.voxels[v], vb = b->volume.voxels[v];
    if (va != vb) {
        memcpy(rgb, colour[diff_kind_of(va, vb, a->threshold, b->threshold)], 3);
        return;
    }
    double grey = a->kind == LOAD_TOOL ? va * 70.0 : (va + 500.0) / 1800 * 150;
    grey = grey < 0 ? 0 : grey > 150 ? 150 : grey;
    memset(rgb, (int)grey, 3);
}

static void draw(const loaded_volume *a, const loaded_volume *b, const diff_result *r, const panel *p, int left, ost_picture *out)
{
    const int32_t dims[3] = {a->volume.geometry.dims.x, a->volume.geometry.dims.y, a->volume.geometry.dims.z};
    int32_t at[3] = {r->busiest[0], r->busiest[1], r->busiest[2]};
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            int row = p->v_up ? p->height - 1 - y : y;
            at[p->u] = (int32_t)((int64_t)x * dims[p->u] / p->width);
            at[p->v] = (int32_t)((int64_t)row * dims[p->v] / p->height);
            int64_t v = at[0] + dims[0] * (at[1] + (int64_t)dims[1] * at[2]);
            colour_of(a, b, v, out->rgb + 3 * ((size_t)y * (size_t)out->width + (size_t)(left + x)));
        }
}

ost_status diff_picture(const loaded_volume *a, const loaded_volume *b, const diff_result *result, ost_picture *out, ost_error *err)
{
    const ost_geometry *g = &a->volume.geometry;
    const double size[3] = {g->dims.x * ost_pm_to_mm(g->spacing.x), g->dims.y * ost_pm_to_mm(g->spacing.y), g->dims.z * ost_pm_to_mm(g->spacing.z)};
    panel panels[3] = {{.u = 0, .v = 1}, {.u = 0, .v = 2, .v_up = true}, {.u = 1, .v = 2, .v_up = true}};
    int width = 2 * GAP, height = 1;
    for (int i = 0; i < 3; i++) {
        panel_size(&panels[i], size);
        width += panels[i].width;
        height = panels[i].height > height ? panels[i].height : height;
    }
    ost_status status = ost_picture_init(out, width, height, err);
    if (status != OST_OK)
        return status;
    memset(out->rgb, 255, 3 * (size_t)width * (size_t)height);
    for (int i = 0, left = 0; i < 3; left += panels[i].width + GAP, i++)
        draw(a, b, result, &panels[i], left, out);
    return OST_OK;
}
