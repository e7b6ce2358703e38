/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/context.h"

#include <stdio.h>
#include <string.h>

enum { DEVICES = 16, NEEDED = 33 };

const char *ost_gl_missing(void)
{
    return NULL;
}

/* --------------------------------------------------------------- messages */

static void APIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                const GLchar *text, const void *user)
{
    ost_gl_context *c = (ost_gl_context *)(uintptr_t)user;
    (void)source;
    (void)id;
    (void)length;
    if ((type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) &&
        severity != GL_DEBUG_SEVERITY_NOTIFICATION && !c->complaint[0])
        snprintf(c->complaint, sizeof c->complaint, "%.200s", text);
}

static void listen(ost_gl_context *c)
{
    if (epoxy_gl_version() < 43 && !epoxy_has_gl_extension("GL_KHR_debug"))
        return;
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_message, c);
}

static const char *error_name(GLenum error)
{
    switch (error) {
    case GL_INVALID_ENUM: return "an invalid enum";
    case GL_INVALID_VALUE: return "an invalid value";
    case GL_INVALID_OPERATION: return "an invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "an incomplete framebuffer";
    case GL_OUT_OF_MEMORY: return "no memory left on the device";
    case GL_CONTEXT_LOST: return "the context was lost: the driver was reset";
    default: return "an error that it does not name";
    }
}

ost_status ost_gl_context_check(ost_gl_context *c, const char *doing, ost_error *err)
{
    const GLenum error = glGetError();
    ost_status status = OST_OK;
    if (error != GL_NO_ERROR || c->complaint[0])
        status = ost_fail(err, error == GL_OUT_OF_MEMORY ? OST_ERR_MEMORY : OST_ERR_UNAVAILABLE,
                          "OpenGL (%s) fails as it %s: %s%s%s", c->info.driver, doing,
                          error != GL_NO_ERROR ? error_name(error) : "",
                          error != GL_NO_ERROR && c->complaint[0] ? "; " : "", c->complaint);
    /* Empties OpenGL's queue of errors. The number of calls is limited, because a lost context reports an error at
     * every call. */
    for (int i = 0; i < 8 && glGetError() != GL_NO_ERROR; i++)
        ;
    c->complaint[0] = '\0';
    return status;
}

/* ------------------------------------------------------------------ features */

static void copy_string(char *out, size_t size, GLenum name)
{
    const char *text = (const char *)glGetString(name);
    snprintf(out, size, "%.*s", (int)size - 1, text ? text : "unknown");
}

static bool is_software(const char *driver)
{
    static const char *const software[] = {"llvmpipe", "softpipe", "SWR", "swrast", "Software Rasterizer"};
    for (size_t i = 0; i < sizeof software / sizeof *software; i++)
        if (strstr(driver, software[i]))
            return true;
    return false;
}

static ost_status describe(ost_gl_context *c, const ost_gl_options *options, ost_error *err)
{
    GLfloat sizes[2] = {1, 1};
    const int there = epoxy_is_desktop_gl() ? epoxy_gl_version() : 0;
    copy_string(c->info.version, sizeof c->info.version, GL_VERSION);
    copy_string(c->info.driver, sizeof c->info.driver, GL_RENDERER);
    c->info.software = is_software(c->info.driver);
    if (there < NEEDED)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL %s (%s); expected 3.3 or later", c->info.version,
                        c->info.driver);
    c->version = options->version >= NEEDED && options->version < there ? options->version : there;
    const bool any = options->version == 0;
    c->persistent = c->version >= 44 || (any && epoxy_has_gl_extension("GL_ARB_buffer_storage"));
    c->zero_to_one = c->version >= 45 || (any && epoxy_has_gl_extension("GL_ARB_clip_control"));
    glGetFloatv(GL_POINT_SIZE_RANGE, sizes);
    c->info.largest = sizes[1];
    c->info.mapped = c->persistent;
    return OST_OK;
}

/* -------------------------------------------------------------------- EGL */

typedef struct candidate {
    EGLenum platform;
    void *device;
    const char *way;
} candidate;

