#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Proves with exact integers the bounds of docs/spec/arithmetic.md, section 18, that cbmc does not prove (AR-INT-3).

There are two kinds of proofs. docs/qualification/proofs.md lists them together with those of cbmc.

  expression  A C expression is read from its source without change and evaluated with intervals:
              each operand is an interval with the width of its C type, and each operation gives the
              exact interval of its results. A result that exceeds the width of its type or the
              stated bound is a failure. An expression that is not found in its source is a failure
              too, because the proof must then be reviewed.
  argument    A short proof by hand whose finite part is computed here. An identity of polynomials of
              degree at most 4 in each variable is checked at 5 values of each variable. A function that
              is linear in each variable is checked at the corners of its ranges. A root is checked by
              exact comparison.

Each proof runs a second time with wider ranges, in which it must fail.

Covers: AR-INT-3, REQ-PROOF
"""

import itertools
import os
import re
import sys
from fractions import Fraction
from math import isqrt

ROOT = os.environ.get("srcdir") or os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")

LENGTH = 8 * 10**12
SPACING = 10**11
N_MAX = 2**60 + 2**52  # OST_ROTATION_N_MAX, which ost_map_make and ost_sweep_count check
N_MIN = 2**59
Q_MAX = 1074815566  # bound of a quaternion's component: 1.001 * 2^30 + 1
IMAGE = 1386 * 10**10  # bound of a corner's image under a rotation


class Failure(Exception):
    pass


def require(holds, text):
    if not holds:
        raise Failure(text)


def source(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as text:
        return re.sub(r"\s+", " ", text.read())


# ------------------------------------------------------------- expressions


class Interval:
    """The integers from low to high, in a signed type of `bits` bits."""

    def __init__(self, bits, low, high):
        require(-(2 ** (bits - 1)) <= low and high < 2 ** (bits - 1), f"[{low}, {high}] exceeds {bits} bits")
        self.bits, self.low, self.high = bits, low, high

    def combined(self, other, ends):
        return Interval(max(self.bits, other.bits), min(ends), max(ends))

    def __add__(self, other):
        return self.combined(other, [self.low + other.low, self.high + other.high])

    def __sub__(self, other):
        return self.combined(other, [self.low - other.high, self.high - other.low])

    def __mul__(self, other):
        return self.combined(other, [a * b for a in (self.low, self.high) for b in (other.low, other.high)])

    def __lshift__(self, other):
        require(0 <= other.low and other.high < self.bits, f"a shift by up to {other.high}")
        return Interval(self.bits, min(self.low << other.low, self.low << other.high), self.high << other.high)

    def __rshift__(self, other):
        require(0 <= other.low and other.high < self.bits, f"a shift by up to {other.high}")
        ends = [v >> s for v in (self.low, self.high) for s in (other.low, other.high)]
        return Interval(self.bits, min(ends), max(ends))

    def __neg__(self):
        return Interval(self.bits, -self.high, -self.low)


class Cast:
    """Represents the cast (type)x, written as Cast(bits) ** x in Python, because a power has the
    precedence of a cast."""

    def __init__(self, bits):
        self.bits = bits

    def __pow__(self, value):
        return Interval(self.bits, value.low, value.high)


TYPES = {"ost_i128": 128, "int64_t": 64, "int32_t": 32, "int": 32}
TOKEN = re.compile(
    r"\((?P<cast>ost_i128|int64_t|int32_t|int)\)|INT64_C\((?P<long>\d+)\)|(?P<number>\d+)"
    r"|(?P<name>[A-Za-z_]\w*(?:(?:->|\.)[A-Za-z_]\w*|\[[^\]]*\])*)"
)


def evaluated(expression, ranges):
    def python(match):
        if match["cast"]:
            return f"Cast({TYPES[match['cast']]}) ** "
        if match["long"] or match["number"]:
            value = match["long"] or match["number"]
            return f"Interval({64 if match['long'] else 32}, {value}, {value})"
        return f"ranges[{match['name']!r}]"

    return eval(TOKEN.sub(python, expression), {"Cast": Cast, "Interval": Interval, "ranges": ranges})


def int32(low, high):
    return (32, low, high)


def int64(low, high):
    return (64, low, high)


def within(bits, limit):
    return (bits, -limit, limit)


M = within(64, N_MAX)  # |M[a][b]| <= N: rotation_entries
VERTEX = int32(0, 2**20)
EDGE = within(64, 2**20)
NORMAL = within(64, 2**41)

# Rule, source, expression, ranges of its operands, and bound of its magnitude.
EXPRESSIONS = [
    ("AR-POSE-3", "src/core/pose.c", "norm * 1000000", {"norm": within(128, 4 * 2**62)}, 2**84),
    ("AR-MESH-3", "src/core/mesh_snap.c", "(p - corner) << f",
     {"p": within(64, LENGTH), "corner": within(64, LENGTH), "f": int32(8, 10)}, 2**54),
    ("AR-TOOL-2", "src/core/tool_geometry.c", "2 * max + voxel", {"max": within(64, LENGTH), "voxel": int64(10**6, SPACING)}, 2**44),
    ("AR-TOOL-2", "src/core/tool_geometry.c", "ost_rhe_div(2 * max + voxel, 2 * voxel) * voxel + voxel",
     # |RHE(r) v| <= |r| v + v / 2
     {"ost_rhe_div(2 * max + voxel, 2 * voxel) * voxel": within(64, LENGTH + SPACING), "voxel": int64(10**6, SPACING)}, 2**43),
    ("AR-CT-4", "src/cpu/ref/import.c", "p - origin", {"p": within(64, LENGTH), "origin": within(64, LENGTH)}, 2**44),
    ("AR-CUB-2", "src/cpu/ref/import.c", "(2 * i + 1) * cubic - rect",
     {"i": int64(0, 2**14 - 1), "cubic": int64(10**6, SPACING), "rect": int64(10**6, SPACING)}, 2**52),
    ("AR-CUB-2", "src/cpu/ref/import.c", "(n - index * d) << WEIGHT_BITS",
     {"n - index * d": int64(0, 2 * SPACING), "WEIGHT_BITS": int32(15, 15)}, 2**53),  # a remainder is below d
    ("AR-VOX-1", "src/cpu/ref/voxelize.c", "u[Y] * v[Z] - u[Z] * v[Y]", dict.fromkeys(["u[Y]", "v[Z]", "u[Z]", "v[Y]"], EDGE), 2**41),
    ("AR-VOX-2", "src/cpu/ref/voxelize.c", "dy * (z - a[Z]) - dz * (y - a[Y])",
     {"dy": EDGE, "dz": EDGE, "z": int64(0, 2**20), "y": int64(0, 2**20), "a[Z]": VERTEX, "a[Y]": VERTEX}, 2**41),
    ("AR-VOX-3", "src/cpu/ref/voxelize.c", "nx * a[X] - ny * (y - a[Y]) - nz * (z - a[Z])",
     {"nx": NORMAL, "ny": NORMAL, "nz": NORMAL, "y": int64(0, 2**20), "z": int64(0, 2**20)} | dict.fromkeys(["a[X]", "a[Y]", "a[Z]"], VERTEX),
     3 * 2**61),
    ("AR-VOX-3", "src/cpu/ref/voxelize.c", "crossing - nx * half",
     {"crossing": within(64, 3 * 2**61), "nx": NORMAL, "half": int64(2**7, 2**9)}, 3 * 2**61 + 2**50),
    ("AR-VOX-3", "src/cpu/ref/voxelize.c", "nx * width", {"nx": NORMAL, "width": int64(2**8, 2**10)}, 2**51),
    ("AR-MOTOR-2", "src/core/motor.c", "motor->phase * STEPS", {"motor->phase": int64(0, 6 * 10**10), "STEPS": int32(4096, 4096)}, 2**48),
    ("AR-MOTOR-7", "src/core/motor.c", "(int64_t)p.qw * OST_Q30_ONE",
     {"p.qw": within(32, Q_MAX), "OST_Q30_ONE": int32(2**30, 2**30)}, 2**60 + 2**51),
    ("AR-SWEEP-1", "src/core/sweep.c", "(ost_i128)r->m[row][a] * lo[a]", {"r->m[row][a]": M, "lo[a]": within(64, LENGTH)}, 2**103),
    ("AR-SWEEP-1", "src/core/sweep.c", "part[0][c & 1] + part[1][c >> 1 & 1] + part[2][c >> 2]",
     dict.fromkeys(["part[0][c & 1]", "part[1][c >> 1 & 1]", "part[2][c >> 2]"], within(128, N_MAX * LENGTH)), 2**105),
    ("AR-SWEEP-2", "src/core/sweep.c", "to[corner] - from[corner] + dt[axis]",
     {"to[corner]": within(64, IMAGE), "from[corner]": within(64, IMAGE), "dt[axis]": within(64, 2 * LENGTH)}, 2**46),
    ("AR-SWEEP-2", "src/core/sweep.c", "(ost_i128)d * d", {"d": within(64, 2**46)}, 2**92),
    ("AR-SWEEP-2", "src/core/sweep.c", "n * n * voxel_squared", {"n": (128, 1, 4096), "voxel_squared": (128, 1, SPACING**2)}, 2**98),
    ("AR-SWEEP-3", "src/core/sweep.c", "2 * d * d", {"d": within(128, N_MAX)}, 2**122),  # d^2 <= Na Nb (Cauchy)
    ("AR-SWEEP-4", "src/core/sweep.c", "(n - k) * a + k * b",
     {"(n - k)": int64(0, 4095), "k": int64(1, 4096), "a": within(64, LENGTH), "b": within(64, LENGTH)}, 2**56),
    ("AR-MAP-7", "src/core/map.c", "(ost_i128)r.n * tool->voxel", {"r.n": int64(N_MIN, N_MAX), "tool->voxel": int64(10**6, SPACING)}, 2**98),
    ("AR-MAP-7", "src/core/map.c", "bone->origin.x - pose->t.x", dict.fromkeys(["bone->origin.x", "pose->t.x"], within(64, LENGTH)), 2**44),
    ("AR-MAP-7", "src/core/map.c", "(ost_i128)r.m[0][a] * from[0] + (ost_i128)r.m[1][a] * from[1] + (ost_i128)r.m[2][a] * from[2]",
     {f"r.m[{b}][a]": M for b in range(3)} | {f"from[{b}]": within(64, 2 * LENGTH) for b in range(3)}, 2**106),
    ("AR-MAP-7", "src/core/map.c", "one * (turned - (ost_i128)r.n * corner[a])",
     {"one": (128, 2**20, 2**20), "turned": within(128, 3 * N_MAX * 2 * LENGTH), "r.n": int64(N_MIN, N_MAX), "corner[a]": within(64, LENGTH)}, 2**126),
    ("AR-MAP-1", "src/core/map.c", "one * r.m[b][a] * bone->spacing.x",
     {"one": (128, 2**20, 2**20), "r.m[b][a]": M, "bone->spacing.x": int64(10**6, SPACING)}, 2**118),
    ("AR-MAP-2", "src/core/map.c", "OST_MAP_RATIO_MAX * tool->voxel", {"OST_MAP_RATIO_MAX": int32(16, 16), "tool->voxel": int64(10**6, SPACING)}, 2**41),
]


def expression_holds(rule, path, expression, ranges, bound, wide):
    require(expression in source(path), f"{path} does not hold this expression: read the proof again")
    # A subexpression whose range is proved separately is replaced by a name.
    text, known = expression, {}
    for name in sorted(ranges, key=len, reverse=True):
        bits, low, high = ranges[name]
        if wide:
            low, high = max(4 * min(low, 0) + max(low, 0), -(2 ** (bits - 1))), min(4 * high, 2 ** (bits - 1) - 1)
        known[name] = Interval(bits, low, high)
    for number, name in enumerate(n for n in sorted(ranges, key=len, reverse=True) if not TOKEN.fullmatch(n)):
        text = text.replace(name, f"part_{number}")
        known[f"part_{number}"] = known[name]
    result = evaluated(text, known)
    require(max(-result.low, result.high) <= bound, f"[{result.low}, {result.high}] exceeds the bound {bound}")


# --------------------------------------------------------------- arguments


def rotation_entries(wide):
    """Proves |M[a][b]| <= N (AR-POSE-4): M M' = N^2 I, so the squares of a row sum to N^2.

    Both sides have at most degree 4 in each component. Therefore they are equal if they are equal at five values of
    each component.
    """
    for w, x, y, z in itertools.product(range(5), repeat=4):
        n = w * w + x * x + y * y + z * z
        m = [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
        for a, b in itertools.product(range(3), repeat=2):
            product = sum(m[a][c] * m[b][c] for c in range(3))
            require(product == (n * n if a == b else 0) + wide, f"M M' differs from N^2 I at {(w, x, y, z)}")
    text = source("src/core/rotation.h")
    for entry in ("w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)",
                  "2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)",
                  "2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z",
                  "w * w + x * x + y * y + z * z"):
        require(entry in text, "rotation.h does not hold this matrix")


def rotation_norm(wide):
    """Bounds N for a pose that was read and for an interpolated pose, whose components are rounded (AR-POSE-3, AR-MAP-7).

    An interpolated quaternion is at most as long as the longer of its two ends. Rounding changes each of the four
    components by at most 1/2, and therefore |q| by at most 1.
    """
    longest = isqrt(1002001 * 2**60 // 10**6) + 2 + wide * 2**20
    require(longest**2 <= N_MAX, "N exceeds OST_ROTATION_N_MAX")
    text = source("src/core/map.c") + source("src/core/sweep.c")
    require("r.n < OST_ROTATION_N_MIN || r.n > OST_ROTATION_N_MAX" in text, "ost_map_make does not check N")
    require("n >= OST_ROTATION_N_MIN && n <= OST_ROTATION_N_MAX" in text, "ost_sweep_count does not check N")


def weighted_sum(wide):
    """Proves |S| <= 2^60 (AR-CUB-2) for every partial sum. A partial sum is linear in each weight and each
    voxel, so its extremes are at the corners of the ranges."""
    one = 2**15
    for weights in itertools.product((0, one << wide), repeat=3):
        low = high = 0
        for d in itertools.product((0, 1), repeat=3):
            weight = 1
            for chosen, w in zip(d, weights):
                weight *= w if chosen else one - w
            ends = (weight * -(2**15), weight * (2**15 - 1))
            low, high = low + min(ends), high + max(ends)
            require(abs(weight) <= 2**45 and -(2**60) <= low and high <= 2**60, f"S is in [{low}, {high}]")


def motor_turn(wide):
    """Proves |w C + z S| <= |q| |(C, S)| < 2^60.01 (AR-MOTOR-4) by Cauchy's inequality, with every entry
    of the table. The quotient fits int32."""
    table = re.search(r"motor_sine\[\] = \{(.*?)\}", source("src/core/motor_table.h"))
    sine = [int(v) for v in table[1].split(",") if v.strip()]
    require(len(sine) == 2049, "the table has 2049 sines")
    greatest = max(sine[2048 - k] ** 2 + sine[k] ** 2 for k in range(2049))
    square = N_MAX * greatest << 2 * wide
    require(square**100 < 2**12002, f"(w C + z S)^2 reaches {square}")
    require(isqrt(square) // 2**30 + 1 < 2**31, "the quotient exceeds int32")


def motor_unit(wide):
    """Bounds the components of a scaled quaternion (AR-MOTOR-7). With r = floor(sqrt N), |c| <= sqrt N < r + 1.
    Therefore 2^30 |c| / r < 2^30 + 2^30 / r, which is at most 2^30 + 2 for N >= 2^59."""
    require(Fraction(2**30, isqrt(N_MIN >> 8 * wide)) <= 2, "a component exceeds 2^30 + 2")


def displacement(wide):
    """Bounds the displacement of a corner (AR-SWEEP-2). A corner of a box within 8 m is at most sqrt(3) * 8 m from
    the origin. The same applies to its image, which RHE moves by at most 1/2 on each axis."""
    image = isqrt(3 * (LENGTH << wide) ** 2) + 2
    require(image <= IMAGE, f"an image at {image} pm")
    along = 2 * image + 2 * LENGTH
    require(along < 2**46 and 4 * 3 * along**2 < 2**96, f"a displacement of {along} pm along an axis")
    # A quotient of ost_rhe_by requires |n| <= 2^46 D.
    require(3 * LENGTH <= 2**46, "|M c| exceeds 2^46 N")


def map_sums(wide):
    """Bounds origin + sum i column (AR-MAP-7), in the order of ost_map_block_base, at every voxel of a bone.

    Each partial sum is linear in each entry of M and in each i s. o + i s is within 8 m, so i s is within 16 m and
    p - t = o + i s - t is within 16 m. The extremes are at the corners of these ranges.
    """
    far = 2 * LENGTH << wide
    for signs in itertools.product((-1, 1), repeat=3):
        partial = 0
        for sign in signs:
            partial += sign * N_MAX * far * 2**20
            require(abs(partial) < 2**126, f"a partial sum of {partial}")
    for signs in itertools.product((-1, 1), repeat=4):
        # 2^20 (sum of M (p - t) - N corner)
        total = 2**20 * N_MAX * (sum(signs[:3]) * far + signs[3] * LENGTH)
        require(abs(total) < 2**126, f"a sum of {total}")
    require("ost_i128_of(map->origin[a]) + OST_MAP_BLOCK * (block.x * ost_i128_of(map->column[0][a]) + "
            "block.y * ost_i128_of(map->column[1][a]) + block.z * ost_i128_of(map->column[2][a]))" in source("src/core/map.c"),
            "map.c does not hold this sum")


def map_steps(wide):
    """Bounds the steps of a map (AR-MAP-3, AR-MAP-5): |column| = 2^20 |M| s <= 2^20 N 16 v = 2^24 divisor, so |step| <= 2^24.

    The squares of a column of R sum to 1, so its magnitudes sum to at most sqrt(3). The three steps, each rounded by at
    most 1/2, therefore sum to at most sqrt(3) * 2^24 + 3/2. The proof by cbmc (map_coordinate) assumes the floor of
    this sum.
    """
    require(2**20 * 16 << wide <= 2**24, "a step exceeds 2^24")
    twice = isqrt(4 * 3 * 2**48) + 3  # floor(2 sqrt(3) 2^24 + 3)
    require(twice // 2 <= 29058992, f"steps sum to {twice / 2}")
    require(15 * 29058992 < 435884881 < 2**29, "D exceeds its bound")
    require("int64_t most = 29058992;" in source("tests/proof/map.c"), "map_coordinate takes another bound")


def quotient(wide):
    """Bounds the products in ost_rhe_div128 (AR-INT-2). The quotient q is rounded down: n = q d + r with 0 <= r < d.
    Therefore |q d| <= |n| + d, for |n| < 2^126 and d < 2^98."""
    require(2**126 + (2**98 << 29 * wide) < 2**127, "q d exceeds 128 bits")
    # For |n| <= 2^46 d, the quotient rounded down and the next integer fit the 64 bits of ost_rhe_by.
    require((2**46 << 17 * wide) + 2 < 2**63, "a quotient exceeds 64 bits")


def divider(wide):
    """Bounds the products in ost_floor_by (src/core/divider.h): |h I| < 2^126, and e differs from the floor by at
    most one. Therefore |e D| <= |n| + 2 D."""
    d = 2**61  # the worst case is the least d, because 2^124 / d - 2^124 / (d + 1) decreases with d
    error = Fraction(2**124, d) - Fraction(2**124, d + 1) + 1
    require(error <= 5, "X - I exceeds 5")
    require(2**124 // (2**61 + 1) < 2**63 and 2**124 // 2**62 >= 2**62, "I is outside [2^62, 2^63)")
    h = (2**62 << wide) + 1  # |n| <= 2^46 D and D < 2^(s + 62)
    require(h * 2**63 < 2**126, "h I exceeds 2^126")
    require(Fraction(5 * h + 2**63, 2**78) < Fraction(1, 2**12), "e is farther than one from the floor")
    require(2**126 + 2 * 2**120 < 2**127, "e D exceeds 128 bits")


def density_sum(wide):
    """Proves that a sum of densities fits int64 (AR-REM-6), for at most 2^36 voxels of at most 2^15 in magnitude."""
    require(2**36 * 2**15 << 13 * wide < 2**63, "a sum of densities exceeds int64")
    require("int64_t density[OST_CLASS_MAX]" in source("include/osteon/event.h"), "the sums have another type")


def constants(wide):
    """Proves that the bounds themselves fit their types (AR-LEN-1, AR-GRID-3, AR-POSE-3, AR-TOOL-1)."""
    require(LENGTH << wide < 2**43 and SPACING < 2**37 and 1001 * 2**30 < 1000 * 2**31, "a bound exceeds its type")
    text = source("include/osteon/length.h") + source("include/osteon/grid.h")
    for name, value in ("OST_LENGTH_MAX", "(INT64_C(8000) * OST_PM_PER_MM)"), ("OST_SPACING_MAX", "(100 * OST_PM_PER_MM)"):
        require(f"#define {name} {value}" in text, f"{name} is not {value}")


ARGUMENTS = [constants, rotation_entries, rotation_norm, weighted_sum, motor_turn, motor_unit, displacement, map_sums, map_steps,
             quotient, divider, density_sum]


def main():
    failures = 0
    proofs = [(f"{e[0]} {e[2]}", lambda wide, e=e: expression_holds(*e, wide)) for e in EXPRESSIONS]
    proofs += [(p.__name__, p) for p in ARGUMENTS]
    for name, proof in proofs:
        try:
            proof(False)
            try:
                proof(True)
                verdict = "FAILED: it holds in the wider range too"
            except Failure:
                verdict = "proved"
        except Failure as failure:
            verdict = f"FAILED: {failure}"
        failures += verdict != "proved"
        print(f"{name}: {verdict}")
    print(f"{len(proofs) - failures} proved, {failures} failed")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
