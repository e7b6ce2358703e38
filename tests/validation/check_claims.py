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
Covers: REQ-REPORT-CLAIMS
"""
import base64
import csv
import html.parser
import io
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

OSTEON = os.environ.get("OSTEON", os.path.join(os.getcwd(), "osteon"))
BLOCKS = {"title", "h1", "h2", "h3", "p", "li", "tr", "pre", "figure", "figcaption", "label", "div", "span"}
VOID = {"br", "img", "input", "meta", "path", "link"}
BAD = ["differs", "failed", "crashed", "timed out"]


class WrongClaim(Exception):
    """A claim of the page that does not follow from the files to which it links."""


# ------------------------------------------------------------------- the page

class Block:
    """A sentence or a row, with the links that it contains."""

    def __init__(self, tag, attributes):
        self.tag, self.attributes = tag, attributes
        self.text, self.links, self.bold, self.cells, self.used = "", [], "", [], False

    def clean(self):
        self.text = " ".join(self.text.split())
        self.bold = " ".join(self.bold.split())
        self.cells = [" ".join(c.split()) for c in self.cells]

    def __str__(self):
        return "<%s> %s" % (self.tag, " | ".join(self.cells) or self.text)


class Page(html.parser.HTMLParser):
    """Collects the blocks of the page in their order. A text belongs to its innermost block."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.blocks, self.open, self.tags, self.ids, self.skip = [], [], [], set(), 0
        self.feed(text)
        if self.tags:
            raise WrongClaim("report.html: <%s> is not closed" % self.tags[-1])
        for block in self.blocks:
            block.clean()

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if "id" in attributes:
            self.ids.add(attributes["id"])
        if tag == "style":
            self.skip += 1
        if tag in BLOCKS and not (tag == "title" and self.open) and not (tag == "span" and self.open and self.open[-1].tag in ("figcaption", "div", "p")):
            self.open.append(Block(tag, attributes))
            self.blocks.append(self.open[-1])
        elif tag == "a":
            self.open[-1].links.append(attributes["href"])
        elif tag in ("td", "th"):
            self.open[-1].cells.append("")
        elif tag in ("br", "title"):
            self.handle_data(" ")
        elif tag in ("b", "strong") and self.open:
            self.open[-1].bold += " "
        elif tag == "img":
            self.open[-1].links.append(attributes["src"])
            self.open[-1].text += attributes["alt"]
        if tag not in VOID:
            self.tags.append(tag)

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.tags or self.tags[-1] != tag:
            raise WrongClaim("report.html: </%s> closes the element %s" % (tag, self.tags[-1:]))
        self.tags.pop()
        if tag == "style":
            self.skip -= 1
        if self.open and self.open[-1].tag == tag and not (tag == "span" and self.open[-1].tag != "span"):
            self.open.pop()

    def handle_data(self, data):
        if self.skip or not self.open:
            return
        block = self.open[-1]
        block.text += data
        if block.cells:
            block.cells[-1] += data
        if any(t in ("b", "strong") for t in self.tags):
            block.bold += data


class Section:
    def __init__(self, name):
        self.name, self.blocks, self.sources = name, [], []


def sections_of(page):
    """Splits the page at its headings. The sources of a section are the links in its lines 'From ...'."""
    sections = [Section("")]
    for block in page.blocks:
        if block.tag == "h2":
            sections.append(Section(block.text))
            block.used = True
        sections[-1].blocks.append(block)
        if block.tag == "p" and block.attributes.get("class") == "from":
            sections[-1].sources += block.links
    return sections


# -------------------------------------------------------------- the bundle

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


@rule("", "title|h1", r"Backend equivalence verification report")
def _(c, b, m):
    return []


@rule("", "div", r"✓ EQUALEvery backend's results are byte-identical to the reference's: ([\d,]+) results?, (0) differing bytes\. From results\.json")
def _(c, b, m):
    r = c.file(b, "results.json")
    same(b, "EQUAL", r["verdict"])
    same(b, True, r["evidence"])
    return expect(r["results"]["equal"], sum(r["results"][k] for k in BAD))


