/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The program walk runs a command repeatedly. In each run, a different call of the command fails.
 *
 *   walk [--kind alloc|open|read] [--runs N] [--seed S] [--only K] [--in TEXT] [--loose TEXT[:TEXT...]]
 *        [--loose-output] LIBRARY COMMAND ARGUMENT...
 *
 * The first run is without a fault, in an empty folder. It gives the number of calls, the expected exit status (0 or
 * 1), the expected files and the expected standard output. Because the output contains times, only its number of lines
 * and its last two bytes are compared (with --loose-output only the last byte). The command then runs again for N
 * values of K (for all values if N is 0). In each of these runs the folder is empty at first and the K-th call fails
 * (inject.c). Each run must satisfy:
 *
 *   - the command ends by itself, either with the expected exit status or with status 2 or 3;
 *   - if the exit status is the expected one, the folder contains exactly the expected files, with
 *     the expected bytes, and standard output is as expected;
 *   - if the exit status is 2 or 3, each expected file is absent or has the expected bytes, there is
 *     no other file, and standard error contains a line that begins with "osteon".
 *
 * Files whose names contain a TEXT of --loose may have other bytes, because they contain times or are recorded while
 * the operation runs. With --in, the K-th call fails only in the processes that OST_FAIL_IN=TEXT selects. Without --in,
 * it fails in each process that the command starts.
 *
 * A failure is reported as one line with K; --only K repeats this run and prints the stack of the failed call. The exit
 * status is 0 without a failure, 1 after a failure, and 2 if the command cannot be tested in this way.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <inttypes.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { TEXT = 4096, FILES = 256, LIMIT_S = 120, SHOWN = 20 };

typedef struct file_state {
    char *name;
    uint64_t size, sum; /* FNV-1a hash of the bytes */
} file_state;

typedef struct folder_state {
    file_state file[FILES];
    int count;
} folder_state;

static const char *kind = "alloc", *library;
static char **command;
static const char *loose, *within;
static bool loose_output;
static char scratch[] = "/tmp/osteon-walk-XXXXXX", work[64], out_path[64], err_path[64], report_path[64];

static void die(const char *what)
{
    perror(what);
    exit(2);
}

/* ------------------------------------------------------------- the folder */

static folder_state *collecting;

static void sum_file(const char *path, file_state *state)
{
    unsigned char block[1 << 14];
    state->sum = UINT64_C(14695981039346656037);
    state->size = 0;
    FILE *in = fopen(path, "rb");
    if (!in)
        die(path);
    for (size_t n; (n = fread(block, 1, sizeof block, in)) > 0; state->size += n)
        for (size_t i = 0; i < n; i++)
            state->sum = (state->sum ^ block[i]) * UINT64_C(1099511628211);
    fclose(in);
}

static int collect_one(const char *path, const struct stat *st, int type, struct FTW *at)
{
    (void)st;
    if (at->level == 0 || collecting->count == FILES)
        return 0;
    file_state *state = &collecting->file[collecting->count++];
    state->name = strdup(path);
    state->size = state->sum = 0;
    if (type == FTW_F)
        sum_file(path, state);
    return 0;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const file_state *)a)->name, ((const file_state *)b)->name);
}

static void collect(folder_state *state)
{
    state->count = 0;
    collecting = state;
    if (nftw(work, collect_one, 16, FTW_PHYS) != 0)
        die(work);
    qsort(state->file, (size_t)state->count, sizeof state->file[0], by_name);
}

static void forget(folder_state *state)
{
    for (int i = 0; i < state->count; i++)
        free(state->file[i].name);
    state->count = 0;
}

static int remove_one(const char *path, const struct stat *st, int type, struct FTW *at)
{
    (void)st, (void)type;
    return at->level == 0 ? 0 : remove(path);
}

static void empty_folder(const char *folder)
{
    nftw(folder, remove_one, 16, FTW_PHYS | FTW_DEPTH);
}

/* ---------------------------------------------------------------- one run */

