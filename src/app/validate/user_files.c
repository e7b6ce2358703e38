/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Uses the user's own files as cases. The files are read with the options of import, voxelize and ream, and recorded in
 * a bundle by size and digest. For a rerun, the recorded files are identified among the given files.
 *
 * This source file has more than 500 lines, because reading a user's file and writing or comparing its record depend on
 * the same options.
 */
#include "app/validate/user_files.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <osteon/motor.h>

#include "app/common/progress.h"
#include "app/common/result.h"
#include "core/conditions.h"
#include "core/integer.h"
#include "io/text/scan.h"

enum { BATCH = 65536, ROWS = 2048, COLLIDE_EVERY = 50 };

bool user_files_given(const user_files *u)
{
    return u->cts.count || u->tools.count || u->paths.count;
}

/* -------------------------------------------------------------------- options */

json_t *user_files_how(int argc, char **argv)
{
    user_files u = USER_FILES_DEFAULT;
    const option table[] = {USER_FILES_HOW(u), {.name = NULL}};
    json_t *how = json_array();
    for (const option *o = table; o->name; o++)
        for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
            const size_t n = strlen(o->name);
            if (strncmp(argv[i], "--", 2) != 0 || strncmp(argv[i] + 2, o->name, n) != 0)
                continue;
            if (argv[i][2 + n] == '=' || (!argv[i][2 + n] && o->kind == OPTION_FLAG))
                append(how, json_string(argv[i]));
            else if (!argv[i][2 + n] && i + 1 < argc)
                append(how, json_sprintf("%s=%s", argv[i], argv[i + 1]));
        }
    return how;
}

/*
 * Parses the options stored in a bundle. Only the options in the verb's table are accepted, because the bundle may
 * come from an untrusted source.
 */
static ost_status parse_how(app_state *app, const json_t *how, user_files *u, ost_error *err)
{
    const option table[] = {USER_FILES_HOW(*u), {.name = NULL}};
    enum { WORDS = 1 + sizeof table / sizeof table[0] };
    char *words[WORDS] = {(char *)(uintptr_t) "verify"};
    const usage_text usage = {.options = table};
    ost_status status;
    int n = 1;
    for (size_t i = 0; i < json_array_size(how); i++) {
        const char *word = json_string_value(json_array_get(how, i));
        const option *o = table;
        while (o->name && (!word || strncmp(word, "--", 2) != 0 || strcspn(word + 2, "=") != strlen(o->name) ||
                           strncmp(word + 2, o->name, strlen(o->name)) != 0))
            o++;
        if (!o->name || n == WORDS)
            return ost_fail(err, OST_ERR_INPUT, "protocol.json: the user's files were read with '%.60s', which this "
                            "version does not support", word ? word : "");
        words[n++] = (char *)(uintptr_t)word;
    }
    options_parse(app, &usage, n, words, &status, err);
    return status;
}

/* --------------------------------------------------------------------- files */

static const char *builtin_of(const char *name)
{
    return strncmp(name, "builtin:", 8) == 0 ? name + 8 : NULL;
}

/*
 * Computes the size and the digest of a file. Rejects a file that can be read only once, such as a pipe,
 * because it could not be verified later.
 */
static ost_status identify_file(const char *path, int64_t *bytes, ost_digest *digest, ost_error *err)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: cannot open: %s", path, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: not a regular file; the evidence needs the SHA-256 of a file that others can check",
                        path);
    *bytes = info.st_size;
    return digest ? file_digest(path, digest, err) : OST_OK;
}

static ost_status add_file(json_t *files, const char *kind, const char *name, ost_error *err)
{
    ost_digest digest;
    int64_t bytes;
    json_t *o = json_object();
    put_text(o, "option", kind);
    append(files, o);
    if (builtin_of(name)) {
        put_text(o, "builtin", builtin_of(name));
        return OST_OK;
    }
    const ost_status status = identify_file(name, &bytes, &digest, err);
    if (status == OST_OK) {
        put_integer(o, "bytes", bytes);
        put_digest(o, "sha256", &digest);
    }
    return status;
}

/* Returns the name of file i, counted in the order of the record: CTs, tools, paths. */
static const char *file_name(const user_files *u, int i)
{
    if (i < u->cts.count)
        return u->cts.value[i];
    i -= u->cts.count;
    return i < u->tools.count ? u->tools.value[i] : u->paths.value[i - u->tools.count];
}

