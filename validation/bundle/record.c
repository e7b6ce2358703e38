/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/record.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"
#include "validation/bundle/anomaly_lines.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/devices.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/junit.h"
#include "validation/bundle/software.h"
#include "validation/bundle/suite.h"
#include "validation/bundle/tools.h"
#include "validation/bundle/trace_table.h"
#include "validation/common/common.h"

/* Writes a JSON file as bundle_put_json does. */
static ost_status put_json(const char *name, const json_t *value, evidence_sink *sink, void *user, ost_error *err)
{
    char *text = json_dumps(value, JSON_SORT_KEYS | JSON_INDENT(1));
    if (!text)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    const size_t size = strlen(text);
    text[size] = '\n';
    ost_status status = sink(user, name, text, size + 1, err);
    free(text);
    return status;
}

static ost_status put_known_anomalies(evidence_sink *sink, void *user, ost_error *err)
{
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    for (size_t i = 0; to && i < sizeof anomaly_lines / sizeof anomaly_lines[0]; i++)
        fprintf(to, "%s\n", anomaly_lines[i]);
    if (!to || !ost_memory_stream_close(to, &made))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", KNOWN_ANOMALIES_FILE);
    const ost_status status = sink(user, KNOWN_ANOMALIES_FILE, made.bytes, made.size, err);
    free(made.bytes);
    return status;
}

ost_status record_put(const char *program, const subject_list *subjects, const json_t *common, evidence_sink *sink,
                      void *user, ost_error *err)
{
    json_t *devices = NULL, *tools = NULL;
    char *requirements = trace_requirements();
    ost_status status = requirements ? sink(user, REQUIREMENTS_FILE, requirements, strlen(requirements), err)
                                     : ost_fail(err, OST_ERR_MEMORY, "out of memory for requirements");
    free(requirements);
    if (status == OST_OK)
        status = put_known_anomalies(sink, user, err);
    if (status == OST_OK)
        /* devices_of is called before tools_of, because it loads drivers that tools_of lists. */
        status = devices_of(subjects, &devices, err);
    if (status == OST_OK)
        status = put_json(DEVICES_FILE, devices, sink, user, err);
    if (status == OST_OK)
        status = tools_of(program, &tools, err);
    if (status == OST_OK)
        status = put_json(TOOLS_FILE, tools, sink, user, err);
    if (status == OST_OK && common)
        status = put_json(COMMON_FILE, common, sink, user, err);
    json_decref(devices);
    json_decref(tools);
    return status;
}

/* -------------------------------------------------------- files of shards */

/* Writes the number of the shard, such as "2/8", from the bundle's protocol. */
static ost_status shard_name(const char *folder, char name[32], ost_error *err)
{
    json_t *protocol;
    const ost_status status = bundle_find_json(folder, EVIDENCE_PROTOCOL, &protocol, err);
    const json_t *shard = json_object_get(protocol, "shard");
    snprintf(name, 32, "%lld/%lld", (long long)json_integer_value(json_array_get(shard, 0)),
             (long long)json_integer_value(json_array_get(shard, 1)));
    json_decref(protocol);
    return status;
}

/* Reads the file `name` of each shard into a JSON object, keyed by the number of the shard. */
static ost_status gather(const char *folder, const char *name, json_t **out, ost_error *err)
{
    DIR *dir = opendir(folder);
    *out = json_object();
    ost_status status = dir ? OST_OK : ost_fail(err, OST_ERR_INPUT, "%s: %s", folder, strerror(errno));
    for (struct dirent *e; status == OST_OK && (status = bundle_next_entry(dir, folder, &e, err)) == OST_OK && e;) {
        char path[BUNDLE_PATH], shard[32], *bytes;
        size_t size;
        if (e->d_name[0] == '.' || strstr(e->d_name, ".part-") ||
            snprintf(path, sizeof path, "%s/%s", folder, e->d_name) >= (int)sizeof path)
            continue;
        status = bundle_find(path, name, &bytes, &size, err);
        if (!bytes)
            continue;
        status = shard_name(path, shard, err);
        if (status == OST_OK && json_object_set_new(*out, shard, json_stringn(bytes, size)) != 0)
            status = ost_fail(err, OST_ERR_INPUT, "%s/%s: not UTF-8", path, name);
        free(bytes);
    }
    if (dir)
        closedir(dir);
    return status;
}

