/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/smooth_mesh.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/mesh_check.h"
#include "core/vector.h"

/* Cosine of 40 degrees. */
#define CREASE 0.76604444311897803
/* Maximum number of triangles at a vertex for which normals are averaged. If more triangles meet at a vertex, each
   corner gets the normal of its own triangle. This limits the computing time. */
enum { MEETING_MAX = 1024 };
#define UNUSED UINT32_MAX

/* The normals of a part's triangles, and the triangles that meet at each position. */
typedef struct part {
    const ost_mesh *mesh;
    double (*normal)[3]; /* owned; unit normals; 0 for a zero-area triangle */
    double *area;        /* owned; twice the area of each triangle */
    /* owned; for each vertex, the number of its position; vertices at the same position have the same number */
    uint32_t *place;
    uint32_t *first;     /* owned; the triangles at position p are meets[first[p]] to meets[first[p + 1] - 1] */
    uint32_t *meets;     /* owned */
    uint32_t *number;    /* owned; for each position, its index in the smooth mesh, or UNUSED */
} part;

static void part_free(part *p)
{
    free(p->normal);
    free(p->area);
    free(p->place);
    free(p->first);
    free(p->meets);
    free(p->number);
}

typedef struct numbered {
    ost_pm3 at;
    uint32_t vertex;
} numbered;

static int by_position(const void *a, const void *b)
{
    const ost_pm3 x = ((const numbered *)a)->at, y = ((const numbered *)b)->at;
    return x.x != y.x ? (x.x > y.x) - (x.x < y.x) : x.y != y.y ? (x.y > y.y) - (x.y < y.y) : (x.z > y.z) - (x.z < y.z);
}

/* Numbers the positions of the vertices. Returns false if memory is exhausted. */
static bool number_positions(part *p)
{
    const size_t count = p->mesh->vertex_count;
    numbered *sorted = malloc((count + 1) * sizeof *sorted);
    if (!sorted)
        return false;
    for (size_t i = 0; i < count; i++)
        sorted[i] = (numbered){p->mesh->vertices[i], (uint32_t)i};
    qsort(sorted, count, sizeof *sorted, by_position);
    uint32_t number = 0;
    for (size_t i = 0; i < count; i++) {
        number += i > 0 && by_position(&sorted[i - 1], &sorted[i]) != 0;
        p->place[sorted[i].vertex] = number;
    }
    free(sorted);
    return true;
}

