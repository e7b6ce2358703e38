/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests report.html: it must follow from the bundle, escape its input, have no dead links, and show differences.
 *
 * The test makes bundles from a protocol and cases written by hand. For a case with a difference, it writes two traces,
 * each with two records of a small bone.
 *
 * Covers: REQ-VALIDATE
 */
#include "report_cases.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory_stream.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/check.h"
#include "validation/report/page.h"
#include "validation/report/pictures.h"
#include "validation/report/report.h"

enum { PATH = 512 };
static char scratch[64];

static ost_status put_file(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    return bundle_put(user, name, bytes, size, err);
}

/* -------------------------------------------------------------- a bundle */

static void put_text_file(bundle *b, const char *name, const char *text)
{
    ost_error err = {0};
    assert_ok(bundle_put(b, name, text, strlen(text), &err));
}

/*
 * Writes one of two traces of a case. The chunks are equal in both traces, and the tick after them differs:
 * if `other` is true, the tick removes one voxel less in the first leaf, and nothing in the second leaf.
 */
static void write_trace(const char *path, bool other)
{
    ost_error err = {0};
    trace_writer *w;
    const int32_t zero[3] = {0, 0, 0}, leaf[3] = {32, 0, 0};
    const ost_dims all = {40, 33, 34}, first = {32, 32, 32}, second = {8, 32, 32};
    assert_ok(trace_create(path, &w, &err));
    trace_begin(w, TRACE_CASE, 0, 0);
    assert_ok(trace_end(w, &err));
    trace_begin(w, TRACE_CHUNKS, 0, 0);
    trace_word(w, 1);
    int16_t *voxels = trace_block(w, zero, all, 2);
    for (int64_t i = 0; i < ost_dims_count(all); i++)
        voxels[i] = 500;
    assert_ok(trace_end(w, &err));
    trace_begin(w, TRACE_TICK, 0, 0);
    trace_word(w, 1);
    voxels = trace_block(w, zero, first, 2);
    for (int64_t i = 0; i < ost_dims_count(first); i++)
        voxels[i] = i % 32 > 20 && i / 32 % 32 > 20 && !(other && i == 31 + 32 * (31 + 32 * 5)) ? 0 : 500;
    if (!other) {
        voxels = trace_block(w, leaf, second, 2);
        for (int64_t i = 0; i < ost_dims_count(second); i++)
            voxels[i] = i < 8 ? 0 : 500;
    }
    assert_ok(trace_end(w, &err));
    trace_begin(w, TRACE_END, 1, 0);
    assert_ok(trace_end(w, &err));
    assert_ok(trace_close(w, &err));
}

/* Stores the pictures of case session/1 on backend 1 by calling the campaign's callback. */
static void put_difference(bundle *b)
{
    ost_error err = {0};
    char one[PATH], two[PATH];
    trace got;
    plan_case c = {.family = PLAN_SESSION, .number = 1, .id = "session/1"};
    subject subjects[2] = {{.available = true}, {.available = true}};
    case_result results[2] = {{.verdict = CASE_EQUAL}};
    compare_range range;
    plan p = {.count = 1, .cases = &c};
    subject_list list = {.count = 2, .subjects = subjects};
    campaign run = {.plan = &p, .subjects = &list, .results = results, .ranges = &range};
    picture_keeper keeper = {.sink = put_file, .user = b};
    snprintf(one, sizeof one, "%s/one", scratch);
    snprintf(two, sizeof two, "%s/two", scratch);
    write_trace(one, false);
    write_trace(two, true);
    assert_ok(trace_open(one, &run.reference, &err));
    assert_ok(trace_open(two, &got, &err));
    range = compare_find(&run.reference, 0);
    compare_case(&run.reference, range, &got, compare_find(&got, 0), &results[1].difference);
    assert_int_equal(results[1].difference.kind, COMPARE_VOXEL);
    pictures_of_difference(&keeper, &run, 0, 1, &got, compare_find(&got, 0));
    assert_int_equal(keeper.err.status, OST_OK);
    assert_int_equal(keeper.drawn[1], 1);
    trace_free(&got);
    trace_free(&run.reference);
    unlink(one);
    unlink(two);
}

