/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests mesh files: the same box in every format must give the same mesh, and reading back a written STL
 * file must give the same mesh. Further tests check units and the errors for broken files.
 *
 * The file has more than 500 lines, because most tests need the writers of all formats, which are defined here.
 *
 * Covers: AR-MESH-1, AR-MESH-2
 */
#include "harness.h"

#include "io/scratch_group.h"

#include <osteon/io.h>
#include <osteon/phantom.h>

#include "config.h"

/* A file that a test builds piece by piece. */
typedef struct bytes {
    size_t size;
    uint8_t at[1 << 16];
} bytes;

static void add(bytes *b, const void *what, size_t size)
{
    assert_true(b->size + size <= sizeof b->at);
    memcpy(b->at + b->size, what, size);
    b->size += size;
}

static void add_text(bytes *b, const char *text)
{
    add(b, text, strlen(text));
}

static void add_number(bytes *b, uint64_t value, size_t size)
{
    add(b, &value, size);
}

static void add_float(bytes *b, float value)
{
    add(b, &value, sizeof value);
}

/* The box [0, 10] x [0, 20] x [-5, 25]. Its faces are quads with outward normals. */
static const float corners[8][3] = {{0, 0, -5}, {10, 0, -5}, {0, 20, -5}, {10, 20, -5},
                                    {0, 0, 25}, {10, 0, 25}, {0, 20, 25}, {10, 20, 25}};
static const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

/* Returns the vertex number of corner c (0 to 2) of the box's triangle t (0 to 11). */
static int corner_of(int t, int c)
{
    return quads[t / 2][c == 0 ? 0 : c + t % 2];
}

static void stl_binary(bytes *b, const char *header, uint32_t count)
{
    char head[80] = {0};
    memcpy(head, header, strlen(header));
    add(b, head, sizeof head);
    add_number(b, count, 4);
    for (int t = 0; t < 12; t++) {
        for (int i = 0; i < 3; i++)
            add_float(b, (float)i);
        for (int c = 0; c < 3; c++)
            add(b, corners[corner_of(t, c)], 12);
        add_number(b, 0xffff, 2);
    }
}

static void stl_ascii(bytes *b)
{
    char line[128];
    add_text(b, "solid box facet vertex\n");
    for (int t = 0; t < 12; t++) {
        add_text(b, t == 3 ? "FACET NORMAL nan -inf 1e99\n OUTER LOOP\n" : "facet normal 0 0 1\n outer loop\r\n");
        for (int c = 0; c < 3; c++) {
            const float *v = corners[corner_of(t, c)];
            snprintf(line, sizeof line, "  vertex %.3e\t%.1f %+d\n", (double)v[0], (double)v[1], (int)v[2]);
            add_text(b, line);
        }
        add_text(b, " endloop\nendfacet\n");
    }
    add_text(b, "endsolid box\n");
}

static void obj(bytes *b)
{
    char line[128];
    add_text(b, "# a box\nmtllib /etc/passwd\no box\n");
    for (int i = 0; i < 8; i++) {
        snprintf(line, sizeof line, "  v %.2f %.0f %.1f%s\n", (double)corners[i][0], (double)corners[i][1],
                 (double)corners[i][2],
                 i == 5   ? " 0.5 0.5 0.5"
                 : i == 6 ? " 1.0"
                          : "");
        add_text(b, line);
    }
    add_text(b, "vn 0 0 1\nvt 0 0\nusemtl none\ns off\np 1\nl 1 2\n");
    for (int q = 0; q < 6; q++) {
        snprintf(line, sizeof line, q == 1 ? "f %d/1/1 %d//1 \\\n %d %d\n" : "f %d %d %d %d\n", quads[q][0] + 1,
                 quads[q][1] + 1, quads[q][2] + 1, quads[q][3] - (q == 2 ? 8 : -1));
        add_text(b, line);
    }
}

