/* SPDX-License-Identifier: Apache-2.0 */
/* Loads the stand-ins of tests/haptics/fake in place of the vendors' libraries. */
#ifndef OST_TESTS_FAKE_LIBRARY_H
#define OST_TESTS_FAKE_LIBRARY_H

#include "ref/scene.h"

#include <dlfcn.h>
#include <unistd.h>

#include <osteon/haptics.h>

#include "haptics/fake/fake.h"

#define MM OST_PM_PER_MM
#define DHD "OSTEON_DHD_LIBRARY"
#define HD "OSTEON_OPENHAPTICS_LIBRARY"
#define SPNAV "OSTEON_SPNAV_LIBRARY"

/* Returns the path of a stand-in in the build folder of make check. */
static inline const char *fake_file(const char *name)
{
    static char path[4096];
    const char *build = getenv("top_builddir");
    snprintf(path, sizeof path, "%s/.libs/%s.so", build ? build : ".", name);
    return path;
}

/*
 * Replaces the vendor's library with the stand-in and returns the stand-in's record, cleared.
 * Skips the test if shared objects were not built.
 */
static inline fake_note *load_stand_in(const char *variable, const char *name, const char *note_name)
{
    const char *file = fake_file(name);
    if (access(file, R_OK) != 0) {
        printf("# %s: built without shared objects\n", file);
        skip();
    }
    assert_int_equal(setenv(variable, file, 1), 0);
    void *handle = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(handle);
    fake_note *note = dlsym(handle, note_name);
    assert_non_null(note);
    memset(note, 0, sizeof *note);
    for (int a = 0; a < 3; a++)
        note->column[a][a] = 1;
    return note;
}

static inline int index_of(const char *name)
{
    ost_haptic_info info;
    for (int i = 0; i < ost_haptic_count(); i++)
        if (ost_haptic_describe(i, &info, NULL) == OST_OK && strcmp(info.name, name) == 0)
            return i;
    return -1;
}

static inline ost_haptic_setup at_start(void)
{
    /* A quarter turn about y rotates the tool's axis z to the bone's x. */
    const int32_t c = 759250125;
    return (ost_haptic_setup){.start = {.t = {10 * MM, 20 * MM, 30 * MM}, .qw = c, .qy = c}};
}

#endif
