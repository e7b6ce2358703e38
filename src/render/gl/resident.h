/* SPDX-License-Identifier: Apache-2.0 */
/*
 * OpenGL's copy of a surface: the points of each block and their shades, in the forms that are drawn. The block's
 * version shows whether a copy is up to date.
 *
 *   form     contents of an element     meaning
 *   points   where, look                a surface point (points/surface.h)
 *   bricks   position, 64 voxel bits,   4^3 voxels with at least one surface voxel; the shades of the
 *            index of first shade       points are stored brick by brick
 *   voxels   density                    all voxels of a block, which are the vertices of the thesis
 *   quads    four vertices              the visible faces of a block (core/face_mesh.h), with one shade for each face
 *   mesh     corner, normal             a tool's faces as triangles
 */
#ifndef OST_RENDER_GL_RESIDENT_H
#define OST_RENDER_GL_RESIDENT_H

#include "core/face_mesh.h"
#include "render/gl/pool.h"
#include "render/points/surface.h"

typedef enum ost_gl_form { OST_GL_POINTS, OST_GL_BRICKS, OST_GL_VOXELS, OST_GL_QUADS, OST_GL_FORMS } ost_gl_form;

typedef struct ost_gl_run {
    uint64_t version;
    uint32_t first, count, granules;
    /* first element of the run of shades, and its number of granules; used only for bricks and quads */
    uint32_t shade_first, shade_granules;
    uint64_t listed;      /* only for quads: value of block->listed when they were made */
    uint64_t bricks[8];   /* set of the bricks of 4^3 voxels that contain a point: bit x | y << 3 of word z */
    uint64_t cells;       /* set of the cells of 8^3 voxels that contain a point: bit x | y << 2 | z << 4 */
    uint64_t hidden;      /* set of the cells that were hidden in the last search (hide.h), encoded like `cells` */
} ost_gl_run;

typedef struct ost_gl_resident {
    /* surface of this entry; NULL if free; only compared, never dereferenced */
    const ost_surface *surface;
    uint64_t last;              /* number of the last frame that used this entry */
    /* owned; for each form, an array of runs, indexed by slot */
    ost_gl_run *run[OST_GL_FORMS];
    int32_t runs[OST_GL_FORMS];
    int pause;                  /* number of frames until the next search for hidden cells (hide.c) */
    GLuint mesh;
    uint64_t mesh_version;      /* sum of the versions of the surface's blocks when the mesh was uploaded */
    uint32_t mesh_vertices;
} ost_gl_resident;

enum { OST_GL_RESIDENTS = 24, OST_GL_QUAD_BITS = 6 /* a granule has 2^OST_GL_QUAD_BITS quads */ };

typedef struct ost_gl_store {
    ost_gl_pool points, bricks, shades, voxels, quads;
    ost_backend *mesher;  /* borrowed; backend that makes the quads; NULL if not set */
    ost_face_mesh mesh;   /* owned; most recent meshes */
    ost_face_cluster *clusters; /* owned; blocks to mesh; cluster_capacity entries */
    int32_t *slots, cluster_capacity; /* owned; slots of these blocks; cluster_capacity entries */
    uint32_t meshed;      /* number of blocks meshed since the start of the frame */
    int64_t mesh_ns, copy_ns; /* time in ns spent on meshing and on copying since the start of the frame */
    ost_gl_resident resident[OST_GL_RESIDENTS];
    uint64_t frame;
    uint64_t uploaded; /* number of bytes uploaded since the start of the frame */
} ost_gl_store;

/* Returns the cell that contains brick x | y << 3 | z << 6 of a block. */
static inline uint32_t ost_gl_cell_of_brick(uint32_t brick)
{
    return (brick >> 1 & 3) | (brick >> 2 & 12) | (brick >> 3 & 48);
}

void ost_gl_store_init(ost_gl_store *store);
void ost_gl_store_free(ost_gl_store *store);
/* Frees only memory, without calling OpenGL. */
void ost_gl_store_abandon(ost_gl_store *store);
ost_gl_pool *ost_gl_store_pool(ost_gl_store *store, ost_gl_form form);

/* Uploads the current state of the surface in the given form. OpenGL must have completed the previous frame. */
ost_status ost_gl_store_bring(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                              ost_gl_form form, ost_gl_resident **out, ost_error *err);
/* Meshes the blocks whose visible faces have changed, and uploads the changed quads and shades. */
ost_status ost_gl_store_bring_quads(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                                    ost_gl_resident **out, ost_error *err);
ost_status ost_gl_store_bring_mesh(ost_gl_context *context, ost_gl_store *store, const ost_surface *surface,
                                   ost_gl_resident **out, ost_error *err);

#endif
