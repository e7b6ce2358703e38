#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the public interface is documented.

Every exported function (OST_API) and every struct and enum of include/osteon has a comment directly
before it. A function's comment begins with a capital letter, that is, with a sentence. A type needs no
comment if each of its members has one.

Usage: tests/api/check_documented.py [FOLDER]    (default: include/osteon of the source tree)
"""
# Covers: REQ-API
import glob
import os
import re
import sys


def comment_before(lines, at):
    """Returns the text of the comment that ends directly before a line, or None."""
    if at == 0 or not lines[at - 1].endswith("*/"):
        return None
    first = at - 1
    while first > 0 and not lines[first].lstrip().startswith("/*"):
        first -= 1
    if not lines[first].startswith("/*"):
        return None  # the comment belongs to the previous declaration
    return " ".join(line.strip(" */") for line in lines[first:at]).strip()


def members_documented(lines, at):
    """Returns True if each member of the type whose first line this is has a comment."""
    if "}" in lines[at]:
        return False  # a type of one line has no room for its members' comments
    body = []
    for line in lines[at + 1:]:
        if line.startswith("}"):
            break
        body.append(line)
    members = [i for i, line in enumerate(body) if re.search(r"[;,]\s*(/\*|$)|^\s*OST_\w+\s*(/\*|$)", line)
               and not line.strip().startswith(("/*", "*"))]
    return bool(members) and all("/*" in body[i] or (i and body[i - 1].endswith("*/")) for i in members)


def faults_of(path):
    """Yields a line for each fault of a header. The last line contains the number of checked declarations."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    for at, line in enumerate(lines):
        function = re.match(r"OST_API .*?\b(ost_\w+)\(", line)
        kind = re.match(r"typedef (?:struct|enum|union) (ost_\w+) \{", line)
        if not function and not kind:
            continue
        name = (function or kind).group(1)
        text = comment_before(lines, at)
        if text is None and (function or not members_documented(lines, at)):
            yield f"{path}:{at + 1}: {name} has no comment", name
        elif function and not re.match(r"[A-Z]", text):
            yield f"{path}:{at + 1}: the comment of {name} is no sentence: {text[:60]}", name
        else:
            yield "", name


def main():
    """Prints a line for each fault. Returns the exit status."""
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.environ.get("srcdir", "."), "include", "osteon")
    results = [result for path in sorted(glob.glob(os.path.join(folder, "*.h"))) for result in faults_of(path)]
    faults = [text for text, _ in results if text]
    for text in faults:
        print(text)
    print(f"check_documented: {len(results)} functions and types, {len(faults)} faults")
    return 1 if faults or not results else 0


if __name__ == "__main__":
    sys.exit(main())
