/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Maps paint numbers to colours.
 *
 *   1 .. 127     a scale, or a colour for each tissue, lit like the surface
 *   128 .. 255   the tissues again, or the grey window of a CT, without lighting
 *
 * The scale runs from light to dark, through yellow, green, blue and violet, so that its order is also recognizable to
 * colour-blind viewers and in black-and-white print. Tissues differ in both lightness and hue.
 */
#ifndef OST_RENDER_PALETTE_H
#define OST_RENDER_PALETTE_H

#include <stdint.h>

typedef enum ost_colouring {
    OST_COLOUR_BONE,
    OST_COLOUR_CLASS,
    OST_COLOUR_DEPTH,
    OST_COLOUR_DENSITY,
    OST_COLOUR_COUNT, /* number of values that a user can select */
    /* colours by label; the voxels of the uncut bone then contain OST_LABEL_DENSITY + label instead of densities */
    OST_COLOUR_LABEL = OST_COLOUR_COUNT
} ost_colouring;

enum {
    OST_PAINTS = 256,
    /* first colour with lighting */
    OST_PAINT_LIT = 1,
    OST_PAINT_FLAT = 128,
    OST_SCALE = 127,        /* number of steps of a scale */
};

/* A tissue of the bone, determined by density and position. The first three are the default density classes, from
   soft to hard. */
typedef enum ost_tissue {
    OST_TISSUE_CARTILAGE,
    OST_TISSUE_CANCELLOUS,
    OST_TISSUE_CORTICAL,
    OST_TISSUE_PLATE,
    OST_TISSUES
} ost_tissue;
extern const char *const ost_tissue_names[OST_TISSUES];
extern const uint32_t ost_tissue_colours[OST_TISSUES]; /* 0xBBGGRR */

/*
 * Labels of the parts of a CT. Label 0 is a part that was omitted or cut away. Labels 1 to OST_LABELS - 2 have their
 * own colours, and all further labels share the last colour. The colours are distinguishable with every type of colour
 * blindness (Okabe and Ito 2008), on bone and on black.
 */
enum { OST_LABELS = 7, OST_LABEL_DENSITY = 1000 };
extern const uint32_t ost_label_colours[OST_LABELS]; /* 0xBBGGRR */
/* Returns the colour of a label, which must be at least 0. */
uint32_t ost_label_colour(int label);

/* Densities, in HU, that the CT window shows as black and as white; also the ends of the density scale. */
enum { OST_WINDOW_BLACK = -100, OST_WINDOW_WHITE = 1300 };

/* ost_scale_colour returns a colour of the scale, and ost_window_grey a grey of the CT window. Steps are 0 to 126. */
uint32_t ost_scale_colour(int step);
uint32_t ost_window_grey(int step);
/* Returns the step, 0 .. 126, for a density in HU. */
int ost_window_step(int density);

/* Fills the palette of a colouring. Entry 0 is unused, because paint 0 is the object's own colour. */
void ost_palette_make(ost_colouring colouring, uint32_t palette[OST_PAINTS]);

#endif
