# SPDX-License-Identifier: Apache-2.0
"""Compares a Python function that removes bone with the reference, case by case.

    cases --> World on the reference ---.
      '-----> World on the function ----+-- every event: all voxels, and the report
                                        |
              first difference: tick, voxel, tool coordinate, margin --minimise--> EventCase

The reference is the backend `ref`. For a function, this is what `osteon validate` does for a plugin. A difference is
never a rounding error, because docs/spec/arithmetic.md determines every bit.
"""
import time
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable, List, NamedTuple, Optional, Tuple, Union

import numpy as np

from osteon._c import lib
from osteon.backend import Backend, Bone
from osteon.cases import Case, EventCase, default_cases
from osteon.differences import classify
from osteon.errors import DifferError, OsteonError
from osteon.event import Event, Map, Report
from osteon.grid import Geometry, Volume
from osteon.mesh import ToolGeometry, ToolVolume
from osteon.plugin import FunctionBackend, RemoveFunction
from osteon.units import Vector
from osteon.world import World

__all__ = ["CaseResult", "CheckResult", "Finding", "Operand", "check"]

ONE = 1 << Map.FRACTION  # units of a tool coordinate in one tool voxel


class Operand(NamedTuple):
    """The values that determine a voxel at one pose (AR-MAP-4).

    Attributes
    ----------
    pose : int
        Number of the pose in the event, from 0.
    u : (int, int, int) or None
        Tool coordinate in units of 2^-20 tool voxels; None in a far block.
    tool_voxel : (int, int, int) or None
        Tool voxel that contains the coordinate, x, y, z.
    tool_class : int
        Class of the tool voxel; 0 outside the grid.
    """

    pose: int
    u: Optional[Vector]
    tool_voxel: Optional[Vector]
    tool_class: int


@dataclass
class Finding:
    """The first difference of a case.

    Attributes
    ----------
    case : str
        Name of the case.
    tick : int
        Number of the tick, from 0.
    kind : str
        "missed" (the function did not remove the voxel), "extra" (it removed too much), "changed" (another density),
        "report" (only the number of touched voxels differs), or "error" (the function raised an exception).
    voxel : (int, int, int) or None
        The first voxel that differs, x, y, z, in the order of memory.
    chunk : (int, int, int) or None
        Its chunk.
    before, expected, got : int
        Its density before the event, on the reference, and from the function. For "report": touched voxels.
    different : int
        Number of voxels that differ.
    box : (lo, hi)
        Half-open box of these voxels, x, y, z.
    pattern : str
        Class of the difference, as `osteon diff` prints it.
    operands : list of Operand
        The values that determine the first voxel; poses that decide it come first.
    margin : int or None
        Distance from the tool coordinate to the nearest border behind which the function would be right, in units of
        2^-20 tool voxels; None if no neighbouring tool voxel explains the result.
    error : Exception or None
        For "error": the exception of the function.
    minimised : EventCase or None
        A small case with a difference of the same kind.
    runs : int
        Number of events that were executed to minimise the case.
    """

    case: str
    tick: int
    kind: str
    voxel: Optional[Vector] = None
    chunk: Optional[Vector] = None
    before: int = 0
    expected: int = 0
    got: int = 0
    different: int = 0
    box: Optional[Tuple[Vector, Vector]] = None
    pattern: str = ""
    operands: List[Operand] = field(default_factory=list)
    margin: Optional[int] = None
    error: Optional[BaseException] = None
    minimised: Optional[EventCase] = None
    runs: int = 0

    def __str__(self) -> str:
        lines = [f"{self.case}: tick {self.tick}: {self._what()}"]
        if self.voxel is not None and self.box is not None:
            lines.append(f"  {self.different} voxel{'s differ' if self.different != 1 else ' differs'} in the box "
                         f"{self.box[0]} to {self.box[1]}" + (f", class {self.pattern}" if self.pattern else ""))
        for operand in self.operands[:1]:
            lines.append(f"  pose {operand.pose}: u = {operand.u}, tool voxel {operand.tool_voxel}, class "
                         f"{operand.tool_class}" + ("" if self.margin is None else
                                                    f"; margin {self.margin} / 2^20 of a tool voxel"))
        if self.minimised is not None:
            small = self.minimised
            lines.append(f"  minimised in {self.runs} runs: {_count(len(small.maps), 'pose')}, "
                         f"{_count(np.count_nonzero(small.bone.voxels), 'bone voxel')} in {_size(small.bone)}, "
                         f"{_count(np.count_nonzero(small.tool.voxels), 'tool voxel')} in {_size(small.tool)}")
        return "\n".join(lines)

    def _what(self) -> str:
        if self.kind == "error":
            return f"the function failed: {type(self.error).__name__}: {self.error}"
        if self.kind == "report":
            return f"the function returned {self.got} touched voxels; expected {self.expected}"
        return (f"{self.kind}: voxel {self.voxel} in chunk {self.chunk} has the density {self.got}; expected "
                f"{self.expected}, before the event {self.before}")


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _size(grid: Any) -> str:
    return " x ".join(str(n) for n in grid.geometry.dims)


