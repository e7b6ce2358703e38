/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/manifest.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SCHEMA = 1, NAMES_MAX = 100000 };

/* Times, identities and the machine: they differ from run to run. */
static const char *const varying[] = {"audit.log", "environment.json", "times.json"};

static bool varies(const char *name)
{
    for (size_t i = 0; i < sizeof varying / sizeof varying[0]; i++)
        if (strcmp(name, varying[i]) == 0)
            return true;
    return false;
}

/* ------------------------------------------------------------- the folder */

typedef struct name_list {
    char **names;
    size_t count, room;
} name_list;

static void free_names(name_list *l)
{
    for (size_t i = 0; i < l->count; i++)
        free(l->names[i]);
    free(l->names);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static ost_status add_name(name_list *l, const char *name, ost_error *err)
{
    if (l->count == NAMES_MAX)
        return ost_fail(err, OST_ERR_INPUT, "more than %d files: no bundle", NAMES_MAX);
    if (l->count == l->room) {
        l->room = l->room ? 2 * l->room : 64;
        char **grown = realloc(l->names, l->room * sizeof *grown);
        if (!grown)
            return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu names", l->room);
        l->names = grown;
    }
    l->names[l->count] = strdup(name);
    return l->names[l->count++] ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "no memory for a name");
}

/* Names relative to the folder; links and devices are named too, so that reading them says what they are. */
static ost_status list_folder(const char *folder, const char *inside, int depth, name_list *l, ost_error *err)
{
    char path[2 * BUNDLE_PATH];
    snprintf(path, sizeof path, "%s%s%s", folder, *inside ? "/" : "", inside);
    DIR *dir = opendir(path);
    if (!dir)
        return ost_fail(err, OST_ERR_IO, "%s: cannot be opened: %s", path, strerror(errno));
    ost_status status;
    for (struct dirent *e; (status = bundle_next_entry(dir, path, &e, err)) == OST_OK && e;) {
        char name[BUNDLE_PATH], full[3 * BUNDLE_PATH];
        struct stat info;
        const int n = snprintf(name, sizeof name, "%s%s%s", inside, *inside ? "/" : "", e->d_name);
        if (n >= (int)sizeof name) {
            status = ost_fail(err, OST_ERR_INPUT, "%s: a name in it is too long", path);
            break;
        }
        if (strcmp(name, MANIFEST_FILE) == 0 || strcmp(name, MANIFEST_SIGNATURES) == 0)
            continue;
        snprintf(full, sizeof full, "%s/%s", folder, name);
        if (lstat(full, &info) == 0 && S_ISDIR(info.st_mode))
            status = depth < 4 ? list_folder(folder, name, depth + 1, l, err) : ost_fail(err, OST_ERR_INPUT, "%s: folders too deep", full);
        else
            status = add_name(l, name, err);
        if (status != OST_OK)
            break;
    }
    closedir(dir);
    return status;
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

/* RFC 6962: split at the greatest power of two below count. */
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

static ost_status describe_files(const char *folder, const name_list *l, json_t *files, ost_digest *all, ost_digest *results, ost_error *err)
{
    ost_digest *leaves = calloc(2 * l->count + 1, sizeof *leaves);
    ost_digest *some = leaves ? leaves + l->count : NULL;
    size_t some_count = 0;
    ost_status status = leaves ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "no memory for %zu digests", l->count);
    for (size_t i = 0; i < l->count && status == OST_OK; i++) {
        char *bytes, hex[OST_DIGEST_HEX];
        size_t size;
        ost_digest file;
        status = bundle_read(folder, l->names[i], &bytes, &size, err);
        if (status == OST_OK)
            status = ost_digest_bytes(bytes, size, &file, err);
        free(bytes);
        if (status == OST_OK)
            status = leaf_of(l->names[i], &file, &leaves[i], err);
        if (status != OST_OK)
            break;
        if (!varies(l->names[i]))
            some[some_count++] = leaves[i];
        json_t *row = json_pack("{s:s,s:I,s:s}", "name", l->names[i], "size", (json_int_t)size, "sha256", ost_digest_hex(&file, hex));
        if (!row || json_array_append_new(files, row) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "no memory for a manifest (or a name in it that is not UTF-8)");
    }
    if (status == OST_OK)
        status = tree_of(leaves, l->count, all, err);
    if (status == OST_OK)
        status = tree_of(some, some_count, results, err);
    free(leaves);
    return status;
}

