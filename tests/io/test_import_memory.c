/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the memory of an import. The peak depends on the size of the grid and not on the size of the file. A bone that
 * is larger than the machine's memory is refused at once. The measured import runs in a second process of this program.
 *
 * Covers: REQ-CT-BIG
 */
#include "import_bone.h"

#include <sys/wait.h>
#include <unistd.h>

#define MEMORY_OPTION "--import-within-bounds"

/*
 * Returns the peak memory of this process in KiB, or -1. ru_maxrss is unsuitable, because it includes the memory before
 * exec.
 */
static long peak_kib(void)
{
    FILE *status = fopen("/proc/self/status", "r");
    if (!status)
        return -1;
    char line[256];
    long peak = -1;
    while (peak < 0 && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %ld kB", &peak) != 1)
            peak = -1;
    (void)fclose(status);
    return peak;
}

enum { BOUNDED = 0, UNREADABLE = 1, GREW = 2, UNKNOWN = 77 };

/* Runs in the second process: imports the text and returns an exit status that states whether the peak was bounded. */
static int import_within_bounds(const char *spec, const char *path)
{
    ost_error err = {0};
    ost_import_result result;
    const long before = peak_kib();
    if (before < 0)
        return UNKNOWN;
    if (ost_backend_open(spec, &backend, &err) != OST_OK ||
        import(path, &(ost_import_options){.digests = true}, &result, &err) != OST_OK) {
        (void)fprintf(stderr, "%s\n", err.text);
        return UNREADABLE;
    }
    ost_backend_close(backend);
    const long grown = peak_kib() - before;
    print_message("the peak memory grew by %ld KiB\n", grown);
    return grown < 10 * 1024 && result.scatter.samples == 1000000 ? BOUNDED : GREW;
}

/*
 * The test imports 20 MB of text for a grid of 50^3 voxels, each given eight times. The peak memory must not depend on
 * the size of the file: the grid and the buffers need a few hundred kilobytes, and the test allows 10 MiB. The import
 * runs in a new process for two reasons: this process has already used more memory, and after a fork without exec,
 * OpenMP would wait for threads that exist only in the parent.
 */
static void memory_is_bounded_by_the_grid(void **state)
{
    (void)state;
#if defined __SANITIZE_ADDRESS__
    skip(); /* with a sanitizer, the measurement would include the sanitizer's own memory */
#endif
    if (strncmp(test_backend, "cl", 2) == 0)
        skip(); /* skipped, because the measurement would include the driver's compiler */
    const char *path = in_folder("large.txt");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int repeat = 0; repeat < 8; repeat++)
        for (int v = 0; v < 125000; v++)
            fprintf(file, "%d.5000 %d.5000 %d.5000 %d\n", v % 50, v / 50 % 50, v / 2500, v % 3000);
    long size = ftell(file);
    assert_int_equal(fclose(file), 0);
    assert_true(size > 20000000);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execl("/proc/self/exe", "test_import_memory", MEMORY_OPTION, test_backend, path, (char *)NULL);
        _exit(UNKNOWN);
    }
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFEXITED(ended));
    if (WEXITSTATUS(ended) == UNKNOWN)
        skip(); /* skipped if the system has no /proc */
    assert_int_equal(WEXITSTATUS(ended), BOUNDED);
}

/* A bone of 2^36 voxels takes 137 GB and must be refused at once if the machine has less memory. */
static void bone_larger_than_memory_is_refused(void **state)
{
    (void)state;
    if ((double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE) > 130e9)
        skip();
    char text[64 * 24] = "";
    for (int i = 0; i < 64; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%d %d %d 1000\n", i % 4 * 16, i / 4 % 4 * 16,
                 i / 16 * 16);
    const char *path = scratch_write(folder, "fine.txt", text, strlen(text));
    const ost_import_options options = {.cubic = 16 * OST_PM_PER_MM / 1024, .digests = true};
    ost_error err = {0};
    ost_bone *bone;
    ost_import_result result;
    assert_int_equal(ost_import(backend, path, &options, &bone, &result, &err), OST_ERR_MEMORY);
    assert_null(bone);
    assert_int_equal(result.stage_count, 2);
    if (!strstr(err.text, "fine.txt: with cubic voxels of 0.015625 mm the bone takes 137 GB; this machine has "))
        fail_msg("the error is '%s'", err.text);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], MEMORY_OPTION) == 0)
        return import_within_bounds(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_is_bounded_by_the_grid),
        cmocka_unit_test(bone_larger_than_memory_is_refused),
    };
    return run_on_backends(tests, set_up, tear_down);
}