static const char *egl_error(void)
{
    switch (eglGetError()) {
    case EGL_NOT_INITIALIZED: return "it cannot be initialised";
    case EGL_BAD_ACCESS: return "access was denied";
    case EGL_BAD_ALLOC: return "no memory, or no device";
    case EGL_BAD_CONFIG: return "no such configuration";
    case EGL_BAD_MATCH: return "no such version of OpenGL";
    case EGL_BAD_PARAMETER: return "a parameter that it does not know";
    case EGL_CONTEXT_LOST: return "the device was reset";
    default: return "it does not say why";
    }
}

static bool has(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

static int find_candidates(candidate *out, ost_error *err)
{
    const char *client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    int count = 0;
    if (!client || !has(client, "EGL_EXT_platform_base")) {
        ost_fail(err, OST_ERR_UNAVAILABLE,
                 "EGL here has no driver, or is too old to draw without a display (no EGL_EXT_platform_base); Debian: "
                 "libegl-mesa0 and libgl1-mesa-dri, or "
                 "the card's driver");
        return 0;
    }
    if (has(client, "EGL_MESA_platform_surfaceless"))
        out[count++] = (candidate){EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, "EGL without a surface"};
    if (has(client, "EGL_EXT_platform_device") &&
        (has(client, "EGL_EXT_device_enumeration") || has(client, "EGL_EXT_device_base"))) {
        EGLDeviceEXT device[DEVICES];
        EGLint devices = 0;
        if (eglQueryDevicesEXT(DEVICES, device, &devices))
            for (EGLint i = 0; i < devices; i++) {
                const char *extensions = eglQueryDeviceStringEXT(device[i], EGL_EXTENSIONS);
                if (!has(extensions, "EGL_MESA_device_software"))
                    out[count++] = (candidate){EGL_PLATFORM_DEVICE_EXT, device[i], "EGL on a device"};
            }
    }
    if (count == 0)
        ost_fail(err, OST_ERR_UNAVAILABLE,
                 "EGL here draws only with a display: no EGL_MESA_platform_surfaceless and no device; Debian: "
                 "libegl-mesa0 and libgl1-mesa-dri, or the "
                 "card's driver");
    return count;
}

/* Reports that no context could be created. Opens a context of any version, so that the error message can state the
   version that the driver supports. */
static ost_status too_old(ost_gl_context *c, EGLConfig config, ost_error *err)
{
    const EGLint none[] = {EGL_NONE};
    const char *why = egl_error();
    const EGLContext any = eglCreateContext(c->display, config, EGL_NO_CONTEXT, none);
    if (any == EGL_NO_CONTEXT)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "EGL cannot create an OpenGL 3.3 context: %s", why);
    if (eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, any)) {
        copy_string(c->info.version, sizeof c->info.version, GL_VERSION);
        copy_string(c->info.driver, sizeof c->info.driver, GL_RENDERER);
        ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL %s (%s); expected 3.3 or later", c->info.version, c->info.driver);
        eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    } else {
        ost_fail(err, OST_ERR_UNAVAILABLE, "EGL cannot create an OpenGL 3.3 context: %s", why);
    }
    eglDestroyContext(c->display, any);
    return OST_ERR_UNAVAILABLE;
}

static ost_status create(ost_gl_context *c, const ost_gl_options *options, ost_error *err)
{
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLint attribute[] = {EGL_CONTEXT_MAJOR_VERSION,
                          3,
                          EGL_CONTEXT_MINOR_VERSION,
                          3,
                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                          options->debug ? EGL_CONTEXT_OPENGL_DEBUG : EGL_NONE,
                          EGL_TRUE,
                          EGL_NONE};
    EGLConfig config = NULL;
    EGLint configs = 0, major = 0, minor = 0;
    if (!eglInitialize(c->display, &major, &minor))
        return ost_fail(
            err, OST_ERR_UNAVAILABLE,
            "EGL has no driver to draw with (%s); Debian: libegl-mesa0 and libgl1-mesa-dri, or the card's driver",
            egl_error());
    const char *extensions = eglQueryString(c->display, EGL_EXTENSIONS);
    if (!has(extensions, "EGL_KHR_surfaceless_context"))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "EGL %d.%d here lacks EGL_KHR_surfaceless_context: it draws into surfaces only", (int)major,
                        (int)minor);
    if (major == 1 && minor < 5 && !has(extensions, "EGL_KHR_create_context"))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "EGL %d.%d here is too old for OpenGL 3.3; expected EGL 1.5",
                        (int)major, (int)minor);
    if (!eglBindAPI(EGL_OPENGL_API) || !eglChooseConfig(c->display, wanted, &config, 1, &configs) || configs < 1)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "EGL %d.%d here has no OpenGL, only OpenGL ES", (int)major,
                        (int)minor);
    c->config = config;
    c->context = eglCreateContext(c->display, config, EGL_NO_CONTEXT, attribute);
    if (c->context == EGL_NO_CONTEXT)
        return too_old(c, config, err);
    if (!eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, c->context))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "EGL's context cannot be used by this thread: %s", egl_error());
    return describe(c, options, err);
}

