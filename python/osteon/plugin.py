# SPDX-License-Identifier: Apache-2.0
"""A Python function as a backend.

    function(bone, tool, event) --FunctionBackend--> a backend: World, Bone.remove, record, replay, check

libosteon calls external implementations through the table of osteon/plugin.h. The extension module of this package is
such a plugin: its slots are the functions below, which cffi calls. Removal and collision call the function; all other
stages (import, voxelization, tools) are those of another backend. libosteon checks the reports that the slots return,
as it does for every plugin.

Threads: libosteon makes one call at a time. The function is called on the thread that called the library, with the
GIL held.
"""
import contextlib
import itertools
import threading
from typing import Any, Callable, Dict, Iterator, List, Optional

import numpy as np

from osteon import _osteon, errors
from osteon._c import call, ffi, lib
from osteon.backend import Backend
from osteon.errors import OsteonError, Status, UsageError
from osteon.event import DensityClass, Event, Map
from osteon.grid import Geometry, array_of, pointer
from osteon.mesh import Snapped, ToolGeometry

__all__ = ["FunctionBackend", "RemoveFunction"]

RemoveFunction = Callable[[np.ndarray, np.ndarray, Event], Optional[int]]
"""The type of a function that removes bone: function(bone, tool, event).

bone is an int16 array [z, y, x], which the function changes in place: every removed voxel becomes 0. Inactive voxels
are 0 already. tool is a uint8 array [z, y, x] with the classes 0 empty, 1 cutting and 2 noncutting. event contains the
maps (AR-MAP) and the grids of bone and tool. The function returns the number of touched voxels (AR-REM-1), or None if it
does not count them."""

_STATUSES = {Status.USAGE: lib.OST_PLUGIN_USAGE, Status.RANGE: lib.OST_PLUGIN_RANGE,
             Status.MEMORY: lib.OST_PLUGIN_MEMORY, Status.UNAVAILABLE: lib.OST_PLUGIN_UNAVAILABLE}


class _Instance:
    """An instance of the plugin: the function, and the backend of all other stages."""

    def __init__(self, function: RemoveFunction, inner: Backend) -> None:
        self.function, self.inner = function, inner
        self.counts_touched: Optional[bool] = None  # None before the first call
        self.calls = 0
        self.quiet = False  # true while a world is made
        self.last_event: Optional[Event] = None
        self.last_bone: Optional["_Bone"] = None
        self.handles: Dict[Any, Any] = {}

    def give(self, item: Any, kind: str) -> Any:
        """Returns a pointer to a Python object, which is kept until drop()."""
        item.owner = self
        handle = ffi.new_handle(item)
        made = ffi.cast(kind, handle)
        self.handles[made] = handle
        return made


class _Grid:
    def __init__(self, c_grid: Any, geometry: Geometry) -> None:
        self.c, self.geometry = ffi.gc(c_grid, lib.ost_grid_free), geometry
        self.owner: Any = None


class _Bone:
    def __init__(self, voxels: np.ndarray, geometry: Geometry, chunk_size: int, threshold: int) -> None:
        self.voxels, self.geometry, self.chunk_size, self.threshold = voxels, geometry, chunk_size, threshold
        self.owner: Any = None


class _Tool:
    def __init__(self, voxels: np.ndarray, geometry: ToolGeometry) -> None:
        self.voxels, self.geometry = voxels, geometry
        self.voxels.flags.writeable = False
        self.owner: Any = None


_waiting: Dict[str, _Instance] = {}  # instances that are being opened, by the text of the plugin's options
_numbers = itertools.count()
_lock = threading.Lock()


def _object(pointer_: Any) -> Any:
    return ffi.from_handle(ffi.cast("void *", pointer_))


def _slot(function: Callable[..., None]) -> Callable[..., None]:
    """Makes a function a slot of the table. An exception becomes a status and a line of text.

    The exception itself becomes the cause of the OsteonError that the call of the library raises.
    """
    def slot(*arguments: Any) -> int:
        try:
            function(*arguments[:-1])
            return int(lib.OST_PLUGIN_OK)
        except BaseException as error:  # pylint: disable=broad-except  # no exception may leave a slot
            errors.pending.error = error
            line = " ".join(f"{type(error).__name__}: {error}".split()).encode()[:arguments[-1].text_size - 1]
            ffi.memmove(arguments[-1].text, line + b"\0", len(line) + 1)
            status = error.status if isinstance(error, OsteonError) else Status.INTERNAL
            return int(_STATUSES.get(status, lib.OST_PLUGIN_FAILED))
    ffi.def_extern(name="osteon_py" + function.__name__)(slot)
    return function


