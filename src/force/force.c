/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the two force laws (docs/reference/force.md).
 *
 *   energy    device o~~~spring, damper~~~o tool | points: f = b * advance
 *
 *     K (x_d - x) + D (v_d - v) = sum over touching points of b * advance * (-inward)
 *     advance = max(inward . -v, 0),  b = area * energy / (cutting ratio * speed of the point)
 *     x and v are the position and the velocity of the tool, x_d and v_d those of the device
 *
 *   To advance into bone, a point needs the power area * advance * energy.  The lateral force of cutting,
 *   cutting ratio * f, supplies this power at the speed of the point.  A contact therefore acts as a damper
 *   and not as a spring, and cannot oscillate.  The equation is solved for the end of the tick (balance.h).
 *
 *   If turn_stiffness is not 0, a spring and a damper also couple the orientation of the tool to that of the device.
 *   The equation then has three more rows, for the torques.
 *
 *   instant   f = layer stiffness * (density / reference)^2 * area * depth
 *
 *   The sum of the stiffness of all points is limited to the stiffness of the coupling.
 *
 * All computations use the tool's frame (contact.h); the results are rotated into the bone's frame.
 */
#include "core/conditions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/backend.h"
#include "core/quaternion.h"
#include "core/vector.h"
#include "force/balance.h"
#include "force/contact.h"
#include "force/params.h"
#include "force/turn.h"
#include "force/vibration.h"

enum { TOOLS_MAX = 16, PARTS = 8 };
#define VELOCITY_HZ 50.0
#define DRAG_S 0.1
#define PI 3.14159265358979323846

/* The coupled tool, with all state that one tick passes to the next. */
typedef struct grip {
    bool coupled;       /* true if a tool is coupled; the other fields are then valid */
    int tool;
    contact_pose pose;  /* pose of the tool */
    double facing[4];   /* orientation of the tool as a quaternion w x y z */
    ost_pose device;    /* pose of the device in the last tick */
    double velocity[3]; /* filtered velocity of the device in m/s */
    double turning[3];  /* filtered angular velocity of the device in rad/s */
    double drag[3];     /* lateral force of cutting in N, low-pass filtered */
    double drag_nm[3];  /* torque of the lateral force of cutting in N m, low-pass filtered */
    double spun;        /* angle in rad by which the tool has rotated */
    double turned;      /* sum in rad of the angles by which ost_force_motor has turned the pose */
} grip;

struct ost_force {
    const ost_bone *bone;
    ost_force_params params;
    double spacing; /* spacing of the bone in m */
    int tools;
    contact_shell *shells[TOOLS_MAX];
    grip grip;
    /* Scratch for one tick. */
    contact contact;
    balance balance;
    double size[OST_SHELL_MAX]; /* force of each touching point in N */
};

/* ------------------------------------------------------------------ making */

ost_status ost_force_create(const ost_bone *bone, const ost_force_params *params, ost_force **out, ost_error *err)
{
    const ost_force_params chosen = params ? *params : ost_force_defaults();
    *out = NULL;
    if (!bone)
        return ost_fail(err, OST_ERR_USAGE, "a force needs a bone");
    ost_status status = ost_force_params_check(&chosen, err);
    if (status == OST_OK)
        status = ost_bone_sample(bone, 0, NULL, NULL, err); /* copies the bone to host memory if a device stores it */
    if (status != OST_OK)
        return status;
    ost_force *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a force");
    f->bone = bone;
    f->params = chosen;
    f->spacing = (double)bone->geometry.spacing.x * OST_M_PER_PM;
    *out = f;
    return OST_OK;
}

void ost_force_free(ost_force *force)
{
    if (!force)
        return;
    for (int i = 0; i < force->tools; i++)
        free(force->shells[i]);
    free(force);
}

ost_status ost_force_add_shell(ost_force *force, const ost_shell *shell, ost_error *err)
{
    if (force->tools == TOOLS_MAX || shell->count > OST_SHELL_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a force takes up to %d tools of up to %d points", TOOLS_MAX,
                        OST_SHELL_MAX);
    contact_shell *points = malloc(sizeof *points);
    if (!points)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool's shell");
    ost_contact_shell_make(shell, &force->params, force->spacing, points);
    force->shells[force->tools++] = points;
    return OST_OK;
}

