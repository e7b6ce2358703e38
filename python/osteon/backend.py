# SPDX-License-Identifier: Apache-2.0
"""Backends, which store voxels and operate on them.

    file --Backend.read_bone--> Bone        Volume --Backend.bone--> Bone --Bone.write--> file
    file --Backend.read_tool--> Tool        Mesh --Backend.voxelize--> Tool

A string selects a backend: "cpu" (the default), "cpu:isa=avx2,threads=2", "ref", "cl:platform=Portable,device=0" or
"plugin:FILE.so". All backends compute bit-identical grids.

Lifetimes: bones and tools refer to their backend, which is closed after them. Backend.close() closes them too.

Threads: the C library allows one thread at a time to use a backend and its objects; different backends may be used by
different threads at the same time. A lock in each backend ensures this, and cffi releases the GIL during a call.
"""
import contextlib
import os
import weakref
from typing import Any, ContextManager, Dict, Iterable, List, Optional, Union

from osteon._c import Lock, Owned, call, call_with_progress, ffi, lib, meta_of, path_bytes, progress_handle, text
from osteon.bone import Bone, volume_of
from osteon.errors import UsageError
from osteon.grid import Geometry, Progress, member_of, pointer, report_of, volume_options
from osteon.mesh import Mesh, Snapped, ToolVolume, grid_of, mesh_of
from osteon.tool import Tool
from osteon.units import Length, c_pm3, mm_text, pm, pm3

__all__ = ["Backend", "backends", "devices"]

_RESAMPLE = {"linear": lib.OST_RESAMPLE_LINEAR, "nearest": lib.OST_RESAMPLE_NEAREST,
             "thesis": lib.OST_RESAMPLE_THESIS}
_DUPLICATES = {"error": lib.OST_DUPLICATES_ERROR, "first": lib.OST_DUPLICATES_FIRST, "last": lib.OST_DUPLICATES_LAST,
               "max": lib.OST_DUPLICATES_MAX}
_RULES = {"winding": lib.OST_FILL_WINDING, "parity": lib.OST_FILL_PARITY}


def choice(table: Dict[str, int], what: str, value: str) -> int:
    """Returns the value of an option, or raises UsageError with the possible values."""
    if value not in table:
        raise UsageError(f"{what} {value!r}: expected one of {', '.join(table)}")
    return table[value]


# ------------------------------------------------------------------ choice


def backends() -> List[Dict[str, Any]]:
    """Returns the backends: name, description, available, and the reason if a backend is not available."""
    found = []
    for index in range(lib.ost_backend_count()):
        info = ffi.new("ost_backend_info *")
        call(lib.ost_backend_describe, index, info)
        found.append({"name": text(info.name), "description": text(info.description), "available": info.available,
                      "reason": text(info.reason)})
    return found


@ffi.def_extern()
def osteon_py_device(device: Any, user: Any) -> None:
    """Receives one device (ost_device_visit)."""
    ffi.from_handle(user).append({name: text(getattr(device, name)) if name != "available" else device.available
                                  for name in ("spec", "platform", "name", "available", "reason", "notes", "facts")})


def devices() -> List[Dict[str, Any]]:
    """Tests every device of every backend, as `osteon devices` does. "spec" is the string for Backend()."""
    found: List[Dict[str, Any]] = []
    handle = ffi.new_handle(found)
    for index in range(lib.ost_backend_count()):
        call(lib.ost_backend_devices, index, lib.osteon_py_device, handle)
    return found


