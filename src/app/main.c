/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The main program, osteon. Like git, it has one verb per task.
 *
 *   osteon VERB ... -> verbs[] -> cmd_VERB -> status -> one line, exit status
 *
 * Exit status: 0 done or equal, 1 a check failed or grids differ, 2 incorrect use or invalid input,
 * 3 not available here. A failure to write standard output, for example on a full disk, is also an
 * error. If the reader closed the pipe, the process ends silently.
 */
#include "app/common/app.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/common/all_cores.h"
#include "app/common/options.h"
#include "app/common/progress.h"
#include "app/common/print.h"
#include "io/outfile.h"
#include "validation/signal_cleanup.h"
#include "validation/worker.h"

static const app_verb verbs[] = {
    {"phantom", "generate a CT: a scapula, a glenoid, trabecular bone or foam", cmd_phantom},
    {"tool", "generate a cutting tool: a reamer, a peg drill or a burr", cmd_tool},
    {"import", "convert a CT into a bone of cubic voxels", cmd_import},
    {"segment", "divide a CT into bones, as a label map", cmd_segment},
    {"voxelize", "convert a mesh into a tool grid", cmd_voxelize},
    {"ream", "move tools along paths and remove bone", cmd_ream},
    {"replay", "repeat a recorded session on any backend and compare", cmd_replay},
    {"sim", "run the simulator: a device moves the tool at 1 kHz", cmd_sim},
    {"bridge", "connect a device of this machine to a simulation on another", cmd_bridge},
    {"diff", "compare two grids and show the differences", cmd_diff},
    {"render", "draw a bone and a tool without a display", cmd_render},
    {"export", "write a bone as a volume, a surface or a picture", cmd_export},
    {"info", "describe a file", cmd_info},
    {"validate", "compare backends stage by stage and write evidence", cmd_validate},
    {"compare", "compare another program's grids with the reference's", cmd_compare},
    {"verify", "check a bundle of evidence offline", cmd_verify},
    {"sign", "sign a bundle of evidence", cmd_sign},
    {"bench", "measure against baselines in the same run", cmd_bench},
    {"reproduce", "reproduce the tables and figures of the thesis", cmd_reproduce},
    {"devices", "list what works on this machine, and why the rest does not", cmd_devices},
};

enum { VERB_COUNT = sizeof verbs / sizeof verbs[0] };

static void print_help(void)
{
    puts("usage: osteon VERB [arguments]\n\n"
         "Simulates the removal of bone from a CT with surgical tools. Results are bit-identical on all\n"
         "backends.\n\n"
         "verbs");
    for (int i = 0; i < VERB_COUNT; i++)
        print_line_to(stdout, "  %-10s %s", verbs[i].name, verbs[i].summary);
    puts("\n"
         "osteon VERB --help shows a verb's options and an example; osteon --version the\n"
         "version.  Every verb takes --json: one JSON object on standard output.\n\n"
         "exit status\n"
         "  0 done, or equal   1 a check failed, or grids differ\n"
         "  2 wrong usage or bad input   3 not available here\n\n"
         "example: a glenoid, a peg hole, then reaming\n"
         "  osteon ream --bone builtin:glenoid --out reamed.nrrd \\\n"
         "    --tool builtin:peg --path builtin:peg-hole \\\n"
         "    --tool builtin:reamer --path builtin:glenoid-ream");
}

static ost_status no_verb(const char *word, ost_error *err)
{
    const char *names[VERB_COUNT];
    for (int i = 0; i < VERB_COUNT; i++)
        names[i] = verbs[i].name;
    static const char *const own[] = {"--help", "--version"};
    if (word[0] == '-' && nearest_name(word, own, 2))
        return ost_fail(err, OST_ERR_USAGE,
                        "'%s' is not an option of osteon itself; did you mean %s? See osteon --help", word,
                        nearest_name(word, own, 2));
    if (word[0] == '-')
        return ost_fail(err, OST_ERR_USAGE, "'%s' is not an option of osteon itself; see osteon --help", word);
    const char *near = nearest_name(word, names, VERB_COUNT);
    if (near)
        return ost_fail(err, OST_ERR_USAGE, "'%s' is not a verb of osteon; did you mean %s? See osteon --help", word,
                        near);
    return ost_fail(err, OST_ERR_USAGE, "'%s' is not a verb of osteon; see osteon --help", word);
}

/*
 * Opens /dev/null for each standard stream that is closed. If the descriptor of a closed stream stayed free, the next
 * opened file would get this descriptor and receive the stream's output.
 */
static void open_standard_streams(void)
{
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF) {
            /* A closed input is opened for writing and a closed output for reading, so that any use of the stream still
               fails. */
            if (open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY) != fd)
                _exit(2);
        }
}

static void on_end_signal(int number)
{
    ost_outfile_unlink_pending();
    signal_cleanup_end();
    signal(number, SIG_DFL);
    raise(number);
}

