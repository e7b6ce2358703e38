/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the library's side of the DICOM reader on records that the test makes: series, order, geometry,
 * faults, densities and resampling. Neither DCMTK nor osteon-dicom is needed.
 *
 * Expected values are derived by hand from the positions in the records. The file has more than 500 lines
 * because each fault needs a record and a message.
 *
 * Covers: AR-DCM-1, AR-DCM-2, AR-DCM-3, AR-DCM-4, AR-DCM-5, REQ-DICOM
 */
#include "harness.h"

#include "dicom_records.h"
#include "io/dicom/density.h"
#include "io/dicom/series.h"
#include "io/dicom/slices.h"
#include "io/dicom/stack.h"

enum { FILES = 64 };
#define MM OST_PM_PER_MM

/* A scan of records. Each record is from a separate file: "f0", "f1", ... */
static ost_dicom_scan scan;
static ost_error err;

static int begin(void **state)
{
    (void)state;
    scan = (ost_dicom_scan){.path = "folder"};
    scan.files.path = calloc(FILES, sizeof *scan.files.path);
    err = (ost_error){0};
    return scan.files.path ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    ost_dicom_scan_free(&scan);
    return 0;
}

static void add(const ost_dicom_record *record)
{
    char name[8];
    snprintf(name, sizeof name, "f%zu", scan.files.count);
    assert_true(scan.files.count < FILES);
    scan.files.path[scan.files.count] = strdup(name);
    assert_ok(ost_dicom_scan_add(&scan, scan.files.count++, record, &err));
}

static void add_at(const char *z)
{
    const ost_dicom_record r = record_at(z);
    add(&r);
}

/* Selects the only series of the scan and makes its stack. */
static ost_status make(const ost_volume_options *options, ost_dicom_stack *stack, ost_dicom_report *report)
{
    size_t series;
    *stack = (ost_dicom_stack){0};
    ost_status status = ost_dicom_series_select(&scan, NULL, &series, &err);
    return status == OST_OK ? ost_dicom_stack_make(&scan, series, options, stack, report, &err) : status;
}

/* Checks that the stack is refused with a message that contains the text. */
static void refused(const char *text)
{
    ost_dicom_stack stack;
    ost_dicom_report report;
    const ost_status status = make(NULL, &stack, &report);
    ost_dicom_stack_free(&stack);
    if (status == OST_OK || !strstr(err.text, text))
        fail_msg("expected '%s', got status %d: %s", text, (int)status, err.text);
}

/* ------------------------------------------------------------------- series */

static void series_selection(void **state)
{
    (void)state;
    ost_dicom_record other = record_at("0");
    size_t series;
    add_at("0");
    add_at("1");
    assert_ok(ost_dicom_series_select(&scan, NULL, &series, &err));
    assert_int_equal(series, 0);
    snprintf(other.series_uid, sizeof other.series_uid, "1.2.4");
    snprintf(other.description, sizeof other.description, "Bone");
    other.series_number = 9;
    add(&other);
    /* A series of one image is not a volume, so the other series is selected. */
    assert_ok(ost_dicom_series_select(&scan, NULL, &series, &err));
    assert_int_equal(series, 0);
    add(&other);
    assert_int_equal(ost_dicom_series_select(&scan, NULL, &series, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "2 series that are volumes (numbers 7, 9)"));
    assert_null(strstr(err.text, "Bone"));
    static const char *const keys[] = {"9", "Bone", "1.2.4"};
    for (int i = 0; i < 3; i++) {
        assert_ok(ost_dicom_series_select(&scan, keys[i], &series, &err));
        assert_int_equal(series, 1);
    }
    assert_int_equal(ost_dicom_series_select(&scan, "8", &series, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "no series has the number, description or UID '8'"));
    snprintf(other.series_uid, sizeof other.series_uid, "1.2.5");
    add(&other);
    assert_int_equal(ost_dicom_series_select(&scan, "Bone", &series, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "2 series match"));
}

