/* SPDX-License-Identifier: Apache-2.0 */
/* Computes points on a circle, in units of 2^-60, by the power series, and builds the skin of rings (tool_shape.h). */
#include "phantom/tool_shape.h"

#include <assert.h>

#include "core/conditions.h"
#include "core/integer.h"

/* pi / 4 * 2^60, rounded half to even */
#define QUARTER_PI INT64_C(905502432259640355)

ost_q60 ost_q60_ratio(int64_t numerator, int64_t denominator)
{
    return (ost_q60)ost_rhe_div128((ost_i128)numerator * OST_Q60_ONE, denominator);
}

int64_t ost_q60_times(int64_t a, ost_q60 b)
{
    return (int64_t)ost_rhe_div128((ost_i128)a * b, OST_Q60_ONE);
}

/*
 * Computes cos x and sin x for 0 <= x <= pi/4 from the terms t_n = t_(n-1) x / n of the power series. Each term has
 * an error of less than 2 units of 2^-60, and the 19th term is below 2^-60.
 */
static void first_eighth(ost_q60 x, ost_q60 *cosine, ost_q60 *sine)
{
    ost_q60 term = OST_Q60_ONE, sum[2] = {OST_Q60_ONE, 0};
    for (int n = 1; n < 20; n++) {
        term = ost_q60_times(term, x) / n;
        sum[n & 1] += n & 2 ? -term : term;
    }
    *cosine = sum[0];
    *sine = sum[1];
}

void ost_circle(int64_t k, int64_t n, ost_q60 *cosine, ost_q60 *sine)
{
    int64_t eighths = (k % n + n) % n * 8;
    int octant = (int)(eighths / n);
    int64_t remainder = eighths % n;
    if (octant & 1)
        /* an odd octant is a mirror image, so its angle is measured backward from the octant's end */
        remainder = n - remainder;
    ost_q60 c, s;
    first_eighth((ost_q60)ost_rhe_div128((ost_i128)QUARTER_PI * remainder, n), &c, &s);
    bool swap = octant == 1 || octant == 2 || octant == 5 || octant == 6;
    bool left = octant >= 2 && octant <= 5;
    bool below = octant >= 4;
    *cosine = swap ? s : c;
    *sine = swap ? c : s;
    if (left)
        *cosine = -*cosine;
    if (below)
        *sine = -*sine;
}

int64_t ost_isqrt(unsigned __int128 n)
{
    int64_t root = 0;
    for (int64_t bit = INT64_C(1) << 62; bit; bit >>= 1) {
        int64_t next = root | bit;
        if ((unsigned __int128)next * (unsigned __int128)next <= n)
            root = next;
    }
    return root;
}

ost_status ost_skin_init(ost_skin *skin, ost_mesh *mesh, int segments, int rings, ost_pm bottom, ost_pm top,
                         ost_error *err)
{
    assert(segments >= 3 && rings >= 1 && bottom < top);
    const uint32_t n = (uint32_t)segments, m = (uint32_t)rings;
    ost_status status = ost_mesh_init(mesh, (size_t)n * m + 2, 2 * (size_t)n * m, err);
    if (status != OST_OK)
        return status;
    *skin = (ost_skin){.segments = segments, .rings = rings, .mesh = mesh};
    const uint32_t upper = n * m + 1;
    mesh->vertices[0] = (ost_pm3){0, 0, bottom};
    mesh->vertices[upper] = (ost_pm3){0, 0, top};

    uint32_t(*t)[3] = mesh->triangles;
    for (uint32_t k = 0; k < n; k++) {
        const uint32_t next = (k + 1) % n;
        const uint32_t corners[2][3] = {{0, 1 + next, 1 + k}, {upper, 1 + (m - 1) * n + k, 1 + (m - 1) * n + next}};
        for (int i = 0; i < 2; i++, t++)
            for (int c = 0; c < 3; c++)
                (*t)[c] = corners[i][c];
    }
    for (uint32_t r = 0; r + 1 < m; r++)
        for (uint32_t k = 0; k < n; k++) {
            const uint32_t a = 1 + r * n + k, b = 1 + r * n + (k + 1) % n;
            const uint32_t corners[2][3] = {{a, b, b + n}, {a, b + n, a + n}};
            for (int i = 0; i < 2; i++, t++)
                for (int c = 0; c < 3; c++)
                    (*t)[c] = corners[i][c];
        }
    return OST_OK;
}

ost_pm3 *ost_skin_ring(ost_skin *skin)
{
    assert(skin->filled < skin->rings);
    return skin->mesh->vertices + 1 + (size_t)skin->filled++ * (size_t)skin->segments;
}

void ost_skin_circle(ost_skin *skin, ost_pm radius, ost_pm z)
{
    ost_pm3 *ring = ost_skin_ring(skin);
    for (int k = 0; k < skin->segments; k++) {
        ost_q60 c, s;
        ost_circle(k, skin->segments, &c, &s);
        ring[k] = (ost_pm3){ost_q60_times(radius, c), ost_q60_times(radius, s), z};
    }
}
