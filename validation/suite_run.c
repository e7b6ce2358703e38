/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/suite_run.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "validation/bundle/limits.h"
#include "validation/bundle/suite.h"
#include "validation/signal_cleanup.h"

#define RUN_TEST "tests/run-test"
enum { SLOTS = 16, BLOCK = 1 << 16, WAIT_MS = 50 };

extern char **environ;

typedef struct running {
    pid_t pid;   /* process id of the test, and id of its process group */
    int output_fd; /* read end of the pipe for the test's output; -1 after the end of the output */
    size_t number;
    double begun;
    json_int_t bytes;
    ost_hasher *hasher;
    const char *stopped; /* "time" or "output", the limit that the test exceeded; "" if the test was not stopped */
    bool line_ended;
    size_t used;
    char line[SUITE_REASON]; /* last non-empty line of the output */
} running;

typedef struct runner {
    const suite_options *o;
    char program[PATH_MAX];
    const json_t *tests;
    json_t *rows; /* array with one entry per test: the test's row in suite.json, or null before it ends */
    running slots[SLOTS];
    int count;
    size_t done;
} runner;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static ost_status find_program(const char *folder, char path[PATH_MAX], ost_error *err)
{
    char name[PATH_MAX];
    struct stat info;
    if (snprintf(name, sizeof name, "%s/" RUN_TEST, folder) >= (int)sizeof name)
        return ost_fail(err, OST_ERR_INPUT, "--with-suite %.100s...: the name is too long", folder);
    if (!realpath(name, path))
        return ost_fail(err, OST_ERR_INPUT,
                        "--with-suite %s: has no program " RUN_TEST " (%s); name the folder that osteon was built in",
                        folder, strerror(errno));
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode) || access(path, X_OK) != 0)
        return ost_fail(err, OST_ERR_INPUT, "--with-suite %s: " RUN_TEST " is no program that can be executed", folder);
    return OST_OK;
}

ost_status suite_find(const char *folder, ost_error *err)
{
    char path[PATH_MAX];
    return find_program(folder, path, err);
}

/* ---------------------------------------------------------- starting tests */

static ost_status start(runner *r, size_t number, ost_error *err)
{
    running *t = &r->slots[r->count];
    char *argv[] = {r->program, (char *)(uintptr_t)json_string_value(json_array_get(r->tests, number)), NULL};
    int ends[2], failed;
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    *t = (running){.number = number, .begun = now_s(), .stopped = ""};
    ost_status status = ost_hasher_open(&t->hasher, err);
    if (status != OST_OK)
        return status;
    if (pipe2(ends, O_CLOEXEC) != 0) {
        ost_hasher_close(t->hasher, NULL, NULL);
        return ost_fail(err, OST_ERR_IO, "no pipe for a test: %s", strerror(errno));
    }
    (void)fcntl(ends[0], F_SETFL, O_NONBLOCK);
    failed = posix_spawn_file_actions_init(&actions);
    if (!failed) {
        failed = posix_spawnattr_init(&attributes);
        if (!failed) {
            failed = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
            if (!failed)
                failed = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
            if (!failed)
                failed = posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
            if (!failed)
                failed = posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
            if (!failed)
                failed = posix_spawn(&t->pid, r->program, &actions, &attributes, argv, environ);
            posix_spawnattr_destroy(&attributes);
        }
        posix_spawn_file_actions_destroy(&actions);
    }
    close(ends[1]);
    if (failed) {
        close(ends[0]);
        ost_hasher_close(t->hasher, NULL, NULL);
        return ost_fail(err, OST_ERR_IO, "%s cannot be started: %s", r->program, strerror(failed));
    }
    signal_cleanup_worker(t->pid);
    t->output_fd = ends[0];
    r->count++;
    return OST_OK;
}

/* Ends a test and all processes of its group. */
static void stop(running *t, const char *why)
{
    if (!*t->stopped)
        t->stopped = why;
    kill(-t->pid, SIGKILL);
}

/* ------------------------------------------------------ reading the output */

static void store_line(running *t, const char *bytes, ssize_t count)
{
    for (ssize_t i = 0; i < count; i++) {
        if (bytes[i] == '\n') {
            t->line_ended = t->used > 0;
            continue;
        }
        if (t->line_ended) {
            t->used = 0;
            t->line_ended = false;
        }
        if (t->used < sizeof t->line - 1)
            t->line[t->used++] = bytes[i];
        t->line[t->used] = '\0';
    }
}

/* Reads the available output up to the limit. Closes the pipe at the end of the output. */
static ost_status read_output(running *t, ost_error *err)
{
    char block[BLOCK];
    ost_status status = OST_OK;
    while (status == OST_OK && t->output_fd >= 0 && !*t->stopped) {
        const ssize_t n = read(t->output_fd, block, sizeof block);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            break;
        if (n <= 0) {
            close(t->output_fd);
            t->output_fd = -1;
            break;
        }
        t->bytes += n;
        store_line(t, block, n);
        status = ost_hasher_add(t->hasher, block, (size_t)n, err);
        if (t->bytes > SUITE_OUTPUT_MAX)
            stop(t, "output");
    }
    return status;
}

/* ------------------------------------------------------------ ending tests */

static void reason_of(const runner *r, const running *t, json_int_t status, char reason[2 * SUITE_REASON])
{
    char line[SUITE_REASON], how[80];
    limits_printable(t->line, line, sizeof line);
    if (strcmp(t->stopped, "time") == 0)
        snprintf(how, sizeof how, "ran longer than %lld s and was stopped", (long long)r->o->limit_s);
    else if (*t->stopped)
        snprintf(how, sizeof how, "printed more than %lld bytes and was stopped", (long long)SUITE_OUTPUT_MAX);
    else if (status < 0)
        snprintf(how, sizeof how, "was ended by signal %lld", (long long)-status);
    else
        snprintf(how, sizeof how, "ended with status %lld", (long long)status);
    const bool plain = status == SUITE_SKIPPED && !*t->stopped && *line; /* a skipped test prints the reason itself */
    snprintf(reason, 2 * SUITE_REASON, "%s%s%s", plain ? "" : how, !plain && *line ? "; it printed last: " : "", line);
}

