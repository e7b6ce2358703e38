/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that each status has a name, a text and an exit status, and that an error's text is a single printable line. */
#include "harness.h"

#include <osteon/status.h>

#include "config.h"

static void every_status_has_an_exit_status(void **state)
{
    (void)state;
    assert_int_equal(ost_status_exit(OST_OK), 0);
    assert_int_equal(ost_status_exit(OST_ERR_DIFFER), 1);
    assert_int_equal(ost_status_exit(OST_ERR_INPUT), 2);
    assert_int_equal(ost_status_exit(OST_ERR_UNAVAILABLE), 3);
    assert_string_equal(ost_status_name(OST_ERR_RANGE), "OST_ERR_RANGE");
    assert_string_equal(ost_status_text(OST_ERR_INPUT), "bad input");
    assert_string_equal(ost_status_name((ost_status)999), "OST_ERR_INTERNAL");
}

static void text_is_one_bounded_line(void **state)
{
    (void)state;
    ost_error err = {0};
    char longer[2 * OST_ERROR_TEXT];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = 0;
    assert_int_equal(ost_fail(&err, OST_ERR_INPUT, "%s", longer), OST_ERR_INPUT);
    assert_int_equal(strlen(err.text), OST_ERROR_TEXT - 1);
    ost_fail(&err, OST_ERR_INPUT, "a\nb\x1b[31mc");
    assert_string_equal(err.text, "a?b?[31mc");
    assert_int_equal(ost_fail_context(&err, "%s:%d", "f.txt", 7), OST_ERR_INPUT);
    assert_string_equal(err.text, "f.txt:7: a?b?[31mc");
}

static void a_null_error_is_allowed(void **state)
{
    (void)state;
    assert_int_equal(ost_fail(NULL, OST_ERR_IO, "x"), OST_ERR_IO);
}

/* The headers, the library and configure.ac state the same version. */
static void versions_are_equal(void **state)
{
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", OST_VERSION_MAJOR, OST_VERSION_MINOR, OST_VERSION_PATCH);
    assert_string_equal(ost_version(), text);
    assert_string_equal(ost_version(), PACKAGE_VERSION);
    assert_int_equal(ost_version_number(), OST_VERSION);
    assert_int_equal(OST_VERSION_NUMBER(1, 2, 3), 1002003);
#if OST_VERSION < OST_VERSION_NUMBER(0, 2, 0) || OST_VERSION >= OST_VERSION_NUMBER(1, 0, 0)
    fail_msg("the preprocessor does not find OST_VERSION between 0.2.0 and 1.0.0");
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_an_exit_status),
        cmocka_unit_test(text_is_one_bounded_line),
        cmocka_unit_test(a_null_error_is_allowed),
        cmocka_unit_test(versions_are_equal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
