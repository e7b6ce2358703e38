# SPDX-License-Identifier: Apache-2.0
"""Paths and worlds.

    Path.read, Path.builtin, Path.of_poses --> Path (an array of ticks) --World.run, World.step--> Step

World.step is the only function that advances a world; it calls ost_world_step.

Threads: a world, its bone and its tools may be used by one thread at a time; the lock of their backend ensures this.
"""
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from osteon._c import Owned, call, ffi, lib, meta_to, path_bytes, text
from osteon.bone import Bone
from osteon.errors import UsageError, error_of
from osteon.event import DensityClass, Pose, Report, classes_of, classes_to
from osteon.grid import array_of, report_of
from osteon.mesh import ToolGeometry
from osteon.tool import Tool
from osteon.units import Length, Vector, c_pm3, of_pm3, pm3, vector

__all__ = ["Glenoid", "Path", "RPM_OF_DEVICE", "RPM_ON", "Step", "TICK", "Totals", "World"]

RPM_ON = int(lib.OST_RPM_ON)
RPM_OF_DEVICE = int(lib.OST_RPM_OF_DEVICE)

_AT = {name: ffi.offsetof("ost_tick", name) for name in ("t_ns", "tool", "rpm", "lifted")}
TICK = np.dtype({
    "names": ["t_ns", "tool", "rpm", "t_pm", "q30", "lifted"],
    "formats": [np.int64, np.int32, np.int32, (np.int64, 3), (np.int32, 4), np.bool_],
    "offsets": [_AT["t_ns"], _AT["tool"], _AT["rpm"], ffi.offsetof("ost_tick", "pose"),
                ffi.offsetof("ost_tick", "pose") + ffi.offsetof("ost_pose", "qw"), _AT["lifted"]],
    "itemsize": ffi.sizeof("ost_tick")})
"""The type of a tick, with the memory layout of ost_tick: time t_ns, index of the tool, speed rpm of the motor,
translation t_pm (x, y, z) and quaternion q30 (w, x, y, z) of the pose, and lifted."""


@dataclass(frozen=True)
class Glenoid:
    """A glenoid: the centre of its face, and the inward direction, in the bone's frame.

    Parameters
    ----------
    at_pm : (int, int, int)
        Centre of the face in picometres.
    axis : (float, float, float)
        Inward direction, of any length except 0.
    side : {"left", "right"}
        The side of the body.
    """

    at_pm: Vector
    axis: Tuple[float, float, float]
    side: str

    @classmethod
    def of(cls, at_mm: Iterable[Length], axis: Iterable[float], side: Optional[str] = None) -> "Glenoid":
        """Makes a glenoid from lengths in millimetres. Without a side, the axis determines it."""
        stated = {None: lib.OST_SIDE_UNKNOWN, "left": lib.OST_SIDE_LEFT, "right": lib.OST_SIDE_RIGHT}
        if side not in stated:
            raise UsageError(f"side {side!r}: expected left or right")
        direction = [float(v) for v in axis]
        left = ffi.new("bool *")
        call(lib.ost_glenoid_side, direction, stated[side], left)
        return cls(pm3(at_mm), (direction[0], direction[1], direction[2]), "left" if left[0] else "right")

    @classmethod
    def of_meta(cls, meta: Dict[str, str]) -> "Glenoid":
        """Reads a glenoid from the facts of a file, for example Bone.meta."""
        facts, out = ffi.new("ost_meta *"), ffi.new("ost_glenoid *")
        meta_to(facts, meta)
        call(lib.ost_glenoid_from_meta, facts, out)
        return cls(of_pm3(out.at), (out.axis[0], out.axis[1], out.axis[2]), "left" if out.left else "right")

    def _c(self) -> Any:
        return ffi.new("ost_glenoid *", {"at": c_pm3(self.at_pm), "axis": list(self.axis),
                                         "left": self.side == "left"})


