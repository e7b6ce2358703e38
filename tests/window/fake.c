/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulated GLFW and OpenGL of fake.h: one window, whose state a test sets and reads through `the_fake`.
 *
 * The file has more than 500 lines, because GLFW and OpenGL share the state of this window.
 */
#include "tests/window/fake.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

fake the_fake;

struct GLFWmonitor {
    int number;
};
static struct GLFWmonitor monitors[FAKE_MONITORS] = {{0}, {1}};

struct GLFWwindow {
    bool there, visible, minimised, closing;
    int x, y, width, height, version;
    void *user;
    GLFWmonitor *monitor;
    GLFWkeyfun key;
    GLFWmousebuttonfun button;
    GLFWcursorposfun move;
    GLFWscrollfun wheel;
    GLFWwindowsizefun size;
    GLFWframebuffersizefun frame_size;
    GLFWwindowcontentscalefun rescaled;
    GLFWwindowiconifyfun minimise;
    GLFWwindowrefreshfun damage;
};
static struct GLFWwindow the_window;
static GLenum gl_error;
static int error_code, major, minor, visible;

void fake_begin(void)
{
    the_fake = (fake){.renderer = "a fake",
                      .version = 45,
                      .plain_version = 45,
                      .khr = true,
                      .texture_side = 16384,
                      .scale = 1,
                      .frame_of_window = 1,
                      .clock_ns = 1000000000,
                      .mode = {{.width = 1920, .height = 1080, .refreshRate = 60},
                               {.width = 1280, .height = 1024, .refreshRate = 75}},
                      .monitor_x = {0, 1920}};
    the_window = (struct GLFWwindow){0};
}

/* The clock returns the time that the test has set. */
int clock_gettime(clockid_t clock, struct timespec *t)
{
    (void)clock;
    t->tv_sec = the_fake.clock_ns / 1000000000;
    t->tv_nsec = the_fake.clock_ns % 1000000000;
    return 0;
}

/* ------------------------------------------------------------------ events */

static void report_size(void)
{
    struct GLFWwindow *w = &the_window;
    if (w->size)
        w->size(w, w->width, w->height);
    if (w->frame_size)
        w->frame_size(w, w->width * the_fake.frame_of_window, w->height * the_fake.frame_of_window);
}

void fake_size(int width, int height)
{
    the_window.width = width;
    the_window.height = height;
    report_size();
}

void fake_minimise(bool on)
{
    the_window.minimised = on;
    the_window.minimise(&the_window, on);
}

void fake_hide(bool on)
{
    the_window.visible = !on;
}

void fake_damage(void)
{
    the_window.damage(&the_window);
}

void fake_rescale(float scale)
{
    the_fake.scale = scale;
    the_window.rescaled(&the_window, scale, scale);
}

void fake_close(void)
{
    the_window.closing = true;
}

void fake_key(int key, int action, int mods)
{
    the_window.key(&the_window, key, 0, action, mods);
}

void fake_button(int button, int action, int mods)
{
    the_window.button(&the_window, button, action, mods);
}

void fake_move(double x, double y)
{
    the_window.move(&the_window, x, y);
}

void fake_wheel(double x, double y)
{
    the_window.wheel(&the_window, x, y);
}

void fake_place(int x, int y)
{
    the_window.x = x;
    the_window.y = y;
}

void fake_unplug_monitor(void)
{
    the_window.monitor = NULL;
}

/* -------------------------------------------------------------------- GLFW */

int glfwInit(void)
{
    the_fake.inits += !the_fake.no_init;
    error_code = GLFW_PLATFORM_ERROR;
    return !the_fake.no_init;
}

void glfwTerminate(void)
{
    if (the_fake.inits)
        the_fake.inits--;
}

int glfwGetError(const char **description)
{
    const int code = error_code;
    if (description)
        *description = code ? the_fake.why : NULL;
    error_code = 0;
    return code;
}

void glfwDefaultWindowHints(void)
{
    major = 1;
    minor = 0;
    visible = 1;
}

