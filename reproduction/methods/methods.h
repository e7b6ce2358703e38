/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The removal algorithms with which the thesis is compared (sections 2.2 and 3.2), and their
 * measurements. Each measurement is one function that appends rows to a table and prints nothing.
 *
 *   options --> methods_chunk_counts   Figs. 3.8, 3.10 to 3.12  1 to 64 chunks in an event
 *               methods_resolutions    Figs. 3.9 to 3.12        tool and bone of 64^3 to 1024^3 voxels
 *               methods_sampling       holes that tool points leave, by the ratio of voxel sizes
 *               methods_sampling_slice a picture of these holes
 *
 * All methods of a case process the same bone, tool and pose (bench/scene.h), and their repetitions alternate. Before a
 * method is timed, its set of removed voxels is compared with the set that its definition requires. The member `exact`
 * of the row is true if the sets are equal. Sets of different definitions differ; the members `missed`, `missed_inside`
 * and `extra` count the differences from osteon's set.
 *
 * Threads: only one measurement may run at a time. It uses options->threads threads.
 */
#ifndef OST_REPRODUCTION_METHODS_H
#define OST_REPRODUCTION_METHODS_H

#include "bench/bench.h"

#include <osteon/phantom.h>

/* The definition of the set of active bone voxels that a method removes. */
typedef enum methods_definition {
    METHODS_BONE_TO_TOOL,       /* osteon's set: the voxels whose centre is in a cutting tool voxel (AR-REM-1) */
    METHODS_BONE_TO_TOOL_FLOAT, /* the thesis' set: the same definition, but computed with a float matrix */
    METHODS_TOOL_TO_BONE        /* the voxels that contain a tool point, that is, the centre of a cutting tool voxel */
} methods_definition;

/* The tool points of the methods that process the tool's voxels. */
typedef enum methods_points {
    METHODS_POINTS_SURFACE, /* cutting voxels with a face neighbour that is not cutting, as in the publications */
    METHODS_POINTS_SOLID    /* all cutting voxels */
} methods_points;

typedef struct methods_info {
    /* short name, such as "yau"; the suffix "-cl" denotes the variant for an OpenCL device, such as "yau-cl" */
    const char *name;
    const char *title;  /* one-line description for tables and legends */
    const char *source; /* the publication, or the section of the thesis */
    methods_definition definition;
    bool device; /* true if the method runs on the device options->cl */
} methods_info;

/* Returns the number of methods. The methods have a fixed order; the first is osteon's event. */
int methods_count(void);
/* Returns the description of method `index`, 0 <= index < methods_count(). Its strings are static. */
const methods_info *methods_info_get(int index);

typedef struct methods_options {
    const char *backend;  /* osteon's backend, such as "cpu" */
    const char *cl;       /* device for the OpenCL methods, such as "cl:platform=0,device=0"; NULL for none */
    int threads;          /* number of threads for osteon's event and every other CPU method; at least 1 */
    int repeat;           /* number of repetitions; 0 selects 21, or fewer for events that take longer than 0.1 s */
    bool quick;           /* true for 3 repetitions and smaller scenes */
    methods_points points;
    const char *methods;  /* comma-separated names of methods; NULL for all */
    void (*show)(void *user, const char *text); /* called before a case is measured; may be NULL */
    void *user;
} methods_options;

/* The result of one method on one scene. */
typedef struct methods_row {
    const methods_info *method;
    char reason[BENCH_TEXT]; /* reason why the method was not measured; "" if it was measured */

    /* the scene */
    const char *tool;               /* "reamer" or "peg" */
    ost_pm tool_voxel, bone_voxel;  /* edge lengths */
    int32_t tool_side, bone_side;   /* in voxels: longest side of the tool's grid; side of the bone */
    int64_t tool_voxels;            /* number of the tool's cutting voxels */
    int64_t tool_points;            /* number of tool points, of the kind options->points */
    int chunk_size;
    int chunks;                     /* number of chunks with active voxels that the event processes (Alg. 2.10) */
    methods_points points;
    int threads;                    /* number of threads; 0 for a method on a device */

    /* the times of an event, in microseconds */
    bench_figures fresh;  /* times of an event with all voxels restored beforehand */
    bench_figures steady; /* times of a repeated event, which has no voxel left to remove */

    /* the work and the result */
    /* number of bone voxels or tool points that the method transforms; 0 if the method does not count them */
    int64_t visited;
    int64_t removed;
    int64_t expected;      /* number of voxels in osteon's set */
    int64_t missed, extra; /* number of voxels only in osteon's set; number of voxels only in the method's set */
    int64_t missed_inside; /* number of missed voxels whose six neighbours all belong to osteon's set */
    /* true if the method's set equals the set that the method's definition requires; false indicates an error */
    bool exact;
    /* memory in bytes for the bone's voxels; for the chunk table, positions, nodes or masks; for the tool */
    int64_t bone_bytes, index_bytes, tool_bytes;
} methods_row;

