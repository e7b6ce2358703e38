/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes the files snap-N.json and steps-N.json of a dump. They contain the steps, which are the
 * computations that precede the voxels. The members of the files are the words of the records in
 * steps_record.h.
 *
 *   file --dump_read_steps--> words --dump_write_steps--> file
 *
 * The files do not contain the box of a pose, because docs/spec/arithmetic.md
 * prescribes no box (AR-REM-5). The words of the box are copied from the
 * reference's record.
 */
#include "validation/dump/parts.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/file.h"
#include "validation/steps_record.h"

enum {
    MESH_WORDS = 15, /* number of words of one mesh in a snap record: 11 numbers and a digest of 4 words */
    MESH_DIGEST = 11,
    TICK_WORDS = 11,
    POSE_WORDS = 61,
    BOX_WORDS = 7, /* number of words for `reaches` (1) and the box (6), at the end of a pose */
    BITS_OF_COORDINATE = 21,
    BYTES_MAX = 1 << 26
};

/* ---------------------------------------------------------- values of members */

/* A file and its reader. `err` describes the first error. After this error, all functions that read members
   return false. */
typedef struct reader {
    const char *path;
    trace_writer *w;
    ost_error *err;
} reader;

static bool expect(reader *r, bool holds, const char *member, const char *expected)
{
    if (!holds)
        ost_fail(r->err, OST_ERR_INPUT, "%s: \"%s\" must be %s; see docs/spec/dumps.md", r->path, member, expected);
    return holds;
}

static bool put_int(reader *r, const json_t *value, const char *member)
{
    if (!expect(r, json_is_integer(value), member, "an integer"))
        return false;
    trace_word(r->w, (uint64_t)json_integer_value(value));
    return true;
}

static bool put_ints(reader *r, const json_t *array, size_t count, const char *member)
{
    char text[64];
    snprintf(text, sizeof text, "an array of %zu integers", count);
    if (!expect(r, json_is_array(array) && json_array_size(array) == count, member, text))
        return false;
    for (size_t i = 0; i < count; i++)
        if (!put_int(r, json_array_get(array, i), member))
            return false;
    return true;
}

/* Reads a 128-bit integer, written as a decimal in quotes, and stores it as two words. */
static bool put_wide(reader *r, const json_t *value, const char *member)
{
    static const char expected[] = "a decimal of at most 126 bits in quotes, as in \"-12\"";
    const char *text = json_string_value(value);
    const bool negative = text && text[0] == '-';
    __extension__ unsigned __int128 sum = 0;
    size_t i = negative;
    for (; text && text[i] >= '0' && text[i] <= '9' && i < 40; i++) {
        if (sum >> 122) /* the next step computes ten times the sum, which must stay below 2^126 */
            break;
        sum = 10 * sum + (unsigned)(text[i] - '0');
    }
    if (!expect(r, text && i > (size_t)negative && !text[i], member, expected))
        return false;
    if (negative)
        sum = -sum;
    trace_word(r->w, (uint64_t)sum);
    trace_word(r->w, (uint64_t)(sum >> 64));
    return true;
}

static bool put_wides(reader *r, const json_t *array, const char *member)
{
    if (!expect(r, json_is_array(array) && json_array_size(array) == 3, member, "an array of 3 decimals in quotes"))
        return false;
    for (size_t i = 0; i < 3; i++)
        if (!put_wide(r, json_array_get(array, i), member))
            return false;
    return true;
}

static json_t *ints(const uint8_t *words, size_t first, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, json_integer((json_int_t)trace_word_at(words, first + i)));
    return array;
}

static json_t *wide_text(const uint8_t *words, size_t first)
{
    char text[44], *at = text + sizeof text - 1;
    __extension__ unsigned __int128 rest =
        (unsigned __int128)trace_word_at(words, first + 1) << 64 | trace_word_at(words, first);
    const bool negative = rest >> 127;
    if (negative)
        rest = -rest;
    *at = 0;
    do
        *--at = (char)('0' + (int)(rest % 10));
    while ((rest /= 10) != 0);
    if (negative)
        *--at = '-';
    return json_string(at);
}

