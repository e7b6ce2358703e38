/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the hand feels: a force and a torque from the tool against the bone.
 *
 *   device's pose --coupling--> tool's pose --> ost_world_step, recorded
 *                     |             '--shell--> bone's densities
 *                     '--> force --safety--> device
 *
 * The tool is a shell of points with inward normals.  Each looks a voxel
 * outward for bone.  Two kinds of removal:
 *
 *   energy    The tool is tied to the device by a spring and a damper.  Where
 *             its points touch bone it advances as fast as the cutting power
 *             of the pressure allows, so that dense bone takes longer; where
 *             it does not cut, it stops.
 *   instant   The tool is where the device is (the thesis).  The force is
 *             that of a layer of bone around the tool, pressed together.
 *
 * Floats decide no voxel: the tool's pose is quantised before the world takes
 * it, and that pose is what a session records.  docs/force.md has the
 * equations, the parameters and where they come from.
 *
 * Threads: an ost_force belongs to the thread of its world.
 */
#ifndef OSTEON_FORCE_H
#define OSTEON_FORCE_H

#include <osteon/backend.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ost_force_mode { OST_FORCE_ENERGY, OST_FORCE_INSTANT } ost_force_mode;

/* SI units; docs/force.md has the source of each default. */
typedef struct ost_force_params {
    ost_force_mode mode;
    double scale;              /* felt over real: a device of 3.3 N cannot give the 40 N of a reamer */
    double stiffness;          /* N/m, of the coupling as the hand feels it */
    double damping;            /* N s/m, likewise */
    double speed;              /* rad/s, of the tool about its own z axis; 0: it does not cut */
    double cutting_ratio;      /* tangential over normal force of what cuts */
    double energy;             /* J/m^3, to cut bone of reference density */
    double reference_density;  /* g/cm^3 */
    double density_at_0;       /* g/cm^3 of 0 HU, */
    double density_per_hu;     /* and for each HU more */
    double layer;              /* m, that is pressed together (instant) */
    double layer_stiffness;    /* N/m^3, per area and depth, of bone of reference density (instant) */
    double turn_stiffness;     /* N m/rad, of the coupling's turn as the hand feels it; 0: the tool's direction is the hand's (energy) */
    double turn_damping;       /* N m s/rad, likewise */
    double vibration;          /* of teeth that pass: its amplitude over the felt force of what cuts reference bone; 0: none */
    double runout;             /* likewise, once a turn and across the axis */
    double teeth;              /* that pass in a turn */
} ost_force_params;

OST_API ost_force_params ost_force_defaults(void);
/* J/m^3 to cut bone of that many HU: energy * (density / reference)^2. */
/* g/cm^3 of that many HU. */
OST_API double ost_force_density(const ost_force_params *params, int hu);
OST_API double ost_force_energy(const ost_force_params *params, int hu);

/* ------------------------------------------------------------------ shells */

typedef struct ost_shell_point {
    double at[3], inward[3]; /* m, tool's frame; inward has length 1 */
    double area;             /* m^2 */
    bool cutting;
} ost_shell_point;

enum { OST_SHELL_MAX = 512 };
typedef struct ost_shell {
    size_t count;
    ost_shell_point *points; /* owned */
} ost_shell;

/* Of a tool's voxels: at most OST_SHELL_MAX points, whose areas are those of the surface they stand for. */
OST_API ost_status ost_shell_make(const ost_tool_volume *tool, ost_shell *out, ost_error *err);
OST_API void ost_shell_free(ost_shell *shell);

/* ------------------------------------------------------------------- force */

typedef struct ost_force ost_force;

/* The bone is borrowed. params may be NULL. OST_ERR_UNAVAILABLE on a backend that cannot be asked for single voxels. */
OST_API ost_status ost_force_create(const ost_bone *bone, const ost_force_params *params, ost_force **out, ost_error *err);
OST_API void ost_force_free(ost_force *force); /* NULL is allowed */
/* In the order of the world's tools. */
OST_API ost_status ost_force_add_tool(ost_force *force, const ost_tool *tool, ost_error *err);
/* The same with points of one's own, copied. */
OST_API ost_status ost_force_add_shell(ost_force *force, const ost_shell *shell, ost_error *err);

