/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as the answers of osteon-dicom, the process that parses DICOM files. The library
 * must refuse the answers with an error of one line, or read a volume that is unchanged after it has been
 * written as NRRD and read again.
 *
 *   input: 2 bytes, the size of the first answer | the answer to the request SCAN | the answer to the request READ
 *
 * The fuzz target also acts as this process: if it is run under the name osteon-dicom, a constructor
 * answers the request and exits before main. The files of the scanned folder are empty, because they are
 * never read.
 */
#include "fuzz.h"

#include <errno.h> /* declares program_invocation_name */
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include <osteon/io.h>

#include "io/dicom/protocol.h"

enum { FILES = 3, COLUMNS = 4, ROWS = 3, PIXEL_BYTES = 2 * COLUMNS * ROWS };

const char *const fuzz_words[] = {"0.5", "-0.25", "1e300", "nan", "100000", "0.0000001", "-8000", "0.7071067811865476",
                                  "1.2.840.10008.1.2.1", "CT", "\1\0\0\0\0\0\0\0\4\0\0\0", "\3\0\0\0", NULL};

/* ---------------------------------------------------------------- process */

/* Reads the request from standard input and writes the part of the fuzz input that answers this request. The fuzz input
   is in a file next to the program. */
static void answer(void)
{
    ost_dicom_request request = {0};
    static uint8_t input[1 << 17];
    char path[1100];
    snprintf(path, sizeof path, "%.*sanswers", (int)(program_invocation_short_name - program_invocation_name),
             program_invocation_name);
    const int fd = open(path, O_RDONLY);
    const ssize_t size = fd < 0 ? -1 : read(fd, input, sizeof input);
    if (size < 2 || read(STDIN_FILENO, &request, sizeof request) != (ssize_t)sizeof request)
        _exit(3);
    size_t scan = (size_t)(input[0] | input[1] << 8), from = 2, to;
    if (scan > (size_t)size - 2)
        scan = (size_t)size - 2;
    to = request.action == OST_DICOM_SCAN ? 2 + scan : (size_t)size;
    from = request.action == OST_DICOM_SCAN ? 2 : 2 + scan;
    while (from < to) {
        const ssize_t n = write(STDOUT_FILENO, input + from, to - from);
        if (n <= 0)
            break;
        from += (size_t)n;
    }
    _exit(0);
}

__attribute__((constructor)) static void be_the_process(void)
{
    if (strcmp(program_invocation_short_name, "osteon-dicom") == 0)
        answer();
}

/* ------------------------------------------------------------------ seeds */

typedef struct bytes {
    uint8_t *at;
    size_t size, capacity;
} bytes;

static void put(bytes *out, const void *from, size_t size)
{
    if (size > out->capacity - out->size)
        abort();
    memcpy(out->at + out->size, from, size);
    out->size += size;
}

static void put_message(bytes *out, ost_dicom_type type, uint32_t index, const void *payload, size_t size)
{
    const ost_dicom_message message = {.type = type, .index = index, .size = (uint32_t)size};
    put(out, &message, sizeof message);
    if (size)
        put(out, payload, size);
}

static void put_result(bytes *out, uint32_t index, uint32_t result)
{
    put_message(out, OST_DICOM_FILE, index, &result, sizeof result);
}

static ost_dicom_record make_record(uint32_t frame, const char *z)
{
    static const char *const directions[] = {"1", "0", "0", "0", "1", "0"};
    ost_dicom_record r = {.frame = frame, .columns = COLUMNS, .rows = ROWS, .bits_allocated = 16, .bits_stored = 12,
                          .high_bit = 11, .series_number = 3};
    r.flags = OST_DICOM_IMAGE_NUMBERED | OST_DICOM_IMAGE_PADDED;
    for (int i = 0; i < 6; i++)
        strcpy(r.orientation[i], directions[i]);
    strcpy(r.position[0], "-10.25");
    strcpy(r.position[1], "20.5");
    strcpy(r.position[2], z);
    strcpy(r.spacing[0], "0.5");
    strcpy(r.spacing[1], "0.5");
    strcpy(r.slope, "1");
    strcpy(r.intercept, "-1024");
    strcpy(r.syntax, "1.2.840.10008.1.2.1");
    strcpy(r.series_uid, "2.25.1");
    strcpy(r.modality, "CT");
    return r;
}

