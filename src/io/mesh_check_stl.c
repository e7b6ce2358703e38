/* SPDX-License-Identifier: Apache-2.0 */
/*
 * STL files hold what they say.
 *
 *   binary   80 bytes of anything, uint32 count, count * (12 float32, 2 bytes)
 *            A few bytes more, less than a triangle, are left out; some
 *            programs append one.  Header and attributes are zeroed: assimp
 *            would look for colours in them.
 *   ASCII    solid NAME  ( facet normal N N N  outer loop  3 x vertex N N N
 *            endloop  endfacet )*  endsolid NAME, once or several times
 *            Names and normals are blanked: nothing here reads them, and a
 *            normal may well be "nan".
 */
#include <math.h>
#include <string.h>

#include "io/mesh_input.h"

enum { HEADER = 84, RECORD = 50 };

ost_status ost_mesh_check_stl_binary(mesh_input *in, ost_error *err)
{
    if (in->size < HEADER)
        return ost_fail(err, OST_ERR_INPUT, "%s: %zu bytes are too few for an STL file: binary has at least %d, ASCII begins with 'solid'",
                        in->path, in->size, HEADER);
    uint32_t count;
    memcpy(&count, in->bytes + 80, sizeof count);
    uint64_t there = (in->size - HEADER) / RECORD;
    if (count == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 80: the file holds no triangle", in->path);
    if (count != there)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 80: says %u triangles, which take %llu bytes; the file has %zu%s", in->path,
                        (unsigned)count, (unsigned long long)count * RECORD + HEADER, in->size,
                        count > there ? " (cut off, or no STL)" : "");
    if (count > OST_MESH_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %u triangles; at most %d", in->path, (unsigned)count, OST_MESH_TRIANGLES_MAX);
    in->size = HEADER + (size_t)count * RECORD;
    in->faces = in->triangles = count;
    memset(in->bytes, 0, 80);
    for (uint32_t t = 0; t < count; t++) {
        uint8_t *record = in->bytes + HEADER + (size_t)t * RECORD;
        float corners[9];
        memset(record, 0, 12);
        memset(record + 48, 0, 2);
        memcpy(corners, record + 12, sizeof corners);
        for (int i = 0; i < 9; i++)
            if (!isfinite(corners[i]))
                return ost_fail(err, OST_ERR_INPUT, "%s: byte %zu: triangle %u has a coordinate that is %s", in->path,
                                (size_t)HEADER + (size_t)t * RECORD + 12 + 4 * (size_t)i, (unsigned)t,
                                isnan(corners[i]) ? "not a number" : "infinite");
    }
    return OST_OK;
}

static ost_status expect(mesh_text *text, const char *keyword, ost_error *err)
{
    mesh_word word = ost_mesh_text_any_word(text);
    if (!ost_mesh_word_is(word, keyword))
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected '%s', found %s", text->path, text->line, keyword, ost_mesh_word_show(word));
    memcpy(word.text, keyword, word.size); /* assimp wants small letters */
    return OST_OK;
}

static ost_status three_numbers(mesh_text *text, bool check, ost_error *err)
{
    for (int i = 0; i < 3; i++) {
        mesh_word word = ost_mesh_text_any_word(text);
        if (word.size == 0 || (check && !ost_mesh_word_number(word)))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected a number, found %s", text->path, text->line, ost_mesh_word_show(word));
        if (!check) {
            memset(word.text, ' ', word.size);
            word.text[0] = '0';
        }
    }
    return OST_OK;
}

/* Behind the word "facet". */
static ost_status facet(mesh_text *text, ost_error *err)
{
    ost_status status = expect(text, "normal", err);
    if (status == OST_OK)
        status = three_numbers(text, false, err);
    if (status == OST_OK)
        status = expect(text, "outer", err);
    if (status == OST_OK)
        status = expect(text, "loop", err);
    for (int i = 0; status == OST_OK && i < 3; i++) {
        status = expect(text, "vertex", err);
        if (status == OST_OK)
            status = three_numbers(text, true, err);
    }
    if (status == OST_OK)
        status = expect(text, "endloop", err);
    if (status == OST_OK)
        status = expect(text, "endfacet", err);
    return status;
}

static void blank_line(mesh_text *text)
{
    char *newline = text->at < text->end ? memchr(text->at, '\n', (size_t)(text->end - text->at)) : NULL;
    char *end = newline ? newline : text->end;
    memset(text->at, ' ', (size_t)(end - text->at));
    text->at = end;
}

/* Behind the word "solid". */
static ost_status solid(mesh_input *in, mesh_text *text, ost_error *err)
{
    blank_line(text);
    for (;;) {
        mesh_word word = ost_mesh_text_any_word(text);
        if (ost_mesh_word_is(word, "endsolid")) {
            memcpy(word.text, "endsolid", word.size);
            blank_line(text);
            return OST_OK;
        }
        if (!ost_mesh_word_is(word, "facet"))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected 'facet' or 'endsolid', found %s", text->path, text->line,
                            ost_mesh_word_show(word));
        memcpy(word.text, "facet", word.size);
        ost_status status = facet(text, err);
        if (status == OST_OK)
            status = ost_mesh_input_face(in, 3, err);
        if (status != OST_OK)
            return status;
    }
}

ost_status ost_mesh_check_stl_ascii(mesh_input *in, ost_error *err)
{
    mesh_text text = {.path = in->path, .at = (char *)in->bytes, .end = (char *)in->bytes + in->size, .line = 1};
    in->bodies = 0;
    for (;;) {
        mesh_word word = ost_mesh_text_any_word(&text);
        if (word.size == 0)
            break;
        if (!ost_mesh_word_is(word, "solid"))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected 'solid', found %s", text.path, text.line, ost_mesh_word_show(word));
        memcpy(word.text, "solid", word.size);
        ost_status status = solid(in, &text, err);
        if (status != OST_OK)
            return status;
        in->bodies++;
    }
    if (in->faces == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file holds no triangle", in->path);
    return OST_OK;
}