ost_status manifest_of(const char *folder, json_t **out, ost_error *err)
{
    name_list l = {0};
    ost_digest all, results;
    char a[OST_DIGEST_HEX], b[OST_DIGEST_HEX];
    *out = NULL;
    json_t *files = json_array(), *names = json_array();
    ost_status status = list_folder(folder, "", 0, &l, err);
    if (status == OST_OK) {
        if (l.count) /* qsort takes no NULL, not even of nothing */
            qsort(l.names, l.count, sizeof *l.names, by_name);
        status = describe_files(folder, &l, files, &all, &results, err);
    }
    for (size_t i = 0; i < sizeof varying / sizeof varying[0]; i++)
        json_array_append_new(names, json_string(varying[i]));
    if (status == OST_OK)
        *out = json_pack("{s:i,s:O,s:O,s:s,s:s,s:s}", "schema", SCHEMA, "files", files, "varying", names, "root", ost_digest_hex(&all, a), "results_root",
                         ost_digest_hex(&results, b), "hash", "SHA-256; roots as in RFC 6962 over SHA-256(00 name 00 digest)");
    if (status == OST_OK && !*out)
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for a manifest");
    json_decref(files);
    json_decref(names);
    free_names(&l);
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

/* The row of a file, or NULL. */
static const json_t *row_of(const json_t *manifest, const char *name)
{
    const json_t *files = json_object_get(manifest, "files");
    for (size_t i = 0; i < json_array_size(files); i++) {
        const json_t *row = json_array_get(files, i);
        const char *its = json_string_value(json_object_get(row, "name"));
        if (its && strcmp(its, name) == 0)
            return row;
    }
    return NULL;
}

static void compare_rows(const json_t *said, const json_t *is, bundle_problem *problem, void *user, int *found)
{
    const json_t *a = json_object_get(said, "files"), *b = json_object_get(is, "files");
    for (size_t i = 0; i < json_array_size(a); i++) {
        const char *name = json_string_value(json_object_get(json_array_get(a, i), "name"));
        const json_t *row = name ? row_of(is, name) : NULL;
        if (!name || !row) {
            problem(user, name ? BUNDLE_ABSENT : BUNDLE_DIFFERENT, name ? name : MANIFEST_FILE, name ? "is in the manifest and not in the folder" : "has a row without a name");
            ++*found;
        } else if (!json_equal(json_array_get(a, i), row)) {
            problem(user, BUNDLE_DIFFERENT, name, "is not the file that the manifest describes");
            ++*found;
        }
    }
    for (size_t i = 0; i < json_array_size(b); i++) {
        const char *name = json_string_value(json_object_get(json_array_get(b, i), "name"));
        if (!row_of(said, name)) {
            problem(user, BUNDLE_DIFFERENT, name, "is in the folder and not in the manifest");
            ++*found;
        }
    }
}

ost_status manifest_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err)
{
    char *bytes = NULL, *text = NULL;
    size_t size = 0;
    json_t *is = NULL;
    const int before = *found;
    ost_status status = manifest_of(folder, &is, err);
    if (status == OST_OK)
        status = bundle_find(folder, MANIFEST_FILE, &bytes, &size, err);
    if (status != OST_OK) {
        json_decref(is);
        return status;
    }
    if (!bytes) {
        problem(user, BUNDLE_ABSENT, MANIFEST_FILE, "is missing");
        ++*found;
    } else if (!(text = manifest_text(is)))
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for a manifest");
    else if (strlen(text) != size || memcmp(text, bytes, size) != 0) {
        json_t *said = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL);
        if (said)
            compare_rows(said, is, problem, user, found);
        if (*found == before) { /* the files are as described, so it is the manifest that was changed */
            problem(user, BUNDLE_DIFFERENT, MANIFEST_FILE, said ? "is not what the files give" : "is not JSON");
            ++*found;
        }
        json_decref(said);
    }
    free(bytes);
    free(text);
    json_decref(is);
    return status;
}
