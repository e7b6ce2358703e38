/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks PLY files: a header that describes the layout of the body, and the body.
 *
 *   ply
 *   format ascii 1.0 | binary_little_endian 1.0 | binary_big_endian 1.0
 *   element NAME COUNT
 *   property TYPE NAME | property list TYPE TYPE NAME
 *   end_header
 *
 * The body is read value by value.  assimp receives a plain PLY that contains only
 * the x, y, z of the vertices, copied verbatim, and the faces as fans of triangles.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "io/mesh/input.h"

enum { ELEMENTS_MAX = 16, PROPERTIES_MAX = 64 };
enum { ASCII, LITTLE, BIG };
enum { OTHER, VERTEX, FACE };

typedef enum value_type { NO_TYPE, INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64 } value_type;

static const struct {
    const char *name;
    value_type type;
} type_names[] = {
    {"char", INT8},   {"uchar", UINT8},   {"short", INT16},     {"ushort", UINT16},
    {"int", INT32},   {"uint", UINT32},   {"float", FLOAT32},   {"double", FLOAT64},
    {"int8", INT8},   {"uint8", UINT8},   {"int16", INT16},     {"uint16", UINT16},
    {"int32", INT32}, {"uint32", UINT32}, {"float32", FLOAT32}, {"float64", FLOAT64},
};

static const size_t type_bytes[] = {
    [INT8] = 1, [UINT8] = 1, [INT16] = 2, [UINT16] = 2, [INT32] = 4, [UINT32] = 4, [FLOAT32] = 4, [FLOAT64] = 8};

typedef struct property {
    value_type count_type; /* type of the count of a list; NO_TYPE for a scalar property */
    value_type type;
    int axis; /* 0 to 2 if the property is a coordinate of a vertex; otherwise -1 */
    bool corners; /* true if the property is the list of a face's vertices */
} property;

typedef struct element {
    int role;
    int64_t count;
    int property_count;
    property properties[PROPERTIES_MAX];
} element;

typedef struct ply {
    mesh_input *in;
    /* the header and, if it is ASCII, the body; text.at is the current position, also in a binary body */
    mesh_text text;
    FILE *out;
    int format;
    int element_count;
    element elements[ELEMENTS_MAX];
    int64_t vertices;
} ply;

/* A value of the file, as bytes and as a number. */
typedef struct value {
    const char *text;
    size_t size;
    /* value as a number; NAN for an ASCII word that is not an integer, because only the text of such a word is used */
    double number;
} value;

static ost_status wrong(const ply *p, mesh_word found, const char *expected, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected %s, found %s", p->text.path, p->text.line, expected,
                    ost_mesh_word_show(found));
}

/* ---------------------------------------------------------------- header */

static value_type read_type(mesh_word word)
{
    for (size_t i = 0; i < sizeof type_names / sizeof type_names[0]; i++)
        if (ost_mesh_word_is(word, type_names[i].name))
            return type_names[i].type;
    return NO_TYPE;
}

static ost_status read_format(ply *p, ost_error *err)
{
    mesh_word word = ost_mesh_text_word(&p->text);
    if (ost_mesh_word_is(word, "ascii"))
        p->format = ASCII;
    else if (ost_mesh_word_is(word, "binary_little_endian"))
        p->format = LITTLE;
    else if (ost_mesh_word_is(word, "binary_big_endian"))
        p->format = BIG;
    else
        return wrong(p, word, "ascii, binary_little_endian or binary_big_endian", err);
    return OST_OK;
}

