/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "io/dicom/process.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/clock.h"

extern char **environ;

enum { PIPE_BYTES = 1 << 20, DESCRIPTORS = 64, CANNOT_START = 127, EXIT_WAIT_MS = 1000 };

/* ---------------------------------------------------------------- program */

static bool is_program(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) && access(path, X_OK) == 0;
}

ost_status ost_dicom_program(const char *input, char path[OST_DICOM_PATH_MAX], ost_error *err)
{
    static const char name[] = "osteon-dicom";
    const char *folder = secure_getenv("OSTEON_LIBEXECDIR");
    if (folder && *folder) {
        if (snprintf(path, OST_DICOM_PATH_MAX, "%s/%s", folder, name) < OST_DICOM_PATH_MAX && is_program(path))
            return OST_OK;
    } else {
        snprintf(path, OST_DICOM_PATH_MAX, "%s/%s", OST_PKGLIBEXECDIR, name);
        if (is_program(path))
            return OST_OK;
        const ssize_t n = readlink("/proc/self/exe", path, OST_DICOM_PATH_MAX - sizeof name);
        char *slash = n > 0 ? memrchr(path, '/', (size_t)n) : NULL;
        if (slash) {
            memcpy(slash + 1, name, sizeof name);
            if (is_program(path))
                return OST_OK;
        }
    }
#ifdef HAVE_DCMTK
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: reading DICOM needs the program osteon-dicom, which is not in %s; install osteon completely",
                    input, folder && *folder ? folder : OST_PKGLIBEXECDIR);
#else
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "%s: reading DICOM needs the program osteon-dicom, which is missing because osteon was built "
                    "without DCMTK (Debian: libdcmtk-dev); dcm2niix converts a series to NIfTI",
                    input);
#endif
}

/* ------------------------------------------------------------------ start */

size_t ost_dicom_process_count(size_t parts)
{
    cpu_set_t set;
    size_t most = sched_getaffinity(0, sizeof set, &set) == 0 ? (size_t)CPU_COUNT(&set) : 1;
    most = most < OST_DICOM_PROCESSES_MAX ? most : OST_DICOM_PROCESSES_MAX;
    parts = parts < most ? parts : most;
    return parts ? parts : 1;
}

#if defined __SANITIZE_ADDRESS__
#define SANITIZED 1
#elif defined __has_feature
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

static bool limit(int what, uint64_t value)
{
    const struct rlimit both = {value, value};
    return setrlimit((__rlimit_resource_t)what, &both) == 0;
}

/*
 * Runs in the child after fork. The parent has several threads, so only async-signal-safe functions may be called here.
 */
static void become(const char *program, int request, int output, uint64_t seconds)
{
    char *argv[] = {(char *)(uintptr_t)program, NULL};
    const struct sigaction usual = {.sa_handler = SIG_DFL};
    sigset_t none;
    sigemptyset(&none);
    for (int s = 1; s < NSIG; s++)
        sigaction(s, &usual, NULL);
    sigprocmask(SIG_SETMASK, &none, NULL);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    const int null = open("/dev/null", O_WRONLY);
    /* Any of the three descriptors may itself be 0, 1 or 2, so all are first duplicated to numbers above 2. */
    const int in = fcntl(request, F_DUPFD, 3), out = fcntl(output, F_DUPFD, 3), errors = fcntl(null, F_DUPFD, 3);
    if (in < 0 || out < 0 || errors < 0 || dup2(in, STDIN_FILENO) < 0 || dup2(out, STDOUT_FILENO) < 0 ||
        dup2(errors, STDERR_FILENO) < 0)
        _exit(CANNOT_START);
    close_range(3, UINT_MAX, 0);
    /* The address space is not limited under AddressSanitizer, which reserves terabytes. */
    if ((!SANITIZED && !limit(RLIMIT_AS, OST_DICOM_MEMORY_MAX)) || !limit(RLIMIT_CPU, seconds) ||
        !limit(RLIMIT_FSIZE, 0) || !limit(RLIMIT_CORE, 0))
        _exit(CANNOT_START);
    (void)limit(RLIMIT_NOFILE, DESCRIPTORS); /* failure is ignored, because this limit cannot be set under valgrind */
    execve(program, argv, environ);
    _exit(CANNOT_START);
}