def _drop(pointer_: Any) -> None:
    _object(pointer_).owner.handles.pop(pointer_)


for _name in ("grid_free", "bone_free", "tool_free"):
    ffi.def_extern(name="osteon_py_" + _name)(_drop)


def _geometry(g: Any) -> Geometry:
    return Geometry(tuple(g.dims), tuple(g.spacing_pm), tuple(g.origin_pm))


def _tool_geometry(g: Any) -> ToolGeometry:
    return ToolGeometry(tuple(g.dims), g.voxel_pm, tuple(g.corner_pm))


# ------------------------------------------------------------------ instance and grids


@_slot
def _open(options: Any, _host: Any, out: Any) -> None:
    instance = _waiting[ffi.string(options).decode()]
    out[0] = instance.give(instance, "ost_plugin_instance *")


@ffi.def_extern()
def osteon_py_close(self: Any) -> None:
    """Frees an instance."""
    _object(self).handles.clear()


@_slot
def _finish(_self: Any) -> None:
    pass  # every slot is complete when it returns


@_slot
def _grid_create(self: Any, geometry: Any, out: Any) -> None:
    instance, made = _object(self), ffi.new("ost_grid **")
    call(lib.ost_grid_create, instance.inner._c, _geometry(geometry)._c(), made)
    out[0] = instance.give(_Grid(made[0], _geometry(geometry)), "ost_plugin_grid *")


@_slot
def _grid_upload(grid: Any, z0: int, count: int, voxels: Any) -> None:
    call(lib.ost_grid_upload, _object(grid).c, z0, count, voxels)


@_slot
def _grid_download(grid: Any, z0: int, count: int, voxels: Any) -> None:
    call(lib.ost_grid_download, _object(grid).c, z0, count, voxels)


@_slot
def _ct_to_rect(rect: Any, samples: Any, report: Any) -> None:
    names = [name for name, _ in ffi.typeof("ost_scatter_report").fields]
    counts = ffi.new("ost_scatter_report *", {name: getattr(report, name) for name in names})
    try:
        call(lib.ost_ct_to_rect, _object(rect).c, ffi.cast("ost_sample *", samples.sample), samples.count,
             samples.first_line, samples.duplicates, counts)
    finally:
        for name in names:
            setattr(report, name, getattr(counts, name))


@_slot
def _rect_to_cubic(rect: Any, cubic: Any, rule: int, out: Any) -> None:
    grid, made = _object(rect), ffi.new("ost_grid **")
    call(lib.ost_rect_to_cubic, grid.c, cubic.spacing_pm[0], rule, made)
    out[0] = grid.owner.give(_Grid(made[0], _geometry(cubic)), "ost_plugin_grid *")


# ------------------------------------------------------------------ bones


@_slot
def _cubic_to_chunks(cubic: Any, chunk_size: int, threshold: int, out: Any) -> None:
    grid = _object(cubic)
    voxels = np.empty(grid.geometry.shape, np.int16)
    call(lib.ost_grid_download, grid.c, 0, grid.geometry.dims[2], pointer(voxels, "int16_t *", writable=True))
    voxels[voxels < threshold] = 0
    out[0] = grid.owner.give(_Bone(voxels, grid.geometry, chunk_size, threshold), "ost_plugin_bone *")


@_slot
def _bone_create(self: Any, geometry: Any, chunk_size: int, threshold: int, out: Any) -> None:
    grid = _geometry(geometry)
    out[0] = _object(self).give(_Bone(np.zeros(grid.shape, np.int16), grid, chunk_size, threshold),
                                "ost_plugin_bone *")


