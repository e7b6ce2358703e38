/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A plugin for tests that wraps the library's reference backend. The results through the plugin interface
 * must equal those without the interface. With an option, the plugin misbehaves.
 *
 *   plugin:mirror.so              the reference
 *   plugin:mirror.so,break=WHAT   misbehaves; WHAT is an argument of broken() below
 */
#include <osteon/osteon.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct ost_plugin_instance {
    ost_backend *ref;
    const ost_plugin_host *host;
    char broken[24];
    int events; /* number of removals so far */
};

static ost_plugin_instance *current; /* a single instance, which is sufficient for tests */

static int broken(const char *what)
{
    return current && strcmp(current->broken, what) == 0;
}

static int32_t put_error(ost_status status, const ost_error *err, ost_plugin_error *error)
{
    if (status == OST_OK)
        return OST_PLUGIN_OK;
    snprintf(error->text, error->text_size, "%s", err->text);
    return status == OST_ERR_USAGE ? OST_PLUGIN_USAGE : status == OST_ERR_RANGE ? OST_PLUGIN_RANGE : OST_PLUGIN_FAILED;
}

static int32_t m_open(const char *options, const ost_plugin_host *host, ost_plugin_instance **out,
                      ost_plugin_error *error)
{
    ost_error err = {0};
    ost_plugin_instance *self = calloc(1, sizeof *self);
    if (!self)
        return OST_PLUGIN_MEMORY;
    if (strncmp(options, "break=", 6) == 0)
        snprintf(self->broken, sizeof self->broken, "%.20s", options + 6);
    self->host = host;
    current = self;
    if (broken("open"))
        raise(SIGSEGV);
    if (broken("options")) {
        /* The text has no terminating NUL. The host must not read beyond the buffer. */
        memset(error->text, 'x', error->text_size);
        free(self);
        current = NULL;
        return OST_PLUGIN_USAGE;
    }
    const int32_t status = put_error(ost_backend_open("ref", &self->ref, &err), &err, error);
    if (status == OST_PLUGIN_OK && !broken("nothing")) {
        *out = self;
        return status;
    }
    if (status == OST_PLUGIN_OK)
        ost_backend_close(self->ref);
    free(self);
    current = NULL;
    return status;
}

static void m_close(ost_plugin_instance *self)
{
    ost_backend_close(self->ref);
    free(self);
    current = NULL;
}

static int32_t m_finish(ost_plugin_instance *self, ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_backend_finish(self->ref, &err), &err, error);
}

/* Objects of the plugin interface are the library's own objects, cast to the plugin's types. */
static ost_geometry geometry_of(const ost_plugin_geometry *g)
{
    return (ost_geometry){{g->dims[0], g->dims[1], g->dims[2]},
                          {g->spacing_pm[0], g->spacing_pm[1], g->spacing_pm[2]},
                          {g->origin_pm[0], g->origin_pm[1], g->origin_pm[2]}};
}

static int32_t m_grid_create(ost_plugin_instance *self, const ost_plugin_geometry *geometry, ost_plugin_grid **out,
                             ost_plugin_error *error)
{
    ost_error err = {0};
    const ost_geometry g = geometry_of(geometry);
    return put_error(ost_grid_create(self->ref, &g, (ost_grid **)out, &err), &err, error);
}

static void m_grid_free(ost_plugin_grid *grid)
{
    ost_grid_free((ost_grid *)grid);
}

static int32_t m_grid_upload(ost_plugin_grid *grid, int32_t z0, int32_t count, const int16_t *voxels,
                             ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_grid_upload((ost_grid *)grid, z0, count, voxels, &err), &err, error);
}

static int32_t m_grid_download(const ost_plugin_grid *grid, int32_t z0, int32_t count, int16_t *voxels,
                               ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_grid_download((const ost_grid *)grid, z0, count, voxels, &err), &err, error);
}

