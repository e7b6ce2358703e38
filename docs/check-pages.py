#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the pages of the documents (*.md at the top and in docs, examples, presets).

  1  a relative link leads to a file or folder that exists, and its #anchor to a heading of that page
  2  docs/README.md, or the README.md of its folder, links every page of docs

Usage: docs/check-pages.py [SRCDIR]
"""
import glob
import os
import re
import sys


def anchors(path):
    """Returns the anchors that a browser of the repository gives to the headings of a page."""
    with open(path, encoding="utf-8") as file:
        headings = re.findall(r"^#+ (.*)$", file.read(), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(path):
    """Yields (line, target file, anchor) of each relative link of a page."""
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
                if not re.match(r"[a-z]+:", target):
                    name, _, anchor = target.partition("#")
                    yield number, os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path, anchor


def main():
    """Prints a line for each fault. Returns the exit status."""
    os.chdir(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("srcdir", "."))
    pages = sorted(glob.glob("*.md") + [page for folder in ("docs", "examples", "presets")
                                        for page in glob.glob(folder + "/**/*.md", recursive=True)])
    faults = []
    count = 0
    for page in pages:
        for number, target, anchor in links(page):
            count += 1
            if not os.path.exists(target):
                faults.append(f"{page}:{number}: {target} does not exist")
            elif anchor and target.endswith(".md") and anchor not in anchors(target):
                faults.append(f"{page}:{number}: {target} has no heading #{anchor}")
    listed = {target for page in pages if page.startswith("docs/") and page.endswith("/README.md")
              for _, target, _ in links(page)}
    faults += [f"{page}: docs/README.md has no link to it" for page in pages
               if page.startswith("docs/") and page != "docs/README.md" and page not in listed]
    for fault in faults:
        print(f"check-pages: {fault}")
    print(f"check-pages: {len(pages)} pages, {count} links, {len(faults)} faults")
    return 1 if faults or not count else 0


if __name__ == "__main__":
    sys.exit(main())
