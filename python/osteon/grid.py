# SPDX-License-Identifier: Apache-2.0
"""Grids in host memory.

Order of the axes: arrays are indexed [z, y, x] and are C-contiguous, which is the memory layout of the C library (x
varies fastest). Everything else (dims, spacing, origin, points, voxel indices in reports) is in the order x, y, z.

The frame of a bone is that of its CT in LPS: x points to the patient's left, y to the back, z to the head. The centre
of voxel (i, j, k) is origin + (i, j, k) * spacing.

Threads: these objects may be used by one thread at a time, or read by several.
"""
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Iterable, Optional, Tuple, Union

import numpy as np

from osteon._c import call, call_with_progress, ffi, lib, meta_of, meta_to, path_bytes, progress_handle
from osteon.errors import RangeError, UsageError
from osteon.units import Length, Vector, c_pm3, of_pm3, pm3, to_mm

__all__ = ["Geometry", "Volume", "as_voxels"]

Progress = Callable[[str, float], Any]


@dataclass(frozen=True)
class Geometry:
    """The grid of a volume: dims, spacing and origin.

    Parameters
    ----------
    dims : (int, int, int)
        Numbers of voxels along x, y and z.
    spacing_pm : (int, int, int)
        Distances between voxel centres in picometres.
    origin_pm : (int, int, int), optional
        Centre of voxel (0, 0, 0) in picometres, in LPS.

    See Also
    --------
    Geometry.of : makes a geometry from an array's shape and lengths in millimetres.
    """

    dims: Vector
    spacing_pm: Vector
    origin_pm: Vector = (0, 0, 0)

    @classmethod
    def of(cls, shape: Iterable[int], spacing_mm: Union[Length, Iterable[Length]],
           origin_mm: Iterable[Length] = (0, 0, 0)) -> "Geometry":
        """Makes a geometry from the shape (z, y, x) of an array, and spacing and origin (x, y, z) in millimetres."""
        z, y, x = (int(n) for n in shape)
        return cls((x, y, z), pm3(spacing_mm), pm3(origin_mm))

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Shape (z, y, x) of an array of the voxels."""
        return self.dims[2], self.dims[1], self.dims[0]

    @property
    def spacing_mm(self) -> Tuple[float, float, float]:
        """Spacing in millimetres, rounded to floats. For display."""
        x, y, z = (to_mm(v) for v in self.spacing_pm)
        return x, y, z

    @property
    def origin_mm(self) -> Tuple[float, float, float]:
        """Origin in millimetres, rounded to floats. For display."""
        x, y, z = (to_mm(v) for v in self.origin_pm)
        return x, y, z

    def check(self, what: str = "grid") -> None:
        """Raises RangeError if a value is outside the ranges of AR-GRID."""
        call(lib.ost_geometry_check, self._c(), what.encode())

    def _c(self) -> Any:
        return ffi.new("ost_geometry *", {"dims": c_pm3(self.dims), "spacing": c_pm3(self.spacing_pm),
                                          "origin": c_pm3(self.origin_pm)})

    @classmethod
    def _of_c(cls, g: Any) -> "Geometry":
        return cls((g.dims.x, g.dims.y, g.dims.z), of_pm3(g.spacing), of_pm3(g.origin))


def as_array(data: Any) -> np.ndarray:
    """Returns data as a numpy array, without a copy if possible.

    Data may be an array, an object with the buffer protocol or __array__, or an object with DLPack on the CPU, such
    as a tensor of PyTorch.
    """
    if isinstance(data, np.ndarray) or not hasattr(data, "__dlpack__"):
        return np.asarray(data)
    try:
        return np.from_dlpack(data)
    except (AttributeError, BufferError, RuntimeError, ValueError) as error:
        raise UsageError(f"{type(data).__name__}: the data cannot be read by DLPack ({error}); copy it to the host, "
                         "for example by cupy.asnumpy or tensor.cpu()") from None


def as_voxels(data: Any, shape: Optional[Tuple[int, int, int]] = None, dtype: Any = np.int16,
              clamp: bool = False) -> np.ndarray:
    """Returns voxels as a C-contiguous array [z, y, x] that the C library can read.

    An array with this type and layout is returned as it is, without a copy. Integers of another type are converted
    if all values fit. Floats are rounded half to even.

    Parameters
    ----------
    data : array_like
        Three-dimensional; numpy, the buffer protocol, or DLPack on the CPU.
    shape : (int, int, int), optional
        The shape that the array must have.
    dtype : dtype
        np.int16 for densities, np.uint8 for tools.
    clamp : bool
        True to saturate values outside the range of the type, which are otherwise an error.

    Raises
    ------
    RangeError
        If a value is NaN or does not fit.
    UsageError
        If the shape is wrong.
    """
    array = as_array(data)
    if array.ndim != 3 or (shape is not None and array.shape != tuple(shape)):
        raise UsageError(f"array of shape {array.shape}: expected {tuple(shape) if shape else '(z, y, x)'}")
    if array.dtype != dtype:
        limits = np.iinfo(dtype)
        if array.dtype.kind == "f":
            array = np.rint(array)
        elif array.dtype.kind not in "iub":
            raise UsageError(f"array of type {array.dtype}: expected numbers")
        if clamp:
            array = np.clip(array, limits.min, limits.max)
        if array.size and not (array.min() >= limits.min and array.max() <= limits.max):  # false for NaN
            raise RangeError(f"values from {array.min()} to {array.max()}: expected {limits.min} to {limits.max}")
        array = array.astype(dtype)
    if array.dtype.byteorder not in "=|" and not array.dtype.isnative:
        array = array.astype(dtype)
    return np.ascontiguousarray(array)


def pointer(array: np.ndarray, ctype: str, writable: bool = False) -> Any:
    """Returns a C pointer to the data of an array, which must outlive the pointer."""
    return ffi.cast(ctype, ffi.from_buffer(array, require_writable=writable))


def array_of(memory: Any, count: int, dtype: Any, shape: Any) -> np.ndarray:
    """Returns an array over C memory, without a copy. `memory` is kept until the array is freed."""
    return np.frombuffer(ffi.buffer(memory, count * np.dtype(dtype).itemsize), dtype=dtype).reshape(shape)


@dataclass
class Volume:
    """A dense grid of int16 densities in host memory: a CT, the voxels of a bone, or a label map.

    Parameters
    ----------
    voxels : array_like
        Densities, [z, y, x]. An int16 array that is C-contiguous is not copied.
    geometry : Geometry
        The grid.
    meta : dict, optional
        Facts that are stored in the header of a file, for example the position of the glenoid (osteon/grid.h).

    Attributes
    ----------
    report : dict
        After Volume.read: the conversions that were applied to the file (ost_volume_report in osteon/io.h).
    """

    voxels: np.ndarray
    geometry: Geometry
    meta: Dict[str, str] = field(default_factory=dict)
    report: Dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.voxels = as_voxels(self.voxels, self.geometry.shape)

    @classmethod
    def read(cls, path: Any, *, clamp: bool = False, resample_oblique: bool = False, orientation: str = "",
             form: str = "auto", series: Optional[str] = None, even_slices: bool = False, untilt: bool = False,
             nan_as_air: bool = False, stack_spacing_mm: Any = None, progress: Optional[Progress] = None) -> "Volume":
        """Reads an NRRD, NIfTI or MetaImage file, a DICOM series or a stack of slices, with axes in LPS.

        The keywords are the options of `osteon import` with the same names. The array refers to the memory of the C
        library; it is not copied.

        Parameters
        ----------
        progress : callable, optional
            Called with a stage and the completed share from 0 to 1. If it returns False, CancelledError is raised.
        """
        options = ffi.new("ost_volume_options *")
        keep = volume_options(options, clamp=clamp, resample_oblique=resample_oblique, orientation=orientation,
                              form=form, series=series, even_slices=even_slices, untilt=untilt,
                              nan_as_air=nan_as_air, stack_spacing_mm=stack_spacing_mm)
        keep_progress = progress_handle(progress, options)
        memory = ffi.new("ost_volume *")
        report = ffi.new("ost_volume_report *")
        call_with_progress(keep_progress, lib.ost_volume_read, path_bytes(path), options, memory, report)
        del keep
        volume = cls._of_c(memory)
        volume.report = report_of(report)
        return volume

    def write(self, path: Any, *, compress: bool = False, progress: Optional[Progress] = None) -> None:
        """Writes the volume. The file name selects the format: .nrrd, .nii, .nii.gz, .mha or .txt.

        The file appears under its name only when it is complete.
        """
        options = ffi.new("ost_write_options *", {"compress": compress})
        keep = progress_handle(progress, options)
        call_with_progress(keep, lib.ost_volume_write, path_bytes(path), self._c(), options)

    @staticmethod
    def write_meta(path: Any, meta: Dict[str, str]) -> None:
        """Replaces the facts in the header of an NRRD file, or of a NIfTI file that osteon wrote. Its voxels do not
        change."""
        facts = ffi.new("ost_meta *")
        meta_to(facts, meta)
        call(lib.ost_volume_write_meta, path_bytes(path), facts)

    def digest(self, kind: str = "cubic") -> str:
        """Returns the digest of the grid (AR-DIG) as 64 hexadecimal digits. kind is "rect" or "cubic"."""
        from osteon.hashing import digest  # pylint: disable=import-outside-toplevel  # hashing imports this module
        return digest(self, kind)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        if dtype is not None and np.dtype(dtype) != self.voxels.dtype:
            return self.voxels.astype(dtype)
        return self.voxels.copy() if copy else self.voxels

    def __dlpack__(self, **options: Any) -> Any:
        return self.voxels.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.voxels.__dlpack_device__()

    # ------------------------------------------------------------------ other packages

    @classmethod
    def from_sitk(cls, image: Any, clamp: bool = False) -> "Volume":
        """Makes a volume from a SimpleITK image, whose frame is LPS.

        The voxels are copied. Axes are flipped and permuted to LPS.

        Raises
        ------
        InputError
            If the image is oblique. Resample it first, or write it and use Volume.read(resample_oblique=True).
        """
        from osteon._images import from_sitk  # pylint: disable=import-outside-toplevel
        return from_sitk(image, clamp)

    def to_sitk(self) -> Any:
        """Returns a SimpleITK image with the same geometry. SimpleITK copies the voxels."""
        from osteon._images import to_sitk  # pylint: disable=import-outside-toplevel
        return to_sitk(self)

    @classmethod
    def from_nibabel(cls, image: Any, clamp: bool = False) -> "Volume":
        """Makes a volume from a nibabel image, whose frame is RAS. Axes are flipped and permuted to LPS.

        Raises
        ------
        InputError
            If the image is oblique.
        """
        from osteon._images import from_nibabel  # pylint: disable=import-outside-toplevel
        return from_nibabel(image, clamp)

    def to_nibabel(self) -> Any:
        """Returns a nibabel.Nifti1Image with the same geometry. The voxels are not copied."""
        from osteon._images import to_nibabel  # pylint: disable=import-outside-toplevel
        return to_nibabel(self)

    # ------------------------------------------------------------------ the C library

    def _c(self) -> Any:
        """Returns an ost_volume that refers to the voxels. It is valid while this object is not changed."""
        volume = ffi.new("ost_volume *")
        volume.geometry = self.geometry._c()[0]
        meta_to(ffi.addressof(volume, "meta"), self.meta)
        self.voxels = as_voxels(self.voxels, self.geometry.shape)
        volume.voxels = pointer(self.voxels, "int16_t *")
        return volume

    @classmethod
    def _of_c(cls, memory: Any) -> "Volume":
        """Takes over an ost_volume; its voxels are freed with the last array that refers to them."""
        geometry = Geometry._of_c(memory.geometry)
        facts = meta_of(memory.meta)
        count = lib.ost_dims_count(memory.geometry.dims)
        voxels = ffi.gc(memory.voxels, lambda _: lib.ost_volume_free(memory), 2 * count)
        return cls(array_of(voxels, count, np.int16, geometry.shape), geometry, facts)


def volume_options(options: Any, *, clamp: bool, resample_oblique: bool, orientation: str, form: str,
                   series: Optional[str], even_slices: bool, untilt: bool, nan_as_air: bool,
                   stack_spacing_mm: Any) -> Any:
    """Fills in an ost_volume_options, and returns the memory to which it refers."""
    forms = {"auto": lib.OST_FORM_AUTO, "qform": lib.OST_FORM_QFORM, "sform": lib.OST_FORM_SFORM}
    if form not in forms:
        raise UsageError(f"form {form!r}: expected auto, qform or sform")
    if len(orientation) not in (0, 3):
        raise UsageError(f"orientation {orientation!r}: expected three letters, such as RAS")
    options.clamp = clamp
    options.resample_oblique = resample_oblique
    options.orientation = orientation.encode()
    options.form = forms[form]
    options.even_slices = even_slices
    options.untilt = untilt
    options.nan_as_air = nan_as_air
    keep = ffi.new("char[]", str(series).encode()) if series is not None else None
    options.series = keep if keep is not None else ffi.NULL
    if stack_spacing_mm is not None:
        options.stack_spacing = c_pm3(pm3(stack_spacing_mm))
    return keep


def report_of(report: Any) -> Dict[str, Any]:
    """Returns the members of a struct as a dict: strings as str, nested structs as dicts, arrays as lists."""
    kind = ffi.typeof(report)
    fields = kind.item.fields if kind.kind == "pointer" else kind.fields
    return {name: member_of(getattr(report, name), member.type) for name, member in fields}


def member_of(value: Any, kind: Any) -> Any:
    """Returns a member of a struct as a Python object."""
    if kind.kind == "array" and kind.item.cname == "char":
        return ffi.string(value).decode("utf-8", "replace")
    if kind.kind == "array":
        return [member_of(item, kind.item) for item in value]
    return report_of(value) if kind.kind == "struct" else value
