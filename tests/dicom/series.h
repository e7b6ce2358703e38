/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Describes a DICOM series that the program make_series writes. The series may have deliberate faults. Every
 * member is set by a word KEY=VALUE of the command line; series.cpp contains the table of keys.
 *
 * Voxel (i, j, k) is column i of row j of slice k. Its centre is at
 *
 *   origin + i * spacing[0] * rows + j * spacing[1] * columns + k * (spacing[2] * normal + tilt * columns)
 *
 * with normal = rows x columns. If neither `smooth` nor `padding` is given, the stored value of the voxel is
 *
 *   values[0] + (13 i + 1009 j + 30011 k + 7 i j k) mod (values[1] - values[0] + 1)
 *
 * Tests compute the expected positions and values from this text. Slice k is stored in the file prefix + (1741 * k + 5)
 * mod 4096, which is also its instance number, so that neither the names nor the instance numbers are in order of
 * position.
 */
#ifndef OST_TESTS_DICOM_SERIES_H
#define OST_TESTS_DICOM_SERIES_H

#include <cstdint>
#include <string>
#include <vector>

enum { EVERY_SLICE = -1 };

/* A change of one slice or of every slice. The text is the part after "KEY=K:". */
struct change {
    std::string key;
    int slice;
    std::string text;
};

struct series {
    int dims[3] = {8, 6, 5};
    double spacing[3] = {0.5, 0.5, 0.5}; /* in mm, between columns, rows and slices */
    double origin[3] = {-10.25, 20.5, -30};
    double rows[3] = {1, 0, 0}, columns[3] = {0, 1, 0}; /* directions of a row and of a column, in LPS */
    double tilt = 0;                     /* displacement along `columns` from slice to slice, in mm */
    double thickness = 0;                /* in mm; 0 means spacing[2] */
    int bits = 12, allocated = 16, high = 0; /* BitsStored, BitsAllocated, HighBit; if high is 0, HighBit is bits - 1 */
    bool is_signed = false, junk = false;    /* `junk`: true if all bits outside BitsStored are inverted */
    int values[2] = {0, 3000};
    int smooth = 0;                      /* if not 0, the stored value is values[0] + smooth * (i + j + k) */
    std::vector<std::string> slope = {"1"}, intercept = {"-1024"}; /* slice k uses element k % size() of each list */
    /* padding value, which is stored in column 0; a second number is the padding range limit, stored in column 1 */
    std::vector<int> padding;
    std::string syntax = "explicit";
    int fragment = 0;                    /* size of a fragment of a compressed frame in kB; 0 means one fragment */
    bool offsets = true;                 /* if true, the basic offset table is written */
    bool multiframe = false;             /* if true, one enhanced CT file is written instead of one file per slice */
    /* series number, and parts of the UIDs of study, patient and frame of reference */
    int number = 1, study = 1, patient = 1, frame = 1;
    std::string description = "bone", modality = "CT", kernel = "B60s", prefix = "IM";
    std::string photometric = "MONOCHROME2";
    std::vector<change> changes;
};

/* A slice in the form in which it is written: its index, its position, and the name of its file. */
struct slice {
    int index;
    double position[3];
    int instance;
    std::string file;
    int delta;   /* number that is added to every stored value */
    int size[2]; /* numbers of columns and rows */
};

/* Reads the command line's words after the folder. Returns false with a message if a word is wrong. */
bool read_words(int count, char *const *words, series *out, std::string *error);

/* Returns the slices in order of instance number, after the changes `drop`, `double`, `move` and `size`. */
std::vector<slice> plan_slices(const series &s);

/* Returns the pixels of a slice with 8 or 16 bits each, in the byte order of the host, which is little-endian. */
std::vector<uint8_t> make_pixels(const series &s, const slice &at);

/* Converts a length in mm to a decimal string with at most six decimal places. */
std::string decimal(double mm);

#endif