/* Runs the command and makes the K-th call fail (none if K is 0). Returns the wait status. */
static int run(long at, bool trace)
{
    fflush(stdout);
    remove(report_path);
    const pid_t child = fork();
    if (child < 0)
        die("fork");
    if (child == 0) {
        char number[24], variable[32];
        snprintf(number, sizeof number, "%ld", at);
        const bool allocation = strcmp(kind, "alloc") == 0, opening = strcmp(kind, "open") == 0;
        snprintf(variable, sizeof variable, "OST_FAIL_%s", allocation ? "ALLOC" : opening ? "OPEN" : "READ");
        setenv(variable, number, 1);
        setenv("OST_FAIL_REPORT", report_path, 1);
        if (within)
            setenv("OST_FAIL_IN", within, 1);
        setenv("LD_PRELOAD", library, 1);
        if (trace)
            setenv("OST_FAIL_TRACE", "1", 1);
        if (chdir(work) != 0 || !freopen("/dev/null", "r", stdin) || !freopen(out_path, "w", stdout) ||
            !freopen(err_path, "w", stderr))
            _exit(125);
        alarm(LIMIT_S);
        execv(command[0], command);
        _exit(125);
    }
    int status;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            die("waitpid");
    return status;
}

/* Returns the number of calls in the process that made the most calls, or -1 if there is no report. */
static long counted(void)
{
    char word[16];
    long count, found = -1;
    FILE *in = fopen(report_path, "r");
    if (!in)
        return -1;
    while (fscanf(in, "%15s %ld", word, &count) == 2)
        if (strcmp(word, kind) == 0 && count > found)
            found = count;
    fclose(in);
    return found;
}

/* Copies the first line of standard error that begins with "osteon" and is not a warning, and returns true. If there is
   no such line, copies the last line and returns false. */
static bool message(char text[TEXT])
{
    char line[TEXT];
    bool found = false;
    text[0] = '\0';
    FILE *in = fopen(err_path, "r");
    if (!in)
        return false;
    while (!found && fgets(line, sizeof line, in)) {
        line[strcspn(line, "\n")] = '\0';
        found = strncmp(line, "osteon", 6) == 0 && strlen(line) > 10 && !strstr(line, "warning:");
        snprintf(text, TEXT, "%s", line);
    }
    fclose(in);
    return found;
}

/* Returns true if the name of the file contains one of the strings given with --loose. */
static bool is_loose(const char *name)
{
    char text[TEXT];
    for (const char *p = loose; p && *p;) {
        const size_t n = strcspn(p, ":");
        snprintf(text, sizeof text, "%.*s", (int)n, p);
        if (n > 0 && strstr(name, text))
            return true;
        p += n + (p[n] == ':');
    }
    return false;
}

/* Compares the folder with the expected files. If `complete` is false, some of them may be absent. Returns a
   description of the first difference, or NULL. */
static const char *compare(const folder_state *expected, bool complete, char text[TEXT])
{
    folder_state now = {.count = 0};
    int n = 0, e = 0;
    collect(&now);
    text[0] = '\0';
    while (!text[0] && (n < now.count || e < expected->count)) {
        const int order = n >= now.count ? 1 : e >= expected->count ? -1 : by_name(&now.file[n], &expected->file[e]);
        const file_state *a = &now.file[n], *b = &expected->file[e];
        if (order < 0)
            snprintf(text, TEXT, "%.1000s exists, but must not exist", a->name);
        else if (order > 0 && complete)
            snprintf(text, TEXT, "%.1000s is missing", b->name);
        else if (order == 0 && !is_loose(a->name) && (a->sum != b->sum || a->size != b->size))
            snprintf(text, TEXT, "%.1000s differs from the expected file (%" PRIu64 " bytes, expected %" PRIu64 ")",
                     a->name, a->size, b->size);
        n += order <= 0;
        e += order >= 0;
    }
    forget(&now);
    return text[0] ? text : NULL;
}

/* ------------------------------------------------------- standard output */

typedef struct output {
    long lines;
    char last[2];
} output;

static void take_output(output *o)
{
    *o = (output){.lines = 0};
    FILE *in = fopen(out_path, "rb");
    if (!in)
        die(out_path);
    for (int c; (c = getc(in)) != EOF;) {
        o->lines += c == '\n';
        o->last[0] = o->last[1];
        o->last[1] = (char)c;
    }
    if (loose_output) {
        o->lines = 0;
        o->last[0] = 0;
    }
    fclose(in);
}

