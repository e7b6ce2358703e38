/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Copies a picture over the previous one in memory, and finds boxes around the pixels that differ.
 *
 *   picture --red and blue swapped--> equal to the stored pixels? --no--> shared memory, boxes --> X server
 *
 * Usually only a small part of a picture changes from frame to frame: the tool and its surroundings. Only cells that
 * may have changed are compared. Comparing a cell takes as long as writing it, but later steps, such as the server's
 * copy, take less time if the boxes are small.
 */
#ifndef OST_WINDOW_CHANGED_H
#define OST_WINDOW_CHANGED_H

#include <stdbool.h>
#include <stdint.h>

#include "window/window.h"

enum { OST_CHANGED_BOXES = 32 };
typedef struct ost_changed_box {
    int x, y, width, height;
} ost_changed_box;

/*
 * Copies the picture and returns the number of boxes, which do not overlap. `shared` receives pixels 0x00RRGGBB in rows
 * of the picture's width. If `shared` does not contain the previous picture, `everything` must be true, so that all
 * pixels are written.
 */
int ost_changed_copy(const ost_window_picture *picture, bool everything, uint32_t *shared,
                     ost_changed_box box[OST_CHANGED_BOXES]);

#endif
