# SPDX-License-Identifier: Apache-2.0
"""Digests (AR-DIG): a SHA-256 that identifies a grid on every backend, with every chunk size, in every file format.

Threads: the functions share no state.
"""
from typing import Any

from osteon._c import call, ffi, lib
from osteon.bone import Bone
from osteon.errors import UsageError
from osteon.grid import Volume, pointer
from osteon.mesh import ToolVolume
from osteon.tool import Tool

__all__ = ["digest", "sha256"]


def digest(grid: Any, kind: str = "cubic") -> str:
    """Returns the digest of a grid as 64 hexadecimal digits, as the `osteon` command prints it.

    Parameters
    ----------
    grid : Bone, Tool, Volume or ToolVolume
        The grid. A Bone has another digest than a Volume with the same voxels, because the threshold is included.
    kind : {"rect", "cubic"}
        For a Volume: the stage of the import to which it belongs.
    """
    out = ffi.new("ost_digest *")
    if isinstance(grid, (Bone, Tool)):
        return grid.digest()
    if isinstance(grid, ToolVolume):
        g = grid.geometry
        geometry = ffi.new("ost_geometry *", {"dims": g.dims, "spacing": (g.voxel_pm,) * 3, "origin": g.corner_pm})
        call(lib.ost_digest_dense, lib.OST_GRID_TOOL, geometry, pointer(grid.voxels, "void *"), 1, out)
    elif isinstance(grid, Volume):
        if kind not in ("rect", "cubic"):
            raise UsageError(f"kind {kind!r}: expected rect or cubic")
        call(lib.ost_digest_volume, lib.OST_GRID_RECT if kind == "rect" else lib.OST_GRID_CUBIC, grid._c(), out)
    else:
        raise UsageError(f"{type(grid).__name__}: expected a Bone, a Tool, a Volume or a ToolVolume")
    return bytes(ffi.buffer(out)).hex()


def sha256(data: Any) -> str:
    """Returns the SHA-256 of bytes or of the memory of a C-contiguous array, as 64 hexadecimal digits."""
    out = ffi.new("ost_digest *")
    memory = ffi.from_buffer(data)
    call(lib.ost_digest_bytes, memory, len(memory), out)
    return bytes(ffi.buffer(out)).hex()
