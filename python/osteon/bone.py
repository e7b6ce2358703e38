# SPDX-License-Identifier: Apache-2.0
"""Bones: active voxels with densities, in the memory of a backend.

    Backend.read_bone, Backend.bone --> Bone --voxels, download, write--> array, Volume, file
                                          '---remove, collide--> Report; World moves tools through it

Threads: one thread at a time can use a backend and its bones; calls of other threads wait.
"""
from typing import TYPE_CHECKING, Any, Dict, Iterable, NamedTuple, Optional, Tuple, Union

import numpy as np

from osteon._c import Owned, call, call_with_progress, ffi, lib, meta_to, path_bytes, progress_handle
from osteon.errors import UsageError
from osteon.event import Event, Pose, Report
from osteon.grid import Geometry, Progress, Volume, as_voxels, pointer
from osteon.units import Vector

if TYPE_CHECKING:
    from osteon.backend import Backend
    from osteon.tool import Tool
    from osteon.world import Glenoid

__all__ = ["Bone", "BoneInfo", "volume_of"]


class BoneInfo(NamedTuple):
    """Properties and counts of a bone (ost_bone_info in osteon/backend.h)."""

    geometry: Geometry
    chunk_size: int
    threshold: int
    chunk_dims: Vector
    chunks: int
    active_chunks: int
    active_voxels: int
    chunk_bytes: int
    resident_bytes: int


