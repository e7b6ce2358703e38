/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Calls a kernel and checks the following processor state, which the kernel must leave
 * unchanged. The general registers are not checked, because the compiler preserves them.
 *
 *   x86-64    MXCSR and the x87 control word. After the call, no x87 register
 *             may be in use (MMX code would leave registers in use), and the
 *             upper halves of the vector registers must be zero, because
 *             baseline code is slow otherwise. The upper halves are checked
 *             only if the compiler clears them, which gcc does from -O2 on.
 *   AArch64   FPCR
 *
 * The exception flags (inexact and so on) may change.
 */
#include "simd/call.h"

#include <setjmp.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>

#include "simd/guard.h"

/* -------------------------------------------------------- processor state */

#if defined __x86_64__

#include <immintrin.h>

typedef struct machine_state {
    uint32_t mxcsr;
    uint16_t control, tags;
    bool upper;
} machine_state;

/* Returns true if the upper half of any vector register is not zero. */
static bool upper_in_use(void)
{
    static uint64_t registers[16][4];
    __asm__ volatile("vmovups %%ymm0, (%0)\n\t"
                     "vmovups %%ymm1, 32(%0)\n\t"
                     "vmovups %%ymm2, 64(%0)\n\t"
                     "vmovups %%ymm3, 96(%0)\n\t"
                     "vmovups %%ymm4, 128(%0)\n\t"
                     "vmovups %%ymm5, 160(%0)\n\t"
                     "vmovups %%ymm6, 192(%0)\n\t"
                     "vmovups %%ymm7, 224(%0)\n\t"
                     "vmovups %%ymm8, 256(%0)\n\t"
                     "vmovups %%ymm9, 288(%0)\n\t"
                     "vmovups %%ymm10, 320(%0)\n\t"
                     "vmovups %%ymm11, 352(%0)\n\t"
                     "vmovups %%ymm12, 384(%0)\n\t"
                     "vmovups %%ymm13, 416(%0)\n\t"
                     "vmovups %%ymm14, 448(%0)\n\t"
                     "vmovups %%ymm15, 480(%0)"
                     :
                     : "r"(registers)
                     : "memory");
    uint64_t any = 0;
    for (int i = 0; i < 16; i++)
        any |= registers[i][2] | registers[i][3];
    return any != 0;
}

static bool has_avx, watches_halves;

static void state_prepare(void)
{
    if (has_avx)
        __asm__ volatile("vzeroupper" ::
                             : "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10",
                               "xmm11", "xmm12", "xmm13", "xmm14", "xmm15");
}

static void state_get(machine_state *s)
{
    struct {
        uint16_t control, unused0, status, unused1, tags, unused2;
        uint32_t other_state[4];
    } x87;
    s->upper = watches_halves && upper_in_use();
    __asm__ volatile("stmxcsr %0" : "=m"(s->mxcsr));
    __asm__ volatile("fnstenv %0\n\tfldenv %0" : "+m"(x87));
    s->mxcsr &= ~UINT32_C(0x3f);
    s->control = x87.control;
    s->tags = x87.tags;
}

/* Restores the state after a fault, or after a kernel that did not restore it. */
static void state_put(const machine_state *s)
{
    __asm__ volatile("ldmxcsr %0" ::"m"(s->mxcsr));
    __asm__ volatile("fninit\n\tfldcw %0" ::"m"(s->control));
}

static bool state_kept(const machine_state *before, const machine_state *after, char *text, size_t size)
{
    if (before->mxcsr != after->mxcsr)
        snprintf(text, size, "changes MXCSR from %04x to %04x", (unsigned)before->mxcsr, (unsigned)after->mxcsr);
    else if (before->control != after->control)
        snprintf(text, size, "changes the x87 control word from %04x to %04x", before->control, after->control);
    else if (after->tags != 0xffff)
        snprintf(text, size, "leaves x87 registers in use (tags %04x): EMMS is missing", after->tags);
    else if (after->upper)
        snprintf(text, size, "leaves upper halves of vector registers in use: VZEROUPPER is missing");
    else
        return true;
    return false;
}

/*
 * Uses the upper halves of vector registers. If the compiler does not clear them, they remain in use after the
 * return.
 */
static __attribute__((noinline, target("avx"))) void use_upper(float *eight)
{
    const __m256 v = _mm256_loadu_ps(eight);
    _mm256_storeu_ps(eight, _mm256_add_ps(v, v));
}

