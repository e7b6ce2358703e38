#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares docs/reference/parameters.md with the command, the headers and the rules.

  1  the options of the page, and only these, are options of the verbs that the page covers
  2  a default is that of the option's help; the command computes the same result with the default and without the
     option, and a different result with another value
  3  a range is that of the message for a value outside it; the list of choices is complete
  4  a key of the safety layer has the unit, default and range that osteon sim --print-force-params prints
  5  every function, constant, struct and member of the page is declared in include/osteon, and every rule is defined

Covers: REQ-CLI-HELP

Usage: test_parameters.py [OSTEON]    (default: $OSTEON, else ./osteon)
"""
import glob
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.environ.get("srcdir", "."))
OSTEON = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("OSTEON", "./osteon"))
VERBS = ("phantom", "tool", "import", "segment", "voxelize", "ream", "replay", "sim", "diff", "render", "export", "info")
REAM = "ream --bone ct.nrrd --tool builtin:reamer --path builtin:glenoid-ream --out out.nrrd"

# Commands without the option whose default is tested, and another value, which changes the result.
EFFECTS = {
    "--threshold": ("import ct.nrrd --out out.nrrd", "121"),
    "--resample": ("import ct.nrrd --out out.nrrd", "nearest"),
    "segment --threshold": ("segment ct.nrrd --out out.nrrd", "121"),
    "--min-volume": ("segment ct.nrrd --out out.nrrd --threshold 800", "0.3"),
    "--air": ("segment ct.nrrd --out out.nrrd --fill --threshold 600", "500"),
    "--voxel": ("voxelize builtin:burr --out out.nrrd", "0.51"),
    "--rpm": (REAM, "201"),
    "--sweep": (REAM, "off"),
    "--classes": (REAM, "cartilage:120,cancellous:151,cortical:650"),
    "--planned": (REAM + " --debrief out.html", "3.1"),
    "phantom --seed": ("phantom glenoid --out out.nrrd", "2"),
    "phantom --scale": ("phantom glenoid --out out.nrrd", "1.01"),
    "phantom --side": ("phantom glenoid --out out.nrrd", "left"),
    "tool --diameter": ("tool {kind} --out out.stl", "36.5"),
    "tool --length": ("tool {kind} --out out.stl", "21"),
    "tool --segments": ("tool reamer --out out.stl", "100"),
}
KINDS = ("reamer", "peg", "burr")  # the order of the defaults of --diameter and --length

# A value outside the range, and the command that refuses it.
OUTSIDE = {
    "--spacing": "import ct.nrrd --out out.nrrd --spacing 100.1",
    "--threshold": "import ct.nrrd --out out.nrrd --threshold 32768",
    "--cubic": "import ct.nrrd --out out.nrrd --cubic 100.1",
    "segment --threshold": "segment ct.nrrd --out out.nrrd --threshold 0",
    "--growth": "segment ct.nrrd --out out.nrrd --growth 0",
    "--min-volume": "segment ct.nrrd --out out.nrrd --min-volume 1e10",
    "--air": "segment ct.nrrd --out out.nrrd --air 32768",
    "--separate": "segment ct.nrrd --out out.nrrd --separate 65.1",
    "--cut-ball": "segment ct.nrrd --out out.nrrd --cut-ball 0,0,0,1001",
    "--voxel": "voxelize builtin:peg --out out.nrrd --voxel 100.1",
    "--rpm": REAM + " --rpm 3001",
    "--rate": REAM + " --rate 0.0001",
    "--max-gap": REAM + " --max-gap 3600001",
    "--classes": REAM + " --classes a:0",
    "--planned": REAM + " --planned 20.1",
    "phantom --seed": "phantom glenoid --out out.nrrd --seed 0",
    "phantom --spacing": "phantom glenoid --out out.nrrd --spacing 100.1",
    "phantom --scale": "phantom glenoid --out out.nrrd --scale 8.1",
    "tool --diameter": "tool peg --out out.stl --diameter 1001",
    "tool --length": "tool peg --out out.stl --length 1001",
    "tool --segments": "tool peg --out out.stl --segments 14",
}
faults = []
checks = 0


def expect(condition, text):
    """Counts a check, and records a fault if the condition is false."""
    global checks
    checks += 1
    if not condition:
        faults.append(text)


def run(arguments):
    """Runs osteon, given its arguments as one string."""
    return subprocess.run([OSTEON] + arguments.split(), capture_output=True, text=True, check=False)


def tables(text):
    """Yields each table of a page as a list of rows, each a dict from the heading of a column to the text of a cell."""
    for block in re.findall(r"(?:^\|.*\n)+", text, re.M):
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in block.rstrip("\n").split("\n")]
        yield [dict(zip(rows[0], row)) for row in rows[2:]]


def plain(cell):
    return cell.replace("`", "")


def options_of(verb):
    """Returns a dict from each option of a verb to its kind (or its choices) and its help."""
    lines = run(verb + " --complete").stdout.rstrip("\n").split("\n")
    return {name: (kind, text) for name, kind, text in (line.split("\t") for line in lines)}


def default_in(kind, text):
    """Returns the default that a help text states, or None."""
    found = re.search(r"\(default: (.*?)\)", text) or re.search(r"([^:,]+) \(default\)", text)
    return found.group(1).strip() if found else None


def rows_of(page):
    """Yields (entry, row) for each option, such as "--air" or "segment --bone", of a table with defaults."""
    for table in tables(page):
        for row in table:
            if "default" in row and "option" in row:
                for entry in re.findall(r"`([^`]*--[^`]*)`", row["option"]):
                    yield entry, row


def check_names(page, known):
    """Checks that the page names all options of its verbs, and no others."""
    named = {name for table in tables(page) for row in table
             for name in re.findall(r"--[a-z-]+", row.get("option", "") + row.get("options", ""))}
    exist = {name for verb in VERBS for name in known[verb]}
    expect(named == exist, f"options that the page lacks: {sorted(exist - named)}; that do not exist: {sorted(named - exist)}")


def check_help(page, known):
    """Checks defaults and choices against the help of each verb that a row covers."""
    own = {entry for entry, _ in rows_of(page) if " " in entry}
    for entry, row in rows_of(page):
        verb, _, name = entry.rpartition(" ")
        verbs = [v for v in VERBS if name in known[v] and (v == verb if verb else f"{v} {name}" not in own)]
        expect(verbs, f"{entry}: no verb has this option")
        if not verbs:
            continue
        stated = set()
        for kind, text in (known[v][name] for v in verbs):
            stated.add(default_in(kind, text))
            if "|" in kind:
                listed = plain(row["range"]).split("; ")[0]
                expect(listed == kind.replace("|", ", "), f"{entry}: range '{listed}', expected '{kind}'")
        stated.discard(None)
        flag = known[verbs[0]][name][0] == "flag"
        expected = stated or {"off" if flag else "none"}
        expect({plain(row["default"])} == expected, f"{entry}: default '{row['default']}'; help: {sorted(expected)}")


def result_of(command):
    """Returns the output files and the result of a command, without times."""
    for name in ("out.nrrd", "out.stl", "out.html"):
        if os.path.exists(name):
            os.remove(name)
    done = run(command + " --json")
    if done.returncode != 0:
        return f"status {done.returncode}: {done.stderr.strip()}"
    values = {k: v for k, v in json.loads(done.stdout).items() if not re.search(r"_ms$|_us$|^stages$|^in$", k)}
    files = []
    for name in ("out.nrrd", "out.stl"):
        if os.path.exists(name):
            with open(name, "rb") as file:
                files.append(hashlib.sha256(file.read()).hexdigest())
    return json.dumps([values, files], sort_keys=True)


def check_effect(entry, row):
    """Checks that the default of a row is the value that the command uses."""
    command, other = EFFECTS[entry]
    name = entry.rpartition(" ")[2]
    text = plain(row["default"])
    numbers = re.findall(r"\d+(?:\.\d+)?", text)
    if "{kind}" in command:
        cases = [(command.format(kind=kind), value) for kind, value in zip(KINDS, numbers)]
        expect(len(numbers) == len(KINDS), f"{entry}: {len(numbers)} defaults, expected {len(KINDS)}")
    else:
        cases = [(command, text if ":" in text or text.lstrip("-").replace(".", "").isdigit() else
                  numbers[-1] if numbers else text.split(";")[0])]
    for case, value in cases:
        without = result_of(case)
        if without.startswith("status 3"):  # a debrief needs libpng
            return
        expect(without.startswith("["), f"osteon {case}: {without}")
        expect(result_of(f"{case} {name}={value}") == without, f"osteon {case}: {name}={value} is not the default")
    expect(result_of(f"{cases[0][0]} {name}={other}") != result_of(cases[0][0]),
           f"osteon {cases[0][0]}: {name}={other} has no effect")


def check_range(entry, row):
    """Checks that the message for a value outside the range states the range of the page."""
    done = run(OUTSIDE[entry])
    stated = plain(row["range"]).split("; ")[0]
    expect(done.returncode == 2, f"osteon {OUTSIDE[entry]}: status {done.returncode}, expected 2")
    expect(re.search(r"(?<![\w.])" + re.escape(stated) + r"(?![\d.])", done.stderr),
           f"{entry}: range '{stated}'; the message is: {done.stderr.strip()}")


def check_safety(page):
    """Compares the keys of the safety layer with the parameters that the command prints."""
    printed = {}
    for key, value, rest in re.findall(r"^(\w+): (\S+) +# (.*)$", run("sim --print-force-params").stdout, re.M):
        unit, _, limits = rest.rpartition(", ")
        printed[key] = (unit, value, limits)
    rows = [row for table in tables(page) for row in table if "key" in row]
    for row in rows:
        key = plain(row["key"])
        expect(printed.get(key) == (row["unit"], row["default"], row["range"]),
               f"{key}: {row['unit']}, {row['default']}, {row['range']}; printed: {printed.get(key)}")
    names = list(printed)
    expect([plain(row["key"]) for row in rows] == names[names.index("max_force"):],
           f"the keys from max_force on are {names[names.index('max_force'):]}")


def check_declarations(page):
    """Checks that headers and rules contain what the page names."""
    headers = ""
    for path in sorted(glob.glob(ROOT + "/include/osteon/*.h")):
        with open(path, encoding="utf-8") as file:
            headers += file.read()
    structs = {name: body for body, name in re.findall(r"typedef struct \w+ \{(.*?)\n\} (\w+);", headers, re.S)}
    for name in sorted(set(re.findall(r"`((?:ost|OST)_[\w.]+)`", page))):
        struct, _, member = name.partition(".")
        if member:
            expect(re.search(r"\b" + member + r"\b", structs.get(struct, "")), f"{name} is not a member in include/osteon")
        else:
            expect(re.search(r"\b" + struct + r"\b", headers), f"{name} is not declared in include/osteon")
    with open(ROOT + "/docs/spec/arithmetic.md", encoding="utf-8") as file:
        rules = set(re.findall(r"^\*\*(AR-[A-Z]+-\d+)\*\*", file.read(), re.M))
    for rule in sorted(set(re.findall(r"AR-[A-Z]+-\d+", page))):
        expect(rule in rules, f"{rule} is not a rule of docs/spec/arithmetic.md")


def main():
    """Prints a line for each fault. Returns the exit status."""
    with open(ROOT + "/docs/reference/parameters.md", encoding="utf-8") as file:
        page = file.read()
    known = {verb: options_of(verb) for verb in VERBS}
    check_names(page, known)
    check_help(page, known)
    check_safety(page)
    check_declarations(page)
    rows = dict(rows_of(page))
    for entry in sorted(set(EFFECTS) | set(OUTSIDE)):
        expect(entry in rows, f"{entry}: no row")
    for entry, row in rows.items():
        if re.search(r"\d to -?\d", row["range"]):
            expect(entry in OUTSIDE, f"{entry}: this test has no value outside the range {row['range']}")
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)
        made = run("phantom glenoid --out ct.nrrd")
        expect(made.returncode == 0, f"osteon phantom: {made.stderr.strip()}")
        for entry in EFFECTS:
            if entry in rows:
                check_effect(entry, rows[entry])
        for entry in OUTSIDE:
            if entry in rows:
                check_range(entry, rows[entry])
        os.chdir(ROOT)
    for fault in faults:
        print(f"FAIL: {fault}")
    print(f"{checks} checks, {len(faults)} failed")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
