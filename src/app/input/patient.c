/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/patient.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/common/print.h"
#include "app/input/load.h"
#include "app/input/proposal.h"

enum { TRIPLE_TEXT = 3 * OST_PM_TEXT };

static ost_status set_triple(const char *name, const char *key, ost_pm3 v, ost_meta *meta, ost_error *err)
{
    char text[TRIPLE_TEXT], x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    snprintf(text, sizeof text, "%s %s %s", ost_pm_format(v.x, x), ost_pm_format(v.y, y), ost_pm_format(v.z, z));
    ost_status status = ost_meta_set(meta, key, text, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", name);
    return status;
}

/*
 * Stores an axis with nine decimal places, in the format that ost_axis_from_meta reads. A vector whose length is
 * above 1000 or below 0.001 is normalized first.
 */
static ost_status set_axis(const char *name, const double axis[3], ost_meta *meta, ost_error *err)
{
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]),
                 by = length > 1000 || length < 0.001 ? length : 1;
    if (!isfinite(length) || length == 0)
        return ost_fail(err, OST_ERR_USAGE, "%s: the axis (%g, %g, %g) is not a direction", name, axis[0], axis[1],
                        axis[2]);
    return set_triple(name, OST_META_GLENOID_AXIS,
                      (ost_pm3){llrint(axis[0] / by * 1e9), llrint(axis[1] / by * 1e9), llrint(axis[2] / by * 1e9)},
                      meta, err);
}

/* ------------------------------------------------------------------ checks */

static bool is_inside(const ost_geometry *g, ost_pm3 p)
{
    const ost_pm at[3] = {p.x - g->origin.x, p.y - g->origin.y, p.z - g->origin.z};
    const ost_pm step[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++)
        if (2 * at[a] < -step[a] || 2 * at[a] > (2 * n[a] - 1) * step[a])
            return false;
    return true;
}

/* The header facts that are checked against the grid and against each other. */
typedef struct orientation {
    ost_pm3 at;
    double axis[3];
    bool has_at, has_axis;
    ost_side side;
} orientation;

/* Reads all header facts about the patient. Returns an error if one of them cannot be parsed. */
static ost_status read_facts(const char *name, const ost_meta *meta, orientation *out, ost_error *err)
{
    ost_pm3 point;
    bool has_point;
    *out = (orientation){.side = OST_SIDE_UNKNOWN};
    ost_status status = ost_point_from_meta(meta, OST_META_GLENOID_AT, &out->at, &out->has_at, err);
    if (status == OST_OK)
        status = ost_point_from_meta(meta, OST_META_TRIGONUM, &point, &has_point, err);
    if (status == OST_OK)
        status = ost_point_from_meta(meta, OST_META_INFERIOR_ANGLE, &point, &has_point, err);
    if (status == OST_OK)
        status = ost_axis_from_meta(meta, out->axis, &out->has_axis, err);
    if (status == OST_OK)
        status = ost_side_from_meta(meta, &out->side, err);
    if (status != OST_OK)
        ost_fail_context(err, "%s", name);
    return status;
}

/*
 * Checks the header facts against the grid and against each other. If the axis determines the side, the side is
 * added.
 */
static ost_status resolve_orientation(const char *name, const ost_geometry *g, ost_meta *meta, ost_error *err)
{
    orientation facts;
    bool left;
    ost_status status = read_facts(name, meta, &facts, err);
    if (status != OST_OK)
        return status;
    const ost_pm3 at = facts.at;
    if (facts.has_at && !is_inside(g, at)) {
        char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
        const ost_pm3 hi = {g->origin.x + (g->dims.x - 1) * g->spacing.x, g->origin.y + (g->dims.y - 1) * g->spacing.y,
                            g->origin.z + (g->dims.z - 1) * g->spacing.z};
        status = ost_fail(err, OST_ERR_INPUT, "the glenoid at %s lies outside the grid, which is from %s to %s%s",
                          format_point(a, at), format_point(b, g->origin), format_point(c, hi),
                          is_inside(g, (ost_pm3){-at.x, -at.y, at.z})
                              ? "; with x and y negated it lies inside, so it is probably in RAS"
                              : "");
    }
    if (status == OST_OK && facts.has_axis) {
        status = ost_glenoid_side(facts.axis, facts.side, &left, err);
        if (status == OST_OK && facts.side == OST_SIDE_UNKNOWN)
            status = ost_meta_set(meta, OST_META_SIDE, left ? "left" : "right", err);
        /* If the header contains no side, verbs that need the side require --side. */
        if (status == OST_ERR_USAGE) {
            *err = (ost_error){0};
            status = OST_OK;
        }
    }
    if (status != OST_OK)
        ost_fail_context(err, "%s", name);
    return status;
}

