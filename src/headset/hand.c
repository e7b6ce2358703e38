/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/insides.h"

#include <stdio.h>

/* A type of controller, and its inputs. */
typedef struct profile {
    /* path of the profile, and for each button the path of its input relative to the hand or NULL if it has no input */
    const char *path, *button[HAND_BUTTONS];
} profile;

static const profile profiles[] = {
    {"/interaction_profiles/khr/simple_controller", {"/input/select/click", "/input/menu/click", NULL}},
    {"/interaction_profiles/htc/vive_controller",
     {"/input/trigger/click", "/input/menu/click", "/input/squeeze/click"}},
    {"/interaction_profiles/valve/index_controller",
     {"/input/trigger/click", "/input/b/click", "/input/squeeze/value"}},
    {"/interaction_profiles/oculus/touch_controller",
     {"/input/trigger/value", "/input/thumbstick/click", "/input/squeeze/value"}},
    {"/interaction_profiles/microsoft/motion_controller",
     {"/input/trigger/value", "/input/menu/click", "/input/squeeze/click"}},
};

static XrPath path_of(const ost_headset *h, const char *hand, const char *rest)
{
    char text[128];
    XrPath path = XR_NULL_PATH;
    snprintf(text, sizeof text, "%s%s", hand, rest);
    xrStringToPath(h->instance, text, &path);
    return path;
}

static XrResult make_action(headset_actions *a, XrActionType type, const char *name, const char *shown, XrAction *out)
{
    XrActionCreateInfo what = {.type = XR_TYPE_ACTION_CREATE_INFO, .actionType = type};
    snprintf(what.actionName, sizeof what.actionName, "%s", name);
    snprintf(what.localizedActionName, sizeof what.localizedActionName, "%s", shown);
    return xrCreateAction(a->set, &what, out);
}

/* Suggests the bindings of a profile. Failure is ignored, because a runtime need not support every profile; if it
   supports none of them, the hand is never tracked. */
static void suggest(const ost_headset *h, const profile *p, const char *hand)
{
    XrActionSuggestedBinding binding[1 + HAND_BUTTONS] = {{h->actions.grip, path_of(h, hand, "/input/grip/pose")}};
    uint32_t count = 1;
    for (int i = 0; i < HAND_BUTTONS; i++)
        if (p->button[i])
            binding[count++] = (XrActionSuggestedBinding){h->actions.button[i], path_of(h, hand, p->button[i])};
    const XrInteractionProfileSuggestedBinding all = {.type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING,
                                                      .interactionProfile = path_of(h, p->path, ""),
                                                      .countSuggestedBindings = count,
                                                      .suggestedBindings = binding};
    xrSuggestInteractionProfileBindings(h->instance, &all);
}

ost_status headset_hand_begin(ost_headset *h, bool left, ost_error *err)
{
    static const char *const names[HAND_BUTTONS][2] = {
        {"trigger", "Motor"}, {"menu", "Next tool"}, {"squeeze", "Squeeze"}};
    headset_actions *a = &h->actions;
    const char *hand = left ? "/user/hand/left" : "/user/hand/right";
    const XrActionSetCreateInfo set = {
        .type = XR_TYPE_ACTION_SET_CREATE_INFO, .actionSetName = "hand", .localizedActionSetName = "Hand"};
    XrResult r = xrCreateActionSet(h->instance, &set, &a->set);
    if (XR_SUCCEEDED(r))
        r = make_action(a, XR_ACTION_TYPE_POSE_INPUT, "grip", "Tool", &a->grip);
    for (int i = 0; i < HAND_BUTTONS && XR_SUCCEEDED(r); i++)
        r = make_action(a, XR_ACTION_TYPE_BOOLEAN_INPUT, names[i][0], names[i][1], &a->button[i]);
    for (size_t i = 0; i < sizeof profiles / sizeof *profiles && XR_SUCCEEDED(r); i++)
        suggest(h, &profiles[i], hand);
    const XrActionSpaceCreateInfo space = {.type = XR_TYPE_ACTION_SPACE_CREATE_INFO,
                                           .action = a->grip,
                                           .poseInActionSpace = {.orientation = {0, 0, 0, 1}}};
    const XrSessionActionSetsAttachInfo attach = {
        .type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, .countActionSets = 1, .actionSets = &a->set};
    if (XR_SUCCEEDED(r))
        r = xrCreateActionSpace(h->session, &space, &a->space);
    if (XR_SUCCEEDED(r))
        r = xrAttachSessionActionSets(h->session, &attach);
    return headset_check(h, r, "prepares the controller", err);
}

ost_headset_hand headset_hand_read(ost_headset *h, XrTime time)
{
    const headset_actions *a = &h->actions;
    const XrActiveActionSet active = {.actionSet = a->set};
    const XrActionsSyncInfo sync = {
        .type = XR_TYPE_ACTIONS_SYNC_INFO, .countActiveActionSets = 1, .activeActionSets = &active};
    const XrSpaceLocationFlags needed = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    XrSpaceLocation l = {.type = XR_TYPE_SPACE_LOCATION};
    ost_headset_hand hand = {0};
    if (xrSyncActions(h->session, &sync) != XR_SUCCESS ||
        XR_FAILED(xrLocateSpace(a->space, h->room, time, &l)) || (l.locationFlags & needed) != needed)
        return hand;
    const XrVector3f *p = &l.pose.position;
    const XrQuaternionf *q = &l.pose.orientation;
    hand = (ost_headset_hand){.tracked = true, .at = {p->x, p->y, p->z}, .q = {q->w, q->x, q->y, q->z}};
    for (int i = 0; i < HAND_BUTTONS; i++) {
        XrActionStateBoolean state = {.type = XR_TYPE_ACTION_STATE_BOOLEAN};
        const XrActionStateGetInfo which = {.type = XR_TYPE_ACTION_STATE_GET_INFO, .action = a->button[i]};
        if (XR_SUCCEEDED(xrGetActionStateBoolean(h->session, &which, &state)) && state.isActive && state.currentState)
            hand.buttons |= UINT32_C(1) << i;
    }
    return hand;
}
