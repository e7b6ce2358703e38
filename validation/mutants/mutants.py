#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures which mutants of the backends' code the campaign detects.

    sources --operators--> mutants --sample--> each: compile, compare, link, run
                                                 --> a row of results.csv
    results.csv, equivalent.csv --table--> mutants.md, mutants.csv

  mutants.py list [--source DIR] [--sample N --seed S]       the mutants that a run would try
  mutants.py run --work DIR [--sample N --seed S] [--hours H] [--jobs N] ...
  mutants.py table --results FILE --out FOLDER                tables of a measurement

`run` clones the source's last commit into --work, builds it once, and appends
a row for each mutant as it is measured; if it is started again it continues
after these rows. Only the files of the scratch build are compiled; the tree is
not changed.
"""
import argparse
import csv
import glob
import os
import queue
import signal
import subprocess
import sys
import threading
import time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build as building  # noqa: E402
import measure  # noqa: E402
import operators  # noqa: E402
import scope  # noqa: E402
import table  # noqa: E402
import trial  # noqa: E402


def generate(source, only=None):
    """Returns all mutants of the files in scope, or of those whose path begins with one of `only`."""
    out = []
    for file in scope.files(source):
        if only and not file.startswith(tuple(only)):
            continue
        with open(os.path.join(source, file), newline="") as f:
            out += operators.mutants_of(file, f.read())
    return out


def imported(source, folder):
    """Reads mutants that another generator wrote as files: FOLDER/PATH/OF/SOURCE.c/ANY-NAME is one mutant of that source."""
    out, seen = [], {}
    for file in scope.files(source):
        with open(os.path.join(source, file), newline="") as f:
            text = f.read()
        for path in sorted(glob.glob(os.path.join(folder, file, "*"))):
            with open(path, newline="") as f:
                m = operators.from_file(file, text, f.read(), seen)
            if m:
                out.append(m)
    return out


def measured(path):
    """Returns the identifiers of the mutants that already have a row."""
    if not os.path.exists(path):
        return set()
    with open(path, newline="") as f:
        return {row["id"] for row in csv.DictReader(f)}


def survivors(path):
    """Returns the identifiers of the mutants that survived according to their last row."""
    with open(path, newline="") as f:
        return {i for i, outcome in {row["id"]: row["outcome"] for row in csv.DictReader(f)}.items() if outcome == "survived"}


def chosen(args):
    source = os.path.join(args.work, "tree") if args.command == "run" else args.source
    mutants = imported(source, args.imported) if args.imported else generate(source, args.files)
    if not args.outside:
        mutants = [m for m in mutants if m.file not in scope.OUTSIDE]
    if args.command == "run" and args.survivors:
        args.ids = ",".join(sorted(survivors(args.results)))
    if args.ids is not None:
        wanted = set(args.ids.split(","))
        return [m for m in mutants if m.id in wanted]
    return operators.sample(mutants, args.sample or len(mutants), args.seed)


def stop(number, _frame):
    """Kills the running processes. The rows that were written remain, and the same command continues after them."""
    building.end_all()
    os._exit(128 + number)


def run(args):
    tree = os.path.join(args.work, "tree")
    folder = building.make_scratch(args.source, tree, args.configure.split())
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=tree, capture_output=True, text=True).stdout.strip()
    build = building.Build(folder, os.path.join(args.work, "objects"))
    campaign = trial.Campaign(os.path.join(folder, "osteon"), os.path.join(args.work, "baseline-" + commit), trial.Limits(args.memory),
                              trial.stage_names(tree), trial.family_names(tree))
    todo, done = chosen(args), set() if args.survivors else measured(args.results)
    work = queue.SimpleQueue()
    for m in todo:
        if m.id not in done:
            work.put(m)
    end, lock = time.monotonic() + args.hours * 3600, threading.Lock()
    one = measure.Measurement(build, campaign, args.tiers.split(","))
    new = not os.path.exists(args.results)
    print(f"{len(todo)} mutants, {work.qsize()} to measure, commit {commit}, seed {args.seed}", flush=True)
    with open(args.results, "a", newline="") as out:
        rows = csv.DictWriter(out, measure.FIELDS, lineterminator="\n")
        if new:
            rows.writeheader()

        def job(number):
            while time.monotonic() < end:
                try:
                    m = work.get_nowait()
                except queue.Empty:
                    return
                try:
                    outcome = one.measure(m, os.path.join(args.work, f"job{number}"))
                except (OSError, RuntimeError, ValueError, building.BuildError) as e:
                    print(f"{m.id} {m.file}:{m.line}: not measured: {e}", file=sys.stderr, flush=True)
                    continue
                with lock:
                    row = {**m._asdict(), **outcome, "tiers": args.tiers.replace(",", "+"), "commit": commit,
                           "seed": "" if args.ids is not None else args.seed}  # named mutants were not drawn, or were in an earlier run
                    rows.writerow({name: row[name] for name in measure.FIELDS})
                    out.flush()
                    print(f"{m.id} {m.file}:{m.line} {m.operator} {m.old!r} -> {m.new!r}: {outcome['outcome']} {outcome['by']} {outcome['stage']}"
                          f" {outcome['how']} ({outcome['seconds']} s)", flush=True)

        threads = [threading.Thread(target=job, args=(n,)) for n in range(args.jobs)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
    print(f"{work.qsize()} mutants are left", flush=True)
    return 0


def main():
    here = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    parser = argparse.ArgumentParser(description="Mutants of the backends' code, and what notices them.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("list", "run"):
        p = commands.add_parser(name)
        p.add_argument("--source", default=here, help="the repository (default: this one)")
        p.add_argument("--sample", type=int, help="so many mutants, in proportion of files and operators (default: all)")
        p.add_argument("--seed", type=int, default=1, help="of the sample (default: 1)")
        p.add_argument("--files", nargs="*", help="files whose path begins so (default: src/core, src/cpu, src/cl)")
        p.add_argument("--ids", help="these mutants alone, by their identifiers")
        p.add_argument("--outside", action="store_true", help="also files that decide no voxel of a campaign")
        p.add_argument("--imported", help="a folder of mutants that another generator made")
        if name == "run":
            p.add_argument("--work", required=True, help="a folder for the build, some hundred MB")
            p.add_argument("--results", required=True, help="a CSV; rows are appended, and mutants in it are not measured again")
            p.add_argument("--survivors", action="store_true", help="those alone that survived according to --results, by other --tiers")
            p.add_argument("--tiers", default="smoke,standard,tests", help="what is run, in this order, until one notices (default: smoke,standard,tests)")
            p.add_argument("--hours", type=float, default=1, help="when no further mutant is begun (default: 1)")
            p.add_argument("--jobs", type=int, default=1, help="mutants at a time (default: 1)")
            p.add_argument("--memory", type=int, default=8192, help="MiB of address space of a program under test (default: 8192)")
            p.add_argument("--configure", default="-q", help="arguments of configure for the scratch build")
    p = commands.add_parser("table")
    p.add_argument("--results", nargs="+", required=True, help="CSVs that run wrote")
    p.add_argument("--equivalent", default=os.path.join(here, "docs/qualification/mutants-equivalent.csv"))
    p.add_argument("--source", default=here, help="the repository")
    p.add_argument("--out", required=True, help="a folder for mutants.md and mutants.csv")
    p.add_argument("--least", type=float, default=0,
                   help="status 1 if fewer per cent than this are noticed, by the upper end of the 95 %% interval (default: 0)")
    p.add_argument("--explained", action="store_true", help="status 1 if a survivor has no reason in --equivalent")
    p.add_argument("--note", default="", help="how it was measured: hours, machine")
    args = parser.parse_args()
    if args.command == "list":
        for m in chosen(args):
            print(f"{m.id} {m.file}:{m.line} {m.operator} {m.old!r} -> {m.new!r}")
        return 0
    if args.command == "table":
        return table.write(args)
    args.work, args.results = os.path.abspath(args.work), os.path.abspath(args.results)
    os.makedirs(args.work, exist_ok=True)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, stop)
    return run(args)


if __name__ == "__main__":
    sys.exit(main())
