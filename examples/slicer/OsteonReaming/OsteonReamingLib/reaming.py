# SPDX-License-Identifier: Apache-2.0
"""Reams a glenoid in a CT: arrays and matrices in, arrays and matrices out. This file does not use Slicer.

    CT [k, j, i], ijk_to_ras, landmarks --ream--> Reamed: bone [k, j, i], removed [k, j, i], ijk_to_ras, counts

Arrays and matrices have the conventions of Slicer: arrays are indexed [k, j, i], points are in RAS, in millimetres.
The reamed bone has cubic voxels with the spacing of the CT along i, so its grid differs from the grid of a CT with
thicker slices.
"""
from typing import Any, Dict, NamedTuple, Optional

import numpy as np
import osteon

_FLIP = np.array([-1.0, -1.0, 1.0])  # between RAS and LPS
BUILTIN_DEPTH_MM = 3                 # depth of the built-in path glenoid-ream
SEARCH_MM = 10.0                     # greatest distance from the middle of the rim to the bone behind it


class Reamed(NamedTuple):
    """The result of ream().

    Attributes
    ----------
    bone : ndarray of int16, [k, j, i]
        Densities of the remaining bone; 0 outside.
    removed : ndarray of uint8, [k, j, i]
        1 for removed voxels.
    ijk_to_ras : ndarray, (4, 4)
        Geometry of both arrays.
    centre_ras, axis_ras : ndarray, (3,)
        Centre of the glenoid's face, and the inward direction.
    voxels, volume_mm3, by_class
        The removed bone: number of voxels, volume, and number of voxels of each density class.
    """

    bone: np.ndarray
    removed: np.ndarray
    ijk_to_ras: np.ndarray
    centre_ras: np.ndarray
    axis_ras: np.ndarray
    voxels: int
    volume_mm3: float
    by_class: Dict[str, int]


class _Image:
    """A CT as the package reads it: an array [i, j, k] and its matrix to RAS, with the names that nibabel uses."""

    def __init__(self, array: np.ndarray, ijk_to_ras: Any, mask: Optional[np.ndarray]) -> None:
        if mask is not None:
            if mask.shape != array.shape:
                raise ValueError(f"a mask of shape {mask.shape}; expected that of the CT, {array.shape}")
            array = np.where(mask != 0, array, -1024)
        self.dataobj, self.affine = array.transpose(), np.asarray(ijk_to_ras, np.float64)


def tool_mesh(vertices_ras: Any = None, triangles: Any = None, diameter_mm: Optional[float] = None) -> osteon.Mesh:
    """Returns the mesh of a tool whose working face points to -z: a model of Slicer, or a reamer of a diameter.

    Slicer converts a mesh file from LPS to RAS when it loads it. The conversion is undone here.
    """
    if vertices_ras is None:
        return osteon.phantom.tool("reamer", diameter_mm=diameter_mm)
    return osteon.Mesh.of_mm(np.asarray(vertices_ras, np.float64) * _FLIP, np.asarray(triangles))


def face_of(bone: osteon.Bone, rim_ras: Any, medial_ras: Any) -> osteon.Glenoid:
    """Determines the face of a glenoid from landmarks.

    Parameters
    ----------
    rim_ras : array_like, (n, 3)
        At least three points on the rim. The axis is perpendicular to the plane that fits them best.
    medial_ras : array_like, (3,)
        A point on the medial side, for example the trigonum spinae. It determines the sign of the axis.

    Returns
    -------
    osteon.Glenoid
        Its centre is the first bone on the axis, from the middle of the rim inward.
    """
    rim = np.asarray(rim_ras, np.float64).reshape(-1, 3) * _FLIP
    if len(rim) < 3:
        raise ValueError(f"{len(rim)} points on the rim of the glenoid; expected at least 3")
    middle = rim.mean(axis=0)
    _, spread, directions = np.linalg.svd(rim - middle, full_matrices=False)
    if spread[1] < 2:
        raise ValueError("the points on the rim lie on a line; expected points around the glenoid")
    axis = directions[2]
    to_medial = (np.asarray(medial_ras, np.float64) * _FLIP - middle) @ axis
    if abs(to_medial) < 5:
        raise ValueError(f"the medial point is {abs(to_medial):.1f} mm from the plane of the rim; expected a point on "
                         "the medial side, at least 5 mm away")
    axis = axis if to_medial > 0 else -axis
    steps = np.arange(0, SEARCH_MM + 0.05, 0.1)
    points = middle + steps[:, None] * axis
    index = np.rint((points - bone.geometry.origin_mm) / bone.geometry.spacing_mm).astype(np.int32)
    active = bone.sample(index) >= bone.threshold
    if not active.any():
        raise ValueError(f"no bone within {SEARCH_MM:g} mm behind the rim of the glenoid; check the landmarks and the "
                         "threshold")
    centre = points[int(np.argmax(active))]
    return osteon.Glenoid.of([round(float(v), 6) for v in centre], axis)


def ream(voxels: np.ndarray, ijk_to_ras: Any, rim_ras: Any, medial_ras: Any, tool: osteon.Mesh, *,
         depth_mm: float = 3.0, rpm: int = 200, threshold: int = 120, mask: Optional[np.ndarray] = None,
         tool_voxel_mm: float = 0.5) -> Reamed:
    """Reams a glenoid along its axis.

    Parameters
    ----------
    voxels : ndarray, [k, j, i]
        Densities of the CT in HU.
    ijk_to_ras : array_like, (4, 4)
        Geometry of the CT, whose axes are parallel to those of the patient.
    rim_ras, medial_ras : array_like
        Landmarks, as for face_of.
    tool : osteon.Mesh
        The tool, as tool_mesh returns it.
    depth_mm : float
        Depth below the centre of the face, 0.5 to 15 mm.
    mask : ndarray, [k, j, i], optional
        Voxels other than 0 belong to the scapula. Without a mask, the humerus is bone too.

    Raises
    ------
    ValueError
        If the input is wrong; the text is one line for the user.
    OsteonError
        For other errors of the library.
    """
    if not 0.5 <= depth_mm <= 15:
        raise ValueError(f"a depth of {depth_mm} mm; expected 0.5 to 15 mm")
    with osteon.Backend() as backend:
        bone = backend.bone(osteon.Volume.from_nibabel(_Image(voxels, ijk_to_ras, mask), clamp=True),
                            threshold=threshold)
        before = bone.voxels()
        glenoid = face_of(bone, rim_ras, medial_ras)
        cutter = backend.voxelize(tool, tool_voxel_mm)
        path = osteon.Path.builtin("glenoid-ream", glenoid, cutter)
        axis = np.array(glenoid.axis) / np.linalg.norm(glenoid.axis)
        further = [osteon.pm(round(float(v), 6)) for v in (depth_mm - BUILTIN_DEPTH_MM) * axis]
        path.ticks["t_pm"] += np.array(further, np.int64)
        path = path.turned(rpm)
        world = osteon.World(bone, [cutter])
        totals = world.run(path)
        after = bone.voxels()
        geometry = bone.geometry
        names = [c.name for c in world.classes]
    to_lps = np.diag(list(geometry.spacing_mm) + [1.0])
    to_lps[:3, 3] = geometry.origin_mm
    return Reamed(after, ((before != 0) & (after == 0)).astype(np.uint8), np.diag(list(_FLIP) + [1.0]) @ to_lps,
                  np.array([osteon.to_mm(v) for v in glenoid.at_pm]) * _FLIP, axis * _FLIP, totals.removed_voxels,
                  totals.removed_voxels * float(np.prod(geometry.spacing_mm)),
                  dict(zip(names, totals.removed_by_class)))
