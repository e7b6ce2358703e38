// SPDX-License-Identifier: Apache-2.0
#include "series.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

std::vector<std::string> split(const std::string &text, char at)
{
    std::vector<std::string> parts;
    size_t from = 0;
    for (size_t to; (to = text.find(at, from)) != std::string::npos; from = to + 1)
        parts.push_back(text.substr(from, to - from));
    parts.push_back(text.substr(from));
    return parts;
}

bool read_number(const std::string &text, double *out)
{
    char *end;
    *out = std::strtod(text.c_str(), &end);
    return !text.empty() && *end == 0 && std::isfinite(*out);
}

bool read_numbers(const std::string &text, std::vector<double> *out)
{
    out->clear();
    for (const std::string &part : split(text, ',')) {
        double v;
        if (!read_number(part, &v))
            return false;
        out->push_back(v);
    }
    return true;
}

bool set_doubles(const std::string &text, double *out, size_t count)
{
    std::vector<double> v;
    if (!read_numbers(text, &v) || v.size() != count)
        return false;
    std::copy(v.begin(), v.end(), out);
    return true;
}

bool set_ints(const std::string &text, int *out, size_t count)
{
    std::vector<double> v;
    if (!read_numbers(text, &v) || v.size() != count)
        return false;
    std::transform(v.begin(), v.end(), out, [](double d) { return static_cast<int>(d); });
    return true;
}

bool set_flag(const std::string &text, bool *out)
{
    *out = text == "1";
    return text == "0" || text == "1";
}

// Returns true if the value of this key describes a change of one slice ("K:TEXT") or of every slice ("*:TEXT").
bool is_change(const std::string &key)
{
    static const char *const keys[] = {"drop", "double", "move", "size", "shift", "set", "remove", "cut",
                                       "replace", "append", "bomb", "flip"};
    return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
}

bool add_change(const std::string &key, const std::string &value, series *s)
{
    const size_t colon = value.find(':');
    const std::string slice = value.substr(0, colon);
    double k = EVERY_SLICE;
    if (slice != "*" && !read_number(slice, &k))
        return false;
    s->changes.push_back({key, static_cast<int>(k), colon == std::string::npos ? "" : value.substr(colon + 1)});
    return true;
}

bool set_word(const std::string &key, const std::string &value, series *s)
{
    if (is_change(key))
        return add_change(key, value, s);
    if (key == "dims")
        return set_ints(value, s->dims, 3);
    if (key == "spacing")
        return set_doubles(value, s->spacing, 3);
    if (key == "origin")
        return set_doubles(value, s->origin, 3);
    if (key == "rows")
        return set_doubles(value, s->rows, 3);
    if (key == "columns")
        return set_doubles(value, s->columns, 3);
    if (key == "tilt")
        return set_doubles(value, &s->tilt, 1);
    if (key == "thickness")
        return set_doubles(value, &s->thickness, 1);
    if (key == "bits")
        return set_ints(value, &s->bits, 1);
    if (key == "allocated")
        return set_ints(value, &s->allocated, 1) && (s->allocated == 8 || s->allocated == 16);
    if (key == "high")
        return set_ints(value, &s->high, 1);
    if (key == "signed")
        return set_flag(value, &s->is_signed);
    if (key == "junk")
        return set_flag(value, &s->junk);
    if (key == "values")
        return set_ints(value, s->values, 2);
    if (key == "smooth")
        return set_ints(value, &s->smooth, 1);
    if (key == "padding") {
        s->padding.resize(split(value, ',').size());
        return set_ints(value, s->padding.data(), s->padding.size());
    }
    if (key == "fragment")
        return set_ints(value, &s->fragment, 1);
    if (key == "offsets")
        return set_flag(value, &s->offsets);
    if (key == "multiframe")
        return set_flag(value, &s->multiframe);
    if (key == "number")
        return set_ints(value, &s->number, 1);
    if (key == "study")
        return set_ints(value, &s->study, 1);
    if (key == "patient")
        return set_ints(value, &s->patient, 1);
    if (key == "frame")
        return set_ints(value, &s->frame, 1);
    if (key == "slope" || key == "intercept") {
        (key == "slope" ? s->slope : s->intercept) = split(value, ',');
        return true;
    }
    std::string *const text = key == "syntax"        ? &s->syntax
                              : key == "description" ? &s->description
                              : key == "modality"    ? &s->modality
                              : key == "kernel"      ? &s->kernel
                              : key == "prefix"      ? &s->prefix
                              : key == "photometric" ? &s->photometric
                                                     : nullptr;
    if (text)
        *text = value;
    return text != nullptr;
}

