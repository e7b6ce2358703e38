/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/manifest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/folder.h"
#include "validation/bundle/limits.h"

enum { SCHEMA = 2, PROBLEMS_MAX = 1000 };

static bool varies(const char *name)
{
    folder_about about;
    return folder_describe(name, &about) && about.varies;
}

/* ---------------------------------------------------------------- the tree */

static ost_status leaf_of(const char *name, const ost_digest *file, ost_digest *out, ost_error *err)
{
    unsigned char bytes[BUNDLE_PATH + 2 + OST_DIGEST_BYTES] = {0};
    const size_t length = strlen(name);
    memcpy(bytes + 1, name, length);
    memcpy(bytes + 1 + length + 1, file->bytes, OST_DIGEST_BYTES);
    return ost_digest_bytes(bytes, length + 2 + OST_DIGEST_BYTES, out, err);
}

/* Computes the tree hash of RFC 6962, which splits at the greatest power of two below count. */
static ost_status tree_of(const ost_digest *leaves, size_t count, ost_digest *out, ost_error *err)
{
    if (count == 0)
        return ost_digest_bytes("", 0, out, err);
    if (count == 1) {
        *out = leaves[0];
        return OST_OK;
    }
    size_t left = 1;
    while (2 * left < count)
        left *= 2;
    unsigned char bytes[1 + 2 * OST_DIGEST_BYTES] = {1};
    ost_digest a, b;
    ost_status status = tree_of(leaves, left, &a, err);
    if (status == OST_OK)
        status = tree_of(leaves + left, count - left, &b, err);
    if (status != OST_OK)
        return status;
    memcpy(bytes + 1, a.bytes, OST_DIGEST_BYTES);
    memcpy(bytes + 1 + OST_DIGEST_BYTES, b.bytes, OST_DIGEST_BYTES);
    return ost_digest_bytes(bytes, sizeof bytes, out, err);
}

/* ------------------------------------------------------------ the manifest */

static ost_status describe_files(const char *folder, const folder_files *l, json_t *files, ost_digest *all,
                                 ost_digest *results, ost_error *err)
{
    ost_digest *leaves = calloc(2 * l->count + 1, sizeof *leaves);
    ost_digest *some = leaves ? leaves + l->count : NULL;
    size_t count = 0, some_count = 0;
    ost_status status = leaves ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu digests", l->count);
    for (size_t i = 0; i < l->count && status == OST_OK; i++) {
        const char *name = l->files[i].name;
        char hex[OST_DIGEST_HEX];
        int64_t size;
        ost_digest file;
        if (strcmp(name, MANIFEST_FILE) == 0)
            continue;
        status = folder_digest(folder, name, &file, &size, err);
        if (status == OST_OK)
            status = leaf_of(name, &file, &leaves[count], err);
        if (status != OST_OK)
            break;
        if (!varies(name))
            some[some_count++] = leaves[count];
        count++;
        json_t *row = json_pack("{s:s,s:I,s:s}", "name", name, "size", (json_int_t)size, "sha256",
                                ost_digest_hex(&file, hex));
        if (!row || json_array_append_new(files, row) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a manifest");
    }
    if (status == OST_OK)
        status = tree_of(leaves, count, all, err);
    if (status == OST_OK)
        status = tree_of(some, some_count, results, err);
    free(leaves);
    return status;
}

static ost_status manifest_of_files(const char *folder, const folder_files *l, json_t **out, ost_error *err)
{
    ost_digest all, results;
    char a[OST_DIGEST_HEX], b[OST_DIGEST_HEX];
    json_t *files = json_array(), *names = json_array();
    *out = NULL;
    ost_status status = describe_files(folder, l, files, &all, &results, err);
    for (size_t i = 0; folder_name(i); i++)
        if (varies(folder_name(i)))
            json_array_append_new(names, json_string(folder_name(i)));
    if (status == OST_OK)
        *out = json_pack("{s:i,s:O,s:O,s:s,s:s,s:s}", "schema", SCHEMA, "files", files, "varying", names, "root",
                         ost_digest_hex(&all, a), "results_root", ost_digest_hex(&results, b), "hash",
                         "SHA-256; roots as in RFC 6962 over SHA-256(00 name 00 digest)");
    if (status == OST_OK && !*out)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a manifest");
    json_decref(files);
    json_decref(names);
    return status;
}

/* Stores the first problem found in the folder. This program wrote all files of the folder, so any problem is an
   error. */
static void first_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem)
{
    ost_error *first = user;
    (void)kind;
    if (first->status == OST_OK)
        (void)ost_fail(first, OST_ERR_IO, "%.80s %s", file, problem);
}

ost_status manifest_of(const char *folder, json_t **out, ost_error *err)
{
    folder_files l;
    ost_error first = {0};
    int found = 0;
    *out = NULL;
    ost_status status = folder_list(folder, &l, first_problem, &first, &found, err);
    if (status != OST_OK)
        return status;
    status = found ? ost_fail(err, first.status, "%s: %s", folder, first.text)
                   : manifest_of_files(folder, &l, out, err);
    folder_free(&l);
    return status;
}

char *manifest_text(const json_t *manifest)
{
    char *text = json_dumps(manifest, JSON_SORT_KEYS | JSON_INDENT(1));
    const size_t size = text ? strlen(text) : 0;
    char *line = text ? realloc(text, size + 2) : NULL;
    if (!line) {
        free(text);
        return NULL;
    }
    memcpy(line + size, "\n", 2);
    return line;
}

