/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libX11 ends the process when its server goes away, and when a window that
 * it draws in was destroyed by somebody else.  An operation in progress is to
 * be ended, not lost.
 *
 * libX11 is GLFW's affair, so it is asked by name and only where it is loaded;
 * from its version 1.7 on a program can go on without a server.
 */
#ifndef OST_WINDOW_X11_H
#define OST_WINDOW_X11_H

typedef enum ost_x11_state { OST_X11_FINE, OST_X11_NO_SERVER, OST_X11_NO_WINDOW } ost_x11_state;

/* From now on, of this GLFW window, which is made and the only one. */
void ost_x11_outlive(void *glfw_window);
/* Once it is not fine it stays so: then GLFW is to be called no more. */
ost_x11_state ost_x11_state_get(void);
/* Who speaks to the server past libX11 found it, or the window, gone. */
void ost_x11_lost(ost_x11_state how);

#endif