/* ----------------------------------------------------------------- options */

/* Stores landmarks in meta. `file` is the name of the landmarks file, for messages. */
static ost_status store_landmarks(const app_state *app, const ost_landmarks *all, const char *file, const char *name,
                                  ost_meta *meta, ost_error *err)
{
    const ost_landmark *found[OST_LANDMARK_INFERIOR_ANGLE + 1] = {NULL};
    ost_status status = OST_OK;
    for (int i = 0; i < all->count; i++) {
        if (all->items[i].role != OST_LANDMARK_OTHER)
            found[all->items[i].role] = &all->items[i];
        else
            warn(app, "%s: unknown label '%s' ignored; expected glenoid, axis, trigonum or inferior angle", file,
                 all->items[i].label);
    }
    const ost_landmark *glenoid = found[OST_LANDMARK_GLENOID], *axis = found[OST_LANDMARK_AXIS_POINT];
    if (axis && !glenoid)
        status = ost_fail(err, OST_ERR_INPUT, "%s: '%s' needs the label glenoid, which the file does not have", file,
                          axis->label);
    if (status == OST_OK && glenoid)
        status = set_triple(name, OST_META_GLENOID_AT, glenoid->at, meta, err);
    if (status == OST_OK && axis) {
        double d[3] = {ost_pm_to_mm(axis->at.x - glenoid->at.x), ost_pm_to_mm(axis->at.y - glenoid->at.y),
                       ost_pm_to_mm(axis->at.z - glenoid->at.z)};
        const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if (length < 1)
            status = ost_fail(err, OST_ERR_INPUT,
                              "%s: '%s' is %.2g mm from '%s'; expected a point at least 1 mm into the bone", file,
                              axis->label, length, glenoid->label);
        for (int a = 0; a < 3; a++)
            d[a] /= length;
        if (status == OST_OK)
            status = set_axis(name, d, meta, err);
    }
    if (status == OST_OK && found[OST_LANDMARK_TRIGONUM])
        status = set_triple(name, OST_META_TRIGONUM, found[OST_LANDMARK_TRIGONUM]->at, meta, err);
    if (status == OST_OK && found[OST_LANDMARK_INFERIOR_ANGLE])
        status = set_triple(name, OST_META_INFERIOR_ANGLE, found[OST_LANDMARK_INFERIOR_ANGLE]->at, meta, err);
    return status;
}

/* Reads landmarks from a file or proposes landmarks for the bone. If requested, also writes the landmarks to a file. */
static ost_status take_landmarks(const app_state *app, const patient_options *options, const ost_bone *bone,
                                 const char *name, ost_meta *meta, ost_error *err)
{
    ost_landmarks all;
    const bool proposed = strcmp(options->landmarks, PROPOSAL_AUTO) == 0;
    ost_status status = proposed ? proposal_make(app, bone, name, meta, &all, err)
                                 : ost_landmarks_read(options->landmarks, &all, err);
    if (status == OST_OK)
        status = store_landmarks(app, &all, options->landmarks, name, meta, err);
    if (status == OST_OK && options->landmarks_out)
        status = ost_landmarks_write(options->landmarks_out, &all, err);
    ost_landmarks_free(&all);
    return status;
}

ost_status patient_check(app_state *app, const patient_options *options, ost_error *err)
{
    if (options->landmarks_out && !options->landmarks)
        return usage_error(app, err, "--landmarks-out needs --landmarks auto or --landmarks FILE");
    return options->landmarks_out ? out_check(app, options->landmarks_out, "mrk.json", err) : OST_OK;
}