/* Makes the suite.json row of a test that ended, and frees its slot. */
static ost_status finish(runner *r, int slot, int state, ost_error *err)
{
    running *t = &r->slots[slot];
    char reason[2 * SUITE_REASON], hex[OST_DIGEST_HEX];
    ost_digest digest = {{0}};
    const json_int_t code = WIFSIGNALED(state) ? -(json_int_t)WTERMSIG(state) : (json_int_t)WEXITSTATUS(state);
    ost_status status = read_output(t, err);
    if (t->output_fd >= 0)
        close(t->output_fd);
    const ost_status closed = ost_hasher_close(t->hasher, &digest, status == OST_OK ? err : NULL);
    signal_cleanup_worker_gone(t->pid);
    status = status == OST_OK ? closed : status;
    const char *result = suite_result(code, t->stopped);
    json_t *row = json_pack("{s:s,s:s,s:I,s:I,s:s,s:f}", "test", json_string_value(json_array_get(r->tests, t->number)),
                            "result", result, "status", code, "output_bytes", t->bytes, "output_sha256",
                            ost_digest_hex(&digest, hex), "seconds", now_s() - t->begun);
    if (*t->stopped)
        json_object_set_new(row, "stopped", json_string(t->stopped));
    if (strcmp(result, "passed") != 0) {
        reason_of(r, t, code, reason);
        json_object_set_new(row, "reason", json_string(reason));
    }
    if (status == OST_OK && (!row || json_array_set(r->rows, t->number, row) != 0))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the suite's results");
    json_decref(row);
    r->slots[slot] = r->slots[--r->count];
    r->done++;
    return status;
}

/* Records the tests that have ended, and kills their process groups, so that no process of these tests remains. */
static ost_status reap(runner *r, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = r->count - 1; i >= 0 && status == OST_OK; i--) {
        siginfo_t info = {0};
        int state;
        if (waitid(P_PID, (id_t)r->slots[i].pid, &info, WEXITED | WNOHANG | WNOWAIT) != 0 || !info.si_pid)
            continue;
        /* the signal is sent before waitpid, because the process id may be reused afterwards */
        kill(-r->slots[i].pid, SIGKILL);
        while (waitpid(r->slots[i].pid, &state, 0) < 0)
            if (errno != EINTR)
                return ost_fail(err, OST_ERR_IO, "waiting for a test: %s", strerror(errno));
        status = finish(r, i, state, err);
    }
    return status;
}

static ost_status listen_to_all(runner *r, ost_error *err)
{
    struct pollfd polled[SLOTS];
    ost_status status = OST_OK;
    for (int i = 0; i < r->count; i++)
        polled[i] = (struct pollfd){.fd = *r->slots[i].stopped ? -1 : r->slots[i].output_fd, .events = POLLIN};
    if (poll(polled, (nfds_t)r->count, WAIT_MS) < 0 && errno != EINTR)
        return ost_fail(err, OST_ERR_IO, "waiting for tests: %s", strerror(errno));
    for (int i = 0; i < r->count && status == OST_OK; i++) {
        status = read_output(&r->slots[i], err);
        if (now_s() - r->slots[i].begun > (double)r->o->limit_s)
            stop(&r->slots[i], "time");
    }
    return status;
}

static ost_status run_all(runner *r, ost_error *err)
{
    const size_t count = json_array_size(r->tests);
    const int jobs = r->o->jobs < 1 ? 1 : r->o->jobs < SLOTS ? r->o->jobs : SLOTS;
    ost_status status = OST_OK;
    for (size_t next = 0; status == OST_OK && (next < count || r->count);) {
        while (status == OST_OK && next < count && r->count < jobs) {
            if (r->o->show)
                r->o->show(r->o->user, json_string_value(json_array_get(r->tests, next)),
                           (double)r->done / (double)count);
            status = start(r, next++, err);
        }
        if (status == OST_OK)
            status = listen_to_all(r, err);
        if (status == OST_OK)
            status = reap(r, err);
    }
    for (int i = 0; i < r->count; i++) { /* after an error, the tests that are still running are stopped */
        running *t = &r->slots[i];
        stop(t, "time");
        waitpid(t->pid, NULL, 0);
        signal_cleanup_worker_gone(t->pid);
        ost_hasher_close(t->hasher, NULL, NULL);
        if (t->output_fd >= 0)
            close(t->output_fd);
    }
    return status;
}

ost_status suite_run(const suite_options *o, json_t **out, ost_error *err)
{
    json_t *tests = suite_tests(o->requirements), *rows = json_array();
    runner r = {.o = o, .tests = tests, .rows = rows};
    *out = NULL;
    ost_status status = tests && rows ? find_program(o->folder, r.program, err)
                                      : ost_fail(err, OST_ERR_MEMORY, "out of memory for the suite");
    for (size_t i = 0; status == OST_OK && i < json_array_size(tests); i++)
        if (json_array_append_new(rows, json_null()) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the suite");
    if (status == OST_OK)
        status = run_all(&r, err);
    if (status == OST_OK && !(*out = json_pack("{s:I,s:O}", "limit_s", (json_int_t)o->limit_s, "tests", rows)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the suite's results");
    if (status == OST_OK)
        suite_count(*out);
    json_decref(tests);
    json_decref(rows);
    return status;
}
