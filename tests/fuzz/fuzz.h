/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzz targets.  Each tests/fuzz/fuzz_X.c defines
 *
 *   LLVMFuzzerTestOneInput   runs one input; a defect aborts or triggers a sanitizer
 *   fuzz_seed                the initial inputs, made by code
 *   fuzz_words               words that mutations insert
 *
 * and is built in one of two ways. With --enable-fuzz it links to libFuzzer (for the seeds of
 * its corpus build once without the option, then run `fuzz_X --write-seeds DIR`). Without it,
 * replay.c has a main that runs every seed and a number of seeded mutations in make check:
 *
 *   tests/fuzz/fuzz_text                   seeds, then mutations; prints its seed
 *   OST_TEST_SEED=7 tests/fuzz/fuzz_text   the same inputs again
 *   OST_FUZZ_RUNS=1000000 ...              more mutations
 *   tests/fuzz/fuzz_text FILE...           these inputs, for example those that libFuzzer found
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

/* Writes seed number `index` into bytes (at most capacity) and returns its size; 0 when there are no more. */
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

/* Words of the format for mutations; the last entry is NULL. */
extern const char *const fuzz_words[];

/*
 * Writes the input to a file of this name in a scratch folder and returns its path. The folder
 * is removed at a normal exit. After a crash it still holds the last input; replay has printed
 * its path.
 */
const char *fuzz_file(const char *name, const uint8_t *data, size_t size);
/* Returns the scratch folder, for further files. */
const char *fuzz_folder(void);

/* Checks a property that must hold for every input. */
#define fuzz_require(condition)                                                                              \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);                   \
            abort();                                                                                         \
        }                                                                                                    \
    } while (0)

/* Checks that a failure has one printable line that names the file, and that a success has no error text. */
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