static ost_status add_files(const user_files *u, json_t *files, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < u->cts.count && status == OST_OK; i++)
        status = add_file(files, "ct", u->cts.value[i], err);
    for (int i = 0; i < u->tools.count && status == OST_OK; i++)
        status = add_file(files, "tool", u->tools.value[i], err);
    for (int i = 0; i < u->paths.count && status == OST_OK; i++)
        status = add_file(files, "path", u->paths.value[i], err);
    return status;
}

/* Computes the digests of all files again. Returns an error if a file changed while it was being read. */
static ost_status still_the_same(const user_files *u, const json_t *files, ost_error *err)
{
    json_t *again = json_array();
    ost_status status = add_files(u, again, err);
    for (size_t i = 0; i < json_array_size(files) && status == OST_OK; i++) {
        const json_t *was = json_object_get(json_array_get(files, i), "sha256"),
                     *is = json_object_get(json_array_get(again, i), "sha256");
        if (was && !json_equal(was, is))
            status = ost_fail(err, OST_ERR_INPUT,
                              "%s: file changed while it was read; try again when no program writes to it",
                              file_name(u, (int)i));
    }
    json_decref(again);
    return status;
}

/* --------------------------------------------------------------------- CTs */

/* Returns true if a sample lies within the grid. Positions are within 8 m, so differences are below 2^44 pm. */
static bool lies_in(const ost_geometry *g, const ost_text_row *row)
{
    const int64_t origin[3] = {g->origin.x, g->origin.y, g->origin.z},
                  spacing[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++) {
        const int64_t at = ost_rhe_div(row->position[a] - origin[a], spacing[a]);
        if (at < 0 || at >= dims[a])
            return false;
    }
    return true;
}

/*
 * Stores every line of a CT given as text, in the order of the file. If `crop` is set, stores only the lines whose
 * samples lie within the grid.
 */
static ost_status put_text_samples(const char *path, const ost_geometry *rect, bool crop, user_store *store,
                                   ost_error *err)
{
    ost_text_source source;
    ost_text_row *rows = malloc(ROWS * sizeof *rows);
    ost_sample *samples = malloc(ROWS * sizeof *samples);
    if (!rows || !samples) {
        free(rows);
        free(samples);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory to read %d lines", path, ROWS);
    }
    ost_status status = ost_text_source_open(&source, path, err);
    if (status == OST_OK) {
        size_t count = 1;
        while (status == OST_OK && count > 0) {
            size_t n = 0;
            status = ost_text_source_next(&source, rows, ROWS, &count, err);
            for (size_t i = 0; i < count && status == OST_OK; i++)
                if (!crop || lies_in(rect, &rows[i]))
                    samples[n++] = (ost_sample){.x = rows[i].position[0],
                                                .y = rows[i].position[1],
                                                .z = rows[i].position[2],
                                                .density = rows[i].density};
            if (status == OST_OK && n)
                status = user_case_samples(store, samples, n, BATCH, err);
        }
        ost_text_source_close(&source);
    }
    free(rows);
    free(samples);
    return status;
}

/* Writes each voxel as a sample at its lattice point, x fastest. */
static ost_status put_volume_samples(const char *path, const ost_import_options *options, const ost_geometry *rect,
                                     user_store *store, ost_error *err)
{
    ost_volume volume = {0};
    ost_status status = ost_volume_read(path, &options->volume, &volume, NULL, err);
    const ost_dims from = volume.geometry.dims;
    const ost_voxel_box box = options->crop ? options->crop_box : (ost_voxel_box){{0, 0, 0}, {from.x, from.y, from.z}};
    const bool fits = status == OST_OK && box.hi[0] <= from.x && box.hi[1] <= from.y && box.hi[2] <= from.z &&
                      box.hi[0] - box.lo[0] == rect->dims.x && box.hi[1] - box.lo[1] == rect->dims.y &&
                      box.hi[2] - box.lo[2] == rect->dims.z;
    if (status == OST_OK && !fits)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: file changed while it was read; try again when no program writes to it", path);
    ost_sample *row = status == OST_OK ? malloc((size_t)rect->dims.x * sizeof *row) : NULL;
    if (status == OST_OK && !row)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a row of %d voxels", path, rect->dims.x);
    for (int32_t k = 0; status == OST_OK && k < rect->dims.z; k++)
        for (int32_t j = 0; status == OST_OK && j < rect->dims.y; j++) {
            const int16_t *voxels = volume.voxels + (size_t)box.lo[0] +
                                    (size_t)from.x *
                                        ((size_t)(box.lo[1] + j) + (size_t)from.y * (size_t)(box.lo[2] + k));
            for (int32_t i = 0; i < rect->dims.x; i++)
                row[i] = (ost_sample){.x = rect->origin.x + rect->spacing.x * i,
                                      .y = rect->origin.y + rect->spacing.y * j,
                                      .z = rect->origin.z + rect->spacing.z * k,
                                      .density = voxels[i]};
            status = user_case_samples(store, row, (size_t)rect->dims.x, BATCH, err);
        }
    free(row);
    ost_volume_free(&volume);
    return status;
}

