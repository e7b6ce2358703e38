# SPDX-License-Identifier: Apache-2.0
"""Compares the results of one event, and describes the first voxel that differs.

    bone before, expected bone, bone of the function --compare--> Finding --describe--> operands, margin, class

An operand is the tool coordinate that decides the voxel at one pose (AR-MAP-4). The margin is the distance from this
coordinate to the nearest border behind which the function would be right, as in `osteon compare`.
"""
from typing import Any, Callable, Optional

import numpy as np

from osteon._c import lib
from osteon.backend import Backend
from osteon.bone import Bone
from osteon.cases import EventCase
from osteon.differences import classify
from osteon.errors import OsteonError
from osteon.event import Map, Report
from osteon.findings import Finding, Operand
from osteon.grid import Volume
from osteon.mesh import ToolVolume
from osteon.plugin import FunctionBackend
from osteon.units import Vector, vector

__all__ = ["ONE", "class_at", "compare", "compare_event", "describe", "margin_of", "operand_of"]

ONE = 1 << Map.FRACTION  # units of a tool coordinate in one tool voxel


def compare(name: str, tick: int, before: np.ndarray, expected: np.ndarray, got_bone: Bone, want: Optional[Report],
            got_report: Optional[Report], failed: Optional[OsteonError], other: FunctionBackend) -> Optional[Finding]:
    """Compares the results of an event. Returns None if they are equal."""
    if failed is not None:
        return Finding(name, tick, "error", error=failed.__cause__ or failed)
    got = got_bone.voxels()
    if not np.array_equal(expected, got):
        differs = expected != got
        z, y, x = (int(v) for v in np.unravel_index(int(np.argmax(differs)), differs.shape))
        at = np.nonzero(differs)
        was, want_density, has = int(before[z, y, x]), int(expected[z, y, x]), int(got[z, y, x])
        kind = "missed" if want_density == 0 and has == was else "extra" if has == 0 else "changed"
        return Finding(name, tick, kind, (x, y, z), vector(v // got_bone.chunk_size for v in (x, y, z)), was,
                       want_density, has, len(at[0]),
                       (vector(a.min() for a in at[::-1]), vector(a.max() + 1 for a in at[::-1])))
    if want is not None and got_report is not None and not want.same(got_report, touched=bool(other.counts_touched)):
        return Finding(name, tick, "report", expected=want.touched, got=got_report.touched)
    return None


def _plain(_which: int, function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments), None
    except OsteonError as error:
        return None, error


def compare_event(case: EventCase, reference: Backend, other: FunctionBackend,
                  timed: Optional[Callable[..., Any]] = None) -> Optional[Finding]:
    """Executes one event on both backends and compares the results."""
    run = timed or _plain
    bones, reports, failed = [], [], None
    for which, backend in enumerate((reference, other)):
        bone = backend.bone(case.bone, threshold=case.threshold, chunk_size=case.chunk_size, resample="nearest")
        before = bone.voxels()
        with backend.tool(case.tool) as tool:
            report, error = run(which, bone.remove, tool, case.event())
        if error is not None and which == 0:
            raise error
        failed = error
        bones.append(bone)
        reports.append(report)
    expected = bones[0].voxels()
    finding = compare(case.id, 0, before, expected, bones[1], reports[0], reports[1], failed, other)
    if finding is not None:
        describe(finding, case, before, expected, bones[1])
    for bone in bones:
        bone.close()
    return finding


# ------------------------------------------------------------------- location


def operand_of(each: Map, number: int, voxel: Vector, tool: ToolVolume) -> Operand:
    """Computes the tool coordinate of a bone voxel at one pose (AR-MAP-4)."""
    base = each.block_base([v // Map.BLOCK for v in voxel])
    if base is None:
        return Operand(number, None, None, 0)
    inner = [v % Map.BLOCK for v in voxel]
    u = vector(base[a] + sum(inner[b] * int(each.step[b, a]) for b in range(3)) for a in range(3))
    at = vector(v >> Map.FRACTION for v in u)
    return Operand(number, u, at, class_at(tool, at))


def class_at(tool: ToolVolume, at: Any) -> int:
    """Returns the class of a tool voxel; 0 outside the grid."""
    if any(not 0 <= v < n for v, n in zip(at, tool.geometry.dims)):
        return 0
    return int(tool.voxels[at[2], at[1], at[0]])


def margin_of(operand: Operand, tool: ToolVolume, cuts: bool) -> Optional[int]:
    """Returns the Chebyshev distance of a coordinate to the nearest tool voxel that cuts, or does not cut.

    Only the neighbours of the voxel that contains the coordinate are searched.
    """
    if operand.u is None or operand.tool_voxel is None:
        return None
    best = None
    for cell in np.ndindex(3, 3, 3):
        at = [operand.tool_voxel[a] + cell[a] - 1 for a in range(3)]
        if (class_at(tool, at) == lib.OST_TOOL_CUTTING) != cuts:
            continue
        # a coordinate is in the cell if at 2^20 <= u < (at + 1) 2^20
        away = max(max(at[a] * ONE - operand.u[a], operand.u[a] - (at[a] + 1) * ONE + 1, 0) for a in range(3))
        best = away if best is None else min(best, away)
    return best


def describe(finding: Finding, case: Optional[EventCase], before: np.ndarray, expected: np.ndarray,
             got_bone: Bone) -> None:
    """Adds the operands and the margin of the first voxel to a finding, and the class of the difference."""
    if case is None or finding.voxel is None:
        return
    grid = case.bone.geometry
    finding.pattern = classify(Volume(expected, grid), Volume(got_bone.voxels(), grid), threshold_a=case.threshold,
                               threshold_b=case.threshold, chunk_size=case.chunk_size, before=Volume(before, grid),
                               report_differs=True)[0] or ""  # the report is derived from the voxels
    operands = [operand_of(each, number, finding.voxel, case.tool) for number, each in enumerate(case.maps)]
    wanted = lib.OST_TOOL_CUTTING if finding.expected == 0 and finding.before != 0 else None
    operands.sort(key=lambda o: (o.tool_class != wanted if wanted else o.u is None, o.pose))
    finding.operands = operands
    if finding.kind == "missed":  # every pose that cuts must not cut
        margins = [margin_of(o, case.tool, False) for o in operands if o.tool_class == lib.OST_TOOL_CUTTING]
        finding.margin = None if not margins or None in margins else max(m for m in margins if m is not None)
    elif finding.kind == "extra":  # one pose must cut
        margins = [margin_of(o, case.tool, True) for o in operands]
        known = [m for m in margins if m is not None]
        finding.margin = min(known) if known else None
        if known:
            finding.operands = [operands[i] for i in np.argsort([ONE * 9 if m is None else m for m in margins],
                                                                kind="stable")]