@dataclass
class CaseResult:
    """The result of a case.

    Attributes
    ----------
    id : str
        Name of the case.
    events : int
        Number of events that were compared.
    finding : Finding or None
        The first difference; None if the case is equal.
    reference_s, function_s : float
        Seconds in the reference and in the function's backend.
    """

    id: str
    events: int
    finding: Optional[Finding]
    reference_s: float
    function_s: float

    @property
    def equal(self) -> bool:
        """True if no result differs."""
        return self.finding is None


@dataclass
class CheckResult:
    """The result of osteon.check. It is true if it is equal; str() is a report.

    Attributes
    ----------
    cases : list of CaseResult
        The results in the order of the cases.
    touched_compared : bool
        False if the function did not return the numbers of touched voxels.
    """

    cases: List[CaseResult]
    touched_compared: bool = True

    @property
    def equal(self) -> bool:
        """True if at least one event was compared and no result differs."""
        return all(case.equal for case in self.cases) and any(case.events for case in self.cases)

    def __bool__(self) -> bool:
        return self.equal

    @property
    def findings(self) -> List[Finding]:
        """The first difference of each case that differs."""
        return [case.finding for case in self.cases if case.finding is not None]

    @property
    def verdict(self) -> str:
        """EQUAL, NOT EQUAL, or NOT COMPARED if there was no event."""
        return "EQUAL" if self.equal else "NOT EQUAL" if self.findings else "NOT COMPARED"

    def __str__(self) -> str:
        events = sum(case.events for case in self.cases)
        text = f"{self.verdict}: {_count(len(self.cases), 'case')}, {_count(events, 'event')} compared"
        if not self.touched_compared:
            text += "; touched voxels were not compared, because the function returned None"
        return "\n".join([text] + [str(finding) for finding in self.findings])

    def raise_if_different(self) -> None:
        """Raises DifferError with the report unless the result is equal. For tests."""
        if not self.equal:
            raise DifferError(str(self))


Progress = Callable[[str, int, int], Any]


def check(function: RemoveFunction, cases: Union[None, str, Case, EventCase, Iterable[Union[Case, EventCase]]] = None,
          *, minimise: bool = True, stop: bool = False, progress: Optional[Progress] = None) -> CheckResult:
    """Compares a function that removes bone with the reference.

    Parameters
    ----------
    function : callable
        function(bone, tool, event), see osteon.FunctionBackend. A function on a GPU copies its arguments to the device
        and the result back.
    cases : iterable of Case or EventCase, or str, optional
        The default is osteon.tie_cases and the smoke tier of `osteon validate` (osteon.campaign_cases). A text is the
        beginning of the names of these cases, such as "ties", "poses" or "sweep/1".
    minimise : bool
        False to report differences without reducing them.
    stop : bool
        True to end after the first case that differs.
    progress : callable, optional
        Called with the name of the case, the tick and the number of ticks.

    Returns
    -------
    CheckResult
        True if every voxel and every report is equal.

    Examples
    --------
    >>> result = osteon.check(my_remove, cases="poses")                      # doctest: +SKIP
    >>> print(result)                                                        # doctest: +SKIP
    """
    if cases is None or isinstance(cases, str):
        cases = default_cases(cases or "")
    elif isinstance(cases, (Case, EventCase)):
        cases = [cases]
    results: List[CaseResult] = []
    touched = True
    for case in cases:
        with Backend("ref") as reference, FunctionBackend(function, "ref") as other:
            run = _Run(case, reference, other)
            result = run.event() if isinstance(case, EventCase) else run.path(progress)
            touched = touched and other.counts_touched is not False
            if result.finding is not None and minimise and run.small is not None:
                _Minimiser(run.small, result.finding, reference, other).run()
        results.append(result)
        if stop and not result.equal:
            break
    return CheckResult(results, touched)


