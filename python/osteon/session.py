# SPDX-License-Identifier: Apache-2.0
"""Sessions: files that record the ticks of a world, and the digest of each step.

    World, Path --record--> file --read--> Session (header, ticks as an array) --replay--> Replay
                                              '---frame, write_hdf5, write_mcap--> pandas, HDF5, MCAP

A session contains inputs, not voxels: the same ticks on the same bone and tools produce the same grids on every
backend (docs/spec/session.md). `osteon replay`, `osteon info` and `osteon export` read the files that record() writes.

Threads: a Recorder and a Session may be used by one thread at a time. The writer thread of a recorder belongs to the
C library.
"""
import hashlib
from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import Lock, Owned, call, ffi, lib, path_bytes, text
from osteon.errors import FileError, UnavailableError
from osteon.grid import report_of
from osteon.units import mm_text
from osteon.world import TICK, Path, Step, Totals, World

__all__ = ["Recorder", "Replay", "SESSION_TICK", "Session", "header_of", "read", "record", "repair", "replay",
           "write_csv"]


def _field(name: str) -> int:
    return int(ffi.offsetof("ost_session_tick", name))


SESSION_TICK = np.dtype({
    "names": ["number", "tick", "flags", "buttons", "digest", "removed", "touched", "poses", "fault", "force_un",
              "torque_unm", "wake_ns", "exec_ns", "missed"],
    "formats": [np.uint64, TICK, np.uint32, np.uint32, np.uint64, np.uint32, np.uint32, np.uint16, np.uint16,
                (np.int32, 3), (np.int32, 3), np.uint32, np.uint32, np.uint32],
    "offsets": [_field(name) for name in ("number", "tick", "flags", "buttons", "digest", "removed", "touched",
                                          "poses", "fault", "force_un", "torque_unm", "wake_ns", "exec_ns",
                                          "missed")],
    "itemsize": ffi.sizeof("ost_session_tick")})
"""The type of a recorded tick, with the memory layout of ost_session_tick (osteon/session.h)."""


@dataclass
class Session:
    """The content of a session file.

    Attributes
    ----------
    header : dict
        Keys and values in their order (docs/spec/session.md).
    ticks : ndarray
        Structured array of the type SESSION_TICK, all valid ticks.
    notes : list of (int, str)
        Times in nanoseconds, and the texts of the notes.
    summary : dict
        Counts, and the amount of data that is missing (ost_session_summary).
    missing : str
        One sentence for each kind of missing data; "" if nothing is missing.
    end_digest : str or None
        Digest of the bone at the end; None if the session was not ended.
    """

    header: Dict[str, str]
    ticks: np.ndarray
    notes: List[Tuple[int, str]]
    summary: Dict[str, Any]
    missing: str
    end_digest: Optional[str]

    @property
    def path(self) -> Path:
        """The ticks that can be replayed: those before the first missing tick."""
        return Path(self.ticks["tick"][:int(self.summary["complete_ticks"])])

    def frame(self) -> Any:
        """Returns the ticks as a pandas.DataFrame, with one column per component.

        Raises
        ------
        UnavailableError
            If pandas is not installed.
        """
        try:
            import pandas  # pylint: disable=import-outside-toplevel
        except ImportError:
            raise UnavailableError("pandas is not installed: pip install osteon[frames]") from None
        columns: Dict[str, Any] = {}
        for name in SESSION_TICK.names or ():
            if name == "tick":
                for part in TICK.names or ():
                    columns.update(_columns(part, self.ticks["tick"][part]))
            else:
                columns.update(_columns(name, self.ticks[name]))
        return pandas.DataFrame(columns)

    def write_hdf5(self, path: Any, world: Optional[World] = None) -> None:
        """Writes an HDF5 file in the layout of the recordings of volumetric_drilling (docs/guide/python.md).

        Parameters
        ----------
        path : path-like
            The file, which appears under its name only when it is complete.
        world : World, optional
            A world with the bone and the tools of the session, before its first tick. The session is replayed in this
            world, and the file then contains the voxels that each tick removed.

        Raises
        ------
        UnavailableError
            If h5py is not installed.
        DifferError
            If a tick of the replay has another result than the recorded one.
        """
        from osteon._hdf5 import write  # pylint: disable=import-outside-toplevel  # it imports this module
        write(self, path, world)

    def write_mcap(self, path: Any) -> None:
        """Writes an MCAP file with JSON messages, for example for Foxglove (docs/guide/python.md).

        Raises
        ------
        UnavailableError
            If the package mcap is not installed.
        """
        from osteon._mcap import write  # pylint: disable=import-outside-toplevel  # it imports this module
        write(self, path)


