/* SPDX-License-Identifier: Apache-2.0 */
/* The figures that are pictures of the models: the scapula, alone or with a tool, and the other models. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/motor.h>

#include "bench/inputs.h"
#include "reproduction/item.h"
#include "reproduction/stated.h"
#include "reproduction/view.h"
#include "reproduction/voxel_blocks.h"

typedef struct job {
    reproduction *r;
    result *out;
    ost_error *err;
    const model *scapula;
    ost_volume bone;
    ost_glenoid glenoid;
} job;

static ost_status begin(job *j)
{
    ost_status status = model_get(&j->r->models, MODEL_SCAPULA, &j->scapula, j->err);
    if (status == OST_OK)
        status = model_cubic(j->scapula, &j->bone, j->err);
    if (status == OST_OK)
        status = model_glenoid(j->scapula, &j->glenoid, j->err);
    return status;
}

/* Draws the scene and adds it to the result as ID[-suffix].png. */
static ost_status add_view(job *j, view_scene scene, const char *suffix, const char *caption)
{
    char file[RESULT_KEY];
    uint8_t *png = NULL;
    size_t size = 0;
    scene.bone = scene.bone ? scene.bone : &j->bone;
    scene.threads = j->r->bench.threads;
    scene.style = OST_STYLE_FACES;
    snprintf(file, sizeof file, "%.30s%s%.12s.png", j->out->id, *suffix ? "-" : "", suffix);
    reproduction_show(j->r, file, 0);
    ost_status status = view_draw(&scene, &png, &size, j->err);
    if (status == OST_OK)
        result_add_picture(j->out, file, caption, png, size);
    return status;
}

/* -------------------------------------------------------------- Figure 1.3 */

ost_status item_scapula(reproduction *r, result *out, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_status status = begin(&j);
    if (status == OST_OK)
        status =
            add_view(&j, (view_scene){.glenoid = &j.glenoid, .view = OST_VIEW_OVERVIEW}, "",
                     "The complete scapula. Each voxel is a cube of 0.47 mm, lit by its own faces as in the thesis.");
    if (status == OST_OK)
        status = add_view(&j, (view_scene){.glenoid = &j.glenoid, .view = OST_VIEW_OPERATOR, .extent_mm = 24}, "close",
                          "The voxels of the glenoid from near by.");
    ost_volume_free(&j.bone);
    return status;
}

/* -------------------------------------------------------------- Figure 1.4 */

static double height_of(const ost_geometry *g)
{
    return ost_pm_to_mm(g->dims.z * g->spacing.z);
}

ost_status item_samples(reproduction *r, result *out, ost_error *err)
{
    static const char *const letters[MODELS] = {"(a)", "(b)", "(c)", "(d)", "(e)"};
    job j = {.r = r, .out = out, .err = err};
    ost_status status = OST_OK;
    for (int id = 0; id < MODELS && status == OST_OK; id++) {
        const bool anatomy = id == MODEL_SCAPULA || id == MODEL_GLENOID;
        char caption[RESULT_TEXT];
        const model *m;
        status = model_get(&r->models, (model_id)id, &m, err);
        if (status == OST_OK)
            status = model_cubic(m, &j.bone, err);
        snprintf(caption, sizeof caption, "%s %s", letters[id], m->name);
        /*
         * The view's extent is measured in the plane through the core's centre. It is 1.6 times the core's height,
         * because the near edge of the core appears larger.
         */
        if (status == OST_OK)
            status = add_view(&j,
                              (view_scene){.view = OST_VIEW_OVERVIEW,
                                           .unoriented = !anatomy,
                                           .turn = anatomy ? 0 : -0.9,
                                           .lift = anatomy ? 0 : 0.25,
                                           .extent_mm = anatomy ? 0 : 1.6 * height_of(&j.bone.geometry)},
                              model_words[id], caption);
        ost_volume_free(&j.bone);
    }
    return status;
}

/* ------------------------------------------------------- Figures 2.1 and 3.1 */

ost_status item_partition(reproduction *r, result *out, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_status status = begin(&j);
    if (status == OST_OK)
        status = add_view(&j,
                          (view_scene){.glenoid = &j.glenoid,
                                       .view = OST_VIEW_OPERATOR,
                                       .extent_mm = 95,
                                       .overlays = 1u << OST_OVERLAY_CHUNKS},
                          "", "The chunks of 32^3 voxels around the glenoid.");
    ost_volume_free(&j.bone);
    return status;
}

