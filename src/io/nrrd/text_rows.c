/* SPDX-License-Identifier: Apache-2.0 */
#include "io/nrrd/text_rows.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/conditions.h"

enum { WORD_MAX = 400 };

static bool is_blank(int byte)
{
    return byte == ' ' || byte == '\t' || byte == '\n' || byte == '\r' || byte == '\v' || byte == '\f';
}

/* Reads the next word. At the end of the file, the word is "". */
static ost_status read_word(ost_input *input, char word[WORD_MAX + 1], size_t *length, ost_error *err)
{
    int byte;
    ost_status status;
    *length = 0;
    do {
        status = ost_input_byte(input, &byte, err);
    } while (status == OST_OK && is_blank(byte));
    while (status == OST_OK && byte >= 0 && !is_blank(byte)) {
        if (*length == WORD_MAX || byte == 0) {
            char location[OST_LOCATION_TEXT];
            return ost_fail(err, OST_ERR_INPUT, "%s: at %s: not a number; expected decimals separated by blanks",
                            ost_input_path(input), ost_input_location(input, *length + 1, location));
        }
        word[(*length)++] = (char)byte;
        status = ost_input_byte(input, &byte, err);
    }
    word[*length] = 0;
    return status;
}

/* Returns true if a word is NaN as programs print it: nan in any case, with or without a sign. */
static bool is_nan(const char *word)
{
    return strcasecmp(word + (*word == '-' || *word == '+'), "nan") == 0;
}

/* Returns true if the value of the decimal is an integer within the range of the type (AR-FILE-4). */
static bool type_holds(ost_element element, const ost_decimal *d)
{
    uint64_t magnitude;
    if (ost_element_is_float(element))
        return true;
    if (!ost_decimal_integer(d, &magnitude))
        return false;
    bool is_signed = element == OST_ELEMENT_INT8 || element == OST_ELEMENT_INT16 || element == OST_ELEMENT_INT32 ||
                     element == OST_ELEMENT_INT64;
    uint64_t most = UINT64_MAX >> (64 - 8 * ost_element_bytes(element) + is_signed);
    return d->negative ? magnitude <= (is_signed ? most + 1 : 0) : magnitude <= most;
}

static ost_status read_value(ost_rows *rows, int64_t number, int16_t *out, ost_error *err)
{
    ost_input *input = rows->parts->input;
    ost_converter *c = &rows->converter;
    char word[WORD_MAX + 1], location[OST_LOCATION_TEXT];
    size_t length;
    ost_status status = read_word(input, word, &length, err);
    if (status != OST_OK)
        return status;
    /* The byte after the word has already been read, unless the word ends the file. */
    ost_input_location(input, length + (ost_input_file_left(input) > 0 || length == 0), location);
    if (length == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: ends after %lld of the %lld values that the header's sizes need",
                        ost_input_path(input), (long long)number,
                        (long long)rows->sizes[0] * rows->sizes[1] * rows->sizes[2]);
    ost_decimal d;
    ost_bad bad = {OST_BAD_NAN, ""};
    snprintf(bad.value, sizeof bad.value, "%.30s", word);
    if (ost_decimal_read(word, word + length, &d) != word + length) {
        if (!is_nan(word) || !ost_element_is_float(c->element))
            bad.kind = OST_BAD_INFINITE;
        else if (c->nan_as_air) {
            c->nan++;
            *out = OST_AIR;
            return OST_OK;
        }
        return ost_rows_bad(rows, number, ost_input_path(input), location, &bad, err);
    }
    int64_t value;
    bool exact = true;
    bool fits = ost_decimal_scale(&d, 1, &value, &exact);
    if (!type_holds(c->element, &d))
        return ost_fail(err, OST_ERR_INPUT, "%s: at %s: %.30s is not a value of type %s", ost_input_path(input),
                        location, word, ost_element_name(c->element));
    if (!fits || value < INT16_MIN || value > INT16_MAX) {
        bad.kind = OST_BAD_RANGE;
        if (!c->clamp)
            return ost_rows_bad(rows, number, ost_input_path(input), location, &bad, err);
        value = (fits ? value < 0 : d.negative) ? INT16_MIN : INT16_MAX;
        c->clamped++;
        exact = true;
    }
    c->rounded += !exact;
    *out = (int16_t)value;
    return OST_OK;
}

/* Must be called after the last value of a part. Returns an error if anything but blanks follows. */
static ost_status end_part(ost_nrrd_text_rows *own, ost_error *err)
{
    ost_input *input = own->rows.parts->input;
    if (!input)
        return OST_OK;
    char word[WORD_MAX + 1];
    size_t length;
    ost_status status = read_word(input, word, &length, err);
    if (status == OST_OK && length > 0)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: unexpected value '%.30s' after the last one that the header's sizes need",
                          ost_input_path(input), word);
    ost_parts_close(own->rows.parts);
    return status;
}

ost_status ost_nrrd_text_rows_next(ost_rows *rows, int64_t first, int16_t *out, ost_error *err)
{
    ost_nrrd_text_rows *own = (ost_nrrd_text_rows *)rows;
    for (int32_t i = 0; i < rows->sizes[0]; i++) {
        ost_status status = OST_OK;
        if (rows->parts->input && own->left == 0)
            status = end_part(own, err);
        if (status == OST_OK && !rows->parts->input) {
            status = ost_parts_ready(rows->parts, err);
            own->left = own->in_part;
        }
        if (status == OST_OK)
            status = read_value(rows, first + i, &out[i], err);
        if (status != OST_OK)
            return status;
        own->left--;
    }
    /* Blanks may follow the last value of the last part. They must be skipped here, because ost_parts_end would refuse
     * them. */
    return own->left == 0 ? end_part(own, err) : OST_OK;
}