static json_t *wides(const uint8_t *words, size_t first)
{
    return json_pack("[o,o,o]", wide_text(words, first), wide_text(words, first + 2), wide_text(words, first + 4));
}

/* ------------------------------------------------------------------- snap-N */

/* Parses 64 lower-case hexadecimal digits. */
static bool digest_of(const char *hex, ost_digest *out)
{
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < 2 * sizeof out->bytes; i++) {
        const char *digit = hex && hex[i] ? strchr(digits, hex[i]) : NULL;
        if (!digit)
            return false;
        out->bytes[i / 2] = (uint8_t)(out->bytes[i / 2] << 4 | (digit - digits));
    }
    return !hex[2 * sizeof out->bytes];
}

static bool read_mesh(reader *r, const json_t *mesh)
{
    static const char *const counts[] = {"fraction_bits", "vertices", "triangles", "dropped_triangles"};
    ost_digest digest = {{0}};
    if (!put_ints(r, json_object_get(mesh, "dims"), 3, "dims") ||
        !put_int(r, json_object_get(mesh, "voxel_pm"), "voxel_pm") ||
        !put_ints(r, json_object_get(mesh, "corner_pm"), 3, "corner_pm"))
        return false;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
        if (!put_int(r, json_object_get(mesh, counts[i]), counts[i]))
            return false;
    if (!expect(r, digest_of(json_string_value(json_object_get(mesh, "sha256")), &digest), "sha256",
                "the digest of AR-DIG-7, 64 hexadecimal digits"))
        return false;
    for (size_t i = 0; i < sizeof digest.bytes; i += 8) {
        uint64_t word;
        memcpy(&word, digest.bytes + i, 8);
        trace_word(r->w, word);
    }
    return true;
}

static bool read_snap(reader *r, const json_t *o, const uint8_t *ref)
{
    const json_t *meshes = json_object_get(o, "meshes"), *vertices = json_object_get(o, "vertices");
    const size_t count = json_array_size(meshes);
    if (!expect(r, count == 1 || count == 2, "meshes", "an array of one or two meshes") ||
        !expect(r, json_is_array(vertices), "vertices", "an array of vertices") ||
        !read_mesh(r, json_array_get(meshes, 0)) || (count == 2 && !read_mesh(r, json_array_get(meshes, 1))))
        return false;
    /* If only the file lacks a second mesh, the words of this mesh are 0. If the reference lacks it too, they
       are copied from the reference. */
    const bool none = trace_word_at(ref, MESH_WORDS + 9) == 0;
    for (size_t i = MESH_WORDS; i < 2 * MESH_WORDS && count == 1; i++)
        trace_word(r->w, none ? trace_word_at(ref, i) : 0);
    for (size_t v = 0; v < json_array_size(vertices); v++) {
        const json_t *vertex = json_array_get(vertices, v);
        uint64_t word = 0;
        for (size_t a = 0; a < 3; a++) {
            const json_t *value = json_array_get(vertex, a);
            if (!expect(r, json_array_size(vertex) == 3 && json_is_integer(value) && json_integer_value(value) >= 0 &&
                               json_integer_value(value) <= 1 << 20,
                        "vertices", "three integers each, from 0 to 2^20"))
                return false;
            word |= (uint64_t)json_integer_value(value) << (BITS_OF_COORDINATE * (int)a);
        }
        trace_word(r->w, word);
    }
    return true;
}