static void put_imported(json_t *to, const ost_import_result *r, const ost_bone_info *info)
{
    char text[OST_PM_TEXT];
    put_dims(to, "rect_dims", r->rect.dims);
    put(to, "rect_spacing_mm", json_array());
    append(json_object_get(to, "rect_spacing_mm"), json_string(ost_pm_format(r->rect.spacing.x, text)));
    append(json_object_get(to, "rect_spacing_mm"), json_string(ost_pm_format(r->rect.spacing.y, text)));
    append(json_object_get(to, "rect_spacing_mm"), json_string(ost_pm_format(r->rect.spacing.z, text)));
    put_dims(to, "cubic_dims", r->cubic.dims);
    put_text(to, "cubic_mm", ost_pm_format(r->cubic.spacing.x, text));
    put_integer(to, "threshold", info->threshold);
    put_integer(to, "chunk", info->chunk_size);
    put_integer(to, "active_voxels", info->active_voxels);
    json_t *stages = json_object();
    for (int i = 0; i < r->stage_count; i++)
        if (r->stages[i].has_digest)
            put_digest(stages, r->stages[i].name, &r->stages[i].digest);
    put(to, "import_sha256", stages);
}

/*
 * Adds a CT. The reference also imports the CT once, as `osteon import` does, so that errors in the file are reported
 * before the campaign.
 */
static ost_status put_ct(const app_state *app, const user_files *u, const char *path, user_store *store, scene *head,
                         ost_meta *meta, json_t *one, ost_error *err)
{
    ost_import_options options;
    ost_import_result result;
    ost_bone_info info;
    ost_backend *ref = NULL;
    ost_bone *bone = NULL;
    ost_status status = load_import_options(app, &u->ct, true, &options, err);
    if (status == OST_OK)
        status = ost_backend_open("ref", &ref, err);
    if (status == OST_OK)
        status = ost_import(ref, path, &options, &bone, &result, err);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &info, err);
    ost_bone_free(bone);
    ost_backend_close(ref);
    if (status != OST_OK)
        return status;
    load_warn_import(app, path, &result);
    head->rect = result.rect;
    head->duplicates = options.duplicates;
    head->cubic = result.cubic.spacing.x;
    head->resample = result.resample;
    head->chunk_size = info.chunk_size;
    head->threshold = info.threshold;
    *meta = result.meta;
    put_imported(one, &result, &info);
    return result.kind == OST_FILE_CT_TEXT ? put_text_samples(path, &result.rect, options.crop, store, err)
                                           : put_volume_samples(path, &options, &result.rect, store, err);
}

/* ------------------------------------------------------------------- tools */

static ost_status snap_tool(const user_files *u, const char *name, bool moves, scene_tool *out, json_t *tools,
                            ost_error *err)
{
    ost_mesh mesh = {0};
    ost_mesh_report report = {0};
    ost_tool_geometry grid;
    ost_pm3 lo, hi;
    ost_file_kind kind = OST_FILE_MESH;
    ost_status status = builtin_of(name) ? OST_OK : ost_file_kind_find(name, &kind, err);
    if (status == OST_OK && kind == OST_FILE_NRRD)
        status = ost_fail(err, OST_ERR_INPUT, "%s: is a tool grid; pass its mesh, since voxelization is compared too",
                          name);
    if (status == OST_OK)
        status = load_mesh(name, (ost_unit)u->how.unit, &mesh, &report, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK && (status = ost_tool_geometry_from_bounds(lo, hi, u->how.voxel, &grid, err)) != OST_OK)
        ost_fail_context(err, "%s", name);
    if (status == OST_OK && moves &&
        (grid.dims.x > OST_TOOL_DIM_REMOVE_MAX || grid.dims.y > OST_TOOL_DIM_REMOVE_MAX ||
         grid.dims.z > OST_TOOL_DIM_REMOVE_MAX))
        status = ost_fail(err, OST_ERR_RANGE,
                          "%s: %d x %d x %d voxels; reaming needs at most %d per side: use a larger --voxel", name,
                          grid.dims.x, grid.dims.y, grid.dims.z, OST_TOOL_DIM_REMOVE_MAX);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &out->cutting, err);
    if (status == OST_OK) {
        json_t *o = json_object();
        put_text(o, "format", report.format);
        put_integer(o, "triangles", (int64_t)out->cutting.triangle_count);
        put_dims(o, "dims", grid.dims);
        append(tools, o);
    }
    out->rule = (ost_fill_rule)u->how.rule;
    out->raw[0] = mesh; /* The tool owns the mesh from here on. */
    return status;
}