static void ply(bytes *b, const char *format, bool wide)
{
    const bool text = strcmp(format, "ascii") == 0, big = strcmp(format, "binary_big_endian") == 0;
    char line[256];
    snprintf(line, sizeof line,
             "ply\nformat %s 1.0\ncomment made by a test\nelement vertex 8\nproperty %s x\nproperty uchar red\n",
             format, wide ? "double" : "float");
    add_text(b, line);
    snprintf(line, sizeof line, "property %s y\nproperty %s z\nelement face 6\nproperty list uchar int vertex_index\n",
             wide ? "double" : "float", wide ? "float64" : "float32");
    add_text(b, line);
    add_text(b, "property list uchar float weights\nend_header\n");
    for (int i = 0; i < 8; i++)
        for (int a = 0; a < 3; a++) {
            double d = (double)corners[i][a];
            float f = corners[i][a];
            uint64_t bits = 0;
            memcpy(&bits, wide ? (void *)&d : (void *)&f, wide ? 8 : 4);
            if (big)
                bits = __builtin_bswap64(bits) >> (wide ? 0 : 32);
            snprintf(line, sizeof line, "%g%s", d, a == 2 ? "\n" : " ");
            text ? add_text(b, line) : add_number(b, bits, wide ? 8 : 4);
            if (a == 0)
                text ? add_text(b, "255 ") : add_number(b, 255, 1);
        }
    for (int q = 0; q < 6; q++) {
        text ? add_text(b, "4") : add_number(b, 4, 1);
        for (int c = 0; c < 4; c++) {
            snprintf(line, sizeof line, " %d", quads[q][c]);
            text ? add_text(b, line)
                 : add_number(b, big ? __builtin_bswap32((uint32_t)quads[q][c]) : (uint32_t)quads[q][c], 4);
        }
        text ? add_text(b, " 0\n") : add_number(b, 0, 1);
    }
}

/* Writes a 3DS file with a material, a local frame and a keyframer. The reader must skip all three. */
static void three_ds(bytes *b)
{
    const uint32_t vertices = 2 + 8 * 12, faces = 2 + 12 * 8, frame = 48,
                   mesh = 6 + (6 + vertices) + (6 + frame) + (6 + faces);
    const uint32_t editor = 6 + 6 + 4 + mesh, key = 6 + 6;
    add_number(b, 0x4d4d, 2), add_number(b, 6 + editor + key, 4);
    add_number(b, 0x3d3d, 2), add_number(b, editor, 4);
    add_number(b, 0x4000, 2), add_number(b, 6 + 4 + mesh, 4), add(b, "box", 4);
    add_number(b, 0x4100, 2), add_number(b, mesh, 4);
    add_number(b, 0x4110, 2), add_number(b, 6 + vertices, 4), add_number(b, 8, 2), add(b, corners, sizeof corners);
    add_number(b, 0x4160, 2), add_number(b, 6 + frame, 4);
    for (int i = 0; i < 12; i++)
        add_float(b, (float)(i * i - 7));
    add_number(b, 0x4120, 2), add_number(b, 6 + faces, 4), add_number(b, 12, 2);
    for (int t = 0; t < 12; t++) {
        for (int c = 0; c < 3; c++)
            add_number(b, (uint64_t)corner_of(t, c), 2);
        add_number(b, 7, 2);
    }
    add_number(b, 0xb000, 2), add_number(b, key, 4), add_number(b, 0xb00a, 2), add_number(b, 6, 4);
}

static void make_file(int which, bytes *b)
{
    b->size = 0;
    switch (which) {
    case 0: stl_binary(b, "a box", 12); break;
    case 1: stl_binary(b, "solid box COLOR=abcd", 12); break;
    case 2: stl_binary(b, "a box", 12), add(b, "\n", 1); break;
    case 3: stl_ascii(b); break;
    case 4: obj(b); break;
    case 5: ply(b, "ascii", false); break;
    case 6: ply(b, "binary_little_endian", false); break;
    case 7: ply(b, "binary_big_endian", false); break;
    case 8: ply(b, "binary_big_endian", true); break;
    case 9: ply(b, "ascii", true); break;
    default: three_ds(b); break;
    }
}

enum { FILES = 11 };
static const char *const names[FILES] = {"a.stl", "b.STL", "c.stl", "d.stl", "e.obj", "f.ply",
                                         "g.ply", "h.ply", "i.PLY", "j.obj", "k.3ds"};

#ifdef HAVE_ASSIMP