/*
 * Closes the context but not the display. Other threads of the process may use the display. Closing the last display
 * would also unload the driver, and some drivers then leak this thread's data.
 */
static void drop(ost_gl_context *c)
{
    if (c->display != EGL_NO_DISPLAY) {
        eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (c->context != EGL_NO_CONTEXT)
            eglDestroyContext(c->display, c->context);
        eglReleaseThread();
    }
    c->display = EGL_NO_DISPLAY;
    c->context = EGL_NO_CONTEXT;
}

/*
 * Opens the first candidate with a hardware renderer. If there is none, opens the first candidate that works, unless
 * the options require a graphics card. On failure, err contains the error of the first candidate that could not be
 * opened, or the name of a software renderer.
 */
static ost_status open_egl(ost_gl_context *c, const ost_gl_options *options, ost_error *err)
{
    candidate list[DEVICES + 1];
    if (!epoxy_has_egl())
        return ost_fail(
            err, OST_ERR_UNAVAILABLE,
            "there is no EGL to draw with (libEGL.so.1); Debian: libegl1, and libegl-mesa0 or the card's driver");
    const int count = find_candidates(list, err);
    ost_status status = count ? OST_OK : OST_ERR_UNAVAILABLE;
    int software = -1;
    for (int pass = 0; pass < 2 && count; pass++)
        for (int i = 0; i < count; i++) {
            ost_error why = {0};
            if (pass == 1 && (i != software || options->hardware))
                continue;
            c->display = eglGetPlatformDisplayEXT(list[i].platform, list[i].device, NULL);
            snprintf(c->info.way, sizeof c->info.way, "%s", list[i].way);
            const ost_status s = c->display == EGL_NO_DISPLAY ? ost_fail(&why, OST_ERR_UNAVAILABLE,
                                                                         "%s: no display: %s", list[i].way, egl_error())
                                                              : create(c, options, &why);
            if (s == OST_OK && (!c->info.software || pass == 1))
                return OST_OK;
            software = s == OST_OK && software < 0 ? i : software;
            if (s != OST_OK && status == OST_OK)
                status = ost_fail(err, s, "%s", why.text);
            if (s == OST_OK && options->hardware)
                status = ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL is software here (%s)", c->info.driver);
            drop(c);
        }
    return status;
}

static ost_status use_current(ost_gl_context *c, const ost_gl_options *options, ost_error *err)
{
    ost_status status = describe(c, options, err);
    if (status == OST_OK && options->hardware && c->info.software)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "OpenGL is software here (%s)", c->info.driver);
    return status;
}

ost_status ost_gl_context_open(ost_gl_context *c, const ost_gl_options *options, ost_error *err)
{
    memset(c, 0, sizeof *c);
    c->display = EGL_NO_DISPLAY;
    c->context = EGL_NO_CONTEXT;
    if (options->current) {
        snprintf(c->info.way, sizeof c->info.way, "the window's context");
        return use_current(c, options, err);
    }
    ost_status status = open_egl(c, options, err);
    if (status != OST_OK)
        return status;
    listen(c);
    return OST_OK;
}

void ost_gl_context_close(ost_gl_context *c)
{
    if (c->context == EGL_NO_CONTEXT)
        return;
    drop(c);
}