def has_force(ticks: np.ndarray) -> np.ndarray:
    """Returns which ticks have a force or a torque, or wrote a force to the device."""
    return (ticks["flags"] & lib.OST_TICK_FORCE > 0) | ticks["force_un"].any(axis=1) | ticks["torque_unm"].any(axis=1)


def _columns(name: str, values: np.ndarray) -> Dict[str, np.ndarray]:
    if values.ndim == 1:
        return {name: values}
    letters = "wxyz" if values.shape[1] == 4 else "xyz"
    return {f"{name}_{letter}": values[:, i] for i, letter in enumerate(letters)}


def read(path: Any) -> Session:
    """Reads a session. Damage is reported in Session.missing and Session.summary.

    Raises
    ------
    InputError
        If the file is not a session, or if both copies of its header are damaged.
    """
    out = ffi.new("ost_session **")
    call(lib.ost_session_open, path_bytes(path), out)
    session = ffi.gc(out[0], lib.ost_session_close)
    summary = report_of(lib.ost_session_summary_of(session))
    ticks = np.zeros(int(summary["ticks"]), SESSION_TICK)
    rows: Any = ffi.cast("ost_session_tick *", ffi.from_buffer(ticks, require_writable=True)) if len(ticks) else None
    notes: List[Tuple[int, str]] = []
    record_, more, count, end = ffi.new("ost_record *"), ffi.new("bool *"), 0, None
    while True:
        call(lib.ost_session_next, session, record_, more)
        if not more[0]:
            break
        if record_.kind == lib.OST_RECORD_TICK and count < len(ticks):
            rows[count] = getattr(record_, "as").tick
            count += 1
        elif record_.kind == lib.OST_RECORD_NOTE:
            note = getattr(record_, "as").note
            notes.append((note.t_ns, text(note.text)))
        elif record_.kind == lib.OST_RECORD_END and getattr(record_, "as").end.has_root:
            end = bytes(ffi.buffer(getattr(record_, "as").end.root.bytes)).hex()
    memory = ffi.new("char[]", lib.OST_SESSION_MISSING)
    return Session(_header_dict(lib.ost_session_header_of(session)), ticks[:count], notes, summary,
                   text(lib.ost_session_missing(session, memory)), end)


def repair(path: Any, out: Any) -> None:
    """Writes all valid blocks of a damaged or interrupted session to a new file. The file `path` is not changed."""
    opened = ffi.new("ost_session **")
    call(lib.ost_session_open, path_bytes(path), opened)
    try:
        call(lib.ost_session_repair, opened[0], path_bytes(out))
    finally:
        lib.ost_session_close(opened[0])


def write_csv(path: Any, out: Any) -> None:
    """Writes a session file as a CSV table with a line for each tick, as `osteon export` does."""
    opened = ffi.new("ost_session **")
    call(lib.ost_session_open, path_bytes(path), opened)
    try:
        call(lib.ost_session_write_csv, opened[0], path_bytes(out))
    finally:
        lib.ost_session_close(opened[0])


