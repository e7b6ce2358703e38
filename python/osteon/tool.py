# SPDX-License-Identifier: Apache-2.0
"""Tools: cutting and noncutting voxels, in the memory of a backend.

    Backend.read_tool, Backend.voxelize, Backend.tool --> Tool --voxels, download, write--> array, ToolVolume, file

Threads: one thread at a time can use a backend and its tools; calls of other threads wait.
"""
from typing import TYPE_CHECKING, Any, Dict

import numpy as np

from osteon._c import Owned, call, ffi, lib
from osteon.mesh import ToolGeometry, ToolVolume

if TYPE_CHECKING:
    from osteon.backend import Backend

__all__ = ["Tool"]


class Tool(Owned):
    """A tool grid in the memory of a backend. Backend.read_tool, voxelize and tool make tools.

    Attributes
    ----------
    geometry : ToolGeometry
        The grid.
    report : dict
        After a voxelization: solid_voxels, cutting_voxels and leaking_rows.
    """

    def __init__(self, backend: "Backend", made: Any) -> None:
        super().__init__(made, lib.ost_tool_free, backend._lock, backend)
        backend._adopt(self)
        self.backend = backend
        self.meta: Dict[str, str] = {}
        self.report: Dict[str, Any] = {}
        self.source = ""  # this and `load` are for the header of a session
        self.load: Dict[str, str] = {}
        self.geometry = ToolGeometry._of_c(lib.ost_tool_geometry_get(made))

    def __repr__(self) -> str:
        x, y, z = self.geometry.dims
        return f"<osteon.Tool {x} x {y} x {z} voxels on {self.backend.spec}{' (closed)' if self.closed else ''}>"

    def download(self) -> ToolVolume:
        """Copies the tool to host memory."""
        memory = ffi.new("ost_tool_volume *")
        with self._lock.held:
            call(lib.ost_tool_download, self._c, memory)
        volume = ToolVolume._of_c(memory)
        volume.meta = dict(self.meta)
        return volume

    def voxels(self) -> np.ndarray:
        """Returns the classes of the voxels, uint8 [z, y, x]."""
        return self.download().voxels

    def digest(self) -> str:
        """Returns the digest of the tool (AR-DIG) as 64 hexadecimal digits."""
        out = ffi.new("ost_digest *")
        with self._lock.held:
            call(lib.ost_tool_digest, self._c, out)
        return bytes(ffi.buffer(out)).hex()

    def write(self, path: Any) -> None:
        """Writes the tool grid as a uint8 NRRD file."""
        self.download().write(path)
