/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/worker.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "validation/perform.h"

extern char **environ;

ost_status worker_run(const plan *p, int from, const char *spec, const char *trace_path, ost_error *err)
{
    ost_backend *backend = NULL;
    trace_writer *w = NULL;
    ost_status status = ost_backend_open(spec, &backend, err);
    if (status == OST_OK)
        status = trace_create(trace_path, &w, err);
    for (int i = from; i < p->count && status == OST_OK; i++) {
        scene s;
        ost_error why = {0};
        status = scene_make(&p->cases[i], &s, err);
        if (status != OST_OK)
            break;
        status = perform(backend, &s, (uint32_t)i, w, NULL, NULL, &why, err);
        scene_free(&s);
        if (why.status != OST_OK)
            fprintf(stderr, "%s on %s: %s\n", p->cases[i].id, spec, why.text);
    }
    if (w && status == OST_OK) {
        trace_begin(w, TRACE_END, (uint32_t)p->count, 0);
        status = trace_end(w, err);
    }
    ost_status closed = trace_close(w, err);
    ost_backend_close(backend);
    return status != OST_OK ? status : closed;
}

ost_status worker_start(char *const argv[], worker *out, ost_error *err)
{
    int ends[2];
    *out = (worker){.pid = -1, .said = -1};
    if (pipe2(ends, O_CLOEXEC) != 0)
        return ost_fail(err, OST_ERR_IO, "no pipe for a worker: %s", strerror(errno));
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (!failed) {
        failed = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        if (!failed)
            failed = posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        if (!failed)
            failed = posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
        if (!failed)
            failed = posix_spawn(&out->pid, argv[0], &actions, NULL, argv, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    close(ends[1]);
    if (failed) {
        close(ends[0]);
        return ost_fail(err, OST_ERR_IO, "%s cannot be started: %s", argv[0], strerror(failed));
    }
    out->said = ends[0];
    return OST_OK;
}

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The last whole line of what it says; only so much is kept. */
typedef struct last_line {
    char text[512];
    size_t used;
    bool complete;
} last_line;

static void listen_to(last_line *l, const char *bytes, ssize_t count)
{
    for (ssize_t i = 0; i < count; i++) {
        if (bytes[i] == '\n') {
            l->complete = true;
            continue;
        }
        if (l->complete) {
            l->used = 0;
            l->complete = false;
        }
        if (l->used < sizeof l->text - 1)
            l->text[l->used++] = bytes[i];
        l->text[l->used] = '\0';
    }
}

ost_status worker_wait(worker *w, double limit_s, worker_result *out, ost_error *err)
{
    const double begin = now_s();
    last_line said = {.used = 0};
    bool late = false;
    *out = (worker_result){.end = WORKER_DONE};
    /* Its end of the pipe closes when it ends, whatever way. */
    for (;;) {
        const double left = limit_s - (now_s() - begin);
        struct pollfd p = {.fd = w->said, .events = POLLIN};
        const int ready = left > 0 ? poll(&p, 1, left > 1000 ? 1000000 : (int)(left * 1000) + 1) : 0;
        if (ready < 0 && errno == EINTR)
            continue;
        if (ready == 0 && left <= 0) {
            late = true;
            kill(w->pid, SIGKILL);
            break;
        }
        if (ready == 0)
            continue;
        char bytes[1024];
        const ssize_t n = read(w->said, bytes, sizeof bytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            break;
        listen_to(&said, bytes, n);
    }
    close(w->said);
    int state;
    while (waitpid(w->pid, &state, 0) < 0)
        if (errno != EINTR)
            return ost_fail(err, OST_ERR_IO, "waiting for a worker: %s", strerror(errno));
    out->seconds = now_s() - begin;
    memcpy(out->text, said.text, sizeof out->text);
    if (late)
        out->end = WORKER_LATE;
    else if (WIFSIGNALED(state)) {
        out->end = WORKER_CRASHED;
        out->code = WTERMSIG(state);
    } else if (WEXITSTATUS(state) != 0) {
        out->end = WORKER_FAILED;
        out->code = WEXITSTATUS(state);
    }
    return OST_OK;
}
