/* SPDX-License-Identifier: Apache-2.0 */
/* Implements runtime.h. One instance and one session exist at a time. */
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_PLATFORM_EGL
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "headset/runtime.h"

#define EXPORT __attribute__((visibility("default")))
#define HANDLE(TYPE, NUMBER) ((TYPE)(uintptr_t)(NUMBER))
#define PERIOD 13888889 /* in ns, for 72 frames per second */

extern fake_xr_state fake_xr;
/* The initial state has a tracked head, a tracked hand, and frames at the display's rate. */
EXPORT fake_xr_state fake_xr = {.eye_x = {-0.03f, 0.03f},
                                .fov = {{-0.8f, 0.7f, 0.7f, -0.7f}, {-0.7f, 0.8f, 0.7f, -0.7f}},
                                .head_tracked = true,
                                .hand_tracked = true,
                                .hand = {0.1f, 0, -0.3f},
                                .waits = true};

static struct {
    GLuint texture[2];
    int acquired[2];      /* 0 if the image is free, 1 if it is acquired, 2 if it is acquired and ready for drawing */
    XrSessionState queue[8];
    int queued, next;
    XrTime time;
    bool in_frame, running;
    int actions;
} now;

static bool fails(const char *name)
{
    return fake_xr.fail && strcmp(fake_xr.fail, name) == 0;
}

#define BEGIN                            \
    do {                                 \
        if (fails(__func__ + 3))         \
            return XR_ERROR_RUNTIME_FAILURE; \
    } while (0)

static XrResult check_order(bool right)
{
    fake_xr.wrong_order = fake_xr.wrong_order || !right;
    return right ? XR_SUCCESS : XR_ERROR_CALL_ORDER_INVALID;
}

static void queue_state(XrSessionState state)
{
    now.queue[now.queued++ % 8] = state;
}

static XrResult my_EnumerateInstanceExtensionProperties(const char *layer, uint32_t capacity, uint32_t *count,
                                                        XrExtensionProperties *out)
{
    static const char *const names[] = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_MNDX_EGL_ENABLE_EXTENSION_NAME};
    (void)layer;
    *count = fake_xr.no_egl ? 1 : 2;
    for (uint32_t i = 0; i < *count && i < capacity; i++)
        snprintf(out[i].extensionName, sizeof out[i].extensionName, "%s", names[i]);
    return XR_SUCCESS;
}

static XrResult my_CreateInstance(const XrInstanceCreateInfo *what, XrInstance *out)
{
    (void)what;
    BEGIN;
    memset(&now, 0, sizeof now);
    fake_xr.instances++;
    *out = HANDLE(XrInstance, 1);
    return XR_SUCCESS;
}

static XrResult my_DestroyInstance(XrInstance instance)
{
    (void)instance;
    fake_xr.instances--;
    return check_order(fake_xr.sessions == 0);
}

static XrResult my_GetInstanceProperties(XrInstance instance, XrInstanceProperties *out)
{
    (void)instance;
    out->runtimeVersion = XR_MAKE_VERSION(1, 2, 3);
    snprintf(out->runtimeName, sizeof out->runtimeName, "fake");
    return XR_SUCCESS;
}

static XrResult my_ResultToString(XrInstance instance, XrResult value, char text[XR_MAX_RESULT_STRING_SIZE])
{
    (void)instance;
    snprintf(text, XR_MAX_RESULT_STRING_SIZE, "fake result %d", (int)value);
    return XR_SUCCESS;
}

static XrResult my_GetSystem(XrInstance instance, const XrSystemGetInfo *what, XrSystemId *out)
{
    (void)instance;
    (void)what;
    *out = 1;
    return fake_xr.no_headset ? XR_ERROR_FORM_FACTOR_UNAVAILABLE : XR_SUCCESS;
}

static XrResult my_GetSystemProperties(XrInstance instance, XrSystemId id, XrSystemProperties *out)
{
    (void)instance;
    (void)id;
    snprintf(out->systemName, sizeof out->systemName, "a headset for tests");
    return XR_SUCCESS;
}

static XrResult my_EnumerateViewConfigurationViews(XrInstance instance, XrSystemId id, XrViewConfigurationType type,
                                                   uint32_t capacity, uint32_t *count, XrViewConfigurationView *out)
{
    (void)instance;
    (void)id;
    (void)type;
    *count = 2;
    for (uint32_t i = 0; i < 2 && i < capacity; i++) {
        out[i].recommendedImageRectWidth = FAKE_WIDTH;
        out[i].recommendedImageRectHeight = FAKE_HEIGHT;
        out[i].maxImageRectWidth = out[i].maxImageRectHeight = 4096;
    }
    return XR_SUCCESS;
}

