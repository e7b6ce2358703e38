/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a result as files, and reads it again.
 *
 *   result --> ID.json       everything, for programs and for --merge
 *          --> ID.csv        one line per row: the machine, and the value of this run in every column; if the thesis
 *                            states values for a column KEY, the next column, KEY_thesis, contains them
 *          --> ID.svg ...    the plots; ID-2.svg for the second plot of an item
 *          --> pictures      under their own names
 *
 * Every file is written completely or not at all (io/outfile.h). Values have 12 significant digits in CSV and in JSON.
 */
#ifndef OST_REPRODUCTION_WRITE_H
#define OST_REPRODUCTION_WRITE_H

#include "reproduction/plot.h"
#include "reproduction/result.h"

enum { WRITE_FILES = 24, WRITE_NAME = 64, WRITE_PATH = 4096 };

/* The names of the files that were written, relative to the output folder. */
typedef struct write_files {
    int count;
    char name[WRITE_FILES][WRITE_NAME];
} write_files;

/* Writes all files of a result into a folder. *files may be NULL. */
ost_status write_result(const char *folder, const result *r, write_files *files, ost_error *err);

/* Reads the file ID.json and its pictures. The caller must free *out, even after an error. If there is no file, *absent
   is set. If the file is not a result, returns OST_ERR_INPUT with an error that names the file. */
ost_status write_read(const char *folder, const char *id, result *out, bool *absent, ost_error *err);

/* Draws plot number `index` of a result. */
ost_status write_plot(FILE *to, const result *r, int index, ost_error *err);

/* Joins a folder and a name. Returns OST_ERR_RANGE if the path is too long. */
ost_status write_path(char path[WRITE_PATH], const char *folder, const char *name, ost_error *err);

/*
 * Formats a value for the report. Integers have all their digits, with narrow spaces between groups; other values have
 * 3 to 4 significant digits.
 */
enum { WRITE_VALUE = 40 };
const char *write_value(char text[WRITE_VALUE], double value);

#endif
