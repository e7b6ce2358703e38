/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/insides.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { EXTENSIONS_MAX = 256, FORMATS_MAX = 64, SRGB8_ALPHA8 = 0x8c43, RGBA8 = 0x8058 };

/* ------------------------------------------------------------- open, close */

/* Checks that the runtime can use an OpenGL context that was created through EGL. */
static ost_status check_extensions(ost_error *err)
{
    static XrExtensionProperties there[EXTENSIONS_MAX];
    uint32_t count = 0;
    bool opengl = false, egl = false;
    for (int i = 0; i < EXTENSIONS_MAX; i++)
        there[i] = (XrExtensionProperties){.type = XR_TYPE_EXTENSION_PROPERTIES};
    if (XR_FAILED(xrEnumerateInstanceExtensionProperties(NULL, EXTENSIONS_MAX, &count, there)))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "no OpenXR runtime is active; Debian 13: libopenxr1-monado and monado-service, or the "
                        "headset's own runtime (XR_RUNTIME_JSON names a runtime's file)");
    for (uint32_t i = 0; i < count; i++) {
        opengl = opengl || strcmp(there[i].extensionName, XR_KHR_OPENGL_ENABLE_EXTENSION_NAME) == 0;
        egl = egl || strcmp(there[i].extensionName, XR_MNDX_EGL_ENABLE_EXTENSION_NAME) == 0;
    }
    return opengl && egl ? OST_OK
                         : ost_fail(err, OST_ERR_UNAVAILABLE,
                                    "the OpenXR runtime here lacks %s, which osteon draws with; Monado has it",
                                    opengl ? XR_MNDX_EGL_ENABLE_EXTENSION_NAME : XR_KHR_OPENGL_ENABLE_EXTENSION_NAME);
}

static ost_status make_instance(ost_headset *h, ost_error *err)
{
    static const char *const extensions[] = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_MNDX_EGL_ENABLE_EXTENSION_NAME};
    const XrInstanceCreateInfo what = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .applicationInfo = {.applicationName = "osteon",
                            .applicationVersion = 1,
                            .engineName = "osteon",
                            .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = 2,
        .enabledExtensionNames = extensions,
    };
    XrInstanceProperties properties = {.type = XR_TYPE_INSTANCE_PROPERTIES};
    const XrResult r = xrCreateInstance(&what, &h->instance);
    if (XR_FAILED(r)) {
        h->instance = XR_NULL_HANDLE;
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "the OpenXR runtime does not answer (result %d); start it first, for example monado-service",
                        (int)r);
    }
    if (XR_SUCCEEDED(xrGetInstanceProperties(h->instance, &properties)))
        snprintf(h->info.runtime, sizeof h->info.runtime, "%.120s %d.%d.%d", properties.runtimeName,
                 (int)XR_VERSION_MAJOR(properties.runtimeVersion), (int)XR_VERSION_MINOR(properties.runtimeVersion),
                 (int)XR_VERSION_PATCH(properties.runtimeVersion));
    return OST_OK;
}

static ost_status find_system(ost_headset *h, ost_error *err)
{
    const XrSystemGetInfo what = {.type = XR_TYPE_SYSTEM_GET_INFO,
                                  .formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrSystemProperties properties = {.type = XR_TYPE_SYSTEM_PROPERTIES};
    XrViewConfigurationView view[EYES];
    uint32_t views = 0;
    for (int i = 0; i < EYES; i++)
        view[i] = (XrViewConfigurationView){.type = XR_TYPE_VIEW_CONFIGURATION_VIEW};
    XrResult r = xrGetSystem(h->instance, &what, &h->system);
    if (r == XR_ERROR_FORM_FACTOR_UNAVAILABLE)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "the OpenXR runtime %s finds no headset; connect one",
                        h->info.runtime);
    if (XR_SUCCEEDED(r))
        r = xrGetSystemProperties(h->instance, h->system, &properties);
    if (XR_SUCCEEDED(r))
        r = xrEnumerateViewConfigurationViews(h->instance, h->system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, EYES,
                                              &views, view);
    if (XR_FAILED(r) || views != EYES)
        return headset_check(h, XR_FAILED(r) ? r : XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
                             "describes the headset", err);
    snprintf(h->info.system, sizeof h->info.system, "%.255s", properties.systemName);
    for (int i = 0; i < EYES; i++) {
        const int width = (int)view[i].recommendedImageRectWidth, height = (int)view[i].recommendedImageRectHeight;
        h->info.width = width > h->info.width ? width : h->info.width;
        h->info.height = height > h->info.height ? height : h->info.height;
    }
    h->width_max = (int)view[0].maxImageRectWidth;
    h->height_max = (int)view[0].maxImageRectHeight;
    return OST_OK;
}