/* Files without a SeriesInstanceUID are grouped by study and number. */
static void series_without_uid(void **state)
{
    (void)state;
    ost_dicom_record r = record_at("0");
    r.series_uid[0] = '\0';
    add(&r);
    add(&r);
    r.series_number = 8;
    add(&r);
    r.study[0] = 99;
    add(&r);
    assert_int_equal(scan.series_count, 3);
    assert_int_equal(scan.series[0].images, 2);
}

static void refuses_series_without_a_volume(void **state)
{
    (void)state;
    refused("the folder contains no file");
    scan.files.count = 2;
    refused("contains no DICOM image; 2 files were examined");
    scan.files.count = 0;
    add_at("0");
    refused("series 7 has one image");
}

/* -------------------------------------------------------------------- order */

/* The order of the files differs from the order of the slices. The positions are decimals of different lengths. */
static void order_and_geometry(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    static const char *const z[] = {"-3.10", "-5.6", "-1.85e0", "-4.350000", "-6.85"};
    for (int i = 0; i < 5; i++)
        add_at(z[i]);
    assert_ok(make(NULL, &stack, &report));
    static const uint32_t files[] = {4, 1, 3, 0, 2};
    assert_int_equal(stack.slice_count, 5);
    for (int i = 0; i < 5; i++)
        assert_int_equal(stack.images[i]->file, files[i]);
    assert_int_equal(stack.affine.column[0][0], MM / 2);
    assert_int_equal(stack.affine.column[1][1], MM / 4 * 3);
    assert_int_equal(stack.affine.column[2][2], MM / 4 * 5);
    assert_int_equal(stack.affine.origin[2], -685 * MM / 100);
    assert_int_equal(stack.sizes[0], 4);
    assert_int_equal(stack.sizes[1], 3);
    assert_int_equal(stack.sizes[2], 5);
    assert_int_equal(report.images, 5);
    assert_int_equal(report.largest_gap, MM / 4 * 5);
    ost_dicom_stack_free(&stack);
}

/* Tests slices in a coronal plane. The normal (1,0,0) x (0,0,-1) points to +y, so the first slice has the lowest y. */
static void coronal_slices(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    for (int i = 0; i < 3; i++) {
        ost_dicom_record r = record_at("0");
        snprintf(r.position[1], sizeof r.position[1], "%d", 20 - 2 * i);
        snprintf(r.orientation[4], sizeof r.orientation[4], "0");
        snprintf(r.orientation[5], sizeof r.orientation[5], "-1");
        add(&r);
    }
    assert_ok(make(NULL, &stack, &report));
    assert_int_equal(stack.images[0]->file, 2);
    assert_int_equal(stack.affine.column[1][2], -MM / 4 * 3);
    assert_int_equal(stack.affine.column[2][1], 2 * MM);
    assert_int_equal(stack.affine.origin[1], 16 * MM);
    ost_dicom_stack_free(&stack);
}

/* ------------------------------------------------------------------- faults */

static void unevenly_spaced_slices(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    const ost_volume_options even = {.even_slices = true};
    static const char *const z[] = {"0", "1", "2", "4", "5"};
    for (int i = 0; i < 5; i++)
        add_at(z[i]);
    refused("f3: lies 2 mm after f2, but most slices are 1 mm apart: 1 slice is missing");
    assert_ok(make(&even, &stack, &report));
    assert_true(stack.evened);
    assert_int_equal(stack.sizes[2], 6);
    assert_int_equal(stack.affine.column[2][2], MM);
    assert_int_equal(report.largest_gap, 2 * MM);
    ost_dicom_stack_free(&stack);
}

static void refuses_irregular_slice_positions(void **state)
{
    (void)state;
    static const char *const z[] = {"0", "1", "2.3", "3", "4"};
    for (int i = 0; i < 5; i++)
        add_at(z[i]);
    refused("f2: lies 0.3 mm off its position in an even stack of slices 1 mm apart");
}

