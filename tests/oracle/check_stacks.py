#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Imports random stacks of PNG slices and compares the rect grid with rule AR-FILE-9 of docs/spec/arithmetic.md.

    folder of PNG (numbers with and without zeros; names, sizes or depths that may differ; a slice that may be missing)
      ---osteon import---> digest of the rect grid, or status 2
      ---AR-FILE-9, AR-FILE-4, AR-FILE-6---> the same digest, or refused

Covers: AR-FILE-9

Usage: check_stacks.py [OSTEON] [COUNT]    (default: $OSTEON, else ./osteon; 80)
OST_TEST_SEED=N replays a run. The exit status is 77 if there is no command, or if it was built without libpng.
"""

import itertools
import json
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

sys.dont_write_bytecode = True
import osteon_oracle as oracle
import random_cases

SKIP = 77
AXES = {"L": (0, 1), "R": (0, -1), "P": (1, 1), "A": (1, -1), "S": (2, 1), "I": (2, -1)}


# ------------------------------------------------------------------ the text


def ordered(names):
    """Returns the names in the order of AR-FILE-9."""
    split = [re.findall(r"\d+|\D", name) for name in names]
    forms = [[None if part.isdigit() else part for part in parts] for parts in split]
    if any(form != forms[0] for form in forms):
        raise oracle.Refused("names differ")
    numbers = [[int(part) for part in parts if part.isdigit()] for parts in split]
    varying = [i for i in range(len(numbers[0])) if len({n[i] for n in numbers}) > 1]
    if len(names) > 1 and len(varying) != 1:
        raise oracle.Refused("more or less than one number differs")
    if len(names) == 1:
        return names
    order = sorted((n[varying[0]], name) for n, name in zip(numbers, names))
    if [number for number, _ in order] != list(range(order[0][0], order[0][0] + len(names))):
        raise oracle.Refused("a slice is missing, or there are two")
    return [name for _, name in order]


def rect_of(slices, spacing, code, clamp):
    """Returns the rect grid in LPS that the slices form. `slices` is {name: (width, height, bits, rows)}."""
    names = ordered(sorted(slices))
    width, height, bits, _ = slices[names[0]]
    if any(slices[name][:3] != (width, height, bits) for name in names):
        raise oracle.Refused("slices differ")
    sizes = [width, height, len(names)]
    place = [AXES[letter] for letter in code]  # the axis and the direction of columns, rows and slices
    of_axis = [next(a for a in range(3) if place[a][0] == w) for w in range(3)]
    dims = [sizes[a] for a in of_axis]
    steps = [spacing[a] for a in of_axis]
    origin = [0 if place[a][1] > 0 else -(sizes[a] - 1) * spacing[a] for a in of_axis]
    oracle.check_limits(dims, steps, origin)
    voxels = []
    for k, j, i in itertools.product(range(dims[2]), range(dims[1]), range(dims[0])):
        at = [0, 0, 0]
        for w, index in enumerate((i, j, k)):
            a = of_axis[w]
            at[a] = index if place[a][1] > 0 else sizes[a] - 1 - index
        value = slices[names[at[2]]][3][at[1]][at[0]]
        if value > 32767 and not clamp:
            raise oracle.Refused("beyond int16")
        voxels.append(min(value, 32767))
    return oracle.Grid(dims, steps, origin, voxels)


# ----------------------------------------------------------------- the files


def png(width, height, bits, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    raw = b"".join(b"\0" + struct.pack(f">{width}{'B' if bits == 8 else 'H'}", *row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def random_stack(rng):
    """Returns a random stack as {name: (width, height, bits, rows)}. Some stacks contain a fault."""
    width, height, bits, count = rng.randrange(1, 6), rng.randrange(1, 6), rng.choice((8, 16)), rng.randrange(1, 15)
    first, digits, fixed = rng.randrange(0, 120), rng.choice((1, 1, 4)), rng.randrange(30)
    fault = rng.choice((None,) * 9 + ("gap", "name", "fixed", "size", "bits", "twice"))
    top_of_16, slices = rng.choice((32767,) * 4 + (40000,)), {}
    for number in range(first, first + count):
        last = number == first + count - 1
        if fault == "gap" and number == first + count // 2:
            continue
        name = f"s{fixed + (fault == 'fixed' and last)}_{'b' if fault == 'name' and last else 'a'}{number:0{digits}d}.png"
        form = (width + (fault == "size" and last), height, 24 - bits if fault == "bits" and last else bits)
        top = 255 if form[2] == 8 else top_of_16
        rows = [[rng.randrange(top + 1) for _ in range(form[0])] for _ in range(form[1])]
        slices[name] = form + (rows,)
        if fault == "twice" and last:
            slices[name.replace("_a", "_a0")] = slices[name]
    return slices or random_stack(rng)


def case(rng, program, folder):
    """Makes a random stack for random_cases.agree. Returns the oracle's digest of its rect grid, and the command's."""
    stack, out = os.path.join(folder, "stack"), os.path.join(folder, "o.nrrd")
    shutil.rmtree(stack, ignore_errors=True)
    os.mkdir(stack)
    slices = random_stack(rng)
    for name, form in slices.items():
        with open(os.path.join(stack, name), "wb") as file:
            file.write(png(*form))
    spacing = [rng.randrange(20, 900) * 10**6 for _ in range(3)]
    code = "".join(rng.choice(pair) for pair in rng.sample(("LR", "PA", "SI"), 3))
    clamp = rng.random() < 0.5
    words = [program, "import", stack, "--out", out, "--backend", "ref", "--json", "--cubic", "1", "--orientation", code]
    words += ["--spacing", ",".join(f"0.{s // 10**6:03d}" for s in spacing)] + ["--clamp"] * clamp
    done = subprocess.run(words, capture_output=True, check=False)
    if done.returncode == 0:
        got = next(stage["sha256"] for stage in json.loads(done.stdout)["stages"] if stage["name"] == "rect")
    else:
        got = "refused" if done.returncode == 2 else f"status {done.returncode}"
    return (lambda: oracle.grid_digest(rect_of(slices, spacing, code, clamp), oracle.KIND_RECT), got,
            f"{sorted(slices)} {code} {spacing}\n{done.stderr.decode()}")


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("OSTEON", "./osteon")
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 80
    if not os.access(program, os.X_OK):
        print(f"# {program} is not built")
        return SKIP
    libraries = json.loads(subprocess.run([program, "devices", "--json"], capture_output=True, check=True).stdout)["libraries"]
    if not any(library["name"] == "png" and library["available"] for library in libraries):
        print("# built without libpng")
        return SKIP
    rng = random.Random(random_cases.seeded("check_stacks"))
    # The example of AR-FILE-9.
    assert ordered(["a_10.tif", "a_11.tif", "a_9.tif"]) == ["a_9.tif", "a_10.tif", "a_11.tif"]
    with tempfile.TemporaryDirectory() as folder:
        return random_cases.agree((case(rng, program, folder) for _ in range(count)), count // 20, count - count // 4)


if __name__ == "__main__":
    sys.exit(main())
