# SPDX-License-Identifier: Apache-2.0
"""Pictures without a display: uint8 arrays [row, column, 3], row 0 at the top.

    render   a shaded view with scale and directions, as `osteon export --view` does
    slices   axial, coronal and sagittal slices, as `osteon export --slices` does
    points   the bone in perspective, through a Camera; bit-identical on every machine

Threads: the functions share no state.
"""
from typing import Any, Iterable, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib, path_bytes
from osteon.bone import Bone, volume_of
from osteon.errors import UsageError
from osteon.event import Pose
from osteon.grid import Geometry, Volume, array_of, pointer
from osteon.mesh import ToolVolume
from osteon.tool import Tool
from osteon.units import vector

__all__ = ["Camera", "encode_png", "points", "render", "slices", "write_png"]

_STYLES = {"smooth": lib.OST_STYLE_SMOOTH, "faces": lib.OST_STYLE_FACES}


def _picture(picture: Any) -> np.ndarray:
    size = 3 * picture.width * picture.height
    rgb = ffi.gc(picture.rgb, lambda _: lib.ost_picture_free(picture), size)
    return array_of(rgb, size, np.uint8, (picture.height, picture.width, 3))


def _scene(data: Any, threshold: Optional[int]) -> Tuple[Volume, int, bool]:
    """Returns the volume, the threshold and whether it is a tool."""
    if isinstance(data, Tool):
        data = data.download()
    if isinstance(data, ToolVolume):
        g = data.geometry
        origin = vector(c + g.voxel_pm // 2 for c in g.corner_pm)
        return Volume(data.voxels.astype(np.int16), Geometry(g.dims, (g.voxel_pm,) * 3, origin)), 1, True
    if threshold is None and isinstance(data, Bone):
        threshold = data.threshold
    volume = volume_of(data)
    return volume, int(volume.meta.get("threshold", 120)) if threshold is None else threshold, False


def render(data: Any, before: Any = None, *, direction: Iterable[float] = (0, 0, 0), up: Iterable[float] = (0, 0, 0),
           size: Tuple[int, int] = (800, 800), threshold: Optional[int] = None, centre_mm: Any = None,
           extent_mm: float = 0.0, legend: bool = True, threads: int = 0) -> np.ndarray:
    """Draws a view of the bone voxels, whose voxels must be cubes.

    Parameters
    ----------
    data : Bone, Volume, Tool, ToolVolume or image
        The grid.
    before : Bone or Volume, optional
        The bone before an operation. The newly exposed surface is coloured by its depth below this surface.
    direction : (x, y, z)
        From the eye into the scene, in LPS; the default is to posterior.
    up : (x, y, z)
        Upward direction; the default is superior.
    size : (int, int)
        Width and height in pixels.
    centre_mm, extent_mm : (x, y, z), float
        Centre of the view and height of the view in its plane; the default shows the complete bone.
    legend : bool
        False to omit the legend, the scale bar and the patient's directions.

    Returns
    -------
    ndarray
        uint8, shape (height, width, 3).
    """
    if min(size) < 1:
        raise UsageError(f"size {tuple(size)}: expected at least 1 pixel")
    volume, level, tool = _scene(data, threshold)
    options = ffi.new("ost_view_options *", {
        "direction": [float(v) for v in direction], "up": [float(v) for v in up], "threshold": level,
        "width": size[0], "height": size[1], "extent_mm": extent_mm, "tool": tool, "no_legend": not legend,
        "threads": threads})
    if centre_mm is not None:
        options.centre_mm = [float(v) for v in centre_mm]
    out = ffi.new("ost_picture *")
    c_volume = volume._c()
    old = volume_of(before) if before is not None else None
    call(lib.ost_picture_view, c_volume, old._c() if old is not None else ffi.NULL, options, out)
    return _picture(out)


def slices(data: Any, before: Any = None, *, at: Optional[Iterable[int]] = None, threshold: Optional[int] = None,
           level: int = 0, width: int = 0, pixels: int = 0) -> np.ndarray:
    """Draws the axial, coronal and sagittal slice through a voxel.

    Parameters
    ----------
    before : Bone or Volume, optional
        The bone before an operation; removed voxels are coloured.
    at : (int, int, int), optional
        Index x, y, z of the voxel; the default is the middle of the removed voxels, or of the grid.
    level, width : int
        Grey-scale window in HU; the default is 400 and 1800.
    pixels : int
        Length of the longest side of a slice; the default is 480.
    """
    volume, lowest, _ = _scene(data, threshold)
    options = ffi.new("ost_slices_options *", {"at": [-1] * 3 if at is None else [int(v) for v in at],
                                               "threshold": lowest, "level": level, "width": width, "pixels": pixels})
    out = ffi.new("ost_picture *")
    c_volume = volume._c()
    old = volume_of(before) if before is not None else None
    call(lib.ost_picture_slices, c_volume, old._c() if old is not None else ffi.NULL, options, out)
    return _picture(out)


class Camera(NamedTuple):
    """A camera in the frame of the bone. In its own frame, x points to the right, y up, and the view direction is -z.

    Attributes
    ----------
    pose : Pose
        Maps the frame of the camera to that of the bone.
    focal_px : float
        Focal length in pixels, 1 to 100,000, rounded to 0.001.
    size : (int, int)
        Width and height of the picture in pixels.
    """

    pose: Pose
    focal_px: float
    size: Tuple[int, int]

    @classmethod
    def look_at(cls, from_mm: Iterable[float], at_mm: Iterable[float], up: Iterable[float] = (0, 0, 1), *,
                focal_px: float = 800, size: Tuple[int, int] = (800, 800)) -> "Camera":
        """Makes a camera at a position that looks at another position; `up` need not be perpendicular to the view."""
        out = ffi.new("ost_camera *")
        call(lib.ost_camera_look_at, [float(v) for v in from_mm], [float(v) for v in at_mm], [float(v) for v in up],
             out)
        return cls(Pose._of_c(out.pose), focal_px, size)

    def _c(self) -> Any:
        return ffi.new("ost_camera *", {"pose": self.pose._c()[0], "focal_milli": round(self.focal_px * 1000),
                                        "width": self.size[0], "height": self.size[1]})


def points(data: Any, camera: Camera, *, style: str = "smooth", threshold: Optional[int] = None,
           threads: int = 0) -> np.ndarray:
    """Draws the voxels of a bone, which must be cubes, as ray-box points in perspective.

    Parameters
    ----------
    data : Bone, Volume, Tool, ToolVolume or image
        The grid.
    style : {"smooth", "faces"}
        Shading by the surface's normals, or by the normal of each face.

    Returns
    -------
    ndarray
        uint8, shape (height, width, 3).
    """
    if style not in _STYLES:
        raise UsageError(f"style {style!r}: expected one of {', '.join(_STYLES)}")
    volume, level, _ = _scene(data, threshold)
    options = ffi.new("ost_points_options *", {"threshold": level, "style": _STYLES[style], "threads": threads})
    out = ffi.new("ost_picture *")
    call(lib.ost_picture_points, volume._c(), camera._c(), options, out)
    return _picture(out)


def _picture_of(picture: np.ndarray) -> Tuple[Any, np.ndarray]:
    """Returns an ost_picture, and the array to which it refers."""
    array = np.ascontiguousarray(picture)
    if array.ndim != 3 or array.shape[2] != 3 or array.dtype != np.uint8:
        raise UsageError(f"picture of shape {array.shape} and type {array.dtype}: expected (rows, columns, 3), uint8")
    return ffi.new("ost_picture *", {"width": array.shape[1], "height": array.shape[0],
                                     "rgb": pointer(array, "uint8_t *")}), array


def write_png(path: Any, picture: np.ndarray) -> None:
    """Writes a picture as a PNG file."""
    made, keep = _picture_of(picture)
    call(lib.ost_picture_write_png, path_bytes(path), made)
    del keep


def encode_png(picture: np.ndarray) -> bytes:
    """Returns a picture as the bytes of a PNG file, for example for IPython.display.Image in a notebook."""
    made, keep = _picture_of(picture)
    memory, size = ffi.new("uint8_t **"), ffi.new("size_t *")
    call(lib.ost_picture_encode_png, made, memory, size)
    del keep
    try:
        return bytes(ffi.buffer(memory[0], size[0]))
    finally:
        lib.free(memory[0])
