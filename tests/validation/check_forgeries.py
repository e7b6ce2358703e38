#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests what osteon verify reports for each of many forgeries of a bundle of evidence.

    a bundle --a forgery, as consistent as the forger can make it--> osteon verify: expected status and line

A careful forger also recomputes the chain of the log and the manifest; the code for this is
independent of osteon's (check_changes.py). Forgeries that can be found only with --rerun or a
signature are tested too; for these, verify must print "valid". The rows of
docs/qualification/forgeries.md must be exactly these forgeries.

The file has more than 500 lines, because it is the only list of the forgeries.

    OST_FORGERY=NAME   tests only this forgery and prints the complete output of verify

Covers: REQ-EVIDENCE
"""
import hashlib
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
from check_changes import OSTEON, contents, manifest, write  # noqa: E402

DOC = os.path.join(HERE, "..", "..", "docs", "qualification", "forgeries.md")
ONE = "cpu:isa=scalar,threads=1"
FORGERIES = []


def forgery(expected, of="equal", status=1, rerun=None):
    def add(make):
        FORGERIES.append((make.__name__.replace("_", " "), make, expected, of, status, rerun))
        return make
    return add


# ------------------------------------------------------------- a forger's tools

def lines_of(f):
    return [json.loads(x) for x in f["cases.jsonl"].decode().splitlines()]


def put_lines(f, lines):
    f["cases.jsonl"] = "".join(json.dumps(x, sort_keys=True, separators=(",", ":")) + "\n" for x in lines).encode()


def get(f, name):
    return json.loads(f[name])


def put(f, name, value):
    f[name] = (json.dumps(value, sort_keys=True, indent=1, ensure_ascii=False) + "\n").encode()


def sha(data):
    return hashlib.sha256(data).hexdigest()


def remake(f, edit=lambda rows: rows):
    """Recomputes the digests in the log from the present files, then the log's chain and the manifest."""
    rows = [x.split("\t")[1:] for x in f["audit.log"].decode().splitlines()]
    for row in rows:
        name = row[2].split(" ")[0]
        if row[1] == "protocol frozen":
            row[2] = sha(f["protocol.json"])
        elif row[1] == "file" and name in f:
            row[2] = name + " " + sha(f[name])
    last, text = "0" * 64, b""
    for row in edit(rows):
        line = "\t".join([last] + row).encode() + b"\n"
        last, text = sha(line), text + line
    f["audit.log"] = text
    f["manifest.json"] = manifest(f)


def relabel(f, key, value):
    p = get(f, "protocol.json")
    p[key] = value
    put(f, "protocol.json", p)
    remake(f)


def lines_digest(one):
    text = "case 0 %s\n" % one["input_sha256"] + "".join("%s %d %s\n" % (r["stage"], r["item"], r["sha256"]) for r in one["reference"])
    return sha(text.encode())


def differing(lines):
    for one in lines:
        for name, r in one["results"].items():
            if r["verdict"] == "differs":
                return one, r
    raise SystemExit("no case differs")


# ------------------------------------------------------------------ the results

@forgery("results.json is not the file that the manifest describes")
def verdict_edited(f):
    f["results.json"] = f["results.json"].replace(b'"EQUAL"', b'"equal"')


@forgery("results.json does not match the files that it is computed from")
def verdict_and_manifest_edited(f):
    f["results.json"] = f["results.json"].replace(b'"EQUAL"', b'"equal"')
    remake(f)


@forgery("says 'equal', and its digests say 'differs', first at", of="different")
def different_case_stated_equal(f):
    lines = lines_of(f)
    differing(lines)[1]["verdict"] = "equal"
    put_lines(f, lines)
    remake(f)


@forgery("says 'equal', and its digest is not the reference's", of="different")
def different_case_stated_equal_without_records(f):
    lines = lines_of(f)
    r = differing(lines)[1]
    r["verdict"] = "equal"
    del r["records"]
    put_lines(f, lines)
    remake(f)


@forgery("its records do not give its sha256", of="different")
def digest_of_the_reference_for_the_backend(f):
    lines = lines_of(f)
    one, r = differing(lines)
    r["sha256"], r["verdict"] = one["reference_sha256"], "equal"
    put_lines(f, lines)
    remake(f)


@forgery("the reference's records do not give reference_sha256")
def digest_of_the_reference_edited(f):
    lines = lines_of(f)
    lines[0]["reference"][0]["sha256"] = "0" * 64
    put_lines(f, lines)
    remake(f)


@forgery("says 'crashed', and has the digest of a complete case")
def equal_case_stated_crashed(f):
    lines = lines_of(f)
    lines[0]["results"][ONE]["verdict"] = "crashed"
    put_lines(f, lines)
    remake(f)


