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
 * The functions print nothing. What cannot run on this machine (no OpenGL, no OpenCL device) is not an
 * error: the result contains the reason. All frames have 1280 x 720 pixels and show the complete model.
 * One thread at a time may use a model.
 */
#ifndef OST_BENCH_VOXEL_METHODS_H
#define OST_BENCH_VOXEL_METHODS_H

#include "bench/bench.h"

#include <osteon/phantom.h>

typedef struct bench_voxel_model bench_voxel_model;

/* The methods, in the order of the names "mesh", "thesis", "gl". */
typedef enum bench_voxel_method {
    BENCH_VOXEL_MESH,   /* one quad for each visible face; a changed chunk is meshed again */
    BENCH_VOXEL_THESIS, /* one GL_POINT for each voxel of each active chunk */
    BENCH_VOXEL_POINTS, /* osteon's GL_POINTs: surface voxels that face the camera */
    BENCH_VOXEL_METHODS
} bench_voxel_method;
const char *bench_voxel_method_name(bench_voxel_method method); /* static */

/* Models: the scapula, the glenoid, the two trabecular cores and the foam (thesis Fig. 1.4). */
extern const ost_phantom_kind bench_voxel_kinds[5];

/*
 * Generates a phantom, resamples it and extracts its surface. options->backend computes the cubic grid, and
 * options->quick selects a quarter of the size. scale: scale of the phantom, from 0 (exclusive) to 1; the
 * foam has 60 million voxels at scale 1.
 */
ost_status bench_voxel_open(const bench_options *options, ost_phantom_kind kind, double scale, bench_voxel_model **out,
                            ost_error *err);
void bench_voxel_close(bench_voxel_model *model); /* model may be NULL */
/* Returns the number of active chunks of 32^3 voxels of the cubic grid, which is the number that can be drawn. */
int32_t bench_voxel_chunks(const bench_voxel_model *model);

/* ----------------------------------------------------- memory (Table 3.7, Fig. 3.15) */

/* Counts and bytes of one grid, divided into chunks of 32^3 voxels. */
typedef struct bench_voxel_grid {
    ost_geometry geometry;
    int64_t chunks, active_chunks; /* active: with at least one active voxel */
    int64_t voxels;                /* voxels of the grid without the padding of chunks */
    int64_t active_voxels;
    int64_t surface_voxels;        /* active voxels with at least one visible face */
    int64_t faces;                 /* visible faces */
    int64_t voxel_bytes;           /* 2 bytes for each voxel of the active chunks, as in Table 3.7 */
    int64_t mesh_bytes;            /* vertices of all faces, 16 bytes for each face */
    int64_t look_bytes;            /* appearance for the OpenGL mesh, 4 bytes for each face */
    int64_t point_bytes;           /* buffer of osteon's GL_POINTs, 8 bytes for each surface voxel */
} bench_voxel_grid;

typedef struct bench_voxel_counts {
    bench_voxel_grid rect;  /* the CT's own voxels: the triangle mesh of the thesis needs no cubic voxels */
    bench_voxel_grid cubic; /* cubic voxels, which GL_POINTs need */
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
const char *bench_voxel_stage_name(bench_voxel_stage stage); /* short English name; static */

typedef struct bench_voxel_stages {
    char reason[BENCH_TEXT];                  /* reason why nothing was measured; "" if measured */
    char backend[BENCH_NAME], device[BENCH_TEXT]; /* for example "cl:platform=0" and the device's name */
    int32_t chunks;                           /* chunks meshed in each repetition */
    int32_t at_a_time;                        /* chunks in one call; 1 as in the thesis, or `chunks` */
    bench_figures stage[BENCH_VOXEL_STAGES];  /* microseconds per chunk over the repetitions */
    bench_figures total;                      /* sum of the stages, microseconds per chunk */
    /* elapsed time of the same call without clocks between the stages, microseconds per chunk; with several
       threads, less than `total` */
    bench_figures elapsed;
    double faces_per_chunk;
} bench_voxel_stages;

/*
 * Meshes every chunk of the cubic grid with a backend: "ref" (scalar), "cpu" (bits, threads), "cl..." (OpenCL).
 * If one is true, each call meshes one chunk, as in the thesis; otherwise one call meshes all of them.
 * repeat: number of repetitions, at least 1.
 */
ost_status bench_voxel_mesh(const bench_voxel_model *model, const char *backend, bool one, int repeat,
                            bench_voxel_stages *out, ost_error *err);

/* ------------------------------------------------- frames (Figs. 3.13, 3.14, 3.16) */

typedef struct bench_voxel_frame {
    int32_t chunks;        /* chunks drawn */
    bench_figures ms;      /* milliseconds per frame, each ended by glFinish */
    uint64_t vertices;     /* vertices passed to OpenGL in a frame */
} bench_voxel_frame;

typedef struct bench_voxel_frames {
    char reason[BENCH_TEXT]; /* reason why nothing was measured; "" if measured */
    char opengl[BENCH_TEXT]; /* driver and version */
    bool software;           /* true if the processor executes OpenGL */
    int32_t count;
    bench_voxel_frame *frame; /* owned; `count` entries */
} bench_voxel_frames;
void bench_voxel_frames_free(bench_voxel_frames *frames);

/*
 * Measures idle frames: nothing changes between frames. counts: numbers of chunks to draw, each from 1 to
 * bench_voxel_chunks; the first chunks in the order of the grid are drawn. repeat: frames for each number.
 */
ost_status bench_voxel_idle(const bench_voxel_model *model, bench_voxel_method method, const int32_t *counts, int count,
                            int repeat, bench_voxel_frames *out, ost_error *err);

/* --------------------------------------------------------- removal (section 3.3.3) */

typedef struct bench_voxel_cut {
    char reason[BENCH_TEXT]; /* reason why nothing was measured; "" if measured */
    char opengl[BENCH_TEXT];
    int32_t frames;
    bench_figures ms;        /* milliseconds per frame: update of the surface, meshing, drawing, glFinish */
    bench_figures idle_ms;   /* the same frames, drawn again without a change */
    double changed_chunks;   /* chunks in which voxels were removed, mean per frame */
    double meshed_chunks;    /* chunks whose mesh was generated again, mean per frame; 0 for GL_POINTs */
    double mesh_ms, copy_ms; /* parts of a frame: meshing, and copying the meshes to OpenGL; means */
    double update_ms;        /* part of a frame: lists and appearance of surface voxels, which all methods need */
    uint64_t uploaded;       /* bytes copied to OpenGL, mean per frame */
} bench_voxel_cut;

/*
 * Measures frames while a ball with the radius of the thesis' reamer head (18 mm at the voxel size of the
 * scapula: 38 voxels) moves into the model, a quarter of a voxel per frame. At a smaller scale of the model,
 * the ball is smaller too. The model is restored at the end. mesher: backend that meshes the chunks, for
 * example "cpu"; used only by BENCH_VOXEL_MESH.
 */
ost_status bench_voxel_removal(bench_voxel_model *model, bench_voxel_method method, const char *mesher, int frames,
                               bench_voxel_cut *out, ost_error *err);

#endif
