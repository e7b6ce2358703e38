/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzz targets. Each tests/fuzz/fuzz_X.c defines
 *
 *   LLVMFuzzerTestOneInput   runs one input; a defect aborts or triggers a sanitizer
 *   fuzz_seed                makes the initial inputs
 *   fuzz_words               contains the words that mutations insert
 *
 * and is built in one of two ways. With --enable-fuzz, the target is linked to libFuzzer; to write the
 * seeds of its corpus, build once without this option and run `fuzz_X --write-seeds DIR`.
 * Without this option, replay.c contains a main that runs every seed and a number of seeded
 * mutations in make check:
 *
 *   tests/fuzz/fuzz_text                   runs the seeds, then mutations; prints the random seed
 *   OST_TEST_SEED=7 tests/fuzz/fuzz_text   repeats the inputs of this random seed
 *   OST_FUZZ_RUNS=1000000 ...              runs more mutations
 *   tests/fuzz/fuzz_text FILE...           runs these inputs, for example those that libFuzzer found
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

/*
 * Writes the seed with this index to `bytes`, which holds `capacity` bytes. Returns the seed's size, or 0 after the
 * last seed.
 */
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

/* Words of the file format that mutations insert. The last entry is NULL. */
extern const char *const fuzz_words[];

/*
 * Writes the input to a file of this name in a scratch folder and returns its path. The folder is removed
 * when the program exits normally. After a crash the folder still contains the last input; replay.c prints
 * its path.
 */
const char *fuzz_file(const char *name, const uint8_t *data, size_t size);
/* Returns the path of the scratch folder, for further files. */
const char *fuzz_folder(void);

/* Aborts if a property that must hold for every input does not hold. */
#define fuzz_require(condition)                                                                              \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            fprintf(stderr, "%s:%d: the condition does not hold: %s\n", __FILE__, __LINE__, #condition);     \
            abort();                                                                                         \
        }                                                                                                    \
    } while (0)

/*
 * Checks the error after a call that failed. The error must have the status that the call returned, which
 * must not be OST_ERR_INTERNAL. The error's text must be one line that contains the path.
 */
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
