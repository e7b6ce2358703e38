/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/limits.h"

#include <stdbool.h>

ost_status limits_count(const char *where, const char *bytes, size_t size, size_t *values, ost_error *err)
{
    size_t count = 1;
    int depth = 0;
    bool text = false;
    for (size_t i = 0; i < size; i++) {
        const char c = bytes[i];
        if (text) {
            i += c == '\\';
            text = c != '"';
            continue;
        }
        text = c == '"';
        count += c == ',' || c == ':' || c == '[' || c == '{';
        depth += (c == '[' || c == '{') - (c == ']' || c == '}');
        if (depth > LIMIT_DEPTH)
            return ost_fail(err, OST_ERR_INPUT, "%s: arrays and objects are nested deeper than %d", where, LIMIT_DEPTH);
        if (count > LIMIT_VALUES)
            return ost_fail(err, OST_ERR_INPUT, "%s: has more than %d values", where, LIMIT_VALUES);
    }
    *values = count;
    return OST_OK;
}

ost_status limits_parse(const char *where, const char *bytes, size_t size, json_t **out, ost_error *err)
{
    size_t values;
    json_error_t why;
    char text[JSON_ERROR_TEXT_LENGTH];
    *out = NULL;
    const ost_status status = limits_count(where, bytes, size, &values, err);
    if (status != OST_OK)
        return status;
    *out = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, &why);
    if (*out)
        return OST_OK;
    if (json_error_code(&why) == json_error_out_of_memory)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", where);
    return ost_fail(err, OST_ERR_INPUT, "%s:%d: is not JSON: %s", where, why.line,
                    limits_printable(why.text, text, sizeof text));
}

char *limits_printable(const char *text, char out[], size_t size)
{
    size_t n = 0;
    for (; text[n] && n + 1 < size; n++)
        out[n] = (char)(text[n] >= ' ' && text[n] <= '~' ? text[n] : '?');
    out[n] = '\0';
    return out;
}
