/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tables 3.1 and 3.2, Figures 3.2 and 3.15: the grids of the five models, their chunks and their memory. All values
 * are counts, which are equal on every machine.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reproduction/item.h"
#include "reproduction/stated.h"

static double mb(double bytes)
{
    return bytes * 1e-6;
}

static double megabytes_of(ost_dims d)
{
    return mb(2.0 * (double)ost_dims_count(d));
}

/* Calls `add` for each model in the order of the thesis. */
static ost_status each_model(reproduction *r, result *out,
                             void (*add)(const reproduction *r, result *out, model_id id, const model *m),
                             ost_error *err)
{
    ost_status status = OST_OK;
    for (int id = 0; id < MODELS && status == OST_OK; id++) {
        const model *m;
        reproduction_show(r, stated_models[id].name, (double)id / MODELS);
        status = model_counted(&r->models, (model_id)id, &m, err);
        if (status == OST_OK)
            add(r, out, (model_id)id, m);
    }
    return status;
}

static void remark_phantoms(const reproduction *r, result *out)
{
    result_add_remark(out, "The CTs of the thesis are not public. Phantoms with the same dimensions and spacings take "
                           "their place, so that the dimensions agree exactly and the numbers of active chunks only "
                           "approximately. --ct MODEL=FILE replaces a phantom by a CT.");
    for (int id = 0; id < MODELS; id++)
        if (model_is_own(&r->models, (model_id)id))
            result_add_remark(out, "%s is a CT of the user: %.300s.", stated_models[id].name, r->models.ct[id]);
}

/* --------------------------------------------------------------- Table 3.1 */

enum { GRID_MODEL, GRID_SPACING, GRID_DIMS, GRID_DIMS_THESIS, GRID_VOXELS, GRID_MEMORY, GRID_CUBIC, GRID_CUBIC_MEMORY };

static void add_grid(const reproduction *r, result *out, model_id id, const model *m)
{
    const stated_model *s = &stated_models[id];
    const ost_geometry *g = &m->rect.geometry, *cubic = &m->info[MODEL_CHUNK_32].geometry;
    (void)r;
    result_add_row(out);
    result_set_text(out, GRID_MODEL, "%s", m->name);
    result_set_text(out, GRID_SPACING, "%.4g x %.4g x %.4g", ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y),
                    ost_pm_to_mm(g->spacing.z));
    result_set_text(out, GRID_DIMS, "%d x %d x %d", g->dims.x, g->dims.y, g->dims.z);
    result_set_text(out, GRID_DIMS_THESIS, "%d x %d x %d", s->dims[0], s->dims[1], s->dims[2]);
    result_set(out, GRID_VOXELS, (double)ost_dims_count(g->dims));
    result_set_thesis(out, GRID_VOXELS, s->voxels);
    result_set(out, GRID_MEMORY, megabytes_of(g->dims));
    result_set_thesis(out, GRID_MEMORY, s->memory_mb);
    result_set_text(out, GRID_CUBIC, "%d x %d x %d", cubic->dims.x, cubic->dims.y, cubic->dims.z);
    result_set(out, GRID_CUBIC_MEMORY, megabytes_of(cubic->dims));
}

ost_status item_model_grids(reproduction *r, result *out, ost_error *err)
{
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "voxel_mm", "voxel (mm)", "text");
    result_add_column(out, "dims", "voxels per axis", "text");
    result_add_column(out, "dims_thesis", "thesis: voxels per axis", "text");
    result_add_column(out, "voxels", "voxels", "");
    result_add_column(out, "memory_MB", "single buffer", "MB");
    result_add_column(out, "cubic_dims", "cubic voxels per axis", "text");
    result_add_column(out, "cubic_MB", "single buffer, cubic voxels", "MB");
    remark_phantoms(r, out);
    result_add_remark(out,
                      "Table 2.2 lists the sizes of the text files. The thesis compares the chunks, which have cubic "
                      "voxels, with a single buffer of the CT's own voxels; the last column is the single buffer "
                      "of the same cubic voxels.");
    return each_model(r, out, add_grid, err);
}

/* --------------------------------------------------------------- Table 3.2 */

enum {
    CHUNKS_MODEL,
    CHUNKS_SIZE,
    CHUNKS_PADDED,
    CHUNKS_DIMS,
    CHUNKS_COUNT,
    CHUNKS_ACTIVE,
    CHUNKS_RAW,
    CHUNKS_ACTIVE_MB,
    CHUNKS_RESIDENT
};