ost_status ost_force_add_tool(ost_force *force, const ost_tool *tool, ost_error *err)
{
    ost_tool_volume volume;
    ost_shell shell = {0};
    ost_status status = ost_tool_download(tool, &volume, err);
    if (status != OST_OK)
        return status;
    status = ost_shell_make(&volume, &shell, err);
    ost_tool_volume_free(&volume);
    if (status == OST_OK)
        status = ost_force_add_shell(force, &shell, err);
    ost_shell_free(&shell);
    return status;
}

ost_status ost_force_refresh(const ost_force *force, ost_error *err)
{
    return ost_bone_sample(force->bone, 0, NULL, NULL, err);
}

static void take_direction(ost_force *f, const ost_pose *pose)
{
    const double q[4] = {pose->qw, pose->qx, pose->qy, pose->qz};
    memcpy(f->grip.facing, q, sizeof q);
    ost_quaternion_unit(f->grip.facing);
    ost_turn_of(f->grip.facing, f->grip.pose.turn);
}

static void position_of(const ost_pose *pose, double at[3])
{
    at[0] = (double)pose->t.x * OST_M_PER_PM;
    at[1] = (double)pose->t.y * OST_M_PER_PM;
    at[2] = (double)pose->t.z * OST_M_PER_PM;
}

void ost_force_set_pose(ost_force *force, int tool, const ost_pose *pose)
{
    force->grip.coupled = true;
    force->grip.tool = tool;
    force->grip.device = *pose;
    position_of(pose, force->grip.pose.at);
    take_direction(force, pose);
    memset(force->grip.velocity, 0, sizeof force->grip.velocity);
    memset(force->grip.turning, 0, sizeof force->grip.turning);
    memset(force->grip.drag, 0, sizeof force->grip.drag);
    memset(force->grip.drag_nm, 0, sizeof force->grip.drag_nm);
    force->grip.spun = force->grip.turned = 0;
}

/* ------------------------------------------------------------------- turns */

void ost_force_motor(ost_force *force, double speed, double turned)
{
    grip *g = &force->grip;
    if (speed != force->params.speed) {
        force->params.speed = speed;
        for (int t = 0; t < force->tools; t++)
            ost_contact_shell_speed(force->shells[t], &force->params);
    }
    if (!g->coupled || turned == 0)
        return;
    g->turned = ost_turn_less_64(g->turned + turned);
    double device[4] = {g->device.qw, g->device.qx, g->device.qy, g->device.qz};
    ost_turn_about_axis(g->facing, turned, g->facing);
    ost_turn_of(g->facing, g->pose.turn);
    ost_turn_about_axis(device, turned, device);
    g->device.qw = (int32_t)rint(device[0]);
    g->device.qx = (int32_t)rint(device[1]);
    g->device.qy = (int32_t)rint(device[2]);
    g->device.qz = (int32_t)rint(device[3]);
}

/* Rotates the tool for the time dt at the angular velocity w, given in the tool's frame. */
static void turn_tool(ost_force *f, const double w[3], double dt)
{
    const double *q = f->grip.facing, h[3] = {w[0] * dt / 2, w[1] * dt / 2, w[2] * dt / 2};
    const double next[4] = {
        q[0] - q[1] * h[0] - q[2] * h[1] - q[3] * h[2], q[1] + q[0] * h[0] + q[2] * h[2] - q[3] * h[1],
        q[2] + q[0] * h[1] + q[3] * h[0] - q[1] * h[2], q[3] + q[0] * h[2] + q[1] * h[1] - q[2] * h[0]};
    memcpy(f->grip.facing, next, sizeof next);
    ost_quaternion_unit(f->grip.facing);
    ost_turn_of(f->grip.facing, f->grip.pose.turn);
}

/* ------------------------------------------------------------------ results */

/*
 * Sums the forces of the points on the tool: the forces along the normals, and the lateral forces
 * of cutting.  If one side of the tool is pressed, the lateral force pulls the tool sideways.  This
 * force has no potential and would make a lightly held device whirl at its natural frequency.
 * A low-pass filter therefore limits the lateral force to lower frequencies.
 */
