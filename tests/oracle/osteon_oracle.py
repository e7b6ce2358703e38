# SPDX-License-Identifier: Apache-2.0
"""A second implementation of the arithmetic of osteon: numbers, texts, grids, chunks, digests.

It was written only from the text of docs/spec/arithmetic.md, with Python's integers and fractions, without
regard to speed. Every rule is implemented as the document states it, next to its identifier.
This implementation and the C library have only the document in common. If they differ, one of
the two (or the document) is wrong.

    osteon_oracle         numbers, text -> rect -> cubic -> bone, digests
    osteon_oracle_tool    mesh -> snapped mesh -> tool grid
    osteon_oracle_events  poses -> sweep -> map -> removal
    osteon_oracle_files   NRRD files

The file has more than 500 lines, because each of its rules uses rules that are defined before it, from numbers to
bones and their digests.

If this file is run as a program, it checks itself against the examples of the document.
"""

import collections
import functools
import hashlib
import re
import struct
from fractions import Fraction

ARITHMETIC_VERSION = 2
PM_PER_MM = 10**9
LENGTH_MAX = 8 * 10**12


class Refused(Exception):
    """Raised for an input that is an error according to the document."""


# ------------------------------------------------------------------ numbers


def floor(r):
    """Returns the greatest integer that is at most r (AR-INT-1)."""
    return r.numerator // r.denominator


def ceil(r):
    """Returns the least integer that is at least r (AR-INT-1)."""
    return -floor(-r)


def rhe(r):
    """Returns the nearest integer, or the even one of two equally near integers (AR-INT-2)."""
    n, d = (r, 1) if isinstance(r, int) else (r.numerator, r.denominator)
    low = n // d
    below, above = n - low * d, (low + 1) * d - n
    if below != above:
        return low if below < above else low + 1
    return low if low % 2 == 0 else low + 1


DECIMAL = re.compile(r"[+-]?(?:\d+(?:\.(\d*))?|\.(\d+))(?:[eE]([+-]?\d+))?", re.ASCII)


@functools.lru_cache(maxsize=None)
def decimal(text):
    """Returns (exact value, decimal places) according to AR-LEN-2 if the complete text is a number, otherwise None."""
    match = DECIMAL.fullmatch(text)
    if not match:
        return None
    exponent = int(match.group(3) or 0)
    if abs(exponent) > 9999:
        raise Refused(f"exponent of '{text}'")
    places = len(match.group(1) or match.group(2) or "") - exponent
    return Fraction(text), places


@functools.lru_cache(maxsize=None)
def length(value_mm):
    """Converts millimetres to picometres (AR-LEN-3, AR-LEN-1)."""
    pm = rhe(value_mm * PM_PER_MM)
    if abs(pm) > LENGTH_MAX:
        raise Refused(f"{float(value_mm)} mm is beyond 8 m")
    return pm


def shortest_decimal(value, bits):
    """Returns the decimal that a finite float32 or float64 represents according to AR-LEN-4."""
    exact = Fraction(value)
    if exact == 0:
        return exact

    def reads_back(candidate):
        return nearest_float(candidate, bits) == exact

    magnitude = abs(exact)
    exponent = 0
    while Fraction(10) ** exponent > magnitude:
        exponent -= 1
    while Fraction(10) ** (exponent + 1) <= magnitude:
        exponent += 1
    for digits in range(1, 19):
        unit = Fraction(10) ** (exponent - digits + 1)
        low = floor(exact / unit)
        found = [m for m in (low, low + 1) if reads_back(m * unit)]
        if found and digits >= 7 and bits == 32 and magnitude < 2**24 and (512 * exact).denominator == 1:
            return exact
        if found:
            return min(found, key=lambda m: (abs(m * unit - exact), m % 2)) * unit
    raise AssertionError("every float64 has a decimal of 17 digits")


