#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes every case of dump_events again in Python's integers and fractions; the results must
be bit-identical.

The library uses a matrix of integer products, one common divisor and 128 bits; this program
uses quaternions that rotate vectors (q' v q / N) and fractions of any length. The two have
only the rules of docs/spec/arithmetic.md in common:

    AR-SWEEP   the number of poses of an event, and the poses
    AR-MAP     steps, bases and far blocks; in addition, the coordinates that are used
               must be within 23 / 2^20 of a tool voxel of the exact coordinates
    AR-REM     the voxels that a complete event removes and touches, and their sums

Covers: AR-INT-3, AR-POSE-4, AR-SWEEP-1, AR-SWEEP-2, AR-SWEEP-3, AR-SWEEP-4, AR-MAP-1, AR-MAP-3, AR-MAP-4, AR-MAP-5, AR-MAP-6,
AR-MAP-7, AR-REM-1, AR-REM-2, AR-REM-6, AR-CLS-1

Usage: check_events.py [DUMPER] [COUNT]    (default: tests/oracle/dump_events, 2000)
OST_TEST_SEED=N replays a run. OST_TEST_BACKENDS="ref cpu:isa=avx2" selects the backends (tests/backends.h); the dumps
of all backends must be the same text. The exit status is 77 if the dumper is missing.
"""

import math
import os
import subprocess
import sys
import time
from fractions import Fraction

SKIP = 77
UNIT = 1 << 20
SWEEP_MAX = 4096


def rhe(value):
    """Returns the nearest integer, ties to even, as Python's own round does for fractions."""
    return round(Fraction(value))


# -------------------------------------------------------------- quaternions


def times(a, b):
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def turn(q, v):
    """Computes R(q) v exactly, as q v q' / N."""
    conjugate = (q[0], -q[1], -q[2], -q[3])
    n = dot(q, q)
    return tuple(Fraction(c, n) for c in times(times(q, (0, *v)), conjugate)[1:])


def turn_back(q, v):
    return turn((q[0], -q[1], -q[2], -q[3]), v)


# -------------------------------------------------------------------- rules


class Tool:
    def __init__(self, text):
        n = [int(word) for word in text.split(",")]
        self.dims, self.voxel, self.corner = tuple(n[0:3]), n[3], tuple(n[4:7])

    def corners(self):
        lo, far = self.corner, [c + d * self.voxel for c, d in zip(self.corner, self.dims)]
        return [(x, y, z) for x in (lo[0], far[0]) for y in (lo[1], far[1]) for z in (lo[2], far[2])]


class Pose:
    def __init__(self, numbers):
        self.t, self.q = tuple(numbers[0:3]), tuple(numbers[3:7])

    @staticmethod
    def read(text):
        return Pose([int(word) for word in text.split(",")])

    def numbers(self):
        return [*self.t, *self.q]

    def image(self, corner):
        return [rhe(c) + t for c, t in zip(turn(self.q, corner), self.t)]

    def coordinate(self, tool, point):
        """Returns a point of the bone's frame in the tool's grid, times 2^20, as fractions."""
        inside = turn_back(self.q, [p - t for p, t in zip(point, self.t)])
        return [UNIT * (c - corner) / tool.voxel for c, corner in zip(inside, tool.corner)]


def least_root(ratio):
    """Returns the smallest n >= 1 with n^2 >= ratio."""
    n = max(1, math.isqrt(ratio.numerator // ratio.denominator))
    while n * n < ratio:
        n += 1
    return n


def sweep_count(a, b, tool, s):
    """Returns the number of poses according to AR-SWEEP-1 to AR-SWEEP-3, or 0 if the sweep is refused."""
    if 2 * dot(a.q, b.q) ** 2 < dot(a.q, a.q) * dot(b.q, b.q):
        return 0
    far = 0
    for corner in tool.corners():
        d = [p - q for p, q in zip(b.image(corner), a.image(corner))]
        far = max(far, dot(d, d))
    n = least_root(Fraction(4 * far, s * s))
    return n if n <= SWEEP_MAX else 0


def sweep_pose(a, b, k, n):
    sign = -1 if dot(a.q, b.q) < 0 else 1
    ends = [*b.t, *(sign * c for c in b.q)]
    return Pose([rhe(Fraction((n - k) * x + k * y, n)) for x, y in zip(a.numbers(), ends)])


class Map:
    """The map of one pose as defined by AR-MAP; bases are cached per block."""

    def __init__(self, pose, s, o, tool):
        self.pose, self.s, self.o, self.tool = pose, s, o, tool
        self.step = []
        for axis in range(3):
            along = [s if a == axis else 0 for a in range(3)]
            self.step.append([rhe(UNIT * c / tool.voxel) for c in turn_back(pose.q, along)])
        self.bases = {}

    def exact(self, voxel):
        return self.pose.coordinate(self.tool, [o + i * self.s for o, i in zip(self.o, voxel)])

    def base(self, block):
        if block not in self.bases:
            self.bases[block] = [rhe(c) for c in self.exact([16 * b for b in block])]
        return self.bases[block]

    def used(self, voxel):
        x, y, z = voxel
        base = self.base((x // 16, y // 16, z // 16))
        along_x, along_y, along_z = self.step
        x, y, z = x % 16, y % 16, z % 16
        return [base[a] + x * along_x[a] + y * along_y[a] + z * along_z[a] for a in range(3)]


def is_near(base):
    return all(-(2**29) <= c < 3 * 2**29 for c in base)


# -------------------------------------------------------------------- cases


def mix(z):
    mask = 2**64 - 1
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & mask
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB & mask
    return z ^ (z >> 31)


def density_at(seed, v):
    h = mix(seed + v)
    return 0 if h % 8 == 0 else 120 + h // 8 % 1000


def class_at(seed, v):
    h = mix(seed + 2**40 + v) % 8
    return 1 if h < 6 else 2 if h == 6 else 0


def integers(text):
    return [int(word) for word in text.split(",")] if text else []


class Checker:
    def __init__(self):
        self.worst = Fraction(0)
        self.counts = {"sweep": 0, "refused": 0, "map": 0, "far": 0, "near at the limits": 0, "exact border": 0, "event": 0, "hit": 0, "touched": 0}

    def sweep(self, words, poses):
        a, b, tool, s = Pose.read(words["a"]), Pose.read(words["b"]), Tool(words["tool"]), int(words["s"])
        n = sweep_count(a, b, tool, s)
        self.expect("n", int(words["n"]), n)
        self.counts["sweep"] += 1
        self.counts["refused"] += n == 0
        for k, text in poses:
            self.expect(f"pose {k}", integers(text), sweep_pose(a, b, k, n).numbers())

    def map(self, words, blocks):
        o, dims, tool = integers(words["o"]), integers(words["dims"]), Tool(words["tool"])
        m = Map(Pose.read(words["pose"]), int(words["s"]), o, tool)
        self.expect("step", integers(words["step"]), [c for row in m.step for c in row])
        self.counts["map"] += 1
        for text in blocks:
            n = integers(text)
            block, near, base = tuple(n[0:3]), n[3], n[4:7]
            self.expect(f"near {block}", near, int(is_near(m.base(block))))
            self.counts["far"] += not near
            self.counts["near at the limits"] += near and words["extreme"] == "1"
            if near:
                self.expect(f"base {block}", base, m.base(block))
            self.deviation(m, block, dims)
            if not near:
                self.far_block_is_outside(m, block)

    def deviation(self, m, block, dims):
        """Checks AR-MAP-6 at two of the block's corners and at one voxel inside it."""
        for d in ((15, 15, 15), (15, 0, 15), (7, 11, 3)):
            voxel = [min(16 * b + i, n - 1) for b, i, n in zip(block, d, dims)]
            for used, exact in zip(m.used(voxel), m.exact(voxel)):
                off = abs(used - exact)
                self.worst = max(self.worst, off)
                self.counts["exact border"] += exact % UNIT == 0
                if off > 23:
                    raise AssertionError(f"voxel {voxel}: osteon uses {used}, the exact value is {exact}")

    def far_block_is_outside(self, m, block):
        for d in ((0, 0, 0), (15, 15, 15), (15, 0, 0), (0, 15, 15)):
            used = m.used([16 * b + i for b, i in zip(block, d)])
            if all(0 <= u // UNIT < n for u, n in zip(used, m.tool.dims)):
                raise AssertionError(f"far block {block} reaches the tool")

    def event(self, words):
        o, dims, tool, s = integers(words["o"]), integers(words["dims"]), Tool(words["tool"]), int(words["s"])
        a, b, seed = Pose.read(words["a"]), Pose.read(words["b"]), int(words["seed"])
        n = sweep_count(a, b, tool, s)
        self.expect("n", int(words["n"]), n)
        maps = [Map(sweep_pose(a, b, k, n), s, o, tool) for k in range(1, n + 1)]
        hits, touched, density = [], 0, [0, 0, 0]
        tx, ty, tz = tool.dims
        for z in range(dims[2]):
            for y in range(dims[1]):
                for x in range(dims[0]):
                    v = x + dims[0] * (y + dims[1] * z)
                    value = density_at(seed, v)
                    if value < 120:
                        continue
                    met = set()
                    for m in maps:
                        i, j, k = (u // UNIT for u in m.used((x, y, z)))
                        if 0 <= i < tx and 0 <= j < ty and 0 <= k < tz:
                            met.add(class_at(seed, i + tx * (j + ty * k)))
                    if 1 in met:
                        hits.append(v)
                        density[0 if value < 150 else 1 if value < 650 else 2] += value
                    elif 2 in met:
                        touched += 1
        self.expect("hits", integers(words["hits"]), hits)
        self.expect("touched", int(words["touched"]), touched)
        self.expect("density", integers(words["density"]), density)
        self.counts["event"] += 1
        self.counts["hit"] += len(hits)
        self.counts["touched"] += touched

    @staticmethod
    def expect(what, found, expected):
        if found != expected:
            raise AssertionError(f"{what}: osteon has {found}, the exact fractions give {expected}")

    def line(self, text):
        kind, *pairs = text.split()
        words, poses, blocks = {}, [], []
        for pair in pairs:
            key, value = pair.split("=", 1)
            if key == "block":
                blocks.append(value)
            elif key.startswith("pose") and key != "pose":
                poses.append((int(key[4:]), value))
            else:
                words[key] = value
        if kind == "sweep":
            self.sweep(words, poses)
        elif kind == "map":
            self.map(words, blocks)
        else:
            self.event(words)


def main(arguments):
    dumper = arguments[0] if arguments else os.path.join("tests", "oracle", "dump_events")
    count = arguments[1] if len(arguments) > 1 else "2000"
    if not os.access(dumper, os.X_OK):
        print(f"{dumper} is not built")
        return SKIP
    seed = os.environ.get("OST_TEST_SEED") or str(time.time_ns() % 10**12)
    print(f"# check_events: OST_TEST_SEED={seed}")
    backends = (os.environ.get("OST_TEST_BACKENDS") or "ref cpu:threads=2 cpu:isa=scalar,threads=3").split()
    dumps = [subprocess.run([dumper, seed, count, backend], stdout=subprocess.PIPE, text=True, check=True).stdout
             for backend in backends]
    dump = dumps[0]
    for backend, other in zip(backends[1:], dumps[1:]):
        if other != dump:
            pairs = enumerate(zip(dump.splitlines(), other.splitlines()), 1)
            number, pair = next(((n, p) for n, p in pairs if p[0] != p[1]), (0, ("one has", "fewer lines")))
            print(f"case {number}: the result of {backend} differs from that of {backends[0]}\n{pair[1][:1000]}\n{pair[0][:1000]}")
            return 1
    checker = Checker()
    for number, text in enumerate(dump.splitlines(), 1):
        try:
            checker.line(text)
        except AssertionError as wrong:
            print(f"case {number}: {wrong}\n{text[:2000]}")
            return 1
    for name, value in checker.counts.items():
        print(f"{name}: {value}")
        if value == 0:
            print(f"no case tested '{name}'")
            return 1
    print(f"worst deviation of a coordinate: {float(checker.worst):.4f} of at most 23 units of 2^-20 tool voxels")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
