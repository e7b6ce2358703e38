/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks 3DS files, and disables the chunks that are not needed. A file consists of nested chunks. Each begins with a
 * uint16 kind and a uint32 size, which includes these six bytes.
 *
 *   4D4D main ( 3D3D editor ( 4000 object: name 0 ( 4100 mesh (
 *       4110 vertices: uint16 count, count * 3 float32
 *       4120 faces:    uint16 count, count * 4 uint16, chunks ))))
 *
 * Vertices are already in the file's common frame. In all other chunks (materials, local frames, keyframe animation),
 * the kind is replaced by 0000, which assimp skips.
 */
#include <math.h>
#include <string.h>

#include "io/mesh/input.h"

enum { MAIN = 0x4d4d, EDITOR = 0x3d3d, OBJECT = 0x4000, MESH = 0x4100, VERTICES = 0x4110, FACES = 0x4120, HEAD = 6 };

typedef struct mesh_part {
    uint32_t vertices, faces;
    uint32_t greatest; /* 1 + the highest vertex index used by any face */
    size_t faces_at;
} mesh_part;

static uint32_t get16(const mesh_input *in, size_t at)
{
    return in->bytes[at] | (uint32_t)in->bytes[at + 1] << 8;
}

static uint32_t get32(const mesh_input *in, size_t at)
{
    return get16(in, at) | get16(in, at + 2) << 16;
}

static ost_status fail_at(const mesh_input *in, size_t at, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: byte %zu: %s", in->path, at, what);
}

static ost_status vertices(mesh_input *in, size_t at, size_t end, mesh_part *part, ost_error *err)
{
    if (part->vertices)
        return fail_at(in, at, "a second list of vertices in one mesh", err);
    if (end - at < 2 || (end - at - 2) / 12 < get16(in, at))
        return fail_at(in, at, "the vertices are more than their chunk holds", err);
    part->vertices = get16(in, at);
    for (size_t i = 0; i < 3 * (size_t)part->vertices; i++) {
        float f;
        memcpy(&f, in->bytes + at + 2 + 4 * i, sizeof f);
        if (!isfinite(f))
            return fail_at(in, at + 2 + 4 * i, "a coordinate that is no finite number", err);
    }
    return OST_OK;
}

static ost_status faces(mesh_input *in, size_t at, size_t end, mesh_part *part, ost_error *err)
{
    if (part->faces)
        return fail_at(in, at, "a second list of faces in one mesh", err);
    if (end - at < 2 || (end - at - 2) / 8 < get16(in, at))
        return fail_at(in, at, "the faces are more than their chunk holds", err);
    part->faces = get16(in, at);
    part->faces_at = at;
    ost_status status = OST_OK;
    for (size_t i = 0; status == OST_OK && i < part->faces; i++) {
        for (size_t c = 0; c < 3; c++) {
            uint32_t index = get16(in, at + 2 + 8 * i + 2 * c);
            if (index >= part->greatest)
                part->greatest = index + 1;
        }
        status = ost_mesh_input_face(in, 3, err);
    }
    /* The remaining chunks name materials and smoothing groups, which are not needed. */
    for (size_t next = at + 2 + 8 * (size_t)part->faces; status == OST_OK && next < end;) {
        if (end - next < HEAD || get32(in, next + 2) < HEAD || get32(in, next + 2) > end - next)
            return fail_at(in, next, "a chunk whose size does not fit into the one around it", err);
        in->bytes[next] = in->bytes[next + 1] = 0;
        next += get32(in, next + 2);
    }
    return status;
}

static ost_status end_mesh(mesh_input *in, const mesh_part *part, ost_error *err)
{
    if (part->greatest > part->vertices)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte %zu: a face uses vertex %u of %u", in->path, part->faces_at,
                        (unsigned)part->greatest - 1, (unsigned)part->vertices);
    in->bodies += part->faces > 0;
    return OST_OK;
}

/*
 * Checks the chunks in the byte range [at, end), which lie inside a chunk of kind `around`. Recurses at most four
 * levels deep.
 */
static ost_status chunks(mesh_input *in, size_t at, size_t end, uint32_t around, mesh_part *part, ost_error *err)
{
    ost_status status = OST_OK;
    while (status == OST_OK && at < end) {
        if (end - at < HEAD || get32(in, at + 2) < HEAD || get32(in, at + 2) > end - at)
            return fail_at(in, at, "a chunk whose size does not fit into the one around it", err);
        const uint32_t kind = get16(in, at);
        const size_t body = at + HEAD, next = at + get32(in, at + 2);
        if (around == MAIN && kind == EDITOR) {
            status = chunks(in, body, next, EDITOR, NULL, err);
        } else if (around == EDITOR && kind == OBJECT) {
            const uint8_t *zero = memchr(in->bytes + body, 0, next - body);
            if (!zero)
                return fail_at(in, body, "an object's name without an end", err);
            status = chunks(in, (size_t)(zero - in->bytes) + 1, next, OBJECT, NULL, err);
        } else if (around == OBJECT && kind == MESH) {
            mesh_part inner = {0};
            status = chunks(in, body, next, MESH, &inner, err);
            if (status == OST_OK)
                status = end_mesh(in, &inner, err);
        } else if (around == MESH && kind == VERTICES) {
            status = vertices(in, body, next, part, err);
        } else if (around == MESH && kind == FACES) {
            status = faces(in, body, next, part, err);
        } else {
            in->bytes[at] = in->bytes[at + 1] = 0;
        }
        at = next;
    }
    return status;
}

ost_status ost_mesh_check_3ds(mesh_input *in, ost_error *err)
{
    if (in->size < HEAD)
        return ost_fail(err, OST_ERR_INPUT, "%s: file is truncated after %zu bytes; a 3DS file begins with %d bytes of "
                        "header", in->path, in->size, HEAD);
    if (get16(in, 0) != MAIN)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 0: the first chunk has the kind %04X; expected 4D4D, the kind of "
                        "a 3DS file", in->path, (unsigned)get16(in, 0));
    if (get32(in, 2) < HEAD || get32(in, 2) > in->size)
        return ost_fail(err, OST_ERR_INPUT, "%s: byte 2: the header states %u bytes; the file has %zu", in->path,
                        (unsigned)get32(in, 2), in->size);
    in->size = get32(in, 2);
    in->bodies = 0;
    ost_status status = chunks(in, HEAD, in->size, MAIN, NULL, err);
    if (status == OST_OK && in->faces == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the file has no face", in->path);
    return status;
}
