/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes two keys to a scratch folder. The tests of both ends of the link (docs/reference/devices.md) use these keys.
 */
#ifndef OST_TESTS_LINK_KEYS_H
#define OST_TESTS_LINK_KEYS_H

#include "harness.h"

#include "haptics/driver.h"
#include "haptics/link.h"
#include "io/io_scratch.h"

#define MM OST_PM_PER_MM
enum { ANSWER_MS = 20000 };

static char *folder;
static char key_file[4200], other_file[4200];
static link_key *key, *other;

static inline int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    uint8_t bytes[32];
    folder = scratch_folder();
    memset(bytes, 7, sizeof bytes);
    snprintf(key_file, sizeof key_file, "%s", scratch_write(folder, "k", bytes, sizeof bytes));
    assert_ok(ost_link_key_make(bytes, sizeof bytes, &key, &err));
    memset(bytes, 8, sizeof bytes);
    snprintf(other_file, sizeof other_file, "%s", scratch_write(folder, "o", bytes, sizeof bytes));
    assert_ok(ost_link_key_make(bytes, sizeof bytes, &other, &err));
    assert_int_equal(chmod(key_file, 0600), 0);
    assert_int_equal(chmod(other_file, 0600), 0);
    return 0;
}

static inline int end(void **state)
{
    (void)state;
    ost_link_key_free(key);
    ost_link_key_free(other);
    scratch_remove(folder);
    return 0;
}

#endif