ost_status item_active_chunks(reproduction *r, result *out, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_status status = begin(&j);
    if (status == OST_OK)
        status =
            add_view(&j,
                     (view_scene){.glenoid = &j.glenoid,
                                  .view = OST_VIEW_OVERVIEW,
                                  .extent_mm = 280,
                                  .overlays = 1u << OST_OVERLAY_CHUNKS},
                     "", "Red: chunks with at least one active voxel. Grey: chunks without one, which take no memory.");
    ost_volume_free(&j.bone);
    return status;
}

/* -------------------------------------------------------------- Figure 2.2 */

/* Adds a drawing of those voxels of a grid that lie in a box around the glenoid. */
static ost_status add_blocks(job *j, const ost_volume *volume, const char *suffix, const char *caption)
{
    const ost_geometry *g = &volume->geometry;
    const ost_pm reach = 5 * OST_PM_PER_MM;
    char file[RESULT_KEY];
    uint8_t *svg = NULL;
    size_t size = 0;
    ost_voxel_box box;
    const ost_pm at[3] = {j->glenoid.at.x - g->origin.x, j->glenoid.at.y - g->origin.y, j->glenoid.at.z - g->origin.z};
    const ost_pm spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        const int64_t lo = (at[a] - reach) / spacing[a], hi = (at[a] + reach) / spacing[a];
        box.lo[a] = (int32_t)(lo < 0 ? 0 : lo);
        box.hi[a] = (int32_t)(hi > dims[a] ? dims[a] : hi);
    }
    snprintf(file, sizeof file, "%.30s-%.12s.svg", j->out->id, suffix);
    ost_status status = voxel_blocks_draw(volume, &box, MODEL_THRESHOLD, j->glenoid.axis, &svg, &size, j->err);
    if (status == OST_OK)
        result_add_picture(j->out, file, caption, svg, size);
    return status;
}

ost_status item_cubic(reproduction *r, result *out, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_status status = begin(&j);
    if (status == OST_OK)
        status = add_blocks(&j, &j.scapula->rect, "before",
                            "(A) Before: voxels of the CT at the glenoid, 0.47 x 0.47 x 1 mm.");
    if (status == OST_OK)
        status =
            add_blocks(&j, &j.bone, "after",
                       "(B) After: cubic voxels of 0.47 mm, interpolated linearly. The thesis repeats the layers of "
                       "the CT instead (--resample thesis of osteon import).");
    ost_volume_free(&j.bone);
    return status;
}

/* ------------------------------------------------- Figures 2.3, 3.3 and 3.4 */

static ost_status with_tool(reproduction *r, result *out, ost_tool_kind kind, ost_builtin path, ost_pm voxel,
                            view_scene scene, const char *caption, ost_error *err)
{
    job j = {.r = r, .out = out, .err = err};
    ost_tool_volume tool = {.voxels = NULL};
    ost_status status = begin(&j);
    if (status == OST_OK)
        status = bench_tool_volume("cpu", kind, voxel, &tool, err);
    if (status == OST_OK)
        status = view_deepest(path, &j.glenoid, &tool.geometry, &scene.pose, err);
    scene.tool = &tool;
    scene.glenoid = &j.glenoid;
    if (status == OST_OK)
        status = add_view(&j, scene, "", caption);
    ost_tool_volume_free(&tool);
    ost_volume_free(&j.bone);
    return status;
}

ost_status item_boxes(reproduction *r, result *out, ost_error *err)
{
    return with_tool(
        r, out, OST_TOOL_REAMER, OST_BUILTIN_GLENOID_REAM, OST_PM_PER_MM / 2,
        (view_scene){
            .view = OST_VIEW_OPERATOR, .extent_mm = 190, .overlays = 1u << OST_OVERLAY_BOXES | 1u << OST_OVERLAY_HITS},
        "White: box of the bone; green: oriented box of the reamer; amber: their intersection box (Alg. 2.8); "
        "red: the active chunks in it (Alg. 2.9).",
        err);
}

ost_status item_bone_to_tool(reproduction *r, result *out, ost_error *err)
{
    return with_tool(
        r, out, OST_TOOL_PEG, OST_BUILTIN_PEG_HOLE, OST_PM_PER_MM / 2,
        (view_scene){.view = OST_VIEW_OPERATOR,
                     .extent_mm = 46,
                     .overlays = 1u << OST_OVERLAY_BONE_VOXELS | 1u << OST_OVERLAY_HITS},
        "From bone to tool: the bone's voxels within the tool's box (red edges) are transformed and compared "
        "with the tool's grid.",
        err);
}

