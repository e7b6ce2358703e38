/* SPDX-License-Identifier: Apache-2.0 */
/* Makes one scratch folder for all tests of a program. The program calls cmocka_run_group_tests(tests, scratch_set_up,
   scratch_tear_down). */
#ifndef OST_TESTS_SCRATCH_GROUP_H
#define OST_TESTS_SCRATCH_GROUP_H

#include "io/io_scratch.h"

static char *folder;

static int scratch_set_up(void **state)
{
    (void)state;
    folder = scratch_folder();
    return 0;
}

static int scratch_tear_down(void **state)
{
    (void)state;
    scratch_remove(folder);
    return 0;
}

#endif
