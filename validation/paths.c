/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void write_count(void *user, const char *path, uint64_t entered)
{
    (void)path;
    trace_word(user, entered);
}

static void write_name(void *user, const char *path, uint64_t entered)
{
    const size_t length = strlen(path);
    const int32_t lo[3] = {0, 0, 0};
    (void)entered;
    void *to = trace_block(user, lo, (ost_dims){(int32_t)length, 1, 1}, 1);
    if (to)
        memcpy(to, path, length);
}

void paths_write(const ost_backend *backend, trace_writer *w)
{
    ost_backend_paths(backend, write_count, w);
    ost_backend_paths(backend, write_name, w);
}

/* Adds `entered` to the count of the path with this name. Appends the path if it is not in the list. */
static ost_status add_one(path_list *list, const char *name, uint64_t entered, ost_error *err)
{
    int i = 0;
    while (i < list->count && strcmp(list->paths[i].name, name) != 0)
        i++;
    if (i == list->count) {
        path_count *grown = realloc(list->paths, (size_t)(i + 1) * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of %d paths", i + 1);
        list->paths = grown;
        list->count++;
        grown[i] = (path_count){.entered = 0};
        snprintf(grown[i].name, sizeof grown[i].name, "%s", name);
    }
    list->paths[i].entered += entered;
    return OST_OK;
}

ost_status paths_add(path_list *list, const trace_record *end, ost_error *err)
{
    uint64_t count;
    const uint8_t *words;
    size_t at = 0;
    trace_block_view block;
    ost_status status = OST_OK;
    if (end->stage != TRACE_END || !trace_words(end, &count, &words) || count > PATHS_MAX)
        return OST_OK;
    for (uint64_t i = 0; i < count && status == OST_OK && trace_next_block(end, &at, &block); i++) {
        char name[OST_PATH_NAME];
        if (block.voxel_bytes != 1 || block.dims.y != 1 || block.dims.z != 1)
            return OST_OK;
        snprintf(name, sizeof name, "%.*s", (int)block.dims.x, (const char *)block.voxels);
        for (char *c = name; *c; c++)
            *c = *c < ' ' || *c > '~' ? '?' : *c;
        status = add_one(list, name, trace_word_at(words, i), err);
    }
    return status;
}

void paths_json(const path_list *list, json_t **entered, json_t **missing)
{
    *entered = json_object();
    *missing = json_array();
    for (int i = 0; i < list->count; i++) {
        const path_count *one = &list->paths[i];
        if (one->entered)
            json_object_set_new(*entered, one->name, json_integer((json_int_t)one->entered));
        else
            json_array_append_new(*missing, json_string(one->name));
    }
}

void paths_free(path_list *list)
{
    free(list->paths);
    *list = (path_list){0};
}
