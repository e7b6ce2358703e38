/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that a tick allocates no memory and makes no system calls except those that read clocks. The tested tick
 * includes the loop, the operation, the step of the world and the recorder. During the ticks, the tool is in
 * contact with the bone and enters one chunk after another.
 *
 * malloc and related functions are replaced by functions that count calls while a tick runs. Without glibc, or with a
 * sanitizer, the test is skipped. System calls are detected by a Linux filter (seccomp) in a separate process, which
 * ends at the first call that is not allowed. Covers: REQ-SERVO
 */
#include "ref/scene.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined __linux__ && defined __x86_64__
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#define FILTERING 1
#else
#define FILTERING 0
#endif

#include <osteon/operation.h>

#include "io/io_scratch.h"

#if defined __GLIBC__ && !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
#define COUNTING 1
#else
#define COUNTING 0
#endif
#if defined __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#undef COUNTING
#define COUNTING 0
#endif
#endif

/* These variables are volatile, because compilers assume that malloc does not access them. */
static _Thread_local volatile bool watching;
static _Thread_local volatile uint64_t calls;

#if COUNTING
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size)
{
    calls += watching;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    calls += watching;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    calls += watching;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    calls += watching;
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    calls += watching;
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : ENOMEM;
}
#endif

static bool watched_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    watching = true;
    return ost_operation_tick(operation, sample, wrench);
}

static void watched_done(void *operation, uint64_t number, uint32_t exec_ns)
{
    ost_operation_done(operation, number, exec_ns);
    watching = false;
}

/* A scene in which a tool moves into the bone, across chunk borders, and rotates slightly. */
enum { TICKS = 400 };
typedef struct scene {
    ost_bone *bone;
    ost_tool *tool;
    ost_world *world;
    ost_force *force;
    ost_path path;
    char *folder;
    ost_session_header *header;
    ost_recorder *recorder;
    ost_haptic *device;
    ost_operation *operation;
} scene;

static scene make_scene(ost_backend *backend)
{
    ost_error err = {0};
    scene s = {.folder = scratch_folder()};
    test_rng rng = {1};
    const ost_geometry g = cubic_geometry(80, 80, 80, 500 * UM, (ost_pm3){0, 0, 0});
    int16_t *voxels = random_densities(&rng, &g, 6);
    s.bone = bone_of(backend, &g, 32, voxels);
    free(voxels);
    s.tool = solid_tool(backend, (ost_tool_geometry){{40, 40, 20}, 500 * UM, {-10000 * UM, -10000 * UM, 0}},
                        OST_TOOL_CUTTING);
    assert_ok(ost_world_create(s.bone, NULL, &s.world, &err));
    assert_ok(ost_world_add_tool(s.world, "tool", s.tool, NULL, &err));
    assert_ok(ost_path_init(&s.path, TICKS, &err));
    for (size_t i = 0; i < s.path.count; i++)
        s.path.ticks[i] = (ost_tick){.rpm = OST_RPM_ON,
                                     .pose = {.t = {(int64_t)(10000 + 50 * i) * UM, 20000 * UM, 15000 * UM},
                                              .qw = OST_Q30_ONE,
                                              .qz = (int32_t)i * 20000}};
    assert_ok(ost_force_create(s.bone, NULL, &s.force, &err));
    assert_ok(ost_force_add_tool(s.force, s.tool, &err));
    return s;
}

/* Starts the recorder and its thread, the device and the operation. */
static void begin(scene *s)
{
    ost_error err = {0};
    char name[4200];
    snprintf(name, sizeof name, "%s/m.session", s->folder);
    assert_ok(ost_session_header_create(&s->header, &err));
    assert_ok(ost_recorder_open(name, s->header, NULL, &s->recorder, &err));
    assert_ok(ost_haptic_open("sim", &(ost_haptic_setup){.path = &s->path}, &s->device, &err));
    assert_ok(ost_operation_create(s->world, &(ost_operation_options){.recorder = s->recorder, .force = s->force},
                                   &s->operation, &err));
}