static XrResult my_GetOpenGLGraphicsRequirementsKHR(XrInstance instance, XrSystemId id,
                                                    XrGraphicsRequirementsOpenGLKHR *out)
{
    (void)instance;
    (void)id;
    out->minApiVersionSupported = XR_MAKE_VERSION(3, 3, 0);
    return XR_SUCCESS;
}

static XrResult my_CreateSession(XrInstance instance, const XrSessionCreateInfo *what, XrSession *out)
{
    const XrGraphicsBindingEGLMNDX *egl = what->next;
    (void)instance;
    BEGIN;
    check_order(egl->type == XR_TYPE_GRAPHICS_BINDING_EGL_MNDX && egl->context == eglGetCurrentContext() &&
                egl->config && egl->getProcAddress("glGetString"));
    fake_xr.sessions++;
    now.time = 1000000000;
    queue_state(XR_SESSION_STATE_IDLE);
    queue_state(XR_SESSION_STATE_READY);
    *out = HANDLE(XrSession, 2);
    return XR_SUCCESS;
}

static XrResult my_DestroySession(XrSession session)
{
    (void)session;
    fake_xr.sessions--;
    glDeleteTextures(2, now.texture);
    return check_order(eglGetCurrentContext() != EGL_NO_CONTEXT);
}

static XrResult my_CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo *what, XrSpace *out)
{
    (void)session;
    *out = HANDLE(XrSpace, 3);
    return check_order(what->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL);
}

static XrResult my_CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo *what, XrSpace *out)
{
    (void)session;
    (void)what;
    *out = HANDLE(XrSpace, 4);
    return XR_SUCCESS;
}

static XrResult my_EnumerateSwapchainFormats(XrSession session, uint32_t capacity, uint32_t *count, int64_t *out)
{
    static const int64_t formats[] = {GL_RGBA16F, GL_RGBA8, GL_SRGB8_ALPHA8};
    (void)session;
    *count = 3;
    for (uint32_t i = 0; i < 3 && i < capacity; i++)
        out[i] = formats[i];
    return XR_SUCCESS;
}

static XrResult my_CreateSwapchain(XrSession session, const XrSwapchainCreateInfo *what, XrSwapchain *out)
{
    const int eye = now.texture[0] != 0;
    (void)session;
    BEGIN;
    glGenTextures(1, &now.texture[eye]);
    glBindTexture(GL_TEXTURE_2D, now.texture[eye]);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)what->format, (GLsizei)what->width, (GLsizei)what->height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, NULL);
    *out = HANDLE(XrSwapchain, 10 + eye);
    return check_order(what->format == GL_SRGB8_ALPHA8 && what->width == FAKE_WIDTH && what->height == FAKE_HEIGHT);
}

static int eye_of(XrSwapchain swapchain)
{
    return (int)((uintptr_t)swapchain - 10);
}

static XrResult my_EnumerateSwapchainImages(XrSwapchain swapchain, uint32_t capacity, uint32_t *count,
                                            XrSwapchainImageBaseHeader *out)
{
    *count = 1;
    if (capacity)
        ((XrSwapchainImageOpenGLKHR *)out)->image = now.texture[eye_of(swapchain)];
    return XR_SUCCESS;
}

static XrResult my_AcquireSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo *what, uint32_t *out)
{
    int *is = &now.acquired[eye_of(swapchain)];
    (void)what;
    BEGIN;
    const XrResult r = check_order(*is == 0 && now.in_frame);
    *is = 1;
    *out = 0;
    return r;
}

static XrResult my_WaitSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageWaitInfo *what)
{
    int *is = &now.acquired[eye_of(swapchain)];
    (void)what;
    const XrResult r = check_order(*is == 1);
    *is = 2;
    return r;
}

static XrResult my_ReleaseSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo *what)
{
    const int eye = eye_of(swapchain);
    (void)what;
    const XrResult r = check_order(now.acquired[eye] == 2);
    now.acquired[eye] = 0;
    glBindTexture(GL_TEXTURE_2D, now.texture[eye]);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, fake_xr.picture[eye]);
    return r;
}