@forgery("was not run, although it was available")
def equal_case_stated_not_run(f):
    lines = lines_of(f)
    lines[0]["results"][ONE] = {"verdict": "not run"}
    put_lines(f, lines)
    remake(f)


def lack(f, backend, stage):
    """Changes the results of an equal backend: marks the first record of a stage as a record for which the backend lacks
    the function."""
    lines = lines_of(f)
    one = lines[0]
    records = ["case 0 " + one["input_sha256"]] + ["%s %d %s" % (r["stage"], r["item"], r["sha256"]) for r in one["reference"]]
    records = one["results"][backend].get("records", records)
    at = next(i for i, x in enumerate(records) if x.startswith(stage + " ") and not x.endswith(" -"))
    records[at] = records[at].rsplit(" ", 1)[0] + " -"
    one["results"][backend] = {"verdict": "equal", "records": records, "sha256": sha("".join(x + "\n" for x in records).encode())}
    put_lines(f, lines)
    remake(f)


@forgery("says 'equal', and its digests say 'differs', first at sample 0")
def sampling_of_a_processor_stated_absent(f):
    lack(f, ONE, "sample")


@forgery("says 'equal', and its digests say 'differs', first at upload 0")
def upload_of_a_processor_stated_absent(f):
    lack(f, ONE, "upload")


@forgery("says 'equal', and its digests say 'differs', first at cubic 0", of="processor")
def import_of_the_second_implementation_stated_absent(f):
    lack(f, "dense", "cubic")


@forgery("says 'equal', and its digests say 'differs', first at upload 0", of="processor")
def upload_of_the_second_implementation_stated_absent(f):
    lack(f, "dense", "upload")


@forgery("valid", status=0, rerun="the reference here gives another result than the bundle states")
def digests_of_reference_and_backend_invented(f):
    lines = lines_of(f)
    for one in lines:
        one["reference"][-1]["sha256"] = "0" * 64
        one["reference_sha256"] = one["results"][ONE]["sha256"] = lines_digest(one)
    put_lines(f, lines)
    remake(f)


# --------------------------------------------------------------------- the plan

@forgery("tier, seed and options give")
def smoke_relabelled_standard(f):
    relabel(f, "tier", "standard")


@forgery("its input is not the one that tier and seed give")
def other_seed(f):
    relabel(f, "seed", "2")


@forgery("'cases' is not what tier, seed and options give")
def case_dropped(f):
    put_lines(f, lines_of(f)[:-1])
    relabel(f, "cases", get(f, "protocol.json")["cases"][:-1])


@forgery("tier, seed and options give import/0")
def cases_exchanged(f):
    lines = lines_of(f)
    put_lines(f, [lines[1], lines[0]] + lines[2:])
    remake(f)


@forgery("the processor can run the backend", of="processor")
def backend_dropped(f):
    p, lines = get(f, "protocol.json"), lines_of(f)
    gone = next(b["name"] for b in p["backends"] if b["name"].startswith("cpu:isa="))
    p["backends"] = [b for b in p["backends"] if b["name"] != gone]
    put(f, "protocol.json", p)
    for one in lines:
        del one["results"][gone]
    put_lines(f, lines)
    times = get(f, "times.json")
    del times["seconds"][gone]
    put(f, "times.json", times)
    remake(f)


@forgery("'accept' is not what tier, seed and options give")
def criterion_relaxed(f):
    relabel(f, "accept", "Most records are equal.")


@forgery("osteon reads format 2", status=2)
def older_format(f):
    relabel(f, "schema", 1)


# ------------------------------------------------------- the log and other runs

@forgery("'results' says '9999 equal")
def counts_of_the_log_raised(f):
    def raised(rows):
        for row in rows:
            if row[1] == "results":
                row[2] = re.sub(r"^\d+ equal", "9999 equal", row[2])
        return rows
    remake(f, raised)


@forgery("'protocol frozen' is expected")
def results_before_the_protocol(f):
    remake(f, lambda rows: [rows[0], rows[2], rows[1]] + rows[3:])


@forgery("is no time, or is before that of the line before")
def log_backdated(f):
    def backdated(rows):
        rows[-1][0] = "2001-01-01T00:00:00Z"
        return rows
    remake(f, backdated)


@forgery("'file' is expected")
def line_of_a_file_left_out(f):
    remake(f, lambda rows: [r for r in rows if not r[2].startswith("tools.json")])


@forgery("'file' says 'tools.json", of="other")
def tools_of_another_run(f):
    tools = get(f, "tools.json")
    tools["build"]["cflags"] = "-O0"
    put(f, "tools.json", tools)
    f["manifest.json"] = manifest(f)