/* Lists the triangles that meet at each position, in ascending order. */
static void list_meetings(part *p)
{
    const ost_mesh *m = p->mesh;
    for (size_t t = 0; t < m->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            p->first[p->place[m->triangles[t][c]] + 1]++;
    for (size_t i = 0; i < m->vertex_count; i++)
        p->first[i + 1] += p->first[i];
    for (size_t t = m->triangle_count; t-- > 0;)
        for (int c = 0; c < 3; c++)
            p->meets[--p->first[p->place[m->triangles[t][c]] + 1]] = (uint32_t)t;
    /* The list of position p now begins at first[p + 1]; it must begin at first[p]. */
    memmove(p->first, p->first + 1, m->vertex_count * sizeof *p->first);
    p->first[m->vertex_count] = (uint32_t)(3 * m->triangle_count);
}

static void find_normals(part *p)
{
    const ost_mesh *m = p->mesh;
    for (size_t t = 0; t < m->triangle_count; t++) {
        const ost_pm3 *v[3] = {&m->vertices[m->triangles[t][0]], &m->vertices[m->triangles[t][1]],
                               &m->vertices[m->triangles[t][2]]};
        double side[2][3];
        for (int s = 0; s < 2; s++) {
            side[s][0] = (double)(v[s + 1]->x - v[0]->x);
            side[s][1] = (double)(v[s + 1]->y - v[0]->y);
            side[s][2] = (double)(v[s + 1]->z - v[0]->z);
        }
        ost_vector_cross(side[0], side[1], p->normal[t]);
        p->area[t] = sqrt(ost_vector_dot(p->normal[t], p->normal[t]));
        for (int a = 0; a < 3; a++)
            p->normal[t][a] = p->area[t] > 0 ? p->normal[t][a] / p->area[t] : 0;
    }
}

static ost_status part_make(const ost_mesh *mesh, part *p, ost_error *err)
{
    *p = (part){.mesh = mesh};
    ost_status status = ost_mesh_check_indices(mesh, err);
    if (status != OST_OK)
        return status;
    p->normal = malloc((mesh->triangle_count + 1) * sizeof *p->normal);
    p->area = malloc((mesh->triangle_count + 1) * sizeof *p->area);
    p->place = malloc((mesh->vertex_count + 1) * sizeof *p->place);
    p->first = calloc(mesh->vertex_count + 2, sizeof *p->first);
    p->meets = malloc((3 * mesh->triangle_count + 1) * sizeof *p->meets);
    p->number = malloc((mesh->vertex_count + 1) * sizeof *p->number);
    if (!p->normal || !p->area || !p->place || !p->first || !p->meets || !p->number || !number_positions(p))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface of %zu triangles", mesh->triangle_count);
    find_normals(p);
    list_meetings(p);
    for (size_t i = 0; i < mesh->vertex_count; i++)
        p->number[i] = UNUSED;
    return OST_OK;
}

/* Computes the normal of a triangle at one of its corners. */
static void corner_normal(const part *p, size_t triangle, uint32_t vertex, float out[3])
{
    const double *own = p->normal[triangle];
    const uint32_t place = p->place[vertex], from = p->first[place], to = p->first[place + 1];
    double sum[3] = {own[0], own[1], own[2]};
    if (to - from <= MEETING_MAX) {
        sum[0] = sum[1] = sum[2] = 0;
        for (uint32_t i = from; i < to; i++) {
            const double *other = p->normal[p->meets[i]];
            const double weight = ost_vector_dot(own, other) >= CREASE ? p->area[p->meets[i]] : 0;
            for (int a = 0; a < 3; a++)
                sum[a] += weight * other[a];
        }
    }
    ost_vector_unit(sum, 2);
    for (int a = 0; a < 3; a++)
        out[a] = (float)sum[a];
}

/* Returns the index of a vertex's position in the smooth mesh. Appends the position on first use. */
static uint32_t position_of(const part *p, uint32_t vertex, const ost_tool_geometry *grid, ost_smooth_mesh *out)
{
    const ost_pm3 *v = &p->mesh->vertices[vertex];
    const double voxel = (double)grid->voxel;
    uint32_t *number = &p->number[p->place[vertex]];
    if (*number == UNUSED) {
        float *at = out->position[out->positions];
        at[0] = (float)((double)(v->x - grid->corner.x) / voxel - 0.5);
        at[1] = (float)((double)(v->y - grid->corner.y) / voxel - 0.5);
        at[2] = (float)((double)(v->z - grid->corner.z) / voxel - 0.5);
        *number = (uint32_t)out->positions++;
    }
    return *number;
}

/* Appends the triangles of a part. */
static void append(const part *p, const ost_tool_geometry *grid, ost_smooth_mesh *out)
{
    const ost_mesh *m = p->mesh;
    for (size_t t = 0; t < m->triangle_count; t++) {
        if (!(p->area[t] > 0))
            continue;
        ost_smooth_triangle *to = &out->triangle[out->count];
        for (int c = 0; c < 3; c++) {
            const uint32_t number = position_of(p, m->triangles[t][c], grid, out);
            out->place[out->count][c] = number;
            memcpy(to->corner[c].at, out->position[number], sizeof to->corner[c].at);
            corner_normal(p, t, m->triangles[t][c], to->corner[c].normal);
        }
        out->count++;
    }
}

static uint64_t hash_of(const ost_smooth_mesh *mesh)
{
    uint64_t h = UINT64_C(0xcbf29ce484222325);
    const unsigned char *bytes = (const unsigned char *)mesh->triangle;
    for (size_t i = 0; i < mesh->count * sizeof *mesh->triangle; i += sizeof(uint64_t)) {
        uint64_t word; /* a triangle has 72 bytes, a multiple of the word size */
        memcpy(&word, bytes + i, sizeof word);
        h = (h ^ word) * UINT64_C(0x100000001b3);
        h ^= h >> 32;
    }
    return h;
}

/*
 * Sets *closed to false if the mesh has open edges or a negative volume. The inner side of the mesh may then be
 * visible.
 */
static ost_status check_closed(const ost_mesh *mesh, bool *closed, ost_error *err)
{
    size_t open = 0;
    ost_status status = ost_mesh_open_edges(mesh, &open, err);
    *closed = *closed && open == 0 && ost_mesh_volume_mm3(mesh) > 0;
    return status;
}

ost_status ost_smooth_mesh_make(const ost_mesh *parts, int count, const ost_tool_geometry *grid, ost_smooth_mesh *out,
                                ost_error *err)
{
    size_t triangles = 0;
    *out = (ost_smooth_mesh){.closed = true};
    for (int i = 0; i < count; i++)
        triangles += parts[i].triangle_count;
    if (triangles == 0 || triangles > OST_SMOOTH_TRIANGLES_MAX)
        return OST_OK;
    out->triangle = malloc(triangles * sizeof *out->triangle);
    out->position = malloc(3 * triangles * sizeof *out->position);
    out->place = malloc(triangles * sizeof *out->place);
    ost_status status = OST_OK;
    if (!out->triangle || !out->position || !out->place)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a surface of %zu triangles", triangles);
    for (int i = 0; i < count && status == OST_OK; i++) {
        part p;
        status = part_make(&parts[i], &p, err);
        if (status == OST_OK)
            status = check_closed(&parts[i], &out->closed, err);
        if (status == OST_OK)
            append(&p, grid, out);
        part_free(&p);
    }
    if (status == OST_OK)
        out->hash = hash_of(out);
    else
        ost_smooth_mesh_free(out);
    return status;
}

void ost_smooth_mesh_free(ost_smooth_mesh *mesh)
{
    free(mesh->triangle);
    free(mesh->position);
    free(mesh->place);
    *mesh = (ost_smooth_mesh){0};
}
