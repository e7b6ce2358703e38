/* SPDX-License-Identifier: Apache-2.0 */
#include "app/debrief/verdict.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define AIM_DEPTH_MM 0.5
#define AIM_ENTRY_MM 1.0
#define AIM_GAP_MM 1.0
#define AIM_WALL_MM 2.0
#define AIM_OVER_MM3 20.0
#define AIM_CONTACT 90.0
/*
 * The operation is graded "Far off the plan" if a figure exceeds its tolerance by more than this factor, or if a wall
 * is perforated.
 */
#define FAR_TIMES 8.0

const char *const verdict_grades[VERDICT_GRADES] = {"As planned", "Near the plan", "Off the plan", "Far off the plan"};

static level judge(double value, double good, double watch)
{
    return fabs(value) <= good ? GOOD : fabs(value) <= watch ? WATCH : BAD;
}

/*
 * Adds a remark if the figure exceeds its tolerance. The list of remarks begins with the figure that exceeds its
 * tolerance by the largest factor.
 */
static void notice(verdict *v, level l, double times, const char *format, ...) OST_PRINTF(4, 5);

static void notice(verdict *v, level l, double times, const char *format, ...)
{
    va_list args;
    if (l == GOOD || l == NONE || v->count == REMARKS)
        return;
    int at = v->count++;
    v->worst = l > v->worst ? l : v->worst;
    if (times > v->times) {
        v->times = times;
        memmove(v->remark[1], v->remark[0], (size_t)at * sizeof v->remark[0]);
        memmove(v->of + 1, v->of, (size_t)at * sizeof v->of[0]);
        at = 0;
    }
    v->of[at] = l;
    va_start(args, format);
    vsnprintf(v->remark[at], REMARK, format, args);
    va_end(args);
}

static void judge_axis(const debrief *d, const ost_metrics *m, verdict *v)
{
    const double off = m->reach_mm - d->plan.depth_mm;
    v->tilt = judge(m->tilt_deg, AIM_DEG, WATCH_DEG);
    notice(v, v->tilt, m->tilt_deg / AIM_DEG,
           "reamed along an axis tilted by %.1f degrees from the planned one; up to %d degrees are allowed",
           m->tilt_deg, AIM_DEG);
    v->version = judge(m->version_error_deg, AIM_DEG, WATCH_DEG);
    v->inclination = judge(m->inclination_error_deg, AIM_DEG, WATCH_DEG);
    v->depth = judge(off, AIM_DEPTH_MM, 2 * AIM_DEPTH_MM);
    notice(v, v->depth, fabs(off) / AIM_DEPTH_MM, "reamed %.1f mm too %s; up to %.1f mm are allowed", fabs(off),
           off > 0 ? "deep" : "shallow", AIM_DEPTH_MM);
    v->entry = judge(m->entry_mm, AIM_ENTRY_MM, 2 * AIM_ENTRY_MM);
    notice(v, v->entry, m->entry_mm / AIM_ENTRY_MM,
           "the reamer entered %.1f mm off the planned centre; up to %.0f mm are allowed", m->entry_mm, AIM_ENTRY_MM);
}

static void judge_seat(const ost_metrics *m, verdict *v)
{
    v->contact = m->contact_percent >= AIM_CONTACT ? GOOD : m->contact_percent >= 75 ? WATCH : BAD;
    notice(v, v->contact, (100 - m->contact_percent) / (100 - AIM_CONTACT),
           "backing contact would be %.0f %%; at least %.0f %% are required", m->contact_percent, AIM_CONTACT);
    v->gap = judge(m->gap_max_mm, AIM_GAP_MM, 2 * AIM_GAP_MM);
    notice(v, v->gap, m->gap_max_mm / AIM_GAP_MM,
           "the widest gap under an implant would be %.1f mm; up to %.0f mm are allowed", m->gap_max_mm, AIM_GAP_MM);
}

