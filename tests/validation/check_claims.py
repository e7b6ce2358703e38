#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every claim of a bundle's report.html follows from a file to which it links.

    report.html --parsed--> headings, sentences, rows, pictures
        each: from the files to which it or its section links, and from no other,
        its expected text is computed again here --> the text agrees, including every figure
A sentence with a figure or with bold text is also a failure if this program cannot compute it.
Therefore no claim can be added without a file that supports it. A picture in the page must have
the bytes of the file to which it links. Each link must lead to a file of the bundle, and each file must have a
link.

Then the check itself is tested: one digit of one figure is changed at a time, for figures from
all parts of the page. Each time this program must report a failure.

    OST_BUNDLE=DIR  an existing bundle (default: some small ones are made)
    OST_FIGURES=N   number of figures to change in each report
                    (default 20; OST_TEST_LONG=1: all)
    OST_SEED=N      seed that selects them (default: from the clock, printed)

The modules claims_*.py contain the parser of the page, the files of the bundle, and the rules by which claims are
computed again.

Covers: REQ-REPORT-CLAIMS
"""
import base64
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import claims_evidence  # noqa: E402, F401  registers its rules
import claims_results  # noqa: E402, F401
from claims_bundle import RULES, Bundle, Claim, same  # noqa: E402
from claims_page import Page, WrongClaim, sections_of  # noqa: E402

OSTEON = os.environ.get("OSTEON", os.path.join(os.getcwd(), "osteon"))


# Phrases that contain figures but make no claim about this bundle.
METHOD = re.compile(r"SHA-256|SPDX 2\.3|&#\d+;")


def is_claim(block):
    return bool(re.search(r"\d", METHOD.sub("", block.text)) or block.bold or block.tag in ("tr", "pre"))


# Bold phrases that are not outcomes: explained terms and headings of tables.
EXPLAINED = {"case scalar reference", "Tester", "Reviewer"}


def check(bundle, text):
    """Returns a list of the problems, one line each."""
    problems, linked = [], set()
    try:
        page = Page(text)
        sections = sections_of(page)
    except WrongClaim as e:
        return [str(e)]
    for section in sections:
        claim = Claim(bundle, section)
        for block in section.blocks:
            for link in block.links:
                if link.startswith("#"):
                    if link[1:] not in page.ids:
                        problems.append("%s: links to %s, which does not exist in the page" % (block, link))
                elif link.startswith("data:image/png;base64,"):
                    files = [x for x in section.blocks[section.blocks.index(block) + 1].links]
                    if not files or bundle.names().isdisjoint(files) or base64.b64decode(link[22:]) != bundle.raw(files[0]):
                        problems.append("%s: the picture differs from the file %s" % (block, files))
                elif link not in bundle.names():
                    problems.append("%s: links to %s, which is not in the bundle" % (block, link))
                else:
                    linked.add(link)
            try:
                for name, tag, pattern, function in RULES:
                    if name != section.name or block.tag not in tag.split("|"):
                        continue
                    match = pattern.fullmatch(block.text) if pattern.pattern else True
                    if not match:
                        continue
                    expected = function(claim, block, match)
                    block.used = True
                    if expected is not None:
                        same(block, list(match.groups()), expected)
                    break
            except WrongClaim as e:
                problems.append(str(e))
                block.used = True
            except (LookupError, AttributeError, ValueError, TypeError, StopIteration) as e:
                problems.append("%s: cannot be computed from the files: %r" % (block, e))
                block.used = True
            if not block.used and is_claim(block) and block.bold not in EXPLAINED:
                problems.append("%s: no rule of this test computes this claim" % block)
    left = bundle.names() - linked - {"report.html"}
    if any(not n.startswith("signatures/") for n in left):
        problems.append("files that the page does not link to: %s" % ", ".join(sorted(left)))
    return problems


# ------------------------------------------------- test of the check itself

def figures_of(text):
    """Returns the position of one digit of each visible figure. A figure is visible if it is in the body, between tags."""
    body = text.index("<body")
    places = []
    for between in re.finditer(r">([^<]+)<", text[body:]):
        if text[:body + between.start()].endswith("</style"):
            continue
        for figure in re.finditer(r"\d[\d,]*", METHOD.sub(lambda m: "x" * len(m.group(0)), between.group(1))):
            places.append(body + between.start(1) + figure.end() - 1 - (figure.group(0)[-1] == ","))
    return places


def changed_digit(text, at):
    return text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1:]


def context(text, at):
    return re.sub(r"\s+", " ", re.sub(r"data:image[^\"]*", "", text[max(0, at - 60):at + 40]))


def examine(folder, rng, figures):
    bundle = Bundle(folder)
    with open(os.path.join(folder, "report.html"), encoding="utf-8") as file:
        text = file.read()
    problems = check(bundle, text)
    if problems:
        return problems
    lean = re.sub(r'src="data:[^"]*"', 'src="#not-shown"', text)  # the pictures have already been compared
    places = figures_of(lean)
    chosen = places if figures is None or figures >= len(places) else sorted(rng.sample(places, figures))
    for at in chosen:
        if not check(bundle, changed_digit(lean, at)):
            problems.append("the changed digit in %r is not detected; it became %s" % (context(lean, at), changed_digit(lean, at)[at]))
    print("%s: all claims are correct; %d figures, one digit changed in each of %d figures, %d changes not detected" % (os.path.basename(folder), len(places), len(chosen), len(problems)))
    return problems


def made(scratch):
    """Makes small bundles with files of the user, with equal and different results. With OST_TEST_LONG also makes three
    further bundles: one in which nothing was compared, one of a complete tier, and one with margins of every stage."""
    build = os.getcwd()
    one = "cpu:isa=scalar,threads=1"
    ct = os.path.join(scratch, "ct.txt")
    with open(ct, "w") as file:
        file.write("".join("%g %g %g %d\n" % (i * 0.5, j * 0.5, k * 0.5, i * 40 + j - k * 3) for k in range(12) for j in range(14) for i in range(16)))
    long, plugin = os.environ.get("OST_TEST_LONG"), os.path.join(build, ".libs", "thesis_f32.so")
    own = ["--only", "user", "--ct", ct, "--tool", "builtin:peg"]
    wanted = {"own": own + ["--backends", one + ";cl:platform=77", "--cubic", "0.4"]}
    if os.path.exists(plugin):
        wanted["own-differs"] = own + ["--backends", one + ";plugin:" + plugin, "--cubic", "0.7"]
    suite = os.path.join(scratch, "suite-of-tests")
    os.makedirs(os.path.join(suite, "tests"))
    with open(os.path.join(suite, "tests", "run-test"), "w") as file:
        file.write("#!/bin/sh\ncase $1 in *core*) exit 0 ;; *api*) echo 3 of 4; exit 5 ;; *) echo not built; exit 77 ;; esac\n")
    os.chmod(file.name, 0o755)
    wanted["suite"] = ["--only", "import/0", "--backends", one, "--with-suite", suite]
    if long:
        wanted["alone"] = ["--only", "import/0", "--backends", "ref"]
        wanted["whole"] = ["--cpu-only"]
        if os.path.exists(plugin):
            wanted["poses-differ"] = ["--tier", "standard", "--only", "poses/1", "--backends", "plugin:" + plugin]
            wanted["whole-differs"] = ["--backends", one + ";plugin:" + plugin]
    for name, arguments in wanted.items():
        folder = os.path.join(scratch, name)
        status = subprocess.run([OSTEON, "validate", "--out", folder, "--quiet"] + arguments, stderr=subprocess.DEVNULL).returncode
        if status not in (0, 1, 3) or not os.path.isdir(folder):
            raise SystemExit("the bundle '%s' was not made: status %d" % (name, status))
        yield folder


def main():
    seed = int(os.environ.get("OST_SEED", time.time_ns() & 0xffffffff))
    figures = int(os.environ["OST_FIGURES"]) if "OST_FIGURES" in os.environ else None if os.environ.get("OST_TEST_LONG") else 20
    print("seed %d" % seed)
    rng, problems = random.Random(seed), []
    scratch = tempfile.mkdtemp()
    try:
        for folder in [os.environ["OST_BUNDLE"].rstrip("/")] if os.environ.get("OST_BUNDLE") else made(scratch):
            problems += ["%s: %s" % (os.path.basename(folder), p) for p in examine(folder, rng, figures)]
    finally:
        shutil.rmtree(scratch)
    for text in problems[:40]:
        print("FAIL: " + text[:600])
    print("%d problems" % len(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
