/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxelization (AR-VOX) on the device, where a work item processes one triangle. For
 * devices that are CPUs, see voxelize_tiles.c.
 *
 *   for each range of slices whose steps fit in the buffer
 *     for the noncutting mesh, then for the cutting mesh
 *       steps   +1 and -1 of every triangle, by integer atomics
 *       fill    a running sum along each row
 *     count     solid and cutting voxels
 */
#include "cl/objects.h"

#include <stdlib.h>

/* STEPS_BYTES is the maximum size of the buffer of steps. ITEMS is a number of work items that is sufficient to keep
   a device busy. */
enum { STEPS_BYTES = 1 << 28, ITEMS = 1 << 14 };

typedef struct mesh_buffers {
    const ost_snapped_mesh *mesh; /* NULL if the tool has no mesh of this class (cutting or non-cutting) */
    uint8_t tool_class;
    cl_mem vertices, triangles;
} mesh_buffers;

static ost_status mesh_upload(cl_backend *b, mesh_buffers *m, ost_error *err)
{
    if (!m->mesh)
        return OST_OK;
    ost_status status = ost_cl_buffer(b, m->mesh->vertex_count * sizeof m->mesh->vertices[0], m->mesh->vertices,
                                      "vertices", &m->vertices, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, m->mesh->triangle_count * sizeof m->mesh->triangles[0], m->mesh->triangles,
                               "triangles", &m->triangles, err);
    return status;
}

static ost_status add_mesh(cl_backend *b, const mesh_buffers *m, ost_cl_vox vox, cl_mem steps, cl_mem classes,
                           cl_mem leaks, ost_error *err)
{
    if (!m->mesh)
        return OST_OK;
    const size_t slices = (size_t)(vox.k1 - vox.k0), triangles = m->mesh->triangle_count;
    size_t bands = triangles ? ITEMS / triangles + 1 : 1;
    bands = bands < slices && b->turns == OST_CL_TURNS ? bands : slices;
    vox.triangles = (uint32_t)triangles;
    vox.bands = (uint32_t)bands;
    vox.tool_class = m->tool_class;
    cl_mem vox_buffer = NULL;
    ost_status status = ost_cl_buffer(b, sizeof vox, &vox, "voxelization", &vox_buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_vox_steps, triangles, bands, 1, err, OST_CL_ARG(vox_buffer),
                               OST_CL_ARG(m->vertices), OST_CL_ARG(m->triangles), OST_CL_ARG(steps));
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_vox_fill, (size_t)vox.dims[1], slices, 1, err, OST_CL_ARG(vox_buffer),
                               OST_CL_ARG(steps), OST_CL_ARG(classes), OST_CL_ARG(leaks));
    ost_cl_buffer_free(b, &vox_buffer);
    return status;
}

static ost_status count_slices(cl_backend *b, const ost_cl_vox *vox, cl_mem classes, cl_mem counts, ost_error *err)
{
    cl_mem vox_buffer = NULL;
    ost_status status = ost_cl_buffer(b, sizeof *vox, vox, "voxelization", &vox_buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_vox_count, (size_t)vox->dims[1], (size_t)(vox->k1 - vox->k0), 1, err,
                               OST_CL_ARG(vox_buffer), OST_CL_ARG(classes), OST_CL_ARG(counts));
    ost_cl_buffer_free(b, &vox_buffer);
    return status;
}

/* Returns the number of slices whose steps fit in the buffer of steps. The result is at least 1. */
static int32_t step_slices(const cl_backend *b, ost_dims dims)
{
    const size_t slice = (size_t)dims.y * ((size_t)dims.x + 1) * sizeof(int32_t);
    const size_t limit = ost_cl_staging(b, STEPS_BYTES),
                 most = b->device.max_buffer < limit ? b->device.max_buffer : limit;
    const size_t fit = most / slice;
    return fit < 1 ? 1 : fit < (size_t)dims.z ? (int32_t)fit : dims.z;
}

ost_status ost_cl_voxelize(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                           ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err)
{
    cl_backend *b = (cl_backend *)backend;
    b->entered[noncutting ? OST_CL_PATH_WITH_NONCUTTING : OST_CL_PATH_NO_NONCUTTING]++;
    if (b->cpu_set)
        return ost_cl_voxelize_tiles(backend, cutting, noncutting, rule, report, out, err);
    const ost_dims dims = cutting->grid.dims;
    const int32_t step = step_slices(b, dims);
    b->entered[OST_CL_PATH_STEPS_IN_PARTS] += step < dims.z;
    mesh_buffers meshes[2] = {{.mesh = noncutting, .tool_class = OST_TOOL_NONCUTTING},
                              {.mesh = cutting, .tool_class = OST_TOOL_CUTTING}};
    cl_mem steps = NULL, leaks = NULL, counts = NULL;
    uint32_t leaking = 0, *count = calloc(2 * (size_t)dims.z, sizeof *count);
    cl_tool *tool = NULL;
    ost_status status = count ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for the counts of %d slices",
                                                  (int)dims.z);
    if (status == OST_OK)
        status = ost_cl_tool_create(backend, &cutting->grid, &tool, err);
    if (status == OST_OK)
        status = ost_cl_zero(b, tool->classes, 0, (size_t)ost_dims_count(dims), err);
    for (int m = 0; m < 2 && status == OST_OK; m++)
        status = mesh_upload(b, &meshes[m], err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, (size_t)step * (size_t)dims.y * ((size_t)dims.x + 1) * sizeof(int32_t),
                                    "steps of rows", &steps, err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, sizeof leaking, "leaking rows", &leaks, err);
    if (status == OST_OK)
        status = ost_cl_buffer_zero(b, 2 * (size_t)dims.z * sizeof *count, "counts", &counts, err);
    for (int32_t k = 0; k < dims.z && status == OST_OK; k += step) {
        const ost_cl_vox vox = {
            .dims = {dims.x, dims.y, dims.z},
            .fraction = cutting->fraction_bits,
            .k0 = k,
            .k1 = dims.z - k < step ? dims.z : k + step,
            .rule = (int32_t)rule,
        };
        for (int m = 0; m < 2 && status == OST_OK; m++)
            status = add_mesh(b, &meshes[m], vox, steps, tool->classes, leaks, err);
        if (status == OST_OK)
            status = count_slices(b, &vox, tool->classes, counts, err);
    }
    if (status == OST_OK)
        status = ost_cl_read(b, counts, 0, 2 * (size_t)dims.z * sizeof *count, count, err);
    if (status == OST_OK)
        status = ost_cl_read(b, leaks, 0, sizeof leaking, &leaking, err);
    if (status == OST_OK) {
        *report = (ost_voxelize_report){.leaking_rows = leaking};
        for (int32_t k = 0; k < dims.z; k++) {
            report->solid_voxels += count[2 * k];
            report->cutting_voxels += count[2 * k + 1];
        }
        tool->touches = noncutting != NULL;
        *out = &tool->base;
    } else if (tool) {
        ost_cl_tool_free(&tool->base);
    }
    for (int m = 0; m < 2; m++) {
        ost_cl_buffer_free(b, &meshes[m].vertices);
        ost_cl_buffer_free(b, &meshes[m].triangles);
    }
    ost_cl_buffer_free(b, &counts);
    ost_cl_buffer_free(b, &leaks);
    ost_cl_buffer_free(b, &steps);
    free(count);
    return status;
}
