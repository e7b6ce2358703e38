#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the public interface is documented.

 - Every exported function (OST_API) and every struct and enum of include/osteon has a comment directly
   before it. A function's comment begins with a capital letter, that is, with a sentence. A type needs no
   comment if each of its members has one.
 - The comment of a function that returns an ost_status names its errors: a code OST_ERR_..., or the word
   "errors" with the name of a function that has the same errors, or the word "errors" if the comment at
   the head of the header names the codes.
 - The comment of a function that creates an object names the function that frees the object. Such a
   function has a parameter that is a pointer to a pointer, or a parameter `out` of a type with a free
   function.
 - The comment at the head of each header contains a thread rule ("Threads: ...").

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


def head_of(lines):
    """Returns the text of the comment at the head of a header: the first comment after the SPDX line."""
    for at, line in enumerate(lines):
        if at > 0 and line.endswith("*/"):
            return comment_before(lines, at + 1) or ""
    return ""


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


def declaration_at(lines, at):
    """Returns a declaration, which may extend over several lines, as one line."""
    last = at
    while ";" not in lines[last]:
        last += 1
    return " ".join(line.strip() for line in lines[at:last + 1])


def names_errors(text, head):
    """Returns True if a function's comment names the errors of the function."""
    if "OST_ERR_" in text:
        return True
    if re.search(r"\berrors\b[^.]*\bost_\w+", text):
        return True  # "The errors are those of ost_..."
    return "OST_ERR_" in head and bool(re.search(r"\berrors\b", text))


def creates_object(declaration, freed_types):
    """Returns True if a function stores a new object, which the caller must free, through a parameter."""
    for const, kind, stars, name in re.findall(r"(const )?(\w+) (\*+)(\w+)[,)]", declaration):
        if not const and (stars == "**" or (stars == "*" and name == "out" and kind in freed_types)):
            return True
    return False


def names_free_function(text):
    """Returns True if a comment names a function that frees an object."""
    return bool(re.search(r"\bost_\w+_(free|close)\b|\bfree\(\)", text))


def faults_of(path, lines, freed_types):
    """Yields a fault, or "", for each property of a header that is checked."""
    head = head_of(lines)
    yield "" if re.search(r"\bThreads[:.]", head) else f"{path}:2: the head of the header states no thread rule"
    for at, line in enumerate(lines):
        function = re.match(r"OST_API (.*?)\b(ost_\w+)\(", line)
        kind = re.match(r"typedef (?:struct|enum|union) (ost_\w+) \{", line)
        if not function and not kind:
            continue
        name = function.group(2) if function else kind.group(1)
        where = f"{path}:{at + 1}"
        text = comment_before(lines, at)
        if text is None:
            missing = function or not members_documented(lines, at)
            yield f"{where}: {name} has no comment" if missing else ""
            continue
        if not function:
            yield ""
            continue
        yield "" if re.match(r"[A-Z]", text) else f"{where}: the comment of {name} is no sentence: {text[:60]}"
        if function.group(1) == "ost_status ":
            yield "" if names_errors(text, head) else f"{where}: the comment of {name} names no error (OST_ERR_...)"
        if creates_object(declaration_at(lines, at), freed_types) and not names_free_function(text):
            yield f"{where}: the comment of {name} does not name the function that frees the result"


def main():
    """Prints a line for each fault. Returns the exit status."""
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.environ.get("srcdir", "."), "include", "osteon")
    headers = {}
    for path in sorted(glob.glob(os.path.join(folder, "*.h"))):
        with open(path, encoding="utf-8") as file:
            headers[path] = file.read().split("\n")
    freed_types = set(re.findall(r"^OST_API \w+ ost_\w+_(?:free|close)\((\w+) \*",
                                 "\n".join("\n".join(lines) for lines in headers.values()), re.MULTILINE))
    results = [result for path, lines in headers.items() for result in faults_of(path, lines, freed_types)]
    faults = [text for text in results if text]
    for text in faults:
        print(text)
    print(f"check_documented: {len(headers)} headers, {len(results)} properties, {len(faults)} faults")
    return 1 if faults or not results else 0


if __name__ == "__main__":
    sys.exit(main())
