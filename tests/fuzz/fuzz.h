/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzz targets.  Each tests/fuzz/fuzz_X.c defines
 *
 *   LLVMFuzzerTestOneInput   one input; a defect aborts or trips a sanitizer
 *   fuzz_seed                the inputs it starts from, made by code
 *   fuzz_words               words that mutations put in
 *
 * and is built in one of two ways: with --enable-fuzz it links to libFuzzer
 * (seeds for its corpus: build once without, then `fuzz_X --write-seeds DIR`);
 * without it, replay.c has a main that runs every seed and a number of seeded
 * mutations in make check:
 *
 *   tests/fuzz/fuzz_text                   seeds, then mutations; prints its seed
 *   OST_TEST_SEED=7 tests/fuzz/fuzz_text   the same inputs again
 *   OST_FUZZ_RUNS=1000000 ...              more of them
 *   tests/fuzz/fuzz_text FILE...           these inputs, e.g. what libFuzzer found
 */
#ifndef OST_TESTS_FUZZ_H
#define OST_TESTS_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Writes seed number `index` into bytes (at most room) and returns its size; 0 when there are no more. */
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t room);

/* Ends with NULL. */
extern const char *const fuzz_words[];

/*
 * Writes the input to a file of this name in a scratch folder and returns its
 * path.  The folder goes at a normal end; after a crash the last input is
 * still there, and replay has said where.
 */
const char *fuzz_file(const char *name, const uint8_t *data, size_t size);
/* The scratch folder, for files beside it. */
const char *fuzz_folder(void);

/* A property that must hold for every input. */
#define fuzz_require(condition)                                                                              \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);                   \
            abort();                                                                                         \
        }                                                                                                    \
    } while (0)

/* An error is one printable line that names the file, and no success carries one. */
#define fuzz_require_error(status, err, path)                                                                \
    do {                                                                                                     \
        if ((status) != OST_OK) {                                                                            \
            fuzz_require((err).status == (status));                                                          \
            fuzz_require((status) != OST_ERR_INTERNAL);                                                      \
            fuzz_require(strstr((err).text, (path)) != NULL);                                                \
            fuzz_require(strchr((err).text, '\n') == NULL);                                                  \
        }                                                                                                    \
    } while (0)

#endif
