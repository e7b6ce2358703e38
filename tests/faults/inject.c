/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A library for LD_PRELOAD that injects faults: it makes calls of the process fail.
 *
 *   OST_FAIL_ALLOC=K   the K-th call of malloc, calloc, realloc, posix_memalign, aligned_alloc, memalign,
 *                      strdup or a libc function that allocates memory with them
 *   OST_FAIL_OPEN=K    the K-th call of open, openat, fopen, opendir or a variant of them
 *   OST_FAIL_READ=K    the K-th call of read or pread
 *   OST_FAIL_FROM=1    the K-th call and all later calls of the same type fail
 *   OST_FAIL_ERRNO=N   errno of a failed open or read (default EMFILE and EIO)
 *   OST_FAIL_IN=TEXT   calls are counted and fail only in processes with the argument TEXT, or for !TEXT
 *                      only in processes without it
 *   OST_FAIL_PATH=TEXT only opens of paths that contain TEXT are counted
 *   OST_FAIL_EXCEPT=A:B  calls from a program or library whose path contains A or B are not counted
 *   OST_FAIL_REPORT=FILE  at exit a process appends the numbers of counted calls to FILE, as "alloc N",
 *                      "open N" and "read N"
 *   OST_FAIL_TRACE=1   the stack of the failed call is printed on standard error
 *
 * Calls of all threads are counted together. K begins at 1; if K is 0, no call fails. Allocations by C++ code (operator
 * new) are never counted, because an exception thrown through C code terminates the process. A fork keeps the counts
 * and an exec call resets them, so the K-th call of each program fails.
 */
/* The functions below are redefined, so the headers of libc must not redirect them. */
#undef _FORTIFY_SOURCE
#undef _FILE_OFFSET_BITS
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <malloc.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ALLOC, OPEN, READ, KINDS, CACHE = 4096, TRACE = 40, EARLY_BYTES = 1 << 14, TEXT = 1024 };

static struct {
    const char *variable, *name;
    long at;
    atomic_long count;
} kinds[KINDS] = {{"OST_FAIL_ALLOC", "alloc", 0, 0}, {"OST_FAIL_OPEN", "open", 0, 0}, {"OST_FAIL_READ", "read", 0, 0}};

static bool ready, from, trace;
static int chosen_errno;
static char except[TEXT], only_path[TEXT], report_path[TEXT];

/* Return addresses that have already been classified, each stored as address * 2 + excepted. */
static atomic_uintptr_t cache[CACHE];

/* -------------------------------------------------------- the real functions */

#define NEXT(name) next_##name
#define REAL(type, name, parameters) static type (*NEXT(name)) parameters
REAL(void *, malloc, (size_t));
REAL(void *, calloc, (size_t, size_t));
REAL(void *, realloc, (void *, size_t));
REAL(void, free, (void *));
REAL(int, posix_memalign, (void **, size_t, size_t));
REAL(void *, aligned_alloc, (size_t, size_t));
REAL(void *, memalign, (size_t, size_t));

/* Memory for allocations by the loader before the real functions are found. */
static _Alignas(16) unsigned char early[EARLY_BYTES];
static size_t early_used;

static bool is_early(const void *p)
{
    return (uintptr_t)p >= (uintptr_t)early && (uintptr_t)p < (uintptr_t)early + EARLY_BYTES;
}

static void *early_alloc(size_t size)
{
    const size_t need = (size + 15) & ~(size_t)15;
    if (need > EARLY_BYTES - early_used)
        abort();
    void *p = early + early_used;
    early_used += need;
    return p;
}

static void *find(const char *name)
{
    return dlsym(RTLD_NEXT, name);
}

static void resolve(void)
{
    static bool resolving;
    if (resolving)
        return;
    resolving = true;
    *(void **)&NEXT(calloc) = find("calloc");
    *(void **)&NEXT(realloc) = find("realloc");
    *(void **)&NEXT(free) = find("free");
    *(void **)&NEXT(posix_memalign) = find("posix_memalign");
    *(void **)&NEXT(aligned_alloc) = find("aligned_alloc");
    *(void **)&NEXT(memalign) = find("memalign");
    *(void **)&NEXT(malloc) = find("malloc");
}

static void copy_setting(char to[TEXT], const char *variable)
{
    const char *value = getenv(variable);
    snprintf(to, TEXT, "%s", value ? value : "");
}

/* Returns true if OST_FAIL_IN selects a process with these arguments, so that the calls of the process are counted. */
static bool process_counts(int argc, char **argv)
{
    const char *wanted = getenv("OST_FAIL_IN");
    const bool without = wanted && wanted[0] == '!';
    bool has = false;
    for (int i = 1; wanted && i < argc; i++)
        has |= strcmp(argv[i], wanted + without) == 0;
    return !wanted || has != without;
}