/* Real forces and what the hand is to feel of them, in the bone's frame; torques about the tool's origin. */
typedef struct ost_force_result {
    ost_pose tool;        /* where the tool is now */
    double force_n[3], torque_nm[3];           /* felt, before the safety layer */
    double axial_n;       /* real, along the tool's axis against its advance */
    double off_axis_n;    /* real, across it */
    double cutting_nm;    /* real torque about the axis */
    double power_w;       /* real, that goes into cutting */
    double shaking_n;     /* felt force of what cuts, by its density: what vibration and runout are shares of */
    int touching;         /* points that touch bone */
} ost_force_result;

/*
 * A tick of period_s.  device is where the hand is.  Nothing is removed here:
 * the world takes out->tool.  Asks for no memory.  The first tick of a tool
 * that was not placed puts it where the device is.
 */
OST_API ost_status ost_force_step(ost_force *force, int tool, const ost_pose *device, double period_s, ost_force_result *out, ost_error *err);
/* The same, and then as if it had not been: what a tick from here would do (see ost_world_rehearse). */
OST_API ost_status ost_force_rehearse(ost_force *force, int tool, const ost_pose *device, double period_s, ost_force_result *out,
                                      ost_error *err);
/*
 * The motor of the tool in the hand (AR-MOTOR): its speed from here on in rad/s,
 * 0 being off, when the tool presses and does not cut; and by how many radians
 * about its own z axis it has turned the tool, and with it the device's pose,
 * since the last tick.
 */
OST_API void ost_force_motor(ost_force *force, double speed, double turned);
/* The tool is in the hand, and at a pose that may not be the device's. */
OST_API void ost_force_place(ost_force *force, int tool, const ost_pose *pose);

/* ------------------------------------------------------------------ safety */

/* What stands between a force and a hand. SI units; sources in docs/force.md. */
typedef struct ost_safety_params {
    double max_n, max_nm;       /* saturation, smooth */
    double slew_n;              /* N a tick at most */
    double ramp_s;              /* from nothing to all of it, after a start and after every fault */
    int stale_ticks;            /* so many ticks without a new pose and the force goes */
    uint32_t dead_man;          /* buttons of which one must be held; 0: none */
    double stored_j;            /* energy that the coupling may hold back: passivity counts from there */
    double max_damping;         /* N s/m at most, that the passivity controller adds; 0: none */
} ost_safety_params;

OST_API ost_safety_params ost_safety_defaults(void);

/* ----------------------------------------------------------- a file of them */

/* The parameters of both by name: "stiffness", "N/m", a sentence with its source, and what is supported. */
typedef struct ost_force_key {
    const char *name, *unit, *about;
    double lo, hi;
} ost_force_key;

OST_API int ost_force_key_count(void);
OST_API const ost_force_key *ost_force_key_at(int index); /* NULL beyond the last */
OST_API double ost_force_key_value(int index, const ost_force_params *force, const ost_safety_params *safety);
enum { OST_FORCE_VALUE = 32 };
OST_API char *ost_force_value_text(double value, char text[OST_FORCE_VALUE]); /* as a file has it */

/*
 * Lines "key: number" and comments after #; keys that are not there stay as
 * they are.  On an error, which names file, line, key, value and what was
 * expected, nothing is changed.
 */
OST_API ost_status ost_force_params_read(const char *file, ost_force_params *force, ost_safety_params *safety, ost_error *err);

typedef struct ost_safety {
    ost_safety_params params;
    double ramp, last[3], last_torque[3], energy_j, applied[3];
    double at[3];
    bool has_at;
    int stale;
    uint64_t damped_ticks; /* in which the passivity controller took something */
} ost_safety;

typedef enum ost_safety_answer {
    OST_SAFETY_GIVEN,
    OST_SAFETY_WITHHELD, /* dead-man released or poses missing: the force goes, and ramps in afterwards */
    OST_SAFETY_FAULT     /* a force that is no number: nothing is given, and it ramps in afterwards */
} ost_safety_answer;

OST_API void ost_safety_begin(ost_safety *safety, const ost_safety_params *params); /* NULL: the defaults */
/* After a fault: no force, and a new ramp. */
OST_API void ost_safety_stop(ost_safety *safety);
/* force and torque as felt, in and out; device is where the hand is now, fresh whether that is new. */
OST_API ost_safety_answer ost_safety_step(ost_safety *safety, const ost_pose *device, bool fresh, uint32_t buttons, double period_s, double force_n[3],
                                          double torque_nm[3]);

#ifdef __cplusplus
}
#endif
#endif