static XrResult my_PollEvent(XrInstance instance, XrEventDataBuffer *out)
{
    XrEventDataSessionStateChanged event = {.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED,
                                            .session = HANDLE(XrSession, 2)};
    (void)instance;
    BEGIN;
    if (now.next == now.queued)
        return XR_EVENT_UNAVAILABLE;
    event.state = now.queue[now.next++ % 8];
    memcpy(out, &event, sizeof event);
    return XR_SUCCESS;
}

static XrResult my_BeginSession(XrSession session, const XrSessionBeginInfo *what)
{
    (void)session;
    (void)what;
    const XrResult r = check_order(!now.running);
    now.running = true;
    return r;
}

static XrResult my_EndSession(XrSession session)
{
    (void)session;
    const XrResult r = check_order(now.running && !now.in_frame);
    now.running = false;
    queue_state(XR_SESSION_STATE_EXITING);
    return r;
}

static XrResult my_RequestExitSession(XrSession session)
{
    (void)session;
    queue_state(XR_SESSION_STATE_STOPPING);
    return check_order(now.running);
}

static XrResult my_WaitFrame(XrSession session, const XrFrameWaitInfo *what, XrFrameState *out)
{
    (void)session;
    (void)what;
    BEGIN;
    const int slow = fake_xr.slow > 0 ? fake_xr.slow : 1;
    const struct timespec period = {.tv_nsec = PERIOD};
    now.time += (XrTime)PERIOD * (slow + fake_xr.skip);
    if (fake_xr.waits)
        nanosleep(&period, NULL);
    fake_xr.skip = 0;
    out->predictedDisplayTime = now.time;
    out->predictedDisplayPeriod = (XrDuration)PERIOD * slow;
    out->shouldRender = !fake_xr.hidden;
    return check_order(now.running);
}

static XrResult my_BeginFrame(XrSession session, const XrFrameBeginInfo *what)
{
    (void)session;
    (void)what;
    const XrResult r = check_order(now.running && !now.in_frame);
    now.in_frame = true;
    return r;
}

static XrResult my_EndFrame(XrSession session, const XrFrameEndInfo *what)
{
    (void)session;
    BEGIN;
    check_order(now.in_frame && what->displayTime == now.time && !now.acquired[0] && !now.acquired[1]);
    now.in_frame = false;
    fake_xr.frames++;
    if (fake_xr.lose_after && fake_xr.frames == fake_xr.lose_after)
        queue_state(XR_SESSION_STATE_LOSS_PENDING);
    if (what->layerCount == 0)
        return XR_SUCCESS;
    const XrCompositionLayerProjection *layer = (const void *)what->layers[0];
    fake_xr.layers++;
    check_order(layer->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION && layer->viewCount == 2);
    for (int i = 0; i < 2; i++) {
        const XrFovf *f = &layer->views[i].fov;
        const float fov[4] = {f->angleLeft, f->angleRight, f->angleUp, f->angleDown};
        memcpy(fake_xr.shown_fov[i], fov, sizeof fov);
        check_order(eye_of(layer->views[i].subImage.swapchain) == i);
    }
    return XR_SUCCESS;
}

static XrResult my_LocateViews(XrSession session, const XrViewLocateInfo *what, XrViewState *state, uint32_t capacity,
                               uint32_t *count, XrView *out)
{
    (void)session;
    check_order(what->displayTime == now.time && what->space == HANDLE(XrSpace, 3) && capacity == 2);
    state->viewStateFlags =
        fake_xr.head_tracked ? XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT : 0;
    *count = 2;
    for (int i = 0; i < 2; i++) {
        const float *f = fake_xr.fov[i];
        out[i].pose = (XrPosef){{0, 0, 0, 1}, {fake_xr.eye_x[i], 0, 0}};
        out[i].fov = (XrFovf){f[0], f[1], f[2], f[3]};
    }
    return XR_SUCCESS;
}

static XrResult my_LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation *out)
{
    check_order(space == HANDLE(XrSpace, 4) && base == HANDLE(XrSpace, 3) && time == now.time);
    out->locationFlags =
        fake_xr.hand_tracked ? XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT : 0;
    out->pose = (XrPosef){{0, 0, 0, 1}, {fake_xr.hand[0], fake_xr.hand[1], fake_xr.hand[2]}};
    return XR_SUCCESS;
}

