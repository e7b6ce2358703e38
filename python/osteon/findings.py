# SPDX-License-Identifier: Apache-2.0
"""The results of osteon.check: CheckResult --> CaseResult --> Finding --> Operand. str() of a result is a report."""
from dataclasses import dataclass, field
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon.cases import EventCase
from osteon.errors import DifferError
from osteon.units import Vector

__all__ = ["CaseResult", "CheckResult", "Finding", "Operand"]


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


def _count(number: Any, what: str) -> str:
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
