/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Helpers for tests that build volume files byte by byte: a scratch folder, functions that append
 * numbers, text and compressed data to a buffer, and checks of the volume that is read.
 */
#ifndef OST_TESTS_VOLUME_FILES_H
#define OST_TESTS_VOLUME_FILES_H

#include "config.h"
#include "harness.h"

#include <ftw.h>
#include <sys/stat.h>
#include <unistd.h>

#include <zlib.h>

#include <osteon/io.h>

#ifdef HAVE_NIFTI
enum { HAS_NIFTI = 1 };
#else
enum { HAS_NIFTI = 0 };
#endif

static char scratch[256];

static inline int remove_one(const char *path, const struct stat *st, int type, struct FTW *walk)
{
    (void)st, (void)type, (void)walk;
    return remove(path);
}

static inline int make_scratch(void **state)
{
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(scratch, sizeof scratch, "%s/osteon-io-XXXXXX", base && *base ? base : "/tmp");
    return mkdtemp(scratch) ? 0 : -1;
}

static inline int drop_scratch(void **state)
{
    (void)state;
    return scratch[0] ? nftw(scratch, remove_one, 8, FTW_DEPTH | FTW_PHYS) : 0;
}

/* Returns a path in the scratch folder. At most four results are valid at the same time. */
static inline const char *at(const char *name)
{
    static char paths[4][600];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", scratch, name);
    return path;
}

/* A buffer to which the functions put_... append bytes. */
typedef struct bytes {
    size_t size;
    unsigned char data[1 << 16];
} bytes;

static inline void put_bytes(bytes *b, const void *data, size_t size)
{
    assert_true(b->size + size <= sizeof b->data);
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static inline void put_text(bytes *b, const char *text)
{
    put_bytes(b, text, strlen(text));
}

static inline void write_file(const char *name, const void *data, size_t size)
{
    FILE *file = fopen(at(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Appends a compressed stream to out; window_bits is the argument of deflateInit2. */
static inline void put_deflated(bytes *out, const void *data, size_t size, int window_bits)
{
    z_stream z = {0};
    assert_int_equal(deflateInit2(&z, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = (unsigned char *)(uintptr_t)data;
    z.avail_in = (uInt)size;
    z.next_out = out->data + out->size;
    z.avail_out = (uInt)(sizeof out->data - out->size);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    out->size = sizeof out->data - z.avail_out;
    deflateEnd(&z);
}

/* Appends one gzip member to out. */
static inline void put_gzip(bytes *out, const void *data, size_t size)
{
    put_deflated(out, data, size, 15 + 16);
}

/* Appends the lowest `size` bytes of `bits`. If `big` is true, the most significant byte is first; otherwise, the least
   significant byte is first. */
static inline void put_bits(bytes *b, uint64_t bits, size_t size, bool big)
{
    for (size_t i = 0; i < size; i++) {
        unsigned char byte = (unsigned char)(bits >> 8 * (big ? size - 1 - i : i));
        put_bytes(b, &byte, 1);
    }
}

static inline uint64_t float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline uint64_t double_bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/*
 * Checks that reading fails with the status `expected` and that the error contains the name of
 * the file and the text `words`.
 */
static inline void assert_refused(const char *path, const ost_volume_options *options, ost_status expected,
                                  const char *words)
{
    ost_error err = {0};
    ost_volume volume;
    ost_status status = ost_volume_read(path, options, &volume, NULL, &err);
    if (status == OST_OK)
        fail_msg("%s was read, though it should say '%s'", path, words);
    if (status != expected || !strstr(err.text, words))
        fail_msg("%s: %s (%s), but %s with '%s' was expected", path, ost_status_name(status), err.text,
                 ost_status_name(expected), words);
    assert_null(volume.voxels);
    assert_int_equal(err.status, status);
    assert_null(strchr(err.text, '\n'));
    assert_non_null(strstr(err.text, scratch));
}

static inline void assert_volumes_equal(const ost_volume *a, const ost_volume *b)
{
    assert_true(ost_geometry_equal(&a->geometry, &b->geometry));
    assert_memory_equal(a->voxels, b->voxels, (size_t)ost_dims_count(a->geometry.dims) * sizeof *a->voxels);
    assert_int_equal(a->meta.count, b->meta.count);
    for (int i = 0; i < a->meta.count; i++)
        assert_string_equal(ost_meta_get(&b->meta, a->meta.entry[i].key), a->meta.entry[i].value);
}

#endif