/* Tests positions that a scanner rounded to 0.01 mm. They must be accepted as equidistant: slices 0.625 mm apart are
   at 0, 0.63, 1.25, 1.88 and 2.5 mm. */
static void rounded_positions(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    static const char *const z[] = {"0", "0.63", "1.25", "1.88", "2.5"};
    for (int i = 0; i < 5; i++)
        add_at(z[i]);
    assert_ok(make(NULL, &stack, &report));
    assert_int_equal(stack.affine.column[2][2], 625 * MM / 1000);
    ost_dicom_stack_free(&stack);
}

static void duplicate_slices(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    static const char *const z[] = {"0", "1", "1", "2"};
    for (int i = 0; i < 4; i++)
        add_at(z[i]);
    assert_ok(make(NULL, &stack, &report));
    assert_int_equal(stack.slice_count, 3);
    assert_int_equal(stack.slices[1].doubles, 1);
    assert_int_equal(report.doubled, 1);
    ost_dicom_stack_free(&stack);
}

/* Tests slices that are 1 mm apart along z. Along y, each slice is displaced by 0.25 mm relative to the previous one.
   The tilt is atan(0.25) = 14.04 degrees. */
static void tilted_slices(void **state)
{
    (void)state;
    ost_dicom_stack stack;
    ost_dicom_report report;
    const ost_volume_options untilt = {.untilt = true};
    for (int i = 0; i < 5; i++) {
        char text[16];
        snprintf(text, sizeof text, "%d", i);
        ost_dicom_record r = record_at(text);
        snprintf(r.position[1], sizeof r.position[1], "%g", 20 + 0.25 * i);
        add(&r);
    }
    refused("tilted by 14.04 degrees (each lies 0.25 mm beside the one before it)");
    assert_ok(make(&untilt, &stack, &report));
    assert_true(stack.untilted);
    /* The last slice is displaced by 1 mm relative to the first. This is between one and two rows of 0.75 mm, so two
       rows are added after the last row. */
    assert_int_equal(stack.sizes[0], 4);
    assert_int_equal(stack.sizes[1], 5);
    assert_int_equal(stack.margin[1], 0);
    assert_int_equal(stack.affine.column[2][1], 0);
    assert_int_equal(stack.affine.column[2][2], MM);
    assert_int_equal(report.sheared, MM);
    ost_dicom_stack_free(&stack);
}

/* Changes one image of five, checks that the message is reported, and restores the scan. */
static void refused_with_record(ost_dicom_record changed, const char *message)
{
    begin(NULL);
    add_at("0");
    add_at("1");
    snprintf(changed.position[2], sizeof changed.position[2], "2");
    add(&changed);
    add_at("3");
    add_at("4");
    refused(message);
    end(NULL);
}

static void refuses_mixed_series(void **state)
{
    (void)state;
    const ost_dicom_record plain = record_at("2");
    ost_dicom_record r = plain;
    end(NULL);
    r.patient[0] = 9;
    refused_with_record(r, "f2: belongs to another patient than f0");
    r = plain;
    r.study[0] = 9;
    refused_with_record(r, "f2: belongs to another study than f0");
    r = plain;
    r.reference[0] = 9;
    refused_with_record(r, "f2: belongs to another frame of reference than f0");
    r = plain;
    r.columns = 5;
    refused_with_record(r, "f2: has 5 x 3 pixels, but f0 has 4 x 3");
    r = plain;
    snprintf(r.spacing[1], sizeof r.spacing[1], "0.6");
    refused_with_record(r, "f2: its PixelSpacing differs from that of f0");
    r = plain;
    snprintf(r.orientation[0], sizeof r.orientation[0], "0");
    snprintf(r.orientation[1], sizeof r.orientation[1], "1");
    snprintf(r.orientation[3], sizeof r.orientation[3], "1");
    snprintf(r.orientation[4], sizeof r.orientation[4], "0");
    refused_with_record(r, "f2: its ImageOrientationPatient differs from that of f0");
    r = plain;
    snprintf(r.position[0], sizeof r.position[0], "-9");
    refused_with_record(r, "f2: lies 1 mm beside the line through the first and the last slice");
}

