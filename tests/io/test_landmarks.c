/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests landmarks from files of 3D Slicer and CSV files. The tests read the same four points in
 * every format and coordinate system, files that must be refused, and files with random damage.
 * Covers: REQ-LANDMARKS
 */
#include "volume_files.h"

#include <math.h>

#include "rng.h"

static const struct {
    const char *label;
    ost_landmark_role role;
    double lps[3];
} points[] = {
    {"Glenoid", OST_LANDMARK_GLENOID, {-117.8, 196.5, -159}},
    {"axis_point", OST_LANDMARK_AXIS_POINT, {-97.8, 196.5, -159}},
    {"F-3", OST_LANDMARK_OTHER, {0.125, -1, 2}},
    {"Inferior Angle", OST_LANDMARK_INFERIOR_ANGLE, {-30, 250.000000001, -300.5}},
};
enum { POINTS = sizeof points / sizeof points[0] };

static void put_coordinates(bytes *b, int i, bool ras, const char *between)
{
    char text[200];
    snprintf(text, sizeof text, "%.9f%s%.9f%s%.9f", ras ? -points[i].lps[0] : points[i].lps[0], between,
             ras ? -points[i].lps[1] : points[i].lps[1], between, points[i].lps[2]);
    put_text(b, text);
}

static void put_json(bytes *b, const char *system, bool ras)
{
    put_text(b, "{\"@schema\": \"markups\", \"markups\": [{\"type\": \"Fiducial\",");
    if (system) {
        put_text(b, "\"coordinateSystem\": \"");
        put_text(b, system);
        put_text(b, "\", \"coordinateUnits\": \"mm\",");
    }
    put_text(b, "\"controlPoints\": [{\"label\": \"not placed\", \"position\": null},\n");
    for (int i = 0; i < POINTS; i++) {
        put_text(b, "{\"id\": \"1\", \"positionStatus\": \"defined\", \"label\": \"");
        put_text(b, points[i].label);
        put_text(b, "\", \"position\": [");
        put_coordinates(b, i, ras, ", ");
        put_text(b, i + 1 < POINTS ? "]},\n" : "]}]}]}\n");
    }
}

/* Writes one row per point. A row consists of `before`, the label and the coordinates in either order, and `after`. */
static void put_rows(bytes *b, bool ras, const char *before, const char *after, bool label_last, const char *end)
{
    for (int i = 0; i < POINTS; i++) {
        put_text(b, before);
        if (!label_last) {
            put_text(b, points[i].label);
            put_text(b, ",");
        }
        put_coordinates(b, i, ras, ",");
        put_text(b, after);
        if (label_last)
            put_text(b, points[i].label);
        put_text(b, end);
    }
}

static void assert_points(const char *name)
{
    ost_error err = {0};
    ost_landmarks all;
    if (ost_landmarks_read(at(name), &all, &err) != OST_OK)
        fail_msg("%s was refused: %s", name, err.text);
    assert_int_equal(all.count, POINTS);
    for (int i = 0; i < POINTS; i++) {
        assert_string_equal(all.items[i].label, points[i].label);
        assert_int_equal(all.items[i].role, points[i].role);
        assert_int_equal(all.items[i].at.x, llround(points[i].lps[0] * 1e9));
        assert_int_equal(all.items[i].at.y, llround(points[i].lps[1] * 1e9));
        assert_int_equal(all.items[i].at.z, llround(points[i].lps[2] * 1e9));
    }
    ost_landmarks_free(&all);
}

/* A file that osteon wrote must give the same labels and, to the picometre, the same positions when it is read. */
static void written_landmarks_are_restored(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_landmark items[POINTS];
    memset(items, 0, sizeof items);
    for (int i = 0; i < POINTS; i++) {
        snprintf(items[i].label, sizeof items[i].label, "%s", points[i].label);
        items[i].at = (ost_pm3){llround(points[i].lps[0] * 1e9), llround(points[i].lps[1] * 1e9),
                                llround(points[i].lps[2] * 1e9)};
    }
    const ost_landmarks all = {POINTS, items};
    assert_ok(ost_landmarks_write(at("w.mrk.json"), &all, &err));
    assert_points("w.mrk.json");
    assert_int_equal(ost_landmarks_write(at("no/folder.mrk.json"), &all, &err), OST_ERR_IO);
}

