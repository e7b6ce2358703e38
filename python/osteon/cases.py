# SPDX-License-Identifier: Apache-2.0
"""Cases for osteon.check: the inputs of an operation, or of one event.

    osteon validate --export-cases --campaign_cases--> Case      Case.of(bone, tools, path) --> Case
    integers at which a rounding decides a voxel   --tie_cases--> Case
    a difference --minimised--> EventCase --save, load--> file

The command `osteon` generates the cases of a campaign from a seed, so that they are the same on every machine
(docs/spec/dumps.md). A case contains integers only.
"""
import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from osteon._c import call, ffi, lib, text
from osteon.backend import Backend
from osteon.bone import Bone, volume_of
from osteon.errors import InputError, OsteonError, UnavailableError, UsageError
from osteon.event import DEFAULT_CLASSES, DensityClass, Event, Map, Pose
from osteon.grid import Geometry, Volume, pointer
from osteon.mesh import Snapped, ToolGeometry, ToolVolume
from osteon.tool import Tool
from osteon.world import Path

__all__ = ["Case", "EventCase", "campaign_cases", "command", "default_cases", "tie_cases"]


def command() -> str:
    """Returns the `osteon` command: $OSTEON, or the one installed with the library, or the first one in $PATH."""
    installed = os.path.join(os.path.dirname(__file__), text(lib.OSTEON_PY_COMMAND))  # relative only in a wheel
    for name in (os.environ.get("OSTEON"), installed):
        if name and os.path.isfile(name) and os.access(name, os.X_OK):
            return name
    found = shutil.which("osteon")
    if found is None:
        raise UnavailableError("the command osteon was not found, which generates the cases of a campaign; set OSTEON "
                               "to its path, or pass cases of your own")
    return found


@dataclass
class Case:
    """An operation: a bone, tools and a path.

    Attributes
    ----------
    id : str
        Name of the case, such as "poses/0".
    bone : Volume
        Densities of the cubic grid.
    tools : list of ToolVolume
        The tools, numbered from 0.
    path : Path
        The ticks.
    threshold, chunk_size : int
        Properties of the bone.
    sweep, removal_period_ns
        Options of the World.
    """

    id: str
    bone: Volume
    tools: List[ToolVolume]
    path: Path
    threshold: int = 120
    chunk_size: int = 32
    sweep: bool = True
    removal_period_ns: int = 0

    @classmethod
    def of(cls, bone: Any, tools: Sequence[Any], path: Path, *, name: str = "case", **options: Any) -> "Case":
        """Makes a case from a Bone or Volume, tools (Tool or ToolVolume) and a path.

        The spacing of the bone must be equal on all axes. The keywords are the attributes of a case.
        """
        if isinstance(bone, Bone):
            options = {"threshold": bone.threshold, "chunk_size": bone.chunk_size, **options}
        volume = volume_of(bone)
        if len(set(volume.geometry.spacing_pm)) != 1:
            raise UsageError("the spacing of the bone differs between the axes; make a Bone of it first")
        options.setdefault("threshold", int(volume.meta.get("threshold", 120)))
        return cls(name, volume, [t.download() if isinstance(t, Tool) else t for t in tools], path, **options)


@dataclass
class EventCase:
    """One removal event: a bone, a tool and the maps of its poses.

    A difference is minimised to an EventCase, which can be passed to osteon.check again.
    """

    id: str
    bone: Volume
    tool: ToolVolume
    maps: List[Map]
    threshold: int = 120
    chunk_size: int = 32
    classes: Tuple[DensityClass, ...] = field(default=DEFAULT_CLASSES)

    def event(self) -> Event:
        """Returns the event."""
        return Event(self.maps, self.bone.geometry, self.tool.geometry, self.classes)

    def save(self, path: Any) -> None:
        """Writes the case as a JSON file. Only voxels that are not 0 are listed."""
        g, t = self.bone.geometry, self.tool.geometry
        document = {
            "osteon_event": 1, "id": self.id, "threshold": self.threshold, "chunk_size": self.chunk_size,
            "classes": [list(c) for c in self.classes],
            "bone": {"dims": g.dims, "spacing_pm": g.spacing_pm, "origin_pm": g.origin_pm,
                     "voxels": _sparse(self.bone.voxels)},
            "tool": {"dims": t.dims, "voxel_pm": t.voxel_pm, "corner_pm": t.corner_pm,
                     "voxels": _sparse(self.tool.voxels)},
            "maps": [{"divisor": str(m.divisor), "origin": [str(v) for v in m.origin],
                      "column": [[str(v) for v in row] for row in m.column], "step": m.step.tolist()}
                     for m in self.maps]}
        with open(path, "w", encoding="ascii") as file:
            json.dump(document, file, indent=1)
            file.write("\n")

    @classmethod
    def load(cls, path: Any) -> "EventCase":
        """Reads a case that save() wrote."""
        try:
            with open(path, encoding="ascii") as file:
                document = json.load(file)
            b, t = document["bone"], document["tool"]
            geometry = Geometry(tuple(b["dims"]), tuple(b["spacing_pm"]), tuple(b["origin_pm"]))
            grid = ToolGeometry(tuple(t["dims"]), t["voxel_pm"], tuple(t["corner_pm"]))
            geometry.check()
            grid.check()
            maps = [Map.of_integers([int(v) for v in m["origin"]], [[int(v) for v in row] for row in m["column"]],
                                    int(m["divisor"]), m["step"]) for m in document["maps"]]
            return cls(document["id"], Volume(_dense(b["voxels"], geometry.shape, np.int16), geometry),
                       ToolVolume(_dense(t["voxels"], grid.shape, np.uint8), grid), maps, document["threshold"],
                       document["chunk_size"], tuple(DensityClass(*c) for c in document["classes"]))
        except (KeyError, TypeError, IndexError, ValueError) as error:
            if isinstance(error, OsteonError):
                raise
            raise InputError(f"{path}: not a case of one event: {type(error).__name__} {error}") from None