static XrResult my_StringToPath(XrInstance instance, const char *text, XrPath *out)
{
    (void)instance;
    *out = strlen(text);
    return check_order(text[0] == '/');
}

static XrResult my_CreateActionSet(XrInstance instance, const XrActionSetCreateInfo *what, XrActionSet *out)
{
    (void)instance;
    (void)what;
    *out = HANDLE(XrActionSet, 5);
    return XR_SUCCESS;
}

static XrResult my_DestroyActionSet(XrActionSet set)
{
    (void)set;
    return XR_SUCCESS;
}

static XrResult my_CreateAction(XrActionSet set, const XrActionCreateInfo *what, XrAction *out)
{
    (void)set;
    (void)what;
    *out = HANDLE(XrAction, 20 + now.actions++);
    return XR_SUCCESS;
}

static XrResult my_SuggestInteractionProfileBindings(XrInstance instance,
                                                     const XrInteractionProfileSuggestedBinding *what)
{
    (void)instance;
    (void)what;
    return XR_SUCCESS;
}

static XrResult my_AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo *what)
{
    (void)session;
    (void)what;
    BEGIN;
    return XR_SUCCESS;
}

static XrResult my_SyncActions(XrSession session, const XrActionsSyncInfo *what)
{
    (void)session;
    (void)what;
    return XR_SUCCESS;
}

/* Action 20 is the pose of the grip, so the boolean actions begin at 21. */
static XrResult my_GetActionStateBoolean(XrSession session, const XrActionStateGetInfo *what, XrActionStateBoolean *out)
{
    (void)session;
    out->isActive = XR_TRUE;
    out->currentState = fake_xr.buttons >> ((uintptr_t)what->action - 21) & 1;
    return XR_SUCCESS;
}

static XrResult my_GetInstanceProcAddr(XrInstance instance, const char *name, PFN_xrVoidFunction *out)
{
#define ENTRY(NAME) {"xr" #NAME, (PFN_xrVoidFunction)my_##NAME}
    static const struct {
        const char *name;
        PFN_xrVoidFunction function;
    } all[] = {
        ENTRY(EnumerateInstanceExtensionProperties), ENTRY(CreateInstance), ENTRY(DestroyInstance),
        ENTRY(GetInstanceProperties), ENTRY(ResultToString), ENTRY(GetSystem), ENTRY(GetSystemProperties),
        ENTRY(EnumerateViewConfigurationViews), ENTRY(GetOpenGLGraphicsRequirementsKHR), ENTRY(CreateSession),
        ENTRY(DestroySession), ENTRY(CreateReferenceSpace), ENTRY(CreateActionSpace), ENTRY(EnumerateSwapchainFormats),
        ENTRY(CreateSwapchain), ENTRY(EnumerateSwapchainImages), ENTRY(AcquireSwapchainImage),
        ENTRY(WaitSwapchainImage), ENTRY(ReleaseSwapchainImage), ENTRY(PollEvent), ENTRY(BeginSession),
        ENTRY(EndSession), ENTRY(RequestExitSession), ENTRY(WaitFrame), ENTRY(BeginFrame), ENTRY(EndFrame),
        ENTRY(LocateViews), ENTRY(LocateSpace), ENTRY(StringToPath), ENTRY(CreateActionSet), ENTRY(DestroyActionSet),
        ENTRY(CreateAction), ENTRY(SuggestInteractionProfileBindings), ENTRY(AttachSessionActionSets),
        ENTRY(SyncActions), ENTRY(GetActionStateBoolean), ENTRY(GetInstanceProcAddr)};
    (void)instance;
    *out = NULL;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (strcmp(all[i].name, name) == 0)
            *out = all[i].function;
    return *out ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

/* The structs that the loader passes to a runtime, as defined by the loader's specification. */
typedef struct runtime_request {
    int type;
    uint32_t version;
    size_t size;
    uint32_t interface_version;
    XrVersion api_version;
    PFN_xrGetInstanceProcAddr get;
} runtime_request;

EXPORT XrResult xrNegotiateLoaderRuntimeInterface(const void *loader, runtime_request *request);
EXPORT XrResult xrNegotiateLoaderRuntimeInterface(const void *loader, runtime_request *request)
{
    (void)loader;
    request->interface_version = 1;
    request->api_version = XR_MAKE_VERSION(1, 0, 0);
    request->get = my_GetInstanceProcAddr;
    return XR_SUCCESS;
}
