# SPDX-License-Identifier: Apache-2.0
"""An operation: a world whose tools are moved by a device, with a motor, a force and a safety layer.

    program  --tick(pose)--> motor --> force --> World --> Tick: wrench, pose of the tool, removed voxels
    thread   --start(); move(pose)--> servo loop at 1 kHz, in C --> state(), changes()

There are two ways to run an operation. tick() executes one tick of 1 ms at each call: the program has the clock, and
equal poses give equal results. start() runs the servo loop of the C library in a thread, with a tick per millisecond;
the program sets poses with move() at any rate, and reads the newest state. No Python code runs in the loop.

Forces are in N and torques in N m, in the bone's frame (LPS), after the safety layer; torques are about the tool's
origin.

Threads: tick() locks the backend, like every call on it. A running loop locks the backend until it ends: other
calls on the backend and its objects wait. move(), motor, state() and changes() can be called while the loop runs, by
one thread.

The file has more than 500 lines, because most of them document the methods of one class.
"""
import threading
import weakref
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import Owned, call, ffi, lib, text
from osteon.errors import OsteonError, OutOfMemoryError, UsageError, error_of
from osteon.event import Pose
from osteon.force import Force, ForceParams, Triple
from osteon.grid import Geometry
from osteon.session import Recorder, header_of
from osteon.units import Vector
from osteon.world import Path, World

__all__ = ["Chunk", "LiveState", "LoopReport", "Operation", "OperationReport", "Tick", "haptic_devices"]

TICK_NS = 1_000_000
_ENDS = {lib.OST_SERVO_TICKS: "ticks", lib.OST_SERVO_STOPPED: "stopped", lib.OST_SERVO_DEVICE_ENDED: "device ended",
         lib.OST_SERVO_DEVICE_LOST: "device lost", lib.OST_SERVO_WATCHDOG: "watchdog"}


@dataclass(frozen=True)
class LiveState:
    """The state of an operation after a tick (ost_live_state in osteon/live.h).

    Attributes
    ----------
    ticks : int
        Number of ticks that advanced the world.
    t_ns : int
        Time of the last tick.
    device, pose : Pose
        Poses of the device and of the tool, which differ in contact.
    force_n, torque_nm : (float, float, float)
        Hand force in N and hand torque in N m.
    contact_n : float
        Contact force of the tool on the bone.
    rpm : int
        Speed of the motor.
    removals, removed_voxels : int
        Numbers of events and of removed voxels since the start.
    touching : int
        Number of voxels that the tool touched or removed in the last tick.
    fault : str
        "" without a fault; otherwise the reason why the tool does not move and the force is 0.
    missed : int
        Number of ticks that the loop skipped.
    """

    ticks: int
    t_ns: int
    device: Pose
    pose: Pose
    force_n: Triple
    torque_nm: Triple
    contact_n: float
    rpm: int
    removals: int
    removed_voxels: int
    touching: int
    fault: str
    missed: int


def haptic_devices() -> List[Dict[str, Any]]:
    """Returns the devices that Operation.start() can run: name, description, available, the reason if a device is not
    available, and for each button its name and its default action."""
    found = []
    for index in range(lib.ost_haptic_count()):
        info = ffi.new("ost_haptic_info *")
        call(lib.ost_haptic_describe, index, info)
        buttons = {text(b.name): text(lib.ost_action_name(b.action)) for b in info.buttons[0:info.button_count]}
        found.append({"name": text(info.name), "description": text(info.description), "available": info.available,
                      "reason": text(info.reason), "force": bool(info.caps & lib.OST_HAPTIC_FORCE),
                      "buttons": buttons})
    return found


class Tick(NamedTuple):
    """The result of Operation.tick.

    Attributes
    ----------
    force_n, torque_nm : (float, float, float)
        Hand force in N and hand torque in N m.
    pose : Pose
        Pose of the tool, including the rotation of the motor.
    contact_n : float
        Contact force of the tool on the bone.
    removed : int
        Number of voxels that this tick removed.
    fault : str
        "" without a fault; otherwise the reason why the tool does not move and the force is 0.
    """

    force_n: Triple
    torque_nm: Triple
    pose: Pose
    contact_n: float
    removed: int
    fault: str


