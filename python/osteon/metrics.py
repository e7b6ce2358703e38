# SPDX-License-Identifier: Apache-2.0
"""The metrics of an operation on a glenoid, compared with a plan (docs/reference/metrics.md).

    bone before, bone after, Plan, motion --measure--> Metrics: values, surface maps
    tools, ticks of a session --Motion.of--> Motion --technique--> values

The values are floats, which are used only in reports.

Threads: the functions share no state.
"""
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib, meta_to
from osteon.bone import Bone, volume_of
from osteon.event import DEFAULT_CLASSES, DensityClass, classes_to
from osteon.grid import array_of, report_of
from osteon.tool import Tool
from osteon.units import Vector, c_pm3, of_pm3
from osteon.world import Glenoid

__all__ = ["Metrics", "Motion", "Plan", "Shape", "measure", "technique"]

_MAP = int(lib.OST_METRICS_MAP)
MAP_PITCH_MM = float(lib.OST_METRICS_PITCH_MM)
"""Distance between two cells of a surface map, in mm."""


@dataclass(frozen=True)
class Plan:
    """The plan of an operation.

    Parameters
    ----------
    glenoid : Glenoid
        Centre of the face, inward axis and side.
    depth_mm : float
        Planned depth of reaming at the centre of the face.
    trigonum_pm, inferior_angle_pm : (int, int, int), optional
        Landmarks of the scapula. With both, angles are measured in the frame of the scapula, otherwise in the planes
        of the CT.
    """

    glenoid: Glenoid
    depth_mm: float = 3.0
    trigonum_pm: Optional[Vector] = None
    inferior_angle_pm: Optional[Vector] = None

    @classmethod
    def of_meta(cls, meta: Dict[str, str], depth_mm: float = 3.0) -> "Plan":
        """Reads a plan from the facts of a file, for example Bone.meta."""
        facts, out, there = ffi.new("ost_meta *"), ffi.new("ost_pm3 *"), ffi.new("bool *")
        meta_to(facts, meta)
        points: List[Optional[Vector]] = []
        for key in (lib.OST_META_TRIGONUM, lib.OST_META_INFERIOR_ANGLE):
            call(lib.ost_point_from_meta, facts, key, out, there)
            points.append(of_pm3(out) if there[0] else None)
        return cls(Glenoid.of_meta(meta), depth_mm, points[0], points[1])

    @property
    def angles_deg(self) -> Optional[Tuple[float, float]]:
        """Retroversion and superior inclination of the axis in the frame of the scapula; None without landmarks."""
        version, inclination = ffi.new("double *"), ffi.new("double *")
        if not lib.ost_metrics_angles(self._c(), version, inclination):
            return None
        return float(version[0]), float(inclination[0])

    def _c(self) -> Any:
        plan = ffi.new("ost_metrics_plan *", {"at": c_pm3(self.glenoid.at_pm), "axis": list(self.glenoid.axis),
                                              "left": self.glenoid.side == "left", "depth_mm": self.depth_mm})
        if self.trigonum_pm is not None and self.inferior_angle_pm is not None:
            plan.landmarks = True
            plan.trigonum, plan.inferior = c_pm3(self.trigonum_pm), c_pm3(self.inferior_angle_pm)
        return plan


MOTION = np.dtype({
    "names": ["t_s", "mm", "axis", "force_n", "removed", "touched", "tool"],
    "formats": [np.float64, (np.float64, 3), (np.float64, 3), np.float64, np.uint32, np.uint32, np.int32],
    "offsets": [ffi.offsetof("ost_motion", name) for name in ("t_s", "mm", "axis", "force_n", "removed", "touched",
                                                              "tool")],
    "itemsize": ffi.sizeof("ost_motion")})
"""The type of a tick of a motion, with the memory layout of ost_motion (osteon/metrics.h)."""


class Shape(NamedTuple):
    """The cutting part of a tool: its role, radius and length in mm, and its tip in the frame of the tool."""

    kind: int
    radius_mm: float
    length_mm: float
    tip_mm: Tuple[float, float, float]

    @classmethod
    def of(cls, tool: Tool) -> "Shape":
        """Determines the shape of a tool, by the rule of ost_metrics_tool_make (osteon/metrics.h)."""
        made = ffi.new("ost_metrics_tool *")
        with tool._lock.held:
            call(lib.ost_metrics_tool_make, tool._c, made)
        return cls(made.kind, made.radius_mm, made.length_mm, tuple(made.tip_mm))