/* ------------------------------------------------------------------- cases */

static ost_status check_counts(const app_state *app, const user_files *u, ost_error *err)
{
    if (u->tools.count > SCENE_TOOLS_MAX)
        return usage_error(app, err, "%d tools given; expected at most %d", u->tools.count, SCENE_TOOLS_MAX);
    if (u->paths.count && (!u->cts.count || !u->tools.count))
        return usage_error(app, err, "--path needs --tool and --ct");
    if (u->tools.count > 1 && u->paths.count > u->tools.count)
        return usage_error(app, err,
                           "%d paths and %d tools; pass one tool for all paths, or one per path in the same order",
                           u->paths.count, u->tools.count);
    for (int i = 0; i < u->cts.count; i++)
        if (builtin_of(u->cts.value[i]))
            return usage_error(app, err, "--ct %s: expected a file; phantoms are in the generated cases",
                               u->cts.value[i]);
    return OST_OK;
}

static ost_status add_case(const app_state *app, const user_files *u, int ct, const scene *tools, user_store *store,
                           json_t *one, ost_error *err)
{
    scene head = *tools; /* The loop changes a copy of the scene, because the caller owns the tools. */
    ream_gaps counted = {0};
    ost_meta meta = {0};
    const ost_tool_geometry *grids[SCENE_TOOLS_MAX] = {NULL};
    ost_status status = ct < u->cts.count ? put_ct(app, u, u->cts.value[ct], store, &head, &meta, one, err) : OST_OK;
    for (int t = 0; t < head.tool_count; t++)
        grids[t] = &head.tools[t].cutting.grid;
    if (status == OST_OK && u->paths.count)
        status = ream_path_make(app, &u->paths, &u->target, &meta, u->cts.value[ct], grids, head.tool_count, NULL,
                                &head.path, &counted, err);
    if (status == OST_OK && u->paths.count)
        status = scene_turn(&head, OST_RPM_REAMER, err);
    if (status == OST_OK) {
        put_integer(one, "ticks", (int64_t)head.path.count);
        put_integer(one, "gaps", (int64_t)counted.gaps);
        status = user_case_end(store, &head, err);
    }
    ost_path_free(&head.path);
    ost_path_free(&head.handle_path);
    return status;
}

ost_status user_files_read(const app_state *app, const user_files *u, json_t *how, user_store **store, json_t **record,
                           ost_error *err)
{
    scene tools = {.world = {.sweep_off = u->sweep == 0}, .collide_every = COLLIDE_EVERY};
    json_t *files = json_array(), *cases = json_array(), *made = json_array();
    *store = NULL;
    *record = json_object();
    put(*record, "files", files);
    put(*record, "tools", made);
    put(*record, "cases", cases);
    put(*record, "how", json_incref(how));
    ost_status status = check_counts(app, u, err);
    if (status == OST_OK)
        status = ream_period(app, &u->rate, &tools.world.removal_period_ns, err);
    if (status == OST_OK)
        status = add_files(u, files, err);
    if (status == OST_OK)
        status = user_store_begin(store, err);
    for (int t = 0; t < u->tools.count && status == OST_OK; t++) {
        snprintf(tools.tools[t].name, sizeof tools.tools[t].name, "tool %d", t + 1);
        tools.tool_count++;
        status = snap_tool(u, u->tools.value[t], u->paths.count > 0, &tools.tools[t], made, err);
    }
    const int count = u->cts.count ? u->cts.count : 1;
    for (int i = 0; i < count && status == OST_OK; i++) {
        json_t *one = json_object();
        put(one, "id", json_sprintf("user/%d", i + 1));
        if (u->cts.count)
            put_integer(one, "ct", i + 1);
        append(cases, one);
        progress_show(NULL, "reading your files", (double)i / count);
        status = add_case(app, u, i, &tools, *store, one, err);
    }
    if (status == OST_OK)
        status = still_the_same(u, files, err);
    if (status == OST_OK)
        status = user_store_end(*store, err);
    progress_end();
    tools.path = (ost_path){0};
    scene_free(&tools);
    return status;
}