ost_status ost_headset_open(ost_headset **out, ost_error *err)
{
    *out = NULL;
    ost_headset *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a headset");
    /* Suppresses the lines that the loader prints for each failure, because the returned error contains the reason. */
    setenv("XR_LOADER_DEBUG", "none", 0);
    ost_status status = check_extensions(err);
    if (status == OST_OK)
        status = make_instance(h, err);
    if (status == OST_OK)
        status = find_system(h, err);
    if (status != OST_OK) {
        ost_headset_close(h);
        return status;
    }
    *out = h;
    return OST_OK;
}

void ost_headset_close(ost_headset *h)
{
    if (!h)
        return;
    ost_headset_end(h);
    if (h->instance != XR_NULL_HANDLE)
        xrDestroyInstance(h->instance);
    free(h);
}

ost_headset_info ost_headset_info_get(const ost_headset *h)
{
    return h->info;
}

ost_headset_counts ost_headset_counts_get(const ost_headset *h)
{
    return h->counts;
}

/* ------------------------------------------------------------------ session */

/*
 * Chooses the format of the swapchains: sRGB or, if the runtime does not offer it, RGBA8. The picture is already
 * sRGB-encoded, so it is copied unchanged and displayed correctly from a texture with an sRGB format.
 */
static ost_status choose_format(const ost_headset *h, int64_t *out, ost_error *err)
{
    int64_t formats[FORMATS_MAX];
    uint32_t count = 0;
    const XrResult r = xrEnumerateSwapchainFormats(h->session, FORMATS_MAX, &count, formats);
    *out = 0;
    for (uint32_t i = 0; i < count && XR_SUCCEEDED(r); i++)
        if (formats[i] == SRGB8_ALPHA8 || (formats[i] == RGBA8 && *out == 0))
            *out = formats[i];
    if (XR_SUCCEEDED(r) && *out == 0)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "the OpenXR runtime %s has no swapchain with 8 bits per colour",
                        h->info.runtime);
    return headset_check(h, r, "lists the formats of swapchains", err);
}

static ost_status make_swapchain(ost_headset *h, headset_swapchain *s, int64_t format, ost_error *err)
{
    const XrSwapchainCreateInfo what = {
        .type = XR_TYPE_SWAPCHAIN_CREATE_INFO,
        .usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
        .format = format,
        .sampleCount = 1,
        .width = (uint32_t)h->info.width,
        .height = (uint32_t)h->info.height,
        .faceCount = 1,
        .arraySize = 1,
        .mipCount = 1,
    };
    XrSwapchainImageOpenGLKHR image[IMAGES_MAX];
    for (int i = 0; i < IMAGES_MAX; i++)
        image[i] = (XrSwapchainImageOpenGLKHR){.type = XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR};
    XrResult r = xrCreateSwapchain(h->session, &what, &s->swapchain);
    if (XR_SUCCEEDED(r))
        r = xrEnumerateSwapchainImages(s->swapchain, IMAGES_MAX, &s->count, (XrSwapchainImageBaseHeader *)image);
    for (uint32_t i = 0; i < s->count && XR_SUCCEEDED(r); i++)
        s->texture[i] = image[i].image;
    return headset_check(h, r, "makes the images of an eye", err);
}