static void sum_up(ost_force *f, double period, ost_force_result *out)
{
    const contact_shell *shell = f->shells[f->grip.tool];
    const contact *c = &f->contact;
    double normal[3] = {0}, pull[3] = {0}, normal_nm[3] = {0}, pull_nm[3] = {0}, shaking = 0, bone[3];
    for (size_t k = 0; k < c->count; k++) {
        const size_t i = c->which[k];
        const double size = f->size[k];
        if (size <= 0)
            continue;
        const double r[3] = {shell->at[0][i], shell->at[1][i], shell->at[2][i]};
        const double cutting = shell->cutting[i] ? f->params.cutting_ratio * size : 0;
        const double push[3] = {size * shell->inward[0][i], size * shell->inward[1][i], size * shell->inward[2][i]};
        const double across[3] = {cutting * shell->against[0][i], cutting * shell->against[1][i], 0};
        double a[3], b[3];
        ost_vector_cross(r, push, a);
        ost_vector_cross(r, across, b);
        for (int d = 0; d < 3; d++) {
            normal[d] += push[d];
            pull[d] += across[d];
            normal_nm[d] += a[d];
            pull_nm[d] += b[d];
        }
        out->power_w += cutting * shell->spin[i];
        shaking += shell->cutting[i] ? size * ost_force_density(&f->params, c->density[k]) / f->params.reference_density
                                     : 0;
    }
    out->cutting_nm = f->params.speed > 0 ? out->power_w / f->params.speed : 0;
    out->axial_n = normal[2];
    out->off_axis_n = sqrt(normal[0] * normal[0] + normal[1] * normal[1]);
    out->shaking_n = f->params.scale * shaking;
    const double slow = period / (period + DRAG_S);
    ost_into_bone(&f->grip.pose, pull, bone);
    for (int d = 0; d < 3; d++)
        f->grip.drag[d] += (bone[d] - f->grip.drag[d]) * slow;
    ost_into_bone(&f->grip.pose, pull_nm, bone);
    for (int d = 0; d < 3; d++) {
        f->grip.drag_nm[d] += (bone[d] - f->grip.drag_nm[d]) * slow;
        normal_nm[d] += pull_nm[d];
    }
    ost_into_bone(&f->grip.pose, normal, out->force_n);
    ost_into_bone(&f->grip.pose, normal_nm, out->torque_nm);
    for (int d = 0; d < 3; d++) {
        out->force_n[d] = f->params.scale * (out->force_n[d] + f->grip.drag[d]);
        out->torque_nm[d] *= f->params.scale;
    }
}

/* Adds the vibration force (vibration.h). In the tool's frame, the angle of the runout is `spun` - `turned`. */
static void shake(ost_force *f, double period, ost_force_result *out)
{
    const ost_force_params *p = &f->params;
    double once[2], teeth[2], felt[3];
    if (p->vibration <= 0 && p->runout <= 0)
        return;
    f->grip.spun = ost_turn_less_64(f->grip.spun + p->speed * period);
    ost_sin_cos(f->grip.spun - f->grip.turned, &once[0], &once[1]);
    ost_sin_cos(f->grip.spun * p->teeth, &teeth[0], &teeth[1]);
    const double own[3] = {p->runout * once[1], p->runout * once[0], p->vibration * teeth[0]};
    ost_into_bone(&f->grip.pose, own, felt);
    for (int d = 0; d < 3; d++)
        out->force_n[d] += out->shaking_n * felt[d];
}

/* ------------------------------------------------------------------ energy */

/*
 * Adds the touching points to the balance. `turn` is the part of the tool's angular velocity, in the tool's frame, for
 * which the balance does not solve.
 */
static void gather(ost_force *f, int axes, const double turn[3])
{
    const contact_shell *shell = f->shells[f->grip.tool];
    const contact *c = &f->contact;
    balance *e = &f->balance;
    e->axes = axes;
    e->count = c->count;
    for (size_t k = 0; k < c->count; k++) {
        const size_t i = c->which[k];
        const double r[3] = {shell->at[0][i], shell->at[1][i], shell->at[2][i]};
        const double n[3] = {-(double)shell->inward[0][i], -(double)shell->inward[1][i], -(double)shell->inward[2][i]};
        double arm[3];
        ost_vector_cross(r, n, arm);
        const double share = ost_force_density(&f->params, c->density[k]) / f->params.reference_density,
                     most = shell->area[i] * OST_RIGID;
        const double b = shell->cutting[i] ? shell->give[i] * share * share : shell->give[i];
        e->b[k] = share <= 0 && shell->cutting[i] ? 0 : b < most ? b : most;
        e->given[k] = ost_vector_dot(turn, arm);
        for (int a = 0; a < 3; a++) {
            e->j[a][k] = n[a];
            e->j[3 + a][k] = arm[a];
        }
    }
}

/*
 * Adds the springs and dampers of the coupling to the balance. The parameters `away` and `velocity` are the offset and
 * the velocity of the device in the tool's frame.
 */
