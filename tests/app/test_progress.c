/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the progress line. The tested command generates a phantom of 36 million voxels, which takes many seconds on any
 * machine. Its standard error is a pseudo-terminal or a pipe. The test ends the command when the progress line appears,
 * or when the time limit for this line has passed.
 * Covers: REQ-PROGRESS
 */
#include "harness.h"

#include <fcntl.h>
#include <poll.h>
#include <regex.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { OUTPUT = 1 << 16, LIMIT_MS = 60000, SILENT_MS = 3000 };

static char folder[] = "/tmp/osteon-progress-XXXXXX";
static char program[4096], out[sizeof folder + 16];

typedef struct child {
    pid_t pid;
    int fd; /* read end of the command's standard error */
    char text[OUTPUT];
    size_t size;
} child;

/* Returns both ends of a pseudo-terminal, or skips the test if there is none. */
static int open_terminal(int *end)
{
    const int fd = posix_openpt(O_RDWR | O_NOCTTY);
    if (fd < 0 || grantpt(fd) != 0 || unlockpt(fd) != 0 || (*end = open(ptsname(fd), O_RDWR | O_NOCTTY)) < 0) {
        if (fd >= 0)
            close(fd);
        skip();
    }
    return fd;
}

static void start(child *c, bool terminal, char *const argv[])
{
    int ends[2];
    c->size = 0;
    if (terminal)
        ends[0] = open_terminal(&ends[1]);
    else
        assert_int_equal(pipe(ends), 0);
    c->pid = fork();
    assert_true(c->pid >= 0);
    if (c->pid == 0) {
        dup2(ends[1], STDERR_FILENO);
        close(ends[0]);
        close(ends[1]);
        execv(program, argv);
        _exit(127);
    }
    close(ends[1]);
    c->fd = ends[0];
}

/* Reads the output until it contains the pattern, the time limit is reached or the output ends. pattern may be NULL. */
static bool read_until(child *c, const char *pattern, int limit_ms)
{
    regex_t regex;
    struct timespec first, now;
    assert_int_equal(regcomp(&regex, pattern ? pattern : "^$", REG_EXTENDED | REG_NOSUB), 0);
    clock_gettime(CLOCK_MONOTONIC, &first);
    bool found = false, open = true;
    while (!found && open) {
        clock_gettime(CLOCK_MONOTONIC, &now);
        const int spent = (int)((now.tv_sec - first.tv_sec) * 1000 + (now.tv_nsec - first.tv_nsec) / 1000000);
        struct pollfd poll_fd = {.fd = c->fd, .events = POLLIN};
        if (spent >= limit_ms)
            break;
        if (poll(&poll_fd, 1, limit_ms - spent) <= 0)
            continue;
        const ssize_t n = read(c->fd, c->text + c->size, OUTPUT - 1 - c->size);
        open = n > 0; /* at the end of a pseudo-terminal's output, read() fails with EIO */
        c->size += n > 0 ? (size_t)n : 0;
        c->text[c->size] = '\0';
        found = pattern && regexec(&regex, c->text, 0, NULL, 0) == 0;
    }
    regfree(&regex);
    return found;
}

/* Ends the command. Returns true if the command was still running. */
static bool stop(child *c)
{
    int how;
    kill(c->pid, SIGTERM);
    assert_int_equal(waitpid(c->pid, &how, 0), c->pid);
    close(c->fd);
    return WIFSIGNALED(how) && WTERMSIG(how) == SIGTERM;
}

static char *const slow[] = {program, (char[]){"phantom"}, (char[]){"trabecular2"}, (char[]){"--out"}, out, NULL};
static char *const quiet[] = {program, (char[]){"phantom"}, (char[]){"trabecular2"}, (char[]){"--out"}, out,
                              (char[]){"--quiet"}, NULL};

/* The line must contain the percentage and the remaining time, and must appear while the command is running. */
static void test_on_a_terminal(void **state)
{
    (void)state;
    static child c;
    start(&c, true, slow);
    const bool seen = read_until(&c, "generating +[0-9]+ %, [0-9]+ s left", LIMIT_MS);
    const bool running = stop(&c);
    if (!seen)
        fail_msg("no progress line on standard error, which contains: %.300s", c.text);
    assert_true(running);
}

/* Without a terminal, or with --quiet, the line must not be printed. The test waits as long as the line would take to
   appear on a terminal. */
static void test_without_progress_line(void **state)
{
    (void)state;
    static child c;
    for (int on_terminal = 0; on_terminal < 2; on_terminal++) {
        start(&c, on_terminal, on_terminal ? quiet : slow);
        assert_false(read_until(&c, NULL, SILENT_MS));
        stop(&c);
        assert_int_equal(c.size, 0);
    }
}

static int set_up(void **state)
{
    (void)state;
    const char *given = getenv("OSTEON");
    if (!mkdtemp(folder))
        return -1;
    snprintf(program, sizeof program, "%s", given ? given : "./osteon");
    snprintf(out, sizeof out, "%s/ct.nrrd", folder);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    unlink(out);
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_on_a_terminal),
        cmocka_unit_test(test_without_progress_line),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