static void catch_signals(void)
{
    static const int ending[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = on_end_signal};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof ending / sizeof ending[0]; i++) {
        struct sigaction old;
        /* A signal that was ignored at the start, for example by nohup, remains ignored. */
        if (sigaction(ending[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN)
            sigaction(ending[i], &action, NULL);
    }
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

/*
 * A library may end the process itself. The OpenMP runtime, for example, calls exit(1) if there is no memory for a
 * thread's stack. An exit status of 1 would mean that grids differ, so the handler below changes the status.
 */
static const app_state *within_verb; /* the state of the running verb, for exit handlers; NULL between verbs */

static void on_exit_within_verb(void)
{
    if (!within_verb)
        return;
    ost_outfile_unlink_pending();
    signal_cleanup_end();
    static const char text[] =
        "osteon: a library ended the command before it was complete; the reason is in the message above\n";
    ssize_t ignored = write(STDERR_FILENO, text, sizeof text - 1);
    (void)ignored;
    _exit(within_verb->worker ? WORKER_EXIT_RESOURCES : 2);
}

/*
 * If memory is exhausted, the functions of jansson return NULL or -1. They are called in hundreds of places, and a
 * caller must not continue with an incomplete object. Therefore the allocator ends the command.
 */
static void *json_memory(size_t size)
{
    void *p = malloc(size ? size : 1);
    if (p)
        return p;
    ost_outfile_unlink_pending();
    signal_cleanup_end();
    static const char text[] = "osteon: no memory for a JSON object; nothing more was written\n";
    ssize_t ignored = write(STDERR_FILENO, text, sizeof text - 1);
    (void)ignored;
    _exit(within_verb && within_verb->worker ? WORKER_EXIT_RESOURCES : 2);
}

/* Flushes standard output. If the reader closed the pipe, SIGPIPE terminates the process silently, as usual. */
static ost_status finish_output(ost_error *err)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout))
        return OST_OK;
    if (errno == EPIPE) {
        signal(SIGPIPE, SIG_DFL);
        raise(SIGPIPE);
    }
    return ost_fail(err, OST_ERR_IO, "standard output: cannot write: %s", errno ? strerror(errno) : "write failed");
}

static int fail(const char *verb_name, const ost_error *err, ost_status status)
{
    progress_end();
    const char *text = err->text[0] ? err->text : ost_status_text(status);
    print_line_to(stderr, "osteon%s%s: %s", verb_name ? " " : "", verb_name ? verb_name : "", text);
    return ost_status_exit(status);
}

/*
 * Returns true if a campaign started this process. The function searches argv itself, because parsing the options may
 * fail if memory is exhausted.
 */
static bool is_worker(int argc, char **argv)
{
    bool worker_given = false, trace_given = false;
    for (int i = 1; i < argc; i++) {
        worker_given |= strcmp(argv[i], "--worker") == 0;
        trace_given |= strcmp(argv[i], "--trace") == 0;
    }
    return worker_given && trace_given;
}

static int run_verb(const app_verb *which, int argc, char **argv)
{
    ost_error err = {0};
    app_state app = {.verb = which->name, .backend = "cpu", .worker = is_worker(argc, argv)};
    within_verb = &app;
    app.result = json_object();
    ost_status status = which->run(&app, argc, argv, &err);
    within_verb = NULL;
    progress_end();
    const bool failed = status != OST_OK && status != OST_ERR_DIFFER;
    bool verdict = !failed || app.answered;
    if (verdict && app.json) {
        /* With 15 digits, lengths up to 8 m are exact to one picometre, and 0.47 is printed as 0.47. */
        char *text = json_dumps(app.result, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
        if (text)
            print_json(text);
        else
            status = ost_fail(&err, OST_ERR_INTERNAL, "the result cannot be written as JSON");
        free(text);
        verdict = text;
    }
    json_decref(app.result);
    json_decref(app.warnings);
    if (verdict) {
        ost_error unwritten = {0};
        if (finish_output(&unwritten) != OST_OK)
            return fail(which->name, &unwritten, OST_ERR_IO);
        if (!failed)
            return ost_status_exit(status);
    }
    const int exit_status = fail(which->name, &err, status);
    return app.worker && (status == OST_ERR_MEMORY || status == OST_ERR_IO) ? WORKER_EXIT_RESOURCES : exit_status;
}

int main(int argc, char **argv)
{
    open_standard_streams();
    catch_signals();
    all_cores_begin();
    atexit(on_exit_within_verb);
    json_set_alloc_funcs(json_memory, free);
    ost_error err = {0};
    if (argc < 2) {
        ost_fail(&err, OST_ERR_USAGE, "no verb given; see osteon --help");
        return fail(NULL, &err, OST_ERR_USAGE);
    }
    const char *word = argv[1];
    for (int i = 0; i < VERB_COUNT; i++)
        if (strcmp(word, verbs[i].name) == 0)
            return run_verb(&verbs[i], argc - 1, argv + 1);
    if (strcmp(word, "help") == 0 && argc > 2) {
        char *swapped[] = {argv[2], (char[]){"--help"}, NULL};
        for (int i = 0; i < VERB_COUNT; i++)
            if (strcmp(argv[2], verbs[i].name) == 0)
                return run_verb(&verbs[i], 2, swapped);
        word = argv[2];
    } else if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0) {
        print_help();
        return finish_output(&err) == OST_OK ? 0 : fail(NULL, &err, OST_ERR_IO);
    } else if (strcmp(word, "--complete") == 0) {
        for (int i = 0; i < VERB_COUNT; i++)
            printf("%s\t%s\n", verbs[i].name, verbs[i].summary);
        return finish_output(&err) == OST_OK ? 0 : fail(NULL, &err, OST_ERR_IO);
    } else if (strcmp(word, "--version") == 0) {
        print_line_to(stdout, "osteon %s, arithmetic version %d", ost_version(), OST_ARITHMETIC_VERSION);
        return finish_output(&err) == OST_OK ? 0 : fail(NULL, &err, OST_ERR_IO);
    }
    no_verb(word, &err);
    return fail(NULL, &err, OST_ERR_USAGE);
}