@rule("", "div", r"⚠ REDUCED RUN: NO EVIDENCE ?Equal in (?:all|the) ([\d,]+) results? that (?:was|were) compared; too little was compared for evidence\. From results\.json")
def _(c, b, m):
    r = c.file(b, "results.json")
    same(b, "EQUAL", r["verdict"])
    same(b, False, r["evidence"])
    same(b, 0, sum(r["results"][k] for k in BAD))
    return expect(r["results"]["equal"])


@rule("", "div", r"⚠ NO VERDICT: NOTHING WAS COMPARED ?No backend other than the reference ran a case that the reference accepted\. From results\.json")
def _(c, b, m):
    same(b, (0, "NOT COMPARED"), tuple(c.file(b, "results.json")[k] for k in ("compared", "verdict")))
    return []


@rule("", "div", r"✗ NOT EQUAL ?In ([\d,]+) of ([\d,]+) results?, the result of a backend differs from the reference's\.(?: ?The other (backend is equal in all its cases|[\d,]+ backends are equal in all their cases)\.)?"
                 r"( This was also a reduced run\.)? From results\.json(?: and cases\.jsonl)?")
def _(c, b, m):
    r, cases, protocol = c.file(b, "results.json"), c.file(b, "cases.jsonl"), c.bundle.parsed("protocol.json")
    bad = sum(r["results"][k] for k in BAD)
    same(b, "NOT EQUAL", r["verdict"])
    others = 0
    for backend in backends_of(protocol)[1:]:
        verdicts = [verdict_of(case, backend["name"]) for case in cases]
        others += "equal" in verdicts and not any(v in BAD for v in verdicts)
    said = None if not others else "backend is equal in all its cases" if others == 1 else "%s are equal in all their cases" % many(others, "backend")
    return expect(bad, bad + r["results"]["equal"]) + [said, None if r["evidence"] else " This was also a reduced run."]


@rule("", "li", r"(.*): ([\d,]+) of ([\d,]+) cases?")
def _(c, b, m):
    box = next(x for x in c.section.blocks if x.tag == "div")
    cases, protocol = c.file(box, "cases.jsonl"), c.bundle.parsed("protocol.json")
    for backend in backends_of(protocol)[1:]:
        verdicts = [verdict_of(case, backend["name"]) for case in cases]
        bad, good = sum(v in BAD for v in verdicts), verdicts.count("equal")
        if bad and [backend["what"]] + expect(bad, bad + good) == list(m.groups()):
            return list(m.groups())
    raise WrongClaim("%s: names no backend of cases.jsonl" % b)


@rule("", "li", r"Sensitivity: ([\d,]+) of ([\d,]+) deliberate mistakes, made in a second implementation and in no backend, were detected; "
                r"of (\d+) kinds (\d+) changed nothing in this tier; ([\d,]+) false alarms? \(sensitivity\.json\)\.")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    silent = [k["name"] for k in s["kinds"] if not k["changed"]]
    same(b, s["kinds_silent"], silent)
    return expect(s["detected"], s["changed"]) + [str(len(s["kinds"])), str(len(silent))] + expect(s["false_alarms"])


@rule("", "li", r"Mistakes that all backends could have in common: the reference passed ([\d,]+) of ([\d,]+) checks by hand, by volume and by law \(common\.json\)\.")
def _(c, b, m):
    passed = [x["passed"] for x in c.file(b, "common.json")["checks"]]
    return expect(sum(passed), len(passed))


@rule("", "li", r"Limits: ([\d,]+) points are not shown; they are listed below \(deviations\.csv\)\.")
def _(c, b, m):
    return expect(len(c.file(b, "deviations.csv")))


@rule("", "p", r"osteon simulates the reaming of bone for surgery\. .* for ([\d,]+ backends?) on ([\d,]+ cases?), against the scalar reference\. osteon (\S+), arithmetic version (\d+); tier (\w+), seed (\d+) "
               r"\(protocol\.json\)\. The times are in times\.json; the log of all steps is audit\.log\.")
def _(c, b, m):
    p = c.file(b, "protocol.json")
    for name in ("times.json", "audit.log"):
        c.file(b, name)
    ran = sum(x["available"] for x in backends_of(p)[1:])
    return [many(ran, "backend"), many(len(c.bundle.parsed("cases.jsonl")), "case"), p["version"], str(p["arithmetic"]), p["tier"], p["seed"]]


