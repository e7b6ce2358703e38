/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/worker.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "validation/dense/dense.h"
#include "validation/signal_cleanup.h"
#include "validation/paths.h"
#include "validation/perform.h"
#include "validation/subjects.h"

extern char **environ;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

ost_status worker_run(const plan *p, int from, int to, const char *spec, const char *trace_path, const char *given,
                      ost_error *err)
{
    ost_backend *backend = NULL;
    trace_writer *w = NULL;
    trace reference = {0};
    to = to < p->count ? to : p->count;
    double *seconds = calloc((size_t)(to > from ? to - from : 0) + 1, sizeof *seconds);
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* the kernel kills the worker if its parent ends */
    const bool second = strcmp(spec, SUBJECT_DENSE) == 0;
    ost_status status = seconds ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of %d cases",
                                                    to - from);
    if (status == OST_OK)
        status = second ? dense_open(NULL, &backend, err) : ost_backend_open(spec, &backend, err);
    if (status == OST_OK && given)
        status = trace_open(given, &reference, err);
    if (status == OST_OK)
        status = trace_create(trace_path, &w, err);
    for (int i = from; i < to && status == OST_OK; i++) {
        scene s;
        ost_error why = {0};
        const double begun = now_s();
        status = scene_make(&p->cases[i], &s, err);
        if (status != OST_OK)
            break;
        status = scene_digest(&s, &s.digest, err);
        if (status == OST_OK)
            status = given ? perform_apart(backend, &s, (uint32_t)i, w, &reference, &why, err)
                     : second ? perform_second(backend, &s, (uint32_t)i, w, &why, err)
                     : perform(backend, &s, (uint32_t)i, w, NULL, NULL, &why, err);
        scene_free(&s);
        seconds[i - from] = now_s() - begun;
        if (status == OST_OK && (why.status == OST_ERR_MEMORY || why.status == OST_ERR_IO))
            status = ost_fail(err, why.status, "%s on %s: %s", p->cases[i].id, spec, why.text);
        else if (why.status != OST_OK)
        {
            ost_error line;
            /* ost_fail makes the text printable */
            (void)ost_fail(&line, why.status, "%s on %s: %s", p->cases[i].id, spec, why.text);
            fprintf(stderr, "%s\n", line.text);
        }
    }
    if (w && status == OST_OK) {
        trace_begin(w, TRACE_END, (uint32_t)to, TRACE_TIMES);
        for (int i = from; i < to; i++)
            trace_word(w, (uint64_t)(1e6 * seconds[i - from]));
        status = trace_end(w, err);
    }
    if (w && status == OST_OK) {
        trace_begin(w, TRACE_END, (uint32_t)to, 0);
        paths_write(backend, w);
        status = trace_end(w, err);
    }
    ost_status closed = trace_close(w, err);
    free(seconds);
    trace_free(&reference);
    ost_backend_close(backend);
    return status != OST_OK ? status : closed;
}

ost_status worker_program(char path[], size_t size, ost_error *err)
{
    const ssize_t n = readlink("/proc/self/exe", path, size - 1);
    if (n < 0)
        return ost_fail(err, OST_ERR_IO, "/proc/self/exe: %s", strerror(errno));
    path[n] = '\0';
    return OST_OK;
}

ost_status worker_start(char *const argv[], int trace_fd, int user_fd, double limit_s, worker *out, ost_error *err)
{
    int ends[2];
    *out = (worker){.pid = -1, .stderr_fd = -1, .limit_s = limit_s, .begun = now_s()};
    if (pipe2(ends, O_CLOEXEC) != 0)
        return ost_fail(err, OST_ERR_IO, "no pipe for a worker: %s", strerror(errno));
    /* There may be more threads than cores, so a waiting thread must not occupy a core. */
    (void)setenv("OMP_WAIT_POLICY", "passive", 0);
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (!failed) {
        failed = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        if (!failed)
            failed = posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        if (!failed)
            failed = posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
        if (!failed && trace_fd >= 0)
            failed = posix_spawn_file_actions_adddup2(&actions, trace_fd, WORKER_TRACE);
        if (!failed && user_fd >= 0)
            failed = posix_spawn_file_actions_adddup2(&actions, user_fd, WORKER_USER);
        if (!failed)
            failed = posix_spawn(&out->pid, argv[0], &actions, NULL, argv, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    close(ends[1]);
    if (failed) {
        close(ends[0]);
        return ost_fail(err, OST_ERR_IO, "%s cannot be started: %s", argv[0], strerror(failed));
    }
    signal_cleanup_worker(out->pid);
    out->stderr_fd = ends[0];
    return OST_OK;
}

static void listen_to(worker *w, const char *bytes, ssize_t count)
{
    for (ssize_t i = 0; i < count; i++) {
        if (bytes[i] == '\n') {
            w->complete = true;
            continue;
        }
        if (w->complete) {
            w->used = 0;
            w->complete = false;
        }
        if (w->used < sizeof w->text - 1)
            w->text[w->used++] = bytes[i];
        w->text[w->used] = '\0';
    }
}

static ost_status reap(worker *w, bool late, worker_result *out, ost_error *err)
{
    int state = 0;
    close(w->stderr_fd);
    while (waitpid(w->pid, &state, 0) < 0)
        if (errno != EINTR)
            return ost_fail(err, OST_ERR_IO, "waiting for a worker: %s", strerror(errno));
    signal_cleanup_worker_gone(w->pid);
    *out = (worker_result){.end = WORKER_DONE, .seconds = now_s() - w->begun};
    memcpy(out->text, w->text, sizeof out->text);
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

ost_status worker_wait_any(worker *const workers[], int count, int *which, worker_result *out, ost_error *err)
{
    struct pollfd polled[WORKERS_MAX];
    for (;;) {
        double left = 1000;
        for (int i = 0; i < count; i++) {
            const double own = workers[i]->limit_s - (now_s() - workers[i]->begun);
            polled[i] = (struct pollfd){.fd = workers[i]->stderr_fd, .events = POLLIN};
            if (own <= 0) {
                *which = i;
                kill(workers[i]->pid, SIGKILL);
                return reap(workers[i], true, out, err);
            }
            left = own < left ? own : left;
        }
        const int ready = poll(polled, (nfds_t)count, (int)(left * 1000) + 1);
        if (ready < 0 && errno != EINTR)
            return ost_fail(err, OST_ERR_IO, "waiting for workers: %s", strerror(errno));
        for (int i = 0; i < count && ready > 0; i++) {
            char bytes[1024];
            if (!polled[i].revents)
                continue;
            const ssize_t n = read(workers[i]->stderr_fd, bytes, sizeof bytes);
            if (n < 0 && errno == EINTR)
                continue;
            if (n <= 0) { /* the write end of the pipe is closed when the worker ends for any reason */
                *which = i;
                return reap(workers[i], false, out, err);
            }
            listen_to(workers[i], bytes, n);
        }
    }
}

ost_status worker_wait(worker *w, worker_result *out, ost_error *err)
{
    worker *const alone[] = {w};
    int which;
    return worker_wait_any(alone, 1, &which, out, err);
}

void worker_stop(worker *w)
{
    worker_result end;
    ost_error none = {0};
    kill(w->pid, SIGKILL);
    reap(w, false, &end, &none);
}
