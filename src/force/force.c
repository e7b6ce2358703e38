/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The two laws (docs/force.md).
 *
 *   energy    device o~~~spring, damper~~~o tool | points: f = b * advance
 *
 *     K (x_d - x) + D (v_d - v) = sum over touching points of b (inward . -v)+ (-inward)
 *     b = area * energy / (cutting ratio * speed of the point)
 *
 *   Who presses a point into bone at speed v cuts area * v * energy watts; the
 *   cutting friction, ratio * f at the point's speed, gives them.  So contact
 *   is a damper and never a spring: nothing of it can swing.  The equation is
 *   solved for the end of the tick, and the set of points that press is found
 *   by trying: each solution says which do.
 *
 *   instant   f = layer stiffness * (density / reference)^2 * area * depth
 *
 *   The sum of the points' stiffness is at most the coupling's.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/backend.h"
#include "force/contact.h"

enum { TOOLS_MAX = 16, SETS = 8, PARTS = 8 };
#define RIGID 1e12     /* N s/m^3: of a point that does not cut */
#define NEAR_AXIS 1e-3 /* m: what is nearer to the axis cuts as if it were so far from it */
#define VELOCITY_HZ 50.0
#define DRAG_S 0.1

struct ost_force {
    const ost_bone *bone;
    ost_force_params params;
    int tools;
    ost_shell shells[TOOLS_MAX];
    bool held;          /* a tool is in the hand: the rest is of it */
    int tool;
    double at[3];       /* m: the tool's origin */
    ost_pose device;    /* of the last tick */
    double velocity[3]; /* m/s: the device's, filtered */
    double drag[3];     /* N: what cutting pulls sideways, as felt: slowly */
    contact contact;
};

/* ------------------------------------------------------------------ making */

static ost_status check(const ost_force_params *p, ost_error *err)
{
    const struct {
        const char *name;
        double value, lo, hi;
    } bounds[] = {{"scale", p->scale, 1e-6, 1},
                  {"stiffness", p->stiffness, 1, 1e6},
                  {"damping", p->damping, 0, 1e3},
                  {"speed", p->speed, 0, 1e5},
                  {"cutting ratio", p->cutting_ratio, 1e-3, 10},
                  {"energy", p->energy, 1, 1e12},
                  {"reference density", p->reference_density, 1e-3, 1e3},
                  {"density at 0 HU", p->density_at_0, -1e3, 1e3},
                  {"density per HU", p->density_per_hu, -1, 1},
                  {"layer", p->layer, 1e-6, 1},
                  {"layer stiffness", p->layer_stiffness, 0, 1e15}};
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++)
        if (!(bounds[i].value >= bounds[i].lo && bounds[i].value <= bounds[i].hi))
            return ost_fail(err, OST_ERR_RANGE, "force: %s is %g; %g to %g is supported", bounds[i].name, bounds[i].value, bounds[i].lo,
                            bounds[i].hi);
    return OST_OK;
}

ost_status ost_force_create(const ost_bone *bone, const ost_force_params *params, ost_force **out, ost_error *err)
{
    const ost_force_params chosen = params ? *params : ost_force_defaults();
    const ost_dims first = {0, 0, 0};
    int16_t density;
    *out = NULL;
    if (!bone)
        return ost_fail(err, OST_ERR_USAGE, "a force needs a bone");
    ost_status status = check(&chosen, err);
    if (status == OST_OK)
        status = ost_bone_sample(bone, 1, &first, &density, err);
    if (status != OST_OK)
        return status;
    ost_force *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a force");
    f->bone = bone;
    f->params = chosen;
    *out = f;
    return OST_OK;
}

void ost_force_free(ost_force *force)
{
    if (!force)
        return;
    for (int i = 0; i < force->tools; i++)
        ost_shell_free(&force->shells[i]);
    free(force);
}