static void judge_hole(const ost_metrics *m, verdict *v)
{
    v->hole_angle = judge(m->hole_angle_deg, AIM_DEG, WATCH_DEG);
    notice(v, v->hole_angle, m->hole_angle_deg / AIM_DEG,
           "the peg hole is tilted by %.1f degrees from the planned axis; up to %d degrees are allowed",
           m->hole_angle_deg, AIM_DEG);
    v->hole_entry = judge(m->hole_entry_mm, AIM_ENTRY_MM, 2 * AIM_ENTRY_MM);
    notice(v, v->hole_entry, m->hole_entry_mm / AIM_ENTRY_MM,
           "the peg hole begins %.1f mm off the planned centre; up to %.0f mm are allowed", m->hole_entry_mm,
           AIM_ENTRY_MM);
    v->wall = m->hole_breach ? BAD : m->hole_wall_mm < AIM_WALL_MM ? WATCH : GOOD;
    if (m->hole_breach)
        notice(v, BAD, FAR_TIMES + 1, "the peg hole breaks through the wall of the vault");
    else
        notice(v, v->wall, 1 + AIM_WALL_MM - m->hole_wall_mm,
               "only %.1f mm of bone are left between the peg hole and the wall of the vault; at least %.0f mm are "
               "required",
               m->hole_wall_mm, AIM_WALL_MM);
}

static void add(verdict *v, const char *format, ...) OST_PRINTF(2, 3);

static void add(verdict *v, const char *format, ...)
{
    const size_t used = strlen(v->line);
    va_list args;
    va_start(args, format);
    vsnprintf(v->line + used, sizeof v->line - used, format, args);
    va_end(args);
}

static void make_line(const debrief *d, const ost_metrics *m, verdict *v)
{
    add(v, "%s", verdict_grades[v->grade]);
    if (v->count) {
        add(v, ": %s", v->remark[0]);
        if (v->times >= 1.05 && !m->hole_breach)
            add(v, " (%.1f times the tolerance)", v->times);
    }
    if (m->reamed)
        add(v,
            ". Reamed %.1f mm deep of %.1f planned, axis tilt %.1f degrees, entry %.1f mm off, over-reaming %.0f mm3",
            m->reach_mm, d->plan.depth_mm, m->tilt_deg, m->entry_mm, m->over_mm3);
    else
        add(v, ". The face was not reamed; over-reaming %.0f mm3", m->over_mm3);
    if (m->plate_mm3 > 0)
        add(v, ", subchondral bone preserved %.0f %%", m->plate_kept_percent);
    if (m->hole && m->hole_breach)
        add(v, ", peg hole through the wall of the vault");
    else if (m->hole)
        add(v, ", peg hole inside the bone");
    add(v, ".");
}

void verdict_make(const debrief *d, const ost_metrics *m, verdict *out)
{
    *out = (verdict){NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, .worst = GOOD};
    if (m->reamed)
        judge_axis(d, m, out);
    out->over = judge(m->over_mm3, AIM_OVER_MM3, 5 * AIM_OVER_MM3);
    notice(out, out->over, fmax(1, m->over_max_mm),
           "%.0f mm3 were removed more than 1 mm deeper than planned; up to %.0f mm3 are allowed", m->over_mm3,
           AIM_OVER_MM3);
    if (m->sphere)
        judge_seat(m, out);
    if (m->plate_mm3 > 0) {
        out->plate = m->plate_kept_percent >= PLATE_GOOD ? GOOD : m->plate_kept_percent >= PLATE_WATCH ? WATCH : BAD;
        notice(out, out->plate, (100 - m->plate_kept_percent) / (100 - PLATE_GOOD),
               "only %.0f %% of the subchondral bone are preserved; at least %d %% are required", m->plate_kept_percent,
               PLATE_GOOD);
    }
    if (m->hole)
        judge_hole(m, out);
    if (d->count) {
        out->plunge = d->technique.plunges ? WATCH : GOOD;
        notice(out, out->plunge, 1, "the tool plunged %d time%s, %.1f mm at the most", d->technique.plunges,
               d->technique.plunges == 1 ? "" : "s", d->technique.plunge_mm);
    }
    out->grade = out->worst == GOOD ? 0 : out->worst == WATCH ? 1 : out->times <= FAR_TIMES ? 2 : 3;
    make_line(d, m, out);
}