static void every_format_gives_the_same_points(void **state)
{
    (void)state;
    static bytes b;
    static const struct {
        const char *system;
        bool ras;
    } systems[] = {{"LPS", false}, {"RAS", true}, {NULL, false}, {"0", true}, {"1", false}};
    for (size_t s = 0; s < sizeof systems / sizeof systems[0]; s++) {
        b.size = 0;
        put_json(&b, systems[s].system, systems[s].ras);
        write_file("l.mrk.json", b.data, b.size);
        assert_points("l.mrk.json");
        if (!systems[s].system)
            continue;
        b.size = 0;
        put_text(&b, "# Markups fiducial file version = 4.11\r\n# CoordinateSystem = ");
        put_text(&b, systems[s].system);
        put_text(&b, "\r\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\r\n");
        put_rows(&b, systems[s].ras, "vtkMRMLMarkupsNode_1,", ",0,0,0,1,1,1,0,", true, ",\"a, b\",node\r\n");
        write_file("l.fcsv", b.data, b.size);
        assert_points("l.fcsv");
        b.size = 0;
        put_text(&b, "# made by hand\n# CoordinateSystem = ");
        put_text(&b, systems[s].system);
        put_text(&b, "\n");
        put_rows(&b, systems[s].ras, "", "", false, "\n");
        write_file("l.csv", b.data, b.size);
        assert_points("l.csv");
    }
    b.size = 0;
    put_rows(&b, false, " ", "", false, "\n\n");
    write_file("l.csv", b.data, b.size);
    assert_points("l.csv");
    b.size = 0;
    put_text(&b, "\xef\xbb\xbfname,x_mm,y_mm,z_mm\n");
    put_rows(&b, false, "", ",7", false, "\n");
    write_file("l.csv", b.data, b.size);
    assert_points("l.csv");
    b.size = 0;
    put_text(&b, "label,r,a,s,defined,selected\n");
    put_rows(&b, true, "", ",1,1", false, "\n");
    write_file("l.csv", b.data, b.size);
    assert_points("l.csv");
}