class Bone(Owned):
    """A bone in the memory of a backend. Backend.read_bone and Backend.bone make bones.

    Attributes
    ----------
    backend : Backend
        The owner of the voxels.
    meta : dict
        Facts of the file, for example the position of the glenoid; write() stores them again.
    imported : dict
        Report of the import.
    """

    def __init__(self, backend: "Backend", made: Any) -> None:
        super().__init__(made, lib.ost_bone_free, backend._lock, backend)
        backend._adopt(self)
        self.backend = backend
        self.meta: Dict[str, str] = {}
        self.imported: Dict[str, Any] = {}
        self.source = ""  # this and `load` are for the header of a session
        self.load: Dict[str, str] = {}
        info = self.info
        self.geometry, self.chunk_size, self.threshold = info.geometry, info.chunk_size, info.threshold
        self.chunk_dims = info.chunk_dims

    def __repr__(self) -> str:
        x, y, z = self.geometry.dims
        return f"<osteon.Bone {x} x {y} x {z} voxels on {self.backend.spec}{' (closed)' if self.closed else ''}>"

    @property
    def info(self) -> BoneInfo:
        """Properties and counts."""
        out = ffi.new("ost_bone_info *")
        with self._lock.held:
            call(lib.ost_bone_info_get, self._c, out)
        return BoneInfo(Geometry._of_c(out.geometry), out.chunk_size, out.threshold,
                        (out.chunk_dims.x, out.chunk_dims.y, out.chunk_dims.z), out.chunks, out.active_chunks,
                        out.active_voxels, out.chunk_bytes, out.resident_bytes)

    def voxels(self, z0: int = 0, count: Optional[int] = None, out: Optional[np.ndarray] = None) -> np.ndarray:
        """Copies slices z0 to z0 + count from the backend to an int16 array [z, y, x]. Inactive voxels are 0.

        Parameters
        ----------
        out : ndarray, optional
            A C-contiguous int16 array to fill, so that no memory is allocated.
        """
        shape = (self.geometry.dims[2] - z0 if count is None else count,) + self.geometry.shape[1:]
        if out is None:
            out = np.empty(shape, np.int16)
        elif out.shape != shape or out.dtype != np.int16 or not out.flags.c_contiguous:
            raise UsageError(f"out: expected a C-contiguous int16 array of shape {shape}")
        with self._lock.held:
            call(lib.ost_bone_download, self._c, z0, shape[0], pointer(out, "int16_t *", writable=True))
        return out

    def download(self) -> Volume:
        """Copies the bone to a volume with its geometry and meta."""
        return Volume(self.voxels(), self.geometry, dict(self.meta))

    def upload(self, voxels: Any, z0: int = 0) -> None:
        """Copies slices from an array [z, y, x] to the bone. Densities below the threshold are stored as 0."""
        array = as_voxels(voxels)
        if array.shape[1:] != self.geometry.shape[1:]:
            raise UsageError(f"slices of shape {array.shape[1:]}: expected {self.geometry.shape[1:]}")
        with self._lock.held:
            call(lib.ost_bone_upload, self._c, z0, array.shape[0], pointer(array, "int16_t *"))

    def copy(self, backend: Optional["Backend"] = None) -> "Bone":
        """Returns a copy of the bone, on the same backend or on another one."""
        backend = backend or self.backend
        out = ffi.new("ost_bone **")
        with backend._lock.held:
            call(lib.ost_bone_create, backend._c, self.geometry._c(), self.chunk_size, self.threshold, out)
        bone = Bone(backend, out[0])
        bone.upload(self.voxels())
        bone.meta = dict(self.meta)
        return bone

    def sample(self, points: Any) -> np.ndarray:
        """Reads the densities of single voxels. points has the indices x, y, z in rows, shape (n, 3)."""
        at = [np.ascontiguousarray(column, np.int32) for column in np.asarray(points).reshape(-1, 3).T]
        out = np.empty(len(at[0]), np.int16)
        columns = ffi.new("int32_t *[3]", [pointer(column, "int32_t *") for column in at])
        with self._lock.held:
            call(lib.ost_bone_sample, self._c, len(out), columns, pointer(out, "int16_t *"))
        return out

    def occupancy(self) -> np.ndarray:
        """Returns which voxels are active, bool [z, y, x]. The backend copies a bit per voxel instead of 16.

        Raises
        ------
        UnavailableError
            If the backend can read only slices, as that of a FunctionBackend.
        """
        n, dims = self.chunk_size, self.chunk_dims
        chunks = np.arange(dims[0] * dims[1] * dims[2], dtype=np.int32)
        words = np.empty((len(chunks), n ** 3 // 32), "<u4")
        with self._lock.held:
            call(lib.ost_bone_occupancy, self._c, len(chunks), pointer(chunks, "int32_t *"),
                 pointer(words, "uint32_t *", writable=True))
        bits = np.unpackbits(words.view(np.uint8), axis=1, bitorder="little").view(np.bool_)
        grid = bits.reshape(dims[2], dims[1], dims[0], n, n, n).transpose(0, 3, 1, 4, 2, 5)
        z, y, x = self.geometry.shape
        return np.ascontiguousarray(grid.reshape(dims[2] * n, dims[1] * n, dims[0] * n)[:z, :y, :x])

    def digest(self) -> str:
        """Returns the digest of the bone (AR-DIG) as 64 hexadecimal digits."""
        out = ffi.new("ost_digest *")
        with self._lock.held:
            call(lib.ost_bone_digest, self._c, ffi.NULL, out)
        return bytes(ffi.buffer(out)).hex()

    def leaves(self) -> np.ndarray:
        """Returns the digests of the leaves of 32^3 voxels, uint8 [z, y, x, 32], which locate a difference."""
        x, y, z = (-(-n // lib.OST_LEAF) for n in self.geometry.dims)
        out = np.empty((z, y, x, lib.OST_DIGEST_BYTES), np.uint8)
        with self._lock.held:
            call(lib.ost_bone_digest, self._c, pointer(out, "ost_digest *"), ffi.new("ost_digest *"))
        return out

    def write(self, path: Any, *, meta: Optional[Dict[str, str]] = None, compress: bool = False,
              progress: Optional[Progress] = None) -> None:
        """Writes the bone with its facts, as `osteon ream --out` does: .nrrd, .nii, .nii.gz, .mha or .txt.

        Parameters
        ----------
        meta : dict, optional
            Facts for the header; the default is Bone.meta.
        """
        options = ffi.new("ost_write_options *", {"compress": compress})
        facts = ffi.new("ost_meta *")
        meta_to(facts, self.meta if meta is None else meta)
        running = progress_handle(progress, options)
        with self._lock.held:
            call_with_progress(running, lib.ost_bone_write, path_bytes(path), self._c, facts, options)

    def remove(self, tool: "Tool", event: Union[Event, Pose, Iterable[Pose]]) -> Report:
        """Removes the voxels that the tool covers in an event (AR-REM), without a world.

        Parameters
        ----------
        event : Event, Pose or poses
            Poses of the tool. World.step computes the poses of a motion.
        """
        return self._event(lib.ost_bone_remove, tool, event)

    def collide(self, tool: "Tool", event: Union[Event, Pose, Iterable[Pose]]) -> Report:
        """Returns the report of remove() without changing the bone."""
        return self._event(lib.ost_bone_collide, tool, event)

    def _event(self, function: Any, tool: "Tool", event: Any) -> Report:
        if not isinstance(event, Event):
            event = Event.of([event] if isinstance(event, Pose) else event, self.geometry, tool.geometry)
        if event.bone != self.geometry or event.tool != tool.geometry:
            raise UsageError("the maps of the event were computed for another bone or tool")
        report = ffi.gc(ffi.new("ost_removal_report *"), lib.ost_removal_report_free)
        c_event, keep = event._c()
        with self._lock.held:
            call(function, self._c, tool._c, c_event, report)
        del keep
        return Report.of(report, len(event.classes))

    def overlap(self, tool: "Tool", pose: Pose) -> int:
        """Counts the active voxels that a tool covers at a pose, with cutting or noncutting voxels."""
        out = ffi.new("int64_t *")
        with self._lock.held:
            call(lib.ost_bone_overlap, self._c, tool._c, pose._c(), out)
        return int(out[0])

    def in_front(self, glenoid: "Glenoid", radius_mm: float = 0, reach_mm: float = 0) -> int:
        """Counts the active voxels in front of the face of a glenoid, as the check of a plan does. A healthy rim has
        no such voxels (ost_bone_in_front in osteon/sim.h).

        Parameters
        ----------
        radius_mm, reach_mm : float
            Largest distances from the axis, and from the centre of the face along the axis; 0 if there is no limit.
        """
        out = ffi.new("int64_t *")
        with self._lock.held:
            call(lib.ost_bone_in_front, self._c, glenoid._c(), radius_mm, reach_mm, out)
        return int(out[0])

    def along_axis(self, glenoid: "Glenoid") -> Tuple[float, float]:
        """Returns the percentages of bone in two cylinders of 4 mm radius around the axis of a glenoid: from 1 to 11
        mm inward of the centre of the face, and as far outward. Little bone inward means a wrong axis."""
        inward, outward = ffi.new("double *"), ffi.new("double *")
        with self._lock.held:
            call(lib.ost_bone_along_axis, self._c, glenoid._c(), inward, outward)
        return float(inward[0]), float(outward[0])


def volume_of(data: Any, geometry: Optional[Geometry] = None) -> Volume:
    """Returns a Volume for a Volume, a Bone, an image of SimpleITK or nibabel, or an array with a geometry."""
    if isinstance(data, Volume):
        return data
    if isinstance(data, Bone):
        return data.download()
    if geometry is not None:
        return Volume(data, geometry)
    if hasattr(data, "GetDirection"):
        return Volume.from_sitk(data)
    if hasattr(data, "affine"):
        return Volume.from_nibabel(data)
    raise UsageError(f"{type(data).__name__}: expected a Volume, a Bone, an image of SimpleITK or nibabel, or an array "
                     "with geometry=Geometry.of(array.shape, spacing_mm, origin_mm)")