static void pull(balance *e, int first, double k, double d, double dt, const double away[3], const double velocity[3])
{
    for (int a = 0; a < 3; a++) {
        e->spring[first + a] = k * dt + d;
        e->pull[first + a] = k * away[a] + d * velocity[a];
    }
}

/* Maximum of the coupling's force and, in the law `instant`, of the sum of the points' forces. A hand cannot exert so
   great a force; it is reached only if the device is far from the tool or deep in the bone. */
#define DEVICE_FORCE_MAX_N 300.0

/*
 * Computes the offset from the tool to the device. The offset is limited so that the force of a coupling with stiffness
 * k does not exceed DEVICE_FORCE_MAX_N.
 */
static void reach_of(const double to[3], const double at[3], double k, double away[3])
{
    double square = 0;
    for (int a = 0; a < 3; a++) {
        away[a] = to[a] - at[a];
        square += away[a] * away[a];
    }
    const double most = DEVICE_FORCE_MAX_N / k, share = square > most * most ? most / sqrt(square) : 1;
    for (int a = 0; a < 3; a++)
        away[a] *= share;
}

static ost_status by_energy(ost_force *f, const ost_pose *device, const double turn[3], double period,
                            ost_force_result *out, ost_error *err)
{
    static const double nothing[3] = {0};
    const ost_force_params *p = &f->params;
    const double k = p->stiffness / p->scale, d = p->damping / p->scale, turn_k = p->turn_stiffness / p->scale,
                 turn_d = p->turn_damping / p->scale;
    const bool turns = p->turn_stiffness > 0;
    const contact_shell *shell = f->shells[f->grip.tool];
    double to[3], facing[4], away[3], lean[3] = {0}, own[3], u[6] = {0}, left = period;
    position_of(device, to);
    ost_turn_quaternion(device, facing);
    for (int part = 0; part < PARTS && left > period * 1e-6; part++) {
        ost_status status = ost_contact_touch(f->bone, shell, &f->grip.pose, &f->contact, err);
        if (status != OST_OK)
            return status;
        reach_of(to, f->grip.pose.at, k, away);
        double far_own[3], speed_own[3];
        ost_into_tool(&f->grip.pose, away, far_own);
        ost_into_tool(&f->grip.pose, f->grip.velocity, speed_own);
        pull(&f->balance, 0, k, d, left, far_own, speed_own);
        ost_into_tool(&f->grip.pose, turn, own);
        own[2] = 0; /* rotation about the tool's axis is ignored, because the tool rotates about this axis anyway */
        if (turns) {
            ost_turn_between(f->grip.facing, facing, lean);
            ost_into_tool(&f->grip.pose, lean, far_own);
            ost_into_tool(&f->grip.pose, f->grip.turning, speed_own);
            pull(&f->balance, 3, turn_k, turn_d, left, far_own, speed_own);
        }
        gather(f, turns ? 6 : 3, turns ? nothing : own);
        ost_balance_solve(&f->balance, u);
        /* In each part of the tick, the tool moves at most half a voxel, because bone is looked up only one voxel
           ahead. */
        const double turned = turns ? sqrt(ost_vector_dot(u + 3, u + 3)) * shell->reach : 0,
                     far = (sqrt(ost_vector_dot(u, u)) + turned) * left;
        const double share = far > f->spacing / 2 ? f->spacing / 2 / far : 1;
        double v[3];
        ost_into_bone(&f->grip.pose, u, v);
        for (int a = 0; a < 3; a++)
            f->grip.pose.at[a] += v[a] * left * share;
        if (turns)
            turn_tool(f, u + 3, left * share);
        left -= left * share;
    }
    out->touching = (int)f->contact.count;
    for (size_t i = 0; i < f->contact.count; i++)
        f->size[i] = f->balance.advance[i] > 0 ? f->balance.b[i] * f->balance.advance[i] : 0;
    sum_up(f, period, out);
    /* The hand force is the sum of the force of the coupling and the lateral force of cutting. */
    double v[3], w[3];
    ost_into_bone(&f->grip.pose, u, v);
    reach_of(to, f->grip.pose.at, k, away);
    for (int a = 0; a < 3; a++)
        out->force_n[a] = p->scale * (f->grip.drag[a] - k * away[a] - d * (f->grip.velocity[a] - v[a]));
    if (turns) {
        ost_into_bone(&f->grip.pose, u + 3, w);
        ost_turn_between(f->grip.facing, facing, lean);
        for (int a = 0; a < 3; a++)
            out->torque_nm[a] = p->scale *
                                (f->grip.drag_nm[a] - turn_k * lean[a] - turn_d * (f->grip.turning[a] - w[a]));
    }
    return OST_OK;
}

