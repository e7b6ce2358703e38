# SPDX-License-Identifier: Apache-2.0
"""Parts of a bone that an operation needs: spheres, and the landmarks of a scapula.

    Bone, Volume, label map --spheres--> the humeral head --landmarks--> glenoid, rim, trigonum, inferior angle
    file of 3D Slicer --read_landmarks--> Landmark --write_landmarks--> file

The results are proposals, which a surgeon confirms or corrects (docs/reference/landmarks.md).

Threads: the functions share no state.
"""
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib, path_bytes, text
from osteon.bone import Bone, volume_of
from osteon.errors import UsageError
from osteon.units import Length, Vector, c_pm3, mm_text, of_pm3, pm, pm3
from osteon.world import Glenoid

__all__ = ["Landmark", "ScapulaLandmarks", "Sphere", "landmarks", "read_landmarks", "rim", "spheres",
           "write_landmarks"]


class Sphere(NamedTuple):
    """A sphere that fits a part of the surface of a bone.

    Attributes
    ----------
    centre_pm, radius_pm : (int, int, int), int
        Centre in LPS and radius, rounded to 0.01 mm.
    coverage : float
        Share of the area of the sphere that lies on the surface, 0 to 1.
    area_mm2 : float
        Area of the surface that lies on the sphere.
    residual_mm : float
        RMS distance between this part of the surface and the sphere.
    facing : (float, float, float)
        Unit vector from the centre to the middle of this part of the surface.
    """

    centre_pm: Vector
    radius_pm: int
    coverage: float
    area_mm2: float
    residual_mm: float
    facing: Tuple[float, float, float]

    @classmethod
    def _of_c(cls, s: Any) -> "Sphere":
        return cls(of_pm3(s.centre), s.radius, s.coverage, s.area_mm2, s.residual_mm, tuple(s.facing))

    def _c(self) -> Any:
        return ffi.new("ost_sphere *", {"centre": c_pm3(self.centre_pm), "radius": self.radius_pm,
                                        "coverage": self.coverage, "area_mm2": self.area_mm2,
                                        "residual_mm": self.residual_mm, "facing": self.facing})


class ScapulaLandmarks(NamedTuple):
    """The landmarks of a scapula, and figures that state how stable they are.

    Attributes
    ----------
    glenoid : Glenoid
        Centre of the face, inward axis, and side.
    trigonum_pm, inferior_angle_pm : (int, int, int)
        Trigonum spinae and inferior angle, in LPS.
    curvature : Sphere
        Sphere that fits the face.
    height_pm, width_pm : int
        Extents of the rim.
    rim_pm : ndarray
        Positions of the rim, int64, shape (n, 3).
    rim_share, rim_residual_mm : float
        Share of the directions in which the rim was found, and RMS distance of the rim from its plane.
    glenoid_spread_mm, axis_spread_deg, trigonum_spread_mm, inferior_spread_mm : float
        Greatest change of a landmark in the variants of the search.
    """

    glenoid: Glenoid
    trigonum_pm: Vector
    inferior_angle_pm: Vector
    curvature: Sphere
    height_pm: int
    width_pm: int
    rim_pm: np.ndarray
    rim_share: float
    rim_residual_mm: float
    glenoid_spread_mm: float
    axis_spread_deg: float
    trigonum_spread_mm: float
    inferior_spread_mm: float

    def meta(self) -> Dict[str, str]:
        """Returns the landmarks as facts for Bone.meta, from which Glenoid.of_meta and Plan.of_meta read them."""
        def point(at: Vector) -> str:
            return " ".join(mm_text(v) for v in at)

        return {text(lib.OST_META_SIDE): self.glenoid.side, text(lib.OST_META_GLENOID_AT): point(self.glenoid.at_pm),
                text(lib.OST_META_GLENOID_AXIS): " ".join(f"{v:.9f}" for v in self.glenoid.axis),
                text(lib.OST_META_TRIGONUM): point(self.trigonum_pm),
                text(lib.OST_META_INFERIOR_ANGLE): point(self.inferior_angle_pm)}


class Landmark(NamedTuple):
    """A labelled position of a file.

    Attributes
    ----------
    label : str
        The label, of at most 63 bytes.
    at_pm : (int, int, int)
        Position in LPS.
    role : {"other", "glenoid", "axis point", "trigonum", "inferior angle"}
        The role that the label states; write_landmarks does not use it.
    """

    label: str
    at_pm: Vector
    role: str = "other"


_ROLES = ("other", "glenoid", "axis point", "trigonum", "inferior angle")  # in the order of ost_landmark_role


def _solid(data: Any, label: Optional[int], threshold: Optional[int]) -> Tuple[Any, Any]:
    """Returns an ost_anatomy_bone, and the memory to which it refers."""
    if label is not None and threshold is not None:
        raise UsageError("label and threshold exclude each other")
    if threshold is None and isinstance(data, Bone):
        threshold = data.threshold
    volume = volume_of(data)
    if threshold is None:
        threshold = int(volume.meta.get("threshold", 120))
    c_volume = volume._c()
    low, high = (label, label) if label is not None else (max(threshold, 1), 32767)
    return ffi.new("ost_anatomy_bone *", {"volume": c_volume, "low": low, "high": high}), (volume, c_volume)


