/* SPDX-License-Identifier: Apache-2.0 */
#include "io/small_text.h"

#include <stdlib.h>
#include <string.h>

#include "io/volume/input.h"

ost_status ost_small_text_read(const char *path, size_t most, const char *contents, const char *expected, char **text,
                               size_t *size, ost_error *err)
{
    static const char mark[] = {'\xef', '\xbb', '\xbf'};
    ost_input *input;
    *text = NULL;
    *size = 0;
    ost_status status = ost_input_open(path, &input, err);
    if (status != OST_OK)
        return status;
    const uint64_t bytes = ost_input_file_bytes(input);
    if (bytes > most)
        status = ost_fail(err, OST_ERR_INPUT, "%s: %llu bytes; a file of %s has at most %zu", path,
                          (unsigned long long)bytes, contents, most);
    else if (!(*text = malloc((size_t)bytes + 1)))
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %llu bytes", path, (unsigned long long)bytes);
    if (status == OST_OK)
        status = ost_input_read(input, *text, (size_t)bytes, size, err);
    ost_input_close(input);
    if (status == OST_OK && memchr(*text, 0, *size))
        status = ost_fail(err, OST_ERR_INPUT, "%s: not a text file; expected %s", path, expected);
    if (status != OST_OK) {
        free(*text);
        *text = NULL;
        return status;
    }
    if (*size >= sizeof mark && memcmp(*text, mark, sizeof mark) == 0) {
        *size -= sizeof mark;
        memmove(*text, *text + sizeof mark, *size);
    }
    (*text)[*size] = 0;
    return OST_OK;
}

bool ost_small_text_is_json(const char *text)
{
    return text[strspn(text, " \t\r\n")] == '{';
}
