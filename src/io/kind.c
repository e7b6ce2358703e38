/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Determines the kind of a file from its first bytes. If these bytes do not identify the kind, the file's name is
 * used.
 *
 *   NRRD0001..5                              NRRD, with attached data or only the header
 *   "ObjectType =", "NDims =" or "Comment =" MetaImage, with attached data or only the header
 *   "DICM" at byte 128; a folder             DICOM
 *   348 or 540, "n+1" "ni1" "n+2" "ni2"      NIfTI; also inside gzip
 *   TIFF or PNG                              a stack; also a folder of such files, and a pattern with '*'
 *   "ply", 4D 4D, "solid ... facet",
 *   84 + 50 n bytes                          meshes
 *   89 "OSTSES" 0A at a multiple of 64       a session, whose first block may be damaged
 *   a first line of numbers                  CT text (4 columns); a path (8 or 9 columns), also inside gzip
 *   a signature of foreign.c                 refused, with the program that converts it
 */
#include <osteon/io.h>

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "core/file.h"
#include "io/dicom/read.h"
#include "io/foreign.h"
#include "io/metaimage/header.h"
#include "io/session/layout.h"
#include "io/stack/names.h"
#include "io/stack/slice.h"
#include "io/text/fields.h"

enum { HEAD = 4096, GZIP_HEAD = 1024 };

static uint32_t le32(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static uint32_t be32(const unsigned char *p)
{
    return p[3] | (uint32_t)p[2] << 8 | (uint32_t)p[1] << 16 | (uint32_t)p[0] << 24;
}

static bool starts(const unsigned char *head, size_t size, const char *word)
{
    size_t length = strlen(word);
    return size >= length && memcmp(head, word, length) == 0;
}

static bool is_nrrd(const unsigned char *head, size_t size)
{
    return starts(head, size, "NRRD000");
}

static bool is_nifti(const unsigned char *head, size_t size)
{
    if (size >= 348 && (le32(head) == 348 || be32(head) == 348))
        return memcmp(head + 344, "n+1", 4) == 0 || memcmp(head + 344, "ni1", 4) == 0;
    if (size >= 12 && (le32(head) == 540 || be32(head) == 540))
        return memcmp(head + 4, "n+2", 4) == 0 || memcmp(head + 4, "ni2", 4) == 0;
    return false;
}

static bool is_session(const unsigned char *head, size_t size)
{
    for (size_t at = 0; at + SESSION_MAGIC <= size; at += SESSION_ALIGN)
        if (memcmp(head + at, session_magic, SESSION_MAGIC) == 0)
            return true;
    return false;
}

static bool is_gzip(const unsigned char *head, size_t size)
{
    return size >= 2 && head[0] == 0x1f && head[1] == 0x8b;
}

/* Unpacks the first bytes of a gzip file. Sets *size to 0 if the data are damaged. */
static ost_status gzip_head(const char *path, int fd, unsigned char head[GZIP_HEAD], size_t *size, ost_error *err)
{
    const int own = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (own < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    gzFile gz = gzdopen(own, "rb");
    if (!gz) {
        close(own);
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for decompression", path);
    }
    const int n = gzread(gz, head, GZIP_HEAD);
    int number = Z_OK;
    gzerror(gz, &number);
    const int error = errno;
    gzclose(gz);
    *size = n > 0 ? (size_t)n : 0;
    if (number == Z_MEM_ERROR)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for decompression", path);
    if (number == Z_ERRNO)
        return ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(error));
    return OST_OK;
}

static bool is_mesh(const unsigned char *head, size_t size, off_t file_size)
{
    if (starts(head, size, "ply\n") || starts(head, size, "ply\r"))
        return true;
    /* a 3DS file begins with the kind of its main chunk, 4D4D, and the size of this chunk, which is the file size */
    if (size >= 6 && head[0] == 0x4d && head[1] == 0x4d && le32(head + 2) == file_size)
        return true;
    if (starts(head, size, "solid") && (memmem(head, size, "facet", 5) || memmem(head, size, "endsolid", 8)))
        return true;
    return size >= 84 && (uint64_t)file_size == 84 + (uint64_t)50 * le32(head + 80);
}

/*
 * Counts the columns of the first line that is not a comment. A column is a number or a word. Sets *path_header to true
 * if the line begins with "t_s". Returns 0 if the bytes are not text.
 */
static int text_columns(const unsigned char *bytes, size_t size, bool *path_header)
{
    const char *p = (const char *)bytes, *all = p + size;
    *path_header = false;
    if (size >= 3 && memcmp(p, "\xef\xbb\xbf", 3) == 0)
        p += 3;
    int columns = 0;
    /* A file whose lines end with CR alone is also classified as text; the text reader later reports the line ends
     * as an error. */
    const char line_end = memchr(p, '\n', (size_t)(all - p)) ? '\n' : '\r';
    while (p < all) {
        const char *newline = memchr(p, line_end, (size_t)(all - p));
        const char *end = newline ? newline : all;
        const char *next = newline ? newline + 1 : all;
        if (end > p && end[-1] == '\r')
            end--;
        if (ost_text_is_binary(p, end))
            return 0;
        const char *q = ost_text_skip_blanks(p, end);
        if (q < end && *q != '#' && columns == 0) {
            *path_header = end - q >= 3 && memcmp(q, "t_s", 3) == 0;
            while (ost_text_field_start(&q, end, columns) == OST_TEXT_FIELD) {
                columns++;
                q = ost_text_field_end(q, end);
            }
        }
        p = next;
    }
    return columns;
}

static ost_file_kind kind_by_name(const char *path)
{
    static const struct {
        const char *suffix;
        ost_file_kind kind;
    } names[] = {
        {".txt", OST_FILE_CT_TEXT}, {".asc", OST_FILE_CT_TEXT},  {".xyz", OST_FILE_CT_TEXT},
        {".dat", OST_FILE_CT_TEXT}, {".csv", OST_FILE_PATH_CSV}, {".nrrd", OST_FILE_NRRD},
        {".nhdr", OST_FILE_NRRD},   {".nii", OST_FILE_NIFTI},    {".nii.gz", OST_FILE_NIFTI},
        {".hdr", OST_FILE_NIFTI},   {".stl", OST_FILE_MESH},     {".obj", OST_FILE_MESH},
        {".ply", OST_FILE_MESH},    {".3ds", OST_FILE_MESH},     {".session", OST_FILE_SESSION},
        {".mha", OST_FILE_METAIMAGE}, {".mhd", OST_FILE_METAIMAGE},
    };
    size_t length = strlen(path);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        size_t n = strlen(names[i].suffix);
        if (length > n && strcasecmp(path + length - n, names[i].suffix) == 0)
            return names[i].kind;
    }
    return OST_FILE_UNKNOWN;
}