def table_of(backend, cases, first):
    def cell(some):
        if first:
            return str(len(some))
        equal = sum(verdict_of(x, backend["name"]) == "equal" and not refused(x) for x in some)
        bad = sum(verdict_of(x, backend["name"]) not in ("equal", "not run") for x in some)
        return "%d of %d" % (equal, len(some)) + (" %d NOT equal" % bad if bad else "")
    return cell


@rule("Comparison of the backends", "tr", r"")
def _(c, b, m):
    protocol, cases = c.file(b, "protocol.json"), c.file(b, "cases.jsonl")
    families = c.bundle.once("families", lambda: sorted({x["id"].split("/")[0] for x in cases}))
    if b.cells[0] == "Backend, device, driver":
        same(b, set(b.cells[1:-1]), set(families))
        same(b, b.cells[-1], "all cases")
        c.columns = b.cells[1:-1]
        return None
    s = next((i for i, x in enumerate(backends_of(protocol)) if b.cells[0] == words("%s %s" % (x["what"], x["name"]))), None)
    if s is None:
        raise WrongClaim("%s: names no backend of protocol.json" % b)
    one = backends_of(protocol)[s]
    if not one["available"]:
        same(b, b.cells[1:], [words("not run: " + one["reason"])])
        return None
    cell = table_of(one, cases, s == 0)
    groups = [[x for x in cases if x["id"].split("/")[0] == f] for f in c.columns] + [cases]
    same(b, b.cells[1:], [cell(g) for g in groups])
    return None


@rule("Comparison of the backends", "p", r"(import|mesh|poses|sweep|session|operation|static|small|user): .*\.")
def _(c, b, m):
    for part in b.text[:-1].split("; "):
        name, about = part.split(": ", 1)
        same(b, about, words(c.file(b, "protocol.json")["families"][name]))
    return None


@rule("Comparison of the backends", "p", r"Criterion for passing, fixed before anything ran: (.*)")
def _(c, b, m):
    frozen = c.bundle.once("frozen", lambda: __import__("hashlib").sha256(c.bundle.raw("protocol.json")).hexdigest())
    log = c.file(b, "audit.log").decode().splitlines()
    places = {line.split("\t")[2]: (i, line) for i, line in enumerate(log)}
    same(b, places["protocol frozen"][1].split("\t")[3], frozen)
    same(b, True, places["protocol frozen"][0] < min(places[k][0] for k in places if k in ("results", "merged")))
    return [words(c.file(b, "protocol.json")["accept"])]


