/* SPDX-License-Identifier: Apache-2.0 */
/*
 * motion: what a tracker saw of a hand, as a hand.
 *
 *   rows   *  *  *  *  .  .  .  .  *  *  *        . not seen
 *   ticks  ||||||||||||            ||||||||       a pose each
 *                      ----------                 UNSEEN: the tool stays
 *                                 ^ takes hold anew where the tool is
 *
 * It is as long as its table, and may begin and end unseen.  Between two rows
 * positions go straight and orientations along their arc.  Rows that lie
 * further apart than gap= are a time in which it was not seen.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/clutch.h"
#include "haptics/driver.h"
#include "io/motion_csv.h"

enum { TICK_NS = 1000000, GAP_MS = 50, FILE_NAME = 4096 };
#define SCALE_PERCENT 5.0

struct haptic_instance {
    motion motion;
    size_t row;      /* the last at or before t_ns */
    int64_t t_ns, gap_ns;
    haptic_clutch clutch;
};

typedef struct choice {
    double percent;
    int64_t gap_ms;
} choice;

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "scale") == 0)
        return haptic_number("motion", key, value, 0.1, 1000, &c->percent, err);
    if (strcmp(key, "gap") == 0)
        return haptic_integer("motion", key, value, 1, 60000, &c->gap_ms, err);
    return ost_fail(err, OST_ERR_USAGE, "device motion: it has no option '%s'; known are scale, per cent, and gap, ms", key);
}

static void motion_close(haptic_instance *m)
{
    motion_free(&m->motion);
    free(m);
}

static ost_status motion_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    choice c = {.percent = SCALE_PERCENT, .gap_ms = GAP_MS};
    char file[FILE_NAME];
    const size_t length = strcspn(options, ",");
    if (length == 0 || length >= sizeof file)
        return ost_fail(err, OST_ERR_USAGE, "device motion: needs the file of a motion, as in motion:hand.csv,scale=5");
    memcpy(file, options, length);
    file[length] = '\0';
    ost_status status = options[length] ? haptic_options("motion", options + length + 1, take, &c, err) : OST_OK;
    if (status == OST_OK)
        status = ost_pose_check(&setup->start, err);
    if (status != OST_OK)
        return status;
    haptic_instance *m = calloc(1, sizeof *m);
    if (!m)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for device motion");
    status = motion_read_csv(file, &m->motion, err);
    if (status != OST_OK) {
        free(m);
        return status;
    }
    m->t_ns = m->motion.rows[0].t_ns;
    m->gap_ns = c.gap_ms * 1000000;
    m->clutch = haptic_clutch_make(&setup->start, c.percent / 100);
    *out = m;
    return OST_OK;
}

/* Along the arc from a to b, the shorter way. */
static void slerp(const double a[4], const double b[4], double share, double out[4])
{
    double dot = 0, length = 0;
    for (int i = 0; i < 4; i++)
        dot += a[i] * b[i];
    const double side = dot < 0 ? -1 : 1, angle = acos(fmin(1, fabs(dot)));
    /* Below a milliradian arc and chord are the same to 1e-7. */
    const double wa = angle < 1e-3 ? 1 - share : sin((1 - share) * angle) / sin(angle);
    const double wb = angle < 1e-3 ? share : sin(share * angle) / sin(angle);
    for (int i = 0; i < 4; i++) {
        out[i] = wa * a[i] + side * wb * b[i];
        length += out[i] * out[i];
    }
    for (int i = 0; i < 4; i++)
        out[i] /= sqrt(length);
}

static ost_haptic_answer motion_read(haptic_instance *m, ost_haptic_state *state)
{
    const motion_row *rows = m->motion.rows;
    const size_t last = m->motion.count - 1;
    const int64_t t = m->t_ns;
    if (t > rows[last].t_ns)
        return OST_HAPTIC_ENDED;
    m->t_ns += TICK_NS;
    while (m->row < last && rows[m->row + 1].t_ns <= t)
        m->row++;
    const motion_row *a = &rows[m->row], *b = m->row < last ? a + 1 : a;
    if (!motion_seen(a) || (t > a->t_ns && (!motion_seen(b) || b->t_ns - a->t_ns > m->gap_ns))) {
        haptic_clutch_release(&m->clutch);
        return OST_HAPTIC_UNSEEN;
    }
    const double share = b == a || !motion_seen(b) ? 0 : (double)(t - a->t_ns) / (double)(b->t_ns - a->t_ns);
    double at[3], q[4];
    for (int i = 0; i < 3; i++)
        at[i] = a->at[i] + share * (b->at[i] - a->at[i]);
    slerp(a->q, motion_seen(b) ? b->q : a->q, share, q);
    *state = (ost_haptic_state){.pose = haptic_clutch_pose(&m->clutch, at, q), .tool = -1};
    return OST_HAPTIC_FRESH;
}

const haptic_driver haptic_motion = {
    .name = "motion",
    .description = "a hand that was tracked, from a file: motion:FILE.csv",
    .caps = OST_HAPTIC_ORIENTATION | OST_HAPTIC_LOGICAL,
    .open = motion_open,
    .close = motion_close,
    .read = motion_read,
};