@forgery("is of another program than tools.json")
def tools_of_another_build(f):
    tools = get(f, "tools.json")
    tools["program"]["sha256"] = "0" * 64
    put(f, "tools.json", tools)
    remake(f)


@forgery("sbom.spdx.json does not match the files that it is computed from")
def library_left_out_of_the_bill_of_materials(f):
    bill = get(f, "sbom.spdx.json")
    del bill["packages"][-1]
    put(f, "sbom.spdx.json", bill)
    remake(f)


@forgery("times.json has other backends than the protocol")
def times_of_another_run(f):
    times = get(f, "times.json")
    times["seconds"]["cl"] = 1.0
    put(f, "times.json", times)
    remake(f)


@forgery("valid", status=0)
def microcode_of_the_machine_invented(f):
    machine = get(f, "environment.json")
    machine["microcode"] = "1.0"
    put(f, "environment.json", machine)
    remake(f)


# -------------------------------------------------------------- hostile content

@forgery("more.txt does not belong to a bundle")
def file_added(f):
    f["more.txt"] = b"more\n"
    remake(f)


@forgery("README.md is a symbolic link")
def symbolic_link(f):
    f["README.md"] = lambda path: os.symlink("/dev/zero", path)


@forgery("README.md is a pipe")
def pipe(f):
    f["README.md"] = os.mkfifo


@forgery("pictures is a symbolic link")
def pictures_is_a_link(f):
    for name in [n for n in f if n.startswith("pictures/")]:
        del f[name]
    f["pictures"] = lambda path: os.symlink("/", path)


@forgery("signatures/")
def garbage_in_signatures(f):
    f["signatures/garbage"] = b"\x00garbage"


@forgery("the line is longer than 67108864 bytes")
def line_of_300_megabytes(f):
    f["cases.jsonl"] = lambda path: sparse(path, 300 << 20)


@forgery("at most 16777216 are expected")
def protocol_of_2_gigabytes(f):
    f["protocol.json"] = lambda path: sparse(path, 2 << 30)


@forgery("nested deeper than 16")
def nested_a_million_deep(f):
    f["cases.jsonl"] = b"[" * 1000000 + b"\n"
    remake(f)


@forgery("more than 1048576 values")
def ten_million_values(f):
    f["cases.jsonl"] = b"[" + b"0," * 10000000 + b"0]\n"
    remake(f)


@forgery("the lines up to here have more than 8388608 values")
def nine_lines_of_a_million_values(f):
    f["cases.jsonl"] = (b'{"a":[' + b"null," * 1000000 + b"null]}\n") * 9
    remake(f)


@forgery("tools.json arrays and objects are nested deeper than 16")
def tools_nested_deep(f):
    f["tools.json"] = b'{"libraries":' + b"[" * 100000 + b"\n"
    remake(f)


# -------------------------------------- other encodings of the same content, other names

def line_replaced(f, old, new):
    """Replaces the first occurrence in the text of cases.jsonl. json.dumps is not used, because it would write the usual
    form."""
    text = f["cases.jsonl"]
    assert old in text, old
    f["cases.jsonl"] = text.replace(old, new, 1)
    remake(f)


@forgery("duplicate object key")
def key_given_twice(f):
    line_replaced(f, b'{"id":"import/0"', b'{"id":"import/1","id":"import/0"')


@forgery("tier, seed and options give import/0")
def name_of_a_case_with_other_letters(f):
    line_replaced(f, b'"id":"import/0"', '"id":"\u0456mport/0"'.encode())  # the first letter is Cyrillic


@forgery("is not written as osteon writes it")
def name_of_a_case_escaped(f):
    line_replaced(f, b'"id":"import/0"', b'"id":"\\u0069mport/0"')


@forgery("is not written as osteon writes it")
def item_written_as_a_power_of_ten(f):
    line_replaced(f, b'"item":0', b'"item":0e0')


@forgery("manifest.json has rows that do not give its root")
def file_listed_twice(f):
    value = get(f, "manifest.json")
    value["files"].append(value["files"][-1])
    f["manifest.json"] = (json.dumps(value, sort_keys=True, indent=1) + "\n").encode()


@forgery("is a folder that does not belong to a bundle")
def bundle_within_the_bundle(f):
    for name, data in list(f.items()):
        f["inner/" + name] = data


@forgery("'begun' says 'osteon 9.9.9'; the bundle's files give 'osteon")
def log_of_another_version(f):
    def other(rows):
        rows[0][2] = "osteon 9.9.9"
        return rows
    remake(f, other)


