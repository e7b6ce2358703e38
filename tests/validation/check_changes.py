#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes random changes to a bundle of evidence. osteon verify must detect each change and name the file.

    a bundle --one random change--> osteon verify: status 1 (2 if a file is absent) and the file's name --> restored --> the next

Bytes are flipped, inserted or removed. Files are truncated, extended, removed, added, renamed or
exchanged. Lines of the log are removed, duplicated or exchanged. A careful forgery is also tried:
a derived file is changed and the manifest is corrected. The hash tree for it is computed here,
independently of osteon (RFC 6962 section 2.1).

    OST_CHANGES=N   number of changes (default 40; OST_TEST_LONG=1: 3000)
    OST_SEED=N      seed of the changes (default: from the clock, printed)
    OST_BUNDLE=DIR  an existing bundle (default: a small one is made)

Covers: REQ-EVIDENCE
"""
import collections
import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

OSTEON = os.environ.get("OSTEON", os.path.join(os.getcwd(), "osteon"))
VARYING = ["audit.log", "devices.json", "environment.json", "impact.json", "junit.xml", "manifest.json",
           "report.html", "sbom.spdx.json", "soup.csv", "suite.json", "times.json", "tools.json", "trace.csv"]
DERIVED = ["README.md", "results.json", "junit.xml", "results.tap", "inputs.csv", "anomalies.csv", "deviations.csv", "trace.csv",
           "sbom.spdx.json", "soup.csv", "report.html"]


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, data):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data)


def contents(folder):
    found = {}
    for top, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(top, name)
            found[os.path.relpath(path, folder)] = read(path)
    return found


def tree(leaves):
    if not leaves:
        return hashlib.sha256(b"").digest()
    if len(leaves) == 1:
        return leaves[0]
    left = 1
    while 2 * left < len(leaves):
        left *= 2
    return hashlib.sha256(b"\x01" + tree(leaves[:left]) + tree(leaves[left:])).digest()


def manifest(files):
    rows, every, some = [], [], []
    for name in sorted(n for n in files if n != "manifest.json" and not n.startswith("signatures/")):
        digest = hashlib.sha256(files[name])
        leaf = hashlib.sha256(b"\x00" + name.encode() + b"\x00" + digest.digest()).digest()
        rows.append({"name": name, "sha256": digest.hexdigest(), "size": len(files[name])})
        every.append(leaf)
        if name not in VARYING:
            some.append(leaf)
    value = {"schema": json.loads(files["manifest.json"])["schema"], "files": rows, "varying": VARYING, "root": tree(every).hex(), "results_root": tree(some).hex(),
             "hash": "SHA-256; roots as in RFC 6962 over SHA-256(00 name 00 digest)"}
    return (json.dumps(value, sort_keys=True, indent=1) + "\n").encode()


class Changes:
    """Each method changes the folder's files in place and returns the names that verify may report."""

    def __init__(self, rng, files):
        self.rng, self.files = rng, files

    def any(self):
        return self.rng.choice(sorted(self.files))

    def bit_flipped(self, f):
        name = self.any()
        data = bytearray(f[name])
        data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        f[name] = bytes(data)
        return [name]

    def byte_replaced(self, f):
        name = self.any()
        data = bytearray(f[name])
        at = self.rng.randrange(len(data))
        data[at] = self.rng.choice([b for b in range(256) if b != data[at]])
        f[name] = bytes(data)
        return [name]

    def byte_inserted(self, f):
        name = self.any()
        at = self.rng.randrange(len(f[name]) + 1)
        f[name] = f[name][:at] + bytes([self.rng.randrange(256)]) + f[name][at:]
        return [name]

    def byte_removed(self, f):
        name = self.any()
        at = self.rng.randrange(len(f[name]))
        f[name] = f[name][:at] + f[name][at + 1:]
        return [name]

    def file_truncated(self, f):
        name = self.any()
        f[name] = f[name][:self.rng.randrange(len(f[name]))]
        return [name]

    def file_removed(self, f):
        name = self.any()
        del f[name]
        return [name]

    def file_added(self, f):
        name = self.rng.choice(["more.txt", "pictures/more.png", "report.html~", ".hidden", "manifest.json.bak"])
        f[name] = b"more"
        return [name]

    def file_renamed(self, f):
        name = self.any()
        f[name + "x"] = f.pop(name)
        return [name + "x"]  # an unknown file, after which no other file is read

    def files_exchanged(self, f):
        return self.exchange(f, *self.rng.sample(sorted(self.files), 2))

    def exchange(self, f, a, b):
        f[a], f[b] = f[b], f[a]
        return [a, b] if f[a] != f[b] else None

    def log(self, f, lines):
        f["audit.log"] = b"".join(lines)
        return ["audit.log"] if f["audit.log"] != self.files["audit.log"] else None

    def log_lines_exchanged(self, f):
        lines = f["audit.log"].splitlines(True)
        a, b = self.rng.sample(range(len(lines)), 2)
        lines[a], lines[b] = lines[b], lines[a]
        return self.log(f, lines)

    def log_line_removed(self, f):
        lines = f["audit.log"].splitlines(True)
        del lines[self.rng.randrange(len(lines))]
        return self.log(f, lines)

    def log_line_duplicated(self, f):
        lines = f["audit.log"].splitlines(True)
        at = self.rng.randrange(len(lines))
        return self.log(f, lines[:at] + [lines[at]] + lines[at:])

    def derived_file_forged(self, f, name=None):
        name = name or self.rng.choice([n for n in DERIVED if n in f])
        data = bytearray(f[name])
        data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        f[name] = bytes(data)
        f["manifest.json"] = manifest(f)
        return [name]

    def log_forged(self, f):
        lines = f["audit.log"].splitlines(True)
        del lines[self.rng.randrange(len(lines) - 1)]  # the last line is excluded, because a chain without its end is still valid
        self.log(f, lines)
        f["manifest.json"] = manifest(f)
        return ["audit.log"]


