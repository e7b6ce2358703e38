/* SPDX-License-Identifier: Apache-2.0 */
#include "window/window.h"

#include <stdlib.h>
#include <string.h>

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

enum { EVENTS = 256 };

struct ost_window {
    GLFWwindow *handle;
    GLuint program, texture, nothing; /* nothing: a vertex array, which a core profile asks for */
    int texture_width, texture_height;
    bool synced, sync_set;
    ost_window_event event[EVENTS]; /* a ring; what comes when it is full is forgotten */
    int first, count;
    unsigned mods;
    int normal[4]; /* place and size before full screen */
    bool full;
    char renderer[128], version[64];
};

const char *ost_window_missing(void)
{
    return NULL;
}

/* ------------------------------------------------------------------ events */

static void add(ost_window *w, ost_window_event event)
{
    /* Moves in a row are one. */
    if (event.kind == OST_WINDOW_MOVE && w->count) {
        ost_window_event *last = &w->event[(w->first + w->count - 1) % EVENTS];
        if (last->kind == OST_WINDOW_MOVE) {
            *last = event;
            return;
        }
    }
    if (w->count < EVENTS)
        w->event[(w->first + w->count++) % EVENTS] = event;
}

static unsigned mods_of(int mods)
{
    return (mods & GLFW_MOD_SHIFT ? OST_WINDOW_SHIFT : 0u) | (mods & GLFW_MOD_CONTROL ? OST_WINDOW_CONTROL : 0u) |
           (mods & GLFW_MOD_ALT ? OST_WINDOW_ALT : 0u);
}

static int key_of(int key)
{
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12)
        return OST_KEY_F1 + key - GLFW_KEY_F1;
    switch (key) {
    case GLFW_KEY_ESCAPE: return OST_KEY_ESCAPE;
    case GLFW_KEY_ENTER: case GLFW_KEY_KP_ENTER: return OST_KEY_ENTER;
    case GLFW_KEY_TAB: return OST_KEY_TAB;
    case GLFW_KEY_LEFT: return OST_KEY_LEFT;
    case GLFW_KEY_RIGHT: return OST_KEY_RIGHT;
    case GLFW_KEY_UP: return OST_KEY_UP;
    case GLFW_KEY_DOWN: return OST_KEY_DOWN;
    case GLFW_KEY_HOME: return OST_KEY_HOME;
    case GLFW_KEY_PAGE_UP: return OST_KEY_PAGE_UP;
    case GLFW_KEY_PAGE_DOWN: return OST_KEY_PAGE_DOWN;
    case GLFW_KEY_EQUAL: case GLFW_KEY_KP_ADD: return OST_KEY_PLUS;
    case GLFW_KEY_MINUS: case GLFW_KEY_KP_SUBTRACT: return OST_KEY_MINUS;
    default: return key > 0 && key < 256 ? key : 0;
    }
}

static void on_key(GLFWwindow *handle, int key, int scancode, int action, int mods)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    (void)scancode;
    w->mods = mods_of(mods);
    /* A modifier's own key comes with the state before it. */
    if (key == GLFW_KEY_LEFT_SHIFT || key == GLFW_KEY_RIGHT_SHIFT)
        w->mods = action == GLFW_RELEASE ? w->mods & ~(unsigned)OST_WINDOW_SHIFT : w->mods | OST_WINDOW_SHIFT;
    if (key == GLFW_KEY_LEFT_CONTROL || key == GLFW_KEY_RIGHT_CONTROL)
        w->mods = action == GLFW_RELEASE ? w->mods & ~(unsigned)OST_WINDOW_CONTROL : w->mods | OST_WINDOW_CONTROL;
    if (action != GLFW_REPEAT)
        add(w, (ost_window_event){.kind = OST_WINDOW_KEY, .key = key_of(key), .pressed = action == GLFW_PRESS, .mods = w->mods});
}

static void on_button(GLFWwindow *handle, int button, int action, int mods)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    w->mods = mods_of(mods);
    add(w, (ost_window_event){.kind = OST_WINDOW_BUTTON, .button = button, .pressed = action == GLFW_PRESS, .mods = w->mods});
}