/* Converts the rows of a manifest to an object {name: row}, which the caller owns. */
static json_t *rows_by_name(const json_t *manifest)
{
    const json_t *files = json_object_get(manifest, "files");
    json_t *out = json_object();
    for (size_t i = 0; i < json_array_size(files); i++) {
        const char *name = json_string_value(json_object_get(json_array_get(files, i), "name"));
        if (name)
            json_object_set(out, name, json_array_get(files, i));
    }
    return out;
}

/* Parses 64 hexadecimal digits. */
static bool digest_in(const char *hex, ost_digest *out)
{
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < 2 * OST_DIGEST_BYTES; i++) {
        const char *digit = hex && hex[i] ? strchr(digits, hex[i]) : NULL;
        if (!digit)
            return false;
        out->bytes[i / 2] = (unsigned char)(i % 2 ? out->bytes[i / 2] << 4 | (digit - digits) : digit - digits);
    }
    return hex[2 * OST_DIGEST_BYTES] == '\0';
}

/* Returns true if the root of a manifest follows from its rows, which means that the manifest is unchanged. In this
   case, a row without a file shows that a file is missing. */
static bool rows_give_root(const json_t *stated)
{
    const json_t *files = json_object_get(stated, "files");
    const size_t count = json_array_size(files);
    ost_digest root, digest, *leaves = calloc(count + 1, sizeof *leaves);
    ost_error none = {0};
    bool same = leaves != NULL && digest_in(json_string_value(json_object_get(stated, "root")), &root);
    for (size_t i = 0; same && i < count; i++) {
        const json_t *row = json_array_get(files, i);
        const char *name = json_string_value(json_object_get(row, "name"));
        same = name && strlen(name) < BUNDLE_PATH &&
               digest_in(json_string_value(json_object_get(row, "sha256")), &digest) &&
               leaf_of(name, &digest, &leaves[i], &none) == OST_OK;
    }
    same = same && tree_of(leaves, count, &digest, &none) == OST_OK && ost_digest_equal(&digest, &root);
    free(leaves);
    return same;
}

static void compare_rows(const json_t *stated, const json_t *is, bundle_problem *problem, void *user, int *found)
{
    const json_t *a = json_object_get(stated, "files");
    json_t *there = rows_by_name(is), *described = rows_by_name(stated), *row;
    const char *key;
    char name[256];
    const bool as_written = rows_give_root(stated);
    if (!as_written) {
        problem(user, BUNDLE_DIFFERENT, MANIFEST_FILE, "has rows that do not give its root");
        ++*found;
    }
    for (size_t i = 0; i < json_array_size(a) && *found < PROBLEMS_MAX; i++) {
        key = json_string_value(json_object_get(json_array_get(a, i), "name"));
        row = key ? json_object_get(there, key) : NULL;
        if (!key || !row) {
            problem(user, key && as_written ? BUNDLE_ABSENT : BUNDLE_DIFFERENT,
                    key ? limits_printable(key, name, sizeof name) : MANIFEST_FILE,
                    key ? "is in the manifest and not in the folder" : "has a row without a name");
            ++*found;
        } else if (!json_equal(json_array_get(a, i), row)) {
            problem(user, BUNDLE_DIFFERENT, key, "is not the file that the manifest describes");
            ++*found;
        }
    }
    json_object_foreach(there, key, row)
        if (!json_object_get(described, key)) {
            problem(user, BUNDLE_DIFFERENT, key, "is in the folder and not in the manifest");
            ++*found;
        }
    json_decref(described);
    json_decref(there);
}

/* Returns an error text without the manifest's name and the line number, because bundle_problem reports the name. */
static const char *problem_text(const char *text)
{
    const char *end = strstr(text, ": ");
    return end ? end + 2 : text;
}

ost_status manifest_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err)
{
    char *bytes = NULL, *text = NULL;
    size_t size = 0;
    folder_files l;
    ost_error unread = {0};
    json_t *is = NULL, *stated = NULL;
    ost_status status = folder_list(folder, &l, problem, user, found, err);
    const int before = *found;
    if (status != OST_OK)
        return status;
    status = manifest_of_files(folder, &l, &is, err);
    folder_free(&l);
    if (status == OST_OK)
        status = bundle_find(folder, MANIFEST_FILE, &bytes, &size, err);
    if (status == OST_OK && !(text = manifest_text(is)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a manifest");
    if (status == OST_OK && !bytes) {
        problem(user, BUNDLE_ABSENT, MANIFEST_FILE, "is missing");
        ++*found;
    } else if (status == OST_OK && (strlen(text) != size || memcmp(text, bytes, size) != 0)) {
        if (limits_parse(MANIFEST_FILE, bytes, size, &stated, &unread) == OST_ERR_MEMORY)
            status = ost_fail(err, OST_ERR_MEMORY, "%s", unread.text);
        if (stated)
            compare_rows(stated, is, problem, user, found);
        /* Every file matches its row, so the difference is in the manifest itself. */
        if (status == OST_OK && *found == before) {
            problem(user, BUNDLE_DIFFERENT, MANIFEST_FILE,
                    stated ? "is not what the files give" : problem_text(unread.text));
            ++*found;
        }
        json_decref(stated);
    }
    free(bytes);
    free(text);
    json_decref(is);
    return status;
}