class _Run:
    """Runs one case on the reference and on the function."""

    def __init__(self, case: Union[Case, EventCase], reference: Backend, other: FunctionBackend) -> None:
        self.case, self.reference, self.other = case, reference, other
        self.small: Optional[EventCase] = None  # the event of the first difference
        self.spent = [0.0, 0.0]

    def _timed(self, which: int, function: Callable[..., Any], *arguments: Any) -> Tuple[Any, Optional[OsteonError]]:
        begin = time.perf_counter()
        try:
            return function(*arguments), None
        except OsteonError as error:
            return None, error
        finally:
            self.spent[which] += time.perf_counter() - begin

    def _result(self, events: int, finding: Optional[Finding]) -> CaseResult:
        return CaseResult(self.case.id, events, finding, self.spent[0], self.spent[1])

    def event(self) -> CaseResult:
        """Compares one event."""
        case = self.case
        assert isinstance(case, EventCase)
        self.small = case
        finding = compare_event(case, self.reference, self.other, self._timed)
        return self._result(1, finding)

    def path(self, progress: Optional[Progress]) -> CaseResult:
        """Compares every event of a path."""
        case = self.case
        assert isinstance(case, Case)
        worlds, bones = [], []
        for backend in (self.reference, self.other):
            bone = backend.bone(case.bone, threshold=case.threshold, chunk_size=case.chunk_size, resample="nearest")
            tools = [backend.tool(tool) for tool in case.tools]
            worlds.append(World(bone, tools, sweep=case.sweep, removal_period_ns=case.removal_period_ns))
            bones.append(bone)
        expected = bones[0].voxels()
        events = 0
        for number, tick in enumerate(case.path.ticks):
            if progress is not None:
                progress(case.id, number, len(case.path))
            before, calls = expected, self.other.calls
            step, refused = self._timed(0, worlds[0].step, tick)
            _, failed = self._timed(1, worlds[1].step, tick)
            if refused is not None and failed is not None and refused.status == failed.status:
                continue  # the tick exceeds a limit; no world has changed
            if refused is not None:
                raise refused
            if failed is None and self.other.calls == calls:
                continue  # the boxes of bone and tool do not intersect
            events += 1
            if step.removed:
                expected = bones[0].voxels()
            want = worlds[0].report
            got = worlds[1].report if failed is None else None
            finding = compare(case.id, number, before, expected, bones[1], want, got, failed, self.other)
            if finding is not None:
                self.small = self._event_case(before, int(tick["tool"]))
                describe(finding, self.small, before, expected, bones[1])
                return self._result(events, finding)
        return self._result(events, None)

    def _event_case(self, before: np.ndarray, tool: int) -> Optional[EventCase]:
        case, event = self.case, self.other._instance.last_event
        assert isinstance(case, Case)
        if event is None:
            return None
        return EventCase(case.id, Volume(before, event.bone), case.tools[tool], event.maps, case.threshold,
                         case.chunk_size, event.classes)


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
        return Finding(name, tick, kind, (x, y, z), tuple(v // got_bone.chunk_size for v in (x, y, z)), was,
                       want_density, has, len(at[0]),
                       (tuple(int(a.min()) for a in at[::-1]), tuple(int(a.max()) + 1 for a in at[::-1])))
    if want is not None and got_report is not None and not want.same(got_report, touched=bool(other.counts_touched)):
        return Finding(name, tick, "report", expected=want.touched, got=got_report.touched)
    return None


def compare_event(case: EventCase, reference: Backend, other: FunctionBackend,
                  timed: Optional[Callable[..., Any]] = None) -> Optional[Finding]:
    """Executes one event on both backends and compares the results."""
    run = timed or _Run(case, reference, other)._timed
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
    u = tuple(int(base[a] + sum(inner[b] * int(each.step[b, a]) for b in range(3))) for a in range(3))
    at = tuple(v >> Map.FRACTION for v in u)
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


# ------------------------------------------------------------------- minimising


class _Minimiser:
    """Reduces the event of a difference while the function still differs in the same way.

    Cropping the bone by complete blocks of 16 voxels and the tool by complete voxels moves the exact map by integers,
    so that the tool coordinates of all remaining voxels stay the same (AR-MAP-4).
    """

    RUNS = 300  # the search ends after this number of events

    def __init__(self, case: EventCase, finding: Finding, reference: Backend, other: FunctionBackend) -> None:
        self.case, self.finding, self.reference, self.other = case, finding, reference, other
        self.runs = 0

    def run(self) -> None:
        """Sets the member `minimised` of the finding."""
        if not self._accept(self.case):
            return  # the difference depends on earlier calls of the function
        self._fewer_poses()
        self._crop_bone()
        self._fewer(lambda: self.case.bone.voxels, self._with_bone)
        self._fewer(lambda: self.case.tool.voxels, self._with_tool)
        self._crop_tool()
        self._crop_bone()
        self.case.id = f"{self.finding.case} (minimised)"
        self.finding.minimised, self.finding.runs = self.case, self.runs

    def _accept(self, case: Optional[EventCase]) -> bool:
        """Keeps a case if the function differs in it in the same way."""
        if case is None or self.runs >= self.RUNS:
            return False
        self.runs += 1
        found = compare_event(case, self.reference, self.other)
        if found is None or found.kind != self.finding.kind:
            return False
        if found.kind == "error" and type(found.error) is not type(self.finding.error):
            return False
        self.case, self.voxel = case, found.voxel
        return True

    def _replace(self, **changes: Any) -> EventCase:
        values = {name: getattr(self.case, name) for name in ("id", "bone", "tool", "maps", "threshold", "chunk_size",
                                                              "classes")}
        return EventCase(**{**values, **changes})

    def _fewer_poses(self) -> None:
        for operand in self.finding.operands[:8]:
            if self._accept(self._replace(maps=[self.case.maps[operand.pose]])):
                return
        step = len(self.case.maps) // 2
        while step:
            start = 0
            while start < len(self.case.maps) > 1:
                kept = self.case.maps[:start] + self.case.maps[start + step:]
                if not (kept and self._accept(self._replace(maps=kept))):
                    start += step
            step //= 2

    def _with_bone(self, voxels: np.ndarray) -> EventCase:
        return self._replace(bone=Volume(voxels, self.case.bone.geometry))

    def _with_tool(self, voxels: np.ndarray) -> EventCase:
        return self._replace(tool=ToolVolume(voxels, self.case.tool.geometry))

    def _fewer(self, current: Callable[[], np.ndarray], make: Callable[[np.ndarray], EventCase]) -> None:
        """Sets as many voxels to 0 as possible: first all except the one that decides, then halves, quarters ..."""
        voxels = current()
        keep = np.zeros(voxels.shape, bool)
        for place in self._deciding(voxels is self.case.tool.voxels):
            keep[place] = True
        if keep.any() and self._accept(make(np.where(keep, voxels, 0).astype(voxels.dtype))):
            return
        parts = 2
        while parts <= 64:
            places = np.flatnonzero(current())
            if len(places) < parts:
                break
            removed = False
            for part in np.array_split(places, parts):
                smaller = current().copy()
                smaller.flat[part] = 0
                removed = self._accept(make(smaller)) or removed
            parts = 2 if removed and len(places) > 2 else parts * 2

    def _deciding(self, tool: bool) -> List[Tuple[int, int, int]]:
        """Returns the indices z, y, x of the bone voxel that differs, or of the tool voxels that it meets."""
        if self.voxel is None:
            return []
        if not tool:
            x, y, z = self.voxel
            return [(z, y, x)]
        found = [operand_of(each, 0, self.voxel, self.case.tool).tool_voxel for each in self.case.maps]
        return [(at[2], at[1], at[0]) for at in found
                if at is not None and all(0 <= v < n for v, n in zip(at, self.case.tool.geometry.dims))]

    def _crop_bone(self) -> None:
        at = np.nonzero(self.case.bone.voxels)
        if not len(at[0]):
            return
        g, high = self.case.bone.geometry, [int(a.max()) + 1 for a in at]
        first = [int(a.min()) // Map.BLOCK * Map.BLOCK for a in at]
        # A function with floats may round differently after the origin has moved; then only the ends are cropped.
        for low in ([first, [0, 0, 0]] if any(first) else [first]):
            x, y, z = low[::-1]
            voxels = np.ascontiguousarray(self.case.bone.voxels[low[0]:high[0], low[1]:high[1], low[2]:high[2]])
            geometry = Geometry(tuple(voxels.shape[::-1]), g.spacing_pm,
                                tuple(g.origin_pm[a] + (x, y, z)[a] * g.spacing_pm[a] for a in range(3)))
            maps = [each.moved([sum((x, y, z)[b] * each.column[b][a] for b in range(3)) for a in range(3)])
                    for each in self.case.maps]
            if self._accept(self._replace(bone=Volume(voxels, geometry), maps=maps)):
                return

    def _crop_tool(self) -> None:
        at = np.nonzero(self.case.tool.voxels)
        if not len(at[0]):
            return
        t, high = self.case.tool.geometry, [int(a.max()) + 1 for a in at]
        first = [int(a.min()) for a in at]
        for low in ([first, [0, 0, 0]] if any(first) else [first]):
            x, y, z = low[::-1]
            voxels = np.ascontiguousarray(self.case.tool.voxels[low[0]:high[0], low[1]:high[1], low[2]:high[2]])
            geometry = ToolGeometry(tuple(voxels.shape[::-1]), t.voxel_pm,
                                    tuple(t.corner_pm[a] + (x, y, z)[a] * t.voxel_pm for a in range(3)))
            maps = [each.moved([-(x, y, z)[a] * ONE * each.divisor for a in range(3)]) for each in self.case.maps]
            if self._accept(self._replace(tool=ToolVolume(voxels, geometry), maps=maps)):
                return
