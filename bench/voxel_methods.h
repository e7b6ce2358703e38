/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measurements of the two methods by which the thesis draws voxels (sections 3.3.1 to 3.3.3): triangle
 * meshes of the visible faces (--renderer mesh), and GL_POINTs (--renderer thesis and --renderer gl).
 *
 *   phantom --> model: rect grid, cubic grid, surface
 *                 |--> bench_voxel_memory    Table 3.7, Fig. 3.15   counts and bytes
 *                 |--> bench_voxel_mesh      Table 3.8              time of each stage per chunk
 *                 |--> bench_voxel_idle      Figs. 3.13, 3.14, 3.16 frame time against the number of chunks
 *                 '--> bench_voxel_removal   section 3.3.3          frame time while a tool removes bone
 *
 * The functions print nothing. A missing OpenGL implementation or OpenCL device is not an error: the result then
 * contains the reason why nothing was measured. All frames have 1280 x 720 pixels and show the
 * complete model. One thread at a time may use a model.
 */
#ifndef OST_BENCH_VOXEL_METHODS_H
#define OST_BENCH_VOXEL_METHODS_H

#include "bench/bench.h"

#include <osteon/phantom.h>

typedef struct bench_voxel_model bench_voxel_model;

/* The methods. */
typedef enum bench_voxel_method {
    BENCH_VOXEL_MESH,   /* one quad for each visible face; if a chunk changes, it is meshed again */
    BENCH_VOXEL_THESIS, /* one GL_POINT for each voxel of each active chunk */
    BENCH_VOXEL_POINTS, /* osteon's GL_POINTs: one for each surface voxel that faces the camera */
    BENCH_VOXEL_METHODS
} bench_voxel_method;

/*
 * Generates a phantom, resamples it and extracts its surface. The backend options->backend computes the cubic grid, and
 * options->quick reduces the size to a quarter. The phantom's size is multiplied by `scale`, which must be in (0, 1].
 * At scale 1, the foam has 60 million voxels.
 */
ost_status bench_voxel_open(const bench_options *options, ost_phantom_kind kind, double scale, bench_voxel_model **out,
                            ost_error *err);
void bench_voxel_close(bench_voxel_model *model); /* model may be NULL */
/*
 * Returns the number of active chunks of 32^3 voxels in the cubic grid. This is the number of chunks that can be drawn.
 */
int32_t bench_voxel_chunks(const bench_voxel_model *model);

/* ----------------------------------------------------- memory (Table 3.7, Fig. 3.15) */

/* The counts of a grid that is divided into chunks of 32^3 voxels, and the sizes of its buffers in bytes. */
typedef struct bench_voxel_grid {
    ost_geometry geometry;
    int64_t chunks, active_chunks; /* number of chunks; number of chunks with at least one active voxel */
    int64_t voxels;                /* number of voxels, without the padding of chunks */
    int64_t active_voxels;
    int64_t surface_voxels;        /* number of active voxels with at least one visible face */
    int64_t faces;                 /* visible faces */
    int64_t voxel_bytes;           /* 2 bytes for each voxel of an active chunk, as in Table 3.7 */
    int64_t mesh_bytes;            /* 16 bytes for the vertices of each face */
    int64_t look_bytes;            /* 4 bytes for the appearance of each face in osteon's mesh */
    int64_t point_bytes;           /* 8 bytes for each surface voxel in the buffer of osteon's GL_POINTs */
} bench_voxel_grid;

typedef struct bench_voxel_counts {
    bench_voxel_grid rect;  /* the grid with the CT's voxel size; the thesis' triangle mesh needs no cubic voxels */
    bench_voxel_grid cubic; /* the grid with cubic voxels, which GL_POINTs need */
} bench_voxel_counts;

ost_status bench_voxel_memory(const bench_voxel_model *model, bench_voxel_counts *out, ost_error *err);

/* ------------------------------------------------------------- stages (Table 3.8) */

typedef enum bench_voxel_stage {
    BENCH_VOXEL_PAD,      /* "Copy chunk cluster data to padded Chunk" */
    BENCH_VOXEL_CLASSIFY, /* "Classify active voxels in padded chunk" */
    BENCH_VOXEL_COMPACT,  /* "Generate sparse active voxels buffer with parallel prefix scan" */
    BENCH_VOXEL_QUADS,    /* "Generate triangle mesh and transfer to global mesh buffer" */
    BENCH_VOXEL_COPY,     /* "Copy global mesh buffer data to chunk mesh buffer" */
    BENCH_VOXEL_STAGES
} bench_voxel_stage;
const char *bench_voxel_stage_name(bench_voxel_stage stage); /* static */

