# SPDX-License-Identifier: Apache-2.0
"""The differences between two grids, from the verdict down to single voxels, as `osteon diff` reports them.

    verdict    equal or not           kinds      removed, added, changed, below
    geometry   spacing, origin        class      the shape of all differences together (osteon/difference.h)
    chunks     where they are         first      the first voxels, with both values

Threads: the functions share no state.
"""
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib, text
from osteon.bone import Bone, volume_of
from osteon.errors import UsageError
from osteon.grid import Geometry, Volume
from osteon.mesh import ToolVolume
from osteon.tool import Tool
from osteon.units import Vector, mm_text, vector

__all__ = ["ChunkDifference", "Differences", "KINDS", "Pattern", "VoxelDifference", "classify", "diff"]

KINDS = ("removed", "added", "changed", "below")
"""Kinds of differing voxels: solid in A only, solid in B only, solid in both, solid in neither."""


class VoxelDifference(NamedTuple):
    """A voxel that differs: index x, y, z, and both values."""

    voxel: Vector
    a: int
    b: int


class ChunkDifference(NamedTuple):
    """A chunk that differs: index x, y, z, the number of differing voxels, and the number of each kind."""

    chunk: Vector
    different: int
    by_kind: Dict[str, int]


class Pattern(NamedTuple):
    """A pattern that holds for all voxels to which it applies: its name and the evidence."""

    name: str
    text: str


@dataclass
class Differences:
    """The result of osteon.diff. It is true if the grids are equal; str() is a report.

    Attributes
    ----------
    same_dims, same_spacing, same_origin : bool
        Lengths are equal if they differ by at most 2^-23, the precision of float32 in a NIfTI file.
    rounded_geometry : bool
        True if spacing or origin are equal only after this rounding.
    different : int
        Number of voxels that differ.
    by_kind : dict
        Number of these voxels of each of KINDS.
    box : (lo, hi) or None
        Half-open box of these voxels, x, y, z.
    chunks : list of ChunkDifference
        Chunks that differ, in the order of the grid.
    first : list of VoxelDifference
        The first voxels that differ, in the order of memory.
    pattern : str or None
        The class of the difference; None if there is nothing to classify.
    patterns : list of Pattern
        All patterns that hold.
    """

    same_dims: bool
    same_spacing: bool
    same_origin: bool
    rounded_geometry: bool
    different: int = 0
    by_kind: Dict[str, int] = field(default_factory=lambda: dict.fromkeys(KINDS, 0))
    box: Optional[Tuple[Vector, Vector]] = None
    chunks: List[ChunkDifference] = field(default_factory=list)
    first: List[VoxelDifference] = field(default_factory=list)
    pattern: Optional[str] = None
    patterns: List[Pattern] = field(default_factory=list)

    @property
    def equal(self) -> bool:
        """True if dims, spacing, origin and all voxels are equal."""
        return self.same_dims and self.same_spacing and self.same_origin and self.different == 0

    def __bool__(self) -> bool:
        return self.equal

    def __str__(self) -> str:
        if self.equal:
            return "equal"
        kinds = ", ".join(f"{n} {kind}" for kind, n in self.by_kind.items() if n)
        lines = [f"different: {self.different} voxels in {len(self.chunks)} chunks" + (f" ({kinds})" if kinds else "")]
        lines += [f"  {pattern.name}: {pattern.text}" for pattern in self.patterns]
        lines += [f"  voxel {v.voxel}: {v.a} in A, {v.b} in B" for v in self.first]
        return "\n".join(lines)


def _grid(data: Any) -> Tuple[Volume, int, Optional[ToolVolume]]:
    """Returns the voxels, the lowest value of a solid voxel, and the tool if the grid is one."""
    if isinstance(data, (str, bytes, os.PathLike)):
        facts = ffi.new("ost_meta *")
        call(lib.ost_volume_read_header, os.fsencode(data), ffi.NULL, facts, ffi.NULL)
        kind = text(lib.ost_meta_get(facts, lib.OST_META_KIND))
        data = ToolVolume.read(data) if kind == "tool" else Volume.read(data)
    if isinstance(data, Tool):
        data = data.download()
    if isinstance(data, ToolVolume):
        g = data.geometry
        geometry = Geometry(g.dims, (g.voxel_pm,) * 3, g.corner_pm)  # the corner of a tool is exact
        return Volume(data.voxels.astype(np.int16), geometry), 1, data
    threshold = data.threshold if isinstance(data, Bone) else None
    volume = volume_of(data)
    if threshold is None:
        stored = volume.meta.get("threshold", "") if volume.meta.get("kind") == "bone" else ""
        threshold = int(stored) if stored.isdigit() else 120
    return volume, threshold, None


