/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Manages the GLFW window: opens it, presents pictures, and recreates it.
 *
 * Three events can end a window during an operation, but must not end the program: a reset of the driver, the loss of
 * the X server, and the destruction of the window by another program (x11.h). After a reset, all OpenGL objects must be
 * recreated, which with GLFW requires a new window.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "window/glfw_window.h"
#include "window/x11.h"

static const int64_t RESETS_WITHIN_NS = 10000000000;

const char *ost_window_missing(void)
{
    return NULL;
}

/* ---------------------------------------------------------------- open, GL */

static void describe(char *out, size_t size, GLenum name)
{
    const char *text = (const char *)glGetString(name);
    snprintf(out, size, "%s", text ? text : "");
}

static ost_status no_window(ost_error *err)
{
    const char *why = NULL;
    glfwGetError(&why);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot open a window: %.300s; pass --headless to run without a window",
                    why ? why : "unknown reason");
}

static ost_status too_old(const ost_window *w, ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "a window needs OpenGL 3.3, found %s (%s); install a newer driver, set LIBGL_ALWAYS_SOFTWARE=1 "
                    "or pass --headless", w->version[0] ? w->version : "none",
                    w->renderer[0] ? w->renderer : "no renderer");
}

static bool is_set(const char *variable)
{
    const char *value = getenv(variable);
    return value && *value;
}

/*
 * Initializes GLFW if the environment names a display. Otherwise fails without calling GLFW, because without a display
 * libraries such as libwayland may write to standard error.
 */
static ost_status begin(ost_error *err)
{
    const bool wayland = is_set("WAYLAND_DISPLAY");
    if (!wayland && !is_set("DISPLAY"))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "cannot open a window: DISPLAY is not set; pass --headless to run without a window");
#ifdef GLFW_PLATFORM /* defined by GLFW 3.4 and later; an earlier version supports only the platform it was built for */
    if (!wayland)
        glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    return glfwInit() ? OST_OK : no_window(err);
}

static bool create(ost_window *w, int width, int height, int major, int minor)
{
    glfwDefaultWindowHints();
    if (major) {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
        glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    } else {
        glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    }
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    w->handle = glfwCreateWindow(width, height, w->title, NULL, NULL);
    if (!w->handle)
        return false;
    glfwMakeContextCurrent(w->handle);
    describe(w->renderer, sizeof w->renderer, GL_RENDERER);
    describe(w->version, sizeof w->version, GL_VERSION);
    return true;
}

/*
 * Creates a window with the newest supported OpenGL version that is at least 3.3. If there is none, opens a
 * window with any OpenGL version, only to report this version in the error message.
 */
static ost_status create_newest(ost_window *w, int width, int height, ost_error *err)
{
    const char *why = NULL;
    if (create(w, width, height, 4, 4) || create(w, width, height, 3, 3))
        return epoxy_gl_version() >= 33 ? OST_OK : too_old(w, err);
    if (glfwGetError(&why) != GLFW_VERSION_UNAVAILABLE && why) {
        ost_fail(err, OST_ERR_UNAVAILABLE, "cannot open a window: %.300s; pass --headless to run without a window",
                 why);
        if (!create(w, 64, 64, 0, 0) || epoxy_gl_version() >= 33)
            return OST_ERR_UNAVAILABLE; /* the window failed for a reason other than the OpenGL version */
        return too_old(w, err);
    }
    create(w, 64, 64, 0, 0);
    return too_old(w, err);
}

static void learn(ost_window *w)
{
    GLint side = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    w->side = side >= 1024 ? side : 1024; /* OpenGL 3.3 guarantees at least 1024, so smaller values are ignored */
    w->reset_notification = epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness") ? BY_KHR
                     : epoxy_has_gl_extension("GL_ARB_robustness")                         ? BY_ARB
                                                                                           : NO_NOTIFICATION;
    w->sync_set = false;
}