ost_status ost_dicom_process_start(const ost_dicom_launch *launch, int request, size_t images, ost_dicom_process *out,
                                   ost_error *err)
{
    int ends[2];
    *out = (ost_dicom_process){.pipe = -1, .seconds = launch->seconds ? launch->seconds : OST_DICOM_SECONDS};
    if (pipe2(ends, O_CLOEXEC) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot create a pipe: %s", launch->program, strerror(errno));
    /* failure is ignored, because the size of the pipe affects only speed */
    (void)fcntl(ends[0], F_SETPIPE_SZ, PIPE_BYTES);
    out->pipe = ends[0];
    const pid_t pid = fork();
    if (pid == 0)
        become(launch->program, request, ends[1], (uint64_t)out->seconds + images * 2);
    const int error = errno;
    close(ends[1]);
    if (pid < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot start: %s", launch->program, strerror(error));
    out->pid = pid;
    return OST_OK;
}

/* -------------------------------------------------------------------- end */

static void reap(ost_dicom_process *process)
{
    kill(process->pid, SIGKILL);
    while (waitpid(process->pid, NULL, 0) < 0 && errno == EINTR)
        ;
    process->pid = 0;
}

void ost_dicom_process_end(ost_dicom_process *process)
{
    if (process->pid)
        reap(process);
    if (process->pipe >= 0)
        close(process->pipe);
    process->pipe = -1;
}

ost_status ost_dicom_process_nonsense(const char *file, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser sent an invalid message (%s)", file, what);
}

/*
 * Returns the error for a pipe that ended too early. The process has closed its end of the pipe, so normally it has
 * exited or is about to exit.
 */
static ost_status explain_end(ost_dicom_process *process, const char *file, ost_error *err)
{
    int state = 0;
    pid_t ended = 0;
    for (int ms = 0; ms < EXIT_WAIT_MS && ended == 0; ms++) {
        ended = waitpid(process->pid, &state, WNOHANG);
        if (ended == 0)
            poll(NULL, 0, 1);
    }
    if (ended == 0)
        reap(process);
    process->pid = 0;
    if (ended > 0 && WIFSIGNALED(state)) {
        if (WTERMSIG(state) == SIGXCPU)
            return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser exceeded its processor time on this file", file);
        return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser failed on this file (signal %d)", file,
                        WTERMSIG(state));
    }
    if (ended > 0 && WIFEXITED(state) && WEXITSTATUS(state) == CANNOT_START)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: the program osteon-dicom cannot be started", file);
    if (ended > 0 && WIFEXITED(state))
        return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser ended early (exit status %d)", file,
                        WEXITSTATUS(state));
    return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser closed its output early", file);
}

/* --------------------------------------------------------------- messages */

ost_status ost_dicom_process_read(ost_dicom_process *process, const char *file, void *to, size_t size,
                                  ost_error *err)
{
    char *at = to;
    while (size) {
        const int64_t left = process->deadline - ost_clock_ns();
        struct pollfd wait = {.fd = process->pipe, .events = POLLIN};
        const int ready = left > 0 ? poll(&wait, 1, (int)(left / 1000000) + 1) : 0;
        if (ready < 0 && errno == EINTR)
            continue;
        if (ready == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: the DICOM parser made no progress for %d s and was ended", file,
                            process->seconds);
        const ssize_t n = ready < 0 ? -1 : read(process->pipe, at, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot read from the DICOM parser: %s", file, strerror(errno));
        if (n == 0)
            return explain_end(process, file, err);
        at += n;
        size -= (size_t)n;
    }
    return OST_OK;
}

ost_status ost_dicom_process_next(ost_dicom_process *process, const char *file, size_t pixel_bytes,
                                  ost_dicom_message *out, ost_error *err)
{
    const size_t sizes[OST_DICOM_TYPE_COUNT] = {
        [OST_DICOM_FRAME] = sizeof(ost_dicom_record),
        [OST_DICOM_FILE] = sizeof(uint32_t),
        [OST_DICOM_PIXELS] = pixel_bytes,
        [OST_DICOM_END] = 0,
    };
    process->deadline = ost_clock_ns() + process->seconds * INT64_C(1000000000);
    ost_status status = ost_dicom_process_read(process, file, out, sizeof *out, err);
    if (status != OST_OK)
        return status;
    if (out->type >= OST_DICOM_TYPE_COUNT)
        return ost_dicom_process_nonsense(file, "unknown type", err);
    if (out->size != sizes[out->type])
        return ost_dicom_process_nonsense(file, "wrong size", err);
    return OST_OK;
}