static json_t *mesh_json(const uint8_t *words, size_t first)
{
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    for (size_t i = 0; i < sizeof digest.bytes; i += 8) {
        const uint64_t word = trace_word_at(words, first + MESH_DIGEST + i / 8);
        memcpy(digest.bytes + i, &word, 8);
    }
    ost_digest_hex(&digest, hex);
    return json_pack("{s:o,s:I,s:o,s:I,s:I,s:I,s:I,s:s}", "dims", ints(words, first, 3), "voxel_pm",
                     (json_int_t)trace_word_at(words, first + 3), "corner_pm", ints(words, first + 4, 3),
                     "fraction_bits", (json_int_t)trace_word_at(words, first + 7), "vertices",
                     (json_int_t)trace_word_at(words, first + 8), "triangles",
                     (json_int_t)trace_word_at(words, first + 9), "dropped_triangles",
                     (json_int_t)trace_word_at(words, first + 10), "sha256", hex);
}

static json_t *snap_json(const uint8_t *words, uint64_t count)
{
    const uint64_t mask = (1 << BITS_OF_COORDINATE) - 1;
    json_t *meshes = json_array(), *vertices = json_array();
    json_array_append_new(meshes, mesh_json(words, 0));
    if (trace_word_at(words, MESH_WORDS + 9))
        json_array_append_new(meshes, mesh_json(words, MESH_WORDS));
    for (uint64_t i = 2 * MESH_WORDS; i < count; i++) {
        const uint64_t v = trace_word_at(words, i);
        json_array_append_new(vertices,
                              json_pack("[I,I,I]", (json_int_t)(v & mask), (json_int_t)(v >> BITS_OF_COORDINATE & mask),
                                        (json_int_t)(v >> 2 * BITS_OF_COORDINATE)));
    }
    return json_pack("{s:o,s:o}", "meshes", meshes, "vertices", vertices);
}

/* ------------------------------------------------------------------ steps-N */

static bool read_pose(reader *r, const json_t *pose, const uint8_t *box)
{
    const json_t *column = json_object_get(pose, "column"), *step = json_object_get(pose, "step"),
                 *base = json_object_get(pose, "base");
    if (!put_ints(r, json_object_get(pose, "pose"), 7, "pose") ||
        !put_wide(r, json_object_get(pose, "divisor"), "divisor") ||
        !put_wides(r, json_object_get(pose, "origin"), "origin"))
        return false;
    if (!expect(r, json_array_size(column) == 3, "column", "three arrays of 3 decimals") ||
        !expect(r, json_array_size(step) == 3, "step", "three arrays of 3 integers") ||
        !expect(r, json_array_size(base) == 3, "base", "an array of three bases, null for a far block"))
        return false;
    for (size_t b = 0; b < 3; b++)
        if (!put_wides(r, json_array_get(column, b), "column"))
            return false;
    for (size_t b = 0; b < 3; b++)
        if (!put_ints(r, json_array_get(step, b), 3, "step"))
            return false;
    for (size_t k = 0; k < 3; k++) {
        const json_t *one = json_array_get(base, k);
        trace_word(r->w, !json_is_null(one));
        if (!json_is_null(one) && !put_ints(r, one, 3, "base"))
            return false;
        for (int a = 0; a < 3 && json_is_null(one); a++)
            trace_word(r->w, 0);
    }
    for (size_t i = 0; i < BOX_WORDS; i++)
        trace_word(r->w, box ? trace_word_at(box, i) : 0);
    return true;
}

static bool read_tick(reader *r, const json_t *o, const uint8_t *ref, uint64_t ref_count)
{
    const json_t *refused = json_object_get(o, "refused"), *removal = json_object_get(o, "removal"),
                 *poses = json_object_get(o, "poses");
    if (!expect(r, json_is_boolean(refused), "refused", "true or false") ||
        !expect(r, json_is_boolean(removal), "removal", "true or false") ||
        !expect(r, json_is_array(poses) && json_array_size(poses) <= OST_SWEEP_MAX, "poses",
                "an array of the event's poses"))
        return false;
    trace_word(r->w, json_is_true(refused) ? 2 : json_is_true(removal));
    trace_word(r->w, json_array_size(poses));
    if (!put_int(r, json_object_get(o, "t_ns"), "t_ns") || !put_int(r, json_object_get(o, "rpm"), "rpm") ||
        !put_ints(r, json_object_get(o, "pose"), 7, "pose"))
        return false;
    for (size_t k = 0; k < json_array_size(poses); k++) {
        const uint64_t box = TICK_WORDS + (k + 1) * POSE_WORDS - BOX_WORDS;
        if (!read_pose(r, json_array_get(poses, k), box + BOX_WORDS <= ref_count ? ref + 8 * box : NULL))
            return false;
    }
    return true;
}