void glfwWindowHint(int hint, int value)
{
    if (hint == GLFW_CONTEXT_VERSION_MAJOR)
        major = value;
    if (hint == GLFW_CONTEXT_VERSION_MINOR)
        minor = value;
    if (hint == GLFW_VISIBLE)
        visible = value;
    if (hint == GLFW_CONTEXT_ROBUSTNESS)
        the_fake.requested_robustness = value;
}

GLFWwindow *glfwCreateWindow(int width, int height, const char *title, GLFWmonitor *monitor, GLFWwindow *share)
{
    (void)monitor;
    (void)share;
    const int requested = 10 * major + minor, version = requested == 10 ? the_fake.plain_version : the_fake.version;
    if (the_window.there || the_fake.no_next || requested > version || version == 0) {
        error_code = the_fake.why ? GLFW_API_UNAVAILABLE : GLFW_VERSION_UNAVAILABLE;
        return NULL;
    }
    the_window = (struct GLFWwindow){
        .there = true, .visible = visible, .width = width, .height = height, .version = version};
    the_fake.requested_major = major;
    the_fake.requested_minor = minor;
    the_fake.windows++;
    the_fake.contexts++;
    the_fake.reset_in_upload = false;
    gl_error = GL_NO_ERROR;
    if (!the_fake.reset_stays)
        the_fake.reset = 0;
    snprintf(the_fake.title, sizeof the_fake.title, "%s", title);
    return &the_window;
}

void glfwDestroyWindow(GLFWwindow *w)
{
    w->there = false;
    the_fake.windows--;
    the_fake.objects = 0;
}

void glfwMakeContextCurrent(GLFWwindow *w)
{
    (void)w;
}

void glfwSetWindowUserPointer(GLFWwindow *w, void *user)
{
    w->user = user;
}

void *glfwGetWindowUserPointer(GLFWwindow *w)
{
    return w->user;
}

#define SETTER(name, type, field) \
    type name(GLFWwindow *w, type f) \
    { \
        w->field = f; \
        return NULL; \
    }
SETTER(glfwSetKeyCallback, GLFWkeyfun, key)
SETTER(glfwSetMouseButtonCallback, GLFWmousebuttonfun, button)
SETTER(glfwSetCursorPosCallback, GLFWcursorposfun, move)
SETTER(glfwSetScrollCallback, GLFWscrollfun, wheel)
SETTER(glfwSetWindowSizeCallback, GLFWwindowsizefun, size)
SETTER(glfwSetFramebufferSizeCallback, GLFWframebuffersizefun, frame_size)
SETTER(glfwSetWindowContentScaleCallback, GLFWwindowcontentscalefun, rescaled)
SETTER(glfwSetWindowIconifyCallback, GLFWwindowiconifyfun, minimise)
SETTER(glfwSetWindowRefreshCallback, GLFWwindowrefreshfun, damage)

void glfwGetWindowSize(GLFWwindow *w, int *width, int *height)
{
    *width = w->width;
    *height = w->height;
}

void glfwGetFramebufferSize(GLFWwindow *w, int *width, int *height)
{
    *width = w->width * the_fake.frame_of_window;
    *height = w->height * the_fake.frame_of_window;
}

void glfwGetWindowContentScale(GLFWwindow *w, float *x, float *y)
{
    (void)w;
    *x = *y = the_fake.scale;
}

int glfwGetWindowAttrib(GLFWwindow *w, int attribute)
{
    return attribute == GLFW_VISIBLE ? w->visible : attribute == GLFW_ICONIFIED ? w->minimised : 0;
}

void glfwSetWindowSizeLimits(GLFWwindow *w, int a, int b, int c, int d)
{
    (void)w;
    (void)a;
    (void)b;
    (void)c;
    (void)d;
}

void glfwWaitEventsTimeout(double timeout)
{
    the_fake.waited = true;
    the_fake.clock_ns += (int64_t)(timeout * 1e9);
}

void glfwPollEvents(void)
{
    the_fake.polls++;
}

int glfwWindowShouldClose(GLFWwindow *w)
{
    return w->closing;
}

GLFWmonitor *glfwGetWindowMonitor(GLFWwindow *w)
{
    return w->monitor;
}