@_slot
def _bone_stats(bone: Any, stats: Any) -> None:
    b = _object(bone)
    active = b.voxels >= b.threshold
    stats.active_voxels = int(np.count_nonzero(active))
    stats.active_chunks = len(np.unique(chunk_numbers(b, np.nonzero(active))))
    stats.chunk_bytes = stats.active_chunks * (b.chunk_size**3 * 2 + b.chunk_size**3 // 8)
    stats.resident_bytes = b.voxels.nbytes


def chunk_numbers(bone: Any, at: Any) -> np.ndarray:
    """Returns the number of the chunk of each voxel (AR-CHK-2); at contains the indices z, y, x."""
    cx, cy, _ = (-(-n // bone.chunk_size) for n in bone.geometry.dims)
    z, y, x = (index // bone.chunk_size for index in at)
    return x + cx * (y + cy * z)


def _slices(bone: Any, count: int, voxels: Any) -> np.ndarray:
    shape = (count,) + bone.geometry.shape[1:]
    size = count * shape[1] * shape[2]
    return array_of(ffi.cast("int16_t *", voxels), size, np.int16, shape)


@_slot
def _bone_upload(bone: Any, z0: int, count: int, voxels: Any) -> None:
    b = _object(bone)
    source = _slices(b, count, voxels)
    b.voxels[z0:z0 + count] = np.where(source >= b.threshold, source, 0)


@_slot
def _bone_download(bone: Any, z0: int, count: int, voxels: Any) -> None:
    b = _object(bone)
    _slices(b, count, voxels)[...] = b.voxels[z0:z0 + count]


# ------------------------------------------------------------------ tools


@_slot
def _voxelize(self: Any, geometry: Any, cutting: Any, noncutting: Any, parity: int, report: Any, out: Any) -> None:
    instance, grid = _object(self), _tool_geometry(geometry)
    parts: List[Snapped] = []
    for mesh in (cutting, noncutting):
        if mesh != ffi.NULL:
            parts.append(Snapped.of(
                grid, mesh.fraction_bits,
                array_of(mesh.vertices, 3 * mesh.vertex_count, np.int32, (-1, 3)) if mesh.vertex_count else
                np.zeros((0, 3), np.int32),
                array_of(mesh.triangles, 3 * mesh.triangle_count, np.uint32, (-1, 3)) if mesh.triangle_count else
                np.zeros((0, 3), np.uint32)))
    tool = instance.inner._voxelize(parts, "parity" if parity else "winding")
    for name, value in tool.report.items():
        setattr(report, name, value)
    out[0] = instance.give(_Tool(tool.voxels().copy(), grid), "ost_plugin_tool *")
    tool.close()


@_slot
def _tool_upload(self: Any, geometry: Any, voxels: Any, out: Any) -> None:
    grid = _tool_geometry(geometry)
    array = array_of(ffi.cast("uint8_t *", voxels), int(np.prod(grid.shape)), np.uint8, grid.shape).copy()
    out[0] = _object(self).give(_Tool(array, grid), "ost_plugin_tool *")


@_slot
def _tool_download(tool: Any, voxels: Any) -> None:
    array = _object(tool).voxels
    ffi.memmove(voxels, ffi.from_buffer(array), array.nbytes)


# ------------------------------------------------------------------ events


def _event_of(event: Any, bone: _Bone, tool: _Tool) -> Event:
    """Returns the event of a slot. The classes have no names in the table of a plugin."""
    maps, memory = [], ffi.cast("char *", event.maps)
    for k in range(event.map_count):
        source = ffi.cast("ost_plugin_map *", memory + k * event.stride)
        made = ffi.new("ost_map *")
        ffi.memmove(made.origin, source.origin, ffi.sizeof(source.origin))
        ffi.memmove(made.column, source.column, ffi.sizeof(source.column))
        made.divisor.low, made.divisor.high = source.divisor.low, source.divisor.high
        ffi.memmove(made.step, source.step, ffi.sizeof(source.step))
        maps.append(Map(made, (tuple(source.box_lo), tuple(source.box_hi))))
    classes = tuple(DensityClass(f"class {c}", event.class_from[c]) for c in range(event.class_count))
    return Event(maps, bone.geometry, tool.geometry, classes)


def _run(bone: _Bone, tool: _Tool, event: Any, report: Any, apply: bool) -> None:
    instance = bone.owner
    if instance.quiet:
        return  # an empty report
    found = _event_of(event, bone, tool)
    after = bone.voxels.copy()
    instance.calls += 1
    instance.last_event, instance.last_bone = found, bone
    touched = instance.function(after, tool.voxels, found)
    if touched is not None and (isinstance(touched, bool) or not isinstance(touched, (int, np.integer)) or
                                touched < 0):
        raise UsageError(f"the function returned {touched!r}; expected the number of touched voxels, or None")
    instance.counts_touched = touched is not None
    add_report(bone, after, [c.border for c in found.classes], report)
    report.touched_voxels = int(touched or 0)
    if apply:
        bone.voxels = after


def add_report(bone: _Bone, after: np.ndarray, borders: List[int], report: Any) -> None:
    """Derives the report of an event from the voxels that became 0 (AR-REM-6, AR-CLS-1)."""
    at = np.nonzero((bone.voxels >= bone.threshold) & (after == 0))
    density = bone.voxels[at].astype(np.int64)
    chunk = chunk_numbers(bone, at)
    kind = np.maximum(np.searchsorted(borders, density, side="right") - 1, 0)
    numbers, place = np.unique(chunk, return_inverse=True)
    rows = place.reshape(-1) * len(borders) + kind
    voxels = np.bincount(rows, minlength=len(numbers) * len(borders)).astype(np.uint32)
    sums = np.zeros(len(numbers) * len(borders), np.int64)
    np.add.at(sums, rows, density)
    for i, number in enumerate(numbers.tolist()):
        part = slice(i * len(borders), (i + 1) * len(borders))
        status = report.add(report.sink, number, voxels[part].tolist(), sums[part].tolist())
        if status != lib.OST_PLUGIN_OK:
            raise UsageError("the report was refused")


@_slot
def _remove(bone: Any, tool: Any, event: Any, report: Any) -> None:
    _run(_object(bone), _object(tool), event, report, True)


@_slot
def _collide(bone: Any, tool: Any, event: Any, report: Any) -> None:
    _run(_object(bone), _object(tool), event, report, False)


class FunctionBackend(Backend):
    """A backend that removes bone by a Python function. All other stages are those of the backend `inner`.

    Parameters
    ----------
    function : callable
        function(bone, tool, event), a RemoveFunction. It changes the int16 array bone [z, y, x] in place: every
        removed voxel becomes 0. tool is a uint8 array [z, y, x], and event is an Event. The function returns the
        number of touched voxels, or None if it does not count them; reports then contain 0 touched voxels.
    inner : str
        The backend of all other stages.

    Notes
    -----
    An exception of the function becomes the cause of the OsteonError that the call raises.

    Examples
    --------
    >>> def remove_nothing(bone, tool, event):
    ...     return None
    >>> with osteon.FunctionBackend(remove_nothing) as backend:              # doctest: +SKIP
    ...     bone = backend.read_bone("bone.nrrd")
    """

    def __init__(self, function: RemoveFunction, inner: str = "cpu") -> None:
        if not callable(function):
            raise UsageError(f"{type(function).__name__}: expected a function(bone, tool, event)")
        if "," in _osteon.__file__:
            raise UsageError(f"{_osteon.__file__}: the name of a plugin must not contain a comma; install the package "
                             "in another folder")
        self._instance = _Instance(function, Backend(inner))
        with _lock:
            key = str(next(_numbers))
            _waiting[key] = self._instance
        try:
            super().__init__(f"plugin:{_osteon.__file__},{key}")
        finally:
            del _waiting[key]
        self.spec = f"function {getattr(function, '__name__', type(function).__name__)}"

    @contextlib.contextmanager
    def _preparing(self) -> Iterator[None]:
        # ost_world_add_tool collides a tool with the bone to read code and data into caches
        self._instance.quiet = True
        try:
            yield
        finally:
            self._instance.quiet = False

    @property
    def counts_touched(self) -> Optional[bool]:
        """True if the function returned the number of touched voxels; None before its first call."""
        return self._instance.counts_touched

    @property
    def calls(self) -> int:
        """Number of calls of the function."""
        return self._instance.calls
