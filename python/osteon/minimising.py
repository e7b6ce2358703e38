# SPDX-License-Identifier: Apache-2.0
"""Reduces the event of a difference to a few voxels.

    EventCase --fewer poses, voxels, smaller grids--> candidate --the function still differs in the same way?--> keep

The search is delta debugging that first tries what usually succeeds: the pose, the bone voxel and the tool voxel that
decide the first difference.
"""
from typing import Any, Callable, List, Optional, Tuple

import numpy as np

from osteon.backend import Backend
from osteon.cases import EventCase
from osteon.event import Map
from osteon.findings import Finding
from osteon.grid import Geometry, Volume
from osteon.locating import ONE, compare_event, operand_of
from osteon.mesh import ToolGeometry, ToolVolume
from osteon.plugin import FunctionBackend
from osteon.units import Vector, vector

__all__ = ["Minimiser"]


class Minimiser:
    """Reduces the event of a difference while the function still differs in the same way.

    Cropping the bone by complete blocks of 16 voxels and the tool by complete voxels moves the exact map by integers,
    so that the tool coordinates of all remaining voxels stay the same (AR-MAP-4).
    """

    RUNS = 300  # the search ends after this number of events

    def __init__(self, case: EventCase, finding: Finding, reference: Backend, other: FunctionBackend) -> None:
        self.case, self.finding, self.reference, self.other = case, finding, reference, other
        self.runs = 0
        self.voxel: Optional[Vector] = None  # the first voxel that differs in self.case

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
            geometry = Geometry(vector(voxels.shape[::-1]), g.spacing_pm,
                                vector(g.origin_pm[a] + (x, y, z)[a] * g.spacing_pm[a] for a in range(3)))
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
            geometry = ToolGeometry(vector(voxels.shape[::-1]), t.voxel_pm,
                                    vector(t.corner_pm[a] + (x, y, z)[a] * t.voxel_pm for a in range(3)))
            maps = [each.moved([-(x, y, z)[a] * ONE * each.divisor for a in range(3)]) for each in self.case.maps]
            if self._accept(self._replace(tool=ToolVolume(voxels, geometry), maps=maps)):
                return
