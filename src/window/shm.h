/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Copies pixels to an X window through memory that is shared with the server (MIT-SHM).
 *
 *   colours --differences (changed.h)--> shared memory --server copies the boxes--> window
 *
 * A software implementation of OpenGL would draw the finished picture again, pixel by pixel. On one core, this takes a
 * third of a frame's time. The program is not linked with the X libraries: GLFW and the driver load them, and the
 * functions are looked up by name. If shared memory is not available, OpenGL shows the picture instead.
 *
 * All functions must be called on the window's thread.
 */
#ifndef OST_WINDOW_SHM_H
#define OST_WINDOW_SHM_H

#include <stdbool.h>
#include <stdint.h>

#include "window/window.h"

typedef struct ost_shm ost_shm;

/*
 * Opens the shared memory. Returns NULL if the window is not an X11 window, if the server is on another machine, or if
 * the window's pixels do not have eight bits each of red, green and blue.
 */
ost_shm *ost_shm_open(void *glfw_window);
/* Frees `shm`, which may be NULL. The window may already be destroyed. */
void ost_shm_close(ost_shm *shm);
/* Marks the contents of the window as unknown, so that the next picture is copied completely. `shm` may be NULL. */
void ost_shm_forget(ost_shm *shm);
/* Shows the picture. Returns false on failure; all later calls then fail too. */
bool ost_shm_present(ost_shm *shm, const ost_window_picture *picture);

#endif
