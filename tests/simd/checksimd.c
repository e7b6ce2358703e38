/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares every kernel of every instruction set with the scalar kernel.
 *
 *   checksimd                                  tests all kernels with random cases and with limit values
 *   checksimd --function=split --isa=avx2      tests one kernel of one instruction set
 *             --seed=N --case=K                repeats one case, with the numbers that a failure prints
 *   checksimd --bench                          times the kernels instead, without checking the times
 *   checksimd --list                           lists the kernels
 *
 * If slots of several instruction sets contain the same function, only the slot of the lowest set is tested,
 * unless --isa names another one. A scalar function is compared with itself, which detects only memory
 * accesses that the contract forbids. The exit status is 0 for success, 1 if a case failed, 2 for a usage
 * error, and 77 if this machine runs only scalar code or cannot run the requested instruction set.
 *
 * Covers: AR-LAW-1
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "simd/check.h"

typedef struct options {
    uint64_t seed;
    const char *function; /* name of the kernel, or NULL for all kernels */
    int isa;              /* instruction set, or -1 for all */
    int number;           /* number of the case, or -1 for all */
    int times;            /* factor by which the number of cases is multiplied */
    bool bench, list;
} options;

static void usage(FILE *to)
{
    fputs("Usage: checksimd [--seed=N] [--function=NAME] [--isa=NAME] [--case=K] [--times=N]\n"
          "       checksimd --bench [--function=NAME] [--isa=NAME]\n"
          "       checksimd --list\n"
          "Compares every vector kernel with the scalar kernel. --times=N runs N times as many cases.\n"
          "Without --seed, the seed is OST_TEST_SEED of the environment, or else the time.\n",
          to);
}

/* Returns the text after "--name=", or NULL. */
static const char *value_of(const char *argument, const char *name)
{
    const size_t n = strlen(name);
    return strncmp(argument, name, n) == 0 && argument[n] == '=' ? argument + n + 1 : NULL;
}

static bool number_of(const char *text, uint64_t max, uint64_t *out)
{
    char *end;
    *out = strtoull(text, &end, 0);
    return *text >= '0' && *text <= '9' && *end == '\0' && *out <= max;
}

static bool isa_of(const char *text, int *out)
{
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        if (strcmp(ost_isa_name((ost_isa)isa), text) == 0) {
            *out = isa;
            return true;
        }
    return false;
}

static bool known(const char *function)
{
    for (int i = 0; i < check_kernel_count; i++)
        if (strcmp(check_kernels[i]->name, function) == 0)
            return true;
    return false;
}

static bool read_option(const char *argument, options *o)
{
    const char *v;
    uint64_t n;
    if (strcmp(argument, "--bench") == 0)
        return o->bench = true;
    if (strcmp(argument, "--list") == 0)
        return o->list = true;
    if ((v = value_of(argument, "--seed")))
        return number_of(v, UINT64_MAX, &o->seed);
    if ((v = value_of(argument, "--function"))) {
        o->function = v;
        return known(v);
    }
    if ((v = value_of(argument, "--isa")))
        return isa_of(v, &o->isa);
    if ((v = value_of(argument, "--case")) && number_of(v, 1000000000, &n)) {
        o->number = (int)n;
        return true;
    }
    if ((v = value_of(argument, "--times")) && number_of(v, 1000, &n) && n > 0) {
        o->times = (int)n;
        return true;
    }
    return false;
}

static bool chosen(const options *o, const check_kernel *kernel)
{
    return !o->function || strcmp(o->function, kernel->name) == 0;
}

/* Returns the lowest level below `isa` whose slot contains the same function, or `isa` if there is no such level. */
static int same_as(const check_kernel *kernel, int isa)
{
    for (int lower = 0; lower < isa; lower++)
        if (ost_isa_available((ost_isa)lower) && kernel->of((ost_isa)lower) == kernel->of((ost_isa)isa))
            return lower;
    return isa;
}

