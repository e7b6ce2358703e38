/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the licences of packages in a bundle: a bundle states the SPDX identifiers of the licences that Debian's
 * copyright files name, or nothing.
 */
#include "harness.h"

#include "validation/bundle/copyright.h"

/* Debian's short names of licences (machine-readable copyright format 1.0) must be converted to SPDX identifiers. */
static void licences_of_packages_are_spdx(void **state)
{
    static const char *const pairs[][2] = {{"Expat", "MIT"},
                                           {"GPL-2+", "GPL-2.0-or-later"},
                                           {"LGPL-2.1", "LGPL-2.1-only"},
                                           {"BSD-3-clause and expat", "BSD-3-Clause AND MIT"},
                                           {"GPL-2 or GPL-3+ or Zlib", "GPL-2.0-only OR GPL-3.0-or-later OR Zlib"},
                                           {"public-domain", ""},
                                           {"Expat and", ""},
                                           {"Expat MIT", ""},
                                           {"", ""},
                                           {"GPL-2+ with OpenSSL exception", ""}};
    char out[COPYRIGHT_LICENCE];
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        copyright_spdx(pairs[i][0], out);
        assert_string_equal(out, pairs[i][1]);
    }
    assert_int_equal(copyright_of("../../../etc/passwd", out, NULL), OST_OK);
    assert_string_equal(out, "");
    assert_int_equal(copyright_of("a-package-that-does-not-exist", out, NULL), OST_OK);
    assert_string_equal(out, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(licences_of_packages_are_spdx),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