typedef struct methods_table {
    size_t count, capacity;
    methods_row *rows; /* owned */
} methods_table;

void methods_table_free(methods_table *table);

/*
 * Each of these measurements appends its rows to *table, which must be zero-initialized before the first call. If a
 * method or a case cannot be measured, its rows contain the reason. Errors: OST_ERR_MEMORY, and OST_ERR_USAGE for an
 * unknown method or backend.
 */

/*
 * Figs. 3.8 and 3.10 to 3.12: the tool is inside a bone in which only the counts[i] chunks that are closest to the
 * tool's centre have active voxels. The chunks have 32^3 voxels. To make 64 chunks possible, the voxels of bone and
 * tool are smaller than in the static event: half as long for a reamer, and a quarter as long for a peg. If a count
 * exceeds the number of chunks that the tool's box enters, the rows of this count contain the reason.
 */
ost_status methods_chunk_counts(const methods_options *options, ost_tool_kind tool, const int *counts, int count,
                                methods_table *table, ost_error *err);

/*
 * Figs. 3.9 to 3.12: the static event with the bone's box divided into bone_side^3 voxels and the tool's longest side
 * into about tool_side voxels. The physical sizes and the pose are constant. If a case needs more memory than is free,
 * its rows contain the reason.
 */
ost_status methods_resolutions(const methods_options *options, ost_tool_kind tool, const int32_t *tool_sides,
                               int tool_count, const int32_t *bone_sides, int bone_count, methods_table *table,
                               ost_error *err);

/* ----------------------------------------------------------------- sampling */

/* A comparison of the voxels hit by tool points with osteon's set, for one ratio of voxel sizes. */
typedef struct methods_sample {
    const char *tool;
    methods_points points;
    double ratio; /* edge of a tool voxel divided by the edge of a bone voxel */
    ost_pm tool_voxel, bone_voxel;
    /* number of poses: 1 for a static event; otherwise the tool moves half a bone voxel along its axis per pose */
    int poses;
    int64_t tool_points;
    int64_t expected;      /* number of voxels in osteon's set, which is the union over all poses */
    int64_t found;         /* number of voxels in both osteon's set and the set of the tool points */
    int64_t missed, extra; /* same meaning as in methods_row */
    int64_t missed_inside;
    double missed_share;   /* missed / expected */
    double missed_inside_share; /* missed_inside / expected */
} methods_sample;

/*
 * Computes samples[i] for each ratios[i], which must be from 0.125 to 4. All voxels of the bone are active and have
 * edges of 0.47 mm. The number of poses must be from 1 to 1000. Errors: OST_ERR_RANGE, OST_ERR_MEMORY.
 */
ost_status methods_sampling(ost_tool_kind tool, methods_points points, int poses, const double *ratios, int count,
                            methods_sample *samples, ost_error *err);

/* Values of the voxels in a slice. The two sets are osteon's set and the set of the tool points. */
enum {
    METHODS_SLICE_NONE,          /* in neither set */
    METHODS_SLICE_BOTH,          /* in both sets */
    METHODS_SLICE_MISSED,        /* only in osteon's set */
    METHODS_SLICE_MISSED_INSIDE, /* only in osteon's set, which also contains all six neighbours */
    METHODS_SLICE_EXTRA          /* only in the set of the tool points */
};

/* A slice of the bone perpendicular to z, through the middle of the removed voxels. */
typedef struct methods_slice {
    int32_t width, height;
    int32_t x0, y0, z; /* position of the first value in the bone */
    uint8_t *values;   /* owned; width * height values, x fastest */
} methods_slice;

/*
 * Computes the slice for the case that methods_sampling measures with the same arguments. The caller frees *slice with
 * methods_slice_free.
 */
ost_status methods_sampling_slice(ost_tool_kind tool, methods_points points, int poses, double ratio,
                                  methods_slice *slice, ost_error *err);
void methods_slice_free(methods_slice *slice);

#endif
