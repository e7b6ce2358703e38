# SPDX-License-Identifier: Apache-2.0
"""Checks that the package calls every public function of the C library, except those listed in docs/guide/python.md."""
import os
import re
from pathlib import Path

HEADING = "## Functions of the C library that are left out"


def read(pattern):
    """Returns the text of the files of the source tree that match a pattern."""
    files = sorted(Path(os.environ["OSTEON_SOURCE"]).glob(pattern))
    assert files, pattern
    return "\n".join(file.read_text(encoding="utf-8") for file in files)


def public():
    """Returns the functions that the headers declare. A declaration may extend over several lines."""
    return set(re.findall(r"\bOST_API\b[^;(]*?\b(ost_\w+)\(", read("include/osteon/*.h")))


def called():
    """Returns the functions that Python calls, and those that the C code of the extension module calls."""
    loop = re.search(r'^LOOP_SOURCE = """(.*?)^"""', read("python/build_osteon.py"), re.M | re.S).group(1)
    return (set(re.findall(r"\blib\.(ost_\w+)", read("python/osteon/*.py")))
            | set(re.findall(r"(?<!osteon_py_)\b(ost_\w+)\(", loop)))


def left_out():
    """Returns the functions in the first column of the table of the guide, in their order."""
    section = read("docs/guide/python.md").split(HEADING + "\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`.*?) \| .*? \|$", section, re.M)
    return [name for row in rows for name in re.findall(r"`(ost_\w+)`", row)]


def test_every_function_is_called_or_listed():
    assert len(public()) > 250 and len(called()) > 150
    assert sorted(public() - called() - set(left_out())) == []


def test_list_of_the_guide():
    listed = left_out()
    assert sorted(set(listed) & called()) == []
    assert sorted(set(listed) - public()) == []
    assert len(listed) == len(set(listed))