def classify(a: Volume, b: Volume, *, threshold_a: int = 120, threshold_b: int = 120, tool: bool = False,
             chunk_size: int = 32, before: Optional[Volume] = None,
             report_differs: bool = False) -> Tuple[Optional[str], List[Pattern]]:
    """Classifies the difference between the voxels of a, which are correct, and those of b.

    Parameters
    ----------
    before : Volume, optional
        The bone before the event that made both grids.
    report_differs : bool
        True if the reports of the event differ too.

    Returns
    -------
    (str or None, list of Pattern)
        The class, and the patterns that hold.
    """
    c_before = before._c() if before is not None else ffi.NULL
    options = ffi.new("ost_difference_options *", {
        "threshold_a": threshold_a, "threshold_b": threshold_b, "tool": tool, "chunk_size": chunk_size,
        "before": c_before, "report_differs": report_differs})
    out = ffi.new("ost_difference *")
    call(lib.ost_difference_find, a._c(), b._c(), options, out)
    return text(out.class_name) or None, [Pattern(text(p.name), text(p.text))
                                          for p in out.patterns[0:out.pattern_count]]


def _within(a: Vector, b: Vector, bound: Vector) -> bool:
    return all(abs(p - q) <= limit >> 23 for p, q, limit in zip(a, b, bound))


def diff(a: Any, b: Any, *, chunk_size: int = 32, limit: int = 10) -> Differences:
    """Compares two grids.

    Parameters
    ----------
    a, b : Bone, Volume, Tool, ToolVolume, image of SimpleITK or nibabel, or path-like
        Two bones, two CTs or two tools.
    chunk_size : {16, 32, 64}
        Edge length of the chunks for the counts.
    limit : int
        Number of voxels in Differences.first.

    Returns
    -------
    Differences
        True if the grids are equal.
    """
    (va, ta, tool_a), (vb, tb, tool_b) = _grid(a), _grid(b)
    if (tool_a is None) != (tool_b is None):
        raise UsageError("a tool cannot be compared with a bone or a CT")
    ga, gb = va.geometry, vb.geometry
    exact = ga.spacing_pm == gb.spacing_pm, ga.origin_pm == gb.origin_pm
    same_spacing, same_origin = exact
    if tool_a is None:
        greater = vector(max(s) for s in zip(ga.spacing_pm, gb.spacing_pm))
        # the farthest voxel centre on each axis
        far = vector(max(abs(o), abs(o + s * (n - 1))) for o, s, n in zip(ga.origin_pm, greater, ga.dims))
        same_spacing = _within(ga.spacing_pm, gb.spacing_pm, greater)
        same_origin = _within(ga.origin_pm, gb.origin_pm, far)
    out = Differences(ga.dims == gb.dims, same_spacing, same_origin,
                      not all(exact) and same_spacing and same_origin)
    if not out.same_dims:
        out.patterns.append(Pattern("geometry", "dims {} x {} x {} against {} x {} x {}".format(*ga.dims, *gb.dims)))
    elif not (same_spacing and same_origin):
        what, pa, pb = (("origin", ga.origin_pm, gb.origin_pm) if same_spacing else
                        ("spacing", ga.spacing_pm, gb.spacing_pm))
        out.patterns.append(Pattern("geometry", f"{what} {_mm(pa)} against {_mm(pb)} mm"))
    if out.same_dims:
        _count(va.voxels, vb.voxels, ta, tb, chunk_size, limit, out)
    if not out.same_dims or out.different:
        name, patterns = classify(va, vb, threshold_a=ta, threshold_b=tb, tool=tool_a is not None,
                                  chunk_size=chunk_size)
        out.pattern = name if out.same_dims or name != "unclassified" else None
        out.patterns += patterns
    for kind in ("removed", "added"):
        if out.different and out.by_kind[kind] == out.different:
            out.patterns.append(Pattern(f"only-{kind}", f"B is A with voxels {kind}, nothing else"))
    return out


def _mm(values: Vector) -> str:
    return "(" + ", ".join(mm_text(v) for v in values) + ")"


def _count(a: np.ndarray, b: np.ndarray, threshold_a: int, threshold_b: int, chunk_size: int, limit: int,
           out: Differences) -> None:
    """Counts the voxels that differ."""
    if chunk_size not in (16, 32, 64):
        raise UsageError(f"chunk size {chunk_size}: expected 16, 32 or 64")
    at = np.nonzero(a != b)
    out.different = len(at[0])
    if not out.different:
        return
    was, now = a[at], b[at]
    kind = np.where(was >= threshold_a, np.where(now >= threshold_b, 2, 0), np.where(now >= threshold_b, 1, 3))
    out.by_kind = dict(zip(KINDS, np.bincount(kind, minlength=4).tolist()))
    low, high = [int(v.min()) for v in at[::-1]], [int(v.max()) + 1 for v in at[::-1]]
    out.box = (low[0], low[1], low[2]), (high[0], high[1], high[2])
    dims = [-(-n // chunk_size) for n in a.shape]
    number = np.ravel_multi_index([v // chunk_size for v in at], dims)
    table = np.bincount(number * 4 + kind, minlength=4 * int(np.prod(dims))).reshape(-1, 4)
    for n in np.flatnonzero(table.any(axis=1)).tolist():
        z, y, x = (int(v) for v in np.unravel_index(n, dims))
        out.chunks.append(ChunkDifference((x, y, z), int(table[n].sum()), dict(zip(KINDS, table[n].tolist()))))
    out.first = [VoxelDifference((int(x), int(y), int(z)), int(p), int(q))
                 for z, y, x, p, q in zip(*(v[:limit] for v in at), was[:limit], now[:limit])]
