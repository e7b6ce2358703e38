/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the cache of compiled kernels. The tests check which programs are stored, how the key of an entry is computed,
 * and how entries are handled that are damaged, invalid, missing or owned by another user.
 */
#include "cl/try_open.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cl/cache.h"
#include "cl/embedded.h"

/* Returns the path of the only file in the cache's folder. */
static void entry_path(const char *cache, char *path, size_t size)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%s/osteon", cache);
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    path[0] = 0;
    for (const struct dirent *e; (e = readdir(dir));)
        if (e->d_name[0] != '.') {
            assert_int_equal(path[0], 0);
            assert_true((size_t)snprintf(path, size, "%s/%s", folder, e->d_name) < size);
        }
    closedir(dir);
    assert_true(path[0] != 0);
}

static unsigned char *read_all(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size = (size_t)ftell(f);
    rewind(f);
    unsigned char *bytes = malloc(*size);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, f), *size);
    fclose(f);
    return bytes;
}

static void write_all(const char *path, const unsigned char *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

/* Opens the first suitable device. Returns true if its program came from the cache. */
static bool opened_from_cache(void)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&ost_cl_loader, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const bool from_cache = ((cl_backend *)backend)->from_cache;
    ost_backend_close(backend);
    return from_cache;
}

/* Returns true if the platform of the first suitable device has this name. */
static bool on_platform(const char *name)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_cl_open_with(&ost_cl_loader, own_options(), &backend, &err));
    backend->ops = &ost_backend_cl;
    const bool is = strcmp(((cl_backend *)backend)->device.platform_name, name) == 0;
    ost_backend_close(backend);
    return is;
}

/* Makes a new cache folder for the backends that the test opens next, and stores the path of the old folder in
   `before`. PoCL's cache stays in the old folder. */
static void begin_cache(char *folder, char *before, size_t size)
{
    snprintf(before, size, "%s", getenv("XDG_CACHE_HOME"));
    assert_non_null(mkdtemp(folder));
    setenv("XDG_CACHE_HOME", folder, 1);
    setenv("POCL_CACHE_DIR", before, 0);
}

static void end_cache(const char *folder, const char *before)
{
    char command[100];
    setenv("XDG_CACHE_HOME", before, 1);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
}

/*
 * PoCL compiles all kernels of a program when the program's binary is requested, which is slow. Therefore, on PoCL,
 * the first program that a process builds from source is not stored. The second program is stored. This test must be
 * the first test that opens a device.
 */
static void first_program_is_cached_unless_pocl(void **state)
{
    (void)state;
    char before[4096], folder[] = "/tmp/osteon-cache-XXXXXX", osteon[64];
    begin_cache(folder, before, sizeof before);
    snprintf(osteon, sizeof osteon, "%s/osteon", folder);
    assert_false(opened_from_cache());
    const bool stored = access(osteon, F_OK) == 0;
    assert_int_equal(opened_from_cache(), stored);
    assert_true(opened_from_cache());
    assert_int_equal(access(osteon, F_OK), 0);
    assert_int_equal(stored, !on_platform("Portable Computing Language"));
    end_cache(folder, before);
}

static void damaged_cache_entries_are_replaced(void **state)
{
    (void)state;
    char before[4096], folder[] = "/tmp/osteon-cache-XXXXXX", path[5000];
    begin_cache(folder, before, sizeof before);

    assert_false(opened_from_cache());
    assert_true(opened_from_cache());
    entry_path(folder, path, sizeof path);
    size_t size;
    unsigned char *good = read_all(path, &size);
    unsigned char *bad = malloc(size + 1);
    assert_non_null(bad);
    assert_true(size > 80);

    /*
     * The lengths to which the cache entry is truncated, and the positions at which a byte is changed. The
     * positions are in the header, the key, the checksum and the binary.
     */
    const size_t cuts[] = {0, 1, 7, 79, 80, size / 2, size - 1},
                 flips[] = {0, 8, 15, 16, 47, 48, 79, 80, size / 2, size - 1};
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
        write_all(path, good, cuts[i]);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }
    for (size_t i = 0; i < sizeof flips / sizeof flips[0]; i++) {
        memcpy(bad, good, size);
        bad[flips[i]] ^= 0x10;
        write_all(path, bad, size);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }
    memcpy(bad, good, size);
    bad[size] = 0;
    write_all(path, bad, size + 1); /* The entry is one byte longer than its length field states. */
    assert_false(opened_from_cache());

    /* This entry contains an invalid binary, but its magic, length, key and checksum are right. Only an attacker
       would write such an entry. The binary is passed to the driver. rusticl (Mesa 22.3) aborts the process in its
       program.rs instead of returning an error. */
    ost_digest checksum;
    if (on_platform("rusticl"))
        printf("# an invalid binary is not tested, because rusticl aborts the process\n");
    else {
        const char rubbish[] = "not a driver's binary";
        const uint64_t length = sizeof rubbish;
        assert_int_equal(ost_digest_bytes(rubbish, sizeof rubbish, &checksum, NULL), OST_OK);
        memcpy(bad, good, 80);
        memcpy(bad + 8, &length, 8);
        memcpy(bad + 48, &checksum, 32);
        memcpy(bad + 80, rubbish, sizeof rubbish);
        write_all(path, bad, 80 + sizeof rubbish);
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
    }

    /* The cache path first refers to a file, and then to a folder that cannot be created. */
    setenv("XDG_CACHE_HOME", path, 1);
    assert_false(opened_from_cache());
    setenv("XDG_CACHE_HOME", "/proc/nothing", 1);
    assert_false(opened_from_cache());

    free(bad);
    free(good);
    end_cache(folder, before);
}

