#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the list of decisions that no case reaches (validation/coverage/decisions.py). A decision
without a reason and a reason without a decision must both be found. The project's list must have
the form that the measurement needs.
Covers: REQ-COVERAGE
"""
import contextlib
import io
import os
import sys

root = os.environ.get("top_srcdir") or os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(root, "validation/coverage"))
import decisions  # noqa: E402

DECISION = ("src/core/a.c", "f", "x * y > 2", "true")


def mistakes(reasons, found, files=("src/core/a.c",)):
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        count = decisions.check(found, [decisions.Reason(row) for row in reasons], set(files))[1]
    return count, said.getvalue()


assert mistakes([], {DECISION}) == (1, "not reached, and no reason is listed: src/core/a.c | f | x * y > 2 | true\n")
assert mistakes([[*DECISION, "why"]], {DECISION})[0] == 0
assert mistakes([[*DECISION, "why"]], set()) == (1, "listed, but nothing that it names is missing: src/core/a.c | f | x * y > 2 | true\n")
assert mistakes([[*DECISION, "sometimes: why"]], set())[0] == 0
assert mistakes([[*DECISION, "why"]], set(), files=("src/core/b.c",))[0] == 0, "a reason for a file that this machine does not compile is accepted"
assert mistakes([["src/core/a.c", "f", "x * z > 2", "true", "why"]], {DECISION})[0] == 2, "a single * in a condition is the operator of C, not a wildcard"
assert mistakes([["src/core/*", "*", "x **", "*", "why"]], {DECISION})[0] == 0
assert len(decisions.reasons_of(os.path.join(root, "docs/qualification/coverage-reasons.csv"))) > 0
