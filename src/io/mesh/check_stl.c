/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks STL files.
 *
 *   binary   80 bytes of any content, uint32 count, count * (12 float32, 2 bytes)
 *            Up to 49 further bytes are ignored, because some programs append a
 *            byte.  Header and attributes are zeroed, because assimp would read
 *            colours from them.
 *   ASCII    solid NAME  ( facet normal N N N  outer loop  3 x vertex N N N
 *            endloop  endfacet )*  endsolid NAME, once or several times
 *            Line breaks between words are arbitrary.  The plain form has no
 *            names, and its normals are 0, because normals are not used here
 *            and some files contain "nan" as a normal.
 */
#include <math.h>
#include <string.h>

#include "io/mesh/input.h"

enum { HEADER = 84, RECORD = 50 };

ost_status ost_mesh_check_stl_binary(mesh_input *in, ost_error *err)
{
    if (in->size < HEADER)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %zu bytes are too few for an STL file: binary has at least %d, ASCII begins with 'solid'",
                        in->path, in->size, HEADER);
    uint32_t count;
    memcpy(&count, in->bytes + 80, sizeof count);
    ost_status status = ost_mesh_check_stl_count(in->path, in->size, count, err);
    if (status != OST_OK)
        return status;
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

typedef struct ascii {
    mesh_input *in;
    mesh_text text;
    mesh_plain plain;
} ascii;

static ost_status expect(ascii *a, const char *keyword, ost_error *err)
{
    mesh_word word = ost_mesh_text_any_word(&a->text);
    if (ost_mesh_word_is(word, keyword))
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected '%s', found %s", a->text.path, a->text.line, keyword,
                    ost_mesh_word_show(word));
}

static ost_status normal(ascii *a, ost_error *err)
{
    for (int i = 0; i < 3; i++)
        if (ost_mesh_text_any_word(&a->text).size == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected a normal's numbers, found the end", a->text.path,
                            a->text.line);
    fputs("facet normal 0 0 0\nouter loop\n", a->plain.out);
    return OST_OK;
}

static ost_status vertex(ascii *a, ost_error *err)
{
    ost_status status = expect(a, "vertex", err);
    if (status != OST_OK)
        return status;
    fputs("vertex", a->plain.out);
    for (int i = 0; i < 3; i++) {
        mesh_word word = ost_mesh_text_any_word(&a->text);
        if (!ost_mesh_word_number(word))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected a number, found %s", a->text.path, a->text.line,
                            ost_mesh_word_show(word));
        fprintf(a->plain.out, " %.*s", (int)word.size, word.text);
    }
    putc('\n', a->plain.out);
    return OST_OK;
}

/* Reads a facet, beginning with the word after "facet". */
static ost_status facet(ascii *a, ost_error *err)
{
    ost_status status = expect(a, "normal", err);
    if (status == OST_OK)
        status = normal(a, err);
    if (status == OST_OK)
        status = expect(a, "outer", err);
    if (status == OST_OK)
        status = expect(a, "loop", err);
    for (int i = 0; status == OST_OK && i < 3; i++)
        status = vertex(a, err);
    if (status == OST_OK)
        status = expect(a, "endloop", err);
    if (status == OST_OK)
        status = expect(a, "endfacet", err);
    fputs("endloop\nendfacet\n", a->plain.out);
    return status;
}

/* Skips the rest of the line, which is a name. */
static void skip_name(ascii *a)
{
    while (ost_mesh_text_word(&a->text).size)
        continue;
}

/* Reads a solid, beginning with the word after "solid". */
static ost_status solid(ascii *a, ost_error *err)
{
    skip_name(a);
    for (;;) {
        mesh_word word = ost_mesh_text_any_word(&a->text);
        if (ost_mesh_word_is(word, "endsolid")) {
            skip_name(a);
            return OST_OK;
        }
        if (!ost_mesh_word_is(word, "facet"))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected 'facet' or 'endsolid', found %s", a->text.path,
                            a->text.line, ost_mesh_word_show(word));
        ost_status status = facet(a, err);
        if (status == OST_OK)
            status = ost_mesh_input_face(a->in, 3, err);
        if (status != OST_OK)
            return status;
    }
}

/* Writes all solids of the file as one solid in the plain form, because the reader would join them anyway. */
static ost_status solids(ascii *a, ost_error *err)
{
    fputs("solid\n", a->plain.out);
    for (mesh_word word; (word = ost_mesh_text_any_word(&a->text)).size;) {
        if (!ost_mesh_word_is(word, "solid"))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected 'solid', found %s", a->text.path, a->text.line,
                            ost_mesh_word_show(word));
        const uint64_t before = a->in->faces;
        ost_status status = solid(a, err);
        if (status != OST_OK)
            return status;
        a->in->bodies += a->in->faces > before;
    }
    if (a->in->faces == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file has no triangle", a->text.path);
    fputs("endsolid\n", a->plain.out);
    return OST_OK;
}

ost_status ost_mesh_check_stl_ascii(mesh_input *in, ost_error *err)
{
    ascii a = {.in = in};
    a.text = (mesh_text){.path = in->path, .at = (char *)in->bytes, .end = (char *)in->bytes + in->size, .line = 1};
    ost_status status = ost_mesh_plain_open(in, &a.plain, err);
    if (status != OST_OK)
        return status;
    in->bodies = 0;
    status = solids(&a, err);
    return ost_mesh_plain_close(in, &a.plain, status, err);
}
