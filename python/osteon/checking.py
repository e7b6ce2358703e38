# SPDX-License-Identifier: Apache-2.0
"""Compares a Python function that removes bone with the reference, case by case.

    cases --> World on the reference ---.
      '-----> World on the function ----+-- every event: all voxels, and the report
                                        |
              first difference --locating--> voxel, tool coordinate, margin --minimising--> EventCase

The reference is the backend `ref`. For a function, this is what `osteon validate` does for a plugin. A difference is
never a rounding error, because docs/spec/arithmetic.md determines every bit.
"""
import time
from typing import Any, Callable, Iterable, List, Optional, Tuple, Union

import numpy as np

from osteon.backend import Backend
from osteon.cases import Case, EventCase, default_cases
from osteon.errors import OsteonError
from osteon.findings import CaseResult, CheckResult, Finding
from osteon.grid import Volume
from osteon.locating import compare, compare_event, describe
from osteon.minimising import Minimiser
from osteon.plugin import FunctionBackend, RemoveFunction
from osteon.world import World

__all__ = ["check"]

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
                Minimiser(run.small, result.finding, reference, other).run()
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