@forgery("junit.xml does not match the files that it is computed from")
def begun_before_the_log(f):
    times = get(f, "times.json")
    times["begun"] = "2001-01-01T00:00:00Z"
    put(f, "times.json", times)
    remake(f)


@forgery("does not belong to a bundle")
def name_with_a_control_character(f):
    f["README.md\x1b[2J"] = b"more\n"
    remake(f)


@forgery("case.json belongs to no bundle of this protocol")
def cases_of_another_plan_added(f):
    f["case.json"] = b"{}\n"
    remake(f)


def sparse(path, size):
    with open(path, "wb") as file:
        file.truncate(size)


# ---------------------------------------------------------------------- the test

def osteon(*words):
    return subprocess.run([OSTEON, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=bounded)


def bounded():
    resource.setrlimit(resource.RLIMIT_CPU, (60, 60))


def make(folder, *words, status=0):
    ran = osteon("validate", *words, "--out", folder, "--quiet")
    if ran.returncode != status:
        raise SystemExit("osteon validate %s: status %d: %s" % (" ".join(words), ran.returncode, ran.stdout.decode(errors="replace")[-500:]))


def dump_with_a_difference(scratch):
    """Dumps the reference's grids and changes one voxel. The dump acts as a backend that differs."""
    dump = os.path.join(scratch, "dump")
    ran = osteon("validate", "--worker", "ref", "--dump", dump, "--only", "import/0")
    if ran.returncode != 0:
        raise SystemExit("osteon validate --dump failed: %s" % ran.stdout.decode(errors="replace"))
    name = next(os.path.join(top, n) for top, _, names in os.walk(dump) for n in names if "cubic" in n)
    with open(name, "r+b") as file:
        file.seek(-2, os.SEEK_END)
        two = file.read(2)
        file.seek(-2, os.SEEK_END)
        file.write(bytes([two[0] ^ 1, two[1]]))
    return dump


def sanitized():
    """Returns true if osteon is built with the address sanitizer, which multiplies the memory use."""
    real = os.path.join(os.path.dirname(OSTEON), ".libs", os.path.basename(OSTEON))
    with open(real if os.path.exists(real) else OSTEON, "rb") as file:
        return b"__asan_init" in file.read()


def rows_of_document():
    with open(DOC, encoding="utf-8") as file:
        return re.findall(r"^\| (?!forgery )([a-z0-9 ]+) \|", file.read(), re.M)


def main():
    only = os.environ.get("OST_FORGERY")
    scratch = tempfile.mkdtemp()
    failed = []
    try:
        path = {name: os.path.join(scratch, name) for name in ("equal", "different", "processor", "x")}
        make(path["equal"], "--only", "import/", "--backends", ONE)
        make(path["different"], "--only", "import/0", "--backends", "dump:" + dump_with_a_difference(scratch), status=1)
        make(path["processor"], "--only", "import/0", "--cpu-only")
        path["other"] = path["equal"]
        for kind in ("equal", "different", "processor"):
            said = osteon("verify", path[kind])
            if said.returncode != 0:
                failed.append("verify reports problems in the unchanged bundle '%s': %s" % (kind, said.stdout.decode(errors="replace")))
        for name, change, expected, of, status, rerun in FORGERIES:
            if only and name != only:
                continue
            now = contents(path[of])
            change(now)
            shutil.rmtree(path["x"], ignore_errors=True)
            os.makedirs(path["x"])
            for file, data in now.items():
                data(os.path.join(path["x"], file)) if callable(data) else write(os.path.join(path["x"], file), data)
            said = osteon("verify", path["x"])
            text = said.stdout.decode(errors="replace")
            if only:
                print(text)
            if said.returncode != status or expected not in text:
                failed.append("%s: status %d, expected %d and '%s'; verify printed: %s" % (name, said.returncode, status, expected, text[:600]))
            if rerun:
                text = osteon("verify", path["x"], "--rerun").stdout.decode(errors="replace")
                if rerun not in text:
                    failed.append("%s: verify --rerun does not print '%s', but: %s" % (name, rerun, text[:400]))
        most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        if most > 512 << 10 and not sanitized():
            failed.append("verify used %d KiB of memory, expected at most 512 MiB" % most)
        if not only and sorted(rows_of_document()) != sorted(x[0] for x in FORGERIES):
            failed.append("rows of docs/qualification/forgeries.md without a forgery, or forgeries without a row: %s" % sorted(set(rows_of_document()) ^ {x[0] for x in FORGERIES}))
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    for text in failed:
        print("FAIL: " + text)
    print("%d forgeries, %d failed; at most %d MiB of memory" % (len(FORGERIES), len(failed), most >> 10))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
