# SPDX-License-Identifier: Apache-2.0
"""Makes the tables of a measurement: mutants.csv with a row per file, and mutants.md for readers."""
import csv
import math
import os
import sys

import scope

COLUMNS = ["file", "scope", "generated", "drawn", "not built here", "not compiled", "identical", "differing", "equivalent", "no result", "smoke", "by crash or time",
           "standard", "tests", "survived"]
# Kinds of mutants that no campaign can detect. The mutated program is equivalent for every input, or it differs only in
# its running time, its memory use, its messages, or for input that is refused earlier.
KINDS = ("equivalent", "no result")
REASONS = ["id", "kind", "file", "text", "old", "new", "reason"]


def interval(hits, count, z=1.96):
    """Returns Wilson's 95 % interval of a proportion."""
    if count == 0:
        return 0.0, 1.0
    p, n = hits / count, count
    middle, half = (p + z * z / (2 * n)) / (1 + z * z / n), z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def read(paths):
    """Returns {id: row}. A row is the last row of the mutant, with all tiers in which it was run in "tiers", and the seed
    by which it was drawn."""
    rows = {}
    for path in paths:
        with open(path, newline="") as f:
            for row in csv.DictReader(f):
                before = rows.get(row["id"])
                tiers = [t for t in (before["tiers"] if before else "").split("+") if t]
                tiers += [t for t in (row.get("tiers") or "smoke").split("+") if t not in tiers]
                rows[row["id"]] = {**row, "tiers": "+".join(tiers), "seed": row.get("seed") or (before["seed"] if before else "")}
    return rows


def reasons(path):
    """Returns {id: row} of the mutants that were examined by hand. A row is valid only for the text of the line that it
    contains."""
    if not os.path.exists(path):
        return {}
    with open(path, newline="") as f:
        return {row["id"]: row for row in csv.DictReader(f)}


def kind_of(row, known):
    """Returns the outcome, or the kind of a survivor that was examined by hand: "equivalent" or "no result"."""
    reason = known.get(row["id"])
    if row["outcome"] in ("survived", "killed by tests") and reason and reason["kind"] in KINDS and reason["text"] == row["text"]:
        return reason["kind"]
    return row["outcome"]


def count_file(file, generated, rows, known):
    kinds = [kind_of(r, known) for r in rows]
    n = {name: kinds.count(name) for name in set(kinds)}
    by_end = sum(1 for r in rows if r["outcome"] == "killed by smoke" and (r["how"] == "time" or "crash" in r["how"] or r["how"].startswith("exit")))
    differing = len(rows) - n.get("not built here", 0) - n.get("not compiled", 0) - n.get("identical", 0)
    return dict(zip(COLUMNS, [file, "tests" if file in scope.OUTSIDE else "campaign", generated, len(rows), n.get("not built here", 0), n.get("not compiled", 0),
                              n.get("identical", 0), differing, n.get("equivalent", 0), n.get("no result", 0), n.get("killed by smoke", 0), by_end,
                              n.get("killed by standard", 0), n.get("killed by tests", 0), n.get("survived", 0)]))


def total(rows, name):
    return {**{c: sum(r[c] for r in rows) for c in COLUMNS[2:]}, "file": name, "scope": ""}


def part_of(file):
    if file.startswith("src/cpu/"):
        return "src/cpu/" + (file.split("/")[2] if file.count("/") > 2 else "")
    return "src/cl/kernels/" if scope.is_kernel(file) else "/".join(file.split("/")[:2]) + "/"


