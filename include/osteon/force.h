/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Force feedback: the force and the torque that a tool in contact with bone
 * exerts on the hand.
 *
 *   device's pose --coupling--> tool's pose --> ost_world_step, recorded
 *                     |             '--shell--> bone's densities
 *                     '--> force --safety--> device
 *
 * The tool's surface is a shell of points with inward normals.  A point touches bone if the position one voxel outward
 * from the point lies in an active voxel.  There are two force laws:
 *
 *   energy    A spring and a damper couple the tool to the device.  The pressure of a
 *             cutting point on bone determines the point's cutting power.  The point
 *             advances as fast as this power removes bone, so dense bone takes longer.
 *             A non-cutting point that touches bone stops the tool.
 *   instant   The tool is at the device's pose, as in the thesis. The force is
 *             that of an elastic layer of bone, compressed around the tool.
 *
 * The force is computed in floating point.  The removal of bone uses integers only:
 * the tool's pose is quantised before ost_world_step uses it, and a session records
 * the quantised pose.  docs/reference/force.md contains the equations, the parameters
 * and their sources.
 *
 * Threads: an ost_force may be used only on the thread of its world. An ost_safety may be used by one thread at a
 * time. The other functions share no state.
 */
#ifndef OSTEON_FORCE_H
#define OSTEON_FORCE_H

#include <osteon/backend.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The force law; the comment at the top of this file describes both laws. */
typedef enum ost_force_mode { OST_FORCE_ENERGY, OST_FORCE_INSTANT } ost_force_mode;

/* Parameters of the force, in SI units. docs/reference/force.md lists the source of each default. */
typedef struct ost_force_params {
    ost_force_mode mode;
    /* Ratio of hand force to contact force. The default is below 1, because a device with a limit of 3.3 N, for
     * example, cannot render the 40 N of a reamer. */
    double scale;
    double stiffness;          /* stiffness of the coupling for the hand force, in N/m */
    double damping;            /* damping of the coupling for the hand force, in N s/m */
    double speed;              /* angular speed of the tool about its z axis in rad/s; with 0, the tool does not cut */
    double cutting_ratio;      /* ratio of tangential to normal force at a cutting point */
    double energy;             /* energy needed to cut bone of the reference density, in J/m^3 */
    double reference_density;  /* reference density in g/cm^3 */
    double density_at_0;       /* density at 0 HU in g/cm^3 */
    double density_per_hu;     /* increase in density per HU in g/cm^3 */
    double layer;              /* thickness of the compressed layer in m; only for OST_FORCE_INSTANT */
    /* Stiffness of the layer in N/m^3 (force per area and depth), for bone of the reference density; only for
     * OST_FORCE_INSTANT. */
    double layer_stiffness;
    /* Angular stiffness of the coupling for the hand torque, in N m/rad. With 0, the tool always has the device's
     * orientation. */
    double turn_stiffness;
    double turn_damping;       /* angular damping of the coupling, in N m s/rad */
    /* Amplitude of the force at the tooth-passing frequency, relative to shaking_n; 0 means no vibration. */
    double vibration;
    /*
     * Amplitude of the force perpendicular to the axis at the frequency of rotation, relative to shaking_n; 0 means no
     * runout.
     */
    double runout;
    double teeth;              /* number of teeth that pass a fixed point during one revolution */
} ost_force_params;

/* Returns the default parameters listed in docs/reference/force.md. */
OST_API ost_force_params ost_force_defaults(void);
/* Returns the density, in g/cm^3, of bone with `hu` Hounsfield units. */
OST_API double ost_force_density(const ost_force_params *params, int hu);
/*
 * Returns the energy, in J/m^3, needed to cut bone with `hu` Hounsfield units:
 * energy * (density / reference_density)^2.
 */
OST_API double ost_force_energy(const ost_force_params *params, int hu);

/* ------------------------------------------------------------------ shells */

typedef struct ost_shell_point {
    double at[3], inward[3]; /* position in m and inward unit normal, in the tool's frame */
    double area;             /* surface area that the point represents, m^2 */
    bool cutting;
} ost_shell_point;

enum { OST_SHELL_MAX = 512 };
/* A tool's surface as a set of points. */
typedef struct ost_shell {
    size_t count;
    ost_shell_point *points; /* owned */
} ost_shell;

/*
 * Computes a shell of at most OST_SHELL_MAX points from a tool's voxels.  The sum of the points' areas is the surface
 * area of the tool.  Returns OST_ERR_INPUT if no voxel of the tool is solid, and OST_ERR_MEMORY if memory is exhausted;
 * *out is then empty.  The caller frees *out with ost_shell_free.
 */