static void make_bundle(const char *out, const kind *k)
{
    ost_error err = {0};
    bundle *b;
    char *bytes, hex[OST_DIGEST_HEX];
    size_t size;
    ost_digest digest;
    json_t *protocol = protocol_of(k), *cases = cases_of(k);
    assert_ok(bundle_begin(out, &b, &err));
    assert_ok(evidence_write(protocol, cases, put_file, b, &err));
    assert_ok(bundle_read(bundle_folder(b), EVIDENCE_PROTOCOL, &bytes, &size, &err));
    assert_ok(ost_digest_bytes(bytes, size, &digest, &err));
    free(bytes);
    assert_ok(bundle_log(b, "protocol frozen", &err, "%s", ost_digest_hex(&digest, hex)));
    assert_ok(bundle_log(b, "results", &err, "here"));
    put_text_file(b, "environment.json", "{}\n");
    put_text_file(b, "times.json", "{}\n");
    put_text_file(b, "junit.xml", "<testsuites/>\n");
    if (k == &hostile) {
        put_text_file(
            b, "sensitivity.json",
            "{\"injected\":3,\"kinds\":[{\"name\":\"<b>x\",\"what\":\"\\\"'<script>\",\"stage\":\"&\"},7,[]]}\n");
        put_text_file(b, PICTURE_AFTER, "no picture \"><script>");
    }
    if (k == &differing) {
        put_text_file(b, "sensitivity.json",
                      "{\"injected\":12,\"kinds\":["
                      "{\"name\":\"seen\",\"stage\":\"tool\",\"injected\":4,\"changed\":4,\"detected\":4,\"localized\":"
                      "4,\"survived\":0},"
                      "{\"name\":\"other\",\"stage\":\"cubic\",\"injected\":5,\"changed\":0,\"detected\":0,"
                      "\"localized\":0,\"survived\":5},"
                      "{\"name\":\"missed\",\"stage\":\"tool\",\"injected\":3,\"changed\":3,\"detected\":2,"
                      "\"localized\":2,\"survived\":0}]}\n");
        put_difference(b);
    }
    assert_ok(report_write(bundle_folder(b), protocol, cases, put_file, b, &err));
    assert_ok(bundle_end(b, &err));
    json_decref(protocol);
    json_decref(cases);
}

static char *page_of(const char *folder)
{
    ost_error err = {0};
    char *bytes;
    size_t size;
    assert_ok(bundle_read(folder, REPORT_FILE, &bytes, &size, &err));
    assert_int_equal(strlen(bytes), size);
    return bytes;
}

static int about_page;
static void append_problem(void *user, bundle_problem_kind what, const char *file, const char *problem)
{
    (void)what;
    char *all = user;
    const size_t used = strlen(all);
    if (strcmp(file, REPORT_FILE) != 0 && strncmp(file, "pictures/", 9) != 0)
        return; /* The bundles were made without a campaign, so problems in their other files are expected. */
    about_page++;
    snprintf(all + used, 4096 - used, "%s %s\n", file, problem);
}

/*
 * Returns the number of problems that the check of the bundle reports for the page and its
 * pictures. Appends the problems to `all`, one per line.
 */
static int problems_of(const char *folder, char all[4096])
{
    ost_error err = {0};
    json_t *summary;
    int found;
    all[0] = '\0';
    about_page = 0;
    assert_ok(check_bundle(folder, append_problem, all, &found, &summary, &err));
    json_decref(summary);
    return about_page;
}

static void flip(const char *folder, const char *name, long at)
{
    char path[PATH];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    const int c = fgetc(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    fputc(c ^ 1, file);
    assert_int_equal(fclose(file), 0);
}

static const char *path_in(const char *name)
{
    static char path[PATH];
    snprintf(path, sizeof path, "%s/%s", scratch, name);
    return path;
}

static void clear(const char *folder)
{
    DIR *dir = opendir(folder);
    for (struct dirent *e; dir && (e = readdir(dir));) {
        char path[PATH + 300];
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (unlink(path) != 0)
            clear(path);
    }
    if (dir)
        closedir(dir);
    rmdir(folder);
}

/* ----------------------------------------------------------------- tests */

/* Overwrites the time in a page with zeros. Two pages of equal results differ only in the time. */
static void without_time(char *html)
{
    static const char row[] = "<tr><th>Begun</th><td>";
    char *at = strstr(html, row);
    if (at)
        memset(at + strlen(row), '0', strlen("2026-11-22 22:05:06"));
}

static void page_follows_from_bundle(void **state)
{
    const kind *kinds[] = {&equal_kind, &reduced, &differing, &hostile};
    char all[4096];
    (void)state;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        char one[PATH], two[PATH];
        snprintf(one, sizeof one, "%s/a%zu", scratch, i);
        snprintf(two, sizeof two, "%s/b%zu", scratch, i);
        make_bundle(one, kinds[i]);
        make_bundle(two, kinds[i]);
        if (problems_of(one, all))
            fail_msg("%s", all);
        char *a = page_of(one), *b = page_of(two);
        without_time(a);
        without_time(b);
        assert_string_equal(a, b);
        free(a);
        free(b);
    }
}