ost_status user_files_of(const app_state *app, const user_files *u, int argc, char **argv, user_store **store,
                         json_t **record, ost_error *err)
{
    json_t *how = user_files_how(argc, argv);
    ost_status status = OST_OK;
    *store = NULL;
    *record = NULL;
    if (user_files_given(u))
        status = user_files_read(app, u, how, store, record, err);
    else if (json_array_size(how))
        status = usage_error(app, err, "%s needs --ct, --tool or --path", json_string_value(json_array_get(how, 0)));
    json_decref(how);
    return status;
}

/* ------------------------------------------------------------------- rerun */

/* Writes the number of files of each kind to `text`, such as "1 with --ct, 2 with --tool". */
static void describe_needed(const json_t *files, char text[96])
{
    static const char *const kinds[] = {"ct", "tool", "path"};
    size_t used = 0;
    for (int k = 0; k < 3; k++) {
        int n = 0;
        for (size_t i = 0; i < json_array_size(files); i++) {
            const char *kind = json_string_value(json_object_get(json_array_get(files, i), "option"));
            n += kind && strcmp(kind, kinds[k]) == 0 && json_object_get(json_array_get(files, i), "sha256");
        }
        if (n)
            used += (size_t)snprintf(text + used, 96 - used, "%s%d with --%s", used ? ", " : "", n, kinds[k]);
    }
}

/* Finds the given file whose size and digest equal those in the record. */
static ost_status find_file(const option_list *given, const char *kind, const json_t *file, const char **out,
                            ost_error *err)
{
    const json_int_t size = json_integer_value(json_object_get(file, "bytes"));
    const char *wanted = json_string_value(json_object_get(file, "sha256"));
    for (int i = 0; i < given->count; i++) {
        int64_t bytes;
        ost_digest digest;
        char hex[OST_DIGEST_HEX];
        ost_status status = identify_file(given->value[i], &bytes, NULL, err);
        if (status == OST_OK && bytes == size && (status = file_digest(given->value[i], &digest, err)) == OST_OK &&
            wanted && strcmp(ost_digest_hex(&digest, hex), wanted) == 0) {
            *out = given->value[i];
            return OST_OK;
        }
        if (status != OST_OK)
            return status;
    }
    return ost_fail(err, OST_ERR_INPUT,
                    "none of the files given with --%s is the bundle's of %lld bytes and SHA-256 %.64s", kind,
                    (long long)size, wanted ? wanted : "");
}

static ost_status take_file(const user_files *given, user_files *u, json_t *names, const json_t *file, ost_error *err)
{
    static const char *const kinds[] = {"ct", "tool", "path"};
    const option_list *const from[] = {&given->cts, &given->tools, &given->paths};
    option_list *const to[] = {&u->cts, &u->tools, &u->paths};
    const char *kind = json_string_value(json_object_get(file, "option")),
               *builtin = json_string_value(json_object_get(file, "builtin")), *name = NULL;
    ost_status status = OST_OK;
    int k = 0;
    while (k < 3 && (!kind || strcmp(kind, kinds[k]) != 0))
        k++;
    if (k == 3 || to[k]->count == OPTION_LIST_MAX)
        return ost_fail(err, OST_ERR_INPUT,
                        "protocol.json: the format of the list of user files is not supported by this version");
    if (builtin) {
        json_t *text = json_sprintf("builtin:%.80s", builtin);
        append(names, text);
        name = json_string_value(text);
    } else
        status = find_file(from[k], kinds[k], file, &name, err);
    to[k]->value[to[k]->count++] = name;
    return status;
}

ost_status user_files_again(app_state *app, const user_files *given, const json_t *record, user_store **store,
                            json_t **again, ost_error *err)
{
    user_files u = USER_FILES_DEFAULT;
    json_t *names = json_array();
    const json_t *files = json_object_get(record, "files");
    char needed[96] = "";
    ost_status status = OST_OK;
    *store = NULL;
    *again = NULL;
    describe_needed(files, needed);
    if (!user_files_given(given) && needed[0])
        status = ost_fail(err, OST_ERR_USAGE, "the bundle has cases of user files: --rerun needs these files, %s",
                          needed);
    if (status == OST_OK)
        status = parse_how(app, json_object_get(record, "how"), &u, err);
    for (size_t i = 0; i < json_array_size(files) && status == OST_OK; i++)
        status = take_file(given, &u, names, json_array_get(files, i), err);
    if (status == OST_OK && !json_is_array(json_object_get(record, "how")))
        status = ost_fail(err, OST_ERR_INPUT, "protocol.json: missing: how the user's files were read");
    if (status == OST_OK)
        status = user_files_read(app, &u, json_object_get(record, "how"), store, again, err);
    json_decref(names);
    return status;
}