OST_API ost_status ost_shell_make(const ost_tool_volume *tool, ost_shell *out, ost_error *err);
/* Frees the points of a shell, which is then empty. */
OST_API void ost_shell_free(ost_shell *shell);

/* ------------------------------------------------------------------- force */

typedef struct ost_force ost_force;

/*
 * Creates an ost_force for a bone, without tools. The bone must outlive the ost_force. `params` is copied; NULL selects
 * the defaults. Returns OST_ERR_UNAVAILABLE if the bone's backend cannot read single voxels (for example `plugin`).
 * Returns OST_ERR_USAGE if bone is NULL, and OST_ERR_RANGE if a parameter is outside the range that ost_force_key_at
 * states, if speed is not within 0 to 10,000 rad/s, or if vibration is not 0 and more than 500 teeth pass per second.
 * Returns OST_ERR_MEMORY if memory is exhausted, and backend errors (backend.h). The caller frees *out with
 * ost_force_free.
 */
OST_API ost_status ost_force_create(const ost_bone *bone, const ost_force_params *params, ost_force **out,
                                    ost_error *err);
/* Frees a force. NULL is allowed. */
OST_API void ost_force_free(ost_force *force);
/*
 * Adds a tool. Tools must be added in the order of the world's tools. The tool's voxels are read during the call. The
 * errors are those of ost_tool_download, ost_shell_make and ost_force_add_shell.
 */
OST_API ost_status ost_force_add_tool(ost_force *force, const ost_tool *tool, ost_error *err);
/*
 * Adds a tool that is represented by the given shell. The shell is copied. Returns OST_ERR_USAGE if there are already
 * 16 tools or the shell has more than OST_SHELL_MAX points, and OST_ERR_MEMORY if memory is exhausted.
 */
OST_API ost_status ost_force_add_shell(ost_force *force, const ost_shell *shell, ost_error *err);

/* The result of a step, in the bone's frame. Torques are about the tool's origin. */
typedef struct ost_force_result {
    ost_pose tool;        /* pose of the tool after the step */
    double force_n[3], torque_nm[3];           /* hand force and hand torque before the safety layer */
    double axial_n;       /* contact force along the tool's axis, positive if the force opposes the tool's advance */
    double off_axis_n;    /* contact force perpendicular to the tool's axis */
    double cutting_nm;    /* contact torque about the tool's axis */
    double power_w;       /* power used to cut bone */
    /* Sum of the hand forces of the cutting points, each weighted by density / reference_density. */
    double shaking_n;
    int touching;         /* number of points that touch bone */
} ost_force_result;

/*
 * Advances the tool with index `tool` by one tick of period_s seconds towards the device's pose. Does not remove bone:
 * for this purpose, the caller passes out->tool to ost_world_step. Allocates no memory and does not block. In its first
 * step, a tool starts at the device's pose, unless ost_force_set_pose has set a different pose. Returns OST_ERR_USAGE
 * if no tool has this index or period_s is not greater than 0, and backend errors (backend.h).
 */
OST_API ost_status ost_force_step(ost_force *force, int tool, const ost_pose *device, double period_s,
                                  ost_force_result *out, ost_error *err);
/*
 * Computes the same step as ost_force_step but does not change the state. Afterwards, the caches contain the data
 * that the next ost_force_step needs (see ost_world_rehearse). The errors are those of ost_force_step.
 */
OST_API ost_status ost_force_rehearse(ost_force *force, int tool, const ost_pose *device, double period_s,
                                      ost_force_result *out, ost_error *err);
/*
 * If the bone is on a device, reads the voxels that removals have changed since the last step. Without this call, the
 * next ost_force_step reads these voxels and waits for the device. A program calls this function after it has written
 * the force to the haptic device. The call does not affect any result. The errors are those of ost_bone_sample.
 */
OST_API ost_status ost_force_refresh(const ost_force *force, ost_error *err);
/*
 * Sets the motor of the current tool (AR-MOTOR). `speed` is the angular speed in rad/s from now on. If speed is 0,
 * the motor is off, and the tool presses on bone without cutting. `turned` is the angle in radians by which the motor
 * has rotated the tool about its z axis since the last step. The device's pose that is passed to the next step must
 * include this rotation.
 */
OST_API void ost_force_motor(ost_force *force, double speed, double turned);
/* Makes `tool` the current tool and sets its pose, which may differ from the device's pose. */
OST_API void ost_force_set_pose(ost_force *force, int tool, const ost_pose *pose);