ost_status item_tool_to_bone(reproduction *r, result *out, ost_error *err)
{
    return with_tool(r, out, OST_TOOL_PEG, OST_BUILTIN_PEG_HOLE, OST_PM_PER_MM / 2,
                     (view_scene){.view = OST_VIEW_OPERATOR,
                                  .extent_mm = 46,
                                  .overlays = 1u << OST_OVERLAY_TOOL_VOXELS | 1u << OST_OVERLAY_BONE_VOXELS},
                     "From tool to bone: the tool's voxels (green edges) are transformed and compared with the bone's "
                     "voxels (red edges).",
                     err);
}

/* -------------------------------------------------------------- Figure 3.5 */

enum { PASSES = 2 };

/* Removes bone along a built-in path, with a tool whose motor rotates. */
static ost_status remove_along(ost_bone *bone, const ost_tool *tool, ost_builtin which, const ost_glenoid *glenoid,
                               double share, ost_pose *last, ost_error *err)
{
    enum { RPM = 600 };
    const ost_tool_geometry *grid = ost_tool_geometry_get(tool);
    ost_world *world = NULL;
    ost_path path = {.ticks = NULL};
    ost_motor motor = {.phase = 0};
    ost_step_result step;
    int index;
    ost_status status = ost_builtin_path(which, glenoid, grid, 0, &path, err);
    if (status == OST_OK)
        status = ost_motor_path(&path, RPM, &motor, err);
    if (status == OST_OK)
        status = ost_world_create(bone, NULL, &world, err);
    if (status == OST_OK)
        status = ost_world_add_tool(world, "tool", tool, &index, err);
    for (size_t i = 0; status == OST_OK && i < (size_t)(share * (double)path.count); i++) {
        status = ost_world_step(world, &path.ticks[i], &step, err);
        *last = path.ticks[i].pose;
    }
    ost_world_free(world);
    ost_path_free(&path);
    return status;
}

static ost_status show_cut(job *j, const ost_bone *bone, const ost_volume *before, const ost_tool_volume *tool,
                           ost_pose pose, const char *suffix, const char *caption)
{
    ost_volume after = {.voxels = NULL};
    ost_status status = ost_volume_init(&after, &before->geometry, j->err);
    if (status == OST_OK)
        status = ost_bone_download(bone, 0, after.geometry.dims.z, after.voxels, j->err);
    if (status == OST_OK)
        status = add_view(j,
                          (view_scene){.bone = &after,
                                       .before = before,
                                       .tool = tool,
                                       .pose = pose,
                                       .glenoid = &j->glenoid,
                                       .view = OST_VIEW_OPERATOR,
                                       .extent_mm = 70},
                          suffix, caption);
    ost_volume_free(&after);
    return status;
}

ost_status item_removal(reproduction *r, result *out, ost_error *err)
{
    static const struct {
        ost_tool_kind kind;
        ost_builtin path;
        double share;
        const char *suffix, *caption;
        bool with_tool;
    } passes[PASSES + 1] = {{OST_TOOL_PEG, OST_BUILTIN_PEG_HOLE, 1, "peg", "After the peg hole.", false},
                            {OST_TOOL_REAMER, OST_BUILTIN_GLENOID_REAM, 0.55, "reaming", "During reaming.", true},
                            {OST_TOOL_REAMER, OST_BUILTIN_GLENOID_REAM, 1, "reamed",
                             "After reaming. The colours show the depth below the uncut surface.", false}};
    job j = {.r = r, .out = out, .err = err};
    ost_backend *backend = NULL;
    ost_bone *bone = NULL;
    ost_status status = begin(&j);
    if (status == OST_OK)
        status = bench_backend(&r->bench, r->bench.threads, &backend, err);
    if (status == OST_OK)
        status = model_bone(j.scapula, backend, 32, &bone, err);
    for (int i = 0; i <= PASSES && status == OST_OK; i++) {
        ost_tool_volume volume = {.voxels = NULL};
        ost_tool *tool = NULL;
        ost_pose pose = ost_pose_identity();
        status = bench_tool_volume("cpu", passes[i].kind, OST_PM_PER_MM / 2, &volume, err);
        if (status == OST_OK)
            status = ost_tool_upload(backend, &volume, &tool, err);
        if (status == OST_OK)
            status = remove_along(bone, tool, passes[i].path, &j.glenoid, passes[i].share, &pose, err);
        if (status == OST_OK)
            status = show_cut(&j, bone, &j.bone, passes[i].with_tool ? &volume : NULL, pose, passes[i].suffix,
                              passes[i].caption);
        ost_tool_free(tool);
        ost_tool_volume_free(&volume);
    }
    ost_bone_free(bone);
    ost_backend_close(backend);
    ost_volume_free(&j.bone);
    return status;
}