def share(hits, count):
    low, high = interval(hits, count)
    return f"{hits} of {count}, {100 * hits / count:.1f} % (95 % interval {100 * low:.0f} to {100 * high:.0f} %)" if count else "none measured"


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def markdown(files, rows, known, command):
    campaign = [f for f in files if f["scope"] == "campaign"]
    every = total(campaign, "all")
    able, strict = every["differing"] - every["equivalent"] - every["no result"], every["differing"] - every["equivalent"]
    parts = {}
    for f in campaign:
        parts.setdefault(part_of(f["file"]), []).append(f)
    head = ["file"] + COLUMNS[2:]
    out = [
        "# Mutants of the backends' code", "",
        "Made by `validation/mutants/mutants.py table`; [validation.md](../design/validation.md#mutants-of-the-real-code) says how", "mutants are made and measured.", "",
        *command, "",
        f"- Noticed by smoke: {share(every['smoke'], able)} of those that are able to change a result. The goal is 95 %.",
        f"- The same with those that change no result counted as not noticed: {share(every['smoke'], strict)}.",
    ]
    judged = [r for r in rows.values() if "standard" in r["tiers"] or r["outcome"] == "killed by smoke"]
    unknown = sum(1 for r in rows.values() if kind_of(r, known) == "survived" and "standard" not in r["tiers"] and r["file"] not in scope.OUTSIDE)
    if unknown:
        out.append(f"- Noticed by smoke and standard: at least {share(every['smoke'] + every['standard'], able)}; {unknown} survivors of smoke were not run through standard.")
        out.append("  The goal is 98 %.")
    elif judged:
        out.append(f"- Noticed by standard: {share(every['smoke'] + every['standard'], able)}. The goal is 98 %.")
    out += ["", "## By part", "", "| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name, group in sorted(parts.items()):
        row = total(group, name)
        out.append("| " + " | ".join(str(row[c]) for c in head) + " |")
    out += ["| " + " | ".join(str(every[c]) for c in head) + " |", "",
            "`generated` counts all mutants of the files, `drawn` those that were measured. `identical` ones make the same object code.",
            "`no result`: they change time, memory, a message or what is refused, and no result that a campaign compares.",
            "`by crash or time` are among those that smoke noticed. mutants.csv has a row for each file.", ""]
    operators = {}
    for r in rows.values():
        if r["file"] not in scope.OUTSIDE:
            operators.setdefault(r["operator"], []).append(r)
    out += ["## By operator", "", "| operator | drawn | able to change a result | smoke | standard | tests | survived |", "|---|---|---|---|---|---|---|"]
    for name, group in sorted(operators.items()):
        one = count_file("", 0, group, known)
        out.append(f"| {name} | {len(group)} | {one['differing'] - one['equivalent'] - one['no result']} | {one['smoke']} | {one['standard']} | {one['tests']} | {one['survived']} |")
    out += ["", "## What the campaign did not notice", ""]
    for title, kinds in (("Survivors", ("survived",)), ("Noticed by the test suite alone", ("killed by tests",)), ("No result", ("no result",)),
                         ("Equivalent", ("equivalent",))):
        group = sorted((r for r in rows.values() if kind_of(r, known) in kinds and r["file"] not in scope.OUTSIDE), key=lambda r: (r["file"], int(r["line"])))
        if not group:
            continue
        out += [f"### {title}", "", "| mutant | place | change | explanation |", "|---|---|---|---|"]
        for r in group:
            reason = known.get(r["id"], {}).get("reason") or (r["by"] if r["outcome"] == "killed by tests" else "not examined")
            note = f" ({r['how']})" if r["how"] and r["outcome"] == "survived" else ""
            out.append(f"| {r['id']} | {r['file']}:{r['line']} | `{cell(r['old'])}` -> `{cell(r['new'])}` in `{cell(r['text'])[:120]}` | {cell(reason)}{note} |")
        out.append("")
    return "\n".join(out).rstrip() + "\n"


def judge(files, rows, known, least, explained):
    """Returns the defects of a measurement as lines: too few detected mutants, judged by the upper end of the interval, and
    survivors without a reason."""
    every = total([f for f in files if f["scope"] == "campaign"], "all")
    hits, count = every["smoke"] + every["standard"], every["differing"] - every["equivalent"] - every["no result"]
    wrong = []
    if count == 0:
        wrong.append("no mutant was measured that is able to change a result")
    elif 100 * interval(hits, count)[1] < least:
        wrong.append(f"noticed: {share(hits, count)}; at least {least:g} % are expected")
    if explained:
        wrong += [f"{r['id']} {r['file']}:{r['line']} survived without an explanation" for r in rows.values()
                  if kind_of(r, known) == "survived" and r["file"] not in scope.OUTSIDE and not known.get(r["id"], {}).get("reason")]
    return wrong


def write(args):
    import mutants
    rows = read(args.results)
    known = reasons(args.equivalent)
    generated = {}
    for m in mutants.generate(args.source):
        generated[m.file] = generated.get(m.file, 0) + 1
    by_file = {}
    for r in rows.values():
        by_file.setdefault(r["file"], []).append(r)
    files = [count_file(f, generated.get(f, 0), by_file.get(f, []), known) for f in sorted(set(generated) | set(by_file))]
    commits = sorted({r["commit"] for r in rows.values()})
    seeds = sorted({r["seed"] for r in rows.values()} - {""})
    note = args.note.replace("\\n", "\n")
    command = [f"{len(rows)} mutants of {sum(generated.values())}, drawn by seed {', '.join(seeds)}, of commit {', '.join(commits)}.", *([note] if note else [])]
    os.makedirs(args.out, exist_ok=True)
    with open(os.path.join(args.out, "mutants.csv"), "w", newline="") as f:
        out = csv.DictWriter(f, COLUMNS, lineterminator="\n")
        out.writeheader()
        out.writerows(files)
    with open(os.path.join(args.out, "mutants.md"), "w") as f:
        f.write(markdown(files, rows, known, command))
    wrong = judge(files, rows, known, args.least, args.explained)
    for line in wrong:
        print(f"mutants.py: {line}", file=sys.stderr)
    return 1 if wrong else 0
