#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes the numbers of docs/design/thesis-notes.md again, with literal implementations of the
thesis' algorithms.

Covers: AR-CUB-2, AR-TOOL-2, REQ-NOTES
"""

import itertools
import struct
import sys
from collections import Counter
from fractions import Fraction

sys.dont_write_bytecode = True
from osteon_oracle import Axis, ceil, floor, rhe

MM = 10**9


def f32(value):
    """Rounds a double to float32. A sum or quotient of two float32 values, computed in double, is exact
    enough for this rounding to be correct."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def literal_import(size, minimum, decimals, count):
    """Computes Alg. 2.4 literally: text to float, (p - min) / size in float, truncated. Returns (number of
    empty layers, number of layers that occur more than once)."""
    s, low = f32(float(size)), f32(float(minimum))
    met = Counter()
    for k in range(count):
        text = f"{float(Fraction(minimum) + k * Fraction(size)):.{decimals}f}"
        met[int(f32(f32(f32(float(text)) - low) / s))] += 1
    return sum(1 for k in range(count) if met[k] == 0), sum(1 for times in met.values() if times > 1)


def lost_layers():
    table = {("0.3", "0", 4): 176, ("0.032", "0", 4): 163, ("0.488281", "0", 4): 114, ("0.48828125", "0", 4): 112,
             ("0.47", "-57.34", 4): 32, ("0.47", "0", 4): 0, ("0.3", "0", 6): 176, ("0.032", "0", 6): 163,
             ("0.488281", "0", 6): 25, ("0.48828125", "0", 6): 6, ("0.47", "-57.34", 6): 32}
    for (size, minimum, decimals), lost in table.items():
        assert literal_import(size, minimum, decimals, 600) == (lost, lost), (size, minimum, decimals)
        # By AR-CT-3 and AR-CT-4 each layer must occur exactly once for the same positions.
        c = [rhe((Fraction(minimum) + k * Fraction(size)) * 10**decimals) * 10 ** (9 - decimals) for k in range(60)]
        axis = Axis(c, {10 ** (9 - decimals)})
        assert [rhe(Fraction(p - c[0], axis.spacing)) for p in c] == list(range(60))
    # Alg. 2.3: dims = round((ceilMultiple(max) - floorMultiple(min)) / size) is one layer short
    # if the positions are multiples of the size.
    size, count = Fraction(3, 10), 600
    low, high = Fraction(0), (count - 1) * size
    assert rhe((ceil(high / size) * size - floor(low / size) * size) / size) == count - 1


def alg_2_5(z, cubic, rect):
    def rtz(q):
        return int(q)

    before, current = rtz(Fraction((z - 1) * cubic, rect)), rtz(Fraction(z * cubic, rect))
    return current if Fraction(z * cubic - before * rect, cubic) >= Fraction(1, 2) else before


def choice_without_effect():
    for cubic, rect in itertools.product(range(1, 60), repeat=2):
        for z in range(40):
            assert alg_2_5(z, cubic, rect) == floor(Fraction(z * cubic, rect))


def intersection_box():
    """Computes Alg. 2.8 in two axes (the third is not needed). A corner of the bone is inside the tool
    but outside the box."""
    turn = ((Fraction(3, 5), Fraction(-4, 5)), (Fraction(4, 5), Fraction(3, 5)))
    back = tuple(zip(*turn))

    def times(m, v):
        return tuple(sum(a * b for a, b in zip(row, v)) for row in m)

    bone, tool, centre = (5, 10), (5, 10), (-6, 2)
    points = []
    for signs in itertools.product((-1, 1), repeat=2):
        corner = tuple(c + s * e for c, s, e in zip(centre, signs, tool))
        points.append(times(turn, tuple(max(-e, min(e, x)) for x, e in zip(times(back, corner), bone))))
    low, high = [[end(p[a] for p in points) for a in (0, 1)] for end in (min, max)]
    assert (low[0], high[0]) == (Fraction(-31, 5), Fraction(1, 5))
    corner = times(turn, (-5, 10))
    assert corner == (-11, 2) and all(abs(p - c) <= e for p, c, e in zip(corner, centre, tool))
    assert corner[0] < low[0]


def tables():
    # Table 3.5: 18 chunks at 0.0545 ms take 0.982 ms, so the table's two rows of times are exchanged.
    for total, chunk in ((982, 545), (975, 542), (967, 538)):
        assert abs(Fraction(total, 1000) - 18 * Fraction(chunk, 10000)) < Fraction(2, 1000)
    # The sizes in MB of 202, 199 and 99 chunks of 32^3 int16, and the scapula's numbers of chunks: 448
    # before its grid is made cubic, and 896 after.
    assert [round(n * 65536 / 1e6, 2) for n in (202, 199, 99)] == [13.24, 13.04, 6.49]
    assert 8 * 8 * 7 == 448 and 256 * 256 * 224 == 448 * 32**3 and 8 * 8 * 14 == 896
    # Bytes of text per voxel (Table 3.1), and megabytes of text per second of loading (Table 2.2).
    models = {"foam": (314 * 320 * 604, 764.1, 6930), "trabecular 2": (314 * 316 * 360, 1400, 13379),
              "trabecular 1": (156 * 156 * 313, 101.4, 936), "scapula": (256 * 234 * 201, 34.3, 295), "glenoid": (49 * 81 * 41, 3.7, 31)}
    per_voxel = {name: round(size * 1e6 / voxels, 1) for name, (voxels, size, _) in models.items()}
    assert per_voxel == {"foam": 12.6, "trabecular 2": 39.2, "trabecular 1": 13.3, "scapula": 2.8, "glenoid": 22.7}
    assert all(104 < size / ms * 1000 < 120 for _, size, ms in models.values())
    assert len("0 0 0 0\n") == 8 and len("10.016000 10.080000 11.488000 1234\n") == 35


def pose_centre():
    """Checks that by Alg. 2.1 the centre of the reamer's box moves with the voxel size."""
    centres = []
    for voxel in (MM, MM // 2):
        ends = []
        for low, high in ((-18 * MM, 17400000000), (-18 * MM, 18 * MM), (0, 20300000000)):
            ends.append((rhe(Fraction(2 * low - voxel, 2 * voxel)) * voxel - voxel, rhe(Fraction(2 * high + voxel, 2 * voxel)) * voxel + voxel))
        centres.append(tuple(Fraction(a + b, 2 * MM) for a, b in ends))
    assert centres == [(0, 0, Fraction(21, 2)), (Fraction(-1, 4), 0, Fraction(41, 4))]


if __name__ == "__main__":
    for check in (lost_layers, choice_without_effect, intersection_box, tables, pose_centre):
        check()
        print(f"ok {check.__name__}")