def _sparse(voxels: np.ndarray) -> List[List[int]]:
    """Returns [x, y, z, value] for every voxel that is not 0."""
    z, y, x = np.nonzero(voxels)
    return np.stack([x, y, z, voxels[z, y, x]], axis=1).astype(int).tolist()


def _dense(rows: List[List[int]], shape: Tuple[int, int, int], dtype: Any) -> np.ndarray:
    out = np.zeros(shape, dtype)
    for x, y, z, value in rows:
        if min(x, y, z) < 0:
            raise ValueError(f"voxel {x} {y} {z}")
        out[z, y, x] = value
    return out


# ----------------------------------------------------------------------- ties

_ONE = 1 << Map.FRACTION
_VOXEL_PM = 1000 * _ONE  # with this edge length of a tool voxel, one unit of a tool coordinate is 1000 pm
_AT = 3  # the tool voxel that cuts, and whose upper border the tie decides


def tie_cases() -> Iterator[Case]:
    """Generates cases in which the rounding of a tie decides a voxel. They are rare in cases of random numbers.

    The pose is the identity, so that the tool coordinate of bone voxel i is base + i step on each axis. On one axis,
    voxel 1 is next to the upper border of tool voxel 3, the only one that cuts:

        ties/base-x     base = RHE(m + 1/2) with an even m; rounded up, the voxel would lie behind the border
        ties/step-x     step = RHE(2^20 + 1/2); rounded up, the voxel would lie behind the border
        ties/border-x   the coordinate is on the lower border of tool voxel 3, which contains the border
    """
    for axis, letter in enumerate("xyz"):
        # name, edge length of a bone voxel, exact coordinate of voxel 0 in units of 2^-20, times 1000
        for name, spacing, first in (("base", _VOXEL_PM + 1000, 1000 * (_AT * _ONE - 2) + 500),
                                     ("step", _VOXEL_PM + 500, 1000 * (_AT * _ONE - 1)),
                                     ("border", _VOXEL_PM, 1000 * (_AT - 1) * _ONE)):
            origin = [1000 * (_AT * _ONE - _ONE // 2)] * 3  # voxel 1 is in the middle of tool voxel 3 on other axes
            origin[axis] = first
            x, y, z = origin
            tool = np.zeros((8, 8, 8), np.uint8)
            tool[_AT, _AT, _AT] = lib.OST_TOOL_CUTTING
            yield Case(f"ties/{name}-{letter}",
                       Volume(np.full((4, 4, 4), 1000, np.int16), Geometry((4, 4, 4), (spacing,) * 3, (x, y, z))),
                       [ToolVolume(tool, ToolGeometry((8, 8, 8), _VOXEL_PM, (0, 0, 0)))], Path.of_poses([Pose()]))


def default_cases(only: str = "") -> Iterator[Case]:
    """Generates the cases of osteon.check: tie_cases(), then those of campaign_cases().

    Parameters
    ----------
    only : str
        Beginning of the names of the cases. "ties" needs no command.
    """
    yield from (case for case in tie_cases() if case.id.startswith(only))
    if not only.startswith("ties"):
        yield from campaign_cases(only)


# ------------------------------------------------------------------- campaign


def campaign_cases(only: str = "", *, tier: str = "smoke", seed: int = 1) -> Iterator[Case]:
    """Generates the cases of a campaign that contain an operation, as `osteon validate` and `osteon compare` run them.

    Parameters
    ----------
    only : str
        Beginning of the names of the cases, such as "poses" or "sweep/1".
    tier : {"smoke", "standard", "full"}
        Number and size of the cases.
    seed : int
        The same seed gives the same cases on every machine.

    Raises
    ------
    UnavailableError
        If the command `osteon` is not found.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = os.path.join(scratch, "cases")
        arguments = [command(), "validate", "--export-cases", folder, "--tier", tier, "--seed", str(seed), "--quiet"]
        done = subprocess.run(arguments + (["--only", only] if only else []), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, check=False)
        if done.returncode != 0:
            raise UsageError(f"cases {only!r} of tier {tier!r}: {done.stderr.strip() or 'osteon validate failed'}")
        with open(os.path.join(folder, "cases.json"), encoding="utf-8") as file:
            listed = json.load(file)["cases"]
        for entry in listed:
            case = exported_case(os.path.join(folder, entry["folder"]))
            if case is not None:
                yield case


def exported_case(folder: str) -> Optional[Case]:
    """Reads the folder of an exported case (docs/spec/dumps.md). Returns None if it contains no operation.

    The bone and the tools are made by the reference. Returns None too if the reference refuses the samples.
    """
    with open(os.path.join(folder, "case.json"), encoding="utf-8") as file:
        facts = json.load(file)
    if "ct" not in facts or not facts.get("ticks"):
        return None
    with Backend("ref") as backend:
        ct = facts["ct"]
        try:
            bone = _bone_of(backend, ct, os.path.join(folder, "samples.txt"))
        except OsteonError:
            return None
        tools = [_tool_of(backend, tool, folder) for tool in facts["tools"]]
    path = Path.read(os.path.join(folder, "path.csv"), max_gap_ns=-1, max_jump_pm=-1)
    return Case(facts["id"], bone, tools, path, ct["threshold"], ct["chunk_size"], facts["world"]["sweep"],
                facts["world"]["removal_period_ns"])


def _bone_of(backend: Backend, ct: Dict[str, Any], name: str) -> Volume:
    rows = np.loadtxt(name, dtype=np.float64, ndmin=2)
    samples = np.zeros(len(rows), np.dtype([("x", "<i8"), ("y", "<i8"), ("z", "<i8"), ("density", "<i4"),
                                            ("line", "<u4")]))
    for column, axis in enumerate("xyz"):
        # The decimals have at most nine places and lie within 8,000 mm, so the error of the product is below
        # 0.01 pm, and rounding gives the exact integer.
        samples[axis] = np.rint(rows[:, column] * 1e9)
    samples["density"], samples["line"] = rows[:, 3], np.arange(len(rows))
    rules = {"error": lib.OST_DUPLICATES_ERROR, "first": lib.OST_DUPLICATES_FIRST, "last": lib.OST_DUPLICATES_LAST,
             "max": lib.OST_DUPLICATES_MAX}
    resample = {"linear": lib.OST_RESAMPLE_LINEAR, "nearest": lib.OST_RESAMPLE_NEAREST,
                "thesis": lib.OST_RESAMPLE_THESIS}
    geometry = Geometry(tuple(ct["dims"]), tuple(ct["spacing_pm"]), tuple(ct["origin_pm"]))
    rect, cubic = ffi.new("ost_grid **"), ffi.new("ost_grid **")
    report = ffi.new("ost_scatter_report *")
    try:
        call(lib.ost_grid_create, backend._c, geometry._c(), rect)
        call(lib.ost_ct_to_rect, rect[0], pointer(samples, "ost_sample *"), len(samples), 1, rules[ct["duplicates"]],
             report)
        call(lib.ost_rect_to_cubic, rect[0], ct["cubic_pm"], resample[ct["resample"]], cubic)
        grid = Geometry._of_c(lib.ost_grid_geometry(cubic[0]))
        voxels = np.empty(grid.shape, np.int16)
        call(lib.ost_grid_download, cubic[0], 0, grid.dims[2], pointer(voxels, "int16_t *", writable=True))
    finally:
        lib.ost_grid_free(cubic[0])
        lib.ost_grid_free(rect[0])
    return Volume(voxels, grid)


def _tool_of(backend: Backend, facts: Dict[str, Any], folder: str) -> ToolVolume:
    grid = ToolGeometry(tuple(facts["dims"]), facts["voxel_pm"], tuple(facts["corner_pm"]))
    parts = []
    for key in ("cutting", "noncutting"):
        if key in facts:
            vertices: List[List[int]] = []
            triangles: List[List[int]] = []
            with open(os.path.join(folder, facts[key]), encoding="ascii") as file:
                for line in file:
                    if line.startswith("v "):
                        vertices.append([int(v) for v in line.split()[1:]])
                    elif line.startswith("f "):
                        triangles.append([int(v) - 1 for v in line.split()[1:]])
            parts.append(Snapped.of(grid, facts["fraction_bits"], np.array(vertices, np.int32).reshape(-1, 3),
                                    np.array(triangles, np.uint32).reshape(-1, 3)))
    with backend._voxelize(parts, facts["rule"]) as tool:
        return tool.download()