/* Checks a run with a fault. Returns a description of the error, or NULL. */
static const char *judge(int status, int expected_status, const folder_state *expected, const output *printed,
                         char text[TEXT])
{
    char text_out[TEXT];
    const bool has_message = message(text_out);
    if (!WIFEXITED(status)) {
        snprintf(text, TEXT, "ended by signal %d: %.300s", WTERMSIG(status), text_out);
        return text;
    }
    const int code = WEXITSTATUS(status);
    if (code == expected_status) {
        output now;
        take_output(&now);
        if (now.lines != printed->lines || memcmp(now.last, printed->last, sizeof now.last) != 0) {
            snprintf(text, TEXT, "status %d, but standard output differs (%ld lines, expected %ld)", code, now.lines,
                     printed->lines);
            return text;
        }
        return compare(expected, true, text);
    }
    if (code != 2 && code != 3) {
        snprintf(text, TEXT, "status %d: %.300s", code, text_out);
        return text;
    }
    if (!has_message) {
        snprintf(text, TEXT, "status %d without a message: %.300s", code, text_out);
        return text;
    }
    return compare(expected, false, text);
}

/* ------------------------------------------------------------------- main */

static uint64_t state;

static uint64_t next_random(void)
{
    state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = state;
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static void remove_scratch(void)
{
    empty_folder(scratch);
    rmdir(scratch);
}

int main(int argc, char **argv)
{
    long runs = 0, only = 0;
    int i = 1;
    for (; i < argc && strncmp(argv[i], "--", 2) == 0; i++) {
        if (i + 1 < argc && strcmp(argv[i], "--loose") == 0)
            loose = argv[++i];
        else if (strcmp(argv[i], "--loose-output") == 0)
            loose_output = true;
        else if (i + 1 < argc && strcmp(argv[i], "--in") == 0)
            within = argv[++i];
        else if (i + 1 < argc && strcmp(argv[i], "--kind") == 0)
            kind = argv[++i];
        else if (i + 1 < argc && strcmp(argv[i], "--runs") == 0)
            runs = atol(argv[++i]);
        else if (i + 1 < argc && strcmp(argv[i], "--seed") == 0)
            state = strtoull(argv[++i], NULL, 10);
        else if (i + 1 < argc && strcmp(argv[i], "--only") == 0)
            only = atol(argv[++i]);
        else
            return fprintf(stderr, "walk: unknown option %s\n", argv[i]), 2;
    }
    if (argc - i < 2)
        return fprintf(stderr, "walk: LIBRARY COMMAND ARGUMENT... are missing\n"), 2;
    library = argv[i];
    command = argv + i + 1;
    if (!mkdtemp(scratch))
        die(scratch);
    atexit(remove_scratch);
    snprintf(work, sizeof work, "%s/work", scratch);
    snprintf(out_path, sizeof out_path, "%s/out", scratch);
    snprintf(err_path, sizeof err_path, "%s/err", scratch);
    snprintf(report_path, sizeof report_path, "%s/report", scratch);
    if (mkdir(work, 0777) != 0)
        die(work);

    char text[TEXT];
    folder_state expected = {.count = 0};
    const int clean = run(0, false);
    const long calls = counted();
    if (!WIFEXITED(clean) || WEXITSTATUS(clean) > 1 || calls < 1) {
        message(text);
        fprintf(stderr, "walk: the run without a fault has the wait status %d and %ld calls: %s\n", clean, calls, text);
        return 2;
    }
    output printed;
    take_output(&printed);
    collect(&expected);
    empty_folder(work);

    int failures = 0;
    const bool all = runs == 0 || runs >= calls;
    const long count = only ? 1 : all ? calls : runs;
    for (long r = 0; r < count; r++) {
        /* The calls are divided into `runs` equal parts; one value of each part is chosen at random. */
        const long at = only  ? only
                        : all ? r + 1
                              : (long)((double)calls * (double)r / (double)runs) + 1 +
                                    (long)(next_random() % (uint64_t)(calls / runs));
        const int status = run(at, only != 0);
        const char *wrong = judge(status, WEXITSTATUS(clean), &expected, &printed, text);
        if (wrong && ++failures <= SHOWN)
            printf("FAIL: %s %ld of %ld: %s\n", kind, at, calls, wrong);
        if (only) {
            char line[TEXT];
            FILE *err = fopen(err_path, "r");
            while (err && fgets(line, sizeof line, err))
                fputs(line, stdout);
            if (err)
                fclose(err);
            printf("wait status %d\n", status);
        }
        empty_folder(work);
    }
    forget(&expected);
    printf("# runs with a failed call (%s): %ld of %ld calls, %d failures\n", kind, count, calls, failures);
    return failures > 0;
}
