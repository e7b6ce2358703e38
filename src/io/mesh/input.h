/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prepares a mesh file for assimp.
 *
 *   file --load--> bytes --check--> bytes whose counts and indices are correct --> assimp
 *
 * assimp reads well-formed files correctly, but it opens files that are named in the input, repairs errors silently,
 * and neither checks counts nor reports line numbers. Therefore every file is first read into memory and checked
 * completely here. assimp receives only data that have passed the check, and cannot open any other file of the system.
 * Binary files are checked in place, and the parts that do not affect the vertices (headers, materials, animation) are
 * zeroed. Text is rewritten in a plain form, in which the numbers are copied verbatim.
 */
#ifndef OST_IO_MESH_INPUT_H
#define OST_IO_MESH_INPUT_H

#include <stdio.h>

#include <osteon/io.h>
#include "core/memory_stream.h"

typedef enum mesh_kind { MESH_STL_BINARY, MESH_STL_ASCII, MESH_OBJ, MESH_PLY, MESH_3DS } mesh_kind;

typedef struct mesh_input {
    const char *path;
    mesh_kind kind;
    uint8_t *bytes; /* owned; contents of the file or its plain form, followed by one zero byte */
    size_t size;
    uint64_t faces;     /* number of primitives (points, lines and polygons) found by the check */
    uint64_t triangles; /* number of triangles after the polygons are triangulated */
    size_t bodies;
} mesh_input;

/* Reads the file and determines its kind. The kind is determined from the content if the content has a signature,
   otherwise from the name. */
ost_status ost_mesh_input_load(const char *path, mesh_input *in, ost_error *err);
void ost_mesh_input_free(mesh_input *in);

/*
 * Each function checks a file of one kind. Returns OST_ERR_INPUT, with a line number or an offset in the message, if
 * the file has an error.
 */
ost_status ost_mesh_check_stl_binary(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_stl_ascii(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_obj(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_ply(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_3ds(mesh_input *in, ost_error *err);

/*
 * Checks that the triangle count in the header of a binary STL file matches the file's size and is within the
 * limit.
 */
ost_status ost_mesh_check_stl_count(const char *path, uint64_t file_size, uint64_t count, ost_error *err);

/*
 * Counts a face with the given number of corners. Returns OST_ERR_RANGE if the file then has more than
 * OST_MESH_FILE_TRIANGLES_MAX triangles.
 */
ost_status ost_mesh_input_face(mesh_input *in, uint64_t corners, ost_error *err);

/* The plain form of a file while it is being written. When it is complete, it replaces in->bytes. */
typedef struct mesh_plain {
    FILE *out;
    ost_memory_stream made;
} mesh_plain;

ost_status ost_mesh_plain_open(const mesh_input *in, mesh_plain *plain, ost_error *err);
/*
 * Completes the plain form, which was written with the result `status`. If `status` is OST_OK, the plain form replaces
 * in->bytes. Otherwise, in->bytes is unchanged and `status` is returned.
 */
ost_status ost_mesh_plain_close(mesh_input *in, mesh_plain *plain, ost_status status, ost_error *err);

/* Joins vertices with equal positions. The remaining vertices keep the order of their first occurrence. */
ost_status ost_mesh_weld(ost_mesh *mesh, ost_error *err);

/* ------------------------------------------------------------------ text */

typedef struct mesh_text {
    const char *path;
    char *at;
    char *end;
    long line;
} mesh_text;

typedef struct mesh_word {
    char *text; /* not terminated */
    size_t size;
} mesh_word;

/*
 * Returns the next word of the current line, or a word of size 0 at the end of the line. Space, tab, CR, VT and FF
 * count as blanks.
 */
mesh_word ost_mesh_text_word(mesh_text *text);
/* Returns the next word on the current or a later line, or a word of size 0 at the end of the text. */
mesh_word ost_mesh_text_any_word(mesh_text *text);
/* Moves to the position after the next newline. Returns false at the end of the text. */
bool ost_mesh_text_next_line(mesh_text *text);
/* Returns true if the word equals the keyword; case is ignored. */
bool ost_mesh_word_is(mesh_word word, const char *keyword);
/* Returns true if the complete word is a decimal whose magnitude fits into a float32. */
bool ost_mesh_word_number(mesh_word word);
/* Reads the complete word as an integer. Returns false if the word is not an integer. */
bool ost_mesh_word_integer(mesh_word word, int64_t *out);
/*
 * Returns at most 40 bytes of the word, in quotes, for a message. Returns "the end" if the word is empty. The text
 * remains valid until the next call in the same thread.
 */
const char *ost_mesh_word_show(mesh_word word);

#endif
