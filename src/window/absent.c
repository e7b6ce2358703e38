/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the functions of window.h in a build without GLFW, in which no window can be opened. */
#include "window/window.h"

const char *ost_window_missing(void)
{
    return "no window, osteon sim runs --headless only; install libglfw3-dev and libepoxy-dev and build again";
}

ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err)
{
    (void)title;
    (void)width;
    (void)height;
    *out = NULL;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "osteon was built without a window; Debian: install libglfw3-dev and libepoxy-dev and build "
                    "again, or use --headless");
}

void ost_window_close(ost_window *window)
{
    (void)window;
}

ost_window_info ost_window_info_get(const ost_window *window)
{
    (void)window;
    return (ost_window_info){.renderer = "", .version = ""};
}

void ost_window_size(const ost_window *window, int *width, int *height, double *scale)
{
    (void)window;
    *width = *height = 0;
    *scale = 1;
}

bool ost_window_closing(const ost_window *window)
{
    (void)window;
    return true;
}

void ost_window_full_screen(ost_window *window, bool on)
{
    (void)window;
    (void)on;
}

bool ost_window_is_full_screen(const ost_window *window)
{
    (void)window;
    return false;
}

void ost_window_title(ost_window *window, const char *title)
{
    (void)window;
    (void)title;
}

void ost_window_poll(ost_window *window, double timeout_s)
{
    (void)window;
    (void)timeout_s;
}

bool ost_window_next(ost_window *window, ost_window_event *out)
{
    (void)window;
    (void)out;
    return false;
}

ost_status ost_window_check(const ost_window *window, ost_error *err)
{
    (void)window;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without a window");
}

bool ost_window_damaged(const ost_window *window)
{
    (void)window;
    return false;
}

ost_status ost_window_present(ost_window *window, const ost_window_picture *picture, bool sync, ost_error *err)
{
    (void)window;
    (void)picture;
    (void)sync;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without a window");
}

bool ost_window_can_be_drawn(const ost_window *window, int width, int height)
{
    (void)window;
    (void)width;
    (void)height;
    return false;
}

ost_status ost_window_show_drawn(ost_window *window, bool sync, ost_error *err)
{
    (void)window;
    (void)sync;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "osteon was built without a window");
}