class Motion(NamedTuple):
    """The motion of tools: an array of the type MOTION in ascending order of time, and the shapes of the tools."""

    ticks: np.ndarray
    tools: Tuple[Shape, ...]

    @classmethod
    def of(cls, ticks: np.ndarray, tools: Iterable[Tool]) -> "Motion":
        """Makes a motion from the ticks of a session.

        Parameters
        ----------
        ticks : ndarray
            Session.ticks, or the part of them up to the end of the operation.
        tools : iterable of Tool
            The tools of the session, to which the ticks refer by index.
        """
        shapes = tuple(Shape.of(tool) for tool in tools)
        made = np.zeros(len(ticks), MOTION)
        made["t_s"], made["tool"] = ticks["tick"]["t_ns"] * 1e-9, ticks["tick"]["tool"]
        made["removed"], made["touched"] = ticks["removed"], ticks["touched"]
        made["force_n"] = np.sqrt(np.square(ticks["force_un"] * 1e-6).sum(axis=1))
        q = ticks["tick"]["q30"] / float(lib.OST_Q30_ONE)
        w, x, y, z = (q / np.sqrt(np.square(q).sum(axis=1, keepdims=True))).T
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        tips = np.zeros((len(ticks), 3))
        for index, shape in enumerate(shapes):
            tips[made["tool"] == index] = shape.tip_mm
        made["axis"] = -turn[:, 2].T
        made["mm"] = ticks["tick"]["t_pm"] / float(lib.OST_PM_PER_MM) + np.einsum("abn,nb->na", turn, tips)
        return cls(made, shapes)


class Metrics(NamedTuple):
    """The metrics of an operation.

    Attributes
    ----------
    values : dict
        The members of ost_metrics (osteon/metrics.h) by name; NaN for a value that could not be measured.
    removed_by_class_mm3 : dict
        Removed volume by the names of the density classes.
    before_mm, after_mm : ndarray
        Maps of the positions of both surfaces along the axis of the plan, float32, NaN where there is no bone. A map
        is indexed [v, u]: u is across and v upward, with cells at distances of MAP_PITCH_MM, centred on the axis.
    depth_mm : ndarray
        Map of the depth below the native face, NaN where no bone was exposed.
    drilled : ndarray
        Map of the cells in which a drill removed bone.
    """

    values: Dict[str, Any]
    removed_by_class_mm3: Dict[str, float]
    before_mm: np.ndarray
    after_mm: np.ndarray
    depth_mm: np.ndarray
    drilled: np.ndarray


def measure(before: Any, after: Any, plan: Plan, motion: Optional[Motion] = None, *, threshold: Optional[int] = None,
            classes: Iterable[Tuple[str, int]] = DEFAULT_CLASSES) -> Metrics:
    """Computes the metrics of an operation, as `osteon ream --debrief` does.

    Parameters
    ----------
    before, after : Bone or Volume
        The bone before and after the operation, with the same geometry.
    plan : Plan
        The plan.
    motion : Motion, optional
        The motion; without it, the values that need the poses of a tool are not computed.
    threshold : int, optional
        Lowest density of bone; the default is that of the bone, or 120.
    classes : iterable of (str, int)
        Names and borders of the density classes.

    Raises
    ------
    InputError
        If no bone was removed.
    """
    for bone in (before, after):
        if threshold is None and isinstance(bone, Bone):
            threshold = bone.threshold
    volumes = volume_of(before), volume_of(after)
    if threshold is None:
        threshold = int(volumes[0].meta.get("threshold", 120))
    named = [DensityClass(*c) for c in classes]
    c_before, c_after = (volume._c() for volume in volumes)
    out = ffi.new("ost_metrics *")
    c_motion, keep = _motion(motion)
    call(lib.ost_metrics_make, c_before, c_after, threshold, classes_to(named), plan._c(), c_motion, out)
    del keep
    values = report_of_scalars(out)
    by_class = {c.name: out.removed_by_class_mm3[i] for i, c in enumerate(named)}
    maps = [array_of(getattr(out, name), _MAP * _MAP, kind, (_MAP, _MAP)).copy()
            for name, kind in (("before_mm", np.float32), ("after_mm", np.float32), ("depth_mm", np.float32),
                               ("drilled", np.bool_))]
    return Metrics(values, by_class, *maps)


def report_of_scalars(struct: Any) -> Dict[str, Any]:
    """Returns the members of a struct that are not arrays as a dict."""
    return {name: getattr(struct, name) for name, member in ffi.typeof(struct).item.fields
            if member.type.kind == "primitive"}


def _motion(motion: Optional[Motion]) -> Tuple[Any, Any]:
    """Returns an ost_metrics_motion or NULL, and the memory to which it refers."""
    if motion is None:
        return ffi.NULL, None
    tools = ffi.new("ost_metrics_tool[]", [{"kind": t.kind, "radius_mm": t.radius_mm, "length_mm": t.length_mm}
                                           for t in motion.tools])
    ticks = np.ascontiguousarray(motion.ticks, MOTION)
    return ffi.new("ost_metrics_motion *", {
        "tools": tools, "tool_count": len(tools), "ticks": ffi.cast("ost_motion *", ffi.from_buffer(ticks)),
        "count": len(ticks)}), (tools, ticks)


def technique(motion: Motion, plan: Plan) -> Dict[str, Any]:
    """Computes the values of ost_technique (osteon/metrics.h): path, contacts, passes, forces, tilt and plunges."""
    ticks = np.ascontiguousarray(motion.ticks, MOTION)
    out = ffi.new("ost_technique *")
    call(lib.ost_technique_make, ffi.cast("ost_motion *", ffi.from_buffer(ticks)), len(ticks), plan._c(), out)
    return report_of(out)