static int32_t m_ct_to_rect(ost_plugin_grid *rect, const ost_plugin_samples *s, ost_plugin_scatter_report *r,
                            ost_plugin_error *error)
{
    ost_error err = {0};
    ost_scatter_report own = {r->samples,       r->duplicates,    r->off_lattice,  r->worst_offset_ppm, r->worst_line,
                              r->rejected_line, r->conflict_line, r->conflict_had, r->conflict_has};
    ost_sample *samples = malloc((s->count ? s->count : 1) * sizeof *samples);
    if (!samples)
        return OST_PLUGIN_MEMORY;
    for (uint64_t i = 0; i < s->count; i++)
        samples[i] = (ost_sample){s->sample[i].x_pm, s->sample[i].y_pm, s->sample[i].z_pm, s->sample[i].density,
                                  s->sample[i].line};
    const ost_status status = ost_ct_to_rect((ost_grid *)rect, samples, s->count, s->first_line,
                                             (ost_duplicates)s->duplicates, &own, &err);
    free(samples);
    r->samples = own.samples;
    r->duplicates = own.duplicates;
    r->off_lattice = own.off_lattice;
    r->worst_offset_ppm = own.worst_offset_ppm;
    r->worst_line = own.worst_line;
    r->rejected_line = own.rejected_line;
    r->conflict_line = own.conflict_line;
    r->conflict_had = own.conflict_had;
    r->conflict_has = own.conflict_has;
    return put_error(status, &err, error);
}

static int32_t m_rect_to_cubic(const ost_plugin_grid *rect, const ost_plugin_geometry *cubic, int32_t rule,
                               ost_plugin_grid **out, ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(
        ost_rect_to_cubic((const ost_grid *)rect, cubic->spacing_pm[0], (ost_resample)rule, (ost_grid **)out, &err),
        &err, error);
}

static int32_t m_cubic_to_chunks(const ost_plugin_grid *cubic, int32_t chunk_size, int32_t threshold,
                                 ost_plugin_bone **out, ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_cubic_to_chunks((const ost_grid *)cubic, chunk_size, threshold, (ost_bone **)out, &err), &err,
                     error);
}

static int32_t m_bone_create(ost_plugin_instance *self, const ost_plugin_geometry *geometry, int32_t chunk_size,
                             int32_t threshold, ost_plugin_bone **out, ost_plugin_error *error)
{
    ost_error err = {0};
    const ost_geometry g = geometry_of(geometry);
    return put_error(ost_bone_create(self->ref, &g, chunk_size, threshold, (ost_bone **)out, &err), &err, error);
}

static void m_bone_free(ost_plugin_bone *bone)
{
    ost_bone_free((ost_bone *)bone);
}

static int32_t m_bone_stats(const ost_plugin_bone *bone, ost_plugin_bone_stats *stats, ost_plugin_error *error)
{
    ost_error err = {0};
    ost_bone_info info;
    const ost_status status = ost_bone_info_get((const ost_bone *)bone, &info, &err);
    if (status != OST_OK)
        return put_error(status, &err, error);
    stats->active_chunks = broken("stats") ? -1 : info.active_chunks;
    stats->active_voxels = info.active_voxels;
    stats->chunk_bytes = info.chunk_bytes;
    stats->resident_bytes = info.resident_bytes;
    return OST_PLUGIN_OK;
}

static int32_t m_bone_upload(ost_plugin_bone *bone, int32_t z0, int32_t count, const int16_t *voxels,
                             ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_bone_upload((ost_bone *)bone, z0, count, voxels, &err), &err, error);
}

static int32_t m_bone_download(const ost_plugin_bone *bone, int32_t z0, int32_t count, int16_t *voxels,
                               ost_plugin_error *error)
{
    ost_error err = {0};
    return put_error(ost_bone_download((const ost_bone *)bone, z0, count, voxels, &err), &err, error);
}

static ost_snapped_mesh mesh_of(const ost_plugin_tool_geometry *g, const ost_plugin_mesh *m)
{
    return (ost_snapped_mesh){.grid = {{g->dims[0], g->dims[1], g->dims[2]},
                                       g->voxel_pm,
                                       {g->corner_pm[0], g->corner_pm[1], g->corner_pm[2]}},
                              .fraction_bits = m->fraction_bits,
                              .vertex_count = m->vertex_count,
                              .vertices = (int32_t(*)[3])(uintptr_t)m->vertices,
                              .triangle_count = m->triangle_count,
                              .triangles = (uint32_t(*)[3])(uintptr_t)m->triangles};
}

