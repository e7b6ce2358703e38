/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture into memory that has the one before: what differs is written, and
 * boxes say where that is.
 *
 *   picture --order of red and blue--> is it there already? --no--> shared memory, boxes --> who copies them on
 *
 * From one frame to the next little of a picture changes, the tool and what is
 * about it: only where it may have is looked at.  To look costs what to write
 * would; what comes after, a server's copy for one, costs as much as there is
 * in the boxes.
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
 * shared: 0x00RRGGBB, rows of the picture's width. whole: it has no picture yet, or nobody knows which.
 * Returns how many boxes there are; they do not overlap.
 */
int ost_changed_copy(const ost_window_picture *picture, bool whole, uint32_t *shared, ost_changed_box box[OST_CHANGED_BOXES]);

#endif