/* ----------------------------------------------------------------- instant */

static ost_status at_once(ost_force *f, double period, ost_force_result *out, ost_error *err)
{
    const contact_shell *shell = f->shells[f->grip.tool];
    const contact *c = &f->contact;
    double sum = 0;
    ost_status status = ost_contact_press(f->bone, shell, &f->grip.pose, f->params.layer, &f->contact, err);
    if (status != OST_OK)
        return status;
    out->touching = (int)c->count;
    for (size_t i = 0; i < c->count; i++) {
        const double k = f->params.layer_stiffness * shell->area[c->which[i]] *
                         ost_force_energy(&f->params, c->density[i]) / f->params.energy;
        f->size[i] = k * c->depth[i];
        sum += c->depth[i] > 0 ? k : 0;
    }
    const double most = f->params.stiffness / f->params.scale;
    for (size_t i = 0; i < c->count && sum > most; i++)
        f->size[i] *= most / sum;
    double pressed = 0;
    for (size_t i = 0; i < c->count; i++)
        pressed += fmax(0, f->size[i]);
    for (size_t i = 0; i < c->count && pressed > DEVICE_FORCE_MAX_N; i++)
        f->size[i] *= DEVICE_FORCE_MAX_N / pressed;
    sum_up(f, period, out);
    return OST_OK;
}

/* -------------------------------------------------------------------- step */

static ost_pm picometres(double m)
{
    return (ost_pm)rint(m / OST_M_PER_PM);
}

/*
 * Updates the velocity and the angular velocity of the device, which are low-pass filtered at VELOCITY_HZ. Sets turn to
 * the unfiltered angular velocity of this tick.
 */
static void follow(ost_force *f, const ost_pose *device, double period, double turn[3])
{
    const double share = period / (period + 1 / (2 * PI * VELOCITY_HZ));
    double to[3], before[3], a[4], b[4];
    position_of(device, to);
    position_of(&f->grip.device, before);
    ost_turn_quaternion(&f->grip.device, a);
    ost_turn_quaternion(device, b);
    ost_turn_between(a, b, turn);
    for (int i = 0; i < 3; i++) {
        turn[i] /= period;
        f->grip.velocity[i] += share * ((to[i] - before[i]) / period - f->grip.velocity[i]);
        f->grip.turning[i] += share * (turn[i] - f->grip.turning[i]);
    }
    f->grip.device = *device;
}

ost_status ost_force_step(ost_force *force, int tool, const ost_pose *device, double period_s, ost_force_result *out,
                          ost_error *err)
{
    *out = (ost_force_result){.tool = *device};
    if (tool < 0 || tool >= force->tools)
        return ost_fail(err, OST_ERR_USAGE, "force: no tool %d", tool);
    if (!(period_s > 0))
        return ost_fail(err, OST_ERR_USAGE, "force: a period of %g s", period_s);
    if (!force->grip.coupled || force->grip.tool != tool)
        ost_force_set_pose(force, tool, device);
    double turn[3];
    follow(force, device, period_s, turn);
    const bool energy = force->params.mode == OST_FORCE_ENERGY, turns = energy && force->params.turn_stiffness > 0;
    if (!energy)
        position_of(device, force->grip.pose.at);
    if (!turns)
        take_direction(force, device);
    ost_status status = energy ? by_energy(force, device, turn, period_s, out, err)
                               : at_once(force, period_s, out, err);
    if (status != OST_OK)
        return status;
    shake(force, period_s, out);
    if (energy)
        out->tool.t = (ost_pm3){picometres(force->grip.pose.at[0]), picometres(force->grip.pose.at[1]),
                                picometres(force->grip.pose.at[2])};
    if (turns) {
        out->tool.qw = (int32_t)rint(force->grip.facing[0] * OST_Q30_ONE);
        out->tool.qx = (int32_t)rint(force->grip.facing[1] * OST_Q30_ONE);
        out->tool.qy = (int32_t)rint(force->grip.facing[2] * OST_Q30_ONE);
        out->tool.qz = (int32_t)rint(force->grip.facing[3] * OST_Q30_ONE);
    }
    return OST_OK;
}

ost_status ost_force_rehearse(ost_force *force, int tool, const ost_pose *device, double period_s,
                              ost_force_result *out, ost_error *err)
{
    const grip now = force->grip;
    ost_status status = ost_force_step(force, tool, device, period_s, out, err);
    force->grip = now;
    return status;
}
