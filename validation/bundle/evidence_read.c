/* SPDX-License-Identifier: Apache-2.0 */
/* Reads protocol.json and cases.jsonl of a bundle, which may come from an untrusted source. */
#include "validation/bundle/evidence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"

ost_status evidence_check_format(const char *folder, const json_t *protocol, ost_error *err)
{
    char version[48];
    const json_t *format = json_object_get(protocol, "schema");
    if (json_is_integer(format) && json_integer_value(format) == EVIDENCE_FORMAT)
        return OST_OK;
    if (!json_is_object(protocol))
        return ost_fail(err, OST_ERR_INPUT, "%.200s/" EVIDENCE_PROTOCOL ": is no JSON object", folder);
    return ost_fail(err, OST_ERR_INPUT,
                    "%.200s: is a bundle of format %lld, written by osteon %s; this osteon reads format %d, so use the "
                    "osteon that wrote it",
                    folder, (long long)json_integer_value(format),
                    limits_printable(evidence_text(protocol, "version"), version, sizeof version), EVIDENCE_FORMAT);
}

/* Reads a line without its newline. Sets *end to true at the end of the file. */
static ost_status read_line(FILE *file, int number, char **line, size_t *capacity, size_t *size, bool *end,
                            ost_error *err)
{
    int c;
    *size = 0;
    while ((c = getc_unlocked(file)) != EOF && c != '\n') {
        if (*size == LIMIT_LINE)
            return ost_fail(err, OST_ERR_INPUT, EVIDENCE_CASES ":%d: the line is longer than %d bytes", number,
                            LIMIT_LINE);
        if (*size == *capacity) {
            const size_t wanted = *capacity ? 2 * *capacity : 1 << 16;
            char *grown = realloc(*line, wanted);
            if (!grown)
                return ost_fail(err, OST_ERR_MEMORY, "out of memory for line %d of " EVIDENCE_CASES, number);
            *line = grown;
            *capacity = wanted;
        }
        (*line)[(*size)++] = (char)c;
    }
    *end = c == EOF && *size == 0;
    if (ferror(file))
        return ost_fail(err, OST_ERR_IO, EVIDENCE_CASES ": cannot be read");
    return c == '\n' || *end ? OST_OK
                             : ost_fail(err, OST_ERR_INPUT, EVIDENCE_CASES ":%d: the last line does not end", number);
}

/* Checks that a line is identical to the text that this program writes for the line's value. */
static ost_status check_written(const json_t *row, const char *where, const char *line, size_t size, ost_error *err)
{
    char *text = json_dumps(row, JSON_SORT_KEYS | JSON_COMPACT);
    if (!text)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", where);
    const bool same = strlen(text) == size && memcmp(text, line, size) == 0;
    free(text);
    return same ? OST_OK : ost_fail(err, OST_ERR_INPUT, "%s: is not written as osteon writes it", where);
}

static void drop_leaves(json_t *row)
{
    const json_t *records = json_object_get(row, "reference");
    for (size_t k = 0; k < json_array_size(records); k++)
        json_object_del(json_array_get(records, k), "leaves");
}

static ost_status read_lines(FILE *file, bool with_leaves, json_t *out, ost_error *err)
{
    char *line = NULL, where[48];
    size_t capacity = 0, size, values, all = 0;
    bool end = false;
    ost_status status = OST_OK;
    for (int number = 1; status == OST_OK; number++) {
        json_t *row = NULL;
        status = read_line(file, number, &line, &capacity, &size, &end, err);
        if (status != OST_OK || end)
            break;
        snprintf(where, sizeof where, "%s:%d", EVIDENCE_CASES, number);
        status = limits_count(where, size ? line : "", size, &values, err);
        all += status == OST_OK ? values : 0;
        if (all > LIMIT_ALL_VALUES)
            status = ost_fail(err, OST_ERR_INPUT, "%s: the lines up to here have more than %d values", where,
                              LIMIT_ALL_VALUES);
        if (status == OST_OK)
            status = limits_parse(where, size ? line : "", size, &row, err);
        if (status == OST_OK && !json_is_object(row))
            status = ost_fail(err, OST_ERR_INPUT, "%s: is no JSON object", where);
        if (status == OST_OK && !with_leaves && (status = check_written(row, where, line, size, err)) == OST_OK)
            drop_leaves(row);
        if (status == OST_OK && json_array_append(out, row) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", where);
        json_decref(row);
    }
    free(line);
    return status;
}

ost_status evidence_read_cases(const char *folder, bool with_leaves, json_t **out, ost_error *err)
{
    ost_file file;
    *out = NULL;
    ost_status status = folder_open(folder, EVIDENCE_CASES, &file, err);
    if (status != OST_OK)
        return status;
    FILE *stream = fdopen(file.fd, "r");
    json_t *list = json_array();
    if (!stream || !list)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for " EVIDENCE_CASES);
    else
        status = read_lines(stream, with_leaves, list, err);
    if (stream)
        fclose(stream);
    else
        close(file.fd);
    if (status == OST_OK)
        *out = list;
    else
        json_decref(list);
    return status;
}

ost_status evidence_read(const char *folder, json_t **protocol, json_t **cases, ost_error *err)
{
    *cases = NULL;
    ost_status status = bundle_read_json(folder, EVIDENCE_PROTOCOL, protocol, err);
    if (status == OST_OK)
        status = evidence_check_format(folder, *protocol, err);
    if (status == OST_OK && (status = evidence_read_cases(folder, true, cases, err)) != OST_OK)
        ost_fail_context(err, "%s", folder);
    if (status != OST_OK) {
        json_decref(*protocol);
        *protocol = NULL;
    }
    return status;
}