// Returns the last change of a slice with this key, or NULL.
const change *find_change(const series &s, const char *key, int k)
{
    const change *found = nullptr;
    for (const change &c : s.changes)
        if (c.key == key && (c.slice == k || c.slice == EVERY_SLICE))
            found = &c;
    return found;
}

} // namespace

bool read_words(int count, char *const *words, series *out, std::string *error)
{
    for (int w = 0; w < count; w++) {
        const std::string word = words[w];
        const size_t equals = word.find('=');
        if (equals == std::string::npos || !set_word(word.substr(0, equals), word.substr(equals + 1), out)) {
            *error = "'" + word + "' is no KEY=VALUE of tests/dicom/series.h";
            return false;
        }
    }
    if (out->high == 0)
        out->high = out->bits - 1;
    if (out->thickness == 0)
        out->thickness = out->spacing[2];
    return true;
}

std::vector<slice> plan_slices(const series &s)
{
    const double *r = s.rows, *c = s.columns;
    const double normal[3] = {r[1] * c[2] - r[2] * c[1], r[2] * c[0] - r[0] * c[2], r[0] * c[1] - r[1] * c[0]};
    std::vector<slice> slices;
    for (int k = 0; k < s.dims[2]; k++) {
        if (find_change(s, "drop", k))
            continue;
        slice at = {k, {0, 0, 0}, (1741 * k + 5) % 4096, "", 0, {s.dims[0], s.dims[1]}};
        at.file = s.prefix + std::to_string(at.instance);
        double along = k * s.spacing[2], shift[3] = {0, 0, 0};
        if (const change *move = find_change(s, "move", k))
            along += std::atof(move->text.c_str());
        if (const change *moved = find_change(s, "shift", k))
            set_doubles(moved->text, shift, 3);
        if (const change *size = find_change(s, "size", k))
            set_ints(size->text, at.size, 2);
        for (int a = 0; a < 3; a++)
            at.position[a] = s.origin[a] + along * normal[a] + k * s.tilt * c[a] + shift[a];
        slices.push_back(at);
        if (const change *again = find_change(s, "double", k)) {
            at.file += "B";
            at.delta = std::atoi(again->text.c_str());
            slices.push_back(at);
        }
    }
    std::stable_sort(slices.begin(), slices.end(),
                     [](const slice &a, const slice &b) { return a.instance < b.instance; });
    return slices;
}

std::vector<uint8_t> make_pixels(const series &s, const slice &at)
{
    const int unused = s.high + 1 - s.bits; // number of unused bits below the stored bits
    const uint32_t stored = ((1u << s.bits) - 1) << unused;
    const int64_t range = int64_t(s.values[1]) - s.values[0] + 1;
    std::vector<uint8_t> bytes;
    for (int j = 0; j < at.size[1]; j++) {
        for (int i = 0; i < at.size[0]; i++) {
            const int64_t k = at.index;
            int64_t v = s.values[0] + (13 * i + 1009 * j + 30011 * k + 7 * i * j * k) % range;
            if (s.smooth)
                v = s.values[0] + s.smooth * (i + j + k);
            if (i < static_cast<int>(s.padding.size()))
                v = s.padding[i];
            // A negative value is sign-extended, as in the files of scanners.
            uint32_t pixel = static_cast<uint32_t>(v + at.delta) << unused;
            if (s.junk)
                pixel ^= ~stored;
            bytes.push_back(static_cast<uint8_t>(pixel));
            if (s.allocated == 16)
                bytes.push_back(static_cast<uint8_t>(pixel >> 8));
        }
    }
    return bytes;
}

std::string decimal(double mm)
{
    char text[64];
    snprintf(text, sizeof text, "%.6f", mm);
    std::string trimmed = text;
    trimmed.erase(trimmed.find_last_not_of('0') + 1);
    if (trimmed.back() == '.')
        trimmed.pop_back();
    return trimmed == "-0" ? "0" : trimmed;
}