static int32_t m_voxelize(ost_plugin_instance *self, const ost_plugin_tool_geometry *g, const ost_plugin_mesh *cutting,
                          const ost_plugin_mesh *noncutting, int32_t parity, ost_plugin_voxelize_report *r,
                          ost_plugin_tool **out, ost_plugin_error *error)
{
    ost_error err = {0};
    ost_voxelize_report own;
    const ost_snapped_mesh first = mesh_of(g, cutting),
                           second = noncutting ? mesh_of(g, noncutting) : (ost_snapped_mesh){.vertices = NULL};
    if (broken("voxelize"))
        return OST_PLUGIN_OK; /* reports success but creates no tool */
    const ost_status status = ost_voxelize(self->ref, &first, noncutting ? &second : NULL,
                                           parity ? OST_FILL_PARITY : OST_FILL_WINDING, &own, (ost_tool **)out, &err);
    r->solid_voxels = own.solid_voxels;
    r->cutting_voxels = own.cutting_voxels;
    r->leaking_rows = own.leaking_rows;
    return put_error(status, &err, error);
}

static int32_t m_tool_upload(ost_plugin_instance *self, const ost_plugin_tool_geometry *g, const uint8_t *voxels,
                             ost_plugin_tool **out, ost_plugin_error *error)
{
    ost_error err = {0};
    const ost_tool_volume volume = {.geometry = {{g->dims[0], g->dims[1], g->dims[2]},
                                                 g->voxel_pm,
                                                 {g->corner_pm[0], g->corner_pm[1], g->corner_pm[2]}},
                                    .voxels = (uint8_t *)(uintptr_t)voxels};
    return put_error(ost_tool_upload(self->ref, &volume, (ost_tool **)out, &err), &err, error);
}

static int32_t m_tool_download(const ost_plugin_tool *tool, uint8_t *voxels, ost_plugin_error *error)
{
    ost_error err = {0};
    ost_tool_volume volume;
    const ost_status status = ost_tool_download((const ost_tool *)tool, &volume, &err);
    if (status != OST_OK)
        return put_error(status, &err, error);
    memcpy(voxels, volume.voxels, (size_t)ost_dims_count(volume.geometry.dims));
    ost_tool_volume_free(&volume);
    return OST_PLUGIN_OK;
}

static void m_tool_free(ost_plugin_tool *tool)
{
    ost_tool_free((ost_tool *)tool);
}

/* ------------------------------------------------------------------- events */

static ost_int128 joined(ost_plugin_int128 v)
{
    return (ost_int128){v.low, v.high};
}

/* Returns true if the host's function block_base computes the same base from `given` as the library computes from
   `map`. */
static int same_base(const ost_map *map, const ost_plugin_map *given)
{
    const int32_t block[3] = {1, 0, 2};
    int32_t a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
    const int has_a = ost_map_block_base(map, (ost_dims){1, 0, 2}, a),
              has_b = current->host->block_base(given, block, b);
    return has_a == has_b && (!has_a || memcmp(a, b, sizeof a) == 0);
}

static int32_t run_event(ost_bone *bone, const ost_tool *tool, const ost_plugin_event *e, int apply,
                         ost_plugin_report *report, ost_plugin_error *error)
{
    ost_error err = {0};
    ost_removal_report own = {0};
    const size_t n = (size_t)e->map_count;
    ost_map *maps = malloc(n * sizeof *maps);
    ost_voxel_box *boxes = malloc(n * sizeof *boxes);
    ost_density_classes classes = {.count = e->class_count};
    ost_status status = maps && boxes ? OST_OK : ost_fail(&err, OST_ERR_MEMORY, "no memory");
    memcpy(classes.border, e->class_from, (size_t)e->class_count * sizeof *e->class_from);
    for (size_t p = 0; p < n && status == OST_OK; p++) {
        const ost_plugin_map *m = (const ost_plugin_map *)(const void *)((const char *)e->maps + p * e->stride);
        maps[p].divisor = joined(m->divisor);
        for (int a = 0; a < 3; a++) {
            maps[p].origin[a] = joined(m->origin[a]);
            boxes[p].lo[a] = m->box_lo[a];
            boxes[p].hi[a] = m->box_hi[a];
            for (int b = 0; b < 3; b++) {
                maps[p].column[b][a] = joined(m->column[b][a]);
                maps[p].step[b][a] = m->step[b][a];
            }
        }
        if (!same_base(&maps[p], m))
            status = ost_fail(&err, OST_ERR_INTERNAL, "the host's block_base is not the map's");
    }
    const ost_removal_event event = {(int)n, maps, boxes, &classes};
    if (status == OST_OK)
        status = apply ? ost_bone_remove(bone, tool, &event, &own, &err)
                       : ost_bone_collide(bone, tool, &event, &own, &err);
    int32_t answer = put_error(status, &err, error);
    for (size_t c = 0; c < own.count && answer == OST_PLUGIN_OK; c++)
        answer = report->add(report->sink, broken("report") ? -3 : own.chunks[c].chunk, own.chunks[c].voxels,
                             own.chunks[c].density);
    report->touched_voxels = own.touched_voxels;
    ost_removal_report_free(&own);
    free(maps);
    free(boxes);
    return answer;
}

