/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/layer.h"

#include <stdlib.h>
#include <string.h>

void sim_layer_free(sim_layer *layer)
{
    free(layer->pixels);
    ost_cells_free(&layer->written);
    ost_cells_free(&layer->changed);
    *layer = (sim_layer){.pixels = NULL};
}

bool sim_layer_fits(const sim_layer *layer, int width, int height)
{
    return layer->pixels && layer->width == width && layer->height == height;
}

static ost_status resize(sim_layer *layer, int width, int height, ost_error *err)
{
    sim_layer_free(layer);
    layer->pixels = calloc((size_t)width * (size_t)height, sizeof *layer->pixels);
    if (!layer->pixels || !ost_cells_init(&layer->written, width, height) ||
        !ost_cells_init(&layer->changed, width, height)) {
        sim_layer_free(layer);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a HUD of %d x %d pixels", width, height);
    }
    layer->width = width;
    layer->height = height;
    ost_cells_fill(&layer->changed);
    return OST_OK;
}

/* Makes the pixels of the written cells transparent. */
static void erase(const sim_layer *layer)
{
    for (int row = 0; row < layer->written.rows; row++)
        for (int from, to = 0; ost_cells_run(&layer->written, row, &from, &to);) {
            const ost_cells_box b = ost_cells_box_of(&layer->written, row, from, to);
            for (int y = b.y0; y < b.y1; y++)
                memset(layer->pixels + (size_t)y * (size_t)layer->width + b.x0, 0,
                       (size_t)(b.x1 - b.x0) * sizeof *layer->pixels);
        }
}

ost_status sim_layer_draw(sim_layer *layer, int width, int height, const sim_hud *hud, const sim_hud_facts *facts,
                          ost_error *err)
{
    ost_status status = sim_layer_fits(layer, width, height) ? OST_OK : resize(layer, width, height, err);
    if (status != OST_OK)
        return status;
    erase(layer);
    ost_cells_join(&layer->changed, &layer->written);
    ost_cells_clear(&layer->written);
    const ost_sheet sheet = {.pixels = layer->pixels,
                             .stride = width,
                             .width = width,
                             .height = height,
                             .written = &layer->written};
    sim_hud_draw(hud, &sheet, facts);
    ost_cells_join(&layer->changed, &layer->written);
    return OST_OK;
}

ost_gl_sheet sim_layer_sheet(const sim_layer *layer)
{
    return (ost_gl_sheet){.pixels = layer->pixels, .stride = layer->width, .changed = &layer->changed};
}

void sim_layer_shown(sim_layer *layer)
{
    ost_cells_clear(&layer->changed);
}