GLFWmonitor **glfwGetMonitors(int *count)
{
    static GLFWmonitor *all[FAKE_MONITORS] = {&monitors[0], &monitors[1]};
    *count = the_fake.no_monitor ? 0 : FAKE_MONITORS;
    return the_fake.no_monitor ? NULL : all;
}

GLFWmonitor *glfwGetPrimaryMonitor(void)
{
    return the_fake.no_monitor ? NULL : &monitors[0];
}

const GLFWvidmode *glfwGetVideoMode(GLFWmonitor *monitor)
{
    return &the_fake.mode[monitor->number];
}

void glfwGetMonitorPos(GLFWmonitor *monitor, int *x, int *y)
{
    *x = the_fake.monitor_x[monitor->number];
    *y = 0;
}

void glfwGetWindowPos(GLFWwindow *w, int *x, int *y)
{
    *x = w->x;
    *y = w->y;
}

void glfwSetWindowPos(GLFWwindow *w, int x, int y)
{
    w->x = x;
    w->y = y;
}

void glfwSetWindowMonitor(GLFWwindow *w, GLFWmonitor *monitor, int x, int y, int width, int height, int rate)
{
    (void)rate;
    w->monitor = monitor;
    w->x = monitor ? the_fake.monitor_x[monitor->number] : x;
    w->y = y;
    w->width = width;
    w->height = height;
    report_size();
}

void glfwSetWindowTitle(GLFWwindow *w, const char *title)
{
    (void)w;
    snprintf(the_fake.title, sizeof the_fake.title, "%s", title);
}

void glfwSwapInterval(int interval)
{
    the_fake.swap_interval = interval;
}

void glfwSwapBuffers(GLFWwindow *w)
{
    (void)w;
    the_fake.frames++;
}

#ifdef GLFW_PLATFORM
void glfwInitHint(int hint, int value)
{
    (void)hint;
    (void)value;
}
#endif

/* ------------------------------------------------------------------ OpenGL */

int epoxy_gl_version(void)
{
    return the_window.version;
}

bool epoxy_has_gl_extension(const char *name)
{
    return strcmp(name, "GL_KHR_robustness") == 0   ? the_fake.khr
           : strcmp(name, "GL_ARB_robustness") == 0 ? the_fake.arb
                                                    : false;
}

static const GLubyte *get_string(GLenum name)
{
    static char version[32];
    snprintf(version, sizeof version, "%d.%d of a test", the_window.version / 10, the_window.version % 10);
    return (const GLubyte *)(name == GL_RENDERER ? the_fake.renderer : version);
}

static void get_integer(GLenum name, GLint *value)
{
    *value = name == GL_MAX_TEXTURE_SIZE ? the_fake.texture_side : 0;
}

static GLuint create_shader(GLenum kind)
{
    (void)kind;
    the_fake.objects++;
    return 1;
}

static GLuint create_program(void)
{
    the_fake.objects++;
    return 1;
}

static void shader_source(GLuint s, GLsizei n, const GLchar *const *text, const GLint *length)
{
    (void)s;
    (void)n;
    (void)text;
    (void)length;
}

static void of_one(GLuint name)
{
    (void)name;
}

static void drop(GLuint name)
{
    (void)name;
    the_fake.objects--;
}

static void attach(GLuint program, GLuint shader)
{
    (void)program;
    (void)shader;
}

static void get_of(GLuint name, GLenum what, GLint *value)
{
    (void)name;
    (void)what;
    *value = !the_fake.no_compile;
}

static void generate(GLsizei n, GLuint *names)
{
    for (GLsizei i = 0; i < n; i++)
        names[i] = 1;
    the_fake.objects += n;
}

static void drop_many(GLsizei n, const GLuint *names)
{
    (void)names;
    the_fake.objects -= n;
}

static void bind(GLenum target, GLuint name)
{
    (void)target;
    (void)name;
}

static void parameter(GLenum target, GLenum name, GLint value)
{
    (void)target;
    (void)name;
    (void)value;
}

static void viewport(GLint x, GLint y, GLsizei width, GLsizei height)
{
    (void)x;
    (void)y;
    the_fake.viewport[0] = width;
    the_fake.viewport[1] = height;
}

static void pixel_store(GLenum name, GLint value)
{
    (void)name;
    (void)value;
}