ost_status ost_force_add_shell(ost_force *force, const ost_shell *shell, ost_error *err)
{
    if (force->tools == TOOLS_MAX || shell->count > OST_SHELL_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a force takes up to %d tools of up to %d points", TOOLS_MAX, OST_SHELL_MAX);
    ost_shell_point *points = malloc((shell->count ? shell->count : 1) * sizeof *points);
    if (!points)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a tool's shell");
    if (shell->count)
        memcpy(points, shell->points, shell->count * sizeof *points);
    force->shells[force->tools++] = (ost_shell){shell->count, points};
    return OST_OK;
}

ost_status ost_force_add_tool(ost_force *force, const ost_tool *tool, ost_error *err)
{
    ost_tool_volume volume;
    ost_shell shell;
    ost_status status = ost_tool_download(tool, &volume, err);
    if (status != OST_OK)
        return status;
    status = ost_shell_make(&volume, &shell, err);
    ost_tool_volume_free(&volume);
    if (status != OST_OK)
        return status;
    status = ost_force_add_shell(force, &shell, err);
    ost_shell_free(&shell);
    return status;
}

void ost_force_place(ost_force *force, int tool, const ost_pose *pose)
{
    force->held = true;
    force->tool = tool;
    force->device = *pose;
    force->at[0] = (double)pose->t.x * OST_M_PER_PM;
    force->at[1] = (double)pose->t.y * OST_M_PER_PM;
    force->at[2] = (double)pose->t.z * OST_M_PER_PM;
    memset(force->velocity, 0, sizeof force->velocity);
    memset(force->drag, 0, sizeof force->drag);
}

/* ------------------------------------------------------------------ energy */

/* m x = b with m symmetric and positive definite. */
static void solve(const double m[3][3], const double b[3], double x[3])
{
    double c[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[i][j] = m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
    const double det = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
    for (int i = 0; i < 3; i++)
        x[i] = (c[0][i] * b[0] + c[1][i] * b[1] + c[2][i] * b[2]) / det;
}

/* How fast the tool's spin moves a point; direction against it, of length 1, in drag. */
static double spin_at(const ost_force *f, const contact_point *p, double drag[3])
{
    double along[3];
    ost_cross(f->contact.axis, p->r, along);
    const double radius = sqrt(ost_dot(along, along));
    for (int a = 0; a < 3; a++)
        drag[a] = radius > 0 ? -along[a] / radius : 0;
    return f->params.speed * (radius > NEAR_AXIS ? radius : NEAR_AXIS);
}

/* N s/m: what a touching point answers to its advance. */
static double resistance(const ost_force *f, const contact_point *p)
{
    double drag[3];
    const double speed = spin_at(f, p, drag);
    if (!p->cutting || speed <= 0)
        return p->area * RIGID;
    const double b = p->area * ost_force_energy(&f->params, p->density) / (f->params.cutting_ratio * speed);
    return b < p->area * RIGID ? b : p->area * RIGID;
}

typedef struct balance {
    double k, d;                   /* real: of the coupling */
    double turn[3];                /* rad/s, without the spin */
    double b[OST_SHELL_MAX];       /* of each point; 0: touches nothing */
    double by_turn[OST_SHELL_MAX]; /* m/s: its advance by the turn alone */
    bool pressing[OST_SHELL_MAX];
} balance;

static double advance(const contact_point *p, double by_turn, const double v[3])
{
    return by_turn - ost_dot(p->inward, v);
}

/* The tool's speed over dt toward a device that is away, with the points that touch now. */
static void find_speed(const contact *c, balance *e, const double away[3], const double velocity[3], double dt, double v[3])
{
    for (size_t i = 0; i < c->count; i++)
        e->pressing[i] = e->b[i] > 0;
    for (int set = 0; set < SETS; set++) {
        double m[3][3] = {{0}}, rhs[3];
        bool same = true;
        for (int a = 0; a < 3; a++) {
            m[a][a] = e->k * dt + e->d;
            rhs[a] = e->k * away[a] + e->d * velocity[a];
        }
        for (size_t i = 0; i < c->count; i++) {
            const double *n = c->points[i].inward;
            for (int a = 0; a < 3 && e->pressing[i]; a++) {
                rhs[a] += e->b[i] * e->by_turn[i] * n[a];
                for (int k = 0; k < 3; k++)
                    m[a][k] += e->b[i] * n[a] * n[k];
            }
        }
        solve(m, rhs, v);
        for (size_t i = 0; i < c->count; i++) {
            const bool presses = e->b[i] > 0 && advance(&c->points[i], e->by_turn[i], v) > 0;
            same &= presses == e->pressing[i];
            e->pressing[i] = presses;
        }
        if (same)
            return;
    }
}

/* Turn from the last device pose to this one, rad/s, across the tool's axis; small angles. */
static void turn_of(const ost_force *f, const ost_pose *device, double period, double out[3])
{
    const ost_pose *a = &f->device;
    const double w = a->qw, x = -(double)a->qx, y = -(double)a->qy, z = -(double)a->qz; /* conjugate */
    const double W = device->qw, X = device->qx, Y = device->qy, Z = device->qz;
    const double real = W * w - X * x - Y * y - Z * z;
    const double imaginary[3] = {W * x + X * w + Y * z - Z * y, W * y - X * z + Y * w + Z * x, W * z + X * y - Y * x + Z * w};
    const double n = sqrt(real * real + ost_dot(imaginary, imaginary));
    for (int i = 0; i < 3; i++)
        out[i] = (real < 0 ? -2 : 2) * imaginary[i] / n / period;
    const double spin = ost_dot(out, f->contact.axis);
    for (int i = 0; i < 3; i++)
        out[i] -= spin * f->contact.axis[i];
}

/*
 * Forces of the points on the tool: along the normals, and what cutting adds.
 * A side that is pressed is pulled across, which turns a push into a turn: a
 * stiffness without a potential, that makes a light hand whirl at the
 * frequency of its own swing.  So the pull is felt slower than that.
 */
static void sum_up(ost_force *f, const double size[], double period, ost_force_result *out)
{
    double normal[3] = {0}, drag_sum[3] = {0};
    for (size_t i = 0; i < f->contact.count; i++) {
        const contact_point *p = &f->contact.points[i];
        double drag[3], force[3], torque[3];
        if (size[i] <= 0)
            continue;
        const double speed = spin_at(f, p, drag);
        const double cutting = p->cutting && f->params.speed > 0 ? f->params.cutting_ratio * size[i] : 0;
        for (int a = 0; a < 3; a++) {
            normal[a] += size[i] * p->inward[a];
            drag_sum[a] += cutting * drag[a];
            force[a] = size[i] * p->inward[a] + cutting * drag[a];
        }
        ost_cross(p->r, force, torque);
        for (int a = 0; a < 3; a++)
            out->torque_nm[a] += f->params.scale * torque[a];
        out->power_w += cutting * speed;
        out->cutting_nm += f->params.speed > 0 ? cutting * speed / f->params.speed : 0;
    }
    out->axial_n = ost_dot(normal, f->contact.axis);
    double across[3];
    for (int a = 0; a < 3; a++)
        across[a] = normal[a] - out->axial_n * f->contact.axis[a];
    out->off_axis_n = sqrt(ost_dot(across, across));
    for (int a = 0; a < 3; a++) {
        f->drag[a] += (drag_sum[a] - f->drag[a]) * period / (period + DRAG_S);
        out->force_n[a] = f->params.scale * (normal[a] + f->drag[a]);
    }
}

static ost_status by_energy(ost_force *f, const double to[3], const double turn[3], double period, ost_force_result *out, ost_error *err)
{
    balance e = {.k = f->params.stiffness / f->params.scale, .d = f->params.damping / f->params.scale};
    const double half_voxel = (double)f->bone->geometry.spacing.x * OST_M_PER_PM / 2;
    contact *c = &f->contact;
    double v[3] = {0}, left = period, size[OST_SHELL_MAX] = {0};
    for (int part = 0; part < PARTS && left > period * 1e-6; part++) {
        double away[3], across[3];
        ost_status status = ost_contact_touch(f->bone, f->at, c, &out->touching, err);
        if (status != OST_OK)
            return status;
        for (size_t i = 0; i < c->count; i++) {
            e.b[i] = c->points[i].density ? resistance(f, &c->points[i]) : 0;
            ost_cross(turn, c->points[i].r, across);
            e.by_turn[i] = -ost_dot(c->points[i].inward, across);
        }
        for (int a = 0; a < 3; a++)
            away[a] = to[a] - f->at[a];
        find_speed(c, &e, away, f->velocity, left, v);
        /* Half a voxel at once: bone is looked for no farther than a voxel ahead. */
        const double far = sqrt(ost_dot(v, v)) * left, share = far > half_voxel ? half_voxel / far : 1;
        for (int a = 0; a < 3; a++)
            f->at[a] += v[a] * left * share;
        left -= left * share;
    }
    for (size_t i = 0; i < c->count; i++) {
        const double speed = e.b[i] > 0 ? advance(&c->points[i], e.by_turn[i], v) : 0;
        size[i] = speed > 0 ? e.b[i] * speed : 0;
    }
    sum_up(f, size, period, out);
    /* What holds the tool is what the hand feels. */
    for (int a = 0; a < 3; a++)
        out->force_n[a] = f->params.scale * (f->drag[a] - e.k * (to[a] - f->at[a]) - e.d * (f->velocity[a] - v[a]));
    return OST_OK;
}

/* ----------------------------------------------------------------- instant */

static ost_status at_once(ost_force *f, const double to[3], double period, ost_force_result *out, ost_error *err)
{
    double size[OST_SHELL_MAX] = {0}, sum = 0;
    memcpy(f->at, to, sizeof f->at);
    ost_status status = ost_contact_press(f->bone, f->at, f->params.layer, &f->contact, &out->touching, err);
    for (size_t i = 0; i < f->contact.count && status == OST_OK; i++) {
        const contact_point *p = &f->contact.points[i];
        if (p->depth <= 0)
            continue;
        const double k = f->params.layer_stiffness * p->area * ost_force_energy(&f->params, p->density) / f->params.energy;
        size[i] = k * p->depth;
        sum += k;
    }
    const double most = f->params.stiffness / f->params.scale;
    for (size_t i = 0; i < f->contact.count && sum > most; i++)
        size[i] *= most / sum;
    if (status == OST_OK)
        sum_up(f, size, period, out);
    return status;
}

/* -------------------------------------------------------------------- step */

static ost_pm picometres(double m)
{
    return (ost_pm)rint(m / OST_M_PER_PM);
}

ost_status ost_force_step(ost_force *force, int tool, const ost_pose *device, double period_s, ost_force_result *out, ost_error *err)
{
    *out = (ost_force_result){.tool = *device};
    if (tool < 0 || tool >= force->tools)
        return ost_fail(err, OST_ERR_USAGE, "force: there is no tool %d", tool);
    if (!(period_s > 0))
        return ost_fail(err, OST_ERR_USAGE, "force: a period of %g s", period_s);
    const double to[3] = {(double)device->t.x * OST_M_PER_PM, (double)device->t.y * OST_M_PER_PM, (double)device->t.z * OST_M_PER_PM};
    if (!force->held || force->tool != tool)
        ost_force_place(force, tool, device);
    ost_contact_turn(&force->shells[tool], device, &force->contact);
    const double before[3] = {(double)force->device.t.x * OST_M_PER_PM, (double)force->device.t.y * OST_M_PER_PM,
                              (double)force->device.t.z * OST_M_PER_PM};
    const double share = period_s / (period_s + 1 / (2 * 3.14159265358979 * VELOCITY_HZ));
    for (int a = 0; a < 3; a++)
        force->velocity[a] += share * ((to[a] - before[a]) / period_s - force->velocity[a]);
    double turn[3];
    turn_of(force, device, period_s, turn);
    ost_status status = force->params.mode == OST_FORCE_INSTANT ? at_once(force, to, period_s, out, err) : by_energy(force, to, turn, period_s, out, err);
    force->device = *device;
    if (force->params.mode == OST_FORCE_ENERGY)
        out->tool.t = (ost_pm3){picometres(force->at[0]), picometres(force->at[1]), picometres(force->at[2])};
    return status;
}
