/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prevents libX11 from ending the process when the X server or the window is gone, so that an operation in progress can
 * be completed.
 *
 * The program is not linked with libX11. If GLFW has loaded libX11, the functions are looked up by name. Since libX11
 * 1.7, a program can continue without a server.
 */
#ifndef OST_WINDOW_X11_H
#define OST_WINDOW_X11_H

typedef enum ost_x11_state { OST_X11_FINE, OST_X11_NO_SERVER, OST_X11_NO_WINDOW } ost_x11_state;

/* Installs the handlers for a GLFW window, which must be the program's only window. */
void ost_x11_outlive(void *glfw_window);
/* Returns the state of the connection. Once it differs from OST_X11_FINE, it never becomes OST_X11_FINE again, and
   no GLFW function may be called. */
ost_x11_state ost_x11_state_get(void);
/* Records that the server or the window is gone. Called by code that detects this without the help of libX11. */
void ost_x11_lost(ost_x11_state how);

#endif
