/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/result.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/common/progress.h"
#include "core/file.h"
#include "io/outfile.h"

static void check(int failed)
{
    if (failed) {
        fputs("osteon: out of memory\n", stderr);
        exit(2);
    }
}

void put(json_t *object, const char *key, json_t *value)
{
    check(json_object_set_new(object, key, value));
}

void append(json_t *array, json_t *value)
{
    check(json_array_append_new(array, value));
}

void put_text(json_t *object, const char *key, const char *text)
{
    json_t *value = json_string(text);
    /*
     * A file name may contain any bytes, but JSON text must be UTF-8. Therefore a name that is not valid UTF-8 is
     * replaced.
     */
    put(object, key, value ? value : json_string("(not UTF-8)"));
}

void put_integer(json_t *object, const char *key, int64_t value)
{
    put(object, key, json_integer(value));
}

void put_real(json_t *object, const char *key, double value)
{
    put(object, key, isfinite(value) ? json_real(value) : json_null());
}

void put_bool(json_t *object, const char *key, bool value)
{
    put(object, key, json_boolean(value));
}

void put_dims(json_t *object, const char *key, ost_dims dims)
{
    put(object, key, json_pack("[i,i,i]", dims.x, dims.y, dims.z));
}

void put_mm3(json_t *object, const char *key, ost_pm3 v)
{
    put(object, key, json_pack("[f,f,f]", ost_pm_to_mm(v.x), ost_pm_to_mm(v.y), ost_pm_to_mm(v.z)));
}

void put_mm(json_t *object, const char *key, ost_pm value)
{
    put_real(object, key, ost_pm_to_mm(value));
}

void put_digest(json_t *object, const char *key, const ost_digest *digest)
{
    char hex[OST_DIGEST_HEX];
    put_text(object, key, ost_digest_hex(digest, hex));
}

void put_meta(json_t *object, const char *key, const ost_meta *meta)
{
    json_t *all = json_object();
    check(!all);
    for (int i = 0; i < meta->count; i++)
        put_text(all, meta->entry[i].key, meta->entry[i].value);
    put(object, key, all);
}

ost_status file_digest(const char *path, ost_digest *out, ost_error *err)
{
    ost_hasher *hasher = NULL;
    FILE *file;
    if (ost_outfile_is_stdout(path)) { /* data written to standard output cannot be read again */
        *out = (ost_digest){{0}};
        return OST_OK;
    }
    struct stat st;
    double done = 0;
    ost_status status = ost_file_stream(path, &file, NULL, err);
    if (status != OST_OK)
        return status;
    status = ost_hasher_open(&hasher, err);
    const double size = fstat(fileno(file), &st) == 0 && st.st_size > 0 ? (double)st.st_size : 1;
    static unsigned char block[1 << 16];
    size_t n;
    while (status == OST_OK && (n = fread(block, 1, sizeof block, file)) > 0) {
        progress_show(NULL, "digest", done / size);
        status = ost_hasher_add(hasher, block, n, err);
        done += (double)n;
    }
    progress_end();
    if (status == OST_OK && ferror(file))
        status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(errno));
    fclose(file);
    if (hasher) {
        ost_status closed = ost_hasher_close(hasher, status == OST_OK ? out : NULL, status == OST_OK ? err : NULL);
        if (status == OST_OK)
            status = closed;
    }
    return status;
}

void put_dicom_report(json_t *object, const ost_dicom_report *report)
{
    json_t *o = json_object();
    put_text(o, "modality", report->modality);
    put_integer(o, "images", report->images);
    put_integer(o, "other_files", report->other_files);
    put_integer(o, "localizers", report->localizers);
    put_integer(o, "doubled", report->doubled);
    put_integer(o, "interpolated", report->interpolated);
    put_mm(o, "largest_gap_mm", report->largest_gap);
    put_mm(o, "thickness_mm", report->thickness);
    put_mm(o, "sheared_mm", report->sheared);
    put_integer(o, "padded_voxels", (int64_t)report->padded);
    put_bool(o, "lossy", report->lossy);
    put_bool(o, "rescaled", !report->no_rescale);
    put(object, "dicom", o);
}
