/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `sim` driver: a simulated device held by a simulated hand, so that the force loop can be
 * closed without hardware.
 *
 *   hand's plan --spring, damper--> mass --encoders--> pose
 *                                    ^  '- friction
 *                                    '---- force, one tick late
 *
 * The parameters of the Phantom Omni and of the hand are taken from the literature:
 *
 *   mass                60 g: apparent mass of 45 g at the tip, plus the stylus
 *   viscous friction    0.2 N s/m
 *   Coulomb friction    0.26 N (backdrive friction in the data sheet)
 *   encoders            55 um (450 dpi)
 *   maximum force       3.3 N
 *   spring and damper   light 100 N/m, 0.5 N s/m; normal 150 N/m, 1.5 N s/m; firm 400 N/m, 4 N s/m
 *
 * A tick consists of ten steps of 0.1 ms, which update velocities first (semi-implicit Euler).
 * Coulomb friction is implicit: in each step, it reduces the speed by as much as possible, but not
 * below zero, so that a sticking device stays still. The stylus always has exactly the planned
 * direction. The device senses this direction and renders no torque.
 *
 * Friction makes the force loop passive up to a stiffness of 2 * 0.26 N / 55 um = 9.5 kN/m (Diolaiti
 * et al. 2006). friction=0 is the worst case, in which a force law must still be stable.
 *
 * The code uses only + - * / and sqrt of doubles, and its own random generator. Therefore the same ticks and forces
 * produce the same poses on every machine. Lengths are in metres.
 */
#include "core/conditions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"

enum { STEPS = 10, FRICTION_MN = 260 };
#define STEP_S 1e-4
#define MASS_KG 0.06
#define VISCOUS 0.2
#define FORCE_MAX_N 3.3
#define ENCODER_PM (55 * (OST_PM_PER_MM / 1000))
#define PM_PER_M (1000.0 * (double)OST_PM_PER_MM)

typedef struct grip {
    const char *name;
    double stiffness, damping;
} grip;

static const grip grips[] = {{"light", 100, 0.5}, {"normal", 150, 1.5}, {"firm", 400, 4}};

struct haptic_instance {
    ost_path path; /* owned; the planned motion of the hand */
    size_t next;
    grip hand;
    double friction; /* Coulomb friction in N */
    double tremor;   /* maximum amplitude of the tremor along an axis */
    uint64_t random;
    double shake[3], x[3], v[3], force[3];
};

typedef struct choice {
    grip hand;
    int64_t seed, tremor_um, friction_mn;
} choice;

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "seed") == 0)
        return ost_haptic_integer("sim", key, value, 0, INT64_MAX, &c->seed, err);
    if (strcmp(key, "tremor") == 0)
        return ost_haptic_integer("sim", key, value, 0, 5000, &c->tremor_um, err);
    if (strcmp(key, "friction") == 0)
        return ost_haptic_integer("sim", key, value, 0, 5000, &c->friction_mn, err);
    if (strcmp(key, "grip") != 0)
        return ost_fail(err, OST_ERR_USAGE, "device sim: unknown option '%s'; expected grip, seed, tremor or friction",
                        key);
    for (size_t i = 0; i < sizeof grips / sizeof grips[0]; i++)
        if (strcmp(value, grips[i].name) == 0) {
            c->hand = grips[i];
            return OST_OK;
        }
    return ost_fail(err, OST_ERR_USAGE, "device sim: grip=%.40s; expected light, normal or firm", value);
}

static void position_of(const ost_pose *pose, double out[3])
{
    out[0] = (double)pose->t.x / PM_PER_M;
    out[1] = (double)pose->t.y / PM_PER_M;
    out[2] = (double)pose->t.z / PM_PER_M;
}

static void sim_close(haptic_instance *instance)
{
    ost_path_free(&instance->path);
    free(instance);
}

static ost_status sim_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    choice c = {.hand = grips[1], .seed = 1, .friction_mn = FRICTION_MN};
    ost_status status = ost_haptic_options("sim", options, take, &c, err);
    if (status != OST_OK)
        return status;
    if (!setup->path || setup->path->count == 0)
        return ost_fail(err, OST_ERR_USAGE, "device sim: no path given; pass --path");
    haptic_instance *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device sim");
    status = ost_path_init(&s->path, setup->path->count, err);
    if (status != OST_OK) {
        free(s);
        return status;
    }
    memcpy(s->path.ticks, setup->path->ticks, setup->path->count * sizeof *setup->path->ticks);
    s->hand = c.hand;
    s->friction = (double)c.friction_mn * 1e-3;
    s->random = (uint64_t)c.seed;
    s->tremor = (double)c.tremor_um * 1e-6;
    position_of(&s->path.ticks[0].pose, s->x);
    *out = s;
    return OST_OK;
}

