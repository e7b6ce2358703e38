# SPDX-License-Identifier: Apache-2.0
"""Poses, and the removal events that they form.

    Pose, Pose ... --Event.of--> Event with one Map per pose --Bone.remove--> Report

A pose transforms the tool's frame to the bone's frame: p_bone = R(q) p_tool + t. It consists of integers: t in
picometres, and q = w, x, y, z in units of 2^-30.

Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
"""
from dataclasses import dataclass
from typing import Any, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from osteon._c import call, ffi, lib, text
from osteon.errors import UsageError
from osteon.grid import Geometry
from osteon.mesh import ToolGeometry
from osteon.units import Length, Vector, c_pm3, of_pm3, pm3

__all__ = ["DEFAULT_CLASSES", "DensityClass", "Event", "Map", "Pose", "Report"]


@dataclass(frozen=True)
class Pose:
    """A pose of a tool.

    Parameters
    ----------
    t_pm : (int, int, int)
        Translation x, y, z in picometres.
    q30 : (int, int, int, int)
        Quaternion w, x, y, z in units of 2^-30. Its length must be within 1e-3 of 1 where a pose is read.
    """

    t_pm: Vector = (0, 0, 0)
    q30: Tuple[int, int, int, int] = (int(lib.OST_Q30_ONE), 0, 0, 0)

    @classmethod
    def of(cls, t_mm: Iterable[Length], q: Iterable[float] = (1.0, 0.0, 0.0, 0.0)) -> "Pose":
        """Makes a pose from a position in millimetres and a quaternion w, x, y, z, which are quantised.

        Raises
        ------
        RangeError
            If a number is NaN or out of range, or if the length of q is not near 1.
        """
        out = ffi.new("ost_pose *")
        call(lib.ost_pose_from_doubles, [0.0, 0.0, 0.0], [float(v) for v in q], out)
        return cls(pm3(t_mm), (out.qw, out.qx, out.qy, out.qz))

    @classmethod
    def of_matrix(cls, matrix_mm: Any) -> "Pose":
        """Makes a pose from a 4 x 4 matrix that maps the tool's frame to the bone's frame, in millimetres."""
        matrix = np.asarray(matrix_mm, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise UsageError(f"matrix of shape {matrix.shape}: expected (4, 4)")
        q = ffi.new("double[4]")
        lib.ost_quaternion_of_columns(matrix[:3, :3].T.tolist(), q)
        return cls.of([float(v) for v in matrix[:3, 3]], list(q))

    def check(self) -> None:
        """Raises RangeError if a component is out of range."""
        call(lib.ost_pose_check, self._c())

    def sweep_to(self, end: "Pose", tool: ToolGeometry, bone_voxel_pm: int) -> List["Pose"]:
        """Returns the poses of a motion from this pose to `end`, between which no voxel is missed (AR-SWEEP).

        World.step computes them for each tick. This pose is not one of them; the last is `end`, apart from the sign of
        the quaternion.

        Raises
        ------
        RangeError
            If the motion is too long for an event, or rotates by more than 90 degrees.
        """
        first, last, count = self._c(), end._c(), ffi.new("int *")
        call(lib.ost_sweep_count, first, last, tool._c(), bone_voxel_pm, count)
        return [Pose._of_c(lib.ost_sweep_pose(first, last, k, count[0])) for k in range(1, count[0] + 1)]

    def matrix_mm(self) -> np.ndarray:
        """Returns the pose as a 4 x 4 matrix of floats, in millimetres. For pictures."""
        w, x, y, z = np.array(self.q30) / float(lib.OST_Q30_ONE)
        n = w * w + x * x + y * y + z * z
        out = np.eye(4)
        out[:3, :3] = np.array([[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                                [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
                                [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]) / n
        out[:3, 3] = np.array(self.t_pm) / float(lib.OST_PM_PER_MM)
        return out

    def _c(self) -> Any:
        w, x, y, z = self.q30
        return ffi.new("ost_pose *", {"t": c_pm3(self.t_pm), "qw": w, "qx": x, "qy": y, "qz": z})

    def _store(self, to: Any) -> None:
        """Copies the pose to an ost_pose."""
        to.t.x, to.t.y, to.t.z = self.t_pm
        to.qw, to.qx, to.qy, to.qz = self.q30

    @classmethod
    def _of_c(cls, pose: Any) -> "Pose":
        return cls(of_pm3(pose.t), (pose.qw, pose.qx, pose.qy, pose.qz))


def _wide(value: Any) -> int:
    """Returns an ost_int128 as int."""
    return (value.high << 64) + value.low


def _narrow(value: int) -> Any:
    """Returns an int as the members of an ost_int128."""
    if not -(1 << 127) <= value < 1 << 127:
        raise UsageError(f"{value}: does not fit 128 bits")
    return {"low": value & (1 << 64) - 1, "high": value >> 64}


class Map:
    """The integer map from bone voxels to tool coordinates at one pose (AR-MAP).

    Tool coordinates are in units of 2^-20 tool voxels. Indices b are axes of the bone, a axes of the tool (x, y, z).

    Attributes
    ----------
    origin : tuple of int
        origin[a] of the exact map (origin[a] + sum over b of i_b column[b][a]) / divisor.
    column : tuple of tuple of int
        column[b][a].
    divisor : int
        Integers of up to 126 bits.
    step : ndarray of int32, shape (3, 3)
        step[b, a] = column[b][a] / divisor, rounded half to even (AR-MAP-3).
    box : (lo, hi) or None
        At this pose, no voxel outside lo <= (x, y, z) < hi can be inside the tool's grid; None if this is not known.
    """

    FRACTION = int(lib.OST_MAP_FRACTION)
    BLOCK = int(lib.OST_MAP_BLOCK)

    def __init__(self, c_map: Any, box: Optional[Tuple[Vector, Vector]] = None) -> None:
        self._c = c_map  # an ost_map
        self.box = box
        self.origin = tuple(_wide(v) for v in c_map.origin)
        self.column = tuple(tuple(_wide(v) for v in row) for row in c_map.column)
        self.divisor = _wide(c_map.divisor)
        self.step = np.array([list(row) for row in c_map.step], np.int32)

    @classmethod
    def of(cls, pose: Pose, bone: Geometry, tool: ToolGeometry) -> "Map":
        """Computes the map of a pose."""
        out = ffi.new("ost_map *")
        call(lib.ost_map_make, pose._c(), bone._c(), tool._c(), out)
        return cls(out)

    @classmethod
    def of_integers(cls, origin: Sequence[int], column: Sequence[Sequence[int]], divisor: int,
                    step: Any) -> "Map":
        """Makes a map from its integers, such as those of another map."""
        out = ffi.new("ost_map *")
        for a in range(3):
            out.origin[a] = _narrow(origin[a])
            for b in range(3):
                out.column[b][a] = _narrow(column[b][a])
                out.step[b][a] = int(step[b][a])
        out.divisor = _narrow(divisor)
        return cls(out)

    def moved(self, by: Sequence[int]) -> "Map":
        """Returns a map whose origin[a] is greater by by[a]."""
        return Map.of_integers([self.origin[a] + by[a] for a in range(3)], self.column, self.divisor, self.step)

    @property
    def affine(self) -> np.ndarray:
        """The exact map in tool voxels as doubles, shape (3, 4): affine[a] @ (i, j, k, 1) is coordinate a."""
        unit = self.divisor << self.FRACTION
        return np.array([[self.column[b][a] / unit for b in range(3)] + [self.origin[a] / unit] for a in range(3)])

    def block_base(self, block: Sequence[int]) -> Optional[Vector]:
        """Returns the base of block (x, y, z) of 16^3 voxels, or None for a far block (AR-MAP-4, AR-MAP-5)."""
        base = ffi.new("int32_t[3]")
        near = lib.ost_map_block_base(self._c, c_pm3(block), base)
        return (base[0], base[1], base[2]) if near else None


class DensityClass(NamedTuple):
    """A class of densities: those from `border` to the border of the next class."""

    name: str
    border: int

    @staticmethod
    def parse(line: str) -> "Tuple[DensityClass, ...]":
        """Reads classes of the form "name:border,name:border,...", as the option --classes of the command does."""
        out = ffi.new("ost_density_classes *")
        call(lib.ost_density_classes_parse, line.encode(), out)
        return classes_of(out)


def classes_of(classes: Any) -> Tuple[DensityClass, ...]:
    """Returns an ost_density_classes as a tuple."""
    return tuple(DensityClass(text(classes.name[i]), classes.border[i]) for i in range(classes.count))


DEFAULT_CLASSES: Tuple[DensityClass, ...] = classes_of(lib.ost_density_classes_default())


def classes_to(classes: Iterable[Tuple[str, int]]) -> Any:
    """Returns an ost_density_classes."""
    out = ffi.new("ost_density_classes *")
    rows = list(classes)
    if len(rows) > lib.OST_CLASS_MAX:
        raise UsageError(f"{len(rows)} density classes: expected 1 to {lib.OST_CLASS_MAX}")
    out.count = len(rows)
    for i, (name, border) in enumerate(rows):
        out.name[i], out.border[i] = name.encode(), border
    call(lib.ost_density_classes_check, out)
    return out


@dataclass(frozen=True)
class Event:
    """A removal event: the maps of its poses, and the density classes of the report.

    Attributes
    ----------
    maps : list of Map
        One map per pose.
    bone, tool : Geometry, ToolGeometry
        The grids for which the maps were computed.
    classes : tuple of DensityClass
        A voxel belongs to the last class whose border is at most its density, otherwise to class 0.
    """

    maps: List[Map]
    bone: Geometry
    tool: ToolGeometry
    classes: Tuple[DensityClass, ...] = DEFAULT_CLASSES

    @classmethod
    def of(cls, poses: Iterable[Pose], bone: Geometry, tool: ToolGeometry,
           classes: Iterable[Tuple[str, int]] = DEFAULT_CLASSES) -> "Event":
        """Makes an event from poses, without a sweep between them."""
        return cls([Map.of(pose, bone, tool) for pose in poses], bone, tool,
                   tuple(DensityClass(*c) for c in classes))

    def _c(self) -> Tuple[Any, Any]:
        """Returns an ost_removal_event whose boxes contain the complete bone, and the memory to which it refers."""
        maps = ffi.new("ost_map[]", len(self.maps))
        boxes = ffi.new("ost_voxel_box[]", len(self.maps))
        for i, each in enumerate(self.maps):
            maps[i] = each._c[0]
            boxes[i].hi = list(self.bone.dims)
        classes = classes_to(self.classes)
        return ffi.new("ost_removal_event *", {"pose_count": len(self.maps), "maps": maps, "boxes": boxes,
                                               "classes": classes}), (maps, boxes, classes)


CHUNK = np.dtype({"names": ["chunk", "voxels", "density"],
                  "formats": [np.int32, (np.uint32, lib.OST_CLASS_MAX), (np.int64, lib.OST_CLASS_MAX)],
                  "offsets": [ffi.offsetof("ost_chunk_report", name) for name in ("chunk", "voxels", "density")],
                  "itemsize": ffi.sizeof("ost_chunk_report")})


class Report(NamedTuple):
    """The report of an event (AR-REM-6).

    Attributes
    ----------
    removed : int
        Number of removed voxels; of hit voxels for a collision.
    touched : int
        Number of voxels that only noncutting tool voxels cover.
    by_class, density : tuple of int
        For each density class, the number of removed voxels and the sum of their densities.
    chunks : ndarray
        Structured array with the fields chunk, voxels and density, in ascending order of chunks.
    """

    removed: int
    touched: int
    by_class: Tuple[int, ...]
    density: Tuple[int, ...]
    chunks: np.ndarray

    @classmethod
    def of(cls, report: Any, classes: int) -> "Report":
        """Copies an ost_removal_report."""
        chunks = np.frombuffer(bytes(ffi.buffer(report.chunks, report.count * CHUNK.itemsize)) if report.count else b"",
                               CHUNK)
        return cls(report.total_voxels, report.touched_voxels, tuple(report.voxels[0:classes]),
                   tuple(report.density[0:classes]), chunks)

    def same(self, other: "Report", touched: bool = True) -> bool:
        """Returns True if two reports are equal. `touched` selects whether the touched voxels are compared."""
        n = len(self.by_class)
        return (self.removed == other.removed and (not touched or self.touched == other.touched)
                and self.by_class == other.by_class and self.density == other.density
                and np.array_equal(self.chunks["chunk"], other.chunks["chunk"])
                and np.array_equal(self.chunks["voxels"][:, :n], other.chunks["voxels"][:, :n])
                and np.array_equal(self.chunks["density"][:, :n], other.chunks["density"][:, :n]))
