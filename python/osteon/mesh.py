# SPDX-License-Identifier: Apache-2.0
"""Meshes and tool grids in host memory.

    file, trimesh, arrays --> Mesh (picometres) --Backend.voxelize--> Tool --Tool.download--> ToolVolume

Threads: these objects may be used by one thread at a time, or read by several.
"""
from dataclasses import dataclass, field
from typing import Any, Dict, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib, meta_of, meta_to, path_bytes
from osteon.errors import InputError, RangeError, UnavailableError, UsageError
from osteon.grid import array_of, as_array, as_voxels, pointer, report_of
from osteon.units import Length, Vector, c_pm3, of_pm3, pm

__all__ = ["Mesh", "ToolGeometry", "ToolVolume"]

_UNITS = {"auto": lib.OST_UNIT_AUTO, "mm": lib.OST_UNIT_MM, "cm": lib.OST_UNIT_CM, "m": lib.OST_UNIT_M,
          "inch": lib.OST_UNIT_INCH, "um": lib.OST_UNIT_UM}


@dataclass(frozen=True)
class ToolGeometry:
    """The grid of a tool. The centre of voxel (i, j, k) is corner + (i + 1/2, j + 1/2, k + 1/2) * voxel.

    Parameters
    ----------
    dims : (int, int, int)
        Numbers of voxels along x, y and z.
    voxel_pm : int
        Edge length of a voxel in picometres.
    corner_pm : (int, int, int)
        Corner of the grid in the tool's frame, in picometres.
    """

    dims: Vector
    voxel_pm: int
    corner_pm: Vector

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Shape (z, y, x) of an array of the voxels."""
        return self.dims[2], self.dims[1], self.dims[0]

    def check(self) -> None:
        """Raises RangeError if a limit of AR-TOOL-1 is exceeded."""
        call(lib.ost_tool_geometry_check, self._c())

    def _c(self) -> Any:
        return ffi.new("ost_tool_geometry *", {"dims": c_pm3(self.dims), "voxel": self.voxel_pm,
                                               "corner": c_pm3(self.corner_pm)})

    @classmethod
    def _of_c(cls, g: Any) -> "ToolGeometry":
        return cls((g.dims.x, g.dims.y, g.dims.z), g.voxel, of_pm3(g.corner))


@dataclass
class ToolVolume:
    """A tool grid in host memory: 0 empty, 1 cutting, 2 touches but removes nothing.

    Parameters
    ----------
    voxels : array_like
        Classes, [z, y, x]. A uint8 array that is C-contiguous is not copied.
    geometry : ToolGeometry
        The grid.
    meta : dict, optional
        Facts that are stored in the header of a file.
    """

    voxels: np.ndarray
    geometry: ToolGeometry
    meta: Dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.voxels = as_voxels(self.voxels, self.geometry.shape, np.uint8)

    @classmethod
    def read(cls, path: Any) -> "ToolVolume":
        """Reads a tool grid that `osteon voxelize` or write() wrote (uint8 NRRD)."""
        memory = ffi.new("ost_tool_volume *")
        call(lib.ost_tool_volume_read, path_bytes(path), memory)
        return cls._of_c(memory)

    def write(self, path: Any) -> None:
        """Writes the tool grid as a uint8 NRRD file. The file appears only when it is complete."""
        call(lib.ost_tool_volume_write, path_bytes(path), self._c())

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        if dtype is not None and np.dtype(dtype) != self.voxels.dtype:
            return self.voxels.astype(dtype)
        return self.voxels.copy() if copy else self.voxels

    def _c(self) -> Any:
        volume = ffi.new("ost_tool_volume *")
        volume.geometry = self.geometry._c()[0]
        meta_to(ffi.addressof(volume, "meta"), self.meta)
        self.voxels = as_voxels(self.voxels, self.geometry.shape, np.uint8)
        volume.voxels = pointer(self.voxels, "uint8_t *")
        return volume

    @classmethod
    def _of_c(cls, memory: Any) -> "ToolVolume":
        geometry = ToolGeometry._of_c(memory.geometry)
        facts = meta_of(memory.meta)
        count = lib.ost_dims_count(memory.geometry.dims)
        voxels = ffi.gc(memory.voxels, lambda _: lib.ost_tool_volume_free(memory), count)
        return cls(array_of(voxels, count, np.uint8, geometry.shape), geometry, facts)


@dataclass
class Mesh:
    """A triangle mesh in the frame of its file.

    Parameters
    ----------
    vertices_pm : array_like of int64, shape (n, 3)
        Vertices x, y, z in picometres.
    triangles : array_like of uint32, shape (m, 3)
        Vertex indices of each triangle, counter-clockwise as seen from outside.
    """

    vertices_pm: np.ndarray
    triangles: np.ndarray
    report: Dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, dtype in (("vertices_pm", np.int64), ("triangles", np.uint32)):
            array = as_array(getattr(self, name))
            if array.ndim != 2 or array.shape[1] != 3:
                raise UsageError(f"{name} of shape {array.shape}: expected (n, 3)")
            if array.dtype != dtype and (array.dtype.kind not in "iu" or
                                         (array.size and (array.min() < 0 and dtype is np.uint32))):
                raise UsageError(f"{name} of type {array.dtype}: expected {np.dtype(dtype)}")
            setattr(self, name, np.ascontiguousarray(array, dtype=dtype))
        if self.triangles.size and self.triangles.max() >= len(self.vertices_pm):
            raise UsageError(f"vertex index {self.triangles.max()} of {len(self.vertices_pm)} vertices")

    @classmethod
    def read(cls, path: Any, unit: str = "auto") -> "Mesh":
        """Reads a mesh file (STL, OBJ, PLY, 3DS ...).

        Parameters
        ----------
        unit : {"auto", "mm", "cm", "m", "inch", "um"}
            Unit of the coordinates. "auto" means millimetres, and the size is checked for plausibility.
        """
        if unit not in _UNITS:
            raise UsageError(f"unit {unit!r}: expected one of {', '.join(_UNITS)}")
        memory, report = ffi.new("ost_mesh *"), ffi.new("ost_mesh_report *")
        call(lib.ost_mesh_read, path_bytes(path), _UNITS[unit], memory, report)
        mesh = cls._of_c(memory)
        mesh.report = report_of(report)
        return mesh

    @classmethod
    def of_mm(cls, vertices_mm: Any, triangles: Any) -> "Mesh":
        """Makes a mesh from vertices in millimetres. The binary value of each float is rounded (AR-MESH-2)."""
        vertices = np.asarray(vertices_mm, dtype=np.float64)
        out = ffi.new("ost_pm *")
        exact = np.empty(vertices.shape, np.int64)
        for place, value in enumerate(vertices.ravel().tolist()):
            if not lib.ost_pm_from_binary(value, out):
                raise RangeError(f"vertex coordinate {value} mm: must be within +-8000 mm")
            exact.flat[place] = out[0]
        return cls(exact, triangles)

    @classmethod
    def from_trimesh(cls, mesh: Any) -> "Mesh":
        """Makes a mesh from a trimesh.Trimesh, whose coordinates are millimetres."""
        if not hasattr(mesh, "vertices") or not hasattr(mesh, "faces"):
            raise UsageError(f"{type(mesh).__name__}: expected a trimesh.Trimesh; a scene has several meshes")
        return cls.of_mm(mesh.vertices, np.asarray(mesh.faces))

    def to_trimesh(self) -> Any:
        """Returns a trimesh.Trimesh in millimetres."""
        try:
            import trimesh  # pylint: disable=import-outside-toplevel
        except ImportError:
            raise UnavailableError("trimesh is not installed: pip install trimesh") from None
        return trimesh.Trimesh(self.vertices_pm / float(lib.OST_PM_PER_MM), self.triangles.astype(np.int64),
                               process=False)

    def write_stl(self, path: Any) -> None:
        """Writes a binary STL file in millimetres."""
        call(lib.ost_mesh_write_stl, path_bytes(path), self._c())

    @property
    def volume_mm3(self) -> float:
        """Signed volume in mm^3, positive for outward faces. For reports."""
        return float(lib.ost_mesh_volume_mm3(self._c()))

    @property
    def open_edges(self) -> int:
        """Number of open edges; 0 for a closed surface."""
        out = ffi.new("size_t *")
        call(lib.ost_mesh_open_edges, self._c(), out)
        return int(out[0])

    @property
    def bounds_pm(self) -> Tuple[Vector, Vector]:
        """Lowest and highest coordinates of the vertices that triangles use, in picometres."""
        low, high = ffi.new("ost_pm3 *"), ffi.new("ost_pm3 *")
        call(lib.ost_mesh_bounds, self._c(), low, high)
        return of_pm3(low), of_pm3(high)

    def _c(self) -> Any:
        """Returns an ost_mesh that refers to the arrays. It is valid while this object is not changed."""
        mesh = ffi.new("ost_mesh *")
        mesh.vertex_count, mesh.triangle_count = len(self.vertices_pm), len(self.triangles)
        mesh.vertices = pointer(self.vertices_pm, "ost_pm3 *")
        mesh.triangles = ffi.cast("uint32_t(*)[3]", ffi.from_buffer(self.triangles))
        return mesh

    @classmethod
    def _of_c(cls, memory: Any) -> "Mesh":
        """Copies an ost_mesh and frees it."""
        try:
            vertices = array_of(memory.vertices, 3 * memory.vertex_count, np.int64, (-1, 3)).copy()
            triangles = array_of(memory.triangles, 3 * memory.triangle_count, np.uint32, (-1, 3)).copy()
        finally:
            lib.ost_mesh_free(memory)
        return cls(vertices, triangles)


def mesh_of(tool: Any, unit: str = "auto") -> Mesh:
    """Returns a mesh for a Mesh, the name of a file, or a trimesh.Trimesh."""
    if isinstance(tool, Mesh):
        return tool
    if hasattr(tool, "vertices") and hasattr(tool, "faces"):
        return Mesh.from_trimesh(tool)
    return Mesh.read(tool, unit)


def grid_of(meshes: Any, voxel_mm: Length) -> ToolGeometry:
    """Returns the grid of a tool, computed from the bounds of its meshes (AR-TOOL-2)."""
    bounds = [mesh.bounds_pm for mesh in meshes]
    low = tuple(min(b[0][a] for b in bounds) for a in range(3))
    high = tuple(max(b[1][a] for b in bounds) for a in range(3))
    out = ffi.new("ost_tool_geometry *")
    call(lib.ost_tool_geometry_from_bounds, c_pm3(low), c_pm3(high), pm(voxel_mm), out)
    return ToolGeometry._of_c(out)


class Snapped:
    """A snapped mesh (AR-MESH-3): integer vertices in units of voxel / 2^fraction_bits."""

    def __init__(self, mesh: Mesh, grid: ToolGeometry) -> None:
        memory = ffi.new("ost_snapped_mesh *")
        call(lib.ost_mesh_snap, mesh._c(), grid._c(), memory)
        self.c = ffi.gc(memory, lib.ost_snapped_mesh_free)
        self.keep: Any = None

    @classmethod
    def of(cls, grid: ToolGeometry, fraction_bits: int, vertices: np.ndarray, triangles: np.ndarray) -> "Snapped":
        """Makes a snapped mesh from integers that were snapped before, such as those of an exported case."""
        snapped = cls.__new__(cls)
        snapped.c = ffi.new("ost_snapped_mesh *")
        snapped.keep = np.ascontiguousarray(vertices, np.int32), np.ascontiguousarray(triangles, np.uint32)
        if snapped.keep[1].size and snapped.keep[1].max() >= len(vertices):
            raise InputError(f"vertex index {snapped.keep[1].max()} of {len(vertices)} vertices")
        snapped.c.grid = grid._c()[0]
        snapped.c.fraction_bits = fraction_bits
        snapped.c.vertex_count, snapped.c.triangle_count = len(vertices), len(triangles)
        snapped.c.vertices = ffi.cast("int32_t(*)[3]", ffi.from_buffer(snapped.keep[0]))
        snapped.c.triangles = ffi.cast("uint32_t(*)[3]", ffi.from_buffer(snapped.keep[1]))
        return snapped

    @property
    def digest(self) -> str:
        """Digest of the snapped mesh (AR-DIG-7)."""
        out = ffi.new("ost_digest *")
        call(lib.ost_snapped_mesh_digest, self.c, out)
        return bytes(ffi.buffer(out)).hex()