/* Merges one file of the shards. If the file is identical in all shards, writes it once. If not, writes an object with
   the file of each shard if by_shard is true, or returns an error if by_shard is false. */
static ost_status merge_one(const char *folder, const char *name, bool by_shard, evidence_sink *sink, void *user,
                            ost_error *err)
{
    json_t *all, *text, *first = NULL, *parts = json_object();
    const char *shard;
    bool equal = true;
    ost_status status = gather(folder, name, &all, err);
    json_object_foreach(all, shard, text) {
        first = first ? first : text;
        equal &= json_equal(first, text) != 0;
        json_object_set_new(
            parts, shard, json_loadb(json_string_value(text), json_string_length(text), JSON_REJECT_DUPLICATES, NULL));
    }
    if (status == OST_OK && first && equal)
        status = sink(user, name, json_string_value(first), json_string_length(first), err);
    else if (status == OST_OK && first && by_shard)
        status = put_json(name, parts, sink, user, err);
    else if (status == OST_OK && first)
        status = ost_fail(err, OST_ERR_INPUT, "%s: the shards' %s differ: they were made by different builds", folder,
                          name);
    json_decref(parts);
    json_decref(all);
    return status;
}

ost_status record_merge(const char *folder, evidence_sink *sink, void *user, ost_error *err)
{
    ost_status status = merge_one(folder, REQUIREMENTS_FILE, false, sink, user, err);
    if (status == OST_OK)
        status = merge_one(folder, KNOWN_ANOMALIES_FILE, false, sink, user, err);
    if (status == OST_OK)
        status = merge_one(folder, COMMON_FILE, false, sink, user, err);
    if (status == OST_OK)
        status = merge_one(folder, DEVICES_FILE, true, sink, user, err);
    return status == OST_OK ? merge_one(folder, TOOLS_FILE, true, sink, user, err) : status;
}

/* ---------------------------------------------------------- derived files */

/* Reads a JSON file. *out is NULL if the file is absent or exceeds the limits; linked_check reports these problems. */
static ost_status find_json(const char *folder, const char *name, json_t **out, ost_error *err)
{
    ost_error why = {0};
    const ost_status status = bundle_find_json(folder, name, out, &why);
    return status == OST_OK || status == OST_ERR_INPUT ? OST_OK : ost_fail(err, status, "%s", why.text);
}

ost_status record_derive(const char *folder, const json_t *protocol, const json_t *cases, evidence_sink *sink,
                         void *user, ost_error *err)
{
    char *requirements = NULL;
    size_t size;
    json_t *tools = NULL, *common = NULL, *times = NULL, *environment = NULL, *suite = NULL;
    ost_status status = find_json(folder, TOOLS_FILE, &tools, err);
    if (status == OST_OK)
        status = find_json(folder, COMMON_FILE, &common, err);
    if (status == OST_OK)
        status = find_json(folder, TIMES_FILE, &times, err);
    if (status == OST_OK)
        status = find_json(folder, ENVIRONMENT_FILE, &environment, err);
    if (status == OST_OK)
        status = find_json(folder, SUITE_FILE, &suite, err);
    if (status == OST_OK && json_is_object(tools))
        status = software_write(tools, sink, user, err);
    if (status == OST_OK)
        status = junit_write(protocol, cases, times, environment, sink, user, err);
    if (status == OST_OK)
        status = bundle_find(folder, REQUIREMENTS_FILE, &requirements, &size, err);
    if (status == OST_OK && requirements)
        status = trace_table_write(requirements, cases, common, suite, sink, user, err);
    free(requirements);
    json_decref(suite);
    json_decref(environment);
    json_decref(times);
    json_decref(common);
    json_decref(tools);
    return status;
}
