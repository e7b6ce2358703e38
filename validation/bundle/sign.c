/* SPDX-License-Identifier: Apache-2.0 */
/* Makes and checks statements about a bundle (in-toto attestation v1, test-result v0.1), and reads the folder of its
   signatures. */
#include "validation/bundle/sign.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "core/file.h"
#include "io/outfile.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/limits.h"
#include "validation/bundle/manifest.h"
#include "validation/bundle/sign_parts.h"

#define ENVELOPE_END ".intoto.jsonl"
#define TIME_STAMP_END ".tsr"

enum { ENVELOPE_MAX = 16 << 20, TIME_STAMP_MAX = 1 << 20, FILES_MAX = 64 };

/* ------------------------------------------------------------- statements */

typedef struct claim {
    char by[SIGN_TEXT_MAX + 1], meaning[SIGN_TEXT_MAX + 1], time[SIGN_TIME];
} claim;

/* Adds "CASE on BACKEND", the name of the test in results.tap, to the list `passed` or `failed`. Returns false if
   memory is exhausted. */
static bool sort_result(const char *id, const char *backend, const char *verdict, json_t *passed, json_t *failed)
{
    char name[400];
    if (strcmp(verdict, case_verdict_name(CASE_NOT_RUN)) == 0)
        return true;
    snprintf(name, sizeof name, "%s on %s", id, backend);
    return json_array_append_new(strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0 ? passed : failed,
                                 json_string(name)) == 0;
}

/* Returns PASSED if all results are equal and the campaign covers enough to be evidence. Returns WARNED if all results
   are equal but the campaign covers too little. Returns FAILED in all other cases, for example if nothing was compared
   or the campaign is incomplete. */
static const char *result_of(const json_t *summary)
{
    if (!json_is_true(json_object_get(summary, "equal")))
        return "FAILED";
    return json_is_true(json_object_get(summary, "evidence")) ? "PASSED" : "WARNED";
}

typedef struct contents {
    json_t *protocol, *cases, *summary, *manifest;
    char manifest_sha256[OST_DIGEST_HEX], protocol_sha256[OST_DIGEST_HEX];
} contents;

static void contents_free(contents *c)
{
    json_decref(c->protocol);
    json_decref(c->cases);
    json_decref(c->summary);
    json_decref(c->manifest);
}

static ost_status read_object(const char *folder, const char *name, json_t **out, char hex[OST_DIGEST_HEX],
                              ost_error *err)
{
    char *bytes;
    size_t size;
    ost_digest digest;
    ost_status status = bundle_read(folder, name, &bytes, &size, err);
    if (status != OST_OK)
        return status;
    status = limits_parse(name, bytes, size, out, err);
    if (status == OST_OK)
        status = json_is_object(*out) ? ost_digest_bytes(bytes, size, &digest, err)
                                      : ost_fail(err, OST_ERR_INPUT, "%s/%s: no JSON object", folder, name);
    if (status == OST_OK)
        ost_digest_hex(&digest, hex);
    free(bytes);
    return status;
}

static ost_status contents_read(const char *folder, contents *c, ost_error *err)
{
    *c = (contents){.protocol = NULL};
    ost_status status = read_object(folder, MANIFEST_FILE, &c->manifest, c->manifest_sha256, err);
    if (status == OST_OK)
        status = read_object(folder, EVIDENCE_PROTOCOL, &c->protocol, c->protocol_sha256, err);
    if (status == OST_OK)
        status = evidence_read_cases(folder, false, &c->cases, err);
    if (status == OST_OK)
        status = evidence_summary(c->protocol, c->cases, &c->summary, err);
    if (status != OST_OK)
        contents_free(c);
    return status;
}

static ost_status statement_of(const contents *c, const claim *claimed, json_t **out, ost_error *err)
{
    const json_t *backends = json_object_get(c->protocol, "backends");
    json_t *passed = json_array(), *failed = json_array();
    bool complete = passed && failed;
    for (size_t s = 1; s < json_array_size(backends) && complete; s++) {
        const char *backend = evidence_text(json_array_get(backends, s), "name");
        for (size_t i = 0; i < json_array_size(c->cases) && complete; i++) {
            const json_t *one = json_array_get(c->cases, i);
            const char *verdict = evidence_text(json_object_get(json_object_get(one, "results"), backend), "verdict");
            complete = sort_result(evidence_text(one, "id"), backend, verdict, passed, failed);
        }
    }
    *out = !complete
               ? NULL
               : json_pack("{s:s,s:[{s:s,s:{s:s},s:{s:s,s:s,s:s,s:s,s:s}}],s:s,s:{s:s,s:[{s:s,s:{s:s}}],s:O,s:O}}",
                           "_type", "https://in-toto.io/Statement/v1", "subject", "name", MANIFEST_FILE, "digest",
                           "sha256", c->manifest_sha256, "annotations", "results_root",
                           evidence_text(c->manifest, "results_root"), "verdict", evidence_text(c->summary, "verdict"),
                           "signer", claimed->by, "meaning", claimed->meaning, "time", claimed->time, "predicateType",
                           "https://in-toto.io/attestation/test-result/v0.1", "predicate", "result",
                           result_of(c->summary), "configuration", "name", EVIDENCE_PROTOCOL, "digest", "sha256",
                           c->protocol_sha256, "passedTests", passed, "failedTests", failed);
    json_decref(passed);
    json_decref(failed);
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a statement");
}

