# SPDX-License-Identifier: Apache-2.0
"""Sessions as MCAP files (https://mcap.dev/spec) with JSON messages.

The schemas of poses and notes are those of Foxglove (https://docs.foxglove.dev/docs/sdk/schemas), which shows them
without a converter. docs/guide/python.md lists the topics.
"""
import json
from typing import Any, Dict

from osteon._c import lib, text
from osteon._files import complete
from osteon.errors import UnavailableError
from osteon.session import Session, has_force

_NUMBER, _INTEGER, _TEXT, _TRUTH = ({"type": name} for name in ("number", "integer", "string", "boolean"))


def _object(**properties: Any) -> Dict[str, Any]:
    return {"type": "object", "properties": properties, "required": list(properties)}


_TIME = _object(sec=_INTEGER, nsec=_INTEGER)
_XYZ = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)

TOPICS = {
    "/tool/pose": ("foxglove.PoseInFrame", _object(
        timestamp=_TIME, frame_id=_TEXT,
        pose=_object(position=_XYZ, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)))),
    "/device/wrench": ("osteon.Wrench", _object(timestamp=_TIME, frame_id=_TEXT, force=_XYZ, torque=_XYZ)),
    "/tick": ("osteon.Tick", _object(
        number=_INTEGER, tool=_INTEGER, rpm=_INTEGER, lifted=_TRUTH, removal=_TRUTH, boxes_meet=_TRUTH, poses=_INTEGER,
        removed=_INTEGER, touched=_INTEGER, digest=_TEXT, buttons=_INTEGER, fault=_INTEGER, wake_ns=_INTEGER,
        exec_ns=_INTEGER, missed=_INTEGER)),
    "/note": ("foxglove.Log", _object(timestamp=_TIME, level=_INTEGER, message=_TEXT, name=_TEXT, file=_TEXT,
                                      line=_INTEGER)),
}
"""The name and the JSON schema of the messages of each topic."""

_INFO = 2  # the level of foxglove.Log


def _xyz(values: Any, unit: float) -> Dict[str, float]:
    return dict(zip("xyz", (value / unit for value in values.tolist())))


def _tick(row: Any) -> Dict[str, Any]:
    names = ("number", "poses", "removed", "touched", "buttons", "fault", "wake_ns", "exec_ns", "missed")
    found: Dict[str, Any] = {name: int(row[name]) for name in names}
    found.update(tool=int(row["tick"]["tool"]), rpm=int(row["tick"]["rpm"]), lifted=bool(row["tick"]["lifted"]),
                 removal=bool(row["flags"] & lib.OST_TICK_REMOVAL), boxes_meet=bool(row["flags"] & lib.OST_TICK_MET),
                 digest=f"{int(row['digest']):016x}")
    return found


def write(session: Session, path: Any) -> None:
    """Implements Session.write_mcap."""
    try:
        from mcap.writer import Writer  # pylint: disable=import-outside-toplevel
    except ImportError:
        raise UnavailableError("mcap is not installed: pip install osteon[mcap]") from None
    ticks = session.ticks
    earliest = min([0] + ticks["tick"]["t_ns"].tolist() + [t_ns for t_ns, _ in session.notes])
    with complete(path) as temporary, open(temporary, "wb") as file:
        writer = Writer(file)
        writer.start(library="osteon " + text(lib.ost_version()))
        channels = {topic: writer.register_channel(topic, "json", writer.register_schema(
            name, "jsonschema", json.dumps(schema).encode())) for topic, (name, schema) in TOPICS.items()}
        writer.add_metadata("osteon session", {**session.header, "mcap.time_shift_ns": str(-earliest)})

        def put(topic: str, t_ns: int, message: Dict[str, Any]) -> None:
            time = t_ns - earliest  # MCAP has no times before 0
            if topic != "/tick":
                message = {"timestamp": {"sec": time // 10**9, "nsec": time % 10**9}, **message}
            writer.add_message(channels[topic], log_time=time, publish_time=time, data=json.dumps(message).encode())

        for t_ns, line in session.notes:
            put("/note", t_ns, {"level": _INFO, "message": line, "name": "osteon", "file": "", "line": 0})
        for row, force in zip(ticks, has_force(ticks)):
            t_ns, (w, *xyz) = int(row["tick"]["t_ns"]), (row["tick"]["q30"] / float(1 << 30)).tolist()
            put("/tool/pose", t_ns, {"frame_id": "bone", "pose": {
                "position": _xyz(row["tick"]["t_pm"], 1e12), "orientation": {**dict(zip("xyz", xyz)), "w": w}}})
            put("/tick", t_ns, _tick(row))
            if force:
                put("/device/wrench", t_ns, {"frame_id": "bone", "force": _xyz(row["force_un"], 1e6),
                                             "torque": _xyz(row["torque_unm"], 1e6)})
        writer.finish()
