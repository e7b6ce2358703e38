/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests requests to end the program. A request is made by a signal, or by another thread while the loop
 * polls for requests (checked by ThreadSanitizer). A second signal must be handled by the handler that was
 * installed before.
 * Covers: REQ-WINDOW
 */
#include <pthread.h>
#include <signal.h>

#include "app/common/interrupt.h"
#include "harness.h"

static volatile sig_atomic_t others;

static void on_other(int number)
{
    (void)number;
    others = others + 1;
}

static void a_signal_is_a_wish_once(void **state)
{
    (void)state;
    const struct sigaction other = {.sa_handler = on_other};
    assert_int_equal(sigaction(SIGTERM, &other, NULL), 0);
    interrupt_begin();
    assert_false(interrupt_requested());
    raise(SIGTERM);
    assert_true(interrupt_requested());
    assert_int_equal(others, 0);
    raise(SIGTERM);
    assert_int_equal(others, 1);
    interrupt_end();
    raise(SIGTERM);
    assert_int_equal(others, 2);
    interrupt_begin();
    assert_false(interrupt_requested());
    interrupt_end();
}

static void *until_asked(void *user)
{
    (void)user;
    while (!interrupt_requested())
        ;
    return NULL;
}

static void a_thread_hears_another_ones_wish(void **state)
{
    pthread_t thread;
    (void)state;
    interrupt_begin();
    assert_int_equal(pthread_create(&thread, NULL, until_asked, NULL), 0);
    interrupt_request();
    assert_int_equal(pthread_join(thread, NULL), 0);
    interrupt_end();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_signal_is_a_wish_once),
        cmocka_unit_test(a_thread_hears_another_ones_wish),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