def nearest_float(value, bits):
    """Returns the float32 or float64 nearest to a rational as a Fraction, ties to even (overflow is not handled)."""
    if value == 0:
        return Fraction(0)
    mantissa, least = (24, -149) if bits == 32 else (53, -1074)
    magnitude = abs(value)
    exponent = 0
    while Fraction(2) ** exponent > magnitude:
        exponent -= 1
    while Fraction(2) ** (exponent + 1) <= magnitude:
        exponent += 1
    unit = Fraction(2) ** max(exponent - mantissa + 1, least)
    return rhe(value / unit) * unit


# -------------------------------------------------------------------- grids


Geometry = collections.namedtuple("Geometry", "dims spacing origin")


def check_limits(dims, spacing, origin):
    """Refuses a grid beyond the limits of AR-GRID-3."""
    nx, ny, nz = dims
    if not all(1 <= n <= 16384 for n in dims) or nx * ny * nz > 2**36:
        raise Refused(f"dims {dims}")
    if not all(10**6 <= s <= 10**11 for s in spacing):
        raise Refused(f"spacing {spacing}")
    for n, s, o in zip(dims, spacing, origin):
        if max(abs(o), abs(o + (n - 1) * s)) > LENGTH_MAX:
            raise Refused("a voxel beyond 8 m")
    return Geometry(tuple(dims), tuple(spacing), tuple(origin))


class Grid:
    """A grid as defined by AR-GRID-1 and AR-GRID-2: dims, spacing, origin and a list of values, x fastest."""

    def __init__(self, dims, spacing, origin, voxels=None):
        self.dims, self.spacing, self.origin = tuple(dims), tuple(spacing), tuple(origin)
        nx, ny, nz = self.dims
        self.voxels = [0] * (nx * ny * nz) if voxels is None else voxels
        assert len(self.voxels) == nx * ny * nz

    def index(self, i, j, k):
        return i + self.dims[0] * (j + self.dims[1] * k)

    def check(self):
        """Refuses a grid beyond the limits of AR-GRID-3."""
        check_limits(self.dims, self.spacing, self.origin)
        return self


# ------------------------------------------------------------- text to rect


class Text:
    """The samples of a CT text, the coordinates of each axis as AR-CT-3 needs them, and the facts in the
    text's comments."""

    def __init__(self, content):
        self.samples, self.meta, self.own = [], {}, {}
        self.terminated = content.endswith("\n")
        self.units, self.rounded = [set(), set(), set()], [0, 0, 0]
        may_be_header = True
        lines = content.split("\n")
        for number, line in enumerate(lines, 1):
            line = line[:-1] if line.endswith("\r") else line
            line, hash_sign, comment = line.partition("#")
            if hash_sign and not line.strip(" \t"):
                self._fact(comment, number)
            fields = self._fields(line)
            if not fields:
                continue
            if may_be_header and not any(DECIMAL.match(f) or re.match("[+-]?(nan|inf)", f, re.I) for f in fields):
                may_be_header = False
                continue
            may_be_header = False
            self._sample(fields, number)

    @staticmethod
    def _fields(line):
        """Splits a line into fields (AR-CT-1). A separator consists of blanks and at most one comma or semicolon."""
        line = line.strip(" \t")
        return re.split(r"[ \t]*[,;][ \t]*|[ \t]+", line) if line else []

    def _fact(self, comment, number):
        """Reads a fact from a comment (AR-CT-8)."""
        match = re.fullmatch(r"[ \t]*osteon[ \t]+([^ \t:]+):(.*)", comment, re.S)
        if not match:
            return
        key, value = match.group(1), match.group(2).strip(" \t")
        if len(value.encode()) > 200:
            raise Refused(f"line {number}: a value of more than 200 bytes")
        if key in ("spacing_mm", "origin_mm", "dims"):
            numbers = [decimal(field) for field in self._fields(value)]
            if len(numbers) != 3 or None in numbers:
                raise Refused(f"line {number}: {key} '{value}'")
            three = tuple(n[0] if key == "dims" else length(n[0]) for n in numbers)
            if key == "dims" and not all(n.denominator == 1 and 1 <= n <= 16384 for n in three):
                raise Refused(f"line {number}: dims '{value}'")
            if key == "spacing_mm" and not all(s > 0 for s in three):
                raise Refused(f"line {number}: spacing_mm '{value}'")
            if self.own.setdefault(key, three) != three:
                raise Refused(f"line {number}: another {key}")
            return
        if not re.fullmatch("[a-z0-9_]{1,40}", key) or re.search("[\x00-\x1f\x7f]", value):
            raise Refused(f"line {number}: '{key}' or its value is no fact")
        self.meta[key] = value
        if len(self.meta) > 32:
            raise Refused("more than 32 facts")

    def _sample(self, fields, number):
        """Reads the four fields of a sample (AR-CT-2)."""
        if len(fields) != 4:
            raise Refused(f"line {number}: {len(fields)} fields")
        numbers = [decimal(field) for field in fields]
        if None in numbers:
            raise Refused(f"line {number}: not a decimal")
        density = numbers[3][0]
        if density.denominator != 1 or not -32768 <= density <= 32767:
            raise Refused(f"line {number}: density {fields[3]}")
        self.samples.append(tuple(length(value) for value, _ in numbers[:3]) + (int(density),))
        for axis, (value, places) in enumerate(numbers[:3]):
            self.units[axis].add(10 ** (9 - min(max(places, -3), 9)))
            if (value * PM_PER_MM).denominator != 1:
                self.rounded[axis] = 1