/* --------------------------------------------------------------- signing */

/* Checks that the text is UTF-8, has no control characters and is at most SIGN_TEXT_MAX bytes long. Returns NULL if the
   text is valid, and otherwise a description of the problem. */
static const char *line_problem(const char *text)
{
    json_t *utf8 = json_string(text);
    json_decref(utf8);
    if (!utf8)
        return "is not UTF-8";
    if (strlen(text) > SIGN_TEXT_MAX)
        return "is too long";
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 127)
            return "contains a control character";
    return NULL;
}

static ost_status check_line(const char *option, const char *text, ost_error *err)
{
    const char *problem = line_problem(text);
    return problem ? ost_fail(err, OST_ERR_USAGE, "%s: %s; expected one printable line of UTF-8 of at most %d bytes",
                              option, problem, SIGN_TEXT_MAX)
                   : OST_OK;
}

static ost_status write_envelope(const char *folder, const char *name, const char *text, ost_error *err)
{
    char path[BUNDLE_PATH];
    struct stat info;
    ost_outfile *file;
    if (snprintf(path, sizeof path, "%s/" MANIFEST_SIGNATURES, folder) >= (int)sizeof path)
        return ost_fail(err, OST_ERR_INPUT, "%.200s: too long", folder);
    if (mkdir(path, 0777) != 0 && errno != EEXIST)
        return ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    if (lstat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return ost_fail(err, OST_ERR_IO, "%s: must be a folder", path);
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        return ost_fail(err, OST_ERR_INPUT, "%.200s: too long", folder);
    if (lstat(path, &info) == 0)
        return ost_fail(err, OST_ERR_IO, "%s: exists; sign again a second later", path);
    ost_status status = ost_outfile_open(path, &file, err);
    if (status != OST_OK)
        return status;
    status = ost_outfile_write(file, text, strlen(text), err);
    if (status == OST_OK)
        status = ost_outfile_write(file, "\n", 1, err);
    if (status == OST_OK)
        return ost_outfile_commit(file, err);
    ost_outfile_discard(file);
    return status;
}

ost_status sign_bundle(const char *folder, const sign_key *key, const char *by, const char *meaning,
                       char name[SIGN_NAME], ost_error *err)
{
    const time_t now = time(NULL);
    char stamp[SIGN_TIME], *payload = NULL, *envelope = NULL;
    json_t *statement = NULL;
    contents c;
    claim claimed;
    struct tm utc;
    ost_status status = check_line("--by", by, err);
    if (status == OST_OK)
        status = check_line("--meaning", meaning, err);
    if (status != OST_OK)
        return status;
    gmtime_r(&now, &utc);
    snprintf(claimed.by, sizeof claimed.by, "%s", by);
    snprintf(claimed.meaning, sizeof claimed.meaning, "%s", meaning);
    strftime(claimed.time, sizeof claimed.time, "%Y-%m-%dT%H:%M:%SZ", &utc);
    strftime(stamp, sizeof stamp, "%Y%m%dT%H%M%SZ", &utc);
    snprintf(name, SIGN_NAME, MANIFEST_SIGNATURES "/%s-%.16s" ENVELOPE_END, stamp, key->fingerprint);
    status = contents_read(folder, &c, err);
    if (status != OST_OK)
        return status;
    status = statement_of(&c, &claimed, &statement, err);
    contents_free(&c);
    if (status == OST_OK && !(payload = json_dumps(statement, JSON_COMPACT | JSON_SORT_KEYS)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a statement");
    if (status == OST_OK)
        status = sign_envelope_make(key, payload, strlen(payload), &envelope, err);
    if (status == OST_OK)
        status = write_envelope(folder, name, envelope, err);
    json_decref(statement);
    free(payload);
    free(envelope);
    return status;
}

/* --------------------------------------------------- checking signatures */

typedef struct check {
    const char *folder;
    int signatures; /* file descriptor of the folder signatures/ */
    const sign_trust *trust;
    const contents *is; /* contents of the bundle; NULL if they cannot be read, which other checks report */
    bundle_problem *problem;
    void *user;
    int *found;
    json_t *list;
} check;

static void report(const check *c, const char *name, const char *text)
{
    char path[512];
    snprintf(path, sizeof path, MANIFEST_SIGNATURES "/%.255s", name);
    c->problem(c->user, BUNDLE_DIFFERENT, path, text);
    ++*c->found;
}

/* Reads a file in signatures/. If it is not a regular file of at most `max` bytes, reports the reason and sets
   *bytes to NULL. */
static ost_status read_within(const check *c, const char *name, size_t max, char **bytes, size_t *size, bool *absent,
                              ost_error *err)
{
    ost_file file;
    ost_error why = {0};
    *bytes = NULL;
    ost_status status = ost_file_open_within(c->signatures, name, &file, &why);
    *absent = status != OST_OK && file.absent;
    if (status != OST_OK) {
        if (!*absent)
            report(c, name, "is not a regular file that can be read");
        return OST_OK;
    }
    if (file.size > (int64_t)max)
        report(c, name, "is larger than a signature can be");
    else
        status = ost_file_bytes(name, &file, bytes, size, err);
    close(file.fd);
    return status;
}

static bool take_claim(const json_t *annotations, const char *key, char *to, size_t size)
{
    const json_t *value = json_object_get(annotations, key);
    const char *text = json_string_value(value);
    if (!text || strlen(text) != json_string_length(value) || strlen(text) >= size || line_problem(text))
        return false;
    snprintf(to, size, "%s", text);
    return true;
}

/* Reads the signer's claims from a statement, and compares the rest of the statement with the bundle. If the statement
   is invalid, sets *why to the reason. If it is valid, sets *why to NULL. */
static ost_status compare_statement(const check *c, const sign_envelope *e, claim *claimed, const char **why,
                                    ost_error *err)
{
    json_t *stated = json_loadb(e->payload, e->payload_size, JSON_REJECT_DUPLICATES, NULL), *is = NULL;
    const json_t *annotations = json_object_get(json_array_get(json_object_get(stated, "subject"), 0), "annotations");
    ost_status status = OST_OK;
    *why = NULL;
    if (!take_claim(annotations, "signer", claimed->by, sizeof claimed->by) ||
        !take_claim(annotations, "meaning", claimed->meaning, sizeof claimed->meaning) ||
        !take_claim(annotations, "time", claimed->time, sizeof claimed->time))
        *why = "holds no statement of osteon sign: signer, meaning or time are missing";
    else if (c->is && (status = statement_of(c->is, claimed, &is, err)) == OST_OK && !json_equal(stated, is))
        *why = "is a statement about another bundle than this one";
    json_decref(stated);
    json_decref(is);
    return status;
}

/* Returns the index of the trusted key with which signature number s of an envelope was made; -1 if there is none. */
static int signer_of(const sign_trust *t, const sign_envelope *e, int s)
{
    for (int k = 0; k < t->count; k++)
        if (sign_holds(&t->keys[k], e->encoded, e->encoded_size, e->signatures[s].bytes, e->signatures[s].size))
            return k;
    return -1;
}

/* Verifies all signatures of an envelope and adds the fingerprints of their keys to `keys`. If a signature is invalid,
   returns the reason. If all are valid, returns NULL. */
static const char *verify_signatures(const check *c, const sign_envelope *e, json_t *keys)
{
    bool used[SIGN_KEYS_MAX] = {false};
    for (int s = 0; s < e->count; s++) {
        const int k = signer_of(c->trust, e, s);
        if (k < 0) {
            for (int i = 0; i < c->trust->count; i++)
                if (strcmp(c->trust->keys[i].fingerprint, e->signatures[s].keyid) == 0)
                    return "has a wrong signature: the key that it names did not sign this";
            return "has a signature by a key that is not trusted";
        }
        if (used[k])
            return "has two signatures by one key";
        used[k] = true;
        json_array_append_new(keys, json_string(c->trust->keys[k].fingerprint));
    }
    return NULL;
}

/* Checks the time stamp of an envelope. Sets `time` to "" if the envelope has none. */
static ost_status check_time(const check *c, const char *name, const char *bytes, size_t size, char time[SIGN_TIME],
                             bool *there, ost_error *err)
{
    char file[300], *response;
    size_t response_size = 0;
    bool absent;
    time[0] = '\0';
    snprintf(file, sizeof file, "%.255s" TIME_STAMP_END, name);
    const int before = *c->found;
    ost_status status = read_within(c, file, TIME_STAMP_MAX, &response, &response_size, &absent, err);
    *there = response != NULL;
    if (status == OST_OK && c->trust && c->trust->authority) {
        const char *why = response ? sign_time_check(c->trust->authority, response, response_size, bytes, size, time)
                                   : NULL;
        if (why)
            report(c, file, why);
        else if (absent)
            report(c, name, "has no time stamp (a file of this name with " TIME_STAMP_END " behind it)");
        if (*c->found > before)
            time[0] = '\0';
    }
    free(response);
    return status;
}

static ost_status check_envelope(const check *c, const char *name, ost_error *err)
{
    char *bytes, time[SIGN_TIME];
    size_t size = 0;
    bool absent, stamped;
    sign_envelope e;
    claim claimed = {.by = ""};
    const char *why;
    ost_status status = read_within(c, name, ENVELOPE_MAX, &bytes, &size, &absent, err);
    if (!bytes)
        return status;
    status = sign_envelope_read(bytes, size, &e, &why, err);
    json_t *keys = json_array();
    if (status == OST_OK && !why) {
        /* The signatures are verified before anything in the envelope is interpreted. */
        why = c->trust ? verify_signatures(c, &e, keys) : NULL;
        if (!why)
            status = compare_statement(c, &e, &claimed, &why, err);
        sign_envelope_free(&e);
    }
    if (status == OST_OK && why)
        report(c, name, why);
    else if (status == OST_OK && (status = check_time(c, name, bytes, size, time, &stamped, err)) == OST_OK) {
        json_t *o = json_pack("{s:s,s:s,s:s,s:s,s:O,s:b,s:b,s:s}", "file", name, "by", claimed.by, "meaning",
                              claimed.meaning, "claimed_time", claimed.time, "keys", keys, "checked", c->trust != NULL,
                              "stamped", stamped, "time_stamp", time);
        if (!o || json_array_append_new(c->list, o) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for signatures");
    }
    json_decref(keys);
    free(bytes);
    return status;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcmp(text + a - b, end) == 0;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

/* Checks every file of the folder in order of name. The names begin with the time of signing. */
static ost_status check_files(const check *c, DIR *dir, ost_error *err)
{
    char names[FILES_MAX][256];
    size_t count = 0;
    ost_status status = OST_OK;
    for (struct dirent *e; (status = bundle_next_entry(dir, c->folder, &e, err)) == OST_OK && e; count++) {
        if (count == FILES_MAX) {
            report(c, "", "has more than 64 files");
            return OST_OK;
        }
        snprintf(names[count], sizeof names[count], "%.255s", e->d_name);
    }
    qsort(names, count, sizeof names[0], by_name);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        char envelope[256];
        const size_t length = strlen(names[i]);
        if (ends_with(names[i], ENVELOPE_END)) {
            status = check_envelope(c, names[i], err);
            continue;
        }
        snprintf(envelope, sizeof envelope, "%.*s",
                 ends_with(names[i], TIME_STAMP_END) ? (int)(length - strlen(TIME_STAMP_END)) : 0, names[i]);
        if (!ends_with(envelope, ENVELOPE_END) || faccessat(c->signatures, envelope, F_OK, AT_SYMLINK_NOFOLLOW) != 0)
            report(c, names[i],
                   "is neither an envelope (NAME" ENVELOPE_END
                   ") nor the time stamp of one (NAME" ENVELOPE_END TIME_STAMP_END ")");
    }
    return status;
}

ost_status sign_check(const char *folder, const sign_trust *trust, bundle_problem *problem, void *user, int *found,
                      json_t **out, ost_error *err)
{
    char path[BUNDLE_PATH];
    contents is;
    ost_error unread = {0};
    check c = {.folder = folder,
               .signatures = -1,
               .trust = trust,
               .problem = problem,
               .user = user,
               .found = found,
               .list = json_array()};
    ost_status status = OST_OK;
    const int before = *found;
    if (snprintf(path, sizeof path, "%s/" MANIFEST_SIGNATURES, folder) >= (int)sizeof path)
        status = ost_fail(err, OST_ERR_INPUT, "%.200s: too long", folder);
    const int fd = status == OST_OK ? open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC) : -1;
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    const int why = errno;
    if (status == OST_OK && !dir && (why == ENOTDIR || why == ELOOP))
        report(&c, "", "is not a folder");
    else if (status == OST_OK && !dir && why != ENOENT)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot read: %s", path, strerror(why));
    if (fd >= 0 && !dir)
        close(fd);
    if (status == OST_OK && dir) {
        c.signatures = fd;
        c.is = contents_read(folder, &is, &unread) == OST_OK ? &is : NULL;
        status = unread.status == OST_ERR_MEMORY ? ost_fail(err, unread.status, "%s", unread.text)
                                                 : check_files(&c, dir, err);
        if (c.is)
            contents_free(&is);
    }
    if (dir)
        closedir(dir);
    if (status == OST_OK && trust && *found == before && !json_array_size(c.list))
        report(&c, "", "has no signature");
    *out = c.list;
    return status;
}