/* glibc passes the arguments of main to constructors. */
__attribute__((constructor)) static void begin(int argc, char **argv)
{
    if (!NEXT(malloc))
        resolve();
    for (int k = 0; k < KINDS; k++)
        kinds[k].at = getenv(kinds[k].variable) ? atol(getenv(kinds[k].variable)) : 0;
    from = getenv("OST_FAIL_FROM") != NULL;
    trace = getenv("OST_FAIL_TRACE") != NULL;
    chosen_errno = getenv("OST_FAIL_ERRNO") ? atoi(getenv("OST_FAIL_ERRNO")) : 0;
    copy_setting(except, "OST_FAIL_EXCEPT");
    copy_setting(only_path, "OST_FAIL_PATH");
    copy_setting(report_path, "OST_FAIL_REPORT");
    void *stack[2];
    backtrace(stack, 2); /* The first call of backtrace loads a library, which must not be counted. */
    ready = process_counts(argc, argv);
}

__attribute__((destructor)) static void end(void)
{
    ready = false;
    FILE *file = report_path[0] ? fopen(report_path, "a") : NULL;
    if (!file)
        return;
    for (int k = 0; k < KINDS; k++)
        fprintf(file, "%s %ld\n", kinds[k].name, atomic_load(&kinds[k].count));
    fclose(file);
}

/* ---------------------------------------------- choosing the call that fails */

static bool module_is_excepted(const char *module)
{
    if (strstr(module, "libstdc++") || strstr(module, "libc++"))
        return true;
    for (const char *p = except; *p;) {
        const size_t n = strcspn(p, ":");
        if (n > 0 && n < TEXT) {
            char word[TEXT];
            memcpy(word, p, n);
            word[n] = '\0';
            if (strstr(module, word))
                return true;
        }
        p += n + (p[n] == ':');
    }
    return false;
}

static bool module_holds(void *address, const char *name)
{
    Dl_info info;
    return dladdr(address, &info) && info.dli_fname && strstr(info.dli_fname, name);
}

/*
 * Returns true if the address is in libc or in the loader. The loader must be included because it allocates
 * the thread-local storage of new threads.
 */
static bool is_of_libc(void *address)
{
    return module_holds(address, "libc.so") || module_holds(address, "ld-linux");
}

/*
 * Returns the first address on the stack that is neither in this library nor in libc. libc is skipped
 * because some of its functions, for example strdup and fopen, allocate memory.
 */
static void *outside_libc(void *caller)
{
    void *stack[TRACE];
    const int count = backtrace(stack, TRACE);
    for (int i = 0; i < count; i++)
        if (!is_of_libc(stack[i]) && !module_holds(stack[i], "fault_inject"))
            return stack[i];
    return caller;
}

static bool is_excepted(void *caller)
{
    const uintptr_t address = (uintptr_t)caller;
    atomic_uintptr_t *entry = &cache[(address >> 2) % CACHE];
    const uintptr_t known = atomic_load_explicit(entry, memory_order_relaxed);
    if (known >> 1 == address)
        return known & 1;
    Dl_info info;
    if (is_of_libc(caller))
        return dladdr(outside_libc(caller), &info) && info.dli_fname && module_is_excepted(info.dli_fname);
    const bool excepted = dladdr(caller, &info) && info.dli_fname && module_is_excepted(info.dli_fname);
    atomic_store_explicit(entry, address << 1 | excepted, memory_order_relaxed);
    return excepted;
}

/* Counts a call. Returns true if it must fail. */
static bool fails(int kind, void *caller)
{
    static _Thread_local bool within;
    if (!ready || within)
        return false;
    within = true;
    const bool excepted = is_excepted(caller);
    within = false;
    if (excepted)
        return false;
    const long count = atomic_fetch_add(&kinds[kind].count, 1) + 1;
    if (kinds[kind].at <= 0 || (from ? count < kinds[kind].at : count != kinds[kind].at))
        return false;
    if (trace) {
        void *stack[TRACE];
        within = true;
        backtrace_symbols_fd(stack, backtrace(stack, TRACE), STDERR_FILENO);
        within = false;
    }
    return true;
}

#define CALLER __builtin_return_address(0)

/* -------------------------------------------------------------------- memory */

void *malloc(size_t size)
{
    if (!NEXT(malloc))
        resolve();
    if (!NEXT(malloc))
        return early_alloc(size);
    if (fails(ALLOC, CALLER)) {
        errno = ENOMEM;
        return NULL;
    }
    return NEXT(malloc)(size);
}

void *calloc(size_t count, size_t size)
{
    if (!NEXT(malloc))
        resolve();
    if (!NEXT(malloc))
        return early_alloc(count * size);
    if (fails(ALLOC, CALLER)) {
        errno = ENOMEM;
        return NULL;
    }
    return NEXT(calloc)(count, size);
}

