/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Joins equal vertices. An STL file repeats a vertex for each triangle that uses it. Vertices are equal if their
 * coordinates in picometres are equal; no vertex is moved. Equal vertices are found with a hash table of vertex
 * numbers, which uses linear probing and is at most half full.
 */
#include <stdlib.h>
#include <string.h>

#include "io/mesh/input.h"

static uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static uint64_t hash(const ost_pm3 *p)
{
    return mix(mix(mix((uint64_t)p->x) + (uint64_t)p->y) + (uint64_t)p->z);
}

static bool same(const ost_pm3 *a, const ost_pm3 *b)
{
    return a->x == b->x && a->y == b->y && a->z == b->z;
}

ost_status ost_mesh_weld(ost_mesh *mesh, ost_error *err)
{
    size_t slots = 16;
    while (slots < 2 * mesh->vertex_count)
        slots *= 2;
    uint32_t *table = malloc(slots * sizeof *table);
    uint32_t *renumber = malloc((mesh->vertex_count + 1) * sizeof *renumber);
    if (!table || !renumber) {
        free(table);
        free(renumber);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to join %zu vertices", mesh->vertex_count);
    }
    memset(table, 0xff, slots * sizeof *table);
    uint32_t kept = 0;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const ost_pm3 p = mesh->vertices[i];
        size_t slot = hash(&p) & (slots - 1);
        while (table[slot] != UINT32_MAX && !same(&mesh->vertices[table[slot]], &p))
            slot = (slot + 1) & (slots - 1);
        if (table[slot] == UINT32_MAX) {
            table[slot] = kept;
            mesh->vertices[kept++] = p;
        }
        renumber[i] = table[slot];
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++)
            mesh->triangles[t][c] = renumber[mesh->triangles[t][c]];
    mesh->vertex_count = kept;
    ost_pm3 *fewer = realloc(mesh->vertices, (kept ? kept : 1) * sizeof *fewer);
    if (fewer)
        mesh->vertices = fewer;
    free(table);
    free(renumber);
    return OST_OK;
}