static void refuses_invalid_attributes(void **state)
{
    (void)state;
    const ost_dicom_record plain = record_at("2");
    ost_dicom_record r = plain;
    end(NULL);
    r.spacing[0][0] = '\0';
    refused_with_record(r, "f2: has no PixelSpacing");
    r.flags |= OST_DICOM_IMAGE_ENCRYPTED;
    refused_with_record(r, "f2: has no PixelSpacing; its attributes are encrypted");
    r = plain;
    snprintf(r.spacing[0], sizeof r.spacing[0], "0");
    refused_with_record(r, "f2: PixelSpacing '0'; expected two lengths from 0.001 to 100 mm");
    r = plain;
    snprintf(r.position[0], sizeof r.position[0], "8001");
    refused_with_record(r, "f2: ImagePositionPatient '8001'; expected three lengths within 8 m");
    r = plain;
    snprintf(r.position[0], sizeof r.position[0], "1 2");
    refused_with_record(r, "f2: ImagePositionPatient '1 2'");
    r = plain;
    r.orientation[5][0] = '\0';
    refused_with_record(r, "f2: has no ImageOrientationPatient");
    r = plain;
    snprintf(r.orientation[0], sizeof r.orientation[0], "0.9");
    refused_with_record(r, "f2: ImageOrientationPatient is not two perpendicular directions of length 1");
    r = plain;
    snprintf(r.slope, sizeof r.slope, "nan");
    refused_with_record(r, "f2: RescaleSlope 'nan'; expected a number below 9,000,000");
    r = plain;
    r.bits_allocated = 12;
    refused_with_record(r, "f2: 12 bits allocated, 12 stored, high bit 11; expected 8 or 16 allocated");
    r = plain;
    r.columns = 100000;
    refused_with_record(r, "f2: has 16385 columns and 3 rows; expected 1 to 16384");
    r = plain;
    r.flags |= OST_DICOM_IMAGE_LUT;
    refused_with_record(r, "f2: has a ModalityLUTSequence");
    r = plain;
    r.flags |= OST_DICOM_IMAGE_FLOAT;
    refused_with_record(r, "f2: has pixels of floating-point numbers");
    r = plain;
    r.result = OST_DICOM_RESULT_DAMAGED;
    refused_with_record(r, "f2: is a truncated or damaged DICOM file");
    r = plain;
    r.result = OST_DICOM_RESULT_UNSUPPORTED;
    refused_with_record(r, "f2: its pixels are compressed in a way that osteon does not read");
    /* An image that is not a slice leaves a gap between slices, which must be detected. */
    r = plain;
    r.flags |= OST_DICOM_IMAGE_LOCALIZER;
    refused_with_record(r, "f3: lies 2 mm after f1");
    begin(NULL);
}

/* Records that osteon-dicom cannot send are refused. */
static void refuses_invalid_records(void **state)
{
    (void)state;
    ost_dicom_record r = record_at("0");
    scan.files.path[0] = strdup("f0");
    scan.files.count = 1;
    r.result = OST_DICOM_RESULT_COUNT;
    assert_int_equal(ost_dicom_scan_add(&scan, 0, &r, &err), OST_ERR_INPUT);
    r = record_at("0");
    r.flags = 1u << 31;
    assert_int_equal(ost_dicom_scan_add(&scan, 0, &r, &err), OST_ERR_INPUT);
    r = record_at("0");
    memset(r.description, 'a', sizeof r.description);
    assert_int_equal(ost_dicom_scan_add(&scan, 0, &r, &err), OST_ERR_INPUT);
    r = record_at("0");
    memset(r.position[1], '1', sizeof r.position[1]);
    assert_int_equal(ost_dicom_scan_add(&scan, 0, &r, &err), OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "the DICOM parser sent an invalid message (attributes)"));
    assert_int_equal(scan.frame_count, 0);
    r = record_at("0");
    snprintf(r.description, sizeof r.description, "a\033[2Jb");
    assert_ok(ost_dicom_scan_add(&scan, 0, &r, &err));
    assert_string_equal(scan.series[0].description, "a?[2Jb");
}