ost_status patient_take(const app_state *app, const patient_options *options, const ost_bone *bone, const char *name,
                        const ost_geometry *geometry, ost_meta *meta, ost_error *err)
{
    const target_options *t = &options->target;
    ost_status status = OST_OK;
    if (!t->at_given && !t->axis_given && !t->side_given && !options->trigonum_given && !options->inferior_given &&
        !options->landmarks) {
        orientation stored;
        return read_facts(name, meta, &stored, err);
    }
    if (options->landmarks)
        status = take_landmarks(app, options, bone, name, meta, err);
    if (status == OST_OK && t->at_given)
        status = set_triple(name, OST_META_GLENOID_AT, t->at, meta, err);
    if (status == OST_OK && t->axis_given)
        status = set_axis(name, t->axis, meta, err);
    if (status == OST_OK && options->trigonum_given)
        status = set_triple(name, OST_META_TRIGONUM, options->trigonum, meta, err);
    if (status == OST_OK && options->inferior_given)
        status = set_triple(name, OST_META_INFERIOR_ANGLE, options->inferior, meta, err);
    if (status == OST_OK && t->side_given) {
        ost_side side;
        status = target_side(t, meta, name, &side, err);
        if (status == OST_OK)
            status = ost_meta_set(meta, OST_META_SIDE, side == OST_SIDE_LEFT ? "left" : "right", err);
    }
    return status == OST_OK ? resolve_orientation(name, geometry, meta, err) : status;
}

/* ------------------------------------------------------------------- --set */

static const struct {
    const char *option, *key;
    bool point;
} facts[] = {
    {"at", OST_META_GLENOID_AT, true},
    {"axis", OST_META_GLENOID_AXIS, false},
    {"side", OST_META_SIDE, false},
    {"trigonum", OST_META_TRIGONUM, true},
    {"inferior-angle", OST_META_INFERIOR_ANGLE, true},
};

static void remove_key(ost_meta *meta, const char *key)
{
    int kept = 0;
    for (int i = 0; i < meta->count; i++)
        if (strcmp(meta->entry[i].key, key) != 0)
            meta->entry[kept++] = meta->entry[i];
    meta->count = kept;
}

static ost_status set_one(const app_state *app, const char *text, ost_meta *meta, ost_error *err)
{
    const size_t length = strcspn(text, "=");
    const char *value = text + length + 1;
    for (size_t f = 0; f < sizeof facts / sizeof facts[0] && text[length]; f++) {
        const char *const spellings[2] = {facts[f].option, facts[f].key};
        for (int s = 0; s < 2; s++) {
            if (strlen(spellings[s]) != length || strncmp(spellings[s], text, length) != 0)
                continue;
            if (!*value) {
                remove_key(meta, facts[f].key);
                return OST_OK;
            }
            ost_status status = ost_meta_set(meta, facts[f].key, value, err);
            ost_pm3 point;
            bool there;
            /* A point is stored in the format of the header, as exact decimals separated by blanks. */
            if (status == OST_OK && facts[f].point) {
                if (ost_point_from_meta(meta, facts[f].key, &point, &there, NULL) != OST_OK)
                    return usage_error(app, err,
                                       "--set %s: expected three numbers X,Y,Z in millimetres, from -8000 to 8000",
                                       text);
                status = set_triple("--set", facts[f].key, point, meta, err);
            }
            double axis[3];
            if (status == OST_OK && strcmp(facts[f].key, OST_META_GLENOID_AXIS) == 0) {
                if (ost_axis_from_meta(meta, axis, &there, NULL) != OST_OK)
                    return usage_error(app, err, "--set %s: expected three numbers X,Y,Z, not all of them 0", text);
                status = set_axis("--set", axis, meta, err);
            }
            ost_side side;
            if (status == OST_OK && strcmp(facts[f].key, OST_META_SIDE) == 0 &&
                ost_side_from_meta(meta, &side, NULL) != OST_OK)
                return usage_error(app, err, "--set %s: expected left or right", text);
            return status;
        }
    }
    return usage_error(app, err,
                       "--set '%s': expected KEY=VALUE with the key at, axis, side, trigonum or inferior-angle", text);
}

ost_status patient_set(const app_state *app, const option_list *sets, const char *name, const ost_geometry *geometry,
                       ost_meta *meta, ost_error *err)
{
    const char *kind = ost_meta_get(meta, OST_META_KIND);
    if (kind && strcmp(kind, "tool") == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: is a tool; these facts are a bone's or a CT's", name);
    ost_status status = OST_OK;
    for (int i = 0; i < sets->count && status == OST_OK; i++)
        status = set_one(app, sets->value[i], meta, err);
    return status == OST_OK ? resolve_orientation(name, geometry, meta, err) : status;
}
