/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/appearance.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/picture/implant.h"
#include "app/picture/landmarks.h"
#include "core/vector.h"
#include "render/marks.h"
#include "window/window.h"

enum { TEXT = 160 };
static const double RADIANS = 0.017453292519943295, STEP_MM = 0.5, STEP_DEG = 5;
static const char *const clip_names[CLIP_NAMES] = {"none", "plan", "across", "axial", "coronal", "sagittal"};

/* ----------------------------------------------------------------- options */

static bool six_numbers(const char *text, double out[6])
{
    const char *p = text, *end = text + strlen(text);
    for (int i = 0; i < 6; i++) {
        ost_decimal d;
        int64_t micro;
        const char *after = ost_decimal_read(p, end, &d);
        if (!after || after == p || (i < 5 ? after == end || *after != ',' : after != end) ||
            !ost_decimal_scale(&d, 1000000, &micro, NULL))
            return false;
        out[i] = (double)micro * 1e-6;
        p = after + 1;
    }
    return true;
}

static ost_status thousandths(const app_state *app, const option_decimal *given, const char *name, int most,
                              double *out, ost_error *err)
{
    int64_t n;
    if (!given->text)
        return OST_OK;
    if (!ost_decimal_scale(&given->value, 1000, &n, NULL) || n < -1000 * (int64_t)most || n > 1000 * (int64_t)most)
        return usage_error(app, err, "--%s %s: must be from -%d to %d", name, given->text, most, most);
    *out = (double)n * 1e-3;
    return OST_OK;
}

static ost_status check_clip(const app_state *app, appearance_options *o, ost_error *err)
{
    double n[6];
    if (!o->clip_text)
        return o->shift.text || o->turn.text ? usage_error(app, err, "--clip-shift and --clip-turn need --clip")
                                             : OST_OK;
    for (int i = 1; i < CLIP_NAMES; i++)
        if (strcmp(o->clip_text, clip_names[i]) == 0)
            o->clip = i;
    if (o->clip == CLIP_NONE && six_numbers(o->clip_text, n)) {
        o->clip = CLIP_FREE;
        memcpy(o->clip_at, n, sizeof o->clip_at);
        memcpy(o->clip_normal, n + 3, sizeof o->clip_normal);
        if (n[3] == 0 && n[4] == 0 && n[5] == 0)
            return usage_error(app, err, "--clip %s: the last three numbers are not a direction", o->clip_text);
    }
    if (o->clip == CLIP_NONE) {
        const char *near = nearest_name(o->clip_text, clip_names + 1, CLIP_NAMES - 1);
        return usage_error(app, err,
                           "--clip %s: expected plan, across, axial, coronal, sagittal or x,y,z,nx,ny,nz%s%s%s",
                           o->clip_text, near ? "; did you mean " : "", near ? near : "", near ? "?" : "");
    }
    if (o->turn.text && o->clip != CLIP_PLAN && o->clip != CLIP_ACROSS)
        return usage_error(app, err, "--clip-turn needs --clip plan or across");
    return OST_OK;
}

ost_status appearance_check(const app_state *app, appearance_options *o, ost_error *err)
{
    for (int i = 0; i < o->overlays.count; i++) {
        const char *name = o->overlays.value[i];
        int k = 0;
        while (k < OST_OVERLAY_COUNT && strcmp(name, ost_overlay_names[k]) != 0)
            k++;
        if (k == OST_OVERLAY_COUNT) {
            const char *near = nearest_name(name, ost_overlay_names, OST_OVERLAY_COUNT);
            return usage_error(app, err, "--overlay %s: unknown overlay; did you mean %s?", name,
                               near ? near : ost_overlay_names[0]);
        }
        o->overlay_bits |= 1u << k;
    }
    ost_status status = check_clip(app, o, err);
    if (status == OST_OK)
        status = thousandths(app, &o->shift, "clip-shift", 1000, &o->shift_mm, err);
    return status == OST_OK ? thousandths(app, &o->turn, "clip-turn", 360, &o->turn_deg, err) : status;
}