static void verdict_is_first(void **state)
{
    const struct {
        const kind *kind;
        const char *contains, *lacks;
    } expected[] = {{&equal_kind, " EQUAL</b>", "NOT EQUAL"},
                    {&reduced, "REDUCED RUN: NO EVIDENCE</b>", " EQUAL</b>"},
                    {&differing, "NOT EQUAL</b>", "&#10003;"}};
    (void)state;
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        char name[32];
        snprintf(name, sizeof name, "v%zu", i);
        make_bundle(path_in(name), expected[i].kind);
        char *html = page_of(path_in(name));
        const char *hit = strstr(html, expected[i].contains), *heading = strstr(html, "<h2>");
        assert_non_null(hit);
        assert_true(hit < heading);
        assert_null(strstr(html, expected[i].lacks));
        const char *not_shown = strstr(html, "<h2 id=\"not-shown\">"),
                   *compared = strstr(html, "<h2>Comparison of the backends");
        assert_non_null(not_shown);
        assert_non_null(compared);
        /* the section `not-shown` must be on the first page, before the comparison */
        assert_true(not_shown < compared);
        free(html);
    }
}

/* Text from the bundle must be escaped, so that the page contains no HTML element or attribute from this text. */
static void input_is_escaped(void **state)
{
    static const char *const bad[] = {"<script", "<img src=x", "onerror=\"", "alert('x')", "\x01", "<b>x"};
    (void)state;
    make_bundle(path_in("hostile"), &hostile);
    char *html = page_of(path_in("hostile"));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_null(strstr(html, bad[i]));
    assert_non_null(strstr(
        html,
        "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;&gt;&lt;img src=x onerror=&quot;y&quot;&gt;&amp;?"));
    free(html);
}

static void links_have_targets(void **state)
{
    const kind *kinds[] = {&equal_kind, &differing, &hostile};
    (void)state;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        char name[32];
        int links = 0;
        snprintf(name, sizeof name, "l%zu", i);
        make_bundle(path_in(name), kinds[i]);
        char *html = page_of(path_in(name));
        for (const char *at = html; (at = strstr(at, "href=\"")); links++) {
            char path[2 * PATH];
            struct stat info;
            at += strlen("href=\"");
            assert_int_not_equal(at[0], '/');
            if (at[0] == '#') { /* a link within the page */
                snprintf(path, sizeof path, "id=\"%.*s\"", (int)strcspn(at + 1, "\""), at + 1);
                assert_non_null(strstr(html, path));
                continue;
            }
            snprintf(path, sizeof path, "%s/%.*s", path_in(name), (int)strcspn(at, "\""), at);
            if (stat(path, &info) != 0)
                fail_msg("the page links to %s, which does not exist", path);
        }
        assert_true(links > 15);
        assert_null(strstr(html, "http://"));
        assert_null(strstr(html, "https://"));
        free(html);
    }
}

static void page_shows_difference(void **state)
{
    static const char *const expected[] = {"tick 12", "the first at (33, 2, 65), chunk (1, 0, 2)",
                                           "<b>700</b>, the reference has <b>-5</b>"};
    struct stat info;
    (void)state;
    make_bundle(path_in("differing"), &differing);
    char *html = page_of(path_in("differing"));
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++)
        assert_non_null(strstr(html, expected[i]));
    if (stat(path_in("differing/pictures/session-1-backend-1-difference.png"), &info) == 0) {
        assert_non_null(
            strstr(html, "alt=\"Reference: axial, coronal, sagittal\" src=\"data:image/png;base64,iVBORw0KGgo"));
        assert_non_null(strstr(html, "alt=\"Backend\""));
        assert_non_null(strstr(html, "alt=\"Difference\""));
    } else
        assert_non_null(strstr(html, "There are no pictures"));
    free(html);
}

/* The page must show the sums per stage, a separate list of the mistakes that were not detected, and every kind in a
   collapsed section. */