/* Returns a pseudo-random number from -1 to 1, computed by SplitMix64. */
static double noise(haptic_instance *s)
{
    uint64_t z = (s->random += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    z ^= z >> 31;
    return (double)(int64_t)(z >> 11) / (double)(INT64_C(1) << 52) - 1;
}

/*
 * Adds a tremor, which is noise filtered by a low pass of about 10 Hz. The factor 5 approximately compensates the
 * filter's loss of amplitude.
 */
static void shake(haptic_instance *s)
{
    for (int a = 0; a < 3 && s->tremor > 0; a++) {
        const double drawn = noise(s) * s->tremor * 5;
        s->shake[a] += (drawn - s->shake[a]) * 0.06;
        s->shake[a] = s->shake[a] > s->tremor ? s->tremor : s->shake[a] < -s->tremor ? -s->tremor : s->shake[a];
    }
}

/* Advances the simulation by one step. The hand is at `to` and moves with `speed`. */
static void step(haptic_instance *s, const double to[3], const double speed[3])
{
    double v[3];
    for (int a = 0; a < 3; a++) {
        const double f = s->hand.stiffness * (to[a] - s->x[a]) + s->hand.damping * (speed[a] - s->v[a]) -
                         VISCOUS * s->v[a] + s->force[a];
        v[a] = s->v[a] + f / MASS_KG * STEP_S;
    }
    const double fast = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), taken = s->friction / MASS_KG * STEP_S;
    const double left = fast > taken ? (fast - taken) / fast : 0;
    for (int a = 0; a < 3; a++) {
        s->v[a] = v[a] * left;
        s->x[a] += s->v[a] * STEP_S;
    }
}

static ost_pm encoded(double metres)
{
    return (ost_pm)rint(metres * PM_PER_M / (double)ENCODER_PM) * ENCODER_PM;
}

static ost_haptic_answer sim_read(haptic_instance *s, ost_haptic_state *state)
{
    /* After the end of the planned motion, the hand stays still. */
    const size_t last = s->path.count - 1, from = s->next < last ? s->next : last, to = from < last ? from + 1 : last;
    const ost_tick *tick = &s->path.ticks[from];
    double a[3], b[3];
    /* When the path changes to another tool, the hand and the device move to the position of that tool at once. */
    const bool taken_up = from > 0 && s->next <= last && tick->tool != s->path.ticks[from - 1].tool;
    position_of(&tick->pose, a);
    position_of(&s->path.ticks[s->path.ticks[to].tool == tick->tool ? to : from].pose, b);
    if (taken_up) {
        memcpy(s->x, a, sizeof s->x);
        memset(s->v, 0, sizeof s->v);
    }
    shake(s);
    for (int k = 1; k <= STEPS; k++) {
        double hand[3], speed[3];
        for (int i = 0; i < 3; i++) {
            hand[i] = a[i] + (b[i] - a[i]) * k / STEPS + s->shake[i];
            speed[i] = (b[i] - a[i]) / (STEPS * STEP_S);
        }
        step(s, hand, speed);
    }
    s->next += s->next < s->path.count;
    *state = (ost_haptic_state){
        .pose = tick->pose, .tool = tick->tool, .turned = tick->rpm != OST_RPM_OF_DEVICE, .rpm = tick->rpm};
    state->pose.t = (ost_pm3){encoded(s->x[0]), encoded(s->x[1]), encoded(s->x[2])};
    return OST_HAPTIC_FRESH;
}

static void sim_write(haptic_instance *s, const ost_wrench *wrench)
{
    const double *f = wrench->force_n;
    const double size = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    /* The force is limited to the maximum force of the motors. A force that is not finite is replaced by zero. */
    const double share = size > FORCE_MAX_N ? FORCE_MAX_N / size : 1;
    for (int a = 0; a < 3; a++)
        s->force[a] = isfinite(size) ? f[a] * share : 0;
}

const haptic_driver ost_haptic_sim = {
    .name = "sim",
    .description = "a simulated device: mass, friction, encoders, and a hand that follows a path",
    .caps = OST_HAPTIC_FORCE | OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL | OST_HAPTIC_LOGICAL,
    .max_force_n = FORCE_MAX_N,
    .max_stiffness_n_m = 700,
    .open = sim_open,
    .close = sim_close,
    .read = sim_read,
    .write = sim_write,
};
