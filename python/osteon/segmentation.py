# SPDX-License-Identifier: Apache-2.0
"""Segmentation: a CT is divided into bones, which are connected components of dense voxels (AR-SEG).

    Volume --segment, with cuts--> Segmentation: label map, list of segments --keep--> fewer segments

The label map can be written, and Backend.read_bone(mask=...) imports one of its bones.

Threads: the functions share no state.
"""
import math
from dataclasses import dataclass
from typing import Any, Iterable, List, NamedTuple, Optional, Tuple

import numpy as np

from osteon._c import call, ffi, lib
from osteon.bone import volume_of
from osteon.errors import UsageError
from osteon.grid import Volume
from osteon.units import Length, Vector, c_pm3, of_pm3, pm, pm3, vector

__all__ = ["Cut", "Segment", "Segmentation", "segment"]

DEFAULT_AIR = -200


class Cut(NamedTuple):
    """A cut that separates two bones: a ball or a half space, whose voxels belong to no bone.

    Attributes
    ----------
    at_pm : (int, int, int)
        Centre of the ball, or a point on the plane.
    radius_pm : int
        Radius of the ball; 0 for a half space.
    normal : (int, int, int)
        Direction from the plane into the half space, of any length except 0.
    """

    at_pm: Vector
    radius_pm: int = 0
    normal: Vector = (0, 0, 0)

    @classmethod
    def ball(cls, at_mm: Any, radius_mm: Length) -> "Cut":
        """Makes a cut by a ball, as --cut-ball does."""
        return cls(pm3(at_mm), pm(radius_mm))

    @classmethod
    def plane(cls, at_mm: Any, normal: Iterable[float]) -> "Cut":
        """Makes a cut by the half space to which the normal points, as --cut-plane does."""
        return cls(pm3(at_mm), 0, pm3(normal))


class Segment(NamedTuple):
    """A bone of a segmentation. Its label is its index + 1.

    Attributes
    ----------
    voxels, filled : int
        Number of voxels without filled holes, and number of voxels in filled holes.
    box : ((int, int, int), (int, int, int))
        First voxel and end of the bounds.
    first : (int, int, int)
        First voxel in the order of the grid.
    """

    voxels: int
    filled: int
    box: Tuple[Vector, Vector]
    first: Vector


@dataclass
class Segmentation:
    """The bones of a CT.

    Attributes
    ----------
    labels : Volume
        The label map, with the geometry of the CT; 0 is no bone.
    segments : list of Segment
        The bones in descending order of size.
    """

    labels: Volume
    segments: List[Segment]

    def label_at(self, at_mm: Any) -> Optional[int]:
        """Returns the label of the voxel that contains a position, or None if the position is outside the grid."""
        label = lib.ost_segment_label_at(self.labels._c(), c_pm3(pm3(at_mm)))
        return None if label < 0 else int(label)

    def label_near(self, at_mm: Any) -> Tuple[int, Vector]:
        """Returns the label of the labelled voxel nearest to a position, and its centre in picometres.

        Raises
        ------
        UsageError
            If no voxel has a label.
        """
        found = ffi.new("ost_pm3 *")
        label = lib.ost_segment_label_near(self.labels._c(), c_pm3(pm3(at_mm)), found)
        if label == 0:
            raise UsageError("no voxel has a label")
        return int(label), of_pm3(found)

    def keep(self, labels: Iterable[int]) -> "Segmentation":
        """Returns the segmentation with these labels only, numbered from 1 in unchanged order (AR-SEG-10)."""
        wanted = {int(label) for label in labels}
        wrong = [label for label in wanted if not 1 <= label <= len(self.segments)]
        if wrong:
            raise UsageError(f"label {min(wrong)}: expected 1 to {len(self.segments)}")
        made = Volume(self.labels.voxels.copy(), self.labels.geometry, dict(self.labels.meta))
        memory = ffi.new("ost_segment[]", [
            {"voxels": s.voxels, "filled": s.filled, "box": {"lo": s.box[0], "hi": s.box[1]}, "first": s.first}
            for s in self.segments])
        count = ffi.new("size_t *", len(self.segments))
        call(lib.ost_segments_keep, made._c(), memory, count,
             ffi.new("bool[]", [label in wanted for label in range(1, len(self.segments) + 1)]))
        return Segmentation(made, _segments(memory, count[0]))

    def mask(self, label: int) -> np.ndarray:
        """Returns the voxels of a bone as a bool array [z, y, x]."""
        return self.labels.voxels == label


def _segments(memory: Any, count: int) -> List[Segment]:
    return [Segment(s.voxels, s.filled, (vector(s.box.lo), vector(s.box.hi)), vector(s.first))
            for s in memory[0:count]]


def segment(ct: Any, *, threshold: int = 120, growth: Optional[int] = None, cuts: Iterable[Cut] = (),
            min_volume_mm3: float = 100, fill: bool = False, air: int = DEFAULT_AIR,
            separate_mm: Optional[Length] = None) -> Segmentation:
    """Divides a CT into bones, as `osteon segment` does.

    Parameters
    ----------
    ct : Volume or image
        The CT.
    threshold : int
        Density that at least one voxel of each bone reaches.
    growth : int, optional
        Lowest density of the voxels of a bone; the default is the threshold.
    cuts : iterable of Cut
        Cuts that separate bones which touch.
    min_volume_mm3 : float
        Smallest volume of a bone; smaller components get no label.
    fill : bool
        True to give holes without air the label of the surrounding bone.
    air : int
        Density below which a voxel is air.
    separate_mm : length, optional
        Divide a bone at a neck whose radius is smaller, by at least this length, than that of the bone on both sides.

    Returns
    -------
    Segmentation
        With no segments if no component is large enough.

    Raises
    ------
    RangeError
        If an option is out of its range, or if there are more than 32767 bones.
    """
    volume = volume_of(ct)
    x, y, z = volume.geometry.spacing_mm
    made = ffi.new("ost_segment_cut[]", [{"at": c_pm3(c.at_pm), "radius": c.radius_pm, "normal": c_pm3(c.normal)}
                                         for c in cuts])
    options = ffi.new("ost_segment_options *", {
        "threshold": threshold, "growth": growth or 0, "cuts": made, "cut_count": len(made),
        "min_voxels": max(1, math.ceil(min_volume_mm3 / (x * y * z))), "fill": fill, "air": air,
        "separate": 0 if separate_mm is None else pm(separate_mm)})
    labels, out, count = ffi.new("ost_volume *"), ffi.new("ost_segment **"), ffi.new("size_t *")
    call(lib.ost_segment_volume, volume._c(), options, labels, out, count)
    try:
        return Segmentation(Volume._of_c(labels), _segments(out[0], count[0]))
    finally:
        lib.ost_segments_free(out[0])
