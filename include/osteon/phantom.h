/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Generated bones and parametric tools, so that all programs can be run without patient data.
 *
 * A phantom is a CT: densities in HU on a rect grid whose size and spacing are taken from Table 3.1 of the thesis. The
 * densities include the partial volume effect, and noise that is generated from a seed. The same seed gives the same
 * grid on every machine, because the noise is computed with integers and no libm function except sqrt is used. The meta
 * of the volume contains the position and axis of the glenoid, the side (OST_META_GLENOID_AT, OST_META_GLENOID_AXIS,
 * OST_META_SIDE), and the landmarks of the scapula (OST_META_TRIGONUM, OST_META_INFERIOR_ANGLE).
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_PHANTOM_H
#define OSTEON_PHANTOM_H

#include <osteon/tool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum ost_phantom_kind {
    OST_PHANTOM_SCAPULA,     /* 256 x 234 x 201 voxels of 0.47 x 0.47 x 1 mm */
    OST_PHANTOM_GLENOID,     /* 49 x 81 x 41 voxels of 0.47 x 0.47 x 1 mm: the glenoid of the scapula phantom */
    OST_PHANTOM_TRABECULAR,  /* core 1: 156 x 156 x 313 voxels of 32 um */
    OST_PHANTOM_TRABECULAR2, /* core 2: 314 x 316 x 360 voxels of 32 um */
    OST_PHANTOM_FOAM,        /* 314 x 320 x 604 voxels of 32 um */
    OST_PHANTOM_SHOULDER,    /* 336 x 234 x 201 voxels of 0.47 x 0.47 x 1 mm: scapula and humerus, which touch */
    OST_PHANTOM_COUNT
} ost_phantom_kind;

typedef struct ost_phantom_options {
    uint64_t seed;     /* seed of the noise; 0 selects 1 */
    /* Spacing; 0 selects the spacing of the thesis. The physical size does not depend on the spacing, so dims =
     * ceil(size / spacing). */
    ost_pm3 spacing;
    double scale;      /* scale of the anatomy and of its box; 0 selects 1 */
    bool left;         /* true for a left scapula; the default is a right scapula */
    ost_progress *progress; /* called with the stage "generating"; may be NULL */
    void *progress_user;
} ost_phantom_options;

/* Returns the name of a kind of phantom, as used by `osteon phantom`; static. */
OST_API const char *ost_phantom_name(ost_phantom_kind kind);
/*
 * Generates a phantom. options may be NULL. Returns OST_ERR_RANGE if the scale is not within 0.125 to 8, if a spacing
 * is not within 0.001 to 100 mm, or if the grid is too large. Returns OST_ERR_USAGE for an unknown kind,
 * OST_ERR_CANCELLED if the progress function returns false, and OST_ERR_MEMORY if memory is exhausted. The caller frees
 * *out with ost_volume_free.
 */
OST_API ost_status ost_phantom_make(ost_phantom_kind kind, const ost_phantom_options *options, ost_volume *out,
                                    ost_error *err);

/*
 * Parametric tools as closed triangle meshes.  In the tool's frame, the working face points in the
 * cutting direction, -z, and the shaft points to +z.  Lengths are in picometres; 0 selects the
 * default.
 *   reamer  domed head with teeth, and a non-cutting hub; the default bounds
 *           are (-18, -18, 0)..(17.4, 18, 20.3) mm
 *   peg     cylinder
 *   burr    sphere on a shaft
 */
typedef enum ost_tool_kind { OST_TOOL_REAMER, OST_TOOL_PEG, OST_TOOL_BURR, OST_TOOL_KIND_COUNT } ost_tool_kind;

/*
 * A part of a tool: the complete tool, its cutting part (head) or its non-cutting part (shaft).
 * The shaft of a reamer is the hub on the back of its head; the shaft of a burr starts at the centre of the sphere.
 * The union of head and shaft is the complete tool.  A peg has no shaft.
 */
typedef enum ost_tool_part { OST_TOOL_COMPLETE, OST_TOOL_HEAD, OST_TOOL_SHAFT } ost_tool_part;

typedef struct ost_tool_options {
    ost_pm diameter; /* the default is 36 mm for a reamer, 6 mm for a peg and 6 mm for a burr */
    /* The default is 20.3 mm for a reamer's head, 30 mm for a peg and 20 mm for a burr's shaft. */
    ost_pm length;
    int segments;    /* number of segments around the axis; 0 selects 96 */
    ost_tool_part part;
} ost_tool_options;

/* Returns the name of a kind of tool, as used by `osteon tool`; static. */
OST_API const char *ost_tool_kind_name(ost_tool_kind kind);
/* Returns true if tools of the given kind have a shaft. */
OST_API bool ost_tool_has_shaft(ost_tool_kind kind);
/*
 * Creates the closed mesh of a tool in the frame of the tool. options may be NULL. Returns OST_ERR_USAGE if this kind
 * of tool does not have the part options->part, or if a length or the number of segments is out of range. Returns
 * OST_ERR_MEMORY if memory is exhausted. The caller frees *out with ost_mesh_free.
 */
OST_API ost_status ost_tool_make(ost_tool_kind kind, const ost_tool_options *options, ost_mesh *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