class Axis:
    """An axis as defined by AR-CT-3: its coordinates, their steps, the unit for which the steps are valid, and the spacing."""

    def __init__(self, coordinates, units, rounded=0):
        self.c = sorted(set(coordinates))
        if len(self.c) == 1:
            raise Refused("a single layer needs a given spacing")
        gaps = [b - a for a, b in zip(self.c, self.c[1:])]
        spans = [c - self.c[0] for c in self.c]
        gap = min(gaps)
        if all(span % gap == 0 for span in spans) and (gap == max(gaps) or gap > max(units)):  # step 2
            self.steps, self.unit = [span // gap for span in spans], min(units) + rounded
            self.spacing = spacing_from_steps([self], True) if self.steps[-1] <= 16383 else None
            if self.spacing is not None:
                return
        for unit in sorted(units):  # step 3
            self.unit = unit + rounded
            self.steps = self._rounded_steps(gaps, spans)
            self.spacing = self.steps and spacing_from_steps([self], True)
            if self.spacing:
                return
        raise Refused("no spacing fits: give one")

    def _rounded_steps(self, gaps, spans):
        """Performs step 3 with one unit. Returns the steps, or None."""
        u, steps = self.unit, [0]
        gap = min((g for g in gaps if g > u), default=None)
        if gap is None:
            return None
        low, high = Fraction(gap - u), Fraction(gap + u)
        for span in spans[1:]:
            fits = range(max(0, ceil((span - u) / high)), floor((span + u) / low) + 1)
            if len(fits) != 1 or fits[0] > 16383:
                return None
            k = fits[0]
            if k:
                low, high = max(low, Fraction(span - u, k)), min(high, Fraction(span + u, k))
            steps.append(k)
        return steps

    @property
    def ratio(self):
        return Fraction(self.c[-1] - self.c[0], self.steps[-1])

    def spread(self, spacing):
        off = [c - k * spacing for c, k in zip(self.c, self.steps)]
        return max(off) - min(off)

    def feasible(self):
        """Performs step 4. Returns the least and the greatest feasible spacing, computed from all pairs of
        coordinates."""
        low, high = Fraction(1), Fraction(self.c[-1] - self.c[0] + self.unit)
        for i, (c, k) in enumerate(zip(self.c, self.steps)):
            for c2, k2 in zip(self.c[i + 1:], self.steps[i + 1:]):
                if k2 > k:
                    low = max(low, Fraction(c2 - c - self.unit, k2 - k))
                    high = min(high, Fraction(c2 - c + self.unit, k2 - k))
                elif c2 - c > self.unit:
                    return 1, 0
        return ceil(low), floor(high)


def spacing_from_steps(axes, thirds=False):
    """Performs AR-CT-3 steps 4 and 5 for one axis, and AR-CT-7 for several axes. Returns a spacing or None."""
    leading = max(axes, key=lambda axis: axis.steps[-1])  # the first of equal axes
    ratio = leading.ratio
    ends = [axis.feasible() for axis in axes]
    low, high = max(a for a, _ in ends), min(b for _, b in ends)
    for digits in range(10):
        unit = 10 ** (9 - digits)
        least, greatest = ceil(Fraction(low, unit)), floor(Fraction(high, unit))
        if least <= greatest:  # the feasible multiple nearest to the ratio is one of its neighbours or an end
            near = {min(max(m, least), greatest) for m in (floor(ratio / unit), ceil(ratio / unit))}
            return min((m * unit for m in near), key=lambda s: (abs(s - ratio), s))
    if thirds and leading.spread(rhe(ratio)) <= leading.unit + leading.steps[-1]:
        return rhe(ratio)
    return None


def infer_spacing(text):
    """Returns the spacing of all three axes (AR-CT-3, AR-CT-7)."""
    axes = [Axis([s[a] for s in text.samples], text.units[a], text.rounded[a]) for a in range(3)]
    spacing = [axis.spacing for axis in axes]

    def nearly_equal(a, b):
        return 100 * abs(spacing[a] - spacing[b]) <= min(spacing[a], spacing[b])

    for group in ((0, 1, 2), (0, 1), (0, 2), (1, 2)):
        common = spacing_from_steps([axes[a] for a in group]) if all(nearly_equal(group[0], a) for a in group) else None
        if common is not None:
            for a in group:
                spacing[a] = common
            break
    return tuple(spacing)


def given_spacing(text):
    """Returns the spacing that the text states as a fact, or None (AR-CT-8)."""
    return text.own.get("spacing_mm")


def rect_geometry(text, spacing):
    """Returns the rect grid without voxels (AR-CT-4, AR-CT-8)."""
    if not text.samples:
        raise Refused("no sample")
    low = [min(s[a] for s in text.samples) for a in range(3)]
    high = [max(s[a] for s in text.samples) for a in range(3)]
    if "origin_mm" in text.own:
        origin = text.own["origin_mm"]
        if any(8 * abs(l - o) > s for l, o, s in zip(low, origin, spacing)):
            raise Refused("the text's own origin is not where its samples start")
        low = origin
    dims = tuple(rhe(Fraction(h - l, s)) + 1 for l, h, s in zip(low, high, spacing))
    if "dims" in text.own:
        if text.own["dims"] != dims:
            raise Refused("the declared dims are others")
        if len(text.samples) != dims[0] * dims[1] * dims[2] or not text.terminated:
            raise Refused("the text's own dims say that it has another end")
    return check_limits(dims, spacing, low)


def text_to_rect(text, spacing=None, duplicates="error", crop=None):
    """Applies AR-CT-4..6, and AR-GRID-5 with the crop lo and hi. Returns the rect grid and a report."""
    if not text.samples:
        raise Refused("no sample")
    spacing = spacing or given_spacing(text) or infer_spacing(text)
    geometry = rect_geometry(text, spacing)
    low = geometry.origin
    from_, to = crop or ((0, 0, 0), geometry.dims)
    if not all(0 <= a < b <= n for a, b, n in zip(from_, to, geometry.dims)):
        raise Refused(f"a crop {crop} of {geometry.dims} voxels")
    dims = tuple(b - a for a, b in zip(from_, to))
    if dims[0] * dims[1] * dims[2] > max(2**24, 256 * len(text.samples)):
        raise Refused("the samples are too sparse")
    rect = Grid(dims, spacing, [o + a * s for o, a, s in zip(low, from_, spacing)])
    seen, report = set(), {"samples": 0, "duplicates": 0, "off_lattice": 0, "worst_offset_ppm": 0}
    for *position, density in text.samples:
        places = [rhe(Fraction(p - l, s)) for p, l, s in zip(position, low, spacing)]
        if crop and not all(a <= i < b for a, i, b in zip(from_, places, to)):
            continue
        report["samples"] += 1
        index, off = [], False
        for p, l, s, n, a, i in zip(position, low, spacing, dims, from_, places):
            offset = abs(p - l - i * s)
            report["worst_offset_ppm"] = max(report["worst_offset_ppm"], floor(Fraction(10**6 * offset, s)))
            off = off or 8 * offset > s
            if 8 * offset > 3 * s or not 0 <= i - a < n:
                raise Refused(f"{p} pm is {offset} pm off the lattice")
            index.append(i - a)
        report["off_lattice"] += off
        at = rect.index(*index)
        if at in seen:
            report["duplicates"] += 1
            had = rect.voxels[at]
            if duplicates == "error" and had != density:
                raise Refused(f"voxel {index} has {had} and {density}")
            density = {"error": had, "first": had, "last": density, "max": max(had, density)}[duplicates]
        seen.add(at)
        rect.voxels[at] = density
    if "dims" in text.own and report["duplicates"]:
        raise Refused("a text with dims gives a voxel twice")
    return rect, report


def samples_digest(text):
    """Computes the digest of a text's samples (AR-DIG-6)."""
    records = b"".join(struct.pack("<3qiI", *sample, 0) for sample in text.samples)
    return hashlib.sha256(records).hexdigest()


# ------------------------------------------------- rect to cubic, and a bone


def axis_taps(n, s, c, rule):
    """Applies AR-CUB-2 to AR-CUB-4 along one axis. Returns for each cubic voxel the rect voxels that it is computed from,
    each with its weight (a Fraction)."""
    taps = []
    for i in range(ceil(Fraction(n * s, c))):
        if rule == "thesis":
            taps.append([(floor(Fraction(i * c, s)), Fraction(1))])
        elif rule == "nearest":
            taps.append([(min(n - 1, floor(Fraction((2 * i + 1) * c, 2 * s))), Fraction(1))])
        else:
            t = min(max(Fraction((2 * i + 1) * c - s, 2 * s), Fraction(0)), Fraction(n - 1))
            k = floor(t)
            w = Fraction(rhe(2**15 * (t - k)), 2**15)
            taps.append([(k, 1 - w)] + ([(k + 1, w)] if w else []))
    return taps


def rect_to_cubic(rect, cubic=None, rule="linear"):
    """Resamples a rect grid to a cubic one (AR-CUB)."""
    c = rect.spacing[0] if cubic is None else cubic
    xs, ys, zs = (axis_taps(n, s, c, rule) for n, s in zip(rect.dims, rect.spacing))
    origin = tuple(o + rhe(Fraction(c - s, 2)) for o, s in zip(rect.origin, rect.spacing))
    out = Grid((len(xs), len(ys), len(zs)), (c, c, c), origin).check()
    out.voxels = []
    for z in zs:
        for y in ys:
            for x in xs:
                if len(x) == len(y) == len(z) == 1:
                    out.voxels.append(rect.voxels[rect.index(x[0][0], y[0][0], z[0][0])])
                    continue
                out.voxels.append(rhe(sum(rect.voxels[rect.index(i, j, k)] * u * v * w for i, u in x for j, v in y for k, w in z)))
    return out


class Bone(Grid):
    """A bone as defined by AR-CHK-1: the active densities, and 0 elsewhere."""

    def __init__(self, cubic, threshold=120):
        kept = [v if v >= threshold else 0 for v in cubic.voxels]
        super().__init__(cubic.dims, cubic.spacing, cubic.origin, kept)
        self.threshold = threshold

    def chunk_dims(self, n):
        """Returns the number of chunks along each axis (AR-CHK-2)."""
        return tuple(ceil(Fraction(d, n)) for d in self.dims)

    def active(self):
        """Yields (i, j, k) of every active voxel, x fastest."""
        nx, ny, nz = self.dims
        at = 0
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    if self.voxels[at]:
                        yield i, j, k
                    at += 1

    def chunk_number(self, i, j, k, n):
        cx, cy, _ = self.chunk_dims(n)
        return i // n + cx * (j // n + cy * (k // n))

    def info(self, n):
        """Returns the bone's counts of chunks and voxels, and the size of its chunks in bytes (AR-CHK-2, AR-CHK-4)."""
        voxels = 0
        active = set()
        for at in self.active():
            voxels += 1
            active.add(self.chunk_number(*at, n))
        a, b, c = self.chunk_dims(n)
        return {"chunk_dims": [a, b, c], "chunks": a * b * c, "active_chunks": len(active), "active_voxels": voxels,
                "chunk_bytes": len(active) * (2 * n**3 + n**3 // 8)}


# ------------------------------------------------------------------ digests

KIND_RECT, KIND_CUBIC, KIND_BONE, KIND_TOOL = 1, 2, 3, 4


def sha256(data):
    return hashlib.sha256(data).digest()


def leaves(grid, kind):
    """Returns the digests of a grid's leaves (AR-DIG-2)."""
    pack = struct.Struct("<32B" if kind == KIND_TOOL else "<32h").pack
    nx, ny, nz = grid.dims
    out = []
    for c in range(0, nz, 32):
        for b in range(0, ny, 32):
            for a in range(0, nx, 32):
                rows = []
                for k in range(c, c + 32):
                    for j in range(b, b + 32):
                        row = [0] * 32
                        if j < ny and k < nz:
                            have = min(32, nx - a)
                            at = grid.index(a, j, k)
                            row[:have] = grid.voxels[at:at + have]
                        rows.append(pack(*row))
                out.append(sha256(b"\x00" + b"".join(rows)))
    return out


def tree(digests):
    """Returns the root of the hash tree over these digests (AR-DIG-3)."""
    if len(digests) == 1:
        return digests[0]
    k = 1
    while 2 * k < len(digests):
        k *= 2
    return sha256(b"\x01" + tree(digests[:k]) + tree(digests[k:]))


def grid_digest(grid, kind):
    """Returns the digest of a grid (AR-DIG-4)."""
    found = leaves(grid, kind)
    threshold = grid.threshold if kind == KIND_BONE else 0
    header = b"OSTEONG1" + struct.pack("<II", ARITHMETIC_VERSION, kind) + struct.pack("<3iI", *grid.dims, 0)
    header += struct.pack("<3q3q", *grid.spacing, *grid.origin) + struct.pack("<iIQ", threshold, 32, len(found)) + bytes(32)
    assert len(header) == 128
    return sha256(b"\x02" + header + tree(found)).hex()


# --------------------------------------------------------------- self-check


def self_check():
    """Checks the examples of docs/spec/arithmetic.md, sections 1 to 8 and 15."""
    assert [rhe(Fraction(n, 2)) for n in (5, 7, -5, -7)] == [2, 4, -2, -4]
    assert (floor(Fraction(-7, 2)), ceil(Fraction(-7, 2)), rhe(Fraction(-1, 3)), rhe(Fraction(-2, 3))) == (-4, -3, 0, -1)

    def mm(text):
        return length(decimal(text)[0])

    assert [mm(t) for t in ("0.48828125", "-57.34", "1.0000000005", "1.0000000015", "5.", ".5", "1.25e1")] == [
        488281250, -57340000000, 1000000000, 1000000002, 5000000000, 500000000, 12500000000]
    assert all(decimal(t) is None for t in ("", ".", "nan", "inf", "0x1", "1e", "- 1", "1_0"))
    assert decimal("1.250e1")[1] == 2 and decimal("12e3")[1] == -3
    binary = struct.unpack("<f", bytes.fromhex("d7a3f03e"))[0]
    assert Fraction(binary) == Fraction(15770583, 2**25)
    assert shortest_decimal(binary, 32) == Fraction(47, 100) and rhe(Fraction(binary) * PM_PER_MM) == 469999999
    assert shortest_decimal(0.841796875, 32) == Fraction(431, 512) and shortest_decimal(-198.912109375, 32) == Fraction(-101843, 512)
    for value in ("0.4882812", "0.488281", "-117.8", "0.4"):
        assert shortest_decimal(struct.unpack("<f", struct.pack("<f", float(value)))[0], 32) == Fraction(value)
    for value in (0.1, 1 / 3, 5e-324, 1.7976931348623157e308, 2.0**60, -57.34):  # repr gives the same decimal
        assert shortest_decimal(value, 64) == Fraction(repr(value))
    assert [floor(Fraction(i * 469999999, 10**9)) for i in (100, 200, 300, 400)] == [46, 93, 140, 187]

    # AR-CT-3: every difficult lattice must be restored completely at 4 and at 6 decimals.
    for spacing in ("0.3", "0.032", "0.488281", "0.47", "0.48828125"):
        for start in ("0", "-57.34", "12.3456"):
            for decimals in (4, 6):
                count = 60
                exact = [Fraction(start) + k * Fraction(spacing) for k in range(count)]
                written = [rhe(c * 10**decimals) * 10 ** (9 - decimals) for c in exact]
                axis = Axis(written, {10 ** (9 - decimals)})
                assert axis.steps == list(range(count)), (spacing, start, decimals)
                assert axis.spacing == rhe(Fraction(spacing) * PM_PER_MM)
                assert [rhe(Fraction(c - written[0], axis.spacing)) for c in written] == axis.steps
    axis = Axis([-57340000000 + 470000000 * k for k in range(256)], {10**7})
    assert axis.feasible() == (469960785, 470039215) and axis.spacing == 470000000
    axis = Axis([rhe(k * Fraction("0.48828125") * 10**4) * 10**5 for k in range(60)], {10**5})
    assert floor(axis.ratio) == 488281355 and axis.feasible() == (488281250, 488281250) and axis.spacing == 488281250
    axis = Axis([rhe(k * Fraction("0.488281") * 10**4) * 10**5 for k in range(60)], {10**5})
    assert axis.feasible() == (488280852, 488281081) and axis.spacing == 488281000
    axis = Axis([470000000 * k for k in (0, 1, 2, 5, 6, 100)], {10**9, 10**8, 10**7})  # 0 .47 .94 2.35 2.82 47
    assert axis.steps == [0, 1, 2, 5, 6, 100] and axis.spacing == 470000000
    axis = Axis([rhe(Fraction(k, 3) * 10**9) for k in range(50)], {1}, 1)  # thirds with nine decimal places
    assert axis.steps == list(range(50)) and axis.spacing == 333333333

    text = Text("x y z HU\n# osteon spacing_mm: 0.47 0.47 1\n-57.34 0 1 120.0\r\n-56.40,0;1 1.2e2 # two on\n")
    rect, report = text_to_rect(text)
    assert rect.dims == (3, 1, 1) and rect.voxels == [120, 0, 120] and report["samples"] == 2
    twice = "0 0 0 5\n0 0 0 5\n"  # AR-CT-8
    assert text_to_rect(Text(twice), (PM_PER_MM,) * 3)[1]["duplicates"] == 1
    try:
        text_to_rect(Text("# osteon dims: 1 1 1\n" + twice), (PM_PER_MM,) * 3)
        raise AssertionError("a text with dims and two samples for a voxel")
    except Refused:
        pass
    cropped, _ = text_to_rect(Text("".join(f"{x} 0 0 {x}\n" for x in range(9))), (PM_PER_MM,) * 3, crop=((4, 0, 0), (6, 1, 1)))  # AR-GRID-5
    assert cropped.dims == (2, 1, 1) and cropped.origin == (4 * PM_PER_MM, 0, 0) and cropped.voxels == [4, 5]
    for wrong in ("0 0 0", "0 0 0 1.5", "0 0 0 32768", "0 0 0 nan", "0 0 0 1 2", "0 0 1e10 1"):
        try:
            Text("0 0 0 1\n" + wrong)
        except Refused:
            continue
        raise AssertionError(wrong)

    for dims, spacing, cubic, chunks in (
            ((256, 234, 201), (470000000, 470000000, 10**9), (256, 234, 428), (8, 8, 14)),
            ((49, 81, 41), (470000000, 470000000, 10**9), (49, 81, 88), (2, 3, 3)),
            ((314, 320, 604), (32000000,) * 3, (314, 320, 604), (10, 10, 19)),
            ((314, 316, 360), (32000000,) * 3, (314, 316, 360), (10, 10, 12)),
            ((156, 156, 313), (32000000,) * 3, (156, 156, 313), (5, 5, 10))):
        got = tuple(ceil(Fraction(n * s, spacing[0])) for n, s in zip(dims, spacing))
        assert got == cubic and tuple(ceil(Fraction(n, 32)) for n in got) == chunks

    def layers(densities, rule):
        return rect_to_cubic(Grid((1, 1, 201), (470000000, 470000000, 10**9), (0, 0, 0), densities), rule=rule).voxels

    assert layers(list(range(201)), "nearest")[:6] == [0, 0, 1, 1, 2, 2]
    assert layers(list(range(201)), "thesis")[:6] == [0, 0, 0, 1, 1, 2]
    for rule in ("linear", "nearest", "thesis"):
        assert layers(list(range(201)), rule)[427] == 200 and len(layers(list(range(201)), rule)) == 428
    assert layers([100 * k for k in range(201)], "linear")[:6] == [0, 20, 67, 114, 161, 208]
    assert [[w * 2**15 for _, w in axis_taps(201, 10**9, 470000000, "linear")[i]][1] for i in (1, 5)] == [6717, 2785]
    moved = rect_to_cubic(Grid((1, 1, 201), (470000000, 470000000, 10**9), (7, 8, 9), [0] * 201))
    assert moved.origin == (7, 8, 9 - 265000000)
    pair = rect_to_cubic(Grid((2, 1, 1), (1500000000,) * 3, (0, 0, 0), [2, 3]), 10**9)
    assert pair.voxels[1] == 2 and pair.dims == (3, 2, 2)

    empty16 = sha256(b"\x00" + bytes(65536))
    assert empty16.hex() == "3266304f31be278d06c3bd3eb9aa3e00c59bedec0a890de466568b0b90b0e01f"
    assert tree([empty16] * 2).hex() == "1f3e47490a7d805550cb89ec2820578d5694205fa095cfc6a81150fb21926017"
    assert tree([empty16] * 3).hex() == "20071a418c7b12674fb1c63cb0b733852fed944660b72b3d739dc1f312b5e853"
    row = Grid((33, 1, 1), (470000000,) * 3, (-57340000000, 0, 0), [120] + [0] * 31 + [1000])
    assert grid_digest(Bone(row), KIND_BONE) == "08722c4b6c9d76cb5d1320756f78c1bafa96e2e0e8fd360569a8c8dc92935ed4"
    assert samples_digest(Text("-57.34 0 1 120")) == "b4b80266d2bbd065000989d6c08fe41144dbc08469191ee5be880275a23b2959"


if __name__ == "__main__":
    self_check()
    print("osteon_oracle: the worked numbers of docs/spec/arithmetic.md hold")