void *realloc(void *p, size_t size)
{
    if (!NEXT(malloc))
        resolve();
    if (is_early(p) || !NEXT(malloc)) {
        void *q = NEXT(malloc) ? NEXT(malloc)(size) : early_alloc(size);
        const size_t most = p ? (size_t)(early + EARLY_BYTES - (unsigned char *)p) : 0;
        if (p && q)
            memmove(q, p, size < most ? size : most);
        return q;
    }
    if (fails(ALLOC, CALLER)) {
        errno = ENOMEM;
        return NULL;
    }
    return NEXT(realloc)(p, size);
}

void free(void *p)
{
    if (p && !is_early(p) && NEXT(free))
        NEXT(free)(p);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    return fails(ALLOC, CALLER) ? ENOMEM : NEXT(posix_memalign)(out, alignment, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    if (fails(ALLOC, CALLER)) {
        errno = ENOMEM;
        return NULL;
    }
    return NEXT(aligned_alloc)(alignment, size);
}

void *memalign(size_t alignment, size_t size)
{
    if (fails(ALLOC, CALLER)) {
        errno = ENOMEM;
        return NULL;
    }
    return NEXT(memalign)(alignment, size);
}

/* --------------------------------------------------------------------- files */

static bool open_fails(const char *path, void *caller)
{
    if (only_path[0] && (!path || !strstr(path, only_path)))
        return false;
    if (!fails(OPEN, caller))
        return false;
    errno = chosen_errno ? chosen_errno : EMFILE;
    return true;
}

static bool read_fails(void *caller)
{
    if (!fails(READ, caller))
        return false;
    errno = chosen_errno ? chosen_errno : EIO;
    return true;
}

/* Looks up a real function at each call. This is possible because dlsym does not open files. */
#define LOOK_UP(type, name, parameters) \
    type(*real) parameters;             \
    *(void **)&real = find(#name)

#define OPEN_WITH_MODE(name)                                  \
    int name(const char *path, int flags, ...)                \
    {                                                         \
        LOOK_UP(int, name, (const char *, int, ...));         \
        va_list args;                                         \
        va_start(args, flags);                                \
        const mode_t mode = va_arg(args, mode_t);             \
        va_end(args);                                         \
        return open_fails(path, CALLER) ? -1 : real(path, flags, mode); \
    }
#define OPENAT_WITH_MODE(name)                                \
    int name(int folder, const char *path, int flags, ...)    \
    {                                                         \
        LOOK_UP(int, name, (int, const char *, int, ...));    \
        va_list args;                                         \
        va_start(args, flags);                                \
        const mode_t mode = va_arg(args, mode_t);             \
        va_end(args);                                         \
        return open_fails(path, CALLER) ? -1 : real(folder, path, flags, mode); \
    }
#define FUNCTION(type, name, parameters, failed, otherwise, arguments) \
    type name parameters;                                              \
    type name parameters                                               \
    {                                                                  \
        LOOK_UP(type, name, parameters);                               \
        return (failed) ? (otherwise) : real arguments;                \
    }

OPEN_WITH_MODE(open)
OPEN_WITH_MODE(open64)
OPENAT_WITH_MODE(openat)
OPENAT_WITH_MODE(openat64)
FUNCTION(int, __open_2, (const char *path, int flags), open_fails(path, CALLER), -1, (path, flags))
FUNCTION(int, __open64_2, (const char *path, int flags), open_fails(path, CALLER), -1, (path, flags))
FUNCTION(int, __openat_2, (int folder, const char *path, int flags), open_fails(path, CALLER), -1,
         (folder, path, flags))
FUNCTION(int, __openat64_2, (int folder, const char *path, int flags), open_fails(path, CALLER), -1,
         (folder, path, flags))
FUNCTION(FILE *, fopen, (const char *path, const char *mode), open_fails(path, CALLER), NULL, (path, mode))
FUNCTION(FILE *, fopen64, (const char *path, const char *mode), open_fails(path, CALLER), NULL, (path, mode))
FUNCTION(DIR *, opendir, (const char *path), open_fails(path, CALLER), NULL, (path))
FUNCTION(ssize_t, read, (int fd, void *to, size_t size), read_fails(CALLER), -1, (fd, to, size))
FUNCTION(ssize_t, __read_chk, (int fd, void *to, size_t size, size_t capacity), read_fails(CALLER), -1,
         (fd, to, size, capacity))
FUNCTION(ssize_t, pread, (int fd, void *to, size_t size, off_t at), read_fails(CALLER), -1, (fd, to, size, at))
FUNCTION(ssize_t, pread64, (int fd, void *to, size_t size, off_t at), read_fails(CALLER), -1, (fd, to, size, at))
