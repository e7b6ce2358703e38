/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A mesh file on its way to assimp.
 *
 *   file --load--> bytes --check--> bytes that hold what they say --> assimp
 *
 * assimp reads well-formed files well, but it trusts counts, follows file
 * names, repairs in silence, and names no line.  So every file is read into
 * memory once and checked from end to end here first; what assimp is given
 * can no longer surprise it, and it is given nothing else: no other file of
 * the system.  Binary files are checked in place, and what decides no vertex
 * is blanked (headers, materials, animation); text is written anew in a plain
 * form, its numbers word for word.
 */
#ifndef OST_IO_MESH_INPUT_H
#define OST_IO_MESH_INPUT_H

#include <stdio.h>

#include <osteon/io.h>

typedef enum mesh_kind { MESH_STL_BINARY, MESH_STL_ASCII, MESH_OBJ, MESH_PLY, MESH_3DS } mesh_kind;

typedef struct mesh_input {
    const char *path;
    mesh_kind kind;
    uint8_t *bytes; /* owned; one zero byte follows the last */
    size_t size;
    uint64_t faces;     /* primitives of any kind, by the check */
    uint64_t triangles; /* that their polygons make */
    size_t bodies;
} mesh_input;

/* Reads the file and finds its kind, by content where it has a signature, else by name. */
ost_status ost_mesh_input_load(const char *path, mesh_input *in, ost_error *err);
void ost_mesh_input_free(mesh_input *in);

/* One a kind; OST_ERR_INPUT with line or offset. */
ost_status ost_mesh_check_stl_binary(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_stl_ascii(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_obj(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_ply(mesh_input *in, ost_error *err);
ost_status ost_mesh_check_3ds(mesh_input *in, ost_error *err);

/* The triangles that a binary STL of this size says it has: there, and not too many. */
ost_status ost_mesh_check_stl_count(const char *path, uint64_t file_size, uint64_t count, ost_error *err);

/* Adds a face of this many corners; OST_ERR_RANGE beyond OST_MESH_FILE_TRIANGLES_MAX. */
ost_status ost_mesh_input_face(mesh_input *in, uint64_t corners, ost_error *err);

/* The plain form of a file, on its way into the place of in->bytes. */
typedef struct mesh_plain {
    FILE *out;
    char *bytes;
    size_t size;
} mesh_plain;

ost_status ost_mesh_plain_open(const mesh_input *in, mesh_plain *plain, ost_error *err);
/* Replaces in->bytes when status, the outcome of writing, is OST_OK; else leaves them. Returns status or its own failure. */
ost_status ost_mesh_plain_close(mesh_input *in, mesh_plain *plain, ost_status status, ost_error *err);

/* Joins vertices at the same place; those left keep the order of their first. */
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

/* The next word on this line; size 0 at the line's end. Blanks are space, tab, CR, VT, FF. */
mesh_word ost_mesh_text_word(mesh_text *text);
/* The next word on this or a later line; size 0 at the text's end. */
mesh_word ost_mesh_text_any_word(mesh_text *text);
/* Behind the next newline; false at the text's end. */
bool ost_mesh_text_next_line(mesh_text *text);
/* Whether word is this keyword, whatever the case of its letters. */
bool ost_mesh_word_is(mesh_word word, const char *keyword);
/* A whole word as a decimal whose magnitude a float32 can hold. */
bool ost_mesh_word_number(mesh_word word);
/* A whole word as an integer. */
bool ost_mesh_word_integer(mesh_word word, int64_t *out);
/* For messages: at most 40 bytes of the word, "the end" for none. Valid until the next call in this thread. */
const char *ost_mesh_word_show(mesh_word word);

#endif