static ost_status read_element(ply *p, ost_error *err)
{
    if (p->element_count == ELEMENTS_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: more than %d elements", p->text.path, p->text.line, ELEMENTS_MAX);
    element *e = &p->elements[p->element_count];
    mesh_word name = ost_mesh_text_word(&p->text);
    mesh_word count = ost_mesh_text_word(&p->text);
    if (!ost_mesh_word_integer(count, &e->count) || e->count < 0 || e->count > 3 * (int64_t)OST_MESH_FILE_TRIANGLES_MAX)
        return wrong(p, count, "a count of elements", err);
    e->role = ost_mesh_word_is(name, "vertex") ? VERTEX : ost_mesh_word_is(name, "face") ? FACE : OTHER;
    for (int i = 0; i < p->element_count; i++)
        if (e->role != OTHER && p->elements[i].role == e->role)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: duplicate name of an element", p->text.path, p->text.line);
    if (e->role == VERTEX)
        p->vertices = e->count;
    p->element_count++;
    return OST_OK;
}

static ost_status read_property(ply *p, ost_error *err)
{
    element *e = p->element_count ? &p->elements[p->element_count - 1] : NULL;
    if (!e || e->property_count == PROPERTIES_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: %s", p->text.path, p->text.line,
                        e ? "too many properties" : "a property before any element");
    property *q = &e->properties[e->property_count++];
    *q = (property){.axis = -1};
    mesh_word word = ost_mesh_text_word(&p->text);
    bool list = ost_mesh_word_is(word, "list");
    if (list) {
        q->count_type = read_type(word = ost_mesh_text_word(&p->text));
        if (q->count_type == NO_TYPE || q->count_type >= FLOAT32)
            return wrong(p, word, "an integer type for the count of a list", err);
        word = ost_mesh_text_word(&p->text);
    }
    q->type = read_type(word);
    if (q->type == NO_TYPE)
        return wrong(p, word, "a type (char, uchar, short, ushort, int, uint, float, double)", err);
    mesh_word name = ost_mesh_text_word(&p->text);
    if (e->role == VERTEX && !list && name.size == 1 && name.text[0] >= 'x' && name.text[0] <= 'z')
        q->axis = name.text[0] - 'x';
    if (e->role == FACE && list && q->type < FLOAT32)
        q->corners = ost_mesh_word_is(name, "vertex_indices") || ost_mesh_word_is(name, "vertex_index");
    return OST_OK;
}

/*
 * Checks the layout: a vertex has exactly one x, one y and one z, all of float types; the vertices precede the faces;
 * and a face has exactly one list of vertices.
 */
static ost_status check_layout(const ply *p, ost_error *err)
{
    int axes[3] = {0}, lists = 0, faces_before_vertices = 0;
    bool vertices = false;
    for (int i = 0; i < p->element_count; i++) {
        const element *e = &p->elements[i];
        for (int k = 0; k < e->property_count; k++) {
            if (e->properties[k].axis >= 0)
                axes[e->properties[k].axis] += e->properties[k].type >= FLOAT32 ? 1 : 2;
            lists += e->properties[k].corners;
        }
        vertices |= e->role == VERTEX;
        faces_before_vertices += e->role == FACE && !vertices;
    }
    if (axes[0] != 1 || axes[1] != 1 || axes[2] != 1)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: the header has no element vertex with one x, y and z each of type float or "
                        "double",
                        p->in->path);
    if (lists != 1 || faces_before_vertices)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: the header has no element face, after vertex, with one list vertex_indices%s",
                        p->in->path, lists == 0 ? " (a cloud of points has no inside)" : "");
    return OST_OK;
}

static ost_status read_header(ply *p, ost_error *err)
{
    ost_status status = OST_OK;
    bool format = false;
    for (;;) {
        if (status != OST_OK)
            return status;
        if (!ost_mesh_text_next_line(&p->text))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: the header has no end_header", p->text.path, p->text.line);
        mesh_word word = ost_mesh_text_word(&p->text);
        if (ost_mesh_word_is(word, "format")) {
            status = read_format(p, err);
            format = true;
        } else if (ost_mesh_word_is(word, "element")) {
            status = read_element(p, err);
        } else if (ost_mesh_word_is(word, "property")) {
            status = read_property(p, err);
        } else if (ost_mesh_word_is(word, "end_header")) {
            break;
        } else if (!ost_mesh_word_is(word, "comment") && !ost_mesh_word_is(word, "obj_info")) {
            return wrong(p, word, "format, element, property, comment or end_header", err);
        }
    }
    if (!format)
        return ost_fail(err, OST_ERR_INPUT, "%s: the header has no format", p->text.path);
    ost_mesh_text_next_line(&p->text);
    return check_layout(p, err);
}

