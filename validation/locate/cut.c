/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/cut.h"

#include <stdlib.h>

#include "core/conditions.h"
#include "core/integer.h"

static bool cut_keeps(const cut_list *list, size_t i)
{
    if (!list->some)
        return true;
    for (int r = 0; r < list->count; r++)
        if (i >= list->range[r][0] && i < list->range[r][1])
            return true;
    return false;
}

static void drop_ct(scene *s)
{
    if (!s->lent)
        free(s->samples);
    s->samples = NULL;
    s->lent = false;
    s->sample_count = 0;
}

static ost_status cut_ct(const scene_cut *cut, scene *s, ost_error *err)
{
    const int32_t n[3] = {s->rect.dims.x, s->rect.dims.y, s->rect.dims.z};
    int32_t lo[3] = {0, 0, 0}, hi[3] = {n[0], n[1], n[2]};
    for (int a = 0; a < 3 && cut->cropped; a++) {
        lo[a] = cut->lo[a];
        hi[a] = cut->hi[a] < n[a] ? cut->hi[a] : n[a];
        if (lo[a] < 0 || lo[a] >= hi[a])
            return ost_fail(err, OST_ERR_INPUT, "crop: nothing of the grid's %d voxels on axis %d lies in %d..%d", n[a],
                            a, cut->lo[a], cut->hi[a]);
    }
    const ost_geometry g = s->rect;
    size_t kept = 0, capacity = s->sample_count;
    ost_sample *to = s->samples;
    if (s->lent && !(to = malloc((capacity ? capacity : 1) * sizeof *to)))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu samples", capacity);
    for (size_t i = 0; i < s->sample_count; i++) {
        const ost_sample *one = &s->samples[i];
        const int64_t at[3] = {ost_rhe_div(one->x - g.origin.x, g.spacing.x),
                               ost_rhe_div(one->y - g.origin.y, g.spacing.y),
                               ost_rhe_div(one->z - g.origin.z, g.spacing.z)};
        bool in = cut_keeps(&cut->samples, i);
        for (int a = 0; a < 3; a++)
            in &= at[a] >= lo[a] && at[a] < hi[a];
        if (in)
            to[kept++] = *one;
    }
    s->samples = to;
    s->lent = false;
    for (size_t i = 0; i < kept; i++)
        s->samples[i].line = (uint32_t)(i % s->batch);
    s->sample_count = kept;
    s->rect.dims = (ost_dims){hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
    s->rect.origin = (ost_pm3){g.origin.x + lo[0] * g.spacing.x, g.origin.y + lo[1] * g.spacing.y,
                               g.origin.z + lo[2] * g.spacing.z};
    return kept ? OST_OK : ost_fail(err, OST_ERR_INPUT, "no sample is left");
}

static void cut_mesh(const cut_list *list, ost_snapped_mesh *m)
{
    size_t kept = 0;
    for (size_t t = 0; t < m->triangle_count; t++)
        if (cut_keeps(list, t)) {
            for (int v = 0; v < 3; v++)
                m->triangles[kept][v] = m->triangles[t][v];
            kept++;
        }
    m->triangle_count = kept;
}

static void drop_raw(scene_tool *tool)
{
    ost_mesh_free(&tool->raw[0]);
    ost_mesh_free(&tool->raw[1]);
    tool->raw[0] = tool->raw[1] = (ost_mesh){.vertex_count = 0};
}

ost_status scene_cut_apply(const scene_cut *cut, scene *s, ost_error *err)
{
    int32_t now[SCENE_TOOLS_MAX];
    int tools = 0;
    size_t ticks = 0;
    ost_status status = OST_OK;
    const bool has_bone = s->sample_count > 0;
    if (cut->no_ct)
        drop_ct(s);
    else if (s->sample_count)
        status = cut_ct(cut, s, err);
    if (cut->no_collide)
        s->collide_every = 0;
    for (int i = 0; i < s->tool_count; i++) {
        now[i] = -1;
        if (cut->no_tools >> i & 1) {
            scene_tool_free(&s->tools[i]);
            continue;
        }
        /* The indices in a cut refer to snapped triangles and not to the meshes before snapping, so these
           meshes are removed. */
        if (cut->triangles[i][0].some || cut->triangles[i][1].some)
            drop_raw(&s->tools[i]);
        cut_mesh(&cut->triangles[i][0], &s->tools[i].cutting);
        cut_mesh(&cut->triangles[i][1], &s->tools[i].noncutting);
        const scene_tool one = s->tools[i];
        s->tools[i] = (scene_tool){.name = ""};
        s->tools[tools] = one;
        now[i] = tools++;
    }
    for (size_t i = 0; i < s->path.count; i++) {
        ost_tick t = s->path.ticks[i];
        if (!cut_keeps(&cut->ticks, i) || t.tool < 0 || t.tool >= s->tool_count || now[t.tool] < 0)
            continue;
        t.tool = now[t.tool];
        s->path.ticks[ticks++] = t;
    }
    for (int i = tools; i < s->tool_count; i++)
        s->tools[i] = (scene_tool){.name = ""};
    s->tool_count = tools;
    /* The poses of the handle do not correspond to ticks, so their path cannot be shortened and is removed. */
    if (ticks != s->path.count || cut->no_tools) {
        ost_path_free(&s->handle_path);
        s->handle_path = (ost_path){.count = 0};
    }
    s->path.count = ticks;
    if (has_bone && !s->sample_count)
        s->path.count = 0; /* Without a bone, no tick can run. */
    return status;
}