class Backend(Owned):
    """An open backend.

    Parameters
    ----------
    spec : str
        For example "cpu", "ref" or "cpu:isa=avx2,threads=2".

    Raises
    ------
    UsageError
        If a name, key or value is unknown.
    UnavailableError
        If the backend cannot run on this machine.
    """

    def __init__(self, spec: str = "cpu") -> None:
        out = ffi.new("ost_backend **")
        call(lib.ost_backend_open, spec.encode(), out)
        super().__init__(out[0], lib.ost_backend_close, Lock())
        self.spec = spec
        self._objects: "weakref.WeakSet[Owned]" = weakref.WeakSet()

    def close(self) -> None:
        """Closes the backend and all its bones, tools and worlds, which must not be used afterwards."""
        for item in sorted(self._objects, key=lambda item: getattr(item, "_closes_first", 1)):
            item.close()
        super().close()

    def _preparing(self) -> ContextManager[Any]:
        """Returns a context in which a world is made."""
        return contextlib.nullcontext()

    def _adopt(self, item: Owned) -> None:
        self._objects.add(item)

    def __repr__(self) -> str:
        return f"<osteon.Backend {self.spec}{' (closed)' if self.closed else ''}>"

    @property
    def name(self) -> str:
        """Name without options, for example "cpu"."""
        return text(lib.ost_backend_name(self._c))

    @property
    def settings(self) -> Dict[str, Any]:
        """Settings that follow from the options and the machine: isa, threads, platform, device."""
        found = lib.ost_backend_settings_get(self._c)
        return {"isa": text(found.isa), "threads": found.threads, "platform": found.platform, "device": found.device}

    def finish(self) -> None:
        """Waits until all work is complete, and raises the error of work that failed after its call returned."""
        with self._lock.held:
            call(lib.ost_backend_finish, self._c)

    # -------------------------------------------------------------- bones

    def read_bone(self, path: Any, *, spacing_mm: Any = None, cubic_mm: Optional[Length] = None,
                  threshold: Optional[int] = None, chunk_size: int = 32, resample: Optional[str] = None,
                  duplicates: str = "error", crop: Any = None, threads: int = 0, digests: bool = False,
                  mask: Any = None, mask_labels: Iterable[Union[int, str]] = (), mask_fill: bool = False,
                  clamp: bool = False, resample_oblique: bool = False, orientation: str = "", form: str = "auto",
                  series: Optional[str] = None, even_slices: bool = False, untilt: bool = False,
                  nan_as_air: bool = False, progress: Optional[Progress] = None) -> "Bone":
        """Imports a CT, or a bone that Bone.write or `osteon import` wrote.

        The keywords are the options of `osteon import` with the same names.

        Parameters
        ----------
        path : path-like
            NRRD, NIfTI, MetaImage, DICOM, a stack of slices, or text.
        spacing_mm : length or (x, y, z), optional
            Spacing of the CT, which replaces the spacing in the file.
        cubic_mm : length, optional
            Edge length of the bone's voxels; the default is the CT's spacing along x.
        threshold : int, optional
            Lowest density of bone; the default is the threshold in the file, or 120.
        crop : ((x, y, z), (x, y, z)), optional
            First voxel and end of the box of CT voxels to import.
        mask : path-like, optional
            Label map; only voxels with the labels `mask_labels` (numbers or names) are imported.
        digests : bool
            True to compute the SHA-256 of the grid of each stage, in Bone.imported["stages"].
        progress : callable, optional
            Called with a stage and the completed share from 0 to 1. If it returns False, CancelledError is raised.

        Returns
        -------
        Bone
            With the facts of the file in Bone.meta, and a report in Bone.imported.
        """
        options, keep = ffi.new("ost_import_options *"), []
        if spacing_mm is not None:
            options.spacing = c_pm3(pm3(spacing_mm))
        options.cubic = 0 if cubic_mm is None else pm(cubic_mm)
        options.threshold = threshold or 0
        options.chunk_size = chunk_size
        if resample is not None:
            options.has_resample, options.resample = True, choice(_RESAMPLE, "resample", resample)
        options.duplicates = choice(_DUPLICATES, "duplicates", duplicates)
        if crop is not None:
            options.crop = True
            options.crop_box.lo, options.crop_box.hi = [int(v) for v in crop[0]], [int(v) for v in crop[1]]
        options.threads, options.digests, options.mask_fill = threads, digests, mask_fill
        if mask is not None:
            keep.append(ffi.new("char[]", path_bytes(mask)))
            options.mask = keep[-1]
        for label in mask_labels:
            if isinstance(label, str):
                keep.append(ffi.new("char[]", label.encode()))
                options.mask_names[options.mask_name_count] = keep[-1]
                options.mask_name_count += 1
            else:
                options.mask_labels[options.mask_label_count] = int(label)
                options.mask_label_count += 1
        keep.append(volume_options(ffi.addressof(options, "volume"), clamp=clamp, resample_oblique=resample_oblique,
                                   orientation=orientation, form=form, series=series, even_slices=even_slices,
                                   untilt=untilt, nan_as_air=nan_as_air,
                                   stack_spacing_mm=spacing_mm))
        out, result = ffi.new("ost_bone **"), ffi.new("ost_import_result *")
        running = progress_handle(progress, options)
        with self._lock.held:
            call_with_progress(running, lib.ost_import, self._c, path_bytes(path), options, out, result)
        bone = Bone(self, out[0])
        bone.meta = meta_of(result.meta)
        bone.imported = imported_of(result)
        bone.source = os.fsdecode(path)
        bone.load = {"duplicates": duplicates, "clamp": "yes" if clamp else "no",
                     "resample_oblique": "yes" if resample_oblique else "no"}
        if spacing_mm is not None:
            bone.load["spacing"] = ",".join(mm_text(v) for v in pm3(spacing_mm))
        if cubic_mm is not None:
            bone.load["cubic"] = mm_text(pm(cubic_mm))
        if crop is not None:
            bone.load["crop"] = ",".join(f"{int(a)}:{int(b)}" for a, b in zip(crop[0], crop[1]))
        if resample is not None:
            bone.load["resample"] = resample
        if orientation:
            bone.load["orientation"] = orientation
        if form != "auto":
            bone.load["form"] = form
        return bone

    def bone(self, volume: Any, *, geometry: Optional[Geometry] = None, cubic_mm: Optional[Length] = None,
             threshold: Optional[int] = None, chunk_size: int = 32, resample: str = "linear") -> "Bone":
        """Makes a bone from densities in memory, by the steps of an import.

        Parameters
        ----------
        volume : Volume, SimpleITK.Image, nibabel image, or array [z, y, x] with `geometry`
            The CT. If its spacing differs between the axes or from `cubic_mm`, it is resampled.
        threshold : int, optional
            Lowest density of bone; the default is volume.meta["threshold"], or 120.
        """
        volume = volume_of(volume, geometry)
        if threshold is None:
            threshold = int(volume.meta.get("threshold", 120))
        cubic = volume.geometry.spacing_pm[0] if cubic_mm is None else pm(cubic_mm)
        c_geometry = volume.geometry._c()
        rect, grid, bone = ffi.new("ost_grid **"), ffi.new("ost_grid **"), ffi.new("ost_bone **")
        with self._lock.held:
            call(lib.ost_grid_create, self._c, c_geometry, rect)
            try:
                call(lib.ost_grid_upload, rect[0], 0, volume.geometry.dims[2], pointer(volume.voxels, "int16_t *"))
                call(lib.ost_rect_to_cubic, rect[0], cubic, choice(_RESAMPLE, "resample", resample), grid)
                call(lib.ost_cubic_to_chunks, grid[0], chunk_size, threshold, bone)
            finally:
                lib.ost_grid_free(grid[0])
                lib.ost_grid_free(rect[0])
        made = Bone(self, bone[0])
        made.meta = dict(volume.meta)
        return made

    # -------------------------------------------------------------- tools

    def read_tool(self, path: Any, voxel_mm: Length = "0.5", *, noncutting: Any = None, unit: str = "auto",
                  rule: str = "winding") -> "Tool":
        """Reads a tool grid, or reads a mesh and voxelizes it, as `osteon voxelize` does.

        The parameters are those of voxelize(), and are not used for a tool grid.
        """
        kind = ffi.new("ost_file_kind *")
        call(lib.ost_file_kind_find, path_bytes(path), kind)
        if kind[0] == lib.OST_FILE_NRRD and noncutting is None:
            tool = self.tool(ToolVolume.read(path))
        else:
            tool = self.voxelize(Mesh.read(path, unit), voxel_mm, noncutting=noncutting, unit=unit, rule=rule)
            tool.load = {"voxel": mm_text(pm(voxel_mm)), "unit": unit, "rule": rule}
        tool.source = os.fsdecode(path)
        return tool

    def voxelize(self, mesh: Any, voxel_mm: Length = "0.5", *, noncutting: Any = None, unit: str = "auto",
                 rule: str = "winding") -> "Tool":
        """Voxelizes a mesh (AR-VOX).

        Parameters
        ----------
        mesh : Mesh, trimesh.Trimesh or path-like
            The part that cuts.
        voxel_mm : length
            Edge length of the tool's voxels.
        noncutting : Mesh, trimesh.Trimesh or path-like, optional
            The part that touches bone but does not cut.
        unit : str
            Unit of the coordinates in mesh files.
        rule : {"winding", "parity"}
            Rule that determines which points are inside a mesh.

        Returns
        -------
        Tool
            With the counts of the voxelization in Tool.report. A surface that is not closed has leaking_rows.
        """
        parts = [mesh_of(mesh, unit)] + ([] if noncutting is None else [mesh_of(noncutting, unit)])
        grid = grid_of(parts, voxel_mm)
        return self._voxelize([Snapped(part, grid) for part in parts], rule)

    def _voxelize(self, parts: List[Snapped], rule: str) -> "Tool":
        out, report = ffi.new("ost_tool **"), ffi.new("ost_voxelize_report *")
        with self._lock.held:
            call(lib.ost_voxelize, self._c, parts[0].c, parts[1].c if len(parts) > 1 else ffi.NULL,
                 choice(_RULES, "rule", rule), report, out)
        tool = Tool(self, out[0])
        tool.report = report_of(report)
        return tool

    def tool(self, volume: ToolVolume) -> "Tool":
        """Makes a tool from a tool grid in memory."""
        out = ffi.new("ost_tool **")
        with self._lock.held:
            call(lib.ost_tool_upload, self._c, volume._c(), out)
        tool = Tool(self, out[0])
        tool.meta = dict(volume.meta)
        return tool


def imported_of(result: Any) -> Dict[str, Any]:
    """Returns the report of an import as a dict."""
    found = {name: member_of(getattr(result, name), member.type) for name, member in ffi.typeof(result).item.fields
             if name not in ("rect", "cubic", "meta", "stages", "stage_count", "resample")}
    found["rect"], found["cubic"] = Geometry._of_c(result.rect), Geometry._of_c(result.cubic)
    found["resample"] = text(lib.ost_resample_name(result.resample))
    found["stages"] = [{"name": text(s.name), "time_ms": s.time_ms,
                        "digest": bytes(ffi.buffer(s.digest.bytes)).hex() if s.has_digest else None}
                       for s in result.stages[0:result.stage_count]]
    return found
