/* SPDX-License-Identifier: Apache-2.0 */
/* Reads dump.json, which describes a dump, and constructs the names of the dump's other files. */
#include "validation/dump/parts.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"

void dump_case_folder(const char *id, char name[PLAN_ID])
{
    snprintf(name, PLAN_ID, "%s", id);
    for (char *c = name; *c; c++)
        if (*c == '/')
            *c = '-';
}

ost_status dump_join(char path[DUMP_PATH], const char *folder, const char *name, ost_error *err)
{
    const int n = snprintf(path, DUMP_PATH, "%s/%s", folder, name);
    return n > 0 && n < DUMP_PATH ? OST_OK : ost_fail(err, OST_ERR_USAGE, "%.60s...: the name is too long", folder);
}

void dump_stage_name(const trace_record *r, char name[40])
{
    if (r->stage == TRACE_TOOL || r->stage == TRACE_TICK || r->stage == TRACE_SNAP || r->stage == TRACE_STEPS)
        snprintf(name, 40, "%s-%u", trace_stage_name(r->stage), (unsigned)r->item);
    else
        snprintf(name, 40, "%s", trace_stage_name(r->stage));
}

bool dump_is_grid(trace_stage stage)
{
    return stage == TRACE_RECT || stage == TRACE_CUBIC || stage == TRACE_CHUNKS || stage == TRACE_TOOL ||
           stage == TRACE_FINAL;
}

static ost_status bad_head(const char *path, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %s", path, what);
}

static bool decimal(const char *text, uint64_t *out)
{
    *out = 0;
    size_t n = 0;
    for (; text[n] >= '0' && text[n] <= '9' && n < 19; n++)
        *out = 10 * *out + (uint64_t)(text[n] - '0');
    return n > 0 && !text[n];
}

ost_status dump_read_head(const char *folder, dump_head *out, ost_error *err)
{
    char path[DUMP_PATH];
    char *bytes;
    size_t size;
    bool absent;
    json_error_t where;
    ost_error why = {0};
    ost_status status = dump_join(path, folder, "dump.json", err);
    *out = (dump_head){.seed = 1};
    if (status != OST_OK)
        return status;
    status = ost_file_read(path, 1 << 20, &bytes, &size, &absent, &why);
    if (status != OST_OK)
        return ost_fail(err, status, "%s%s", why.text,
                        absent ? "; expected the folder of a dump, which contains this file (docs/spec/dumps.md)" : "");
    json_t *o = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, &where);
    free(bytes);
    if (!o)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s", path, where.line, where.text);
    const json_t *format = json_object_get(o, "osteon_dump"), *tier = json_object_get(o, "tier"),
                 *seed = json_object_get(o, "seed"), *only = json_object_get(o, "only"),
                 *program = json_object_get(o, "program"), *arithmetic = json_object_get(o, "arithmetic");
    const char *tier_text = json_string_value(tier);
    bool known = !tier;
    for (int i = 0; tier_text && i < PLAN_TIERS; i++)
        if (strcmp(tier_text, plan_tier_name((plan_tier)i)) == 0) {
            out->tier = (plan_tier)i;
            known = true;
        }
    if (!json_is_integer(format) || json_integer_value(format) != DUMP_FORMAT)
        status = bad_head(path, "osteon_dump must be 1, the format's version", err);
    else if (arithmetic && json_integer_value(arithmetic) != OST_ARITHMETIC_VERSION)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: arithmetic is %lld; this osteon compares with version %d of docs/spec/arithmetic.md",
                          path, (long long)json_integer_value(arithmetic), OST_ARITHMETIC_VERSION);
    else if (!known)
        status = bad_head(path, "tier must be \"smoke\", \"standard\" or \"full\"", err);
    else if (seed && (!json_is_string(seed) || !decimal(json_string_value(seed), &out->seed)))
        status = bad_head(path, "seed must be a number in quotes, as in \"1\"", err);
    else if (only && (!json_is_string(only) || json_string_length(only) >= sizeof out->only))
        status = bad_head(path, "only must be the beginning of a case's name, as in \"import/0\"", err);
    else if (program && (!json_is_string(program) || json_string_length(program) >= sizeof out->program))
        status = bad_head(path, "program must be a text of less than 200 bytes", err);
    if (status == OST_OK) {
        snprintf(out->only, sizeof out->only, "%s", only ? json_string_value(only) : "");
        snprintf(out->program, sizeof out->program, "%s", program ? json_string_value(program) : "");
    }
    json_decref(o);
    return status;
}

size_t dump_voxel_index(ost_dims d, int32_t x, int32_t y, int32_t z)
{
    return (size_t)x + (size_t)d.x * ((size_t)y + (size_t)d.y * (size_t)z);
}

void dump_copy_block(const trace_block_view *b, ost_dims d, int16_t *bone)
{
    if (b->voxel_bytes != 2 || b->lo[0] < 0 || b->lo[1] < 0 || b->lo[2] < 0 || b->lo[0] + b->dims.x > d.x ||
        b->lo[1] + b->dims.y > d.y || b->lo[2] + b->dims.z > d.z)
        return;
    for (int32_t k = 0; k < b->dims.z; k++)
        for (int32_t j = 0; j < b->dims.y; j++)
            memcpy(bone + dump_voxel_index(d, b->lo[0], b->lo[1] + j, b->lo[2] + k),
                   b->voxels + 2 * dump_voxel_index(b->dims, 0, j, k), 2 * (size_t)b->dims.x);
}
