/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The computations of thesis_plugin.c, in C (engine_c.c) or on an OpenCL device
 * (engine_cl.c).  Arrays are in host memory.  A function that fails writes one
 * line to *error and returns an ost_plugin_status.
 */
#ifndef THESIS_ENGINE_H
#define THESIS_ENGINE_H

#include <osteon/plugin.h>

#ifndef THESIS_TYPES
#define THESIS_TYPES
/* These structs have the same layouts as the structs in thesis_f32.cl, where their fields are documented. */
typedef struct thesis_axis {
    float minimum, size;
    int dims;
} thesis_axis;

typedef struct thesis_rect {
    thesis_axis axis[3];
} thesis_rect;

typedef struct thesis_boxes {
    float matrix[12];
    float bone[3], tool[3];
    float bone_voxel, tool_voxel;
    int bone_dims[3], tool_dims[3];
    int chunk_size;
    int chunk_lo[3], chunk_hi[3];
} thesis_boxes;

typedef struct thesis_grid {
    float minimum[3];
    float size;
    int dims[3];
    int parity;
    int triangles;
} thesis_grid;
#endif

typedef struct engine engine;

extern const char engine_name[], engine_about[];

int32_t engine_open(const char *options, engine **out, ost_plugin_error *error);
void engine_close(engine *e);

/*
 * Computes the voxel of each sample. `samples` contains four floats for each sample: x, y, z and density.
 * For each sample, stores in index[] the index of the voxel in the grid *rect, or -1 if the index is
 * outside the grid.
 */
int32_t engine_index(engine *e, const float first_last_size[9], const float *samples, size_t count, thesis_rect *rect,
                     int *index, ost_plugin_error *error);
int32_t engine_layers(engine *e, float cubic, float rect, size_t count, int *layer, ost_plugin_error *error);
int32_t engine_minimum(engine *e, const float least[3], float size, float minimum[3], ost_plugin_error *error);
/* Sets the voxels inside the mesh to the value `mark`. `corners` contains nine floats per triangle. */
int32_t engine_solid(engine *e, const thesis_grid *grid, const float *corners, int mark, uint8_t *solid,
                     ost_plugin_error *error);
/*
 * Processes one pose. Stores the chunk range in *x and adds the pose's marks to `marks`, an array
 * with one element per bone voxel.
 */
int32_t engine_pose(engine *e, thesis_boxes *x, const uint8_t *tool, uint8_t *marks, ost_plugin_error *error);

/* Writes the text of the error and returns `status`. */
#if defined __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
int32_t plugin_fail(ost_plugin_error *error, int32_t status, const char *format, ...);
/*
 * Copies the value of the option key to a buffer; copies "" if the option is absent. Returns
 * false if the buffer is too small.
 */
int option(const char *options, const char *key, char *value, size_t size);

#endif