static ost_file_kind plain_kind(const unsigned char *head, size_t size, off_t file_size, ost_file_kind by_name)
{
    if (is_nrrd(head, size))
        return OST_FILE_NRRD;
    if (ost_metaimage_sniff(head, size))
        return OST_FILE_METAIMAGE;
    if (ost_dicom_sniff(head, size))
        return OST_FILE_DICOM;
    if (ost_slice_sniff(head, size) != OST_SLICE_NONE)
        return OST_FILE_STACK;
    if (is_session(head, size))
        return OST_FILE_SESSION;
    if (is_nifti(head, size))
        return OST_FILE_NIFTI;
    if (is_mesh(head, size, file_size))
        return OST_FILE_MESH;
    if (by_name == OST_FILE_UNKNOWN || by_name == OST_FILE_PATH_CSV) {
        bool path_header;
        int columns = text_columns(head, size, &path_header);
        if (path_header || columns == 8 || columns == 9)
            return OST_FILE_PATH_CSV;
        if (columns == 4)
            return OST_FILE_CT_TEXT;
    }
    return OST_FILE_UNKNOWN;
}

static ost_status kind_by_content(const char *path, int fd, const unsigned char *head, size_t size, off_t file_size,
                                  ost_file_kind by_name, ost_file_kind *out, ost_error *err)
{
    if (!is_gzip(head, size)) {
        *out = plain_kind(head, size, file_size, by_name);
        return *out == OST_FILE_UNKNOWN ? ost_refuse_foreign(path, head, size, err) : OST_OK;
    }
    unsigned char inner[GZIP_HEAD];
    size_t inner_size = 0;
    ost_status status = gzip_head(path, fd, inner, &inner_size, err);
    bool path_header = false;
    const bool nifti = status == OST_OK && is_nifti(inner, inner_size);
    if (status == OST_OK && !nifti)
        (void)text_columns(inner, inner_size, &path_header);
    *out = nifti ? OST_FILE_NIFTI : path_header ? OST_FILE_PATH_CSV : OST_FILE_UNKNOWN;
    if (status == OST_OK && *out == OST_FILE_UNKNOWN && by_name == OST_FILE_UNKNOWN)
        status = ost_fail(err, OST_ERR_INPUT,
                          "%s: is compressed by gzip, and its content is no NIfTI file and no path; "
                          "gunzip decompresses it",
                          path);
    return status;
}

ost_status ost_file_kind_find(const char *path, ost_file_kind *out, ost_error *err)
{
    *out = OST_FILE_UNKNOWN;
    struct stat info;
    ost_status status = OST_OK;
    const bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    bool stack = false;
    if (folder || ost_stack_is_pattern(path))
        status = ost_stack_find(path, &stack, err);
    if (status != OST_OK)
        return status;
    if (stack || folder) {
        *out = stack ? OST_FILE_STACK : OST_FILE_DICOM;
        return OST_OK;
    }
    ost_file file;
    status = ost_file_open(path, &file, err);
    if (status != OST_OK)
        return status;
    unsigned char head[HEAD];
    size_t size = 0;
    for (ssize_t n = 1; n > 0 && size < HEAD; size += (size_t)(n > 0 ? n : 0)) {
        n = pread(file.fd, head + size, HEAD - size, (off_t)size);
        if (n < 0) {
            status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
            close(file.fd);
            return status;
        }
    }
    ost_file_kind by_name = kind_by_name(path);
    status = kind_by_content(path, file.fd, head, size, file.size, by_name, out, err);
    close(file.fd);
    if (status == OST_OK && *out == OST_FILE_UNKNOWN)
        *out = by_name;
    return status;
}