static json_t *pose_json(const uint8_t *words, size_t first)
{
    json_t *column = json_array(), *step = json_array(), *base = json_array();
    for (size_t b = 0; b < 3; b++) {
        json_array_append_new(column, wides(words, first + 15 + 6 * b));
        json_array_append_new(step, ints(words, first + 33 + 3 * b, 3));
        json_array_append_new(base, trace_word_at(words, first + 42 + 4 * b) ? ints(words, first + 43 + 4 * b, 3)
                                                                             : json_null());
    }
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "pose", ints(words, first, 7), "divisor",
                     wide_text(words, first + 7), "origin", wides(words, first + 9), "column", column, "step", step,
                     "base", base);
}

static json_t *tick_json(const uint8_t *words)
{
    const uint64_t event = trace_word_at(words, 0), count = trace_word_at(words, 1);
    json_t *poses = json_array();
    for (uint64_t k = 0; k < count; k++)
        json_array_append_new(poses, pose_json(words, TICK_WORDS + k * POSE_WORDS));
    return json_pack("{s:b,s:b,s:I,s:I,s:o,s:o}", "refused", event == 2, "removal", event == 1, "t_ns",
                     (json_int_t)trace_word_at(words, 2), "rpm", (json_int_t)trace_word_at(words, 3), "pose",
                     ints(words, 4, 7), "poses", poses);
}

/* -------------------------------------------------------------------- files */

static ost_status name_of(char path[DUMP_PATH], const char *folder, const trace_record *record, ost_error *err)
{
    char name[40], file[64];
    dump_stage_name(record, name);
    snprintf(file, sizeof file, "%s.json", name);
    return dump_join(path, folder, file, err);
}

ost_status dump_read_steps(const char *folder, const trace_record *ref, trace_writer *w, bool *there, ost_error *err)
{
    char path[DUMP_PATH], *bytes;
    size_t size;
    uint64_t count;
    const uint8_t *words;
    bool absent;
    json_error_t where;
    *there = false;
    ost_status status = name_of(path, folder, ref, err);
    /* The record has no words if a tool's mesh before snapping is not available. Then nothing is compared. */
    if (status != OST_OK || access(path, F_OK) != 0 || !trace_words(ref, &count, &words) || !count)
        return status;
    status = ost_file_read(path, BYTES_MAX, &bytes, &size, &absent, err);
    if (status != OST_OK)
        return status;
    json_t *o = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, &where);
    free(bytes);
    if (!o)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s", path, where.line, where.text);
    reader r = {.path = path, .w = w, .err = err};
    *there = true;
    const bool good = ref->stage == TRACE_SNAP ? read_snap(&r, o, words) : read_tick(&r, o, words, count);
    json_decref(o);
    return good ? OST_OK : OST_ERR_INPUT;
}

ost_status dump_write_steps(const char *folder, const trace_record *record, ost_error *err)
{
    char path[DUMP_PATH];
    uint64_t count;
    const uint8_t *words;
    const ost_status status = name_of(path, folder, record, err);
    if (status != OST_OK || !trace_words(record, &count, &words) || !count)
        return status;
    json_t *o = record->stage == TRACE_SNAP ? snap_json(words, count) : tick_json(words);
    if (!o)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", path);
    const bool written = json_dump_file(o, path, JSON_PRESERVE_ORDER) == 0;
    json_decref(o);
    return written ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
}
