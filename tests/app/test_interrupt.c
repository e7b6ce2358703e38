/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests requests to end the program. A request is made by a signal, or by another thread while the loop
 * polls for requests (checked by ThreadSanitizer). A second signal must be handled by the handler that was
 * installed before the first request.
 * Covers: REQ-WINDOW
 */
#include <pthread.h>
#include <signal.h>

#include "app/common/interrupt.h"
#include "harness.h"

static volatile sig_atomic_t others;

static void count_signal(int number)
{
    (void)number;
    others = others + 1;
}

static void first_signal_requests_end(void **state)
{
    (void)state;
    const struct sigaction other = {.sa_handler = count_signal};
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

static void *wait_for_request(void *user)
{
    (void)user;
    while (!interrupt_requested())
        ;
    return NULL;
}

static void request_is_visible_to_other_thread(void **state)
{
    pthread_t thread;
    (void)state;
    interrupt_begin();
    assert_int_equal(pthread_create(&thread, NULL, wait_for_request, NULL), 0);
    interrupt_request();
    assert_int_equal(pthread_join(thread, NULL), 0);
    interrupt_end();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_signal_requests_end),
        cmocka_unit_test(request_is_visible_to_other_thread),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
