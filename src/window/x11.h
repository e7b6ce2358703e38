/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prevents the process from ending when the X server or the window is gone. By default, libX11 ends
 * the process in this case, and an operation in progress would be lost instead of being completed.
 *
 * The program does not link libX11, which GLFW loads; if it is loaded, its functions are looked up
 * by name. Since libX11 1.7, a program can continue without a server.
 */
#ifndef OST_WINDOW_X11_H
#define OST_WINDOW_X11_H

typedef enum ost_x11_state { OST_X11_FINE, OST_X11_NO_SERVER, OST_X11_NO_WINDOW } ost_x11_state;

/* Installs the handlers for this GLFW window, which must be the only one. */
void ost_x11_outlive(void *glfw_window);
/* Returns the state. It never returns to OST_X11_FINE. In any other state, no function of GLFW may be called. */
ost_x11_state ost_x11_state_get(void);
/* Records that the server or the window is gone. Called by code that does not use libX11. */
void ost_x11_lost(ost_x11_state how);

#endif
