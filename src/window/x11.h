/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prevents the process from ending when the X server or the window is gone. By default, libX11 ends
 * the process in this case, and an operation in progress would be lost instead of being completed.
 *
 * The program is not linked with libX11. GLFW loads libX11; if libX11 is loaded, its functions are
 * looked up by name. Since libX11 1.7, a program can continue without a server.
 */
#ifndef OST_WINDOW_X11_H
#define OST_WINDOW_X11_H

typedef enum ost_x11_state { OST_X11_FINE, OST_X11_NO_SERVER, OST_X11_NO_WINDOW } ost_x11_state;

/* Installs the handlers for a GLFW window. The program must have no other GLFW window. */
void ost_x11_outlive(void *glfw_window);
/* Returns the state of the connection. Once the state differs from OST_X11_FINE, it never becomes
   OST_X11_FINE again, and no function of GLFW may be called. */
ost_x11_state ost_x11_state_get(void);
/* Records that the server or the window is gone. Called by code that detects this without libX11. */
void ost_x11_lost(ost_x11_state how);

#endif