/* Called on the thread of the OpenGL context. */
static ost_status make_session(void *user, ost_error *err)
{
    ost_headset *h = user;
    const ost_gl_egl egl = ost_gl_egl_get(h->gl);
    const XrGraphicsBindingEGLMNDX binding = {.type = XR_TYPE_GRAPHICS_BINDING_EGL_MNDX,
                                              .getProcAddress = eglGetProcAddress,
                                              .display = egl.display,
                                              .config = egl.config,
                                              .context = egl.context};
    const XrSessionCreateInfo what = {
        .type = XR_TYPE_SESSION_CREATE_INFO, .next = &binding, .systemId = h->system};
    const XrReferenceSpaceCreateInfo space = {.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                              .referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL,
                                              .poseInReferenceSpace = {.orientation = {0, 0, 0, 1}}};
    XrGraphicsRequirementsOpenGLKHR needed = {.type = XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR};
    PFN_xrGetOpenGLGraphicsRequirementsKHR requirements = NULL;
    int64_t format;
    XrResult r = xrGetInstanceProcAddr(h->instance, "xrGetOpenGLGraphicsRequirementsKHR",
                                       (PFN_xrVoidFunction *)&requirements);
    /* OpenXR requires this call before a session is created. xrCreateSession then refuses a context that is too old. */
    if (XR_SUCCEEDED(r))
        r = requirements(h->instance, h->system, &needed);
    if (XR_SUCCEEDED(r))
        r = xrCreateSession(h->instance, &what, &h->session);
    if (XR_SUCCEEDED(r))
        r = xrCreateReferenceSpace(h->session, &space, &h->room);
    ost_status status = headset_check(h, r, "begins a session with OpenGL", err);
    if (status == OST_OK)
        status = choose_format(h, &format, err);
    for (int i = 0; i < EYES && status == OST_OK; i++)
        status = make_swapchain(h, &h->eye[i], format, err);
    return status;
}

ost_status ost_headset_begin(ost_headset *h, ost_gl *gl, int width, int height, bool left, ost_error *err)
{
    h->gl = gl;
    if (width > 0) {
        h->info.width = width;
        h->info.height = height;
    }
    if (h->info.width > h->width_max || h->info.height > h->height_max || h->info.width > OST_FRAME_MAX ||
        h->info.height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%d x %d pixels for an eye; the headset shows at most %d x %d",
                        h->info.width, h->info.height, h->width_max, h->height_max);
    ost_status status = ost_gl_do(gl, make_session, h, err);
    return status == OST_OK ? headset_hand_begin(h, left, err) : status;
}

ost_status headset_poll(ost_headset *h, ost_error *err)
{
    XrEventDataBuffer event = {.type = XR_TYPE_EVENT_DATA_BUFFER};
    const XrSessionBeginInfo begin = {.type = XR_TYPE_SESSION_BEGIN_INFO,
                                      .primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    XrResult r;
    while ((r = xrPollEvent(h->instance, &event)) == XR_SUCCESS) {
        if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
            h->ended = true;
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
            XrEventDataSessionStateChanged change;
            memcpy(&change, &event, sizeof change);
            if (change.state == XR_SESSION_STATE_READY && XR_SUCCEEDED(xrBeginSession(h->session, &begin)))
                h->running = true;
            if (change.state == XR_SESSION_STATE_STOPPING) {
                h->running = false;
                h->last = 0;
                xrEndSession(h->session);
            }
            if (change.state == XR_SESSION_STATE_EXITING || change.state == XR_SESSION_STATE_LOSS_PENDING)
                h->ended = true;
        }
        event = (XrEventDataBuffer){.type = XR_TYPE_EVENT_DATA_BUFFER};
    }
    return headset_check(h, r, "reports its state", err);
}

/* Called on the thread of the OpenGL context. Destroying a session also destroys its swapchains and spaces. */
static ost_status destroy_session(void *user, ost_error *err)
{
    ost_headset *h = user;
    (void)err;
    xrDestroySession(h->session);
    if (h->actions.set != XR_NULL_HANDLE)
        xrDestroyActionSet(h->actions.set);
    return OST_OK;
}

void ost_headset_end(ost_headset *h)
{
    enum { TRIES = 100 };
    const struct timespec pause = {.tv_nsec = 10000000};
    if (h->session == XR_NULL_HANDLE)
        return;
    if (h->running && XR_SUCCEEDED(xrRequestExitSession(h->session)))
        for (int i = 0; i < TRIES && h->running && headset_poll(h, NULL) == OST_OK; i++)
            nanosleep(&pause, NULL);
    ost_gl_do(h->gl, destroy_session, h, NULL);
    h->session = XR_NULL_HANDLE;
    h->actions = (headset_actions){0};
    h->running = false;
}