@rule("The user's own files", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "File":
        return None
    f = c.file(b, "protocol.json")["user"]["files"][int(b.cells[0]) - 1]
    kind = "CT" if f["option"] == "ct" else f["option"]
    if "builtin" in f:
        same(b, b.cells[1:], [kind, "-", "built in: " + f["builtin"]])
        return None
    same(b, b.cells[1:], [kind, commas(f["bytes"]), f["sha256"]])
    same(b, True, any(r["sha256"] == f["sha256"] and int(r["bytes"] or 0) == f["bytes"] for r in c.file(b, "inputs.csv")))
    return None


@rule("The user's own files", "li", r"(user/\d+): .*")
def _(c, b, m):
    one = next(x for x in c.file(b, "protocol.json")["user"]["cases"] if x["id"] == m.group(1))
    text = one["id"] + ": "
    if "ct" in one:
        text += "CT %d of %s voxels at %s mm, resampled to %s cubes of %s mm; " % (
            one["ct"], " × ".join(map(str, one["rect_dims"])), " × ".join(one["rect_spacing_mm"]), " × ".join(map(str, one["cubic_dims"])), one["cubic_mm"])
    same(b, b.text, text + many(one["ticks"], "tick") + " of movement")
    return None


@rule("Not shown", "li", r"(.*)")
def _(c, b, m):
    left = [words(x["what was not shown"]) for x in c.file(b, "deviations.csv")]
    same(b, True, m.group(1) in left)
    same(b, [x.text for x in c.section.blocks if x.tag == "li"], left)
    return None


@rule("Pictures", "p", r"Case (operation/0) as the reference computed it: .*")
def _(c, b, m):
    return [next(x["id"] for x in c.file(b, "cases.jsonl") if x["id"] == "operation/0" and x["reference"])]


@rule("Results of the reference", "p", r"([\d,]+ cases?) gave ([\d,]+ records?)\. Each record is compared with that of every backend, in the order of the table; cases\.jsonl contains the SHA-256 digests\.")
def _(c, b, m):
    cases = c.file(b, "cases.jsonl")
    return [many(len(cases), "case"), many(sum(len(x["reference"]) for x in cases), "record")]


@rule("Results of the reference", "tr", r"")
def _(c, b, m):
    cases = c.file(b, "cases.jsonl")
    stages = c.bundle.once("stages", lambda: [r["stage"] for x in cases for r in x["reference"]])
    if b.cells[0] == "Stage":
        same(b, {x.cells[0] for x in c.section.blocks if x.tag == "tr"} - {"Stage"}, set(stages))
        return None
    same(b, b.cells[1], commas(stages.count(b.cells[0])))
    return None


@rule("Differences", "p", r"None\. All compared results are byte-identical to the reference's\.")
def _(c, b, m):
    same(b, [], c.file(b, "anomalies.csv"))
    return []


@rule("Differences", "p", r"([\d,]+) results? differs? from the reference's\. .*")
def _(c, b, m):
    return expect(len(c.file(b, "anomalies.csv")))


@rule("Differences", "p", r"The first (\d+) of (\d+) are listed here\.")
def _(c, b, m):
    return [str(sum(x.tag == "tr" for x in c.section.blocks) - 1), str(len(c.file(b, "anomalies.csv")))]


def where_of(r):
    return r.get("stage", "") + (" %d" % r["item"] if r.get("stage") in ("tick", "collide", "tool") else "")


def what_of(r):
    text = r.get("text", "")
    if "voxel" in r:
        n, size = r["different_voxels"], r.get("chunk_size", 32)
        text = "%s in this record; the first at (%d, %d, %d), chunk (%d, %d, %d) of %d3: %d, the reference has %d" % (
            (many(n, "voxel"),) + tuple(r["voxel"]) + tuple(v // size for v in r["voxel"]) + (size, r["got"], r["reference"]))
    elif "word" in r:
        text = "reported: %s is %d, the reference has %d" % (r["word"], r["got"], r["reference"])
        if "chunk" in r:
            text += "; of chunk (%d, %d, %d) first" % tuple(r["chunk"])
    return text + (" Class %s: %s%s" % (r["class"], r["class_text"], "; " + r["class_hint"] if r["class_hint"] else "") if "class" in r else "")


@rule("Differences", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "No.":
        return None
    protocol, cases = c.bundle.parsed("protocol.json"), c.file(b, "cases.jsonl")
    n, case, s, r = findings_of(protocol, cases)[int(b.cells[0][1:]) - 1]
    same(b, b.cells, ["A%d" % n, "%s %s" % (case["id"], backends_of(protocol)[s]["what"]), r["verdict"], where_of(r), words(what_of(r))])
    same(b, c.file(b, "anomalies.csv")[n - 1]["case"], case["id"])
    return None


ONE_BY_ONE = "Each difference"


@rule(ONE_BY_ONE, "h3", r"A(\d+): (.*)")
def _(c, b, m):
    protocol, cases = c.bundle.parsed("protocol.json"), c.file(b, "cases.jsonl")
    c.finding = findings_of(protocol, cases)[int(m.group(1)) - 1]
    n, case, s, _ = c.finding
    return [str(n), "%s, %s" % (case["id"], backends_of(protocol)[s]["what"])]


@rule(ONE_BY_ONE, "p", r"The reduced case still differs in the same stage and with the same class: (.*) \((cases/\S+\.json)\)\. In the folder of this page:")
def _(c, b, m):
    n, case, s, r = c.finding
    same(b, c.file(b, r["reproduce"])["id"], case["id"])
    return [c.file(b, "cases.jsonl") and words(r["small_case"]), r["reproduce"]]


@rule(ONE_BY_ONE, "pre", r"osteon validate --case (\S+) --backends (\S+|'[^']*')(.*)")
def _(c, b, m):
    n, case, s, r = c.finding
    protocol = c.bundle.parsed("protocol.json")
    said = shlex.split(m.group(0))
    same(b, said[3:6], [r["reproduce"], "--backends", backends_of(protocol)[s]["name"]])
    same(b, said[6:], own_words(protocol) if case["id"].startswith("user/") else [])
    return None


def own_words(protocol):
    said = []
    for f in protocol.get("user", {}).get("files", []):
        said += ["--" + f["option"], "builtin:" + f["builtin"] if "builtin" in f else "FILE"]
    return said + protocol.get("user", {}).get("how", [])


@rule(ONE_BY_ONE, "p", r"Operands that decide voxel \((\d+), (\d+), (\d+)\), computed by the reference\. .*")
def _(c, b, m):
    c.file(b, "cases.jsonl")
    c.operands = iter(c.finding[3]["operands"])
    return [str(v) for v in c.finding[3]["voxel"]]


@rule(ONE_BY_ONE, "tr", r"")
def _(c, b, m):
    one = next(c.operands)
    same(b, b.cells, [words(one["name"]), words(one["value"])])
    return None


@rule(ONE_BY_ONE, "figcaption", r"(Reference: axial, coronal, sagittal|Backend|Difference) (\S+)")
def _(c, b, m):
    n, case, s, r = c.finding
    role = {"R": "reference", "B": "got", "D": "difference"}[m.group(1)[0]]
    same(b, b.links, ["pictures/%s-backend-%d-%s.png" % (re.sub("[^a-z0-9]", "-", case["id"]), s, role)])
    return [m.group(1)] + b.links


@rule(ONE_BY_ONE, "p", r"There are pictures of (\d+) of them and reduced cases of (\d+): .*")
def _(c, b, m):
    results = [r for _, _, _, r in findings_of(c.bundle.parsed("protocol.json"), c.bundle.parsed("cases.jsonl"))]
    return [str(sum(n.endswith("-difference.png") for n in c.bundle.names())), str(sum("reproduce" in r for r in results))]


MARGINS = "Margins of differing decisions"
MARGIN_KEYS = ["voxels", "inherited", "below_threshold", "unexplained", "decided"]


def margin_rows(c, b, what):
    names = {x["what"]: x["name"] for x in backends_of(c.bundle.parsed("protocol.json"))}
    return [r for r in c.file(b, "margins.csv") if r["backend"] == names[what]]


def margin_bins(row):
    return [int(v) for k, v in row.items() if k == "at_0" or k == "more" or k.startswith("below_") and k != "below_threshold"]


@rule(MARGINS, "h3", r"(.*)")
def _(c, b, m):
    c.rows = margin_rows(c, b, m.group(1))
    same(b, True, bool(c.rows))
    return None


@rule(MARGINS, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Stage":
        c.header = b
        return None
    rows = [r for r in c.rows if r["stage"] == b.cells[0]]
    same(b, b.cells[1:6], [commas(sum(int(r[k]) for r in rows)) for k in MARGIN_KEYS])
    most = max(int(r["max_2_20"]) for r in rows)
    decided = sum(int(r["decided"]) for r in rows)
    unit = rows[0]["unit"].split(" ", 1)[1]
    same(b, b.cells[6], "%d.%07d of a %s" % (most >> 20, (most & 0xfffff) * 10000000 >> 20, unit) if decided else "-")
    bins = [sum(x) for x in zip(*[margin_bins(r) for r in rows])] if decided else []
    same(b, b.cells[7].split(), " ".join(many(n, "voxel").replace(",", "") for n in bins if n).split())
    return None


@rule(MARGINS, "p", r"(?:For ([\d,]+) of these voxels, no border explains the other backend's value, so the difference is not only rounding\. ?)?"
                    r"(?:([\d,]+) of these decisions lay farther than 1/1024 of a voxel from the nearest border that could explain them, so the difference is not only rounding\. ?)?"
                    r"(?:([\d,]+) voxels were not measured, because there are too many\. ?)?"
                    r"(?:Decisions within 1/1024 of a voxel of a border: ([\d,]+), which are all measured decisions\. This is consistent with rounding at borders only but does not prove it: "
                    r"another mistake can also have its effect at borders, and the greatest margin is a bound for these cases only\.)?")
def _(c, b, m):
    c.file(b, "margins.csv")
    total = {k: sum(int(r[k]) for r in c.rows) for k in MARGIN_KEYS + ["unmeasured"]}
    near = sum(sum(margin_bins(r)[:11]) for r in c.rows)
    other, far = total["unexplained"] + total["below_threshold"], total["decided"] - near
    only = not other and not total["unmeasured"] and total["decided"] and not far
    return [commas(n) if n else None for n in (other, far, total["unmeasured"])] + [commas(total["decided"]) if only else None]


SENSITIVITY = "Sensitivity proof"
COUNTS = ["injected", "changed", "detected", "localized", "survived"]


@rule(SENSITIVITY, "p", r"The second implementation \(validation/dense\), which is no backend, was run with deliberate mistakes at random positions, and its results were compared in the same way\. ([\d,]+) of the ([\d,]+) mistakes that changed a result were detected and "
                        r"([\d,]+) located; ([\d,]+) false alarms in ([\d,]+) runs without a mistake\. (.*)")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    whole = s["proved"] and s["detected"] == s["changed"] == s["localized"] and not s["false_alarms"]
    return expect(s["detected"], s["changed"], s["localized"], s["false_alarms"], s["clean_runs"]) + [
        "Every mistake that had an effect was detected and located." if whole else "This does not show that mistakes are detected."]


@rule(SENSITIVITY, "tr", r"")
def _(c, b, m):
    s = c.file(b, "sensitivity.json")
    if b.cells[0] in ("Mistakes in", "Mistake"):
        return None
    by_stage = re.fullmatch(r"(\w+), ([\d,]+ kinds?)", b.cells[0])
    if b.cells[0] == "all":
        rows = s["kinds"]
        same(b, b.cells[1:], [commas(s[k]) for k in COUNTS])
    elif by_stage:
        rows = [k for k in s["kinds"] if k["stage"] == by_stage.group(1)]
        same(b, by_stage.group(2), many(len(rows), "kind"))
    else:
        rows = [k for k in s["kinds"] if b.cells[0] == "%s (%s) %s" % (k["name"], k["stage"], k["what"])]
        same(b, len(rows), 1)
    same(b, b.cells[1:], [commas(sum(r[k] for r in rows)) for k in COUNTS])
    return None


@rule(SENSITIVITY, "label", r"Kind by kind: ([\d,]+ kinds?) of mistakes")
def _(c, b, m):
    return [many(len(c.file(b, "sensitivity.json")["kinds"]), "kind")]


@rule(SENSITIVITY, "p", r"Not all detected, or not all located:")
def _(c, b, m):
    same(b, True, any(not k["changed"] == k["detected"] == k["localized"] for k in c.file(b, "sensitivity.json")["kinds"]))
    return []


def machines_of(environment):
    return [("Machine", environment)] if isinstance(environment.get("machine"), str) else [("Machine of shard " + k, v) for k, v in sorted(environment.items())]


@rule("Date and machine", "tr", r"")
def _(c, b, m):
    head, said, source = b.cells
    same(b, b.links, [source])
    if head == "Begun":
        begun = c.bundle.raw(source).decode().split("\n")[0].split("\t")
        same(b, begun[2], "begun")
        same(b, said, begun[1].replace("T", " ").replace("Z", " UTC"))
        return None
    if head == "OpenCL":
        p = c.file(b, source)
        sets = [(x["what"], re.search(r"kernels=(\w+)", x["name"])) for x in backends_of(p)[1:] if x["name"].startswith("cl") and x["available"]]
        rows = [words(what if found and "kernels for" in what else "%s; kernels%s" % (what, " for %sPUs" % found.group(1)[0].upper() if found else ": the set that the device's type chooses"))
                for what, found in sets]
        same(b, said, " ".join(rows) or "no device was compared")
        return None
    machines = machines_of(c.file(b, source))
    if head == "Threads":
        shared = {int(n) for _, e in machines for x in e.get("paths", {}).values() for path, count in x["entered"].items() if count for n in re.findall(r" on (\d+) threads$", path)}
        text = "work was shared by %s threads, according to the backends' counters" % ", ".join(str(n) for n in sorted(shared))
        same(b, said, text if shared else "no backend counted work shared by threads")
    elif head == "Processor":
        same(b, True, said in [words("%s, %s" % (e["processor"] or "not reported by the system", many(e["cores_online"], "core"))) for _, e in machines])
    else:
        e = dict(machines)[head]
        same(b, said, words("%s%s, kernel %s, %s" % (e["host"] + ": " if e.get("host") else "", e["system"], e["kernel"], e["machine"])))
    return None


@rule("Code paths of each backend", "tr", r"")
def _(c, b, m):
    paths = c.file(b, "environment.json")["paths"]
    if b.cells[0] == "Backend":
        return None
    mine = paths[b.cells[0]]
    same(b, b.cells[1:], [str(len(mine["entered"])), str(len(mine["not_entered"])), words(", ".join(mine["not_entered"])) or "none"])
    return None


CHANGES = "Changes since an older bundle"


@rule(CHANGES, "p", r"([\d,]+ cases?) compared by the digests of the reference's results: ([\d,]+) different; ([\d,]+ cases?) not compared; ([\d,]+ verdicts?) of backends changed\. Conclusion: (.*)\.")
def _(c, b, m):
    i = c.file(b, "impact.json")
    r = i["results"]
    return [many(r["compared"], "case"), commas(len(r["differences"])), many(len(r["not_compared"]), "case"), many(len(i["verdicts"]), "verdict"), i["conclusion"]]


@rule(CHANGES, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Changed":
        return None
    i = c.file(b, "impact.json")
    rows = [[kind] + [words(x[k]) for k in ("what", "old", "new")] for kind, key in (("run", "causes"), ("library", "libraries"), ("device", "devices")) for x in i[key]]
    rows += [["requirement", x["what"], "absent" if x["old"] == "absent" else "present",
              "present" if x["old"] == "absent" else "absent" if x["new"] == "absent" else "another text or other tests"] for x in i["requirements"]]
    same(b, True, b.cells in rows)
    return None


COMMON = "Mistakes that all backends could have in common"
ABOUT = {"golden": "by hand", "volume": "by volume"}


@rule(COMMON, "p", r"If every backend made the same mistake, .* (All checks passed|Some checks failed)\. Passed by hand: (\d+) of (\d+); by volume: (\d+) of (\d+); by law: (\d+) of (\d+)\.")
def _(c, b, m):
    checks = c.file(b, "common.json")["checks"]
    sums = []
    for about in ("by hand", "by volume", "by law"):
        mine = [x["passed"] for x in checks if ABOUT.get(x["kind"], "by law") == about]
        sums += [str(sum(mine)), str(len(mine))]
    return ["All checks passed" if all(x["passed"] for x in checks) else "Some checks failed"] + sums


@rule(COMMON, "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Check":
        return None
    rows = [[words(t) for t in ("%s %s" % (x["name"], ABOUT.get(x["kind"], "by law")), x["what"], x["expected"], x["got"], "✓" if x["passed"] else "✗ FAILED")]
            for x in c.file(b, "common.json")["checks"]]
    same(b, True, b.cells in rows)
    return None


@rule(COMMON, "p", r"Not part of this bundle, because these checks need the source tree and its tests \(make check\):")
def _(c, b, m):
    same(b, True, bool(c.file(b, "common.json")["by_the_tests"]))
    return []


@rule(COMMON, "li", r"(.*)")
def _(c, b, m):
    same(b, True, m.group(1) in ["%s (%s)" % (x["what"], x["tests"]) for x in c.file(b, "common.json")["by_the_tests"]])
    return None


@rule("Requirements", "p", r"Of (\d+) requirements, (\d+) have tests, and (\d+) of these are also supported by results in this bundle\. Orphans in both directions: "
                           r"(\d+) requirements without a test, (\d+) tests that no requirement names, (\d+) results that concern no requirement\.")
def _(c, b, m):
    rows = c.file(b, "trace.csv")
    kinds = [r["kind"] for r in rows]
    listed = [r for r in csv.DictReader(io.StringIO(c.file(b, "requirements.csv") and c.bundle.raw("requirements.csv").decode()))]
    tested, untested = kinds.count("requirement"), kinds.count("orphan requirement")
    same(b, tested + untested + kinds.count("orphan test"), len(listed))
    shown = sum(r["kind"] == "requirement" and bool(r["files"]) for r in rows)
    return [str(n) for n in (tested + untested, tested, shown, untested, kinds.count("orphan test"), kinds.count("orphan result"))]


@rule("", "div", r"✗ THE TEST SUITE FAILED ?([\d,]+ tests?) that requirements name failed; they are listed below\. From suite\.json")
def _(c, b, m):
    return [many(sum(t["result"] == "failed" for t in c.file(b, "suite.json")["tests"]), "test")]


@rule("The test suite", "p", r"The programs that requirements name as their tests were run with this campaign: ([\d,]+) passed, ([\d,]+) failed, ([\d,]+) were skipped\. .*")
def _(c, b, m):
    results = [t["result"] for t in c.file(b, "suite.json")["tests"]]
    return expect(*[results.count(r) for r in ("passed", "failed", "skipped")])


@rule("The test suite", "tr", r"")
def _(c, b, m):
    if b.cells[0] == "Test":
        return None
    rows = [[words(x) for x in (t["test"], "✗ FAILED" if t["result"] == "failed" else "skipped", t["reason"])]
            for t in c.file(b, "suite.json")["tests"] if t["result"] != "passed"]
    same(b, True, b.cells in rows)
    return None


@rule("Made with", "tr", r"")
def _(c, b, m):
    tools, devices = c.leaves(b, "tools.json"), c.leaves(b, "devices.json")
    if b.cells[0] in ("Source", "Compiler", "Flags", "Program, SHA-256"):
        build = c.file(b, "tools.json")
        expected = {"Source": "commit", "Compiler": "compiler", "Flags": "cflags"}
        same(b, b.cells[1], words(build["program"]["sha256"] if b.cells[0].startswith("Program") else build["build"][expected[b.cells[0]]]))
        return None
    if b.cells[0] == "Machines":
        same(b, "build" in c.file(b, "tools.json"), False)
        return None
    for one in c.file(b, "devices.json")["opencl"]["devices"]:
        version = one.get("driver_says", {}).get("CL_DEVICE_VERSION", "")
        says = (version + "; " if version else "") + (one.get("fingerprint") or one.get("reason", ""))
        if b.cells == [words(t) for t in ("%s %s" % (one.get("name") or one.get("platform"), one["backend"]), says)]:
            return None
    raise WrongClaim("%s: names no device of devices.json" % b)


@rule("Made with", "p", r"(\d+) libraries were loaded, drivers included\. .*")
def _(c, b, m):
    return [str(len(c.file(b, "tools.json").get("libraries", [])))]


@rule("Verification and repetition", "pre", r"osteon verify \.")
def _(c, b, m):
    return []


@rule("Verification and repetition", "pre", r"osteon validate (.*) --out BUNDLE")
def _(c, b, m):
    p = c.file(next(x for x in c.section.blocks if "protocol.json" in x.links), "protocol.json")
    said = ["--tier", p["tier"], "--seed", p["seed"]]
    said += ["--shard", "%d/%d" % tuple(p["shard"])] if p["shard"][1] > 1 else []
    said += ["--case", "case.json"] if "case" in p else []
    said += ["--only", p["only"]] if p["only"] else []
    said += ["--cpu-only"] if p["cpu_only"] else []
    said += ["--backends", p["chosen"]] if p["chosen"] else []
    same(b, shlex.split(m.group(1)), said + own_words(p) + (["--with-suite", "FOLDER"] if "suite" in p else []))
    return None


@rule("Files", "tr", r"")
def _(c, b, m):
    if b.cells[0] != "File":
        same(b, b.links, [b.cells[0]])
    return None


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