typedef struct bench_voxel_stages {
    char reason[BENCH_TEXT];                  /* reason why nothing was measured; "" if measured */
    /* options string of the backend, such as "cl:platform=0", and name of the device */
    char backend[BENCH_NAME], device[BENCH_TEXT];
    int32_t chunks;                           /* number of chunks meshed in each repetition */
    int32_t at_a_time;                        /* number of chunks in one call: 1, as in the thesis, or `chunks` */
    bench_figures stage[BENCH_VOXEL_STAGES];  /* times of the stages in microseconds per chunk, over all repetitions */
    bench_figures total;                      /* sum of the stages in microseconds per chunk */
    /* time of the same calls in microseconds per chunk, without timing the stages; with several threads, this time is
       shorter than `total` */
    bench_figures elapsed;
    double faces_per_chunk;
} bench_voxel_stages;

/*
 * Meshes every chunk of the cubic grid on a backend: "ref" uses scalar code, "cpu" bit operations and threads, and
 * "cl..." OpenCL. The flag `one` selects one chunk per call, as in the thesis, instead of all chunks in one call.
 * `repeat` is the number of repetitions, at least 1.
 */
ost_status bench_voxel_mesh(const bench_voxel_model *model, const char *backend, bool one, int repeat,
                            bench_voxel_stages *out, ost_error *err);

/* ------------------------------------------------- frames (Figs. 3.13, 3.14, 3.16) */

typedef struct bench_voxel_frame {
    int32_t chunks;        /* chunks drawn */
    bench_figures ms;      /* milliseconds per frame; each frame ends with glFinish */
    uint64_t vertices;     /* number of vertices that are passed to OpenGL in a frame */
} bench_voxel_frame;

typedef struct bench_voxel_frames {
    char reason[BENCH_TEXT]; /* reason why nothing was measured; "" if measured */
    char opengl[BENCH_TEXT]; /* name and version of the driver */
    bool software;           /* true if the processor executes OpenGL */
    int32_t count;
    bench_voxel_frame *frame; /* owned; `count` entries */
} bench_voxel_frames;
void bench_voxel_frames_free(bench_voxel_frames *frames);

/*
 * Measures idle frames, between which nothing changes. Each element n of `counts` (1 to bench_voxel_chunks) selects a
 * measurement of `repeat` frames. These frames show the first n chunks in the order of the grid.
 */
ost_status bench_voxel_idle(const bench_voxel_model *model, bench_voxel_method method, const int32_t *counts, int count,
                            int repeat, bench_voxel_frames *out, ost_error *err);

/* --------------------------------------------------------- removal (section 3.3.3) */

typedef struct bench_voxel_cut {
    char reason[BENCH_TEXT]; /* reason why nothing was measured; "" if measured */
    char opengl[BENCH_TEXT];
    int32_t frames;
    /* milliseconds per frame, including the update of the surface, meshing, drawing and glFinish */
    bench_figures ms;
    bench_figures idle_ms;   /* milliseconds per frame if a frame is drawn again without a change */
    double changed_chunks;   /* mean number of chunks from which voxels are removed in a frame */
    double meshed_chunks;    /* mean number of chunks that are meshed again in a frame; 0 for GL_POINTs */
    double mesh_ms, copy_ms; /* mean times in ms per frame for meshing and for copying the meshes to OpenGL */
    /* mean time in ms per frame for updating the lists and the appearance of surface voxels, which all methods need */
    double update_ms;
    uint64_t uploaded;       /* mean number of bytes copied to OpenGL per frame */
} bench_voxel_cut;

/*
 * Measures the time per frame while a ball moves into the model. The ball advances by a quarter of a voxel per frame.
 * Its radius is 38 voxels times the scale of the model, but at least 4 voxels. In the scapula at scale 1, this is
 * 18 mm, the radius of the thesis' reamer head. The model is restored at the end. `mesher` is the backend that meshes
 * the chunks, such as "cpu"; only BENCH_VOXEL_MESH uses it.
 */
ost_status bench_voxel_removal(bench_voxel_model *model, bench_voxel_method method, const char *mesher, int frames,
                               bench_voxel_cut *out, ost_error *err);

#endif
