/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The HUD as a transparent layer, for frames that OpenGL draws directly into the window.
 *
 *   facts --drawn on an empty sheet--> layer --changed cells--> OpenGL, over the frame
 */
#ifndef OST_APP_SIM_LAYER_H
#define OST_APP_SIM_LAYER_H

#include "app/sim/hud.h"
#include "render/gl/gl.h"

typedef struct sim_layer {
    uint32_t *pixels; /* owned; NULL before the first call of sim_layer_draw */
    int width, height;
    ost_cells written; /* owned; cells of the HUD */
    ost_cells changed; /* owned; cells in which the layer may differ from the layer that was shown last */
} sim_layer;

void sim_layer_free(sim_layer *layer); /* accepts zero-initialized memory */
/* Returns true if the layer has the given size. A layer of another size must be drawn again. */
bool sim_layer_fits(const sim_layer *layer, int width, int height);
/* Erases the layer, then draws the HUD with the given facts on it. */
ost_status sim_layer_draw(sim_layer *layer, int width, int height, const sim_hud *hud, const sim_hud_facts *facts,
                          ost_error *err);
/* Returns the layer for ost_viewer_show. The result is valid until the layer is drawn again. */
ost_gl_sheet sim_layer_sheet(const sim_layer *layer);
/* Clears `changed`. Must be called after the layer was shown. */
void sim_layer_shown(sim_layer *layer);

#endif