/* -------------------------------------------------------------------- clip */

/*
 * Computes three perpendicular unit vectors: `inward` is the direction of the glenoid's axis, `right` is horizontal,
 * and `above` points upward.
 */
static void axis_frame(const ost_view_subject *s, double inward[3], double right[3], double above[3])
{
    static const double lateral[3] = {-1, 0, 0}, top[3] = {0, 0, 1};
    memcpy(inward, s->has_face ? s->inward : lateral, 3 * sizeof(double));
    ost_vector_cross(inward, top, right);
    ost_vector_unit(right, 0);
    ost_vector_cross(right, inward, above);
}

static void plane(const appearance *a, double at[3], double normal[3])
{
    double inward[3], right[3], above[3];
    const int kind = a->clip;
    axis_frame(a->subject, inward, right, above);
    memcpy(at, a->subject->has_face ? a->subject->face : a->subject->middle, 3 * sizeof(double));
    const double turn = (a->turn_deg + (kind == CLIP_ACROSS ? 90 : 0)) * RADIANS, c = cos(turn), s = sin(turn);
    for (int i = 0; i < 3; i++)
        normal[i] = kind == CLIP_AXIAL      ? i == 2
                    : kind == CLIP_CORONAL  ? i == 1
                    : kind == CLIP_SAGITTAL ? i == 0
                                            : c * right[i] + s * above[i];
    if (kind == CLIP_FREE) {
        memcpy(at, a->clip_at, 3 * sizeof(double));
        memcpy(normal, a->clip_normal, 3 * sizeof(double));
        ost_vector_unit(normal, 0);
    }
    for (int i = 0; i < 3; i++) {
        normal[i] = a->flipped ? -normal[i] : normal[i];
        at[i] -= a->shift_mm * normal[i];
    }
}

static ost_status set_clip(appearance *a, ost_error *err)
{
    double at[3], normal[3];
    ost_clip clip;
    if (a->clip == CLIP_NONE) {
        ost_viewer_set_clip(a->viewer, NULL);
        return OST_OK;
    }
    plane(a, at, normal);
    ost_status status = ost_clip_make(&a->viewer->bone.geometry, at, normal, &clip, err);
    if (status == OST_OK)
        ost_viewer_set_clip(a->viewer, &clip);
    return status;
}

/*
 * Turns the normal of the clip plane towards the camera at eye_mm, because the part in front of a clip plane is
 * hidden.
 */
static void face_the_eye(appearance *a, const double eye_mm[3])
{
    double at[3], normal[3], back[3];
    a->flipped = false;
    if (a->clip == CLIP_FREE)
        return;
    plane(a, at, normal);
    for (int i = 0; i < 3; i++)
        back[i] = eye_mm[i] - at[i];
    a->flipped = ost_vector_dot(back, normal) < 0;
}

/* ------------------------------------------------------------------- ghost */

/*
 * Returns the distance from the tool's origin to the lowest point of the tool, in mm. The grid begins one to two
 * voxels below this point (Alg. 2.1).
 */
static double tip_of(const ost_tool_volume *tool)
{
    return -1e-9 * (double)(tool->geometry.corner.z + 3 * tool->geometry.voxel / 2);
}

static ost_status set_ghost(appearance *a, ost_error *err)
{
    double inward[3], right[3], above[3], back[3], q[4], at[3];
    ost_tool_volume implant = {0};
    ost_pose pose;
    a->viewer->show_ghost = false;
    if (a->ghost == GHOST_NONE)
        return OST_OK;
    axis_frame(a->subject, inward, right, above);
    for (int i = 0; i < 3; i++)
        back[i] = -inward[i];
    ost_vector_cross(above, back, right);  /* right, above and back are the x, y and z axes of a right-handed frame */
    const double columns[3][3] = {
        {right[0], right[1], right[2]}, {above[0], above[1], above[2]}, {back[0], back[1], back[2]}};
    ost_quaternion_of_columns(columns, q);
    const double deep = a->depth_mm - (a->ghost == GHOST_TOOL && a->tool ? tip_of(a->tool) : 0);
    for (int i = 0; i < 3; i++)
        at[i] = a->subject->face[i] + deep * inward[i];
    ost_status status = ost_pose_from_doubles(at, q, &pose, err);
    if (status == OST_OK && a->ghost == GHOST_IMPLANT)
        status = implant_make(&implant, err);
    if (status == OST_OK)
        status = ost_viewer_set_ghost(a->viewer, a->ghost == GHOST_IMPLANT ? &implant : a->tool, &pose, err);
    ost_tool_volume_free(&implant);
    return status;
}

