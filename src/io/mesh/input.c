/* SPDX-License-Identifier: Apache-2.0 */
/* Loads a mesh file, determines its kind, and splits text into words. */
#include "io/mesh/input.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "core/file.h"

/*
 * Maximum size of a mesh file in bytes. A text file may thus have 128 bytes for each of
 * OST_MESH_FILE_TRIANGLES_MAX triangles; a binary STL file needs only 50 bytes for each.
 */
#define FILE_MAX (INT64_C(1) << 30)

enum { STL_HEADER = 84, STL_RECORD = 50, STL_SNIFF = 4096 };

static bool starts_with(const mesh_input *in, const char *word)
{
    mesh_text text = {.at = (char *)in->bytes, .end = (char *)in->bytes + in->size};
    return ost_mesh_word_is(ost_mesh_text_any_word(&text), word);
}

static uint64_t stl_count(const mesh_input *in)
{
    const uint8_t *p = in->bytes + 80;
    return (uint64_t)p[0] | (uint64_t)p[1] << 8 | (uint64_t)p[2] << 16 | (uint64_t)p[3] << 24;
}

/*
 * Returns the kind of an STL file. A binary file may begin with "solid" and is therefore recognised by its size; a text
 * file contains no zero byte. `file_size` may exceed in->size, the number of bytes in memory.
 */
static mesh_kind stl_kind(const mesh_input *in, uint64_t file_size)
{
    if (in->size >= STL_HEADER && file_size - STL_HEADER == stl_count(in) * STL_RECORD)
        return MESH_STL_BINARY;
    size_t sniffed = in->size < STL_SNIFF ? in->size : STL_SNIFF;
    if (starts_with(in, "solid") && !memchr(in->bytes, 0, sniffed))
        return MESH_STL_ASCII;
    return MESH_STL_BINARY;
}

static const char *extension_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot + 1 : "";
}

/*
 * Checks the first bytes and the size of a binary STL file, so that an invalid file is refused before the rest of it is
 * read.
 */