static void state_init(void)
{
    float eight[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    /* ost_isa_available is unsuitable: in tests/simd/portable it returns true even for sets that this machine lacks. */
    has_avx = __builtin_cpu_supports("avx");
    if (has_avx) {
        state_prepare();
        use_upper(eight);
        __asm__ volatile("" ::"r"(eight) : "memory"); /* Without this use of the result, gcc -O1 removes the call. */
        watches_halves = !upper_in_use();
        state_prepare();
    }
}

#elif defined __aarch64__

typedef struct machine_state {
    uint64_t fpcr;
} machine_state;

static void state_init(void)
{
}

static void state_prepare(void)
{
}

static void state_get(machine_state *s)
{
    __asm__ volatile("mrs %0, fpcr" : "=r"(s->fpcr));
}

static void state_put(const machine_state *s)
{
    __asm__ volatile("msr fpcr, %0" ::"r"(s->fpcr));
}

static bool state_kept(const machine_state *before, const machine_state *after, char *text, size_t size)
{
    if (before->fpcr == after->fpcr)
        return true;
    snprintf(text, size, "changes FPCR from %08llx to %08llx", (unsigned long long)before->fpcr,
             (unsigned long long)after->fpcr);
    return false;
}

#else

typedef struct machine_state {
    char none;
} machine_state;

static void state_init(void)
{
}

static void state_prepare(void)
{
}

static void state_get(machine_state *s)
{
    s->none = 0;
}

static void state_put(const machine_state *s)
{
    (void)s;
}

static bool state_kept(const machine_state *before, const machine_state *after, char *text, size_t size)
{
    (void)before, (void)after, (void)text, (void)size;
    return true;
}

#endif

/* ----------------------------------------------------------------- faults */

static sigjmp_buf landing;
static volatile sig_atomic_t in_call, signal_caught;
static void *volatile address_caught;
/* call_seen is the value of call_number when the last SIGVTALRM arrived. */
static volatile sig_atomic_t call_number, call_seen;

static void land(int sig, siginfo_t *info, void *context)
{
    (void)context;
    if (sig == SIGVTALRM) {
        if (!in_call || call_seen != call_number) {
            call_seen = call_number;
            return;
        }
    } else if (!in_call) {
        signal(sig, SIG_DFL);
        raise(sig);
        return;
    }
    in_call = 0;
    signal_caught = sig;
    address_caught = info->si_addr;
    siglongjmp(landing, 1);
}

void call_watch(double seconds)
{
    static const int signals[] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGTRAP, SIGABRT, SIGVTALRM};
    struct sigaction action = {.sa_sigaction = land, .sa_flags = SA_SIGINFO};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        sigaction(signals[i], &action, NULL);
    const long us = (long)(seconds * 1e6);
    const struct timeval tick = {us / 1000000, us % 1000000};
    setitimer(ITIMER_VIRTUAL, &(struct itimerval){tick, tick}, NULL);
    state_init();
}

static void describe_fault(char *text, size_t size)
{
    char where[200] = "";
    if (signal_caught == SIGSEGV || signal_caught == SIGBUS)
        guard_describe(address_caught, where, sizeof where);
    const char *what = "is stopped by a signal";
    switch (signal_caught) {
    case SIGSEGV:
    case SIGBUS:
        what = "accesses memory that it must not access: ";
        break;
    case SIGILL:
        what = "executes an instruction that this processor does not support (SIGILL)";
        break;
    case SIGFPE:
        what = "divides by zero (SIGFPE)";
        break;
    case SIGABRT:
        what = "is aborted by an assertion or a sanitizer";
        break;
    case SIGVTALRM:
        what = "does not end";
        break;
    default:
        break;
    }
    snprintf(text, size, "%s%s", what, where);
}

call_end call_kernel(check_call_fn *call, check_fn *kernel, void *arguments, char *text, size_t size)
{
    static machine_state before, after;
    state_prepare();
    state_get(&before);
    if (sigsetjmp(landing, 1)) {
        state_put(&before);
        describe_fault(text, size);
        return CALL_FAULT;
    }
    call_number = (call_number + 1) & 0xffffff;
    in_call = 1;
    call(kernel, arguments);
    in_call = 0;
    state_get(&after);
    if (state_kept(&before, &after, text, size))
        return CALL_RETURNED;
    state_put(&before);
    return CALL_STATE;
}

bool call_watches_halves(void)
{
#if defined __x86_64__
    return watches_halves;
#else
    return false;
#endif
}

bool call_under_valgrind(void)
{
    if (!getenv("OST_UNDER_VALGRIND"))
        return false;
    puts("not run under valgrind: it would attribute the fault of a wrong kernel to the test; guard pages detect the "
         "same errors");
    return true;
}