/* ------------------------------------------------------------------- begin */

ost_status appearance_begin(appearance *a, ost_viewer *viewer, const ost_view_subject *subject, double depth_mm,
                            const ost_tool_volume *tool, const appearance_options *options, const double eye_mm[3],
                            ost_error *err)
{
    *a = (appearance){
        .viewer = viewer,
        .subject = subject,
        .depth_mm = depth_mm,
        .tool = tool,
        .colouring = (ost_colouring)options->colour,
        .clip = options->clip,
        .shift_mm = options->shift_mm,
        .turn_deg = options->turn_deg,
        .ghost = options->ghost,
    };
    memcpy(a->clip_at, options->clip_at, sizeof a->clip_at);
    memcpy(a->clip_normal, options->clip_normal, sizeof a->clip_normal);
    if (a->ghost != GHOST_NONE && !subject->has_face)
        return ost_fail(err, OST_ERR_USAGE, "--ghost needs the glenoid: pass --at and --axis");
    if (a->ghost == GHOST_TOOL && !tool)
        return ost_fail(err, OST_ERR_USAGE, "--ghost tool needs --tool TOOL");
    viewer->antialiased = true;
    viewer->overlays = options->overlay_bits;
    viewer->scene.planned = subject->has_face;
    viewer->scene.depth_mm = depth_mm;
    memcpy(viewer->scene.face_mm, subject->face, sizeof subject->face);
    memcpy(viewer->scene.inward, subject->inward, sizeof subject->inward);
    ost_status status = OST_OK;
    if (options->overlay_bits >> OST_OVERLAY_LANDMARKS & 1)
        status = landmarks_show(subject, viewer, err);
    ost_viewer_set_colouring(viewer, a->colouring);
    face_the_eye(a, eye_mm);
    if (status == OST_OK)
        status = set_clip(a, err);
    return status == OST_OK ? set_ghost(a, err) : status;
}

void appearance_free(appearance *a)
{
    ost_lettering_free(a->lettering);
    *a = (appearance){.viewer = NULL};
}

ost_legend appearance_legend_of(const appearance *a)
{
    return (ost_legend){a->colouring, a->viewer->reference.scale_mm, a->viewer->reference.has_face,
                        a->clip != CLIP_NONE};
}

ost_status appearance_marks(appearance *a, const ost_orbit *orbit, bool oriented, ost_error *err)
{
    const ost_sheet sheet = ost_frame_sheet(&a->viewer->frame);
    const double unit = ost_marks_unit(sheet.height);
    ost_marks marks = {.legend = appearance_legend_of(a)};
    double back[3];
    if (orbit)
        marks.mm_per_pixel = orbit->distance / (OST_VIEW_FOCAL * sheet.height);
    if (orbit && oriented)
        ost_orbit_frame(orbit, marks.right, marks.up, back);
    if (!a->lettering || unit != a->unit) {
        ost_lettering_free(a->lettering);
        a->lettering = NULL;
        ost_status status = ost_lettering_create(OST_MARKS_LETTER * unit, &a->lettering, err);
        if (status != OST_OK)
            return status;
        a->unit = unit;
    }
    ost_marks_draw(&marks, a->lettering, &sheet, unit);
    return OST_OK;
}

/* -------------------------------------------------------------------- keys */

