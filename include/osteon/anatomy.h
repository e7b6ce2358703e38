/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the parts of a bone that an operation needs: spheres, such as the humeral head, and the
 * landmarks of a scapula.
 *
 *   voxels --surface--> points, normals --votes along the normals--> candidates --least squares--> spheres
 *   spheres --the one that faces a vault--> face --rim--> centre, axis; blade --spine--> trigonum, inferior angle
 *
 * The results are proposals, not measurements. Each proposal has figures that state its uncertainty, and a surgeon
 * confirms or corrects it. The results are the same on every machine: they are computed from additions,
 * multiplications, divisions and square roots of doubles in a fixed order, and lengths are rounded to 0.01 mm.
 *
 * Threads: the functions have no state and may run on any thread; a volume that is passed
 * as const may be shared.
 */
#ifndef OSTEON_ANATOMY_H
#define OSTEON_ANATOMY_H

#include <osteon/grid.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The bone voxels of a volume, which are the voxels with values from `low` to `high`. `low` must be at least 1. For
 * label k of a label map, both members are k. For a CT, `low` is the threshold and `high` is 32767.
 */
typedef struct ost_anatomy_bone {
    const ost_volume *volume;
    int32_t low, high;
} ost_anatomy_bone;

/* Options of a search for spheres. A zero-initialised struct selects the defaults. */
typedef struct ost_sphere_options {
    bool concave; /* true if the bone lies outside the sphere, as at the glenoid; false if it lies inside */
    /* limits of the radius, 5 to 100 mm; if both are 0, they are 17 and 32 mm, or 20 and 45 mm for concave spheres */
    ost_pm radius_min, radius_max;
    bool has_near;                  /* true to find only spheres whose centres are within `reach` of `near` */
    ost_pm3 near;
    ost_pm reach;
} ost_sphere_options;

/* A sphere that fits a part of the surface of a bone. */
typedef struct ost_sphere {
    ost_pm3 centre;     /* centre of the sphere; the centre and the radius are rounded to 0.01 mm */
    ost_pm radius;
    double coverage;    /* share of the sphere's area that lies on the bone's surface, 0 to 1 */
    double area_mm2;    /* area of the part of the bone's surface that lies on the sphere */
    double residual_mm; /* RMS distance between this part of the surface and the sphere */
    double facing[3];   /* unit vector from the centre to the middle of this part of the surface */
} ost_sphere;

enum { OST_SPHERES_MAX = 16 };
/*
 * Finds spheres on the surface of a bone. Cavities in the bone are ignored. Stores the spheres in out and their number
 * in *count. The parameter `most` is the capacity of out, 1 to OST_SPHERES_MAX. Convex spheres are in descending order
 * of coverage, which is at least 0.15. Concave spheres are in descending order of area, which is at least 200 mm2. The
 * centres of two spheres are at least 10 mm apart. Returns OST_ERR_RANGE if an option is out of range, and
 * OST_ERR_INPUT if there is no bone or no sphere.
 */
OST_API ost_status ost_spheres_find(const ost_anatomy_bone *bone, const ost_sphere_options *options, ost_sphere *out,
                                    int most, int *count, ost_error *err);

enum { OST_RIM_MAX = 72 }; /* number of directions, one every 5 degrees, in which the glenoid's rim is searched for */

/*
 * Landmarks of a scapula, defined in docs/reference/landmarks.md. Lengths and positions are rounded to 0.01 mm, and
 * components of the axis to 0.000001.
 */
typedef struct ost_scapula_landmarks {
    ost_pm3 glenoid;       /* centre of the glenoid's face */
    double axis[3];        /* unit vector into the bone, perpendicular to the plane of the rim */
    ost_pm3 trigonum, inferior; /* trigonum spinae and inferior angle */
    bool left;
    ost_sphere curvature;  /* sphere that fits the face */
    ost_pm height, width;  /* extent of the rim along the superior direction, and perpendicular to it */
    ost_pm3 rim[OST_RIM_MAX];
    int rim_count;
    /*
     * The uncertainty of the proposal. A spread is the maximum change in a value when the search is repeated with the
     * surface moved inward or outward, with only the even or only the odd directions of the rim, and on a coarser grid.
     */
    double rim_share;      /* share of the directions in which the rim was found */
    double rim_residual_mm; /* RMS distance of the rim from its plane */
    double glenoid_spread_mm, axis_spread_deg, trigonum_spread_mm, inferior_spread_mm;
} ost_scapula_landmarks;

/*
 * Proposes the landmarks of a scapula. `head` is the sphere of the humeral head, or NULL if it is not known. Returns
 * OST_ERR_INPUT with the reason if the bone is not a complete scapula with one glenoid, or if its glenoid is not
 * visible from outside.
 */
OST_API ost_status ost_scapula_landmarks_find(const ost_anatomy_bone *bone, const ost_sphere *head,
                                              ost_scapula_landmarks *out, ost_error *err);

/*
 * Finds the rim of a glenoid, given its centre (mm) and its inward axis. The result has up to OST_RIM_MAX
 * positions, ordered around the axis. Returns OST_ERR_RANGE if a coordinate of the centre is beyond 8 m or the axis is
 * zero, and OST_ERR_INPUT if the region around the centre is outside the volume.
 */
OST_API ost_status ost_glenoid_rim_find(const ost_anatomy_bone *bone, const double centre_mm[3], const double axis[3],
                                        ost_pm3 rim[OST_RIM_MAX], int *count, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
