/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pixels into an X window through memory that the server shares (MIT-SHM).
 *
 *   colours --what differs (changed.h)--> shared memory --server copies the boxes--> window
 *
 * Where OpenGL is software it draws the finished picture once more, pixel by
 * pixel, to show it: a third of a frame's time on one core.  The X libraries
 * are GLFW's and the driver's affair: they are asked by name, and where
 * anything is otherwise than expected OpenGL shows the picture.
 *
 * By the thread of the window.
 */
#ifndef OST_WINDOW_SHM_H
#define OST_WINDOW_SHM_H

#include <stdbool.h>
#include <stdint.h>

#include "window/window.h"

typedef struct ost_shm ost_shm;

/* NULL where a window is not X11's, the server is another machine's, or its pixels are not eight bits of red, green, blue each. */
ost_shm *ost_shm_open(void *glfw_window);
/* The window itself may be gone. NULL is allowed. */
void ost_shm_close(ost_shm *shm);
/* The window has another picture now, or none: the next is shown whole. NULL is allowed. */
void ost_shm_forget(ost_shm *shm);
/* False: it was not shown, and this way never will be again. */
bool ost_shm_present(ost_shm *shm, const ost_window_picture *picture);

#endif
