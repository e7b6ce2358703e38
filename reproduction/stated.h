/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The numbers that the thesis states, each with the table or section that contains it. No other file contains them.
 *
 * Only values that the thesis prints as numbers are included. Values that can only be read from its plots
 * (Figures 3.2 and 3.8 to 3.16) are not included.
 *
 * All times were measured on an Intel Core i5 8600 with an Nvidia GTX 1070, unless stated otherwise.
 */
#ifndef OST_REPRODUCTION_STATED_H
#define OST_REPRODUCTION_STATED_H

#include <stdint.h>

/* The number of models. They are in the order of Tables 3.1 and 3.2. */
enum { STATED_MODELS = 5 };

typedef struct stated_model {
    const char *name;
    /* Table 3.1 */
    double voxel_mm[3];
    int32_t dims[3];
    double voxels, memory_mb, text_mb;
    /* Table 3.2 */
    int32_t padded[3], chunk_dims[3];
    double chunks, active_chunks, raw_mb, active_mb;
    /* Table 2.2, in ms */
    double read_ms, rect_ms, cubic_ms, chunks_ms;
} stated_model;
extern const stated_model stated_models[STATED_MODELS];

/* Tables 3.3 and 3.4: the static event with chunks of 16^3, 32^3 and 64^3 voxels. */
typedef struct stated_event {
    int chunk;
    double chunks, chunk_ms, event_ms;
} stated_event;
extern const stated_event stated_reamer[3], stated_peg[3];

/*
 * Table 3.5: the reamer with chunks of 32^3 and tool voxels of three sizes. In the printed table, the rows for the time
 * per chunk and the total time are exchanged (0.982 ms per chunk, 0.0545 ms in total). Here they are in the right
 * order, which follows from the 18 chunks and from Table 3.3.
 */
typedef struct stated_tool_voxel {
    double voxel_mm, chunks, chunk_ms, event_ms, voxels;
} stated_tool_voxel;
extern const stated_tool_voxel stated_tool_voxels[3];

/* Table 2.1: times in ms to voxelize the tools, and the time of the additional pass for the reamer. */
#define STATED_VOXELIZE_REAMER_MS 0.753728
#define STATED_VOXELIZE_REAMER_PASS_MS 0.442368
#define STATED_VOXELIZE_PEG_MS 0.559584

/* Section 3.2.3: the times of the reamer's event with the chunk system and with Reza's method, for grids of 64^3
   voxels. */
#define STATED_CHUNKS_64_MS 0.44
#define STATED_REZA_64_MS 0.19
/* Section 3.2.3, Figure 3.10: for grids of 1024^3 voxels, the chunk system is faster for events of up to 12 chunks. */
#define STATED_CROSSING_CHUNKS 12

/* Table 3.7: the memory of the scapula as a triangle mesh (with chunks of 0.47 x 0.47 x 1 mm voxels) and as points. */
typedef struct stated_rendering {
    double chunks, active_chunks, voxel_mb, mesh_mb, total_mb;
} stated_rendering;
extern const stated_rendering stated_as_mesh, stated_as_points;

/* Table 3.8: times in ms of the stages that generate the mesh of a chunk. */
typedef struct stated_stage {
    const char *name;
    double ms;
} stated_stage;
enum { STATED_STAGES = 6 };
extern const stated_stage stated_mesh_stages[STATED_STAGES];

/* Table 3.6: the computers. */
typedef struct stated_computer {
    const char *cpu, *cpu_ghz, *gpu, *gpu_mhz, *cores, *vram_gb, *ram_gb;
} stated_computer;
enum { STATED_COMPUTERS = 4 };
extern const stated_computer stated_computers[STATED_COMPUTERS];

#endif