/* ------------------------------------------------------------------ safety */

/*
 * Limits that are applied to the computed force before it is sent to the device. docs/reference/force.md lists
 * their sources.
 */
typedef struct ost_safety_params {
    /* Maximum force in N and maximum torque in N m. A saturation function reduces every value to less than its maximum;
       it hardly changes a value far below the maximum. */
    double max_force_n, max_torque_nm;
    double slew_n;              /* maximum change in the force per tick, in N */
    double ramp_s;              /* time in s during which the force rises from 0 after a start or a fault */
    int max_ticks_without_sample; /* the force becomes 0 after this number of consecutive ticks without a new pose */
    /* Bit mask of dead-man buttons, at least one of which must be held; 0 means that no button is required. */
    uint32_t dead_man;
    /* Maximum energy in J that the coupling can store. The passivity observer enforces this limit. */
    double stored_j;
    double max_damping;         /* maximum damping in N s/m that the passivity controller adds; 0 means no controller */
} ost_safety_params;

/* Returns the default limits listed in docs/reference/force.md. */
OST_API ost_safety_params ost_safety_defaults(void);

/* ------------------------------------------------------------ parameter files */

/*
 * A parameter of ost_force_params or ost_safety_params: its name ("stiffness"), its unit ("N/m"), a sentence that
 * states its source, and the accepted range.
 */
typedef struct ost_force_key {
    const char *name, *unit, *about;
    double lo, hi;
} ost_force_key;

/*
 * Returns the number of parameters of ost_force_params and ost_safety_params together. The parameters are numbered from
 * 0 in a fixed order.
 */
OST_API int ost_force_key_count(void);
/* Returns the description of parameter number `index`, or NULL if index is out of range. The description is static. */
OST_API const ost_force_key *ost_force_key_at(int index);
/*
 * Returns the value of parameter number `index`, which is a member of *force or of *safety. Returns 0 if index is out
 * of range.
 */
OST_API double ost_force_key_value(int index, const ost_force_params *force, const ost_safety_params *safety);
enum { OST_FORCE_VALUE = 32 };
/* Writes a value to text in the format of a parameter file. Returns text. */
OST_API char *ost_force_value_text(double value, char text[OST_FORCE_VALUE]);

/*
 * Reads a file with lines of the form "key: number"; # starts a comment.  Parameters that are not in the file keep
 * their values.  Returns OST_ERR_INPUT if a line cannot be parsed and OST_ERR_RANGE if a value is out of range; err
 * then contains the file, the line, the key, the value and the expected range.  Returns OST_ERR_IO if the file cannot
 * be opened, and OST_ERR_MEMORY if memory is exhausted.  After an error, *force and *safety are unchanged.
 */
OST_API ost_status ost_force_params_read(const char *file, ost_force_params *force, ost_safety_params *safety,
                                         ost_error *err);

/* The state of the safety layer. Members other than `params` and `damped_ticks` are private. */
typedef struct ost_safety {
    ost_safety_params params;
    double ramp, last[3], last_torque[3], energy_j, applied[3];
    double at[3];
    bool has_at;
    int ticks_without_sample;
    uint64_t damped_ticks; /* number of ticks in which the passivity controller reduced the force */
} ost_safety;

/*
 * The safety layer's decision on the force of a tick. After OST_SAFETY_WITHHELD and OST_SAFETY_FAULT, the force
 * rises gradually from 0.
 */
typedef enum ost_safety_answer {
    OST_SAFETY_GIVEN,    /* the force is reduced to the limits and written to the device */
    OST_SAFETY_WITHHELD, /* the force is reduced to 0 because no dead-man button is held or poses are missing */
    OST_SAFETY_FAULT     /* the force is 0 because the computed force or torque is not finite */
} ost_safety_answer;

/* Initialises the safety layer. `params` is copied; NULL selects the defaults. */
OST_API void ost_safety_begin(ost_safety *safety, const ost_safety_params *params);
/* Sets the force to 0 after a fault. In the following steps, the force rises gradually from 0. */
OST_API void ost_safety_stop(ost_safety *safety);
/*
 * Applies the limits to force_n and torque_nm in place. `device` is the newest pose of the device. `fresh` is true if
 * this pose is new in this tick. Allocates no memory and does not block.
 */
OST_API ost_safety_answer ost_safety_step(ost_safety *safety, const ost_pose *device, bool fresh, uint32_t buttons,
                                          double period_s, double force_n[3], double torque_nm[3]);

#ifdef __cplusplus
}
#endif
#endif
