#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Imports random NRRD volumes and compares the rect grid with the rules of docs/spec/arithmetic.md for values and orientation.

    NRRD (axes permuted, flipped, tilted; LPS, RAS, LAS; every type, in text and raw; some broken)
      ---osteon import---> digest of the rect grid, or status 2
      ---AR-FILE-4, AR-FILE-5, in fractions---> the same digest, or refused

Covers: AR-GRID-4, AR-FILE-4, AR-FILE-5

Usage: check_volumes.py [OSTEON] [COUNT]    (default: $OSTEON, else ./osteon; 80)
OST_TEST_SEED=N replays a run. The exit status is 77 if there is no command.
"""

import itertools
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
from fractions import Fraction

sys.dont_write_bytecode = True
import osteon_oracle as oracle
import random_cases

SKIP = 77
TYPES = {"int8": ("b", -2**7, 2**7 - 1), "uint8": ("B", 0, 2**8 - 1), "int16": ("h", -2**15, 2**15 - 1), "uint16": ("H", 0, 2**16 - 1),
         "int32": ("i", -2**31, 2**31 - 1), "uint32": ("I", 0, 2**32 - 1), "int64": ("q", -2**63, 2**63 - 1),
         "uint64": ("Q", 0, 2**64 - 1), "float": ("f", None, None), "double": ("d", None, None)}
SIGNS = {"LPS": (1, 1, 1), "RAS": (-1, -1, 1), "LAS": (1, -1, 1)}


# ------------------------------------------------------------------ the text


def orient(sizes, directions, origin):
    """Applies AR-FILE-5. Returns dims, spacing, origin and, for every axis w, the file's axis and
    whether it is flipped."""
    if any(abs(c) > 10**11 for d in directions for c in d):
        raise oracle.Refused("a voxel of more than 100 mm")
    (a, b, c), (d, e, f), (g, h, i) = directions
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) == 0:
        raise oracle.Refused("no space")
    best = max(itertools.permutations(range(3)),  # in the document's order, because max returns the first of equal values
               key=lambda keeps: abs(directions[0][keeps[0]] * directions[1][keeps[1]] * directions[2][keeps[2]]))
    axis = [best.index(w) for w in range(3)]
    spacing = [abs(directions[axis[w]][w]) for w in range(3)]
    for w in range(3):
        if 8 * sum(abs(directions[a][w]) * max(sizes[a] - 1, 64) for a in range(3) if a != axis[w]) > spacing[w]:
            raise oracle.Refused("oblique")
    flipped = [directions[axis[w]][w] < 0 for w in range(3)]
    first = list(origin)
    for w in range(3):
        if flipped[w]:
            first = [o + (sizes[axis[w]] - 1) * c for o, c in zip(first, directions[axis[w]])]
    return [sizes[axis[w]] for w in range(3)], spacing, first, list(zip(axis, flipped))


def density(value, kind, clamp, nan_as_air):
    """Converts a file's value, a Fraction or None for NaN, to a density according to AR-FILE-4."""
    low, high = TYPES[kind][1:]
    if value is None:
        if low is not None or not nan_as_air:
            raise oracle.Refused("NaN")
        return -1024
    if low is not None and (value.denominator != 1 or not low <= value <= high):
        raise oracle.Refused(f"{value} is no {kind}")
    value = oracle.rhe(value)
    if not -32768 <= value <= 32767 and not clamp:
        raise oracle.Refused("beyond int16")
    return min(max(value, -32768), 32767)


def rect_of(sizes, directions, origin, values, kind, clamp, nan_as_air):
    dims, spacing, first, axes = orient(sizes, directions, origin)
    oracle.check_limits(dims, spacing, first)
    voxels = []
    for k, j, i in itertools.product(range(dims[2]), range(dims[1]), range(dims[0])):
        at = [0, 0, 0]
        for (a, flip), index in zip(axes, (i, j, k)):
            at[a] = sizes[a] - 1 - index if flip else index
        voxels.append(density(values[at[0] + sizes[0] * (at[1] + sizes[1] * at[2])], kind, clamp, nan_as_air))
    return oracle.Grid(dims, spacing, first, voxels)


# --------------------------------------------------------------- the files


def mm(pm):
    digits = f"{abs(pm):010d}"
    return f"{'-' if pm < 0 else ''}{digits[:-9]}.{digits[-9:]}"


