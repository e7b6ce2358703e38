# SPDX-License-Identifier: Apache-2.0
"""The messages that osteon.openigtlink receives and sends, and the bone that its images show.

    data of a client -----> Reader: Received, each with its header and body
    operation.state() ----> Messages: TRANSFORM, SENSOR, STRING
    operation.changes() --> ChangedBone: removed voxels, box of the changes --> Messages: IMAGE

Messages converts poses, vectors and images from the bone's frame (LPS) to that of the clients, LPS or RAS.
"""
import json
import struct
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon.errors import RangeError
from osteon.event import Pose
from osteon.operation import LiveState, Operation

try:
    import pyigtl.messages as igtl
    _Message: Any = igtl.MessageBase
except ImportError:  # Server raises the error, so that the modules can be imported for their documentation
    igtl = None
    _Message = object

__all__ = ["HEADER", "NEWTON", "NEWTON_METRE", "Broken", "ChangedBone", "Messages", "Reader", "Received", "Refused",
           "SensorMessage", "igtl"]

HEADER = struct.Struct("> H 12s 20s Q Q Q")
MAX_BODY = 4096          # longest body of a message that the server uses, in bytes
MAX_SKIPPED = 1 << 30    # longest body of another message, which is skipped without being stored
_FLIP = np.diag([-1.0, -1.0, 1.0, 1.0])  # between LPS and RAS
_FLIP3 = (-1.0, -1.0, 1.0)


def _unit(*parts: Tuple[int, int]) -> int:
    """Packs (unit, exponent) pairs into the UNIT field of a SENSOR message, without a prefix."""
    packed = 0
    for number, (unit, exponent) in enumerate(parts):
        packed |= unit << (54 - 10 * number) | (exponent & 15) << (50 - 10 * number)
    return packed


NEWTON = _unit((0x0B, 1))
"""UNIT field of a force."""
NEWTON_METRE = _unit((0x0B, 1), (0x01, 1))
"""UNIT field of a torque."""


class SensorMessage(_Message):  # type: ignore[misc]
    """A SENSOR message, which pyigtl 0.3 does not contain.

    Parameters
    ----------
    values : sequence of float
        At most 255 values.
    unit : int
        The UNIT field: NEWTON or NEWTON_METRE.

    Notes
    -----
    A client of pyigtl receives these messages after

        pyigtl.messages.message_type_to_class_constructor["SENSOR"] = osteon.openigtlink.SensorMessage
    """

    def __init__(self, values: Iterable[float] = (), unit: int = 0, timestamp: Optional[float] = None,
                 device_name: Optional[str] = None) -> None:
        super().__init__(timestamp=timestamp, device_name=device_name)
        self._message_type = "SENSOR"
        self.values, self.unit = [float(v) for v in values], unit
        self._valid_message = True

    def _pack_content(self) -> bytes:
        return struct.pack(f"> B B Q {len(self.values)}d", len(self.values), 0, self.unit, *self.values)

    def _unpack_content(self, content: bytes) -> None:
        count, _, self.unit = struct.unpack_from("> B B Q", content)
        self.values = list(struct.unpack_from(f"> {count}d", content, 10))


class Broken(Exception):
    """The data of a client are not OpenIGTLink; the connection is closed."""


class Refused(Exception):
    """A message is refused; the connection remains open."""


class Received(NamedTuple):
    """A message of a client."""

    kind: str
    """Type of the message, such as TRANSFORM."""
    device: str
    """Device name."""
    size: int
    """Length of the body in bytes."""
    crc: int
    """CRC that the header states."""
    header: bytes
    """The header."""
    body: Optional[bytes]
    """The body, or None if the server does not use the message."""

    def unpack(self) -> Any:
        """Returns the message of pyigtl. Raises Refused if the CRC or the content is wrong."""
        if igtl.CRC64(self.body) != self.crc:
            raise Refused("the CRC is wrong; the message is ignored")
        message = igtl.MessageBase.create_message(self.kind)
        try:
            message.unpack(igtl.MessageBase.parse_header(self.header), self.body)
        except Exception as error:  # pylint: disable=broad-except  # pyigtl does not check lengths and encodings
            raise Refused(f"cannot be read: {error}") from None
        return message


class Reader:
    """Divides the data of a client into messages."""

    def __init__(self) -> None:
        self._held = bytearray()
        self._skipped = 0  # bytes of the present message that are still to be skipped

    def feed(self, data: bytes) -> Iterator[Received]:
        """Yields the messages that are complete after these data. Raises Broken if the data are not OpenIGTLink."""
        if self._skipped:
            part = min(self._skipped, len(data))
            self._skipped -= part
            data = data[part:]
        self._held += data
        start, held = 0, self._held
        while len(held) - start >= HEADER.size:
            version, kind, name, _, size, crc = HEADER.unpack_from(held, start)
            if not 1 <= version <= 3:
                raise Broken(f"not an OpenIGTLink message: header version {version}, expected 1 to 3")
            if size > MAX_SKIPPED:
                raise Broken(f"a message of {size} bytes; expected at most {MAX_SKIPPED}")
            type_name, device = (part.rstrip(b"\0 ").decode("ascii", "backslashreplace") for part in (kind, name))
            header = bytes(held[start:start + HEADER.size])
            if type_name not in ("TRANSFORM", "STRING") or size > MAX_BODY:
                start += HEADER.size
                available = min(size, len(held) - start)
                start += available
                self._skipped = size - available
                yield Received(type_name, device, size, crc, header, None)
                continue
            if len(held) - start < HEADER.size + size:
                break
            body = bytes(held[start + HEADER.size:start + HEADER.size + size])
            start += HEADER.size + size
            yield Received(type_name, device, size, crc, header, body)
        del self._held[:start]


