/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the volume and the open edges of a mesh, for reports only. */
#include "core/mesh_check.h"

#include <stdlib.h>
#include <string.h>

/*
 * Adds the signed volumes of the tetrahedra between the first vertex and each triangle, in doubles. The error
 * is about 1e-12 of the volume of the bounding box.
 */
double ost_mesh_volume_mm3(const ost_mesh *mesh)
{
    if (mesh->triangle_count == 0)
        return 0.0;
    ost_pm3 o = mesh->vertices[mesh->triangles[0][0]];
    double six = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double p[3][3];
        for (int c = 0; c < 3; c++) {
            ost_pm3 v = mesh->vertices[mesh->triangles[t][c]];
            p[c][0] = ost_pm_to_mm(v.x - o.x);
            p[c][1] = ost_pm_to_mm(v.y - o.y);
            p[c][2] = ost_pm_to_mm(v.z - o.z);
        }
        six += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return six / 6.0;
}

/* ------------------------------------------------------------ open edges */

/* A directed edge between two welded vertices, with low < high. `sign` is +1 if the edge is directed from low to high,
   otherwise -1. */
typedef struct edge {
    uint32_t low, high;
    int32_t sign;
} edge;

typedef struct keyed_vertex {
    ost_pm3 p;
    uint32_t index;
} keyed_vertex;

static int compare_vertices(const void *a, const void *b)
{
    const ost_pm3 *p = &((const keyed_vertex *)a)->p;
    const ost_pm3 *q = &((const keyed_vertex *)b)->p;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    return p->z < q->z ? -1 : p->z > q->z;
}

static int compare_edges(const void *a, const void *b)
{
    const edge *e = a;
    const edge *f = b;
    if (e->low != f->low)
        return e->low < f->low ? -1 : 1;
    return e->high < f->high ? -1 : e->high > f->high;
}

/* Sets weld[i] to a number that is the same for all vertices at the position of vertex i. */
static void weld_vertices(const ost_mesh *mesh, keyed_vertex *keyed, uint32_t *weld)
{
    for (size_t i = 0; i < mesh->vertex_count; i++)
        keyed[i] = (keyed_vertex){mesh->vertices[i], (uint32_t)i};
    qsort(keyed, mesh->vertex_count, sizeof *keyed, compare_vertices);
    uint32_t number = 0;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        if (i > 0 && compare_vertices(&keyed[i - 1], &keyed[i]) != 0)
            number++;
        weld[keyed[i].index] = number;
    }
}

static size_t collect_edges(const ost_mesh *mesh, const uint32_t *weld, edge *edges)
{
    size_t count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            uint32_t a = weld[mesh->triangles[t][c]];
            uint32_t b = weld[mesh->triangles[t][(c + 1) % 3]];
            if (a != b)
                edges[count++] = a < b ? (edge){a, b, 1} : (edge){b, a, -1};
        }
    return count;
}

/*
 * Counts the open edges. Equal edges are adjacent in the array. An edge is not open if it occurs exactly twice, with
 * opposite signs.
 */
static size_t count_open(const edge *edges, size_t count)
{
    size_t open = 0;
    for (size_t i = 0; i < count;) {
        size_t j = i;
        int64_t sum = 0;
        for (; j < count && compare_edges(&edges[i], &edges[j]) == 0; j++)
            sum += edges[j].sign;
        open += j - i != 2 || sum != 0;
        i = j;
    }
    return open;
}

ost_status ost_mesh_open_edges(const ost_mesh *mesh, size_t *open_edges, ost_error *err)
{
    ost_status status = ost_mesh_check_indices(mesh, err);
    if (status != OST_OK)
        return status;
    keyed_vertex *keyed = malloc((mesh->vertex_count + 1) * sizeof *keyed);
    uint32_t *weld = malloc((mesh->vertex_count + 1) * sizeof *weld);
    edge *edges = malloc((3 * mesh->triangle_count + 1) * sizeof *edges);
    if (!keyed || !weld || !edges) {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the edges of %zu triangles", mesh->triangle_count);
        goto cleanup;
    }
    weld_vertices(mesh, keyed, weld);
    size_t count = collect_edges(mesh, weld, edges);
    qsort(edges, count, sizeof *edges, compare_edges);
    *open_edges = count_open(edges, count);
cleanup:
    free(keyed);
    free(weld);
    free(edges);
    return status;
}
