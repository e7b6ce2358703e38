#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the tables of the campaign's structural coverage from the export of llvm-cov.

  decisions.py SOURCE FOLDER TIER check    fails if a decision is neither reached nor listed, or a listed one is reached
  decisions.py SOURCE FOLDER TIER write    also writes docs/qualification/coverage.csv and coverage.md,
                                           and removes reasons that match no missing decision

FOLDER/json has one BACKEND.json for each backend that ran, all.json for all of them together, and kernels.json for the
kernels compiled as C; FOLDER/backends lists the backends.  docs/qualification/coverage-reasons.csv in SOURCE lists the
decisions that no case reaches. A decision is named by file, function and the text of its condition, so that a row survives edits:

  true, false    the condition never had this value
  neither        the condition was never evaluated
  alone          MC/DC: the condition never changed the outcome of its decision on its own
  called         the function was never entered

A * in a row of reasons matches any string. A reason that begins with "sometimes: " depends on threads or on the
machine; such a row may be reached.
"""
import csv
import json
import os
import re
import sys

SCOPE = ("src/core/", "src/cpu/", "src/cl/kernels/")
# Code that determines no voxel value: texts, files, the list and the options of backends, clocks, matrices of floats.
APART = ("src/core/backend.c", "src/core/clock.h", "src/core/decimal.c", "src/core/file.c", "src/core/isa.c",
         "src/core/isa_choose.c", "src/core/length.c", "src/core/memory_stream.c", "src/core/mesh.c",
         "src/core/mesh_facts.c", "src/core/meta.c", "src/core/path.c", "src/core/pose.c", "src/core/pose_doubles.c",
         "src/core/printable.c", "src/core/report.c", "src/core/shortest.c", "src/core/status.c",
         "src/core/unsupported.c", "src/cpu/cpu.c", "src/cpu/kernels.c", "src/cpu/ref/ref.c")
KERNELS = "src/cl/kernels/"
HEAD = ["file", "function", "condition", "what", "reason"]


class Source:
    def __init__(self, root):
        self.root = root
        self.lines = {}

    def of(self, name):
        if name not in self.lines:
            with open(os.path.join(self.root, name), encoding="utf-8") as f:
                self.lines[name] = f.read().split("\n")
        return self.lines[name]

    def text(self, name, l1, c1, l2, c2):
        lines = self.of(name)
        if l1 == l2:
            part = lines[l1 - 1][c1 - 1:c2 - 1]
        else:
            part = " ".join([lines[l1 - 1][c1 - 1:]] + lines[l1:l2 - 1] + [lines[l2 - 1][:c2 - 1]])
        return " ".join(part.split())

    def in_assertion(self, name, line, column):
        before = self.of(name)[line - 1][:column + 6]
        return "assert(" in before


def in_scope(name):
    return name.startswith(SCOPE) and name not in APART


def load(path, root):
    """Maps each file in scope to its functions, branches, MC/DC conditions and lines.

    All instances of an inline function count as one.
    """
    with open(path, encoding="utf-8") as f:
        data = json.load(f)["data"][0]
    root = os.path.realpath(root) + "/"
    out = {}

    def name_of(filename):
        real = os.path.realpath(filename)
        return real[len(root):] if real.startswith(root) else ""

    for entry in data["files"]:
        name = name_of(entry["filename"])
        if in_scope(name):
            lines = entry["summary"]["lines"]
            out[name] = {"lines": (lines["count"], lines["covered"]), "functions": {}, "branches": {}, "conditions": {}}
    for function in data["functions"]:
        name = name_of(function["filenames"][0])
        if name in out:
            first = function["regions"][0]
            short = function["name"].rsplit(":", 1)[-1]
            known = out[name]["functions"]
            begin, end, count = known.get(short, (first[0], first[2], 0))
            known[short] = (begin, end, max(count, function["count"]))
    for function in data["functions"]:
        for branch in function["branches"]:
            name = name_of(function["filenames"][branch[6]])
            if name in out:
                place = tuple(branch[:4])
                was = out[name]["branches"].get(place, (0, 0))
                out[name]["branches"][place] = (was[0] + branch[4], was[1] + branch[5])
        for record in function["mcdc_records"]:
            name = name_of(function["filenames"][record[4]])
            if name not in out:
                continue
            inside = sorted({tuple(b[:4]) for b in function["branches"]
                             if b[6] == record[4] and tuple(b[:2]) >= tuple(record[:2]) and tuple(b[2:4]) <= tuple(record[2:4])})
            if len(inside) != len(record[6]):
                continue
            for place, shown in zip(inside, record[6]):
                conditions = out[name]["conditions"]
                conditions[place] = conditions.get(place, False) or shown
    return out


def function_at(functions, line):
    best = ""
    for name, (begin, end, _) in functions.items():
        if begin <= line <= end and (not best or begin > functions[best][0]):
            best = name
    return best


def missing(measured, source):
    """Returns (file, function, condition, what) for everything that was not reached. Assertions are omitted, because they
    never fail."""
    rows = set()
    for name, file in measured.items():
        silent = {f for f, (_, _, count) in file["functions"].items() if count == 0}
        rows |= {(name, f, "", "called") for f in silent}
        for place, (yes, no) in file["branches"].items():
            function = function_at(file["functions"], place[0])
            if function in silent or source.in_assertion(name, place[0], place[1]):
                continue
            text = source.text(name, *place)
            label = text.startswith(("case ", "default"))
            if not yes and not no and not label:
                rows.add((name, function, text, "neither"))
            elif not yes:
                rows.add((name, function, text, "true"))
            elif not no and not label:
                rows.add((name, function, text, "false"))
        for place, shown in file["conditions"].items():
            function = function_at(file["functions"], place[0])
            yes, no = file["branches"].get(place, (0, 0))
            if not shown and yes and no and function not in silent and not source.in_assertion(name, place[0], place[1]):
                rows.add((name, function, source.text(name, *place), "alone"))
    return rows


def counts(file):
    sides = [bool(side) for pair in file["branches"].values() for side in pair]
    shown = list(file["conditions"].values())
    return file["lines"] + (len(sides), sum(sides), len(shown), sum(shown))


def table_of(data):
    """Yields for each file: the file, lines, reached lines, sides of branches, reached sides, conditions, and conditions
    shown by MC/DC."""
    for name in sorted(data):
        if data[name]["functions"]:
            yield (name,) + counts(data[name])


class Reason:
    def __init__(self, row):
        self.row = row
        self.sometimes = row[4].startswith("sometimes: ")
        self.used = False
        self.patterns = [re.compile("".join(".*" if c == "*" and i != 2 else re.escape(c) for c in text)) for i, text in enumerate(row[:4])]
        # A condition may contain a product, so its wildcard is **.
        self.patterns[2] = re.compile(".*".join(re.escape(part) for part in row[2].split("**")))

    def matches(self, decision):
        return all(p.fullmatch(text) for p, text in zip(self.patterns, decision))

    def about(self, files):
        return any(self.patterns[0].fullmatch(name) for name in files)


def reasons_of(path):
    with open(path, encoding="utf-8", newline="") as f:
        rows = list(csv.reader(f))
    if rows[0] != HEAD:
        sys.exit(f"{path}: the first line must be {','.join(HEAD)}")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != 5 or not row[4] or row[3] not in ("true", "false", "neither", "alone", "called", "*"):
            sys.exit(f"{path}:{number}: a row has a file, a function, a condition, one of true, false, neither, alone, called and *, and a reason")
    return [Reason(row) for row in rows[1:]]


def check(decisions, reasons, files):
    """Pairs each decision with its reason and prints the mistakes. Returns the pairs and the number of mistakes."""
    pairs, mistakes = [], 0
    for decision in sorted(decisions):
        of = [r for r in reasons if r.matches(decision)]
        for r in of:
            r.used = True
        pairs.append((decision, of[0].row[4] if of else "no reason is listed"))
        if not of:
            mistakes += 1
            print("not reached, and no reason is listed: " + " | ".join(decision))
    for r in reasons:
        if not r.used and not r.sometimes and r.about(files):
            mistakes += 1
            print("listed, but nothing that it names is missing: " + " | ".join(r.row[:4]))
    return pairs, mistakes


def percent(reached, count):
    return f"{reached} of {count}" if count else "none"


def document(tier, tables, pairs):
    out = ["<!-- SPDX-License-Identifier: Apache-2.0 -->", "# Structural coverage of the campaign", "",
           f"`validation/coverage/measure write {tier}` generates this page and `coverage.csv`. The `{tier}` tier of",
           "`osteon validate` was measured with the counters of clang-19, on a machine with the backends in the",
           "following table. `.ci/long coverage` repeats the measurement. It fails if a decision is neither",
           "reached nor listed in `coverage-reasons.csv`, or if a row of that file matches no missing decision.", "",
           "The measured code is the code in `src/core`, `src/cpu` and `src/cl/kernels` that determines voxels.",
           "The following files of these folders read texts, list backends or parse the options of backends.",
           "They determine no voxel and are not measured:",
           ",\n".join(f"`{name}`" for name in APART) + ".", "",
           "- *Lines* are source lines that contain code. A *side of a branch* is one of the two outcomes of a",
           "  condition, true or false.",
           "- *MC/DC* is counted for decisions with two or more conditions. It is the number of conditions for",
           "  which a pair of cases shows that the condition alone changes the outcome of the decision. Most",
           "  conditions that are missing check for an input that no case contains. clang-19 does not measure",
           "  MC/DC in two files with OpenMP loops, `src/cpu/bone/bone.c` and `src/cpu/voxelize/voxelize.c`.",
           "- All instances of an inline function are counted as one. Assertions are not counted, because none",
           "  of them may fail.",
           "- OpenCL devices have no counters. The kernels are therefore measured as C code, which the unit test",
           "  `tests/cl/test_kernels_as_c` runs; their rows describe this test and not the campaign. The row of",
           "  an OpenCL backend shows how much of `src/core` the host code of the backend uses.",
           "- `src/cpu/arm` is compiled only for AArch64 and is not measured.", "",
           "## Backends", "", "| backend | lines | sides of branches | MC/DC |", "|---|---|---|---|"]
    for backend, rows in tables:
        total = [sum(column) for column in list(zip(*rows))[1:]]
        out.append(f"| `{backend}` | {percent(total[1], total[0])} | {percent(total[3], total[2])} | {percent(total[5], total[4])} |")
    out += ["", "A backend is not expected to execute the files of other backends. The table of files is for all backends together.", "", "## Files", "",
            "| file | lines | sides of branches | MC/DC |", "|---|---|---|---|"]
    for backend, rows in tables:
        if backend in ("all backends", "kernels as C"):
            for row in rows:
                out.append(f"| `{row[0]}` | {percent(row[2], row[1])} | {percent(row[4], row[3])} | {percent(row[6], row[5])} |")
    out += ["", "## What no case reaches", "", f"The following {len(pairs)} outcomes of decisions are not reached by any case. They are listed by reason.", ""]
    by_reason = {}
    for decision, reason in pairs:
        by_reason.setdefault(reason, []).append(decision)
    for reason in sorted(by_reason):
        out += [f"### {reason[0].upper() + reason[1:]}", ""]
        places = {}
        for name, function, condition, what in by_reason[reason]:
            places.setdefault((name, function), []).append(what if not condition else f"`{condition}` {what}")
        out += [f"- `{name}`, `{function}`: " + "; ".join(parts) for (name, function), parts in sorted(places.items())] + [""]
    return "\n".join(out[:-1]) + "\n"


def main():
    source, folder, tier, action = sys.argv[1:5]
    with open(os.path.join(folder, "backends"), encoding="utf-8") as f:
        backends = f.read().split("\n")[:-1]
    everything = load(os.path.join(folder, "json", "all.json"), source)
    kernels = load(os.path.join(folder, "json", "kernels.json"), source)
    kernels = {name: file for name, file in kernels.items() if name.startswith(KERNELS)}
    everything = {name: file for name, file in everything.items() if not name.startswith(KERNELS)}
    texts = Source(source)
    decisions = missing(everything, texts) | missing(kernels, texts)
    reasons = reasons_of(os.path.join(source, "docs/qualification/coverage-reasons.csv"))
    files = set(everything) | set(kernels)
    pairs, mistakes = check(decisions, reasons, files)
    if action == "write":
        tables = []
        for backend in backends:
            data = load(os.path.join(folder, "json", re.sub("[:=,]", "_", backend) + ".json"), source)
            tables.append((backend, [row for row in table_of(data) if not row[0].startswith(KERNELS)]))
        tables += [("all backends", list(table_of(everything))), ("kernels as C", list(table_of(kernels)))]
        here = os.path.join(source, "docs/qualification")
        with open(os.path.join(here, "coverage-reasons.csv"), "w", encoding="utf-8", newline="") as f:
            out = csv.writer(f, lineterminator="\n")
            out.writerow(HEAD)
            out.writerows(r.row for r in reasons if r.used or r.sometimes or not r.about(files))
        with open(os.path.join(here, "coverage.csv"), "w", encoding="utf-8", newline="") as f:
            out = csv.writer(f, lineterminator="\n")
            out.writerow(("backend", "file", "lines", "lines_reached", "sides", "sides_reached", "conditions", "conditions_shown"))
            for backend, rows in tables:
                out.writerows((backend,) + row for row in rows)
        with open(os.path.join(here, "coverage.md"), "w", encoding="utf-8") as f:
            f.write(document(tier, tables, pairs))
    print(f"{len(pairs)} outcomes that no case reaches, {mistakes} mistakes in their list")
    sys.exit(mistakes > 0)


if __name__ == "__main__":
    main()