class OperationReport(NamedTuple):
    """Counts and peak values of an operation (ost_operation_report in osteon/operation.h)."""

    ticks: int
    faults: int
    fault_ticks: int
    dropouts: int
    peak_n: float
    peak_axial_n: float
    energy_j: float
    touching_ticks: int
    damped_ticks: int


class LoopReport(NamedTuple):
    """The result of a servo loop (ost_servo_report in osteon/haptics.h). Times are in microseconds."""

    end: str
    ticks: int
    missed: int
    longest_miss: int
    wake_us: Tuple[float, float, float]
    exec_us: Tuple[float, float, float]
    scheduling: str


class Chunk(NamedTuple):
    """A changed chunk: the index of its first voxel x, y, z, and the occupancy of its voxels, bool [z, y, x]."""

    first: Vector
    active: np.ndarray


class _Live(Owned):
    """The channel that passes the state of an operation to a viewer."""

    _closes_first = -1


@ffi.def_extern()
def osteon_py_chunk(user: Any, at: Any, words: Any, _err: Any) -> int:
    """Receives the occupancy of a chunk from ost_live_take. The words are copied."""
    found, n = ffi.from_handle(user)
    found.append(((at[0], at[1], at[2]), bytes(ffi.buffer(words, n * n * n // 8))))
    return int(lib.OST_OK)


def _triple(values: Any) -> Triple:
    return values[0], values[1], values[2]


class Operation(Owned):
    """A world in operation.

    Parameters
    ----------
    world : World
        The world, on the backend cpu, ref or cl. While the operation is used, no other code may step the world.
    force : ForceParams, optional
        Parameters of the force and the safety layer; the default values if it is not given. None: there is no force,
        and the tool is always at the device's pose.
    rpm : int
        Speed of the motor while it is on.
    motor : bool
        True if the motor is on at the start.
    record : path-like, optional
        Session file to write; finish() completes it.
    device : str
        Name of the source of the poses, for the session.

    Examples
    --------
    >>> with osteon.Operation(world) as operation:                           # doctest: +SKIP
    ...     felt = operation.tick(pose)
    ...     print(felt.force_n, felt.removed)
    """

    _closes_first = -2

    def __init__(self, world: World, *, force: Optional[ForceParams] = ForceParams(), rpm: int = int(lib.OST_RPM_REAMER),
                 motor: bool = True, record: Any = None, device: str = "program") -> None:
        if force is not None and force["dead_man"]:
            raise UsageError("force parameter dead_man: an operation in Python has no buttons; expected 0")
        if not 0 <= rpm <= lib.OST_RPM_MAX:
            raise UsageError(f"a motor speed of {rpm} rpm; expected 0 to {lib.OST_RPM_MAX}")
        bone = world.bone
        self.world, self.rpm = world, rpm
        self.force = None if force is None else Force(bone, world.tools, force, rpm=rpm)
        self._number, self._removed = 0, 0
        self._motor = bool(motor)
        self._thread: Optional[threading.Thread] = None
        self._loop: Any = None
        self._outcome: Any = None
        with bone._lock.held:
            live = ffi.new("ost_live_channel **")
            call(lib.ost_live_create, bone._c, live)
            self._live = _Live(live[0], lib.ost_live_free, bone._lock, bone)
            bone.backend._adopt(self._live)
        self._chunk = lib.ost_live_chunk_size(self._live._c)
        self._recorder = None if record is None else Recorder(record, self._header(device, force))
        options = ffi.new("ost_operation_options *", {"rpm": rpm, "motor_waits": True, "live": self._live._c})
        options.buttons[0] = lib.OST_ACTION_MOTOR  # button 0 of tick() and move(); a pose and its motor arrive together
        if self.force is not None and force is not None:
            options.force, options.safety = self.force._c, force._safety
        if self._recorder is not None:
            options.recorder = self._recorder._c
        out = ffi.new("ost_operation **")
        with bone._lock.held:
            call(lib.ost_operation_create, world._c, options, out)
        super().__init__(out[0], lib.ost_operation_free, bone._lock, (world, self.force, self._live, self._recorder))
        bone.backend._adopt(self)
        self._sample, self._wrench, self._seen = (ffi.new("ost_servo_sample *"), ffi.new("ost_wrench *"),
                                                  ffi.new("ost_live_state *"))

    def _header(self, device: str, force: Optional[ForceParams]) -> Any:
        header = header_of(self.world, device)
        memory = ffi.new("char[]", lib.OST_FORCE_VALUE)
        for name, value in ({} if force is None else force.values).items():
            header[f"force.{name}"] = text(lib.ost_force_value_text(value, memory))
        return header

    @property
    def motor(self) -> bool:
        """True if the motor is on. Can be set while the loop runs."""
        return self._motor

    @motor.setter
    def motor(self, on: bool) -> None:
        self._motor = bool(on)
        if self._loop is None:
            return
        if self._mouse == ffi.NULL:
            lib.ost_operation_keys(self._c, (1 << lib.OST_ACTION_MOTOR) if on else 0)
        else:
            self._input.lifted, self._input.buttons = False, self._motor
            lib.ost_mouse_input_put(self._mouse, self._input)

    # ------------------------------------------------------- the program's clock

    def tick(self, pose: Pose, *, tool: int = 0, lifted: bool = False, fresh: bool = True,
             tracked: bool = True) -> Tick:
        """Executes one tick of 1 ms.

        Parameters
        ----------
        pose : Pose
            Pose of the device, without the rotation of the motor. If it is more than 5 mm from the last pose, the tick
            is a fault.
        tool : int
            Index of the tool in use.
        lifted : bool
            True if the tool was lifted and put down at this pose: nothing is removed in between.
        fresh : bool
            False if the device returned no new pose; `pose` is then the last one.
        tracked : bool
            False if tracking is lost: the tool stays where it is, and the force is 0.
        """
        if self._loop is not None:
            raise UsageError("the loop of this operation is running; use move() and state()")
        s, wrench = self._sample, self._wrench
        s.number, s.t_ns = self._number, self._number * TICK_NS
        s.declared, s.tracking_lost = not fresh, not tracked
        to = s.state
        to.tool, to.lifted, to.buttons = tool, lifted, self._motor
        pose._store(to.pose)
        ffi.memmove(wrench, bytes(ffi.sizeof("ost_wrench")), ffi.sizeof("ost_wrench"))
        with self._lock.held:
            if self.world.closed or self.world.bone.closed:
                raise UsageError("the world of this Operation is closed")
            if not lib.ost_operation_tick(self._c, s, wrench):
                raise self._failure()
            lib.ost_operation_done(self._c, self._number, 0)
            self._number += 1
            seen = self._state()
        removed, self._removed = seen.removed_voxels - self._removed, seen.removed_voxels
        return Tick(_triple(wrench.force_n), _triple(wrench.torque_nm), Pose._of_c(seen.pose), seen.contact_n, removed,
                    _fault(seen))

    def _failure(self) -> BaseException:
        out = ffi.new("ost_operation_report *")
        lib.ost_operation_report_get(self._c, out)
        return error_of(out.status, ffi.addressof(out, "error"))

    def _state(self) -> Any:
        lib.ost_live_state_get(self._live._c, self._seen)
        return self._seen

    # ---------------------------------------------------------------- the loop

    def start(self, pose: Pose = Pose(), *, device: Optional[str] = None, path: Optional[Path] = None, ticks: int = 0,
              clock: bool = True, realtime: bool = True) -> None:
        """Starts the servo loop in a thread. It locks the backend until it ends.

        Parameters
        ----------
        pose : Pose
            First pose of the tool.
        device : str, optional
            A device of `osteon devices`, with its options; the default is a pose that move() sets.
        path : Path, optional
            Path of the device "script", or of the hand of the device "sim".
        ticks : int
            Number of ticks; 0: until stop(), or until the device ends.
        clock : bool
            False to run the ticks without waiting, for devices whose poses do not depend on time.
        realtime : bool
            True to request real-time priority and locked memory from the system.
        """
        if self._thread is not None:
            raise UsageError("the loop of this operation is already running")
        pose.check()
        if self._number:
            raise UsageError("an operation that tick() has advanced cannot run a loop; make a new Operation")
        setup = ffi.new("ost_haptic_setup *", {"start": pose._c()[0]})
        first = ffi.new("ost_haptic_state *", {"pose": pose._c()[0], "buttons": self._motor})
        mouse = ffi.new("ost_mouse_input **")
        keep: List[Any] = []
        if device is None:
            call(lib.ost_mouse_input_create, first, mouse)
            setup.mouse = mouse[0]
        if path is not None:
            memory = ffi.from_buffer(path.ticks)
            keep += [memory, ffi.new("ost_path *", {"count": len(path), "ticks": ffi.cast("ost_tick *", memory)})]
            setup.path = keep[-1]
        haptic = ffi.new("ost_haptic **")
        try:
            call(lib.ost_haptic_open, (device or "mouse").encode(), setup, haptic)
        except OsteonError:
            lib.ost_mouse_input_free(mouse[0])
            raise
        loop = lib.osteon_py_loop_make(self._c)
        if loop == ffi.NULL:
            lib.ost_haptic_close(haptic[0])
            lib.ost_mouse_input_free(mouse[0])
            raise OutOfMemoryError("out of memory for a servo loop")
        options = ffi.new("ost_servo_options *", {"ticks": ticks, "no_clock": not clock,
                                                  "no_realtime": not (clock and realtime)})
        if device is not None:
            lib.ost_operation_keys(self._c, (1 << lib.OST_ACTION_MOTOR) if self._motor else 0)
        self._loop, self._mouse, self._input, self._outcome = loop, mouse[0], first, None
        self._thread = threading.Thread(target=self._run, args=(haptic[0], options, keep), name="osteon servo loop",
                                        daemon=True)
        self._thread.start()
        # At exit, the loop ends before the objects of its backend are freed, which waits for the lock.
        self._guard = weakref.finalize(self, _end, loop, self._thread)

    def _run(self, haptic: Any, options: Any, keep: Any) -> None:
        """Runs the loop; called on its thread."""
        report, err = ffi.new("ost_servo_report *"), ffi.new("ost_error *")
        try:
            with self._lock.held:
                status = lib.osteon_py_loop_run(self._loop, haptic, options, report, err)
                lib.ost_live_flush(self._live._c, ffi.NULL)
        except BaseException as error:  # pylint: disable=broad-except  # wait() raises it in the caller's thread
            self._outcome = None, error
            return
        finally:
            lib.ost_haptic_close(haptic)
            del keep

        def times(of: Any) -> Tuple[float, float, float]:
            return (lib.ost_times_share_us(ffi.addressof(report, of), 0.5),
                    lib.ost_times_share_us(ffi.addressof(report, of), 0.99), getattr(report, of).max_ns / 1e3)

        made = LoopReport(_ENDS[report.end], report.ticks, report.missed, report.longest_miss, times("wake"),
                          times("exec"), text(report.realtime.scheduling))
        self._outcome = made, (error_of(status, err) if status else None)

    def move(self, pose: Pose, *, lifted: bool = False, motor: Optional[bool] = None) -> None:
        """Sets the pose that the tool approaches: with a time constant of 15 ms, at 250 mm/s and 3 turns/s at most.

        Parameters
        ----------
        lifted : bool
            True to put the tool down at this pose in one tick; nothing is removed in between.
        motor : bool, optional
            Switches the motor on or off from this pose on; it is unchanged by default.
        """
        if self._loop is None or self._mouse == ffi.NULL:
            raise UsageError("move() needs a loop that was started without a device")
        pose.check()
        if motor is not None:
            self._motor = motor
        to = self._input
        to.lifted, to.buttons = lifted, self._motor
        pose._store(to.pose)
        lib.ost_mouse_input_put(self._mouse, to)

    @property
    def running(self) -> bool:
        """True while the loop runs."""
        return self._thread is not None and self._thread.is_alive()

    def state(self) -> Optional[LiveState]:
        """Returns the state after the newest tick; None before the first tick."""
        s = self._seen
        if not lib.ost_live_state_get(self._live._c, s):
            return None
        return LiveState(s.ticks, s.t_ns, Pose._of_c(s.device), Pose._of_c(s.pose), _triple(s.force_n),
                         _triple(s.torque_nm), s.contact_n, s.rpm, s.removals, s.removed_voxels, s.touching, _fault(s),
                         s.missed)

    def changes(self) -> Iterator[Chunk]:
        """Yields the chunks that changed since the last call. The first call yields all active chunks.

        While the loop runs, a chunk may be partly updated; a later call then yields it again. After stop(), the chunks
        are those of the bone.
        """
        n = self._chunk
        found: List[Tuple[Vector, bytes]] = []
        handle = ffi.new_handle((found, n))
        call(lib.ost_live_take, self._live._c, lib.osteon_py_chunk, handle)
        for at, words in found:
            bits = np.unpackbits(np.frombuffer(words, np.uint8), bitorder="little")
            yield Chunk((at[0] * n, at[1] * n, at[2] * n), bits.reshape(n, n, n).astype(bool))

    def wait(self, timeout_s: Optional[float] = None) -> Optional[LoopReport]:
        """Waits until the loop ends, and returns its report; None if it still runs after timeout_s seconds.

        Raises
        ------
        OsteonError
            If the loop or the world failed.
        """
        if self._thread is None:
            raise UsageError("the loop of this operation was not started")
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            return None
        self._thread = None
        self._guard.detach()
        loop, self._loop = self._loop, None
        lib.osteon_py_loop_free(loop)
        lib.ost_mouse_input_free(self._mouse)
        self._mouse = ffi.NULL
        report, error = self._outcome
        if error is not None:
            raise error
        out = ffi.new("ost_operation_report *")
        lib.ost_operation_report_get(self._c, out)
        if out.status:
            raise self._failure()
        return report

    def stop(self) -> LoopReport:
        """Ends the loop, and returns its report."""
        if self._loop is None:
            raise UsageError("the loop of this operation was not started")
        lib.osteon_py_loop_stop(self._loop)
        report = self.wait()
        assert report is not None  # wait() without a time returns a report
        return report

    # ------------------------------------------------------------------ the end

    @property
    def report(self) -> OperationReport:
        """Counts and peak values. Available while no loop runs."""
        out = ffi.new("ost_operation_report *")
        with self._lock.held:
            lib.ost_operation_report_get(self._c, out)
        return OperationReport(out.steps, out.faults, out.fault_ticks, out.dropouts, out.peak_n, out.peak_axial_n,
                               out.energy_j, out.touching_ticks, out.damped_ticks)

    @property
    def geometry(self) -> Geometry:
        """Geometry of the bone. Can be read while the loop runs."""
        return self.world.bone.geometry

    def finish(self) -> None:
        """Ends a loop that runs, and completes the session file."""
        if self._loop is not None:
            self.stop()
        if self._recorder is not None:
            recorder, self._recorder = self._recorder, None
            recorder.finish(self.world.totals, self.world.bone.digest())

    def close(self) -> None:
        """Ends a loop that runs, completes the session file, and frees the operation."""
        if not self.closed:
            self.finish()
        super().close()
        self._live.close()
        if self.force is not None:
            self.force.close()


def _end(loop: Any, thread: threading.Thread) -> None:
    lib.osteon_py_loop_stop(loop)
    thread.join()


def _fault(state: Any) -> str:
    return text(lib.ost_fault_text(state.fault)) if state.fault else ""
