/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Keeps the process alive when the X server or the window is gone.  By default
 * libX11 then ends the process, and an operation in progress would be lost
 * instead of being completed.
 *
 * The program does not link libX11, which GLFW loads; its functions are looked
 * up by name if it is loaded.  Since libX11 1.7 a program can continue without
 * a server.
 */
#ifndef OST_WINDOW_X11_H
#define OST_WINDOW_X11_H

typedef enum ost_x11_state { OST_X11_FINE, OST_X11_NO_SERVER, OST_X11_NO_WINDOW } ost_x11_state;

/* Installs the handlers for this GLFW window, which must be the only one. */
void ost_x11_outlive(void *glfw_window);
/* Returns the state. It never returns to OST_X11_FINE; in any other state GLFW must not be called any more. */
ost_x11_state ost_x11_state_get(void);
/* Records that the server or the window is gone, as found by code that does not use libX11. */
void ost_x11_lost(ost_x11_state how);

#endif
