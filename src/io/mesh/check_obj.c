/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks OBJ files. Only two kinds of statement define a surface.
 *
 *   v x y z [colour or weight 1]
 *   f v[/vt[/vn]] ...    indices from 1; a negative index counts back from the last vertex
 *
 * assimp receives only these statements, in a plain form: numbers are copied verbatim, and faces become fans of
 * triangles with indices from 1. A fan has the same winding numbers as its polygon, even if the polygon is not convex.
 * No other statement reaches assimp, in particular no material library, which would name other files. A backslash at
 * the end of a line joins it to the next line. Points and lines are counted and omitted.
 */
#include <string.h>

#include "io/mesh/input.h"

typedef struct obj {
    mesh_input *in;
    mesh_text text;
    mesh_plain plain;
    int64_t vertices;
    int64_t greatest; /* highest vertex index used so far, and the line that uses it */
    long greatest_line;
    bool body_has_faces;
} obj;

static ost_status vertex(obj *o, ost_error *err)
{
    mesh_word words[4];
    int count = 0;
    for (mesh_word word; (word = ost_mesh_text_word(&o->text)).size; count++) {
        if (!ost_mesh_word_number(word))
            return ost_fail(err, OST_ERR_INPUT, "%s:%ld: expected a number, found %s", o->text.path, o->text.line,
                            ost_mesh_word_show(word));
        if (count < 4)
            words[count] = word;
    }
    if (count < 3)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: a vertex needs three numbers, found %d", o->text.path,
                        o->text.line, count);
    ost_decimal weight;
    int64_t millionths;
    if (count == 4 && !(ost_decimal_read(words[3].text, words[3].text + words[3].size, &weight) &&
                        ost_decimal_scale(&weight, 1000000, &millionths, NULL) && millionths == 1000000))
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: a vertex of weight %s; expected 1", o->text.path, o->text.line,
                        ost_mesh_word_show(words[3]));
    putc('v', o->plain.out);
    /* assimp does not accept a number that begins with the decimal point, so a 0 is prepended */
    for (int i = 0; i < 3; i++)
        fprintf(o->plain.out, words[i].text[0] == '.' ? " 0%.*s" : " %.*s", (int)words[i].size, words[i].text);
    putc('\n', o->plain.out);
    if (++o->vertices > 3 * (int64_t)OST_MESH_FILE_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s:%ld: more than %lld vertices; simplify the mesh", o->text.path,
                        o->text.line, 3 * (long long)OST_MESH_FILE_TRIANGLES_MAX);
    return OST_OK;
}

static ost_status face(obj *o, ost_error *err)
{
    int64_t first = 0, last = 0;
    uint64_t corners = 0;
    for (mesh_word word; (word = ost_mesh_text_word(&o->text)).size; corners++) {
        char *slash = memchr(word.text, '/', word.size);
        mesh_word index = {word.text, slash ? (size_t)(slash - word.text) : word.size};
        int64_t i;
        if (!ost_mesh_word_integer(index, &i) || i == 0 || i > UINT32_MAX || i < -o->vertices)
            return ost_fail(err, OST_ERR_INPUT,
                            "%s:%ld: %s is not the number of a vertex; expected 1 or more, or a negative number that "
                            "counts back over the %lld vertices before the face", o->text.path, o->text.line,
                            ost_mesh_word_show(word), (long long)o->vertices);
        if (i < 0)
            i += o->vertices + 1;
        if (i > o->greatest) {
            o->greatest = i;
            o->greatest_line = o->text.line;
        }
        if (corners == 0)
            first = i;
        if (corners >= 2)
            fprintf(o->plain.out, "f %lld %lld %lld\n", (long long)first, (long long)last, (long long)i);
        last = i;
    }
    if (corners > 2 && !o->body_has_faces) {
        o->body_has_faces = true;
        o->in->bodies++;
    }
    return ost_mesh_input_face(o->in, corners, err);
}

/*
 * Replaces each backslash and the newline after it with blanks. The joined lines count as one line, so messages about
 * later lines state line numbers that are too small.
 */
static void join_lines(char *at, const char *end)
{
    for (; (at = memchr(at, '\\', (size_t)(end - at))); at++) {
        size_t n = at + 1 < end && at[1] == '\n' ? 2 : at + 2 < end && at[1] == '\r' && at[2] == '\n' ? 3 : 0;
        memset(at, ' ', n);
    }
}

static ost_status statements(obj *o, ost_error *err)
{
    ost_status status = OST_OK;
    do {
        mesh_word word = ost_mesh_text_word(&o->text);
        if (ost_mesh_word_is(word, "v"))
            status = vertex(o, err);
        else if (ost_mesh_word_is(word, "f"))
            status = face(o, err);
        else if (ost_mesh_word_is(word, "p") || ost_mesh_word_is(word, "l"))
            status = ost_mesh_input_face(o->in, 0, err);
        else if (ost_mesh_word_is(word, "o"))
            o->body_has_faces = false;
    } while (status == OST_OK && ost_mesh_text_next_line(&o->text));
    if (status == OST_OK && o->greatest > o->vertices)
        return ost_fail(err, OST_ERR_INPUT, "%s:%ld: a face refers to vertex %lld; the file has %lld", o->text.path,
                        o->greatest_line, (long long)o->greatest, (long long)o->vertices);
    if (status == OST_OK && o->in->triangles == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file has no face", o->text.path);
    return status;
}

ost_status ost_mesh_check_obj(mesh_input *in, ost_error *err)
{
    if (memchr(in->bytes, 0, in->size))
        return ost_fail(err, OST_ERR_INPUT, "%s: byte %zu: a zero byte; an OBJ file is text", in->path,
                        (size_t)((uint8_t *)memchr(in->bytes, 0, in->size) - in->bytes));
    obj o = {.in = in};
    o.text = (mesh_text){.path = in->path, .at = (char *)in->bytes, .end = (char *)in->bytes + in->size, .line = 1};
    ost_status status = ost_mesh_plain_open(in, &o.plain, err);
    if (status != OST_OK)
        return status;
    in->bodies = 0;
    join_lines(o.text.at, o.text.end);
    status = statements(&o, err);
    return ost_mesh_plain_close(in, &o.plain, status, err);
}