static void mistakes_are_summed_per_stage(void **state)
{
    (void)state;
    make_bundle(path_in("mistakes"), &differing);
    char *html = page_of(path_in("mistakes"));
    const char *tool = strstr(html, "<b>tool</b>, 2 kinds</td><td class=\"n\">7</td><td class=\"n\">7</td><td "
                                    "class=\"n\">6</td><td class=\"n\">6</td><td class=\"n\">0</td>");
    assert_non_null(tool);
    assert_null(strstr(tool + 1, "<b>tool</b>"));
    assert_non_null(strstr(tool, "<b>cubic</b>, 1 kind</td>"));
    const char *missed = strstr(tool, "Not all detected"), *all = strstr(tool, "<div class=\"fold\">");
    assert_non_null(missed);
    assert_non_null(all);
    assert_true(missed < strstr(tool, "<b>missed</b>") && strstr(tool, "<b>missed</b>") < all);
    assert_true(strstr(tool, "<b>seen</b>") > all);
    free(html);
}

static void counts_are_formatted(void **state)
{
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    (void)state;
    assert_non_null(to);
    const page p = {.to = to};
    page_many(&p, 1, "case");
    fputs("; ", to);
    page_many(&p, 0, "case");
    fputs("; ", to);
    page_many(&p, 12345, "result");
    assert_true(ost_memory_stream_close(to, &made));
    assert_string_equal(made.bytes, "1 case; 0 cases; 12,345 results");
    free(made.bytes);
}

static void changed_byte_is_detected(void **state)
{
    test_rng rng = rng_seeded("changed_byte_is_detected");
    static const char picture[] = "pictures/session-1-backend-1-difference.png";
    char all[4096], folder[PATH];
    struct stat info;
    (void)state;
    snprintf(folder, sizeof folder, "%s", path_in("changed"));
    make_bundle(folder, &differing);
    for (int i = 0; i < 20; i++) {
        const bool of_picture = i % 2 &&
                                stat(path_in("changed/pictures/session-1-backend-1-difference.png"), &info) == 0;
        const char *name = of_picture ? picture : REPORT_FILE;
        char path[2 * PATH];
        snprintf(path, sizeof path, "%s/%s", folder, name);
        assert_int_equal(stat(path, &info), 0);
        const long at = (long)(rng_next(&rng) % (uint64_t)info.st_size);
        flip(folder, name, at);
        /* one problem concerns the manifest; another problem is that the page no longer matches the bundle */
        assert_true(problems_of(folder, all) >= 2);
        assert_non_null(strstr(all, name));
        assert_non_null(strstr(all, REPORT_FILE " does not match"));
        flip(folder, name, at);
        assert_int_equal(problems_of(folder, all), 0);
    }
}

static ost_status count_pictures(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    (void)bytes;
    (void)err;
    assert_true(size > 0);
    assert_non_null(strstr(name, "session-1-backend-1-"));
    ++*(int *)user;
    return OST_OK;
}

static void pictures_of_shards_are_collected(void **state)
{
    ost_error err = {0};
    int count = 0;
    struct stat info;
    json_t *protocol = protocol_of(&differing), *cases = cases_of(&differing);
    (void)state;
    assert_int_equal(mkdir(path_in("shards"), 0777), 0);
    make_bundle(path_in("shards/1"), &equal_kind);
    make_bundle(path_in("shards/2"), &differing);
    assert_ok(pictures_of_shards(path_in("shards"), protocol, cases, count_pictures, &count, &err));
    assert_int_equal(count, stat(path_in("shards/2/pictures"), &info) == 0 ? 3 : 0);
    json_decref(protocol);
    json_decref(cases);
}

static int make_scratch(void **state)
{
    (void)state;
    snprintf(scratch, sizeof scratch, "/tmp/osteon-report-XXXXXX");
    return mkdtemp(scratch) ? 0 : -1;
}

static int clear_scratch(void **state)
{
    (void)state;
    clear(scratch);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(page_follows_from_bundle),
        cmocka_unit_test(verdict_is_first),
        cmocka_unit_test(input_is_escaped),
        cmocka_unit_test(links_have_targets),
        cmocka_unit_test(page_shows_difference),
        cmocka_unit_test(mistakes_are_summed_per_stage),
        cmocka_unit_test(counts_are_formatted),
        cmocka_unit_test(changed_byte_is_detected),
        cmocka_unit_test(pictures_of_shards_are_collected),
    };
    return cmocka_run_group_tests(tests, make_scratch, clear_scratch);
}