static void image(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border,
                  GLenum format, GLenum type, const void *pixels)
{
    (void)target;
    (void)level;
    (void)internal;
    (void)border;
    (void)format;
    (void)type;
    (void)pixels;
    if (the_fake.reset_in_upload)
        the_fake.reset = GL_UNKNOWN_CONTEXT_RESET;
    if (the_fake.reset_in_upload || the_fake.no_texture_memory || width > the_fake.texture_side ||
        height > the_fake.texture_side)
        gl_error = GL_OUT_OF_MEMORY;
    the_fake.uploads++;
}

static void sub_image(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height, GLenum format,
                      GLenum type, const void *pixels)
{
    (void)target;
    (void)level;
    (void)x;
    (void)y;
    (void)width;
    (void)height;
    (void)format;
    (void)type;
    (void)pixels;
    the_fake.uploads++;
}

static GLenum get_error(void)
{
    const GLenum e = gl_error;
    gl_error = the_fake.reset && (the_fake.khr || the_fake.arb) ? GL_CONTEXT_LOST : GL_NO_ERROR;
    return e;
}

static void draw(GLenum mode, GLint first, GLsizei count)
{
    (void)mode;
    (void)first;
    (void)count;
}

static GLenum reset_status(void)
{
    return the_fake.reset;
}

PFNGLGETSTRINGPROC epoxy_glGetString = get_string;
PFNGLGETINTEGERVPROC epoxy_glGetIntegerv = get_integer;
PFNGLCREATESHADERPROC epoxy_glCreateShader = create_shader;
PFNGLSHADERSOURCEPROC epoxy_glShaderSource = shader_source;
PFNGLCOMPILESHADERPROC epoxy_glCompileShader = of_one;
PFNGLGETSHADERIVPROC epoxy_glGetShaderiv = get_of;
PFNGLDELETESHADERPROC epoxy_glDeleteShader = drop;
PFNGLCREATEPROGRAMPROC epoxy_glCreateProgram = create_program;
PFNGLATTACHSHADERPROC epoxy_glAttachShader = attach;
PFNGLLINKPROGRAMPROC epoxy_glLinkProgram = of_one;
PFNGLGETPROGRAMIVPROC epoxy_glGetProgramiv = get_of;
PFNGLDELETEPROGRAMPROC epoxy_glDeleteProgram = drop;
PFNGLGENVERTEXARRAYSPROC epoxy_glGenVertexArrays = generate;
PFNGLDELETEVERTEXARRAYSPROC epoxy_glDeleteVertexArrays = drop_many;
PFNGLBINDVERTEXARRAYPROC epoxy_glBindVertexArray = of_one;
PFNGLGENTEXTURESPROC epoxy_glGenTextures = generate;
PFNGLDELETETEXTURESPROC epoxy_glDeleteTextures = drop_many;
PFNGLBINDTEXTUREPROC epoxy_glBindTexture = bind;
PFNGLTEXPARAMETERIPROC epoxy_glTexParameteri = parameter;
PFNGLBINDFRAMEBUFFERPROC epoxy_glBindFramebuffer = bind;
PFNGLDISABLEPROC epoxy_glDisable = of_one;
PFNGLACTIVETEXTUREPROC epoxy_glActiveTexture = of_one;
PFNGLVIEWPORTPROC epoxy_glViewport = viewport;
PFNGLPIXELSTOREIPROC epoxy_glPixelStorei = pixel_store;
PFNGLTEXIMAGE2DPROC epoxy_glTexImage2D = image;
PFNGLTEXSUBIMAGE2DPROC epoxy_glTexSubImage2D = sub_image;
PFNGLGETERRORPROC epoxy_glGetError = get_error;
PFNGLUSEPROGRAMPROC epoxy_glUseProgram = of_one;
PFNGLDRAWARRAYSPROC epoxy_glDrawArrays = draw;
PFNGLGETGRAPHICSRESETSTATUSPROC epoxy_glGetGraphicsResetStatus = reset_status;
PFNGLGETGRAPHICSRESETSTATUSARBPROC epoxy_glGetGraphicsResetStatusARB = reset_status;