/* ---------------------------------------------------------------- densities */

static int16_t density_of(ost_dicom_table *table, const ost_dicom_record *record, uint16_t cell)
{
    ost_dicom_frame frame;
    int16_t out = 0;
    int32_t value;
    ost_dicom_frame_of(record, &frame);
    table->of = NULL;
    ost_dicom_table_set(table, &frame);
    assert_int_equal(ost_dicom_convert(table, &cell, 1, &out, &value), 1);
    table->of = NULL;
    return out;
}

static void densities_of_stored_values(void **state)
{
    (void)state;
    ost_dicom_table *table = calloc(1, sizeof *table);
    assert_non_null(table);
    ost_dicom_record r = record_at("0");
    assert_int_equal(density_of(table, &r, 0), -1024);
    assert_int_equal(density_of(table, &r, 4095), 3071);
    assert_int_equal(density_of(table, &r, 0xf000 | 24), -1000); /* bits above the high bit are ignored */
    r.flags |= OST_DICOM_IMAGE_SIGNED;
    assert_int_equal(density_of(table, &r, 0x0fff), -1025); /* -1 in 12 bits */
    assert_int_equal(density_of(table, &r, 0x0800), -2048 - 1024);
    r.high_bit = 15; /* the 12 stored bits are the upper bits */
    assert_int_equal(density_of(table, &r, 0x0010), 1 - 1024);
    assert_int_equal(density_of(table, &r, 0xfff7), -1 - 1024);
    r = record_at("0");
    snprintf(r.slope, sizeof r.slope, "0.5");
    snprintf(r.intercept, sizeof r.intercept, "0");
    assert_int_equal(density_of(table, &r, 1), 0); /* 0.5, 1.5 and 2.5 are ties, which are rounded to the even number */
    assert_int_equal(density_of(table, &r, 3), 2);
    assert_int_equal(density_of(table, &r, 5), 2);
    assert_int_equal(table->rounded, 3);
    /* 1.000000000001 * 2500 - 0.5 is 2.5e-9 above the tie 2499.5. */
    snprintf(r.slope, sizeof r.slope, "1.000000000001");
    snprintf(r.intercept, sizeof r.intercept, "-0.5");
    assert_int_equal(density_of(table, &r, 2501), 2501);
    snprintf(r.slope, sizeof r.slope, "0.999999999999");
    assert_int_equal(density_of(table, &r, 2500), 2499);
    free(table);
}

/* Tests 16-bit padding in an image of 12 bits, and a range of padding values. */
static void padding_values_are_air(void **state)
{
    (void)state;
    ost_dicom_table *table = calloc(1, sizeof *table);
    assert_non_null(table);
    ost_dicom_record r = record_at("0");
    r.flags |= OST_DICOM_IMAGE_PADDED;
    r.padding_first = r.padding_last = 63536; /* the 16 bits of -2000 as an unsigned number */
    assert_int_equal(density_of(table, &r, 63536), OST_DICOM_AIR);
    assert_int_equal(density_of(table, &r, 63536 & 4095), (63536 & 4095) - 1024);
    r.padding_first = 10;
    r.padding_last = 12;
    assert_int_equal(density_of(table, &r, 9), 9 - 1024);
    assert_int_equal(density_of(table, &r, 10), OST_DICOM_AIR);
    assert_int_equal(density_of(table, &r, 12), OST_DICOM_AIR);
    assert_int_equal(density_of(table, &r, 13), 13 - 1024);
    assert_int_equal(table->padded, 3);
    free(table);
}

