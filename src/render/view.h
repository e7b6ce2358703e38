/* SPDX-License-Identifier: Apache-2.0 */
/* Draws a view of a bone, or of the labelled parts of a CT, each in its own colour. */
#ifndef OST_RENDER_VIEW_H
#define OST_RENDER_VIEW_H

#include <osteon/picture.h>

/*
 * Draws a view as ost_picture_view does. If `labels` is true, the volume contains OST_LABEL_DENSITY + label in the
 * voxels of a part, and 0 elsewhere; ost_label_colour (points/palette.h) determines the colours of the labels. `unit`
 * is the size of a unit of the marks in pixels (marks.h); 0 means the size that fits the picture's height.
 */
ost_status ost_view_draw(const ost_volume *volume, bool labels, double unit, const ost_view_options *options,
                         ost_picture *out, ost_error *err);

#endif