static void every_format_reads_the_same_box(void **state)
{
    (void)state;
    static bytes b;
    for (int which = 0; which < FILES; which++) {
        ost_error err = {0};
        ost_mesh mesh;
        ost_mesh_report report;
        make_file(which, &b);
        assert_ok(
            ost_mesh_read(scratch_write(folder, names[which], b.at, b.size), OST_UNIT_AUTO, &mesh, &report, &err));
        assert_int_equal(mesh.triangle_count, 12);
        assert_int_equal(mesh.vertex_count, 8);
        assert_int_equal(report.file_triangles, which < 4 || which == 10 ? 12 : which == 4 ? 8 : 6);
        assert_int_equal(report.bodies, 1);
        /* The triangles and their corners must be in the file's order. */
        for (int t = 0; t < 12; t++)
            for (int c = 0; c < 3; c++) {
                const ost_pm3 *p = &mesh.vertices[mesh.triangles[t][c]];
                const float *v = corners[corner_of(t, c)];
                assert_int_equal(p->x, (int64_t)v[0] * OST_PM_PER_MM);
                assert_int_equal(p->y, (int64_t)v[1] * OST_PM_PER_MM);
                assert_int_equal(p->z, (int64_t)v[2] * OST_PM_PER_MM);
            }
        size_t open = 1;
        assert_ok(ost_mesh_open_edges(&mesh, &open, &err));
        assert_int_equal(open, 0);
        assert_true(report.bounds_mm[2] == -5.0 && report.bounds_mm[5] == 25.0);
        ost_mesh_free(&mesh);
    }
}

/*
 * For a file truncated at any position, or with any bytes changed, reading must return either an
 * error that names the file or a valid mesh.
 */
static void damaged_files_give_an_error_or_a_valid_mesh(void **state)
{
    (void)state;
    static bytes b, broken;
    test_rng rng = rng_seeded("broken");
    for (int which = 0; which < FILES; which++) {
        make_file(which, &b);
        for (int round = 0; round < 160; round++) {
            ost_error err = {0};
            ost_mesh mesh;
            memcpy(broken.at, b.at, b.size);
            broken.size = b.size;
            const bool cut = round < 80;
            if (cut)
                broken.size = (size_t)rng_range(&rng, 0, (int64_t)b.size - (which == 2 ? 2 : 1));
            else
                for (int64_t n = rng_range(&rng, 1, 4); n > 0; n--)
                    broken.at[rng_range(&rng, 0, (int64_t)b.size - 1)] = (uint8_t)rng_range(&rng, 0, 255);
            const char *path = scratch_write(folder, names[which], broken.at, broken.size);
            ost_status status = ost_mesh_read(path, OST_UNIT_MM, &mesh, NULL, &err);
            if (status == OST_OK) {
                for (size_t t = 0; t < mesh.triangle_count; t++)
                    for (int c = 0; c < 3; c++)
                        assert_true(mesh.triangles[t][c] < mesh.vertex_count);
                ost_mesh_free(&mesh);
            } else {
                assert_int_equal(err.status, status);
                assert_int_equal(ost_status_exit(status), 2);
                assert_true(status != OST_ERR_INTERNAL);
                assert_ptr_equal(strstr(err.text, path), err.text);
                assert_null(mesh.vertices);
            }
            /* A truncated file must be refused, unless it is in a text format and still contains all necessary data. */
            if (cut && status == OST_OK && which != 4 && which != 3 && which != 5 && which != 9)
                fail_msg("%s truncated to %zu of %zu bytes was accepted", names[which], broken.size, b.size);
        }
    }
}

