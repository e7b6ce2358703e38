# SPDX-License-Identifier: Apache-2.0
"""Images of SimpleITK and nibabel. The two packages are imported only when an image is made."""
from typing import Any

import numpy as np

from osteon.errors import InputError, UnavailableError, UsageError
from osteon.grid import Geometry, Volume, as_voxels
from osteon.units import pm, to_mm


def straighten(array: np.ndarray, matrix: np.ndarray, origin_pm: Any, spacing_pm: Any, clamp: bool) -> Volume:
    """Makes a volume from an array whose axes are parallel to the axes of LPS.

    Parameters
    ----------
    array : ndarray
        Voxels, [i, j, k].
    matrix : ndarray
        Directions: matrix[a, b] is the component of array axis b along LPS axis a.
    origin_pm, spacing_pm : sequence of int
        Centre of voxel (0, 0, 0), in LPS, and the distances along i, j and k.
    """
    nearest = np.rint(matrix)
    if not np.array_equal(np.abs(nearest).sum(axis=0), [1, 1, 1]) or \
            not np.array_equal(np.abs(nearest).sum(axis=1), [1, 1, 1]) or np.abs(matrix - nearest).max() > 1e-4:
        raise InputError("the axes of the image are oblique; resample the image onto the patient's axes, or write it "
                         "to a file and read this with Volume.read(resample_oblique=True)")
    axis_of = [int(np.flatnonzero(nearest[a])[0]) for a in range(3)]  # the array's axis along LPS axis a
    origin = list(origin_pm)
    for a, b in enumerate(axis_of):
        if nearest[a, b] < 0:  # the last voxel of a flipped axis becomes the first
            origin[a] -= (array.shape[b] - 1) * spacing_pm[b]
            array = np.flip(array, axis=b)
    array = array.transpose(axis_of[::-1])  # [z, y, x]
    geometry = Geometry(tuple(array.shape[::-1]), tuple(spacing_pm[b] for b in axis_of), tuple(origin))
    geometry.check("image")
    return Volume(as_voxels(array, clamp=clamp), geometry)


def length(mm: float) -> int:
    """Converts a length from an image's header. A float32 represents its shortest decimal (AR-LEN)."""
    return pm(np.float32(mm)) if float(np.float32(mm)) == mm else pm(mm)


def from_sitk(image: Any, clamp: bool) -> Volume:
    """Implements Volume.from_sitk."""
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise UsageError("expected a SimpleITK image with three dimensions and one component per voxel")
    import SimpleITK  # pylint: disable=import-outside-toplevel  # an image of SimpleITK exists, so this succeeds
    array = SimpleITK.GetArrayViewFromImage(image).transpose()  # [i, j, k]
    matrix = np.array(image.GetDirection()).reshape(3, 3)
    return straighten(array, matrix, [pm(v) for v in image.GetOrigin()], [pm(v) for v in image.GetSpacing()], clamp)


def to_sitk(volume: Volume) -> Any:
    """Implements Volume.to_sitk."""
    try:
        import SimpleITK  # pylint: disable=import-outside-toplevel
    except ImportError:
        raise UnavailableError("SimpleITK is not installed: pip install SimpleITK") from None
    image = SimpleITK.GetImageFromArray(volume.voxels)
    image.SetSpacing([to_mm(v) for v in volume.geometry.spacing_pm])
    image.SetOrigin([to_mm(v) for v in volume.geometry.origin_pm])
    for key, value in volume.meta.items():
        image.SetMetaData("osteon_" + key, value)
    return image


def from_nibabel(image: Any, clamp: bool) -> Volume:
    """Implements Volume.from_nibabel."""
    array = np.asanyarray(image.dataobj)
    if array.ndim == 4 and array.shape[3] == 1:
        array = array[..., 0]
    if array.ndim != 3:
        raise UsageError(f"nibabel image of shape {array.shape}: expected three dimensions")
    affine = np.asarray(image.affine, dtype=np.float64) * np.array([[-1.0], [-1.0], [1.0], [1.0]])  # RAS to LPS
    columns = affine[:3, :3]
    scale = np.abs(columns).max(axis=0)  # the spacing, as an oblique image is refused
    if not (scale > 0).all():
        raise InputError("the affine of the image is singular")
    return straighten(array, columns / scale, [length(v) for v in affine[:3, 3]], [length(v) for v in scale], clamp)


def to_nibabel(volume: Volume) -> Any:
    """Implements Volume.to_nibabel."""
    try:
        import nibabel  # pylint: disable=import-outside-toplevel
    except ImportError:
        raise UnavailableError("nibabel is not installed: pip install nibabel") from None
    affine = np.diag([to_mm(v) for v in volume.geometry.spacing_pm] + [1.0])
    affine[:3, 3] = [to_mm(v) for v in volume.geometry.origin_pm]
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine  # LPS to RAS
    image = nibabel.Nifti1Image(volume.voxels.transpose(), affine)
    image.header.set_xyzt_units("mm")
    image.set_sform(affine, code="scanner")
    image.set_qform(affine, code="scanner")
    return image