static void add_chunks(const reproduction *r, result *out, model_id id, const model *m)
{
    const stated_model *s = &stated_models[id];
    (void)r;
    for (int i = 0; i < MODEL_CHUNK_SIZES; i++) {
        const ost_bone_info *info = &m->info[i];
        const double n = model_chunk[i], bytes = 2 * n * n * n;
        result_add_row(out);
        result_set_text(out, CHUNKS_MODEL, "%s", m->name);
        result_set(out, CHUNKS_SIZE, n);
        result_set_text(out, CHUNKS_PADDED, "%d x %d x %d", info->chunk_dims.x * model_chunk[i],
                        info->chunk_dims.y * model_chunk[i], info->chunk_dims.z * model_chunk[i]);
        result_set_text(out, CHUNKS_DIMS, "%d x %d x %d", info->chunk_dims.x, info->chunk_dims.y, info->chunk_dims.z);
        result_set(out, CHUNKS_COUNT, (double)info->chunks);
        result_set(out, CHUNKS_ACTIVE, (double)info->active_chunks);
        result_set(out, CHUNKS_RAW, mb(bytes * (double)info->chunks));
        result_set(out, CHUNKS_ACTIVE_MB, mb(bytes * (double)info->active_chunks));
        result_set(out, CHUNKS_RESIDENT, mb((double)info->resident_bytes));
        if (i != MODEL_CHUNK_32)
            continue;
        result_set_thesis(out, CHUNKS_COUNT, s->chunks);
        result_set_thesis(out, CHUNKS_ACTIVE, s->active_chunks);
        result_set_thesis(out, CHUNKS_RAW, s->raw_mb);
        result_set_thesis(out, CHUNKS_ACTIVE_MB, s->active_mb);
    }
}

ost_status item_model_chunks(reproduction *r, result *out, ost_error *err)
{
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "chunk_voxels", "chunk side (voxels)", "");
    result_add_column(out, "padded_dims", "padded voxels per axis", "text");
    result_add_column(out, "chunk_dims", "chunks per axis", "text");
    result_add_column(out, "chunks", "chunks", "");
    result_add_column(out, "active_chunks", "active chunks", "");
    result_add_column(out, "raw_MB", "all chunks", "MB");
    result_add_column(out, "active_MB", "active chunks", "MB");
    result_add_column(out, "resident_MB", "osteon, with all tables", "MB");
    remark_phantoms(r, out);
    result_add_remark(out, "The last column is the memory of osteon's bone: in addition to the densities, one bit per "
                           "voxel and a table of the chunks.");
    return each_model(r, out, add_chunks, err);
}

/* -------------------------------------------------------------- Figure 3.2 */

enum { MEMORY_MODEL, MEMORY_SINGLE, MEMORY_CUBIC, MEMORY_16, MEMORY_32, MEMORY_64 };

static void add_memory(const reproduction *r, result *out, model_id id, const model *m)
{
    const stated_model *s = &stated_models[id];
    (void)r;
    result_add_row(out);
    result_set_text(out, MEMORY_MODEL, "%s", m->name);
    result_set(out, MEMORY_SINGLE, megabytes_of(m->rect.geometry.dims));
    result_set_thesis(out, MEMORY_SINGLE, s->memory_mb);
    result_set(out, MEMORY_CUBIC, megabytes_of(m->info[0].geometry.dims));
    for (int i = 0; i < MODEL_CHUNK_SIZES; i++) {
        const double n = model_chunk[i];
        result_set(out, MEMORY_16 + i, mb(2 * n * n * n * (double)m->info[i].active_chunks));
    }
    result_set_thesis(out, MEMORY_32, s->active_mb);
}

static void judge_memory(result *out)
{
    char saves[RESULT_TEXT] = "", more[RESULT_TEXT] = "";
    int expected = 0;
    for (size_t i = 0; i < out->row_count; i++) {
        const result_cell *cell = out->row[i].cell;
        const double single = cell[MEMORY_SINGLE].value, chunks = cell[MEMORY_32].value;
        char *to = chunks < single ? saves : more;
        const size_t at = strlen(to);
        snprintf(to + at, RESULT_TEXT - at, "%s%.40s (%+.0f %%)", at ? ", " : "", cell[MEMORY_MODEL].text,
                 100 * (chunks / single - 1));
        expected += (chunks < single) == (cell[MEMORY_32].thesis < cell[MEMORY_SINGLE].thesis);
    }
    result_add_finding(out, expected == MODELS ? RESULT_CONFIRMED : RESULT_CONTRADICTED, "section 3.1.1",
                       "Chunks of 32^3 voxels take less memory than a single buffer in three of the five models, and "
                       "more for the glenoid and trabecular core 1.",
                       "Less for %.280s; more for %.280s.", *saves ? saves : "none", *more ? more : "none");
    const result_cell *scapula = out->row[MODEL_SCAPULA].cell;
    const double saved = 1 - scapula[MEMORY_32].value / scapula[MEMORY_SINGLE].value,
                 saved_cubic = 1 - scapula[MEMORY_32].value / scapula[MEMORY_CUBIC].value;
    result_add_finding(
        out, saved > 0.4 && saved < 0.6 ? RESULT_CONFIRMED : RESULT_CONTRADICTED, "section 3.1.1",
        "The scapula's chunks take up to 50 % less memory than a single buffer.",
        "%.0f %% less than a buffer of the CT's voxels, and %.0f %% less than a buffer of the same cubic "
        "voxels. The thesis compares with the former, although that buffer has fewer, longer voxels.",
        100 * saved, 100 * saved_cubic);
}