static void turn_overlays(appearance *a, char *text)
{
    static const unsigned steps[] = {0,
                                     1u << OST_OVERLAY_AXIS,
                                     1u << OST_OVERLAY_BOXES | 1u << OST_OVERLAY_HITS,
                                     1u << OST_OVERLAY_CHUNKS,
                                     1u << OST_OVERLAY_TOOL_VOXELS | 1u << OST_OVERLAY_BONE_VOXELS};
    static const char *const names[] = {"no lines", "the planned axis", "boxes, and the chunks that the tool meets",
                                        "chunks: active ones red", "voxels: the tool's green, the bone's red"};
    a->overlay_step = (a->overlay_step + 1) % (int)(sizeof steps / sizeof *steps);
    a->viewer->overlays = steps[a->overlay_step];
    snprintf(text, TEXT, "lines: %s", names[a->overlay_step]);
}

static void turn_clip(appearance *a, bool shift, const double eye_mm[3], char *text)
{
    static const char *const names[] = {
        "none", "along the axis, upright", "along the axis, across", "axial", "coronal", "sagittal", "as given"};
    if (shift && a->clip != CLIP_NONE)
        a->flipped = !a->flipped;
    else {
        a->clip = (a->clip + 1) % CLIP_NAMES;
        a->shift_mm = a->turn_deg = 0;
        face_the_eye(a, eye_mm);
    }
    snprintf(text, TEXT, "clip plane: %s%s", names[a->clip],
             a->clip == CLIP_NONE ? "" : "; page up and down move it, with shift they turn it");
}

static void turn_colours(appearance *a, char *text)
{
    static const char *const names[] = {"as bone", "by density class", "by depth below the old surface", "by density"};
    a->colouring = (ost_colouring)((a->colouring + 1) % (a->viewer->has_uncut ? OST_COLOUR_COUNT : 1));
    ost_viewer_set_colouring(a->viewer, a->colouring);
    snprintf(text, TEXT, "what is cut: %s", names[a->colouring]);
}

static void turn_ghost(appearance *a, char *text)
{
    static const char *const names[] = {"none", "the planned implant", "the tool at the planned depth"};
    a->ghost = a->subject->has_face ? (a->ghost + 1) % (a->tool ? 3 : 2) : GHOST_NONE;
    snprintf(text, TEXT, "ghost: %s", a->subject->has_face ? names[a->ghost] : "none, since there is no plan");
}

bool appearance_key(appearance *a, int key, bool shift, const double eye_mm[3], char *text)
{
    ost_error err = {0};
    ost_status status = OST_OK;
    const int away = (key == OST_KEY_PAGE_UP) - (key == OST_KEY_PAGE_DOWN);
    text[0] = '\0';
    if (key == 'C')
        turn_colours(a, text);
    else if (key == 'X') {
        turn_clip(a, shift, eye_mm, text);
        status = set_clip(a, &err);
    } else if (away != 0) {
        if (a->clip == CLIP_NONE)
            return true;
        if (shift)
            a->turn_deg += away * STEP_DEG;
        else
            a->shift_mm += away * STEP_MM;
        snprintf(text, TEXT, "clip plane: %+.1f mm, %+.0f degrees", a->shift_mm, a->turn_deg);
        status = set_clip(a, &err);
    } else if (key == 'G') {
        turn_ghost(a, text);
        status = set_ghost(a, &err);
    } else if (key == 'O')
        turn_overlays(a, text);
    else if (key == 'K') {
        ost_viewer_set_contact(a->viewer, !a->viewer->bone.shows_contact);
        snprintf(text, TEXT, "where bone goes: %s", a->viewer->bone.shows_contact ? "shown for a moment" : "not shown");
    } else
        return false;
    if (status != OST_OK)
        snprintf(text, TEXT, "%.150s", err.text);
    return true;
}

bool appearance_wheel(appearance *a, double steps, bool fine)
{
    if (a->clip == CLIP_NONE)
        return false;
    a->shift_mm += steps * STEP_MM * (fine ? 0.2 : 1);
    set_clip(a, NULL);
    return true;
}
