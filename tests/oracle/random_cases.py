# SPDX-License-Identifier: Apache-2.0
"""Runs random cases. Each case is passed to the oracle and to a program, which must agree or both refuse the case."""

import os
import time

import osteon_oracle as oracle


def seeded(test):
    """Returns a seed from OST_TEST_SEED, or otherwise from the clock, and prints it."""
    seed = int(os.environ.get("OST_TEST_SEED", "0"), 0) or time.time_ns() % 2**32
    print(f"# {test}: OST_TEST_SEED={seed}")
    return seed


def agree(cases, least, most):
    """Compares the cases one by one and returns the exit status of the test.

    A case is (expected, got, shown): expected() returns the oracle's text or raises Refused, got is the program's
    text, or "refused" if it refused, and shown is the case as printed in messages. More than `least` and fewer than
    `most` cases must be refused; otherwise the cases are not a mixture, and the test has little significance.
    """
    count = refused = 0
    for expected, got, shown in cases:
        try:
            want, reason = expected(), ""
        except oracle.Refused as why:
            want, reason, refused = "refused", f" ({why})", refused + 1
        if want != got:
            print(f"not ok case {count}: the program has '{got}', the oracle '{want}'{reason}\n{shown}")
            return 1
        count += 1
    if not least < refused < most:
        print(f"not ok: {refused} of {count} cases are refused: the cases are no mixture")
        return 1
    print(f"ok {count} cases, {refused} of them refused by both")
    return 0