static ost_status make(ost_window *w, int width, int height, ost_error *err)
{
    ost_status status = create_newest(w, width, height, err);
    if (status != OST_OK)
        return status;
    ost_x11_outlive(w->handle);
    if (!ost_shown_make(&w->shown))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "OpenGL %s (%s) cannot run the window's program; pass --headless to run without a window",
                        w->version, w->renderer);
    learn(w);
    w->shm = ost_window_info_get(w).software ? ost_shm_open(w->handle) : NULL;
    ost_window_listen(w);
    glfwSetWindowSizeLimits(w->handle, 160, 120, GLFW_DONT_CARE, GLFW_DONT_CARE);
    return OST_OK;
}

ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err)
{
    *out = NULL;
    ost_window *w = calloc(1, sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a window");
    snprintf(w->title, sizeof w->title, "%s", title);
    ost_status status = begin(err);
    if (status == OST_OK)
        status = make(w, width, height, err);
    if (status != OST_OK) {
        ost_window_close(w);
        return status;
    }
    *out = w;
    return OST_OK;
}

/* Closes the window. Calls no GLFW function if the display is gone. */
void ost_window_close(ost_window *window)
{
    if (!window)
        return;
    ost_shm_close(window->shm);
    if (ost_x11_state_get() == OST_X11_FINE) {
        if (window->handle) {
            ost_shown_free(&window->shown);
            glfwDestroyWindow(window->handle);
        }
        glfwTerminate();
    }
    free(window);
}

ost_window_info ost_window_info_get(const ost_window *window)
{
    static const char *const software[] = {"llvmpipe", "softpipe", "SWR", "swrast", "Software Rasterizer"};
    ost_window_info info = {.renderer = window->renderer,
                            .version = window->version,
                            .robust = window->reset_notification != NO_NOTIFICATION,
                            .resets = window->resets};
    for (size_t i = 0; i < sizeof software / sizeof *software; i++)
        info.software = info.software || strstr(window->renderer, software[i]);
    return info;
}

/* ---------------------------------------------------------- other functions */

bool ost_window_closing(const ost_window *window)
{
    return !ost_window_lives(window) || glfwWindowShouldClose(window->handle);
}

bool ost_window_is_full_screen(const ost_window *window)
{
    return ost_window_lives(window) && glfwGetWindowMonitor(window->handle) != NULL;
}

/* Returns the screen that contains most of the window. */
static GLFWmonitor *screen_of(const ost_window *w)
{
    int count = 0, x, y;
    GLFWmonitor **all = glfwGetMonitors(&count), *best = glfwGetPrimaryMonitor();
    int64_t most = 0;
    glfwGetWindowPos(w->handle, &x, &y);
    for (int i = 0; i < count; i++) {
        int left, top;
        const GLFWvidmode *mode = glfwGetVideoMode(all[i]);
        glfwGetMonitorPos(all[i], &left, &top);
        if (!mode)
            continue;
        const int64_t x0 = x > left ? x : left,
                      x1 = x + w->width < left + mode->width ? x + w->width : left + mode->width;
        const int64_t y0 = y > top ? y : top,
                      y1 = y + w->height < top + mode->height ? y + w->height : top + mode->height;
        if (x1 > x0 && y1 > y0 && (x1 - x0) * (y1 - y0) > most) {
            most = (x1 - x0) * (y1 - y0);
            best = all[i];
        }
    }
    return best;
}

void ost_window_full_screen(ost_window *window, bool on)
{
    int *n = window->normal;
    if (!ost_window_lives(window) || on == ost_window_is_full_screen(window))
        return;
    if (on) {
        GLFWmonitor *monitor = screen_of(window);
        const GLFWvidmode *mode = monitor ? glfwGetVideoMode(monitor) : NULL;
        if (!mode)
            return;
        glfwGetWindowPos(window->handle, &n[0], &n[1]);
        glfwGetWindowSize(window->handle, &n[2], &n[3]);
        glfwSetWindowMonitor(window->handle, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    } else {
        glfwSetWindowMonitor(window->handle, NULL, n[0], n[1], n[2] > 0 ? n[2] : 640, n[3] > 0 ? n[3] : 360, 0);
    }
}

void ost_window_title(ost_window *window, const char *title)
{
    snprintf(window->title, sizeof window->title, "%s", title);
    if (ost_window_lives(window))
        glfwSetWindowTitle(window->handle, window->title);
}

/* Recreates the window at the same position and size; a new OpenGL context requires a new window. */
static ost_status restart(ost_window *w, ost_error *err)
{
    int x, y;
    const int64_t now = ost_clock_ns();
    const bool full = ost_window_is_full_screen(w);
    const int width = full ? w->normal[2] : w->width, height = full ? w->normal[3] : w->height;
    int64_t *oldest = &w->reset_ns[w->resets % OST_WINDOW_RESETS];
    w->resets++;
    if (*oldest && now - *oldest < RESETS_WITHIN_NS)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "the graphics driver (%s) was reset %d times within %d s; pass "
                        "--headless to run without a window", w->renderer, OST_WINDOW_RESETS + 1,
                        (int)(RESETS_WITHIN_NS / 1000000000));
    *oldest = now;
    glfwGetWindowPos(w->handle, &x, &y);
    ost_shm_close(w->shm);
    w->shm = NULL;
    glfwDestroyWindow(w->handle);
    w->handle = NULL;
    w->shown = (ost_shown){0};
    w->spilt = true; /* releases of keys and buttons may have been missed */
    ost_status status = make(w, width > 0 ? width : 640, height > 0 ? height : 360, err);
    if (status != OST_OK)
        return ost_fail_context(err, "the graphics driver was reset");
    glfwSetWindowPos(w->handle, full ? w->normal[0] : x, full ? w->normal[1] : y);
    ost_window_full_screen(w, full);
    return OST_OK;
}

static ost_status gone(ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    ost_x11_state_get() == OST_X11_NO_SERVER ? "lost the connection to the display" :
                    "another program destroyed the window");
}