/* Makes voxel (1, 2, 3) active without reporting it. */
static void activate_unreported_voxel(ost_bone *bone)
{
    ost_bone_info info;
    if (ost_bone_info_get(bone, &info, NULL) != OST_OK)
        return;
    int16_t *slice = malloc((size_t)info.geometry.dims.x * (size_t)info.geometry.dims.y * sizeof *slice);
    if (slice && ost_bone_download(bone, 3, 1, slice, NULL) == OST_OK) {
        slice[1 + 2 * info.geometry.dims.x] = 777;
        (void)ost_bone_upload(bone, 3, 1, slice, NULL);
    }
    free(slice);
}

static int32_t m_remove(ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                        ost_plugin_report *report, ost_plugin_error *error)
{
    if (broken("crash"))
        raise(SIGSEGV);
    while (broken("hang"))
        pause();
    if (broken("status"))
        return 77;
    if (broken("lost")) {
        snprintf(error->text, error->text_size, "the device\nwent away");
        return OST_PLUGIN_LOST;
    }
    const int number = current ? ++current->events : 0;
    if (number == 62 && broken("forgets"))
        return OST_PLUGIN_OK; /* This event removes nothing and reports nothing. */
    const int32_t status = run_event((ost_bone *)bone, (const ost_tool *)tool, event, 1, report, error);
    if (number == 20 && broken("slips"))
        activate_unreported_voxel((ost_bone *)bone);
    return status;
}

static int32_t m_collide(const ost_plugin_bone *bone, const ost_plugin_tool *tool, const ost_plugin_event *event,
                         ost_plugin_report *report, ost_plugin_error *error)
{
    return run_event((ost_bone *)(uintptr_t)bone, (const ost_tool *)tool, event, 0, report, error);
}

/* -------------------------------------------------------------------- steps */

static ost_tool_geometry tool_grid_of(const ost_plugin_tool_geometry *g)
{
    return (ost_tool_geometry){{g->dims[0], g->dims[1], g->dims[2]},
                               g->voxel_pm,
                               {g->corner_pm[0], g->corner_pm[1], g->corner_pm[2]}};
}

static int32_t m_snap(ost_plugin_instance *self, const ost_plugin_tool_geometry *geometry,
                      const ost_plugin_raw_mesh *raw, ost_plugin_snapped *made, ost_plugin_error *error)
{
    ost_error err = {0};
    const ost_tool_geometry g = tool_grid_of(geometry);
    ost_mesh mesh;
    ost_snapped_mesh own;
    (void)self;
    ost_status status = ost_mesh_init(&mesh, raw->vertex_count, raw->triangle_count, &err);
    if (status != OST_OK)
        return put_error(status, &err, error);
    memcpy(mesh.vertices, raw->vertices_pm, raw->vertex_count * sizeof *mesh.vertices);
    memcpy(mesh.triangles, raw->triangles, raw->triangle_count * sizeof *mesh.triangles);
    status = ost_mesh_snap(&mesh, &g, &own, &err);
    ost_mesh_free(&mesh);
    if (status != OST_OK)
        return put_error(status, &err, error);
    made->fraction_bits = own.fraction_bits;
    made->triangle_count = own.triangle_count;
    memcpy(made->vertices, own.vertices, own.vertex_count * sizeof *own.vertices);
    memcpy(made->triangles, own.triangles, own.triangle_count * sizeof *own.triangles);
    made->vertices[0] += broken("snap");
    ost_snapped_mesh_free(&own);
    return OST_PLUGIN_OK;
}