class Path:
    """The motion of a tool: an array of ticks in ascending order of time.

    Parameters
    ----------
    ticks : ndarray
        Structured array of the type TICK. A contiguous array is not copied.
    """

    def __init__(self, ticks: Any) -> None:
        array = np.asarray(ticks)
        if array.dtype != TICK or array.ndim != 1:
            raise UsageError(f"ticks of type {array.dtype} and shape {array.shape}: expected osteon.TICK and one axis")
        self.ticks = np.ascontiguousarray(array)
        self.report: Dict[str, Any] = {}

    def __len__(self) -> int:
        return len(self.ticks)

    def __getitem__(self, index: Any) -> Any:
        return Path(self.ticks[index]) if isinstance(index, slice) else self.ticks[index]

    @classmethod
    def of_poses(cls, poses: Sequence[Pose], *, t_ns: Optional[Sequence[int]] = None, tool: int = 0,
                 rpm: int = RPM_ON, rate_hz: int = 1000) -> "Path":
        """Makes a path from poses of the tool.

        Parameters
        ----------
        t_ns : sequence of int, optional
            Times in nanoseconds; the default is `rate_hz` poses per second, beginning at 0.
        rpm : int
            Speed of the motor; 0 if it is off. With RPM_OF_DEVICE, the poses are poses of the hand (Path.turned).
        """
        ticks = np.zeros(len(poses), TICK)
        ticks["t_ns"] = np.arange(len(poses), dtype=np.int64) * (10**9 // rate_hz) if t_ns is None else t_ns
        ticks["tool"], ticks["rpm"] = tool, rpm
        for i, pose in enumerate(poses):
            ticks["t_pm"][i], ticks["q30"][i] = pose.t_pm, pose.q30
        return cls(ticks)

    @classmethod
    def read(cls, path: Any, *, max_gap_ns: int = 0, max_jump_pm: int = 0) -> "Path":
        """Reads a path from a CSV file, or the ticks of a session.

        Parameters
        ----------
        max_gap_ns, max_jump_pm : int
            Rows that are farther apart have a gap between them (AR-PATH-5): 0 computes the limits from the rows, -1
            sets no limit.
        """
        kind = ffi.new("ost_file_kind *")
        memory, report = ffi.new("ost_path *"), ffi.new("ost_path_report *")
        if lib.ost_file_kind_find(path_bytes(path), kind, ffi.NULL) == 0 and kind[0] == lib.OST_FILE_SESSION:
            session = ffi.new("ost_session **")
            call(lib.ost_session_open, path_bytes(path), session)
            try:
                call(lib.ost_session_path, session[0], memory)
            finally:
                lib.ost_session_close(session[0])
        else:
            options = ffi.new("ost_path_options *", {"max_gap_ns": max_gap_ns, "max_jump_pm": max_jump_pm})
            call(lib.ost_path_read, path_bytes(path), options, memory, report)
        made = cls._of_c(memory)
        made.report = report_of(report)
        return made

    @classmethod
    def builtin(cls, name: str, glenoid: Glenoid, tool: Union[Tool, ToolGeometry], index: int = 0) -> "Path":
        """Makes a built-in path of a hand on a glenoid. Path.turned adds the rotation of the motor.

        Parameters
        ----------
        name : {"peg-hole", "glenoid-ream", "glenoid-slow", "glenoid-press"}
            The path, as for `osteon ream --path builtin:NAME`.
        tool : Tool or ToolGeometry
            The tool, whose working face points to -z.
        index : int
            Index of the tool in the world.
        """
        names = {text(lib.ost_builtin_name(which)): which for which in range(lib.OST_BUILTIN_COUNT)}
        if name not in names:
            raise UsageError(f"path {name!r}: expected one of {', '.join(names)}")
        geometry = tool if isinstance(tool, ToolGeometry) else tool.geometry
        memory = ffi.new("ost_path *")
        call(lib.ost_builtin_path, names[name], glenoid._c(), geometry._c(), index, memory)
        return cls._of_c(memory)

    @classmethod
    def press(cls, glenoid: Glenoid, tool: Union[Tool, ToolGeometry], count: int, index: int = 0) -> "Path":
        """Makes the path "glenoid-press" with a given number of ticks: a hand presses the tool into the face, moves over
        the face and wobbles.
        """
        geometry = tool if isinstance(tool, ToolGeometry) else tool.geometry
        memory = ffi.new("ost_path *")
        call(lib.ost_builtin_press, glenoid._c(), geometry._c(), index, count, memory)
        return cls._of_c(memory)

    def turned(self, rpm: int = int(lib.OST_RPM_REAMER)) -> "Path":
        """Converts poses of a hand to the ticks of a tool that a motor rotates at rpm (AR-MOTOR-7).

        Only rows with RPM_OF_DEVICE are converted. A row is divided if the motor turns by more than 1/8 turn.
        """
        memory, motor = ffi.new("ost_path *"), ffi.new("ost_motor *")
        call(lib.ost_path_init, memory, len(self))
        ffi.memmove(memory.ticks, ffi.from_buffer(self.ticks), self.ticks.nbytes)
        try:
            call(lib.ost_motor_path, memory, rpm, motor)
        except BaseException:
            lib.ost_path_free(memory)
            raise
        return Path._of_c(memory)

    def write_csv(self, path: Any) -> None:
        """Writes a CSV file, which Path.read and `osteon ream --path` read."""
        memory = ffi.new("ost_path *", {"count": len(self), "ticks": ffi.cast("ost_tick *",
                                                                              ffi.from_buffer(self.ticks))})
        call(lib.ost_path_write_csv, path_bytes(path), memory)

    def poses(self) -> List[Pose]:
        """Returns the poses of the ticks."""
        return [Pose(vector(t), (w, x, y, z)) for t, (w, x, y, z) in
                zip(self.ticks["t_pm"].tolist(), self.ticks["q30"].tolist())]

    @classmethod
    def _of_c(cls, memory: Any) -> "Path":
        if memory.count == 0:
            lib.ost_path_free(memory)
            return cls(np.zeros(0, TICK))
        ticks = ffi.gc(memory.ticks, lambda _: lib.ost_path_free(memory), memory.count * TICK.itemsize)
        return cls(array_of(ticks, memory.count, TICK, (-1,)))


class Step(NamedTuple):
    """The result of a tick (ost_step_result in osteon/sim.h).

    Attributes
    ----------
    removal : bool
        True if the tick was an event.
    boxes_meet : bool
        True if the boxes of bone and tool intersect in at least one pose of the sweep.
    poses : int
        Number of poses of the sweep; 0 without an event.
    removed, touched : int
        Numbers of removed voxels, and of voxels that only noncutting tool voxels cover.
    """

    removal: bool
    boxes_meet: bool
    poses: int
    removed: int
    touched: int


class Totals(NamedTuple):
    """Totals since a world was created."""

    ticks: int
    removals: int
    poses: int
    removed_voxels: int
    removed_by_class: Tuple[int, ...]
    density_by_class: Tuple[int, ...]


class World(Owned):
    """A bone and tools that a path moves.

    Parameters
    ----------
    bone : Bone
        The bone. It is changed by the ticks.
    tools : sequence of Tool
        The tools, numbered from 0, of the same backend.
    sweep : bool
        False if an event has only one pose, as in the thesis.
    removal_period_ns : int
        0 if every tick is an event; otherwise the first tick of every period is an event.
    classes : sequence of (name, border), optional
        Density classes.

    Examples
    --------
    >>> world = osteon.World(bone, [tool])                                   # doctest: +SKIP
    >>> for tick in path.ticks:                                              # doctest: +SKIP
    ...     step = world.step(tick)
    """

    _closes_first = 0

    def __init__(self, bone: Bone, tools: Iterable[Tool], *, sweep: bool = True, removal_period_ns: int = 0,
                 classes: Optional[Iterable[Tuple[str, int]]] = None) -> None:
        tools = list(tools)
        options = ffi.new("ost_world_options *", {"sweep_off": not sweep, "removal_period_ns": removal_period_ns})
        if classes is not None:
            options.classes = classes_to(classes)[0]
        out = ffi.new("ost_world **")
        with bone._lock.held:
            call(lib.ost_world_create, bone._c, options, out)
        super().__init__(out[0], lib.ost_world_free, bone._lock, (bone, tools))
        bone.backend._adopt(self)
        self.bone, self.tools = bone, tools
        self.sweep, self.removal_period_ns = sweep, removal_period_ns
        with self._lock.held, bone.backend._preparing():
            for number, tool in enumerate(tools):
                call(lib.ost_world_add_tool, self._c, f"tool {number}".encode(), tool._c, ffi.NULL)
            call(lib.ost_world_reserve, self._c)  # so that no tick allocates in the C library
        self.classes: Tuple[DensityClass, ...] = classes_of(lib.ost_world_classes(out[0]))
        self._result, self._err, self._tick = (ffi.new("ost_step_result *"), ffi.new("ost_error *"),
                                               ffi.new("ost_tick *"))

    def step(self, tick: Any) -> Step:
        """Advances the world by one tick.

        Parameters
        ----------
        tick : numpy.void
            An element of an array of the type TICK, for example path.ticks[0].

        Raises
        ------
        RangeError
            For a jump or a rotation beyond the limits of AR-SWEEP. The world remains unchanged.
        """
        data = tick.tobytes()
        if len(data) != TICK.itemsize:
            raise UsageError("expected one tick, an element of an array of the type osteon.TICK")
        ffi.memmove(self._tick, data, TICK.itemsize)
        return self._step(self._tick)

    def step_pose(self, t_ns: int, pose: Pose, tool: int = 0, rpm: int = RPM_ON, lifted: bool = False) -> Step:
        """Advances the world by one tick, given by its values, as for a device that returns one pose at a time."""
        to = self._tick
        to.t_ns, to.tool, to.rpm, to.lifted = t_ns, tool, rpm, lifted
        pose._store(to.pose)
        return self._step(to)

    def _step(self, tick: Any) -> Step:
        result = self._result
        with self._lock.held:
            status = lib.ost_world_step(self._c, tick, result, self._err)
            if status:
                raise error_of(status, self._err)
            report = result.report
            if report:
                return Step(result.removal, result.boxes_meet, result.pose_count, report.total_voxels,
                            report.touched_voxels)
            return Step(result.removal, result.boxes_meet, result.pose_count, 0, 0)

    def steps(self, path: Path) -> Iterator[Step]:
        """Executes the ticks of a path one by one, and yields the result of each."""
        memory = ffi.from_buffer(path.ticks)  # prevents that the array is freed
        ticks = ffi.cast("ost_tick *", memory)
        for i in range(len(path)):
            yield self._step(ticks + i)

    def run(self, path: Path, progress: Optional[Callable[[int, Step], Any]] = None) -> Totals:
        """Executes all ticks of a path.

        Parameters
        ----------
        progress : callable, optional
            Called after each tick with the number of the tick and its result. If it returns False, the run ends.

        Returns
        -------
        Totals
            Totals since the world was created.
        """
        for number, step in enumerate(self.steps(path)):
            if progress is not None and progress(number, step) is False:
                break
        return self.totals

    @property
    def report(self) -> Optional[Report]:
        """Report of the last tick, with its chunks; None if the tick was not an event."""
        with self._lock.held:
            if self.closed or not self._result.report:
                return None
            return Report.of(self._result.report, len(self.classes))

    @property
    def step_digest(self) -> int:
        """64-bit digest of the last tick (SES-DIGEST). Equal steps have equal digests on every backend."""
        with self._lock.held:
            if self.closed:
                raise UsageError("the World is closed")
            return int(lib.ost_step_digest(self._result, len(self.classes)))

    @property
    def totals(self) -> Totals:
        """Totals since the world was created."""
        out = ffi.new("ost_world_totals *")
        with self._lock.held:
            lib.ost_world_totals_get(self._c, out)
        n = len(self.classes)
        return Totals(out.ticks, out.removals, out.poses, out.removed_voxels, tuple(out.removed_by_class[0:n]),
                      tuple(out.density_by_class[0:n]))