/* Coordinates of a window and pixels of its frame differ on some systems. */
static void on_move(GLFWwindow *handle, double x, double y)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    int window_width, window_height, width, height;
    glfwGetWindowSize(handle, &window_width, &window_height);
    glfwGetFramebufferSize(handle, &width, &height);
    const double sx = window_width > 0 ? (double)width / window_width : 1, sy = window_height > 0 ? (double)height / window_height : 1;
    add(w, (ost_window_event){.kind = OST_WINDOW_MOVE, .x = x * sx, .y = y * sy, .mods = w->mods});
}

static void on_wheel(GLFWwindow *handle, double x, double y)
{
    ost_window *w = glfwGetWindowUserPointer(handle);
    /* Some systems turn the wheel to the side while shift is down. */
    add(w, (ost_window_event){.kind = OST_WINDOW_WHEEL, .y = y != 0 ? y : x, .mods = w->mods});
}

void ost_window_poll(ost_window *window, double timeout_s)
{
    (void)window;
    if (timeout_s > 0)
        glfwWaitEventsTimeout(timeout_s);
    else
        glfwPollEvents();
}

bool ost_window_next(ost_window *window, ost_window_event *out)
{
    if (!window->count)
        return false;
    *out = window->event[window->first];
    window->first = (window->first + 1) % EVENTS;
    window->count--;
    return true;
}

/* ---------------------------------------------------------------- open, GL */

static GLuint shader(GLenum kind, const char *text)
{
    const GLuint s = glCreateShader(kind);
    GLint compiled = 0;
    glShaderSource(s, 1, &text, NULL);
    glCompileShader(s);
    glGetShaderiv(s, GL_COMPILE_STATUS, &compiled);
    if (compiled)
        return s;
    glDeleteShader(s);
    return 0;
}

static bool make_program(ost_window *w)
{
    static const char vertex[] = "#version 330 core\n"
                                 "out vec2 at;\n"
                                 "void main() {\n"
                                 "    vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);\n"
                                 "    at = vec2(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y);\n"
                                 "    gl_Position = vec4(p, 0.0, 1.0);\n"
                                 "}\n";
    static const char fragment[] = "#version 330 core\n"
                                   "in vec2 at;\n"
                                   "out vec4 colour;\n"
                                   "uniform sampler2D picture;\n"
                                   "void main() { colour = vec4(texture(picture, at).rgb, 1.0); }\n";
    const GLuint v = shader(GL_VERTEX_SHADER, vertex), f = shader(GL_FRAGMENT_SHADER, fragment);
    GLint linked = 0;
    if (v && f) {
        w->program = glCreateProgram();
        glAttachShader(w->program, v);
        glAttachShader(w->program, f);
        glLinkProgram(w->program);
        glGetProgramiv(w->program, GL_LINK_STATUS, &linked);
    }
    if (v)
        glDeleteShader(v);
    if (f)
        glDeleteShader(f);
    glGenVertexArrays(1, &w->nothing);
    glGenTextures(1, &w->texture);
    glBindTexture(GL_TEXTURE_2D, w->texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return linked != 0;
}

static void describe(char *out, size_t size, GLenum name)
{
    const char *text = (const char *)glGetString(name);
    const size_t length = text ? strlen(text) : 0, used = length < size - 1 ? length : size - 1;
    if (used)
        memcpy(out, text, used);
    out[used] = '\0';
}

static ost_status no_window(ost_error *err)
{
    const char *why = NULL;
    glfwGetError(&why);
    return ost_fail(err, OST_ERR_UNAVAILABLE, "no window could be opened: %.300s; --headless runs without one", why ? why : "the system does not say why");
}

static bool is_set(const char *variable)
{
    const char *value = getenv(variable);
    return value && *value;
}

/* What is asked for a display that nobody named may write to standard error by itself, as libwayland does. */
static ost_status begin(ost_error *err)
{
    const bool wayland = is_set("WAYLAND_DISPLAY");
    if (!wayland && !is_set("DISPLAY"))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "there is no display to open a window on (DISPLAY is not set); --headless runs without one");
#ifdef GLFW_PLATFORM /* from 3.4 on; before it a build has one platform */
    if (!wayland)
        glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    return glfwInit() ? OST_OK : no_window(err);
}