static ost_pose pose_of(const ost_plugin_pose *p)
{
    return (ost_pose){{p->t_pm[0], p->t_pm[1], p->t_pm[2]}, p->q[0], p->q[1], p->q[2], p->q[3]};
}

static ost_plugin_int128 halves(ost_int128 v)
{
    return (ost_plugin_int128){v.low, v.high};
}

static int32_t m_steps(ost_plugin_instance *self, const ost_plugin_steps *in, ost_plugin_error *error)
{
    ost_error err = {0};
    const ost_plugin_geometry *b = in->bone;
    const ost_geometry bone = {{b->dims[0], b->dims[1], b->dims[2]},
                               {b->spacing_pm[0], b->spacing_pm[1], b->spacing_pm[2]},
                               {b->origin_pm[0], b->origin_pm[1], b->origin_pm[2]}};
    const ost_tool_geometry tool = tool_grid_of(in->tool);
    const ost_pose to = pose_of(in->to), from = in->from ? pose_of(in->from) : to;
    int count = 1;
    (void)self;
    ost_status status = in->from ? ost_sweep_count(&from, &to, &tool, bone.spacing.x, &count, &err) : OST_OK;
    int32_t answer = OST_PLUGIN_OK;
    for (int k = 1; k <= count && status == OST_OK && answer == OST_PLUGIN_OK; k++) {
        const ost_pose pose = count == 1 ? to : ost_sweep_pose(&from, &to, k, count);
        const ost_plugin_pose p = {sizeof p, {pose.qw, pose.qx, pose.qy, pose.qz}, {pose.t.x, pose.t.y, pose.t.z}};
        ost_map map;
        status = ost_map_make(&pose, &bone, &tool, &map, &err);
        ost_plugin_map m = {.size = sizeof m, .divisor = halves(map.divisor)};
        for (int a = 0; a < 3 && status == OST_OK; a++) {
            m.origin[a] = halves(map.origin[a]);
            for (int c = 0; c < 3; c++) {
                m.column[c][a] = halves(map.column[c][a]);
                m.step[c][a] = map.step[c][a];
            }
        }
        m.step[1][2] += broken("steps");
        if (status == OST_OK)
            answer = in->add(in->sink, &p, &m);
    }
    return status == OST_OK ? answer : put_error(status, &err, error);
}

#ifndef MIRROR_SIZE
#define MIRROR_SIZE sizeof(ost_plugin)
#endif
#ifndef MIRROR_ABI
#define MIRROR_ABI OST_PLUGIN_ABI
#endif
#ifdef MIRROR_NO_COLLIDE
#define COLLIDE NULL
#else
#define COLLIDE m_collide
#endif
#ifndef MIRROR_ARITHMETIC
#define MIRROR_ARITHMETIC OST_ARITHMETIC_VERSION
#endif

static const ost_plugin table = {
    MIRROR_SIZE,
    MIRROR_ABI,
    MIRROR_ARITHMETIC,
    0,
    "mirror",
    "the reference, through the plugin interface",
    m_open,
    m_close,
    m_finish,
    m_grid_create,
    m_grid_free,
    m_grid_upload,
    m_grid_download,
    m_ct_to_rect,
    m_rect_to_cubic,
    m_cubic_to_chunks,
    m_bone_create,
    m_bone_free,
    m_bone_stats,
    m_bone_upload,
    m_bone_download,
    m_voxelize,
    m_tool_upload,
    m_tool_download,
    m_tool_free,
    m_remove,
    COLLIDE,
    m_snap,
    m_steps,
};

OST_PLUGIN_EXPORT const ost_plugin *ost_plugin_entry(uint32_t host_abi);

const ost_plugin *ost_plugin_entry(uint32_t host_abi)
{
#ifdef MIRROR_REFUSES
    return host_abi ? NULL : &table;
#else
    return host_abi == OST_PLUGIN_ABI ? &table : NULL;
#endif
}