class ChangedBone:
    """The densities of an operation's bone, without the voxels that were removed.

    `box` is the first voxel and the end of the changed part, in the order x, y, z, or None if nothing was removed.
    """

    def __init__(self, operation: Operation) -> None:
        bone = operation.world.bone
        self.operation = operation
        self.voxels = bone.voxels()
        self._active = np.zeros(bone.geometry.shape, bool)
        self.box: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self.take()

    def take(self) -> np.ndarray:
        """Takes the changed chunks, and returns the densities of the voxels removed since the last call."""
        found: List[np.ndarray] = []
        for (x, y, z), active in self.operation.changes():
            box = slice(z, z + active.shape[0]), slice(y, y + active.shape[1]), slice(x, x + active.shape[2])
            before = self._active[box]
            active = active[:before.shape[0], :before.shape[1], :before.shape[2]]
            gone = before & ~active
            if gone.any():
                densities = self.voxels[box]
                found.append(densities[gone])
                densities[gone] = 0
                lo = np.array([x, y, z])
                hi = lo + before.shape[::-1]
                self.box = (lo, hi) if self.box is None else (np.minimum(lo, self.box[0]), np.maximum(hi, self.box[1]))
            self._active[box] = active
        return np.concatenate(found) if found else np.empty(0, np.int16)


class Messages:
    """Packs the state of an operation into messages.

    Parameters
    ----------
    frame : {"ras", "lps"}
        Frame of the poses, forces, torques and images.
    epoch : float
        Time of the operation's start, in seconds since 1970.
    """

    def __init__(self, frame: str, epoch: float) -> None:
        self.frame, self.epoch = frame, epoch

    def time(self, state: LiveState) -> float:
        """Returns the time of a state, in seconds since 1970."""
        return self.epoch + state.t_ns * 1e-9

    def pose(self, matrix: np.ndarray) -> np.ndarray:
        """Converts the matrix of a pose between LPS and the frame of the messages."""
        return _FLIP @ matrix @ _FLIP if self.frame == "ras" else matrix

    def received_pose(self, matrix: Any) -> Tuple[np.ndarray, Pose]:
        """Returns the matrix of a received pose in LPS, and the pose. Raises Refused if the matrix is not a pose."""
        matrix = np.asarray(matrix, np.float64)
        if not np.isfinite(matrix).all():
            raise Refused("the matrix contains NaN or an infinite number; it is ignored")
        turn = matrix[:3, :3]
        if np.abs(turn.T @ turn - np.eye(3)).max() > 2e-3 or np.linalg.det(turn) < 0:
            raise Refused("the matrix is not a rotation and a translation; it is ignored")
        matrix = self.pose(matrix)
        try:
            return matrix, Pose.of_matrix(matrix)
        except RangeError as error:
            raise Refused(f"{error}; it is ignored") from None

    def vector(self, values: Iterable[float]) -> List[float]:
        """Converts a vector from LPS to the frame of the messages."""
        signs = _FLIP3 if self.frame == "ras" else (1.0, 1.0, 1.0)
        return [v * sign + 0.0 for v, sign in zip(values, signs)]  # the sum is never -0.0

    def state(self, state: LiveState) -> bytes:
        """Packs the pose of the tool, the hand force and torque, and the contact force."""
        at = self.time(state)
        packed: bytes = igtl.TransformMessage(self.pose(state.pose.matrix_mm()), timestamp=at,
                                              device_name="CutterToBone").pack()
        for name, values, unit in (("HandForce", self.vector(state.force_n), NEWTON),
                                   ("HandTorque", self.vector(state.torque_nm), NEWTON_METRE),
                                   ("ContactForce", [state.contact_n], NEWTON)):
            packed += SensorMessage(values, unit, timestamp=at, device_name=name).pack()
        return packed

    def text(self, name: str, state: LiveState, content: Dict[str, Any]) -> bytes:
        """Packs a JSON object as a STRING message."""
        packed: bytes = igtl.StringMessage(json.dumps(content), timestamp=self.time(state), device_name=name).pack()
        return packed

    def report(self, state: LiveState) -> bytes:
        """Packs the STRING message State."""
        return self.text("State", state, {
            "t_s": state.t_ns / 1e9, "hand_force_n": [round(v, 6) for v in self.vector(state.force_n)],
            "hand_torque_nm": [round(v, 9) for v in self.vector(state.torque_nm)],
            "contact_force_n": round(state.contact_n, 6), "rpm": state.rpm,
            "removed_voxels": state.removed_voxels, "fault": state.fault})

    def image(self, bone: ChangedBone, at: float) -> bytes:
        """Packs the changed part of the bone, with the time of the last change."""
        assert bone.box is not None
        lo, hi = bone.box
        geometry = bone.operation.geometry
        matrix = np.diag([s * 1e-9 for s in geometry.spacing_pm] + [1.0])
        matrix[:3, 3] = [(o + int(n) * s) * 1e-9 for o, n, s in zip(geometry.origin_pm, lo, geometry.spacing_pm)]
        if self.frame == "ras":
            matrix = _FLIP @ matrix
        part = np.ascontiguousarray(bone.voxels[lo[2]:hi[2], lo[1]:hi[1], lo[0]:hi[0]])
        packed: bytes = igtl.ImageMessage(part, matrix, self.frame, timestamp=at, device_name="Bone").pack()
        return packed
