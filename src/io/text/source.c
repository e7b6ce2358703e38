/* SPDX-License-Identifier: Apache-2.0 */
/* Reads a CT text as rows. The source can be rewound. */
#include "io/text/scan.h"

ost_status ost_text_source_open(ost_text_source *source, const char *path, ost_error *err)
{
    *source = (ost_text_source){.parser = {.path = path}};
    return ost_text_lines_open(path, &source->lines, err);
}

ost_status ost_text_source_next(ost_text_source *source, ost_text_row *rows, size_t capacity, size_t *count,
                                ost_error *err)
{
    *count = 0;
    while (*count == 0) {
        if (source->block.begin == source->block.end) {
            ost_status status = ost_text_lines_next(source->lines, source->parser.line + 1, &source->block, err);
            if (status != OST_OK || source->block.begin == source->block.end)
                return status;
        }
        ost_status status = ost_text_parse(&source->parser, &source->block, rows, capacity, count, err);
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

ost_status ost_text_source_rewind(ost_text_source *source, ost_error *err)
{
    source->block = (ost_text_block){NULL, NULL};
    source->parser.line = 0;
    source->parser.past_header = false;
    source->parser.fact = NULL;
    return ost_text_lines_rewind(source->lines, err);
}

void ost_text_source_close(ost_text_source *source)
{
    ost_text_lines_close(source->lines);
    source->lines = NULL;
}

void ost_text_fingerprint_add(ost_text_fingerprint *fingerprint, const ost_text_row *rows, size_t count)
{
    uint64_t hash = fingerprint->hash;
    for (size_t i = 0; i < count; i++) {
        const ost_text_row *row = &rows[i];
        uint64_t mixed = (uint64_t)row->position[0] * UINT64_C(0x9e3779b97f4a7c15) +
                         (uint64_t)row->position[1] * UINT64_C(0xbf58476d1ce4e5b9) +
                         (uint64_t)row->position[2] * UINT64_C(0x94d049bb133111eb) +
                         (uint64_t)row->density * UINT64_C(0xd6e8feb86659fd93);
        hash = (hash ^ mixed ^ mixed >> 32) * UINT64_C(0xd1342543de82ef95);
        hash ^= hash >> 29;
    }
    fingerprint->hash = hash;
    fingerprint->rows += count;
}