/* ------------------------------------------------------------------ body */

static double from_bytes(const uint8_t *bytes, value_type type, bool big)
{
    uint8_t b[8] = {0};
    const size_t n = type_bytes[type];
    for (size_t i = 0; i < n; i++)
        b[i] = bytes[big ? n - 1 - i : i];
    uint64_t bits;
    float f;
    double d;
    memcpy(&bits, b, sizeof bits);
    memcpy(&f, b, sizeof f);
    memcpy(&d, b, sizeof d);
    switch (type) {
    case INT8: return (int8_t)bits;
    case INT16: return (int16_t)bits;
    case INT32: return (int32_t)bits;
    case FLOAT32: return f;
    case FLOAT64: return d;
    case UINT8:
    case UINT16:
    case UINT32:
    case NO_TYPE: break;
    }
    return (double)bits;
}

static ost_status next_value(ply *p, value_type type, value *out, ost_error *err)
{
    if (p->format != ASCII) {
        const size_t left = (size_t)(p->text.end - p->text.at);
        if (left < type_bytes[type])
            return ost_fail(err, OST_ERR_INPUT,
                            "%s: byte %zu: the file ends before the elements that its header declares", p->in->path,
                            p->in->size);
        *out = (value){p->text.at, type_bytes[type], from_bytes((uint8_t *)p->text.at, type, p->format == BIG)};
        p->text.at += type_bytes[type];
        return OST_OK;
    }
    mesh_word word = ost_mesh_text_any_word(&p->text);
    int64_t integer;
    if (!ost_mesh_word_number(word))
        return wrong(p, word, "a number", err);
    *out = (value){word.text, word.size, ost_mesh_word_integer(word, &integer) ? (double)integer : (double)NAN};
    return OST_OK;
}

static ost_status bad_value(const ply *p, int64_t index, const char *what, const char *expected, ost_error *err)
{
    if (p->format == ASCII)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: %s %lld: expected %s", p->text.path, p->text.line, what,
                        (long long)index, expected);
    return ost_fail(err, OST_ERR_INPUT, "%s: byte %zu: %s %lld: expected %s", p->in->path,
                    (size_t)(p->text.at - (char *)p->in->bytes), what, (long long)index, expected);
}

/* Writes an index in the byte order of the file. */
static void put_index(const ply *p, uint32_t index)
{
    if (p->format == ASCII) {
        fprintf(p->out, " %u", (unsigned)index);
        return;
    }
    uint32_t bytes = p->format == BIG ? __builtin_bswap32(index) : index;
    fwrite(&bytes, sizeof bytes, 1, p->out);
}

static void put_triangle(const ply *p, uint32_t a, uint32_t b, uint32_t c)
{
    putc(p->format == ASCII ? '3' : 3, p->out);
    put_index(p, a);
    put_index(p, b);
    put_index(p, c);
    if (p->format == ASCII)
        putc('\n', p->out);
}

static ost_status read_list(ply *p, const property *q, int64_t index, ost_error *err)
{
    value v;
    ost_status status = next_value(p, q->count_type, &v, err);
    if (status != OST_OK)
        return status;
    if (!(v.number >= 0))
        return bad_value(p, index, q->corners ? "face" : "element", "a count of values", err);
    /* The loop terminates, because each value takes at least 1 byte and the file's size is limited. */
    const uint64_t count = (uint64_t)v.number;
    uint32_t first = 0, last = 0;
    for (uint64_t i = 0; status == OST_OK && i < count; i++) {
        status = next_value(p, q->type, &v, err);
        if (status != OST_OK || !q->corners)
            continue;
        if (!(v.number >= 0 && v.number < (double)p->vertices)) {
            char expected[80];
            snprintf(expected, sizeof expected, "indices of vertices below %lld, the number of vertices",
                     (long long)p->vertices);
            return bad_value(p, index, "face", expected, err);
        }
        const uint32_t corner = (uint32_t)v.number;
        if (i == 0)
            first = corner;
        if (i >= 2)
            put_triangle(p, first, last, corner);
        last = corner;
    }
    return status == OST_OK && q->corners ? ost_mesh_input_face(p->in, count, err) : status;
}