static void free_scene(scene *s)
{
    ost_error err = {0};
    ost_operation_free(s->operation);
    ost_force_free(s->force);
    ost_haptic_close(s->device);
    assert_ok(ost_recorder_close(s->recorder, NULL, &err));
    ost_session_header_free(s->header);
    ost_path_free(&s->path);
    ost_world_free(s->world);
    ost_tool_free(s->tool);
    ost_bone_free(s->bone);
    scratch_remove(s->folder);
}

static ost_status run(scene *s, ost_servo_tick *tick, ost_servo_done *done, ost_error *err)
{
    static ost_servo_report report;
    const ost_servo_options how = {.ticks = TICKS, .no_clock = true, .no_realtime = true};
    return ost_servo_run(s->device, &how, tick, done, s->operation, &report, err);
}

static void tick_allocates_nothing(void **state)
{
    /* Only the cpu backend is tested: the reference allocates memory, and the driver of an OpenCL device may do so. */
    if (!COUNTING || strncmp(ost_backend_name(*state), "cpu", 3) != 0)
        skip();
    ost_error err = {0};
    scene s = make_scene(*state);
    begin(&s);
    calls = 0;
    assert_ok(run(&s, watched_tick, watched_done, &err));
    const uint64_t counted = calls;
    ost_operation_report done;
    ost_operation_report_get(s.operation, &done);
    assert_int_equal(done.steps, TICKS);
    ost_world_totals totals;
    ost_world_totals_get(s.world, &totals);
    assert_true(totals.removed_voxels > 10000 && done.touching_ticks > 300);
    assert_int_equal(counted, 0);
    /* Checks that allocations are counted. */
    watching = true;
    void *volatile some = calloc(1, 100);
    watching = false;
    free(some);
    assert_int_equal(calls, counted + 1);
    free_scene(&s);
}

#if FILTERING
enum { REFUSED = 7, NO_FILTER = 8, ENDED_EARLY = 9 };

static void print_and_end(int number, siginfo_t *info, void *context)
{
    (void)number, (void)context;
    char text[] = "a tick makes call 000 of the system\n";
    for (int i = 0, left = info->si_syscall; i < 3; i++, left /= 10)
        text[20 - i] = (char)('0' + left % 10);
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
    _exit(REFUSED);
}

/*
 * Installs a filter that allows only calls that read clocks or processor usage, and calls that are needed to report a
 * refused call.
 */
static bool begin_filter(void)
{
    struct sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_clock_gettime, 5, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_getrusage, 4, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_write, 3, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_exit_group, 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_rt_sigreturn, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog program = {sizeof rules / sizeof *rules, rules};
    const struct sigaction answer = {.sa_sigaction = print_and_end, .sa_flags = SA_SIGINFO};
    return sigaction(SIGSYS, &answer, NULL) == 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

static bool filtered_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    if (sample->number == 0 && !begin_filter())
        _exit(NO_FILTER);
    return ost_operation_tick(operation, sample, wrench);
}

static void filtered_done(void *operation, uint64_t number, uint32_t exec_ns)
{
    ost_operation_done(operation, number, exec_ns);
    if (number == TICKS - 1)
        _exit(0);
}

static bool calling_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    const bool go_on = filtered_tick(operation, sample, wrench);
    return getppid() > 0 && go_on;
}

/* Runs the ticks in a new process under the filter and returns its exit status. */
static int status_of(scene *s, ost_servo_tick *tick)
{
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        begin(s);
        run(s, tick, filtered_done, NULL);
        _exit(ENDED_EARLY);
    }
    int how;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_true(WIFEXITED(how));
    return WEXITSTATUS(how);
}
#endif

static void tick_makes_no_system_calls_except_clocks(void **state)
{
#if FILTERING
    if (!COUNTING || getenv("OST_UNDER_VALGRIND") || strncmp(ost_backend_name(*state), "cpu", 3) != 0)
        skip();
    scene s = make_scene(*state);
    const int status = status_of(&s, filtered_tick);
    if (status == NO_FILTER)
        skip();
    assert_int_equal(status, 0);
    /* Checks that the filter detects a system call. */
    assert_int_equal(status_of(&s, calling_tick), REFUSED);
    begin(&s);
    free_scene(&s);
#else
    (void)state;
    skip();
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tick_allocates_nothing),
        cmocka_unit_test(tick_makes_no_system_calls_except_clocks),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
