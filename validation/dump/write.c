/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the records of a trace as a dump. */
#include "validation/dump/parts.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static ost_status write_file(const char *path, const void *bytes, size_t size, ost_error *err)
{
    FILE *f = fopen(path, "wb");
    const bool written = f && fwrite(bytes, 1, size, f) == size;
    if ((f && fclose(f) != 0) || !written)
        return ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    return OST_OK;
}

static ost_status make_folder(const char *path, ost_error *err)
{
    return mkdir(path, 0777) == 0 ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
}

static ost_status write_case(const char *folder, const trace *t, compare_range range, ost_error *err)
{
    ost_dims dims = {0, 0, 0};
    int16_t *bone = NULL;
    ost_status status = OST_OK;
    for (size_t i = 0; i < range.count && status == OST_OK; i++) {
        const trace_record *r = &t->records[range.first + i];
        char name[40], file[64], path[DUMP_PATH];
        size_t at = 0, bytes = 0;
        trace_block_view b;
        const void *voxels = NULL;
        dump_stage_name(r, name);
        snprintf(file, sizeof file, "%s.raw", name);
        status = dump_join(path, folder, file, err);
        if (r->stage == TRACE_TICK && bone) {
            while (trace_next_block(r, &at, &b))
                dump_copy_block(&b, dims, bone);
            voxels = bone;
            bytes = 2 * (size_t)ost_dims_count(dims);
        } else if (dump_is_grid(r->stage) && trace_next_block(r, &at, &b)) {
            voxels = b.voxels;
            bytes = (size_t)ost_dims_count(b.dims) * b.voxel_bytes;
            if (r->stage == TRACE_CHUNKS && !bone) {
                dims = b.dims;
                bone = malloc(bytes);
                if (!bone)
                    status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a bone of %zu bytes", bytes);
                else
                    memcpy(bone, b.voxels, bytes);
            }
        }
        if (voxels && status == OST_OK)
            status = write_file(path, voxels, bytes, err);
        if ((r->stage == TRACE_SNAP || r->stage == TRACE_STEPS) && status == OST_OK)
            status = dump_write_steps(folder, r, err);
    }
    free(bone);
    return status;
}

ost_status dump_write(const char *folder, const char *program, const plan *p, const trace *t, ost_error *err)
{
    char path[DUMP_PATH];
    ost_status status = make_folder(folder, err);
    for (int i = 0; i < p->count && status == OST_OK; i++) {
        const compare_range range = compare_find(t, (uint32_t)i);
        char name[PLAN_ID];
        dump_case_folder(p->cases[i].id, name);
        if (!range.count)
            continue;
        status = dump_join(path, folder, name, err);
        if (status == OST_OK)
            status = make_folder(path, err);
        if (status == OST_OK)
            status = write_case(path, t, range, err);
    }
    if (status == OST_OK)
        status = dump_join(path, folder, "dump.json", err);
    if (status != OST_OK)
        return status;
    char seed[32];
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    json_t *o = json_pack("{s:i,s:s,s:i,s:s,s:s,s:s}", "osteon_dump", DUMP_FORMAT, "program", program, "arithmetic",
                          OST_ARITHMETIC_VERSION, "tier", plan_tier_name(p->tier), "seed", seed, "only",
                          p->only ? p->only : "");
    char *text = o ? json_dumps(o, JSON_INDENT(1) | JSON_SORT_KEYS) : NULL;
    status = text ? write_file(path, text, strlen(text), err)
                  : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", path);
    free(text);
    json_decref(o);
    return status;
}