ost_status ost_window_check(const ost_window *window, ost_error *err)
{
    return ost_window_lives(window) ? OST_OK : gone(err);
}

static bool was_reset(const ost_window *w)
{
    return (w->reset_notification == BY_KHR && glGetGraphicsResetStatus() != GL_NO_ERROR) ||
           (w->reset_notification == BY_ARB && glGetGraphicsResetStatusARB() != GL_NO_ERROR);
}

/*
 * Presents the picture through shared memory. Returns false if OpenGL must present the picture instead, for example
 * because the picture must be scaled to the size of the window.
 */
static bool show_by_shm(ost_window *w, const ost_window_picture *picture, bool damaged)
{
    if (!w->shm)
        return false;
    const bool fits = picture->width == w->frame_width && picture->height == w->frame_height;
    if (damaged || !fits)
        ost_shm_forget(w->shm);
    if (!fits)
        return false;
    if (ost_shm_present(w->shm, picture))
        return true;
    ost_shm_close(w->shm);
    w->shm = NULL;
    return false;
}

static void set_sync(ost_window *w, bool sync)
{
    if (w->sync_set && w->synced == sync)
        return;
    glfwSwapInterval(sync);
    w->synced = sync;
    w->sync_set = true;
}

bool ost_window_can_be_drawn(const ost_window *window, int width, int height)
{
    return ost_window_lives(window) && !ost_window_info_get(window).software && width == window->frame_width &&
           height == window->frame_height;
}

ost_status ost_window_show_drawn(ost_window *window, bool sync, ost_error *err)
{
    if (!ost_window_lives(window))
        return gone(err);
    if (was_reset(window))
        return restart(window, err);
    set_sync(window, sync);
    window->damaged = false;
    glfwSwapBuffers(window->handle);
    return ost_window_lives(window) ? OST_OK : gone(err);
}

ost_status ost_window_present(ost_window *window, const ost_window_picture *picture, bool sync, ost_error *err)
{
    const int width = picture->width, height = picture->height;
    if (!ost_window_lives(window))
        return gone(err);
    if (was_reset(window))
        return restart(window, err);
    set_sync(window, sync);
    const bool damaged = window->damaged;
    window->damaged = false;
    const bool shown = show_by_shm(window, picture, damaged);
    if (!ost_window_lives(window))
        return gone(err);
    if (shown)
        return OST_OK;
    if (!ost_shown_draw(&window->shown, picture->pixels, picture->stride, width, height, window->frame_width,
                        window->frame_height))
        return was_reset(window) ? restart(window, err)
                                 : ost_fail(err, OST_ERR_UNAVAILABLE,
                                            "OpenGL (%s): out of memory for a picture of %d x %d pixels",
                                            window->renderer, width, height);
    glfwSwapBuffers(window->handle);
    return ost_window_lives(window) ? OST_OK : gone(err);
}
