# SPDX-License-Identifier: Apache-2.0
"""The files of a bundle, for check_claims.py: a claim of the page can read only the files to which it links. Also the
forms of figures in the page, and values of cases that several rules need."""
import csv
import io
import json
import os
import re

from claims_page import WrongClaim

BAD = ["differs", "failed", "crashed", "timed out"]


class Bundle:
    """The files of a bundle, unchanged, and the counts of their contents."""

    def __init__(self, folder):
        self.folder, self.made = folder, {}

    def once(self, key, make):
        if key not in self.made:
            self.made[key] = make()
        return self.made[key]

    def raw(self, name):
        def read():
            with open(os.path.join(self.folder, name), "rb") as file:
                return file.read()
        return self.once(("raw", name), read)

    def names(self):
        def walk():
            found = set()
            for top, _, names in os.walk(self.folder):
                found |= {os.path.relpath(os.path.join(top, n), self.folder) for n in names}
            return found
        return self.once("names", walk)

    def parsed(self, name):
        def parse():
            text = self.raw(name).decode()
            if name.endswith(".jsonl"):
                return [json.loads(line) for line in text.splitlines()]
            if name.endswith(".csv"):
                return list(csv.DictReader(io.StringIO(text)))
            return json.loads(text)
        return self.once(("parsed", name), parse)

    def leaves(self, name):
        """Returns every text and number of a JSON file."""
        def walk(value, into):
            if isinstance(value, dict):
                for one in value.values():
                    walk(one, into)
            elif isinstance(value, list):
                for one in value:
                    walk(one, into)
            else:
                into.add(str(value))
            return into
        return self.once(("leaves", name), lambda: walk(self.parsed(name), set()))


class Claim:
    """A section that is being checked. It can open files only through its links."""

    def __init__(self, bundle, section):
        self.bundle, self.section = bundle, section

    def file(self, block, name):
        if name not in block.links and name not in self.section.sources:
            raise WrongClaim("%s: states a value of %s, but links to %s" % (block, name, ", ".join(block.links + self.section.sources) or "nothing"))
        if name not in self.bundle.names():
            raise WrongClaim("%s: links to %s, which does not exist" % (block, name))
        return self.bundle.parsed(name) if name.endswith((".json", ".jsonl", ".csv")) else self.bundle.raw(name)

    def leaves(self, block, name):
        self.file(block, name)
        return self.bundle.leaves(name)


def same(block, got, expected):
    if got != expected:
        raise WrongClaim("%s: states %r; the value in the linked file is %r" % (block, got, expected))


def number(text):
    if not re.fullmatch(r"-?\d{1,3}(,\d{3})*", text):
        raise WrongClaim("%r is not a number in the form of the page" % text)
    return int(text.replace(",", ""))


def commas(value):
    return "{:,}".format(value)


def words(text):
    return " ".join(text.split())


def many(value, what):
    return "%s %s%s" % (commas(value), what, "" if value == 1 else "s")


def backends_of(protocol):
    return protocol["backends"]


def verdict_of(case, backend):
    return case["results"].get(backend, {}).get("verdict", "")


def refused(case):
    return any(r["stage"] == "failed" for r in case["reference"])


def findings_of(protocol, cases):
    """Returns [(number, case, index of the backend, its result)], numbered as in anomalies.csv."""
    found = []
    for case in cases:
        for s, backend in enumerate(backends_of(protocol)):
            if s and verdict_of(case, backend["name"]) in BAD:
                found.append((len(found) + 1, case, s, case["results"][backend["name"]]))
    return found


def own_words(protocol):
    said = []
    for f in protocol.get("user", {}).get("files", []):
        said += ["--" + f["option"], "builtin:" + f["builtin"] if "builtin" in f else "FILE"]
    return said + protocol.get("user", {}).get("how", [])


# ------------------------------------------------------------------- rules
#
# A rule consists of the section, the tag, a pattern for the text, and a function that computes
# the groups.

RULES = []


def rule(section, tag, pattern):
    def add(function):
        RULES.append((section, tag, re.compile(pattern), function))
        return function
    return add


def expect(*values):
    return [v if isinstance(v, str) else commas(v) for v in values]