def random_file(rng):
    """Makes a random file. Returns its bytes and the arguments of rect_of."""
    sizes = [rng.randrange(1, 7) for _ in range(3)]
    if rng.random() < 0.3:
        sizes[rng.randrange(3)] = rng.randrange(60, 90)
    keeps = rng.sample(range(3), 3)
    tilt = rng.choice((0, 0, 3, 10**5, 6 * 10**5, 10**7))
    directions = [[rng.randrange(-tilt, tilt + 1) for _ in range(3)] for _ in range(3)]
    for a in range(3):
        directions[a][keeps[a]] = rng.choice((1, -1)) * rng.randrange(400 * 10**6, 1200 * 10**6)
    if rng.random() < 0.05:
        directions[rng.randrange(3)] = [0, 0, 10**9]
    origin = [rng.randrange(-300 * 10**9, 300 * 10**9) for _ in range(3)]
    space = rng.choice(tuple(SIGNS))
    kind, as_text, clamp = rng.choice(tuple(TYPES)), rng.random() < 0.6, rng.random() < 0.6
    nan_as_air = rng.random() < 0.5
    code, low, high = TYPES[kind]
    count = sizes[0] * sizes[1] * sizes[2]
    if low is None:
        words = [f"{rng.randrange(-70000, 70000)}e-{rng.randrange(1, 3)}" for _ in range(count)]
        if rng.random() < 0.4:
            words[rng.randrange(count)] = rng.choice(("nan", "-nan", "+NaN"))
    else:
        words = [str(rng.randrange(max(low, -1000), min(high, 1000) + 1)) for _ in range(count)]
        if clamp:
            words[rng.randrange(count)] = str(rng.choice((low, high)))
        if as_text and rng.random() < 0.2:
            words[rng.randrange(count)] = rng.choice((f"{low - 1}", f"{high + 1}", "1.5", "70e-1", "5.000", "1e30", "nan"))
    values = [None if "nan" in word.lower() else Fraction(word) for word in words]
    head = (f"NRRD0005\ntype: {kind}\ndimension: 3\nspace: {space}\nsizes: {' '.join(map(str, sizes))}\nspace directions: "
            + " ".join(f"({','.join(mm(c) for c in d)})" for d in directions)
            + f"\nspace origin: ({','.join(mm(c) for c in origin)})\nencoding: {'text' if as_text else 'raw'}\nendian: little\n\n")
    if as_text:
        body = (rng.choice((" ", "\n")).join(words) + "\n").encode()
    else:
        numbers = [float("nan") if v is None else float(v) if low is None else int(v) for v in values]
        body = struct.pack(f"<{count}{code}", *numbers)
        values = [None if n != n else Fraction(n) for n in struct.unpack(f"<{count}{code}", body)]
    signs = SIGNS[space]
    return head.encode() + body, ([list(sizes)] + [[[c * s for c, s in zip(d, signs)] for d in directions]]
                                  + [[c * s for c, s in zip(origin, signs)], values, kind, clamp, nan_as_air])


def case(rng, program, folder):
    """Makes a random file for random_cases.agree. Returns the oracle's digest of its rect grid, and the command's."""
    path, out = os.path.join(folder, "v.nrrd"), os.path.join(folder, "o.nrrd")
    content, arguments = random_file(rng)
    with open(path, "wb") as file:
        file.write(content)
    words = [program, "import", path, "--out", out, "--backend", "ref", "--json", "--cubic", "1"]
    words += ["--clamp"] * arguments[-2] + ["--nan-as-air"] * arguments[-1]
    done = subprocess.run(words, capture_output=True, check=False)
    if done.returncode == 0:
        got = next(stage["sha256"] for stage in json.loads(done.stdout)["stages"] if stage["name"] == "rect")
    else:
        got = "refused" if done.returncode == 2 else f"status {done.returncode}"
    return (lambda: oracle.grid_digest(rect_of(*arguments), oracle.KIND_RECT), got,
            content.partition(b"\n\n")[0].decode() + "\n" + done.stderr.decode())


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("OSTEON", "./osteon")
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 80
    if not os.access(program, os.X_OK):
        print(f"# {program} is not built")
        return SKIP
    rng = random.Random(random_cases.seeded("check_volumes"))
    # The example of AR-FILE-5.
    example = orient([201, 3, 3], [[-800000000, 400000, 0], [0, 800000000, 0], [0, 0, 800000000]], [100 * 10**9, 20 * 10**9, -5 * 10**9])
    assert example[2] == [-60 * 10**9, 20080000000, -5 * 10**9], example
    with tempfile.TemporaryDirectory() as folder:
        return random_cases.agree((case(rng, program, folder) for _ in range(count)), count // 20, count - count // 4)


if __name__ == "__main__":
    sys.exit(main())