def _header_dict(header: Any) -> Dict[str, str]:
    key, value = ffi.new("char **"), ffi.new("char **")
    found = {}
    for index in range(lib.ost_session_header_count(header)):
        lib.ost_session_header_entry(header, index, ffi.cast("const char **", key), ffi.cast("const char **", value))
        found[text(key[0])] = text(value[0])
    return found


# ------------------------------------------------------------------- recording


def header_of(world: World, device: str = "path") -> Dict[str, str]:
    """Returns the header for a session of a world, in its present state (docs/spec/session.md)."""
    bone, g, settings = world.bone, world.bone.geometry, world.bone.backend.settings

    def vector(v: Any) -> str:
        return ",".join(mm_text(c) for c in v)

    header = {"format": "osteon session 2", "osteon": text(lib.ost_version()),
              "arithmetic": str(int(lib.OST_ARITHMETIC_VERSION)), "build": "python package osteon",
              "backend": bone.backend.name, "isa": settings["isa"], "threads": str(settings["threads"]),
              "bone": bone.source or "memory", "bone_sha256": bone.digest(),
              "bone_dims": ",".join(str(n) for n in g.dims), "bone_spacing_mm": vector(g.spacing_pm),
              "bone_origin_mm": vector(g.origin_pm)}
    for number, tool in enumerate(world.tools):
        header[f"tool.{number}"] = tool.source or "memory"
        header[f"tool_sha256.{number}"] = tool.digest()
    config = {"config.threshold": str(bone.threshold), "config.chunk": str(bone.chunk_size),
              "config.sweep": "on" if world.sweep else "off",
              "config.removal_period_ns": str(world.removal_period_ns),
              "config.classes": ",".join(f"{c.name}:{c.border}" for c in world.classes)}
    header.update(config)
    lines = "".join(f"{key}: {value}\n" for key, value in config.items())
    header["config_sha256"] = hashlib.sha256(lines.encode()).hexdigest()
    load = {"voxel": mm_text(world.tools[0].geometry.voxel_pm) if world.tools else "0.5", "unit": "auto",
            "rule": "winding", "duplicates": "error", "clamp": "no", "resample_oblique": "no"}
    for tool in world.tools[:1]:
        load.update(tool.load)
    load.update(bone.load)
    header.update({f"load.{key}": value for key, value in load.items()})
    header["device"] = device
    return header