static void values_beyond_int16(void **state)
{
    (void)state;
    ost_dicom_table *table = calloc(1, sizeof *table);
    assert_non_null(table);
    ost_dicom_record r = record_at("0");
    ost_dicom_frame frame;
    const uint16_t cells[3] = {0, 3, 0};
    int16_t out[3];
    int32_t value = 0;
    snprintf(r.slope, sizeof r.slope, "12000");
    ost_dicom_frame_of(&r, &frame);
    ost_dicom_table_set(table, &frame);
    assert_int_equal(ost_dicom_convert(table, cells, 3, out, &value), 1);
    assert_int_equal(value, 3);
    table->of = NULL;
    table->clamp = true;
    ost_dicom_table_set(table, &frame);
    assert_int_equal(ost_dicom_convert(table, cells, 3, out, &value), 3);
    assert_int_equal(out[1], 32767);
    assert_int_equal(table->clamped, 1);
    free(table);
}

/* --------------------------------------------------------------- resampling */

static void interpolation_between_slices(void **state)
{
    (void)state;
    const int16_t before[] = {0, 10, -32768, 1}, after[] = {10, 0, 32767, 2};
    int16_t out[4];
    ost_dicom_mix(before, after, 4, 1, 4, out);
    const int16_t quarter[] = {2, 8, -16384, 1}; /* the exact values are 2.5, 7.5, -16384.25 and 1.25 */
    assert_memory_equal(out, quarter, sizeof out);
    ost_dicom_mix(before, after, 4, 0, 4, out);
    assert_memory_equal(out, before, sizeof out);
    /* The fraction 2^60 / (2^61 - 1) cannot be reduced and is computed in 128 bits. The results equal those for 1/2. */
    ost_dicom_mix(before, after, 2, INT64_C(1) << 60, (INT64_C(1) << 61) - 1, out);
    assert_int_equal(out[0], 5);
    assert_int_equal(out[1], 5);
}

/* Moves a slice of 3 x 2 pixels by 1.5 pixels along x. Then moves the original slice by -0.5 pixels along both x and
   y. */
static void shear_of_a_slice(void **state)
{
    (void)state;
    const int16_t from[] = {0, 100, 200, 10, 110, 210};
    const ost_pm spacing[2] = {MM, 2 * MM}, none[2] = {0, 0}, drift[2] = {3 * MM / 2, 0}, both[2] = {-MM / 2, -MM};
    const int32_t no_margin[2] = {0, 0}, same[2] = {3, 2}, wide[2] = {5, 2};
    int16_t out[10];
    ost_dicom_shear(from, 3, 2, none, spacing, no_margin, same, out);
    assert_memory_equal(out, from, sizeof from);
    ost_dicom_shear(from, 3, 2, drift, spacing, no_margin, wide, out);
    const int16_t moved[] = {-1024, -1024, 50, 150, -1024, -1024, -1024, 60, 160, -1024};
    assert_memory_equal(out, moved, sizeof out);
    ost_dicom_shear(from, 3, 2, both, spacing, no_margin, same, out);
    const int16_t half[] = {55, 155, -1024, -1024, -1024, -1024};
    assert_memory_equal(out, half, 6 * sizeof *out);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(series_selection),
        TEST(series_without_uid),
        TEST(refuses_series_without_a_volume),
        TEST(order_and_geometry),
        TEST(coronal_slices),
        TEST(unevenly_spaced_slices),
        TEST(refuses_irregular_slice_positions),
        TEST(rounded_positions),
        TEST(duplicate_slices),
        TEST(tilted_slices),
        TEST(refuses_mixed_series),
        TEST(refuses_invalid_attributes),
        TEST(densities_of_stored_values),
        TEST(padding_values_are_air),
        TEST(values_beyond_int16),
        TEST(refuses_invalid_records),
        TEST(interpolation_between_slices),
        TEST(shear_of_a_slice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