def spheres(data: Any, *, concave: bool = False, radius_mm: Optional[Tuple[Length, Length]] = None,
            near_mm: Any = None, reach_mm: Length = 20, most: int = int(lib.OST_SPHERES_MAX),
            label: Optional[int] = None, threshold: Optional[int] = None) -> List[Sphere]:
    """Finds spheres on the surface of a bone, for example the humeral head.

    Parameters
    ----------
    data : Bone, Volume or image
        A bone, a CT or a label map.
    concave : bool
        True if the bone lies outside the sphere, as at the glenoid.
    radius_mm : (length, length), optional
        Range of the radius, within 5 to 100 mm; the default is 17 to 32 mm, or 20 to 45 mm if concave.
    near_mm : (x, y, z), optional
        Only spheres whose centres are within `reach_mm` of this position are found.
    most : int
        Greatest number of spheres, at most 16.
    label : int, optional
        The bone consists of the voxels with this value of a label map.
    threshold : int, optional
        Lowest density of bone; the default is that of the bone, or 120.

    Returns
    -------
    list of Sphere
        Convex spheres in descending order of coverage, concave ones in descending order of area.

    Raises
    ------
    InputError
        If there is no bone or no sphere.
    """
    solid, keep = _solid(data, label, threshold)
    options = ffi.new("ost_sphere_options *", {"concave": concave})
    if radius_mm is not None:
        options.radius_min, options.radius_max = (pm(v) for v in radius_mm)
    if near_mm is not None:
        options.has_near, options.near, options.reach = True, c_pm3(pm3(near_mm)), pm(reach_mm)
    out, count = ffi.new("ost_sphere[]", int(lib.OST_SPHERES_MAX)), ffi.new("int *")
    call(lib.ost_spheres_find, solid, options, out, most, count)
    del keep
    return [Sphere._of_c(out[i]) for i in range(count[0])]


def landmarks(data: Any, head: Optional[Sphere] = None, *, label: Optional[int] = None,
              threshold: Optional[int] = None) -> ScapulaLandmarks:
    """Proposes the landmarks of a scapula, as `osteon import --landmarks auto` does.

    Parameters
    ----------
    data : Bone, Volume or image
        The scapula alone, or a label map with `label`.
    head : Sphere, optional
        The humeral head.
    label, threshold : int, optional
        As in spheres().

    Raises
    ------
    InputError
        With the reason, if the bone is not a complete scapula with one glenoid that is visible from outside.
    """
    solid, keep = _solid(data, label, threshold)
    out = ffi.new("ost_scapula_landmarks *")
    call(lib.ost_scapula_landmarks_find, solid, head._c() if head is not None else ffi.NULL, out)
    del keep
    return ScapulaLandmarks(
        Glenoid(of_pm3(out.glenoid), tuple(out.axis), "left" if out.left else "right"), of_pm3(out.trigonum),
        of_pm3(out.inferior), Sphere._of_c(out.curvature), out.height, out.width, _points(out.rim, out.rim_count),
        out.rim_share, out.rim_residual_mm, out.glenoid_spread_mm, out.axis_spread_deg, out.trigonum_spread_mm,
        out.inferior_spread_mm)


def rim(data: Any, glenoid: Glenoid, *, label: Optional[int] = None, threshold: Optional[int] = None) -> np.ndarray:
    """Finds the rim of a glenoid, ordered around its axis, in picometres: int64, shape (n, 3) with n up to 72.

    Raises
    ------
    InputError
        If the volume ends before the glenoid.
    """
    solid, keep = _solid(data, label, threshold)
    out, count = ffi.new("ost_pm3[]", int(lib.OST_RIM_MAX)), ffi.new("int *")
    call(lib.ost_glenoid_rim_find, solid, [lib.ost_pm_to_mm(v) for v in glenoid.at_pm], list(glenoid.axis), out, count)
    del keep
    return _points(out, count[0])


def _points(points: Any, count: int) -> np.ndarray:
    return np.array([of_pm3(points[i]) for i in range(count)], np.int64).reshape(-1, 3)


def read_landmarks(path: Any) -> List[Landmark]:
    """Reads landmarks from a .mrk.json or .fcsv file of 3D Slicer, or a CSV file with the columns label,x,y,z."""
    memory = ffi.new("ost_landmarks *")
    call(lib.ost_landmarks_read, path_bytes(path), memory)
    try:
        return [Landmark(text(item.label), of_pm3(item.at), _ROLES[item.role])
                for item in memory.items[0:memory.count]]
    finally:
        lib.ost_landmarks_free(memory)


def write_landmarks(path: Any, items: Iterable[Landmark]) -> None:
    """Writes landmarks as a .mrk.json file of 3D Slicer, in LPS. read_landmarks reads the same positions."""
    made = [{"label": item.label.encode()[:int(lib.OST_LANDMARK_LABEL) - 1], "at": c_pm3(item.at_pm)}
            for item in items]
    array = ffi.new("ost_landmark[]", made)
    call(lib.ost_landmarks_write, path_bytes(path), ffi.new("ost_landmarks *", {"count": len(made), "items": array}))
