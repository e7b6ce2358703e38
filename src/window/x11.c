/* SPDX-License-Identifier: Apache-2.0 */
#include "window/x11.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

enum { BAD_WINDOW = 3, BAD_DRAWABLE = 9 };

/* Must have the layout of XErrorEvent, which is part of libX11's binary interface. */
typedef struct x11_error {
    int type;
    void *display;
    unsigned long resource, serial;
    unsigned char code, request, minor;
} x11_error;

typedef struct x11 {
    void *(*display)(void);
    unsigned long (*window)(void *);
    void *(*set_error)(int (*)(void *, x11_error *));
    void *(*set_io_error)(int (*)(void *));
    void (*set_exit)(void *, void (*)(void *, void *), void *);
} x11;

static ost_x11_state state;
static unsigned long ours;

static int on_error(void *display, x11_error *error)
{
    (void)display;
    if (error->resource == ours && (error->code == BAD_WINDOW || error->code == BAD_DRAWABLE) && state == OST_X11_FINE)
        state = OST_X11_NO_WINDOW;
    return 0;
}

/* Prints nothing, unlike libX11's default handler, because the caller of ost_x11_state_get reports the error. */
static int on_io_error(void *display)
{
    (void)display;
    state = OST_X11_NO_SERVER;
    return 0;
}

static void on_exit_wish(void *display, void *user)
{
    (void)display;
    (void)user;
}

static bool find(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

void ost_x11_outlive(void *glfw_window)
{
    x11 x;
    void *library = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD), *display = NULL;
    state = OST_X11_FINE;
    if (!library)
        return;
    if (find(RTLD_DEFAULT, "glfwGetX11Display", &x.display) && find(RTLD_DEFAULT, "glfwGetX11Window", &x.window) &&
        find(library, "XSetErrorHandler", &x.set_error) && (display = x.display()) != NULL) {
        ours = x.window(glfw_window);
        x.set_error(on_error);
        if (find(library, "XSetIOErrorHandler", &x.set_io_error) &&
            find(library, "XSetIOErrorExitHandler", &x.set_exit)) {
            x.set_io_error(on_io_error);
            x.set_exit(display, on_exit_wish, NULL);
        }
    }
    dlclose(library);
}

ost_x11_state ost_x11_state_get(void)
{
    return state;
}

void ost_x11_lost(ost_x11_state how)
{
    if (state == OST_X11_FINE)
        state = how;
}
