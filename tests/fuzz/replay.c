/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a fuzz target as a plain check program: first with an empty input and every seed, then with mutations of the
 * seeds. Run k depends only on k and on the random seed, which is printed.
 *
 *   seed k mod count -> 1 to 6 edits -> LLVMFuzzerTestOneInput
 */
#include "fuzz.h"

#include <errno.h>
#include <time.h>

enum { INPUT_MAX = 1 << 16, RUNS = 20000, SECONDS = 4 };

static uint64_t rng;

static uint64_t next(void)
{
    uint64_t z = (rng += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static size_t below(size_t n)
{
    return n ? (size_t)(next() % n) : 0;
}

static uint8_t input[INPUT_MAX];
static size_t input_size;

/* Replaces the `removed` bytes at offset `at` with `count` new bytes, and truncates the result to INPUT_MAX bytes. */
static void splice(size_t at, size_t removed, const uint8_t *bytes, size_t count)
{
    size_t tail = input_size - at - removed;
    if (count > INPUT_MAX - at)
        count = INPUT_MAX - at;
    if (tail > INPUT_MAX - at - count)
        tail = INPUT_MAX - at - count;
    memmove(input + at + count, input + at + removed, tail);
    if (count > 0)
        memcpy(input + at, bytes, count);
    input_size = at + count + tail;
}

static void put_number(void)
{
    static const int64_t numbers[] = {0,      1,          -1,         127,       128,        255,           256,
                                      32767,  32768,      65535,      65536,     INT32_MAX,  INT32_MIN,     UINT32_MAX,
                                      INT64_MAX, INT64_MIN, 16384,    16385,     1000000000, 0x7f800000, 0x7fc00000};
    static const size_t widths[] = {1, 2, 4, 8};
    uint64_t value = (uint64_t)numbers[below(sizeof numbers / sizeof numbers[0])];
    size_t width = widths[below(4)];
    uint8_t bytes[8];
    bool big = next() & 1;
    for (size_t i = 0; i < width; i++)
        bytes[i] = (uint8_t)(value >> 8 * (big ? width - 1 - i : i));
    size_t at = below(input_size + 1), capacity = input_size - at;
    splice(at, width < capacity ? width : capacity, bytes, width);
}

static void edit(void)
{
    size_t at = below(input_size + 1), capacity = input_size - at;
    uint8_t copy[256];
    size_t count = below(sizeof copy);
    switch (below(10)) {
    case 0: /* This edit flips one bit. */
        if (capacity)
            input[at] ^= (uint8_t)(1u << below(8));
        break;
    case 1: /* This edit replaces one byte. */
        if (capacity)
            input[at] = (uint8_t)next();
        break;
    case 2: /* This edit replaces one byte with a character that occurs in text formats. */
        if (capacity)
            input[at] = (uint8_t) "0123456789+-.eE \t,;#\n\r\0\xff"[below(24)];
        break;
    case 3: /* This edit truncates the input. */
        input_size = at;
        break;
    case 4: /* This edit removes a piece. */
        splice(at, below(capacity + 1), NULL, 0);
        break;
    case 5: /* This edit duplicates a piece. */
        count = count < capacity ? count : capacity;
        memcpy(copy, input + at, count);
        splice(below(input_size + 1), 0, copy, count);
        break;
    case 6: /* This edit inserts random bytes. */
        for (size_t i = 0; i < count; i++)
            copy[i] = (uint8_t)next();
        splice(at, 0, copy, count % 16);
        break;
    case 7:
        put_number();
        break;
    default: { /* This edit inserts a word of the format, or replaces a piece with such a word. */
        size_t words = 0;
        while (fuzz_words[words])
            words++;
        if (words) {
            const char *word = fuzz_words[below(words)];
            splice(at, below(2) ? 0 : below(capacity < 16 ? capacity + 1 : 16), (const uint8_t *)word, strlen(word));
        }
    }
    }
}

static int replay_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
        return 99;
    }
    size_t capacity = 0, size = 0;
    uint8_t *bytes = NULL;
    for (size_t n = 1; n > 0; size += n) {
        if (size == capacity) {
            capacity = capacity ? 2 * capacity : 4096;
            uint8_t *more = realloc(bytes, capacity);
            if (!more)
                exit(99);
            bytes = more;
        }
        n = fread(bytes + size, 1, capacity - size, file);
    }
    fclose(file);
    LLVMFuzzerTestOneInput(bytes, size);
    free(bytes);
    return 0;
}

static int write_seeds(const char *to)
{
    for (unsigned i = 0; (input_size = fuzz_seed(i, input, INPUT_MAX)) > 0; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/seed-%u", to, i);
        FILE *file = fopen(path, "wb");
        if (!file || fwrite(input, 1, input_size, file) != input_size || fclose(file) != 0) {
            perror(path);
            return 99;
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--write-seeds") == 0)
        return write_seeds(argv[2]);
    if (argc > 1) {
        for (int i = 1; i < argc; i++)
            if (replay_file(argv[i]) != 0)
                return 99;
        return 0;
    }

    const char *given = getenv("OST_TEST_SEED"), *runs_given = getenv("OST_FUZZ_RUNS");
    uint64_t seed = given ? strtoull(given, NULL, 0) : (uint64_t)time(NULL) * 2654435761u;
    unsigned long runs = runs_given ? strtoul(runs_given, NULL, 0) : RUNS;
    printf("# OST_TEST_SEED=%llu; after a crash the last input is in %s\n", (unsigned long long)seed, fuzz_folder());
    fflush(stdout);

    unsigned seeds = 0;
    LLVMFuzzerTestOneInput(input, 0);
    while ((input_size = fuzz_seed(seeds, input, INPUT_MAX)) > 0) {
        LLVMFuzzerTestOneInput(input, input_size);
        seeds++;
    }
    time_t start = time(NULL);
    unsigned long done = 0;
    for (; seeds > 0 && done < runs && (runs_given || time(NULL) - start <= SECONDS); done++) {
        rng = seed ^ (done * UINT64_C(0xd1342543de82ef95));
        input_size = fuzz_seed((unsigned)(done % seeds), input, INPUT_MAX);
        for (size_t edits = 1 + below(6); edits > 0; edits--)
            edit();
        LLVMFuzzerTestOneInput(input, input_size);
    }
    printf("# %u seeds, %lu mutations\n", seeds, done);
    return seeds > 0 ? 0 : 99;
}