static ost_status read_body_element(ply *p, const element *e, int64_t index, ost_error *err)
{
    value axes[3] = {{0}};
    ost_status status = OST_OK;
    for (int k = 0; status == OST_OK && k < e->property_count; k++) {
        const property *q = &e->properties[k];
        value v;
        if (q->count_type != NO_TYPE) {
            status = read_list(p, q, index, err);
            continue;
        }
        status = next_value(p, q->type, &v, err);
        if (status == OST_OK && q->axis >= 0) {
            if (p->format != ASCII && !(fabs(v.number) < 1e38))
                return bad_value(p, index, "vertex", "a finite coordinate", err);
            axes[q->axis] = v;
        }
    }
    if (status == OST_OK && e->role == VERTEX)
        for (int a = 0; a < 3; a++) {
            fwrite(axes[a].text, 1, axes[a].size, p->out);
            if (p->format == ASCII)
                putc(a == 2 ? '\n' : ' ', p->out);
        }
    return status;
}

static ost_status read_body(ply *p, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; status == OST_OK && i < p->element_count; i++) {
        const element *e = &p->elements[i];
        /* An element without properties has no data, however large its count, so it is skipped. */
        for (int64_t n = 0; status == OST_OK && e->property_count && n < e->count; n++)
            status = read_body_element(p, e, n, err);
    }
    if (status == OST_OK && p->in->triangles == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file has no face", p->in->path);
    return status;
}

/* Writes the plain header. Must be called after the triangles have been counted. */
static void put_header(const ply *p, FILE *out)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const char *types[3] = {"float", "float", "float"};
    for (int i = 0; i < p->element_count; i++)
        for (int k = 0; k < p->elements[i].property_count; k++)
            if (p->elements[i].properties[k].axis >= 0 && p->elements[i].properties[k].type == FLOAT64)
                types[p->elements[i].properties[k].axis] = "double";
    fprintf(out, "ply\nformat %s 1.0\nelement vertex %lld\nproperty %s x\nproperty %s y\nproperty %s z\n",
            formats[p->format], (long long)p->vertices, types[0], types[1], types[2]);
    fprintf(out, "element face %llu\nproperty list uchar uint vertex_indices\nend_header\n",
            (unsigned long long)p->in->triangles);
}

static ost_status no_memory(const mesh_input *in, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for its elements", in->path);
}

ost_status ost_mesh_check_ply(mesh_input *in, ost_error *err)
{
    ost_status status;
    mesh_plain parsed;
    ost_memory_stream body = {.bytes = NULL};
    ply *p = calloc(1, sizeof *p);
    if (!p || !(p->out = ost_memory_stream_open(&body))) {
        status = no_memory(in, err);
        goto cleanup;
    }
    p->in = in;
    p->text = (mesh_text){.path = in->path, .at = (char *)in->bytes, .end = (char *)in->bytes + in->size, .line = 1};
    status = read_header(p, err);
    if (status == OST_OK)
        status = read_body(p, err);
    if (!ost_memory_stream_close(p->out, &body) && status == OST_OK)
        status = no_memory(in, err);
    if (status == OST_OK)
        status = ost_mesh_plain_open(in, &parsed, err);
    if (status == OST_OK) {
        put_header(p, parsed.out);
        fwrite(body.bytes, 1, body.size, parsed.out);
        status = ost_mesh_plain_close(in, &parsed, status, err);
    }
cleanup:
    free(body.bytes);
    free(p);
    return status;
}