static ost_status check_stl_header(const ost_file *file, const char *path, ost_error *err)
{
    uint8_t sniffed[STL_SNIFF + 1] = {0};
    const ssize_t got = pread(file->fd, sniffed, STL_SNIFF, 0);
    if (got < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    const mesh_input in = {.path = path, .bytes = sniffed, .size = (size_t)got};
    if (in.size < STL_HEADER || memcmp(sniffed, "ply", 3) == 0 ||
        stl_kind(&in, (uint64_t)file->size) != MESH_STL_BINARY)
        return OST_OK;
    return ost_mesh_check_stl_count(path, (uint64_t)file->size, stl_count(&in), err);
}

static ost_status read_all(const ost_file *file, const char *path, mesh_input *in, ost_error *err)
{
    if (file->size == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file is empty", path);
    if (file->size > FILE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %lld bytes; a mesh file may have at most %lld", path,
                        (long long)file->size, (long long)FILE_MAX);
    in->size = (size_t)file->size;
    in->bytes = malloc(in->size + 1);
    if (!in->bytes)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu bytes", path, in->size);
    in->bytes[in->size] = 0;
    return ost_file_fill(path, file, in->bytes, err);
}

static ost_status find_kind(const char *path, mesh_input *in, ost_error *err)
{
    const char *extension = extension_of(path);
    if (in->size >= 4 && memcmp(in->bytes, "ply", 3) == 0 && (in->bytes[3] == '\n' || in->bytes[3] == '\r'))
        in->kind = MESH_PLY;
    else if (strcasecmp(extension, "stl") == 0)
        in->kind = stl_kind(in, in->size);
    else if (strcasecmp(extension, "obj") == 0)
        in->kind = MESH_OBJ;
    else if (strcasecmp(extension, "3ds") == 0)
        in->kind = MESH_3DS;
    else if (strcasecmp(extension, "ply") == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 0: a PLY file begins with a line 'ply'", path);
    else
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: '%.20s' is not a supported mesh format; expected .stl, .obj, .ply or .3ds", path,
                        extension[0] ? extension - 1 : "no extension");
    return OST_OK;
}

ost_status ost_mesh_input_load(const char *path, mesh_input *in, ost_error *err)
{
    *in = (mesh_input){.path = path, .bodies = 1};
    ost_file file;
    ost_status status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return status;
    if (strcasecmp(extension_of(path), "stl") == 0)
        status = check_stl_header(&file, path, err);
    if (status == OST_OK)
        status = read_all(&file, path, in, err);
    close(file.fd);
    if (status == OST_OK)
        status = find_kind(path, in, err);
    if (status != OST_OK)
        ost_mesh_input_free(in);
    return status;
}

void ost_mesh_input_free(mesh_input *in)
{
    free(in->bytes);
    in->bytes = NULL;
}

ost_status ost_mesh_input_face(mesh_input *in, uint64_t corners, ost_error *err)
{
    in->faces++;
    if (corners > 2)
        in->triangles += corners - 2;
    if (in->triangles > OST_MESH_FILE_TRIANGLES_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: more than %d triangles; simplify the mesh", in->path,
                        OST_MESH_FILE_TRIANGLES_MAX);
    return OST_OK;
}

ost_status ost_mesh_plain_open(const mesh_input *in, mesh_plain *plain, ost_error *err)
{
    plain->out = ost_memory_stream_open(&plain->made);
    return plain->out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the converted mesh", in->path);
}

ost_status ost_mesh_plain_close(mesh_input *in, mesh_plain *plain, ost_status status, ost_error *err)
{
    if (!ost_memory_stream_close(plain->out, &plain->made) && status == OST_OK)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the converted mesh", in->path);
    if (status == OST_OK) {
        free(in->bytes);
        in->bytes = (uint8_t *)plain->made.bytes;
        in->size = plain->made.size;
    } else {
        free(plain->made.bytes);
    }
    return status;
}

/* ------------------------------------------------------------------ text */

static bool blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

mesh_word ost_mesh_text_word(mesh_text *text)
{
    while (text->at < text->end && blank(*text->at))
        text->at++;
    mesh_word word = {text->at, 0};
    while (text->at < text->end && !blank(*text->at) && *text->at != '\n')
        text->at++;
    word.size = (size_t)(text->at - word.text);
    return word;
}

mesh_word ost_mesh_text_any_word(mesh_text *text)
{
    mesh_word word;
    do
        word = ost_mesh_text_word(text);
    while (word.size == 0 && ost_mesh_text_next_line(text));
    return word;
}

bool ost_mesh_text_next_line(mesh_text *text)
{
    char *newline = text->at < text->end ? memchr(text->at, '\n', (size_t)(text->end - text->at)) : NULL;
    text->at = newline ? newline + 1 : text->end;
    text->line += newline != NULL;
    return text->at < text->end;
}

bool ost_mesh_word_is(mesh_word word, const char *keyword)
{
    return word.size == strlen(keyword) && strncasecmp(word.text, keyword, word.size) == 0;
}

/*
 * Returns true if the word has at most 64 bytes, is a decimal, and satisfies (digits of the mantissa) + exponent <= 38.
 * The magnitude of such a decimal is at most 10^38, and the greatest float32 is 3.4 * 10^38. If assimp
 * nevertheless converts a word to infinity, read.c refuses the vertex.
 */
bool ost_mesh_word_number(mesh_word word)
{
    ost_decimal value;
    if (word.size == 0 || word.size > 64 ||
        ost_decimal_read(word.text, word.text + word.size, &value) != word.text + word.size)
        return false;
    int64_t m = value.mantissa < 0 ? -value.mantissa : value.mantissa;
    int64_t digits = 0;
    for (; m; m /= 10)
        digits++;
    return digits == 0 || digits + value.exponent <= 38;
}

bool ost_mesh_word_integer(mesh_word word, int64_t *out)
{
    size_t i = word.size && (word.text[0] == '-' || word.text[0] == '+');
    if (i == word.size || word.size > 18)
        return false;
    *out = 0;
    for (; i < word.size; i++) {
        if (word.text[i] < '0' || word.text[i] > '9')
            return false;
        *out = *out * 10 + (word.text[i] - '0');
    }
    if (word.text[0] == '-')
        *out = -*out;
    return true;
}

const char *ost_mesh_word_show(mesh_word word)
{
    static _Thread_local char shown[48];
    if (word.size == 0)
        return "the end";
    snprintf(shown, sizeof shown, "'%.*s%s'", (int)(word.size < 40 ? word.size : 40), word.text,
             word.size > 40 ? "..." : "");
    return shown;
}
