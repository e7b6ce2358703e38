#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the pseudo-code of docs/spec/arithmetic.md, AR-CT-3 and AR-CT-7, with the reader of CT texts.

    docs/spec/arithmetic.md --its ```python block, unchanged---> spacings  |  equal for every text, and
    random lattices ---> texts ---> dump_lattices (src/io/text) ------> |  refused by both or by neither

The texts contain numbers with every count of digits that occurs in practice, with and without
trailing zeros, absent layers, noise that fits a lattice or does not, thirds of a millimetre,
exponents, and facts in comments. The oracle's own search for spacings (osteon_oracle.py) must agree as well.

Covers: AR-CT-3, AR-CT-4, AR-CT-7, AR-CT-8

Usage: check_lattices.py [DUMPER] [COUNT]    (default: tests/oracle/dump_lattices, 500)
OST_TEST_SEED=N replays a run. The exit status is 77 if the dumper is missing.
"""

import functools
import os
import random
import re
import subprocess
import sys
import tempfile
from fractions import Fraction

sys.dont_write_bytecode = True
import osteon_oracle as oracle
import random_cases

SKIP = 77
MM = 10**9


def pseudo_code():
    """Executes the program in the document, and returns the names that it defines."""
    root = os.environ.get("top_srcdir") or os.path.join(os.path.dirname(__file__), "..", "..")
    with open(os.path.join(root, "docs", "spec", "arithmetic.md"), encoding="utf-8") as file:
        text = file.read()
    block, = (b for b in re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S) if "def ar_ct_3" in b)
    names = {}
    exec(compile(block, "docs/spec/arithmetic.md", "exec"), names)  # pylint: disable=exec-used
    return names


# -------------------------------------------------------------------- texts


def written(rng, value, places, style):
    """Returns a coordinate (a Fraction of mm) with this number of places, in one of the styles of CT texts."""
    scaled = oracle.rhe(value * 10**places)
    digits = f"{abs(scaled):0{places + 1}d}"
    text = f"{digits[:-places]}.{digits[-places:]}" if places else digits
    if style == "stripped" and places:
        text = text.rstrip("0").rstrip(".")
    if style == "exponents" and rng.random() < 0.3:
        shift = rng.randrange(-2, 4)
        text = f"{digits}e{-places}" if shift < 0 else f"{digits}{'0' * shift}E-{places + shift}"
    return "-" + text if scaled < 0 else text


def spacing(rng):
    kind = rng.randrange(7)
    if kind == 0:
        return Fraction(rng.randrange(1, 400), 3 * rng.choice((1, 10, 100)))
    if kind == 1:
        return Fraction(rng.randrange(1, 4000), 2 ** rng.randrange(1, 14))
    if kind == 2:
        return Fraction(rng.choice(("0.3", "0.032", "0.47", "0.48828125", "0.488281", "1", "1.25", "5")))
    if kind == 3:
        return Fraction(rng.randrange(95 * MM, 101 * MM), MM)  # around the greatest spacing
    if kind == 4:
        return Fraction(rng.randrange(900, 3000), 10**6)  # around the smallest spacing
    return Fraction(rng.randrange(1000, 2 * 10**6), 10 ** rng.randrange(5, 7))


def axis_coordinates(rng, step):
    """Returns the written coordinates of an axis, in any order, without duplicates."""
    places = rng.choice([p for p in (0, 1, 2, 3, 3, 4, 4, 5, 6, 6, 7, 8, 9, 10, 12) if step > Fraction(4, 10**p) or rng.random() < 0.02])
    style = rng.choice(("plain", "plain", "stripped", "exponents"))
    start = Fraction(rng.choice((0, 0, rng.randrange(-10**6, 10**6))), 10 ** rng.randrange(3, 7))
    absent = rng.choice((0, 0, 0, 0.1, 0.5))
    layers = [k for k in range(rng.choice((2, 3, 5, 9, 20, 33)) if rng.random() < 0.98 else 1) if rng.random() >= absent] or [0]
    noise = rng.choice((0,) * 15 + (1, 3)) * Fraction(1, 10**places)
    exact = [start + k * step + rng.choice((-1, 0, 1)) * noise for k in layers]
    if rng.random() < 0.01:
        exact.append(start + len(layers) * rng.choice((1, 17000, 40000)) * step + step * Fraction(rng.randrange(1, 10), 10))
    return [written(rng, c, places, style) for c in exact]


def facts(rng, grid):
    """Returns comments with facts. Most facts are true; some are repeated, false or broken. `grid` is the grid of the
    samples, or None."""
    lines = []
    if grid is None or rng.random() < 0.6:
        return lines
    dims, steps, origin = grid
    choices = [f"dims: {dims[0]} {dims[1]} {dims[2]}", f"dims: {dims[0]}.0,{dims[1]}e0;\t{dims[2]}", f"dims: {dims[0]} {dims[1]} {dims[2] + 1}",
               f"spacing_mm: {' '.join(mm(s) for s in steps)}", f"spacing_mm: {', '.join(mm(s) + '0' * ('.' in mm(s)) for s in steps)}",
               "spacing_mm: 0.5 0.5 0.5", "spacing_mm: 1 1", f"origin_mm: {' '.join(mm(o) for o in origin)}",
               f"origin_mm: {' '.join(mm(o + s // 10) for o, s in zip(origin, steps))}", "origin_mm: 0 0", "note: of no weight",
               "note: given again", "Dims: 1 1 1", "dims : 1 1 1", "dims of: this: 3", "side: left", "dims: 1.5 1 1", "dims: -1 1 1"]
    weights = [9, 4, 1, 9, 4, 1, 1, 9, 1, 1, 4, 4, 2, 2, 2, 4, 1, 1]
    for choice in rng.choices(choices, weights, k=rng.randrange(1, 4)):
        lines.append("#" + rng.choice((" ", "", "\t ")) + "osteon" + rng.choice((" ", "  ", "\t")) + choice + rng.choice(("", " ", "\t")))
    return lines


def mm(pm):
    scaled = f"{abs(pm):010d}"
    return ("-" if pm < 0 else "") + f"{scaled[:-9]}.{scaled[-9:]}".rstrip("0").rstrip(".")


def random_text(rng, names):
    """Returns a text that contains every coordinate of each axis at least once."""
    step = spacing(rng)
    axes = []
    for _ in range(3):
        step = step if rng.random() < 0.6 else step * Fraction(rng.choice((99, 100, 101, 102)), 100) if rng.random() < 0.4 else spacing(rng)
        axes.append(axis_coordinates(rng, step))
    full = len(axes[0]) * len(axes[1]) * len(axes[2])
    if full <= 200:
        samples = [(x, y, z) for z in axes[2] for y in axes[1] for x in axes[0]]
    else:
        samples = [tuple(axis[n % len(axis)] for axis in axes) for n in range(max(map(len, axes)))]
    if rng.random() < 0.3:
        rng.shuffle(samples)
    body = [f"{x} {y} {z} 100" for x, y, z in samples]
    try:
        grid = expected(oracle.Text("\n".join(body) + "\n"), names)
    except oracle.Refused:
        grid = None
    comments = facts(rng, grid)
    for comment in comments:
        body.insert(rng.choice((0, 0, len(body), rng.randrange(len(body) + 1))), comment)
    return "\n".join(body) + ("" if rng.random() < 0.05 else "\n")


# ------------------------------------------------------------------- checks


def expected(text, names):
    """Returns (dims, spacing, origin). The program in the document computes the spacing, and the oracle
    applies AR-CT-4 and AR-CT-8."""
    given = oracle.given_spacing(text)
    found = [None] * 3
    for a in range(3):
        coordinates = sorted({sample[a] for sample in text.samples})
        if given is None:
            found[a] = names["ar_ct_3"](coordinates, text.units[a], text.rounded[a])
            if found[a] is None:
                raise oracle.Refused("no spacing")
    steps = given or tuple(names["ar_ct_7"](found))
    if given is None and steps != oracle.infer_spacing(text):
        raise AssertionError(f"the pseudo-code finds {steps}, the oracle finds {oracle.infer_spacing(text)}")
    rect = oracle.rect_geometry(text, steps)
    return rect.dims, rect.spacing, rect.origin


def lattice(text, names):
    """Returns the line that dump_lattices prints for a text."""
    dims, steps, origin = expected(oracle.Text(text), names)
    return " ".join(map(str, (*dims, *steps, *origin)))


def main():
    dumper = sys.argv[1] if len(sys.argv) > 1 else os.path.join("tests", "oracle", "dump_lattices")
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 500
    if not os.access(dumper, os.X_OK):
        print(f"# {dumper} is not built")
        return SKIP
    rng, names = random.Random(random_cases.seeded("check_lattices")), pseudo_code()
    texts = [random_text(rng, names) for _ in range(count)]
    with tempfile.TemporaryDirectory() as folder:
        paths = [os.path.join(folder, f"{n}.txt") for n in range(count)]
        for path, text in zip(paths, texts):
            with open(path, "w", encoding="ascii", newline="") as file:
                file.write(text)
        lines = subprocess.run([dumper, *paths], capture_output=True, check=True).stdout.decode().splitlines()
    cases = ((functools.partial(lattice, text, names), "refused" if line.startswith("refused") else line, f"{line}\n{text}")
             for text, line in zip(texts, lines, strict=True))
    return random_cases.agree(cases, count // 10, count - count // 10)


if __name__ == "__main__":
    sys.exit(main())