def main():
    count = int(os.environ.get("OST_CHANGES", 3000 if os.environ.get("OST_TEST_LONG") else 40))
    seed = int(os.environ.get("OST_SEED", time.time_ns() & 0xffffffff))
    print("seed %d" % seed)
    rng = random.Random(seed)
    scratch = tempfile.mkdtemp()
    missed, done = [], collections.Counter()
    try:
        folder = os.path.join(scratch, "bundle")
        if os.environ.get("OST_BUNDLE"):
            shutil.copytree(os.environ["OST_BUNDLE"], folder)
        else:
            subprocess.run([OSTEON, "validate", "--only", "import/", "--backends", "cpu:isa=scalar,threads=1", "--out", folder, "--quiet"], check=True)
        files = contents(folder)
        if manifest(files) != files["manifest.json"]:
            missed.append("manifest.json differs from the manifest that this test computes")
        changes = Changes(rng, files)
        kinds = [getattr(changes, k) for k in sorted(vars(Changes)) if k not in ("any", "exchange", "log") and not k.startswith("_")]
        # Exchanges two JSON files. The file that replaces the protocol contains no format number.
        first = [lambda f: changes.exchange(f, "environment.json", "protocol.json")]
        first[0].__name__ = "files_exchanged"
        # Each derived file is forged at least once.
        for name in [n for n in DERIVED if n in files]:
            first.append(lambda f, name=name: changes.derived_file_forged(f, name))
            first[-1].__name__ = "derived_file_forged"
        while sum(done.values()) < count and len(missed) < 10:
            change = first.pop() if first else rng.choice(kinds)
            now = dict(files)
            names = change(now)
            if not names:
                continue
            touched = {n for n in set(now) | set(files) if now.get(n) != files.get(n)}
            for n in touched:
                if n in now:
                    write(os.path.join(folder, n), now[n])
                else:
                    os.remove(os.path.join(folder, n))
            said = subprocess.run([OSTEON, "verify", folder], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            text = said.stdout.decode(errors="replace")
            # A change in the manifest may be reported for another file or for a file that cannot be read.
            named = any("  %s " % n in text for n in names) or "manifest.json" in names and "  " in text
            expected = 2 if any(n not in now for n in touched) and change.__name__ != "file_renamed" else 1
            if said.returncode != expected or not named:
                missed.append("%s of %s: verify ended with status %d, expected %d and the file's name; it printed: %s"
                              % (change.__name__, names, said.returncode, expected, text[:300]))
            done[change.__name__] += 1
            for n in touched:
                if n in files:
                    write(os.path.join(folder, n), files[n])
                else:
                    os.remove(os.path.join(folder, n))
        if subprocess.run([OSTEON, "verify", folder, "--quiet"]).returncode != 0:
            missed.append("the restored bundle is not valid at the end")
    finally:
        shutil.rmtree(scratch)
    for kind, n in sorted(done.items()):
        print("%6d %s" % (n, kind.replace("_", " ")))
    print("%d changes, %d not detected" % (sum(done.values()), len(missed)))
    for text in missed:
        print("FAIL: " + text)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