/* A cache that other users may have written must be neither read nor written. */
static void cache_of_other_users_is_not_used(void **state)
{
    (void)state;
    char before[4096], cache[] = "/tmp/osteon-cache-XXXXXX", folder[64], elsewhere[64], path[5000], moved[5100];
    struct stat info;
    begin_cache(cache, before, sizeof before);
    snprintf(folder, sizeof folder, "%s/osteon", cache);
    snprintf(elsewhere, sizeof elsewhere, "%s/elsewhere", cache);

    assert_false(opened_from_cache());
    assert_int_equal(stat(folder, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0700);
    entry_path(cache, path, sizeof path);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    assert_true(opened_from_cache());

    /* A cache folder to which its group or others may write must be neither used nor changed. */
    const mode_t open_modes[] = {0770, 0702};
    for (size_t i = 0; i < sizeof open_modes / sizeof open_modes[0]; i++) {
        assert_int_equal(chmod(folder, open_modes[i]), 0);
        assert_false(opened_from_cache());
        assert_false(opened_from_cache());
    }
    assert_int_equal(chmod(folder, 0700), 0);
    assert_true(opened_from_cache());

    /* A cache entry with write permission for other users is replaced with a new entry without this permission. */
    assert_int_equal(chmod(path, 0620), 0);
    assert_false(opened_from_cache());
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
    assert_true(opened_from_cache());

    /* Symbolic links to a valid entry and to a valid folder must not be followed. */
    snprintf(moved, sizeof moved, "%s/moved", cache);
    assert_int_equal(rename(path, moved), 0);
    assert_int_equal(symlink(moved, path), 0);
    assert_false(opened_from_cache());
    assert_int_equal(lstat(path, &info), 0);
    assert_true(S_ISREG(info.st_mode)); /* The link was replaced, not followed. */
    assert_true(opened_from_cache());
    assert_int_equal(rename(folder, elsewhere), 0);
    assert_int_equal(symlink(elsewhere, folder), 0);
    assert_false(opened_from_cache());
    assert_false(opened_from_cache());
    assert_int_equal(unlink(folder), 0);
    assert_int_equal(rename(elsewhere, folder), 0);
    assert_true(opened_from_cache());

    /* An entry or folder of another user is not used. Only root can create one for this test. */
    if (geteuid() == 0 && chown(path, 65534, 65534) == 0) {
        assert_false(opened_from_cache());
        assert_true(opened_from_cache());
        assert_int_equal(chown(folder, 65534, 65534), 0);
        assert_false(opened_from_cache());
        assert_false(opened_from_cache());
    } else
        printf("# a folder of another user is not tested, because only root can create it\n");

    end_cache(cache, before);
}

static ost_digest key_now(void)
{
    const ost_cl_device device = {.platform_name = "P", .platform_version = "OpenCL 1.2", .name = "D", .driver = "1"};
    const char *const sources[] = {"a", "b"};
    ost_cl_cache cache;
    ost_error err = {0};
    assert_ok(ost_cl_key(&device, sources, 2, "", &cache, &err));
    return cache.key;
}

/*
 * The key depends on the environment variables that configure drivers. It does not depend on cache folders or on
 * variables of other programs.
 */
static void cache_key_depends_on_driver_settings(void **state)
{
    (void)state;
    static const char *const matter[] = {"POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_METHOD", "RUSTICL_FEATURES",
                                         "GALLIVM_PERF", "CL_CONFIG_X"};
    static const char *const do_not[] = {"POCL_CACHE_DIR", "MESA_SHADER_CACHE_DIR", "OST_ANYTHING", "XPOCL_X"};
    const ost_digest before = key_now();
    for (size_t i = 0; i < sizeof matter / sizeof matter[0]; i++) {
        char *kept = getenv(matter[i]) ? strdup(getenv(matter[i])) : NULL;
        setenv(matter[i], "sse2-or-so", 1);
        const ost_digest one = key_now();
        setenv(matter[i], "another", 1);
        const ost_digest other = key_now();
        if (kept)
            setenv(matter[i], kept, 1);
        else
            unsetenv(matter[i]);
        free(kept);
        if (ost_digest_equal(&one, &before) || ost_digest_equal(&one, &other))
            fail_msg("the cache key does not depend on %s", matter[i]);
    }
    for (size_t i = 0; i < sizeof do_not / sizeof do_not[0]; i++) {
        char *kept = getenv(do_not[i]) ? strdup(getenv(do_not[i])) : NULL;
        setenv(do_not[i], "/somewhere/else", 1);
        const ost_digest now = key_now();
        if (kept)
            setenv(do_not[i], kept, 1);
        else
            unsetenv(do_not[i]);
        free(kept);
        if (!ost_digest_equal(&now, &before))
            fail_msg("the cache key depends on %s", do_not[i]);
    }
    /* The key does not depend on the order in which the variables were set. */
    setenv("POCL_B", "1", 1);
    setenv("POCL_A", "2", 1);
    const ost_digest first = key_now();
    unsetenv("POCL_B");
    setenv("POCL_B", "1", 1);
    const ost_digest second = key_now();
    unsetenv("POCL_A");
    unsetenv("POCL_B");
    const ost_digest after = key_now();
    assert_true(ost_digest_equal(&first, &second) && !ost_digest_equal(&first, &before) &&
                ost_digest_equal(&after, &before));
}

int main(void)
{
    const int missing = device_missing();
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_program_is_cached_unless_pocl),
        cmocka_unit_test(damaged_cache_entries_are_replaced),
        cmocka_unit_test(cache_of_other_users_is_not_used),
        cmocka_unit_test(cache_key_depends_on_driver_settings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
