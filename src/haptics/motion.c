/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `motion` driver: plays back a tracked hand's motion from a path in text form (io/path_csv.c).
 *
 *   rows   *  *  *  *  .  .  .  .  *  *  *        . row without a pose
 *   ticks  ||||||||||||            ||||||||       one pose per tick
 *                      ----------                 OST_HAPTIC_NOT_TRACKED: the tool stays
 *                                 ^ lifted row: the clutch engages with the tool at its current position
 *
 * The motion lasts from the first row of the table to the last. Tracking may be lost at the
 * beginning and at the end. Between two rows, positions are interpolated linearly and orientations
 * along the shorter arc. Tracking is lost before a lifted row (AR-PATH-4, AR-PATH-5).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/io.h>

#include "core/quaternion.h"
#include "haptics/clutch.h"
#include "haptics/driver.h"

enum { TICK_NS = 1000000, FILE_NAME = 4096 };
#define SECONDS_MAX INT64_C(86400)
#define SCALE_PERCENT 5.0

struct haptic_instance {
    ost_path path;   /* owned */
    size_t row;      /* index of the last row whose time is at most t_ns; 0 if there is no such row */
    int64_t t_ns, end_ns;
    haptic_clutch clutch;
};

typedef struct choice {
    double percent, jump_mm;
    int64_t gap_ms;
} choice;

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "scale") == 0)
        return ost_haptic_number("motion", key, value, 0.1, 1000, &c->percent, err);
    if (strcmp(key, "gap") == 0)
        return ost_haptic_integer("motion", key, value, 1, 60000, &c->gap_ms, err);
    if (strcmp(key, "jump") == 0)
        return ost_haptic_number("motion", key, value, 0.1, 1000, &c->jump_mm, err);
    return ost_fail(err, OST_ERR_USAGE,
                    "device motion: unknown option '%s'; expected scale (per cent), gap (ms) or jump (mm)", key);
}

static void motion_close(haptic_instance *m)
{
    ost_path_free(&m->path);
    free(m);
}

static ost_status motion_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    choice c = {.percent = SCALE_PERCENT, .jump_mm = 0};
    char file[FILE_NAME];
    const size_t length = strcspn(options, ",");
    if (length == 0 || length >= sizeof file)
        return ost_fail(err, OST_ERR_USAGE,
                        "device motion: no file given; expected for example motion:hand.csv,scale=5");
    memcpy(file, options, length);
    file[length] = '\0';
    ost_status status = options[length] ? ost_haptic_options("motion", options + length + 1, take, &c, err) : OST_OK;
    if (status == OST_OK)
        status = ost_pose_check(&setup->start, err);
    if (status != OST_OK)
        return status;
    haptic_instance *m = calloc(1, sizeof *m);
    if (!m)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device motion");
    const ost_path_options gaps = {c.gap_ms ? c.gap_ms * 1000000 : setup->gaps.max_gap_ns,
                                   c.jump_mm > 0 ? (ost_pm)(c.jump_mm * (double)OST_PM_PER_MM)
                                                 : setup->gaps.max_jump_pm};
    ost_path_report table;
    status = ost_path_read(file, &gaps, &m->path, &table, err);
    if (status == OST_OK && table.end_ns - table.begin_ns > SECONDS_MAX * 1000000000)
        status = ost_fail(err, OST_ERR_RANGE, "%s: lasts from %.9g to %.9g s; device motion plays a day at most", file,
                          (double)table.begin_ns * 1e-9, (double)table.end_ns * 1e-9);
    if (status != OST_OK) {
        motion_close(m);
        return status;
    }
    m->t_ns = table.begin_ns;
    m->end_ns = table.end_ns;
    m->clutch = ost_haptic_clutch_make(&setup->start, c.percent / 100);
    *out = m;
    return OST_OK;
}

/* Interpolates from a to b along the shorter arc (spherical linear interpolation). */
static void slerp(const double a[4], const double b[4], double share, double out[4])
{
    double dot = 0;
    for (int i = 0; i < 4; i++)
        dot += a[i] * b[i];
    const double side = dot < 0 ? -1 : 1, angle = acos(fmin(1, fabs(dot)));
    /* For angles below one milliradian, the arc and the chord agree to 1e-7. */
    const double wa = angle < 1e-3 ? 1 - share : sin((1 - share) * angle) / sin(angle);
    const double wb = angle < 1e-3 ? share : sin(share * angle) / sin(angle);
    for (int i = 0; i < 4; i++)
        out[i] = wa * a[i] + side * wb * b[i];
    ost_quaternion_unit(out);
}

static ost_haptic_answer motion_read(haptic_instance *m, ost_haptic_state *state)
{
    const ost_tick *ticks = m->path.ticks;
    const size_t last = m->path.count - 1;
    const int64_t t = m->t_ns;
    if (t > m->end_ns)
        return OST_HAPTIC_ENDED;
    m->t_ns += TICK_NS;
    while (m->row < last && ticks[m->row + 1].t_ns <= t)
        m->row++;
    const ost_tick *a = &ticks[m->row], *b = m->row < last ? a + 1 : a;
    if (t < a->t_ns || (t > a->t_ns && (b == a || b->lifted))) {
        ost_haptic_clutch_release(&m->clutch);
        return OST_HAPTIC_NOT_TRACKED;
    }
    const double share = b == a ? 0 : (double)(t - a->t_ns) / (double)(b->t_ns - a->t_ns);
    double at[3], to[3], from_q[4], to_q[4], q[4];
    ost_haptic_pose_to_metres(&a->pose, at, from_q);
    ost_haptic_pose_to_metres(&b->pose, to, to_q);
    for (int i = 0; i < 3; i++)
        at[i] += share * (to[i] - at[i]);
    slerp(from_q, to_q, share, q);
    *state = (ost_haptic_state){.pose = ost_haptic_clutch_pose(&m->clutch, at, q), .tool = -1};
    return OST_HAPTIC_FRESH;
}

const haptic_driver ost_haptic_motion = {
    .name = "motion",
    .description = "a recorded motion of a hand: motion:FILE.csv",
    .caps = OST_HAPTIC_ORIENTATION | OST_HAPTIC_LOGICAL,
    .open = motion_open,
    .close = motion_close,
    .read = motion_read,
};