ost_status item_model_memory(reproduction *r, result *out, ost_error *err)
{
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "single_MB", "single buffer", "MB");
    result_add_column(out, "cubic_MB", "single buffer, cubic voxels", "MB");
    result_add_column(out, "chunks_16_MB", "chunks of 16^3", "MB");
    result_add_column(out, "chunks_32_MB", "chunks of 32^3", "MB");
    result_add_column(out, "chunks_64_MB", "chunks of 64^3", "MB");
    ost_status status = each_model(r, out, add_memory, err);
    remark_phantoms(r, out);
    result_add_remark(out,
                      "The plot of the thesis has no printed values; the values next to ours are those of Tables 3.1 "
                      "and 3.2.");
    if (status == OST_OK && !out->out_of_memory)
        judge_memory(out);
    result_plot *p = result_add_plot(out, RESULT_PLOT_BARS, "Memory of the active voxels", "model", "memory (MB)");
    p->x = MEMORY_MODEL;
    for (int c = MEMORY_SINGLE; c <= MEMORY_32; c++)
        if (c != MEMORY_16)
            p->value[p->values++] = c;
    p = result_add_plot(out, RESULT_PLOT_BARS, "Memory by size of the chunks", "model", "memory (MB)");
    p->x = MEMORY_MODEL;
    for (int c = MEMORY_16; c <= MEMORY_64; c++)
        p->value[p->values++] = c;
    return status;
}

/* ------------------------------------------------------------- Figure 3.15 */

enum { RATIO_MODEL, RATIO_ACTIVE, RATIO_INACTIVE, RATIO_RATIO, RATIO_SHARE, RATIO_SURFACE, RATIO_SURFACE_SHARE };

static void add_ratio(const reproduction *r, result *out, model_id id, const model *m)
{
    const ost_bone_info *info = &m->info[MODEL_CHUNK_32];
    const double stored = 32.0 * 32 * 32 * (double)info->active_chunks, active = (double)info->active_voxels;
    (void)r;
    (void)id;
    result_add_row(out);
    result_set_text(out, RATIO_MODEL, "%s", m->name);
    result_set(out, RATIO_ACTIVE, active);
    result_set(out, RATIO_INACTIVE, stored - active);
    result_set(out, RATIO_RATIO, stored > active ? active / (stored - active) : 0);
    result_set(out, RATIO_SHARE, stored > 0 ? 100 * active / stored : 0);
    result_set(out, RATIO_SURFACE, (double)m->surface_voxels);
    result_set(out, RATIO_SURFACE_SHARE, active > 0 ? 100 * (double)m->surface_voxels / active : 0);
}

ost_status item_active_ratio(reproduction *r, result *out, ost_error *err)
{
    result_add_column(out, "model", "model", "text");
    result_add_column(out, "active_voxels", "active voxels", "");
    result_add_column(out, "inactive_voxels", "inactive voxels of active chunks", "");
    result_add_column(out, "active_to_inactive", "active / inactive", "");
    result_add_column(out, "active_percent", "active in active chunks", "%");
    result_add_column(out, "surface_voxels", "voxels at the surface", "");
    result_add_column(out, "surface_percent", "at the surface, of the active", "%");
    ost_status status = each_model(r, out, add_ratio, err);
    remark_phantoms(r, out);
    result_add_remark(out, "The plot of the thesis has no printed values. Voxels at the surface are those that osteon "
                           "draws; the thesis passes every voxel of an active chunk to the vertex shader and discards "
                           "the inactive ones there.");
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_BARS, "Ratio of active to inactive voxels", "model", "active / inactive");
    p->x = RATIO_MODEL;
    p->value[p->values++] = RATIO_RATIO;
    p = result_add_plot(out, RESULT_PLOT_BARS, "Share of the voxels", "model", "share (%)");
    p->x = RATIO_MODEL;
    p->value[p->values++] = RATIO_SHARE;
    p->value[p->values++] = RATIO_SURFACE_SHARE;
    return status;
}