static void put_pixels(bytes *out)
{
    uint16_t pixels[PIXEL_BYTES / 2];
    for (uint32_t k = 0; k < FILES; k++) {
        for (int v = 0; v < PIXEL_BYTES / 2; v++)
            pixels[v] = (uint16_t)(100 * v + k);
        put_message(out, OST_DICOM_PIXELS, k, pixels, sizeof pixels);
    }
    put_message(out, OST_DICOM_END, 0, NULL, 0);
}

/* Makes three kinds of seeds: answers for one file per slice, for a file with all slices, and for slices that are
   uneven, tilted or damaged. */
size_t fuzz_seed(unsigned index, uint8_t *out, size_t capacity)
{
    static const char *const even[FILES] = {"1", "0.5", "1.5"}, *const uneven[FILES] = {"0", "0.5", "1.6"};
    bytes b = {.at = out, .size = 2, .capacity = capacity};
    if (index > 4 || capacity < 8192)
        return 0;
    for (uint32_t k = 0; k < FILES; k++) {
        ost_dicom_record record = make_record(index == 1 ? k : 0, index == 2 ? uneven[k] : even[k]);
        if (index == 3)
            snprintf(record.position[1], sizeof record.position[1], "%s", uneven[k]);
        if (index == 4 && k == 2)
            record.result = OST_DICOM_RESULT_DAMAGED;
        put_message(&b, OST_DICOM_FRAME, index == 1 ? 0 : k, &record, sizeof record);
        if (index != 1)
            put_result(&b, k, OST_DICOM_RESULT_OK);
    }
    for (uint32_t k = 0; index == 1 && k < FILES; k++)
        put_result(&b, k, k == 0 ? OST_DICOM_RESULT_OK : OST_DICOM_RESULT_NOT_DICOM);
    put_message(&b, OST_DICOM_END, 0, NULL, 0);
    out[0] = (uint8_t)(b.size - 2);
    out[1] = (uint8_t)((b.size - 2) >> 8);
    put_pixels(&b);
    return b.size;
}

/* ----------------------------------------------------------------- target */

static char ct[1024]; /* the scanned folder */

static const char *ct_file(int k)
{
    static char path[1100];
    snprintf(path, sizeof path, "%s/%d", ct, k);
    return path;
}

static void remove_ct(void)
{
    for (int k = 0; k < FILES; k++)
        unlink(ct_file(k));
    rmdir(ct);
}

static void make_folder(void)
{
    if (ct[0])
        return;
    char path[1100], program[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    fuzz_require(n > 0);
    program[n] = '\0';
    snprintf(path, sizeof path, "%s/osteon-dicom", fuzz_folder());
    fuzz_require(symlink(program, path) == 0 && setenv("OSTEON_LIBEXECDIR", fuzz_folder(), 1) == 0);
    snprintf(ct, sizeof ct, "%s/ct", fuzz_folder());
    fuzz_require(mkdir(ct, 0700) == 0 && atexit(remove_ct) == 0);
    for (int k = 0; k < FILES; k++) {
        const int fd = open(ct_file(k), O_WRONLY | O_CREAT, 0600);
        fuzz_require(fd >= 0 && close(fd) == 0);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char again[1100];
    make_folder();
    snprintf(again, sizeof again, "%s/again.nrrd", fuzz_folder());
    fuzz_file("answers", data, size);
    for (int variant = 0; variant < 2; variant++) {
        const ost_volume_options options = {.clamp = variant == 1, .resample_oblique = variant == 1,
                                            .even_slices = variant == 1, .untilt = variant == 1};
        ost_error err = {0};
        ost_volume v, back;
        const ost_status status = ost_volume_read(ct, &options, &v, NULL, &err);
        fuzz_require_error(status, err, fuzz_folder());
        fuzz_require((status == OST_OK) == (v.voxels != NULL));
        if (status == OST_OK) {
            fuzz_require(ost_geometry_check(&v.geometry, ct, &err) == OST_OK);
            fuzz_require(ost_volume_write(again, &v, NULL, &err) == OST_OK);
            fuzz_require(ost_volume_read(again, NULL, &back, NULL, &err) == OST_OK);
            fuzz_require(ost_geometry_equal(&v.geometry, &back.geometry));
            fuzz_require(memcmp(v.voxels, back.voxels, (size_t)ost_dims_count(v.geometry.dims) * 2) == 0);
            ost_volume_free(&back);
        }
        ost_volume_free(&v);
    }
    return 0;
}