static void labels_are_recognized(void **state)
{
    (void)state;
    static const struct {
        const char *label;
        ost_landmark_role role;
    } cases[] = {{"GLENOID-CENTRE", OST_LANDMARK_GLENOID},
                 {"gc", OST_LANDMARK_GLENOID},
                 {"Axis", OST_LANDMARK_AXIS_POINT},
                 {"Trigonum spinae", OST_LANDMARK_TRIGONUM},
                 {"root of Spine", OST_LANDMARK_TRIGONUM},
                 {"TS", OST_LANDMARK_TRIGONUM},
                 {"AI", OST_LANDMARK_INFERIOR_ANGLE},
                 {"inferior_angle", OST_LANDMARK_INFERIOR_ANGLE},
                 {"", OST_LANDMARK_OTHER},
                 {"glenoid 2", OST_LANDMARK_OTHER},
                 {"a label that is longer than any that has a meaning", OST_LANDMARK_OTHER}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_int_equal(ost_landmark_role_of(cases[i].label), cases[i].role);
}

static void refuses_invalid_files(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text, *message;
    } cases[] = {
        {"e.csv", "", "no landmarks in the file"},
        {"e.csv", "# nothing\n", "no landmarks in the file"},
        {"e.csv", "glenoid,1,2\n", ":1: 3 columns; expected the z coordinate in column 4"},
        {"e.csv", "glenoid,1,2,3\nGC,1,2,4\n", "e.csv:2: 'glenoid' and 'GC' name the same landmark"},
        {"e.csv", "glenoid,1,2,nan\n", "column 4, 'nan', is not a length"},
        {"e.csv", "glenoid,1,2,8001\n", "column 4, '8001', is not a length"},
        {"e.csv", "# CoordinateSystem = IJK\nglenoid,1,2,3\n", ":1: CoordinateSystem is 'IJK'"},
        {"e.csv", "# columns = a,b\nglenoid,1,2,3\n", ":1: missing columns; expected label"},
        {"e.fcsv", "id,1,2,3,0,0,0,1,1,1,0,glenoid,,\n", "expected '# CoordinateSystem"},
        {"e.fcsv", "# CoordinateSystem = LPS\nid,1,2,3\n", "4 columns; the label was expected in column 12"},
        {"e.json", "{", "e.json:1: "},
        {"e.json", "{\"markups\": 1}", "no array 'markups'"},
        {"e.json", "{\"markups\": []}", "no landmarks in the file"},
        {"e.json", "{\"markups\": [{\"coordinateSystem\": \"IJK\"}]}", "coordinateSystem is 'IJK'"},
        {"e.json", "{\"markups\": [{\"coordinateUnits\": \"m\"}]}", "coordinateUnits is 'm'"},
        {"e.json", "{\"markups\": [{\"controlPoints\": [{\"position\": [1, 2]}]}]}",
         "control point 1: the position is not an array of three"},
        {"e.json", "{\"markups\": [{\"controlPoints\": [{\"position\": [1, 2, \"3\"]}]}]}",
         "coordinate 3 of the position"},
        {"e.json", "{\"markups\": [{\"controlPoints\": [{\"position\": [1, 1e300, 3]}]}]}",
         "coordinate 2 of the position"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_landmarks all;
        write_file(cases[i].name, cases[i].text, strlen(cases[i].text));
        assert_int_not_equal(ost_landmarks_read(at(cases[i].name), &all, &err), OST_OK);
        if (!strstr(err.text, cases[i].message))
            fail_msg("the error '%s' does not contain '%s'", err.text, cases[i].message);
        assert_null(all.items);
    }
    ost_error err = {0};
    ost_landmarks all;
    write_file("e.csv", "a\0b", 3);
    assert_int_equal(ost_landmarks_read(at("e.csv"), &all, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "not a text file"));
    assert_int_equal(truncate(at("e.csv"), (4 << 20) + 1), 0);
    assert_int_equal(ost_landmarks_read(at("e.csv"), &all, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "a file of landmarks has at most"));
    assert_int_equal(mkfifo(at("pipe"), 0600), 0);
    assert_int_not_equal(ost_landmarks_read(at("pipe"), &all, &err), OST_OK);
    assert_int_not_equal(ost_landmarks_read(at("absent"), &all, &err), OST_OK);
}

/* Randomly changed, removed or duplicated bytes must give either points or a one-line error, never a crash. */
static void damaged_files_do_not_crash(void **state)
{
    (void)state;
    static bytes complete[2], b;
    test_rng rng = rng_seeded("landmarks");
    put_json(&complete[0], "RAS", true);
    put_text(&complete[1], "# CoordinateSystem = LPS\n");
    put_rows(&complete[1], false, "id,", ",0,0,0,1,1,1,0,", true, ",\"a, b\",node\n");
    for (int n = 0; n < 2000; n++) {
        ost_error err = {0};
        ost_landmarks all;
        b = complete[n % 2];
        for (int64_t k = rng_range(&rng, 0, 5); k >= 0; k--)
            b.data[rng_range(&rng, 0, (int64_t)b.size - 1)] =
                (unsigned char)"{}[]\",:#\n\r=-e9\xff "[rng_range(&rng, 0, 16)];
        if (n % 5 == 0)
            b.size = (size_t)rng_range(&rng, 0, (int64_t)b.size - 1);
        write_file(n % 2 ? "d.fcsv" : "d.json", b.data, b.size);
        if (ost_landmarks_read(at(n % 2 ? "d.fcsv" : "d.json"), &all, &err) != OST_OK) {
            assert_true(err.text[0] != 0);
            assert_null(all.items);
        }
        ost_landmarks_free(&all);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_landmarks_are_restored),
        cmocka_unit_test(every_format_gives_the_same_points),
        cmocka_unit_test(labels_are_recognized),
        cmocka_unit_test(refuses_invalid_files),
        cmocka_unit_test(damaged_files_do_not_crash),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