static ost_status make(ost_window *w, const char *title, int width, int height, ost_error *err)
{
    const ost_status status = begin(err);
    if (status != OST_OK)
        return status;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    w->handle = glfwCreateWindow(width, height, title, NULL, NULL);
    if (!w->handle)
        return no_window(err);
    glfwMakeContextCurrent(w->handle);
    describe(w->renderer, sizeof w->renderer, GL_RENDERER);
    describe(w->version, sizeof w->version, GL_VERSION);
    if (epoxy_gl_version() < 33 || !make_program(w))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "a window needs OpenGL 3.3; here is %s (%s); --headless runs without one", w->version, w->renderer);
    glfwSetWindowUserPointer(w->handle, w);
    glfwSetKeyCallback(w->handle, on_key);
    glfwSetMouseButtonCallback(w->handle, on_button);
    glfwSetCursorPosCallback(w->handle, on_move);
    glfwSetScrollCallback(w->handle, on_wheel);
    glfwSetWindowSizeLimits(w->handle, 320, 200, GLFW_DONT_CARE, GLFW_DONT_CARE);
    return OST_OK;
}

ost_status ost_window_open(const char *title, int width, int height, ost_window **out, ost_error *err)
{
    *out = NULL;
    ost_window *w = calloc(1, sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a window");
    ost_status status = make(w, title, width, height, err);
    if (status != OST_OK) {
        ost_window_close(w);
        return status;
    }
    *out = w;
    return OST_OK;
}

void ost_window_close(ost_window *window)
{
    if (!window)
        return;
    if (window->handle) {
        if (window->program)
            glDeleteProgram(window->program);
        if (window->texture)
            glDeleteTextures(1, &window->texture);
        if (window->nothing)
            glDeleteVertexArrays(1, &window->nothing);
        glfwDestroyWindow(window->handle);
    }
    glfwTerminate();
    free(window);
}

ost_window_info ost_window_info_get(const ost_window *window)
{
    static const char *const software[] = {"llvmpipe", "softpipe", "SWR", "swrast", "Software Rasterizer"};
    ost_window_info info = {.renderer = window->renderer, .version = window->version};
    for (size_t i = 0; i < sizeof software / sizeof *software; i++)
        info.software = info.software || strstr(window->renderer, software[i]);
    return info;
}

/* ----------------------------------------------------------------- the rest */

void ost_window_size(const ost_window *window, int *width, int *height, double *scale)
{
    float x = 1, y = 1;
    glfwGetFramebufferSize(window->handle, width, height);
    if (glfwGetWindowAttrib(window->handle, GLFW_ICONIFIED))
        *width = *height = 0;
    glfwGetWindowContentScale(window->handle, &x, &y);
    *scale = y > 0.5f && y < 8 ? (double)y : 1;
}

bool ost_window_closing(const ost_window *window)
{
    return glfwWindowShouldClose(window->handle);
}

bool ost_window_is_full_screen(const ost_window *window)
{
    return window->full;
}

void ost_window_full_screen(ost_window *window, bool on)
{
    GLFWmonitor *monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode *mode = monitor ? glfwGetVideoMode(monitor) : NULL;
    int *n = window->normal;
    if (on == window->full || !mode)
        return;
    if (on) {
        glfwGetWindowPos(window->handle, &n[0], &n[1]);
        glfwGetWindowSize(window->handle, &n[2], &n[3]);
        glfwSetWindowMonitor(window->handle, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    } else {
        glfwSetWindowMonitor(window->handle, NULL, n[0], n[1], n[2], n[3], 0);
    }
    window->full = on;
}

void ost_window_title(ost_window *window, const char *title)
{
    glfwSetWindowTitle(window->handle, title);
}

void ost_window_present(ost_window *window, const uint32_t *pixels, int stride, int width, int height, bool sync)
{
    if (!window->sync_set || window->synced != sync) {
        glfwSwapInterval(sync);
        window->synced = sync;
        window->sync_set = true;
    }
    glViewport(0, 0, width, height);
    glBindTexture(GL_TEXTURE_2D, window->texture);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, stride);
    if (width != window->texture_width || height != window->texture_height) {
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
        window->texture_width = width;
        window->texture_height = height;
    } else {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    }
    glUseProgram(window->program);
    glBindVertexArray(window->nothing);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glfwSwapBuffers(window->handle);
}