class Recorder(Owned):
    """Writes a session while a world runs.

    Parameters
    ----------
    path : path-like
        The file, which is created or replaced.
    header : dict
        Keys and values, for example header_of(world).
    sync : bool
        False to lose more data if the power fails.

    Notes
    -----
    Leaving a `with` block without finish() ends the file without an end record, as after an interruption.
    """

    def __init__(self, path: Any, header: Dict[str, str], *, sync: bool = True) -> None:
        made, out = ffi.new("ost_session_header **"), ffi.new("ost_recorder **")
        call(lib.ost_session_header_create, made)
        try:
            for key, value in header.items():
                call(lib.ost_session_header_set, made[0], key.encode(), value.encode())
            options = ffi.new("ost_recorder_options *", {"no_sync": not sync})
            call(lib.ost_recorder_open, path_bytes(path), made[0], options, out)
        finally:
            lib.ost_session_header_free(made[0])
        super().__init__(out[0], lambda recorder: lib.ost_recorder_close(recorder, ffi.NULL, ffi.NULL), Lock())
        self.path = path
        self._record = ffi.new("ost_record *")
        self._count = 0

    def put(self, tick: Any, step: Step, digest: int) -> None:
        """Puts one tick into the session. The call waits if the ring of the recorder is full.

        Parameters
        ----------
        tick : numpy.void
            The tick, an element of an array of the type TICK.
        step : Step
            The result of World.step.
        digest : int
            World.step_digest after this step.
        """
        record_ = self._record
        record_.kind = lib.OST_RECORD_TICK
        to = getattr(record_, "as").tick
        to.number = self._count
        ffi.memmove(ffi.addressof(to, "tick"), tick.tobytes(), TICK.itemsize)
        to.flags = (lib.OST_TICK_REMOVAL if step.removal else 0) | (lib.OST_TICK_MET if step.boxes_meet else 0)
        to.digest, to.poses = digest, step.poses
        to.removed, to.touched = min(step.removed, 2**32 - 1), min(step.touched, 2**32 - 1)
        with self._lock.held:
            if not lib.ost_recorder_put_waiting(self._c, record_):
                raise FileError(f"{self.path}: tick {self._count} could not be recorded: {self.state['reason']}")
        self._count += 1

    def note(self, t_ns: int, line: str) -> None:
        """Puts a line of text with a time into the session; it is truncated to 103 bytes."""
        record_ = ffi.new("ost_record *", {"kind": lib.OST_RECORD_NOTE})
        to = getattr(record_, "as").note
        to.t_ns = t_ns
        to.text = line.encode()[:lib.OST_SESSION_TEXT - 1]
        with self._lock.held:
            lib.ost_recorder_put_waiting(self._c, record_)

    @property
    def state(self) -> Dict[str, Any]:
        """State of the writer thread: put, written, lost, written_bytes, failing, reason."""
        out = ffi.new("ost_recorder_state *")
        lib.ost_recorder_state_get(self._c, out)
        return report_of(out)

    def finish(self, totals: Totals, digest: Optional[str]) -> None:
        """Writes the end record and closes the file.

        Parameters
        ----------
        totals : Totals
            World.totals.
        digest : str, optional
            Bone.digest() at the end.

        Raises
        ------
        FileError
            If records could not be written or were lost.
        """
        end = ffi.new("ost_session_end *", {"ticks": totals.ticks, "removals": totals.removals,
                                            "removed_voxels": totals.removed_voxels, "has_root": digest is not None})
        if digest is not None:
            end.root.bytes = bytes.fromhex(digest)
        with self._lock.held:
            recorder, self._pointer = self._c, None
            self._finalizer.detach()
            call(lib.ost_recorder_close, recorder, end)


def record(world: World, path: Path, file: Any, *, header: Optional[Dict[str, str]] = None,
           sync: bool = True) -> Totals:
    """Executes the ticks of a path and records them, as `osteon ream --record` does.

    Parameters
    ----------
    header : dict, optional
        The header; the default is header_of(world).
    """
    with Recorder(file, header_of(world) if header is None else header, sync=sync) as recorder:
        for number, step in enumerate(world.steps(path)):
            recorder.put(path.ticks[number], step, world.step_digest)
        recorder.finish(world.totals, world.bone.digest())
    return world.totals


class Replay(NamedTuple):
    """The result of a replay.

    Attributes
    ----------
    ticks : int
        Number of ticks that were executed.
    equal : bool
        True if every tick had the recorded result and, at the end, the bone had the recorded digest.
    first_difference : int or None
        Number of the first tick with another result; the replay ends there.
    end_equal : bool or None
        True if the bone at the end has the recorded digest; None if the session has no end or was not completed.
    """

    ticks: int
    equal: bool
    first_difference: Optional[int]
    end_equal: Optional[bool]


def replay(session: Any, world: World) -> Replay:
    """Executes the ticks of a session and compares the digest of each step with the recorded digest.

    Parameters
    ----------
    session : Session or path-like
        The session.
    world : World
        A world with the bone and the tools of the session, before its first tick, on any backend.
    """
    if not isinstance(session, Session):
        session = read(session)
    recorded = session.ticks["digest"].tolist()
    path = session.path
    for number, _ in enumerate(world.steps(path)):
        if world.step_digest != recorded[number]:
            return Replay(number + 1, False, number, None)
    end = None
    if session.end_digest is not None and len(path) == len(session.ticks):
        end = world.bone.digest() == session.end_digest
    return Replay(len(path), end is not False, None, end)
