# SPDX-License-Identifier: Apache-2.0
"""osteon: bit-exact voxel reaming.

    units, grid, mesh     lengths in picometres, volumes [z, y, x], tool grids, meshes
    backend, bone, tool   voxels in the memory of a backend
    event, world          poses, events, paths, the world and its step
    force, operation      the force on the hand; a world that a device moves, with a motor and a force
    session               record, read and replay sessions
    hashing, differences  digests, and the differences between two grids
    plugin                a Python function as a backend
    cases, checking       a Python function compared with the reference, case by case; findings, locating and
                          minimising are its parts
    segmentation, anatomy the bones of a CT; spheres, and landmarks of a scapula
    metrics               an operation compared with its plan
    pictures, phantom     pictures as arrays, generated bones and tools

Arrays are indexed [z, y, x]; everything else (dims, spacing, origin, points) is in the order x, y, z, in LPS.

Examples
--------
>>> import osteon
>>> backend = osteon.Backend()
>>> bone = backend.bone(osteon.phantom.ct("glenoid"))
>>> tool = backend.voxelize(osteon.phantom.tool("peg"))
>>> path = osteon.Path.builtin("peg-hole", osteon.Glenoid.of_meta(bone.meta), tool).turned(rpm=200)
>>> osteon.World(bone, [tool]).run(path).removed_voxels > 0
True
"""
from osteon import anatomy, metrics, phantom, segmentation, session
from osteon._c import lib as _lib, text as _text
from osteon.backend import Backend, backends, devices
from osteon.bone import Bone, BoneInfo
from osteon.cases import Case, EventCase, campaign_cases, tie_cases
from osteon.checking import check
from osteon.differences import Differences, diff
from osteon.errors import (CancelledError, DifferError, FileError, InputError, InternalError, OsteonError,
                           OutOfMemoryError, RangeError, Status, UnavailableError, UsageError)
from osteon.event import DEFAULT_CLASSES, DensityClass, Event, Map, Pose, Report
from osteon.findings import CaseResult, CheckResult, Finding, Operand
from osteon.force import Force, ForceParams, ForceResult
from osteon.grid import Geometry, Volume
from osteon.hashing import digest, sha256
from osteon.mesh import Mesh, ToolGeometry, ToolVolume
from osteon.operation import Operation
from osteon.pictures import Camera, encode_png, points, render, slices, write_png
from osteon.plugin import FunctionBackend
from osteon.tool import Tool
from osteon.units import PM_PER_MM, mm_text, pm, pm3, to_mm
from osteon.world import RPM_OF_DEVICE, RPM_ON, TICK, Glenoid, Path, Step, Totals, World

__version__ = _text(_lib.ost_version())
ARITHMETIC_VERSION = int(_lib.OST_ARITHMETIC_VERSION)

__all__ = [
    "ARITHMETIC_VERSION", "Backend", "Bone", "BoneInfo", "Camera", "CancelledError", "Case", "CaseResult", "CheckResult", "DEFAULT_CLASSES", "DensityClass",
    "DifferError", "Differences", "Event", "EventCase", "FileError", "Finding", "Force", "ForceParams", "ForceResult", "FunctionBackend", "Geometry", "Glenoid", "InputError", "InternalError", "Map", "Mesh",
    "Operand", "Operation", "OsteonError", "OutOfMemoryError", "PM_PER_MM", "Path", "Pose", "RPM_OF_DEVICE", "RPM_ON", "RangeError", "Report",
    "Status", "Step", "TICK", "Tool", "ToolGeometry", "ToolVolume", "Totals", "UnavailableError", "UsageError",
    "Volume", "World", "anatomy", "backends", "campaign_cases", "check", "devices", "diff", "digest", "encode_png", "metrics", "mm_text", "phantom", "pm", "pm3", "points", "render", "segmentation", "session",
    "sha256", "slices", "tie_cases", "to_mm", "write_png",
]