static void units_are_given_or_inferred(void **state)
{
    (void)state;
    static bytes b;
    static const struct {
        const char *scale; /* the mesh is the triangle with the vertices (0, 0, 0), (scale, 0, 0) and (0, scale, 0) */
        ost_unit unit;
        int64_t pm;          /* expected scale in picometres; 0 if the file must be refused */
        const char *message; /* text that the error must contain, if the file is refused */
    } rows[] = {
        {"10", OST_UNIT_AUTO, 10000000000, NULL},
        {"10", OST_UNIT_CM, 100000000000, NULL},
        {"0.5", OST_UNIT_M, 500000000000, NULL},
        {"1", OST_UNIT_INCH, 25400000000, NULL},
        /* float32 stores 0.1 as 0.100000001490116..., which is multiplied by 25.4 */
        {"0.1", OST_UNIT_INCH, 2540000038, NULL},
        {"0.1", OST_UNIT_MM, 100000001, NULL},      /* 100000001.49 pm, rounded */
        {"0.1", OST_UNIT_UM, 100000, NULL},
        {"0.5", OST_UNIT_UM, 500000, NULL},
        {"1", OST_UNIT_AUTO, 1000000000, NULL},
        {"1000", OST_UNIT_AUTO, 1000000000000, NULL},
        {"0.047", OST_UNIT_AUTO, 0, "0.047 mm across"},
        {"0.047", OST_UNIT_AUTO, 0, "--unit m makes it 47 mm, --unit inch makes it 1.19 mm"},
        {"1001", OST_UNIT_AUTO, 0, "--unit um makes it 1 mm"},
        {"0.000001", OST_UNIT_AUTO, 0, "mm to confirm millimetres"},
        {"8001", OST_UNIT_MM, 0, "expected coordinates from -8000 to 8000 mm"},
        {"9", OST_UNIT_M, 0, "expected coordinates from -8000 to 8000 mm"},
        {"3e37", OST_UNIT_MM, 0, "expected coordinates from -8000 to 8000 mm"},
        {"5", (ost_unit)6, 0, "unknown unit"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        ost_mesh mesh;
        char text[256];
        snprintf(text, sizeof text, "v 0 0 0\nv %s 0 0\nv 0 %s -0\nf 1 2 3\n", rows[i].scale, rows[i].scale);
        b.size = 0;
        add_text(&b, text);
        ost_status status = ost_mesh_read(scratch_write(folder, "unit.obj", b.at, b.size), rows[i].unit, &mesh, NULL,
                                          &err);
        if (rows[i].pm) {
            if (status != OST_OK)
                fail_msg("row %zu: %s", i, err.text);
            assert_int_equal(mesh.vertices[1].x, rows[i].pm);
            assert_int_equal(mesh.vertices[2].z, 0);
            ost_mesh_free(&mesh);
        } else {
            assert_int_equal(ost_status_exit(status), 2);
            if (!strstr(err.text, rows[i].message))
                fail_msg("row %zu: the error '%s' does not contain '%s'", i, err.text, rows[i].message);
        }
    }
}

#define PLY_HEAD "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define PLY_FACE "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
#define FACET "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\n"

static void text_errors_contain_the_line(void **state)
{
    (void)state;
    static const struct {
        const char *name, *content, *message;
    } rows[] = {
        {"x.stl", "", "the file is empty"},
        {"x.stl", "hello", "5 bytes are too few"},
        {"x.stl", "solid a\n", ":2: expected 'facet' or 'endsolid', found the end"},
        {"x.stl", "solid a\nendsolid a\n", "has no triangle"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n", ":4: expected a number, found 'zero'"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n", ":4: expected a number, found 'nan'"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 1,5 0\n", ":4: expected a number, found '1,5'"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 1e39 0\n", ":4: expected a number, found '1e39'"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0x1 0\n", ":4: expected a number"},
        {"x.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
         ":6: expected 'vertex', found 'endloop'"},
        {"x.stl", "solid a\n" FACET, ":9: expected 'facet' or 'endsolid', found the end"},
        {"x.stl", "solid a\n" FACET "endsolid\nsolid b\n" FACET "junk\n",
         ":18: expected 'facet' or 'endsolid', found 'junk'"},
        {"x.stl", "solid a\n" FACET "endsolid\nmore\n", ":10: expected 'solid', found 'more'"},
        {"x.obj", "", "the file is empty"},
        {"x.obj", "v 0 0 0\n", "has no face"},
        {"x.obj", "v 0 0\n", ":1: a vertex needs three numbers, found 2"},
        {"x.obj", "v 0 0 inf\n", ":1: expected a number, found 'inf'"},
        {"x.obj", "v 0 0 0 2\n", ":1: a vertex of weight '2'"},
        {"x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", ":4: a face refers to vertex 4; the file has 3"},
        {"x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", ":4: '0' is not the number of a vertex"},
        {"x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", ":4: '-4' is not the number of a vertex"},
        {"x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", ":4: '99999999999999999999'"},
        {"x.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "has no face"},
        {"x.ply", "plyx\n", "begins with a line 'ply'"},
        {"x.ply", "ply\nformat ascii 1.0\n", "no end_header"},
        {"x.ply", "ply\nformat morse 1.0\n", ":2: expected ascii, binary_little_endian"},
        {"x.ply", "ply\nend_header\n", "has no format"},
        {"x.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\n", ":3: expected a count of elements"},
        {"x.ply", "ply\nformat ascii 1.0\nelement vertex -3\n", ":3: expected a count"},
        {"x.ply", "ply\nformat ascii 1.0\nproperty float x\n", ":3: a property before any element"},
        {"x.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty half x\n", ":4: expected a type"},
        {"x.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty list float int x\n",
         ":4: expected an integer type"},
        {"x.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n", "x, y and z"},
        {"x.ply", PLY_HEAD "element vertex 3\n", ":7: duplicate name of an element"},
        {"x.ply", PLY_HEAD "property float x\n" PLY_FACE, "x, y and z"},
        {"x.ply", PLY_HEAD "end_header\n0 0 0\n1 0 0\n0 1 0\n", "a cloud of points has no inside"},
        {"x.ply", PLY_HEAD "junk\n", ":7: expected format, element"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 1\n", ":13: expected a number, found the end"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", ":12: expected a number, found 'nan'"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
         ":13: face 0: expected indices of vertices below 3"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
         ":13: face 0: expected indices of vertices below 3"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", ":13: face 0: expected a count"},
        {"x.ply", PLY_HEAD PLY_FACE "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "has no face"},
        {"x.3ds", "MMMMMM", "byte 2: the header states"},
        {"x.3ds", "no", "truncated after 2 bytes; a 3DS file begins with 6 bytes of header"},
        {"x.3ds", "NNMMMM", "byte 0: the first chunk has the kind 4E4E; expected 4D4D, the kind of a 3DS file"},
        {"x.off", "OFF\n3 1 0\n", "'.off' is not a supported mesh format"},
        {"noextension", "v 0 0 0\n", "'no extension' is not a supported mesh format"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        ost_mesh mesh;
        const char *path = scratch_write(folder, rows[i].name, rows[i].content, strlen(rows[i].content));
        ost_status status = ost_mesh_read(path, OST_UNIT_MM, &mesh, NULL, &err);
        assert_int_equal(status, OST_ERR_INPUT);
        if (strstr(err.text, path) != err.text || !strstr(err.text, rows[i].message))
            fail_msg("row %zu: the error '%s' does not contain '%s'", i, err.text, rows[i].message);
    }
}

static void binary_errors_contain_the_byte(void **state)
{
    (void)state;
    static bytes b;
    const float nan_value = __builtin_nanf(""), infinite = -__builtin_inff();
    const uint32_t huge = 4000000000u;
    static const struct {
        int which;
        size_t at;
        const char *message;
    } rows[] = {
        {0, 80, "byte 80: the header states 4000000000 triangles"},
        {0, 84 + 50 * 7 + 12 + 16, "byte 462: triangle 7 has a coordinate that is not a number"},
        {0, 84 + 50 * 7 + 12 + 16, "byte 462: triangle 7 has a coordinate that is infinite"},
        {10, 2, "byte 2: the header states 4000000000 bytes"},
        {10, 8, "byte 6: a chunk whose size"},
        {10, 36, "byte 36: a coordinate that is no finite number"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ost_error err = {0};
        ost_mesh mesh;
        make_file(rows[i].which, &b);
        const bool number = strstr(rows[i].message, "coordinate") != NULL;
        const float *value = strstr(rows[i].message, "infinite") ? &infinite : &nan_value;
        memcpy(b.at + rows[i].at, number ? (const void *)value : (const void *)&huge, 4);
        ost_status status = ost_mesh_read(scratch_write(folder, names[rows[i].which], b.at, b.size), OST_UNIT_AUTO,
                                          &mesh, NULL, &err);
        assert_int_equal(status, OST_ERR_INPUT);
        if (!strstr(err.text, rows[i].message))
            fail_msg("row %zu: the error '%s' does not contain '%s'", i, err.text, rows[i].message);
    }
    ost_error err = {0};
    ost_mesh mesh;
    assert_int_equal(ost_mesh_read(folder, OST_UNIT_AUTO, &mesh, NULL, &err), OST_ERR_IO);
    assert_int_equal(ost_mesh_read("/dev/null/a.stl", OST_UNIT_AUTO, &mesh, NULL, &err), OST_ERR_IO);
    assert_int_equal(ost_mesh_read("/dev/zero", OST_UNIT_AUTO, &mesh, NULL, &err), OST_ERR_IO);
}

static void bodies_are_joined_and_counted(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_mesh mesh;
    ost_mesh_report report;
    static const char two_solids[] = "solid a\n" FACET "endsolid\nsolid\nendsolid\nsolid b\n" FACET
                                     "facet\nnormal 0\n0\n1 outer\nloop vertex\n0 .0 -.0 vertex 9.\n0 0\nvertex 0 9e0 "
                                     "0 endloop endfacet\nendsolid b\n";
    assert_ok(ost_mesh_read(scratch_write(folder, "two.stl", two_solids, sizeof two_solids - 1), OST_UNIT_AUTO, &mesh,
                            &report, &err));
    assert_int_equal(mesh.triangle_count, 3);
    assert_int_equal(mesh.vertex_count, 3);
    assert_int_equal(report.bodies, 2); /* the second of the three bodies has no triangle and is not counted */
    assert_string_equal(report.format, "STL (ASCII)");
    ost_mesh_free(&mesh);
    static const char two_objects[] = "o a\nv 0 0 0\nv 9 0 0\nv .0 9. +0\nf 1 2 3\no empty\no b\nv 0 0 9\nf 1 2 -1\n";
    assert_ok(ost_mesh_read(scratch_write(folder, "two.obj", two_objects, sizeof two_objects - 1), OST_UNIT_AUTO, &mesh,
                            &report, &err));
    assert_int_equal(mesh.triangle_count, 2);
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(report.bodies, 2);
    ost_mesh_free(&mesh);
}

static void written_stl_is_restored(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_mesh made, read;
    char path[4200], again[4200];
    snprintf(path, sizeof path, "%s/reamer.stl", folder);
    snprintf(again, sizeof again, "%s/again.stl", folder);
    assert_ok(ost_tool_make(OST_TOOL_REAMER, NULL, &made, &err));
    assert_ok(ost_mesh_write_stl(path, &made, &err));
    assert_ok(ost_mesh_read(path, OST_UNIT_AUTO, &read, NULL, &err));
    assert_int_equal(read.triangle_count, made.triangle_count);
    assert_int_equal(read.vertex_count, made.vertex_count);
    for (size_t t = 0; t < made.triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            const ost_pm3 *p = &made.vertices[made.triangles[t][c]], *q = &read.vertices[read.triangles[t][c]];
            assert_true(llabs(p->x - q->x) <= 1000 && llabs(p->y - q->y) <= 1000 && llabs(p->z - q->z) <= 1000);
        }
    assert_ok(ost_mesh_write_stl(again, &read, &err));
    size_t size[2];
    char *content[2] = {scratch_read(path, &size[0]), scratch_read(again, &size[1])};
    assert_int_equal(size[0], 84 + 50 * made.triangle_count);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(content[0], content[1], size[0]);
    assert_memory_not_equal(content[0], "solid", 5);
    /* Normals must point outward: the normal of a triangle at the lower pole points down. */
    float z;
    memcpy(&z, content[0] + 84 + 8, 4);
    assert_true(z < -0.9f);
    free(content[0]);
    free(content[1]);
    made.triangles[5][1] = (uint32_t)made.vertex_count;
    assert_int_equal(ost_mesh_write_stl(path, &made, &err), OST_ERR_USAGE);
    assert_int_equal(ost_mesh_write_stl("/dev/null/a.stl", &read, &err), OST_ERR_IO);
    ost_mesh_free(&made);
    ost_mesh_free(&read);
}

#else

static void without_assimp(void **state)
{
    (void)state;
    static bytes b;
    ost_error err = {0};
    ost_mesh mesh;
    for (int which = 0; which < FILES; which++) {
        make_file(which, &b);
        const char *path = scratch_write(folder, names[which], b.at, b.size);
        assert_int_equal(ost_mesh_read(path, OST_UNIT_AUTO, &mesh, NULL, &err), OST_ERR_UNAVAILABLE);
        assert_non_null(strstr(err.text, "libassimp-dev"));
    }
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef HAVE_ASSIMP
        cmocka_unit_test(every_format_reads_the_same_box),
        cmocka_unit_test(damaged_files_give_an_error_or_a_valid_mesh),
        cmocka_unit_test(units_are_given_or_inferred),
        cmocka_unit_test(text_errors_contain_the_line),
        cmocka_unit_test(binary_errors_contain_the_byte),
        cmocka_unit_test(bodies_are_joined_and_counted),
        cmocka_unit_test(written_stl_is_restored),
#else
        cmocka_unit_test(without_assimp),
#endif
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