static void print_list(void)
{
    printf("%-16s %8s", "function", "cases");
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        printf("  %-11s", ost_isa_name((ost_isa)isa));
    printf("\n");
    for (int i = 0; i < check_kernel_count; i++) {
        printf("%-16s %8d", check_kernels[i]->name, check_kernels[i]->cases);
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            char text[24] = "own";
            if (!ost_isa_available((ost_isa)isa))
                snprintf(text, sizeof text, "not here");
            else if (same_as(check_kernels[i], isa) != isa)
                snprintf(text, sizeof text, "as %.8s", ost_isa_name((ost_isa)same_as(check_kernels[i], isa)));
            printf("  %-11s", text);
        }
        printf("\n");
    }
}

static int bench_all(const options *o)
{
    const ost_isa only = o->isa < 0 ? OST_ISA_COUNT : (ost_isa)o->isa;
    bench_heading(only);
    for (int i = 0; i < check_kernel_count; i++)
        if (chosen(o, check_kernels[i]) && check_kernels[i]->bench)
            bench_run(check_kernels[i], only);
    return 0;
}

/*
 * Checks a kernel for one instruction set and writes the result to `cell`. Returns false if the
 * check failed.
 */
static bool check_one(const options *o, const check_kernel *kernel, int isa, char cell[24])
{
    const int same = same_as(kernel, isa);
    if (same != isa && o->isa != isa) {
        snprintf(cell, 24, "as %.8s", ost_isa_name((ost_isa)same));
        return true;
    }
    const int first = o->number < 0 ? 0 : o->number, count = o->number < 0 ? kernel->cases * o->times : 1;
    const bool good = check_run(kernel, kernel->of(OST_ISA_SCALAR), kernel->of((ost_isa)isa),
                                ost_isa_name((ost_isa)isa), o->seed, first, count, false) == CHECK_GOOD;
    snprintf(cell, 24, "%s", good ? "ok" : "FAILED");
    return good;
}

static int check_all(const options *o)
{
    enum { KERNELS_MAX = 64 };
    static char cell[KERNELS_MAX][OST_ISA_COUNT][24];
    int failed = 0, checked = 0, vectors = 0;
    printf("checksimd --seed=%" PRIu64 "\n", o->seed);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if ((o->isa >= 0 && o->isa != isa) || !ost_isa_available((ost_isa)isa))
            continue;
        vectors += isa != OST_ISA_SCALAR;
        for (int i = 0; i < check_kernel_count && i < KERNELS_MAX; i++)
            if (chosen(o, check_kernels[i])) {
                failed += !check_one(o, check_kernels[i], isa, cell[i][isa]);
                checked++;
                fflush(stdout);
            }
    }
    printf("%-16s", "function");
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        printf("  %-11s", ost_isa_name((ost_isa)isa));
    printf("\n");
    for (int i = 0; i < check_kernel_count && i < KERNELS_MAX; i++) {
        if (!chosen(o, check_kernels[i]))
            continue;
        printf("%-16s", check_kernels[i]->name);
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            printf("  %-11s", ost_isa_available((ost_isa)isa) ? cell[i][isa] : "not here");
        printf("\n");
    }
    printf("%d of %d failed\n", failed, checked);
    if (failed > 0)
        return 1;
    return checked == 0 || (vectors == 0 && o->isa < 0) ? 77 : 0;
}

int main(int argc, char **argv)
{
    const char *given = getenv("OST_TEST_SEED");
    options o = {.seed = given ? strtoull(given, NULL, 0)
                               : ((uint64_t)time(NULL) * 2654435761u ^ (uint64_t)clock()) & UINT32_MAX,
                 .isa = -1,
                 .number = -1,
                 .times = getenv("OST_TEST_LONG") ? 50 : 1};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            usage(stdout);
            return 0;
        }
        if (!read_option(argv[i], &o)) {
            fprintf(stderr, "checksimd: invalid option '%s'\n", argv[i]);
            usage(stderr);
            return 2;
        }
    }
    if (o.isa >= 0 && !ost_isa_available((ost_isa)o.isa)) {
        printf("checksimd: %s does not run on this machine, or is not in this build\n", ost_isa_name((ost_isa)o.isa));
        return 77;
    }
    if (call_under_valgrind())
        return 77;
    call_watch(10);
    if (o.list) {
        print_list();
        return 0;
    }
    return o.bench ? bench_all(&o) : check_all(&o);
}
