/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/insides.h"

#include <math.h>
#include <time.h>

typedef struct frame {
    ost_headset *h;
    headset_swapchain *swapchain; /* swapchain of the eye that is being drawn */
    XrTime time;
    XrCompositionLayerProjectionView views[EYES];
    bool shown;                   /* true if both eyes have been drawn, so that the frame can be shown */
} frame;

static ost_status begin_here(void *user, ost_error *err)
{
    const frame *f = user;
    return headset_check(f->h, xrBeginFrame(f->h->session, NULL), "begins a frame", err);
}

static ost_status end_here(void *user, ost_error *err)
{
    const frame *f = user;
    const XrCompositionLayerProjection layer = {.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION,
                                                .space = f->h->room,
                                                .viewCount = EYES,
                                                .views = f->views};
    const XrCompositionLayerBaseHeader *const layers[] = {(const XrCompositionLayerBaseHeader *)&layer};
    const XrFrameEndInfo what = {.type = XR_TYPE_FRAME_END_INFO,
                                 .displayTime = f->time,
                                 .environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                                 .layerCount = f->shown,
                                 .layers = f->shown ? layers : NULL};
    return headset_check(f->h, xrEndFrame(f->h->session, &what), "shows a frame", err);
}

static ost_status acquire_here(void *user, ost_error *err)
{
    const frame *f = user;
    const XrSwapchainImageWaitInfo wait = {.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, .timeout = XR_INFINITE_DURATION};
    XrResult r = xrAcquireSwapchainImage(f->swapchain->swapchain, NULL, &f->swapchain->image);
    if (XR_SUCCEEDED(r))
        r = xrWaitSwapchainImage(f->swapchain->swapchain, &wait);
    if (XR_SUCCEEDED(r) && f->swapchain->image >= f->swapchain->count)
        r = XR_ERROR_RUNTIME_FAILURE;
    return headset_check(f->h, r, "prepares an image of an eye", err);
}

static ost_status release_here(void *user, ost_error *err)
{
    const frame *f = user;
    return headset_check(f->h, xrReleaseSwapchainImage(f->swapchain->swapchain, NULL), "takes an image of an eye",
                         err);
}

/* Draws one eye into its swapchain. Returns OST_ERR_RANGE if the eye's position is out of range. */
static ost_status draw_eye(frame *f, int number, const XrView *view, const ost_headset_calls *calls, ost_error *err)
{
    ost_headset *h = f->h;
    const XrVector3f *p = &view->pose.position;
    const XrQuaternionf *q = &view->pose.orientation;
    ost_headset_view eye = {.at = {p->x, p->y, p->z},
                            .q = {q->w, q->x, q->y, q->z},
                            .width = h->info.width,
                            .height = h->info.height};
    const ost_headset_fov fov = {view->fov.angleLeft, view->fov.angleRight, view->fov.angleUp, view->fov.angleDown};
    if (!ost_headset_project(&fov, eye.width, eye.height, &eye.projection))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "the OpenXR runtime %s reports an angle of view that cannot be drawn",
                        h->info.runtime);
    ost_status status = calls->draw(calls->user, &eye, err);
    if (status != OST_OK)
        return status;
    f->swapchain = &h->eye[number];
    status = ost_gl_do(h->gl, acquire_here, f, err);
    if (status != OST_OK)
        return status;
    status = ost_gl_copy(h->gl, f->swapchain->texture[f->swapchain->image], err);
    const ost_status released = ost_gl_do(h->gl, release_here, f, status == OST_OK ? err : NULL);
    const ost_headset_fov *covers = &eye.projection.fov;
    f->views[number] = (XrCompositionLayerProjectionView){
        .type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
        .pose = view->pose,
        .fov = {(float)covers->left, (float)covers->right, (float)covers->up, (float)covers->down},
        .subImage = {.swapchain = f->swapchain->swapchain, .imageRect = {{0, 0}, {eye.width, eye.height}}}};
    return status == OST_OK ? released : status;
}

static ost_status draw_eyes(frame *f, const ost_headset_calls *calls, ost_error *err)
{
    ost_headset *h = f->h;
    const XrViewLocateInfo where = {.type = XR_TYPE_VIEW_LOCATE_INFO,
                                    .viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                    .displayTime = f->time,
                                    .space = h->room};
    const XrViewStateFlags needed = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
    XrViewState state = {.type = XR_TYPE_VIEW_STATE};
    XrView view[EYES] = {{.type = XR_TYPE_VIEW}, {.type = XR_TYPE_VIEW}};
    uint32_t count = 0;
    ost_status status = headset_check(h, xrLocateViews(h->session, &where, &state, EYES, &count, view),
                                      "reports the pose of the head", err);
    if (status != OST_OK)
        return status;
    if (count != EYES || (state.viewStateFlags & needed) != needed) {
        h->counts.untracked++;
        return OST_OK;
    }
    for (int i = 0; i < EYES && status == OST_OK; i++)
        status = draw_eye(f, i, &view[i], calls, err);
    f->shown = status == OST_OK;
    h->counts.drawn += f->shown;
    if (status == OST_ERR_RANGE) {
        if (err)
            *err = (ost_error){0};
        return OST_OK;
    }
    return status;
}

/*
 * Counts the display periods that have passed without a new frame. If frames take too long, some runtimes request them
 * at a lower rate and report a longer period. The shortest period reported so far is therefore used as the period of
 * the display.
 */
static void count_frame(ost_headset *h, const XrFrameState *state)
{
    const XrDuration period = state->predictedDisplayPeriod;
    h->counts.frames++;
    if (period > 0 && (h->period == 0 || period < h->period))
        h->period = period;
    if (h->period > 0) {
        h->counts.display_hz = 1e9 / (double)h->period;
        const double periods = rint((double)(state->predictedDisplayTime - h->last) / (double)h->period);
        if (h->last && periods > 1)
            h->counts.missed += (uint64_t)periods - 1;
    }
    h->last = state->predictedDisplayTime;
}

ost_status ost_headset_frame(ost_headset *h, const ost_headset_calls *calls, bool *ended, ost_error *err)
{
    const struct timespec pause = {.tv_nsec = 10000000};
    static const ost_headset_hand no_hand;
    frame f = {.h = h};
    XrFrameState state = {.type = XR_TYPE_FRAME_STATE};
    ost_status status = headset_poll(h, err);
    *ended = h->ended;
    if (status != OST_OK)
        return status;
    if (!h->running) {
        calls->hand(calls->user, &no_hand);
        nanosleep(&pause, NULL);
        return OST_OK;
    }
    status = headset_check(h, xrWaitFrame(h->session, NULL, &state), "waits for a frame", err);
    if (status != OST_OK)
        return status;
    f.time = state.predictedDisplayTime;
    count_frame(h, &state);
    const ost_headset_hand hand = headset_hand_read(h, f.time);
    calls->hand(calls->user, &hand);
    status = ost_gl_do(h->gl, begin_here, &f, err);
    if (status != OST_OK)
        return status;
    if (state.shouldRender)
        status = draw_eyes(&f, calls, err);
    const ost_status shown = ost_gl_do(h->gl, end_here, &f, status == OST_OK ? err : NULL);
    return status == OST_OK ? shown : status;
}
