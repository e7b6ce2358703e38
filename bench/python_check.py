#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the time of osteon.check per case, next to that of `osteon compare` for the same cases.

    PYTHON bench/python_check.py [FAMILY...]        the package osteon must be installed

The function is the numpy implementation of tests/python/removal.py. Its time is subtracted, so that the overhead of
the comparison remains: both worlds, the reports, and the comparison of all voxels after each event.
"""
import os
import subprocess
import sys
import time

import osteon
from osteon.cases import command

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "tests", "python"))
from removal import removal  # noqa: E402  # the path is set first


def main():
    print(f"{'ms per case':12}{'cases':>6}{'events':>8}{'generate':>10}{'check':>8}{'function':>10}{'osteon compare':>16}")
    for family in sys.argv[1:] or ("poses", "sweep", "session"):
        remove, spent = removal(), [0.0]

        def timed(bone, tool, event, remove=remove, spent=spent):
            begin = time.perf_counter()
            touched = remove(bone, tool, event)
            spent[0] += time.perf_counter() - begin
            return touched

        begin = time.perf_counter()
        cases = list(osteon.campaign_cases(family))
        made = time.perf_counter() - begin
        begin = time.perf_counter()
        result = osteon.check(timed, cases)
        result.raise_if_different()
        checked = time.perf_counter() - begin - spent[0]
        begin = time.perf_counter()
        subprocess.run([command(), "compare", "cpu:threads=1", "--only", family], stdout=subprocess.DEVNULL, check=True)
        compared = time.perf_counter() - begin
        events = sum(case.events for case in result.cases)
        row = [1e3 * t / len(cases) for t in (made, checked, spent[0], compared)]
        print(f"{family:12}{len(cases):6}{events:8}{row[0]:10.0f}{row[1]:8.0f}{row[2]:10.0f}{row[3]:16.0f}")


if __name__ == "__main__":
    main()
