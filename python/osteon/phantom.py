# SPDX-License-Identifier: Apache-2.0
"""Generated bones and parametric tools, so that every example runs without patient data.

Threads: the functions share no state.
"""
from typing import Any, Optional

from osteon._c import call, call_with_progress, ffi, lib, progress_handle, text
from osteon.errors import UsageError
from osteon.grid import Progress, Volume
from osteon.mesh import Mesh
from osteon.units import Length, c_pm3, pm, pm3

__all__ = ["ct", "tool"]

_KINDS = {text(lib.ost_phantom_name(kind)): kind for kind in range(lib.OST_PHANTOM_COUNT)}
_TOOLS = {text(lib.ost_tool_kind_name(kind)): kind for kind in range(lib.OST_TOOL_KIND_COUNT)}
_PARTS = {"complete": lib.OST_TOOL_COMPLETE, "head": lib.OST_TOOL_HEAD, "shaft": lib.OST_TOOL_SHAFT}


def ct(kind: str = "scapula", *, seed: int = 1, spacing_mm: Any = None, scale: float = 1.0, left: bool = False,
       progress: Optional[Progress] = None) -> Volume:
    """Generates the CT of a phantom, as `osteon phantom` does.

    Parameters
    ----------
    kind : str
        "scapula", "glenoid", "shoulder", ...; `osteon phantom --help` lists the kinds.
    seed : int
        Seed of the noise. The same seed gives the same grid on every machine.

    Returns
    -------
    Volume
        Volume.meta contains the position and the axis of the glenoid.
    """
    if kind not in _KINDS:
        raise UsageError(f"phantom {kind!r}: expected one of {', '.join(_KINDS)}")
    options = ffi.new("ost_phantom_options *", {"seed": seed, "scale": scale, "left": left})
    if spacing_mm is not None:
        options.spacing = c_pm3(pm3(spacing_mm))
    keep = progress_handle(progress, options)
    memory = ffi.new("ost_volume *")
    call_with_progress(keep, lib.ost_phantom_make, _KINDS[kind], options, memory)
    return Volume._of_c(memory)


def tool(kind: str = "reamer", *, diameter_mm: Optional[Length] = None, length_mm: Optional[Length] = None,
         segments: int = 0, part: str = "complete") -> Mesh:
    """Creates the closed mesh of a tool, as `osteon tool` does.

    Parameters
    ----------
    kind : {"reamer", "peg", "burr"}
        The tool. Its working face points to -z.
    part : {"complete", "head", "shaft"}
        The complete tool, its cutting part or its noncutting part.
    """
    if kind not in _TOOLS:
        raise UsageError(f"tool {kind!r}: expected one of {', '.join(_TOOLS)}")
    if part not in _PARTS:
        raise UsageError(f"part {part!r}: expected one of {', '.join(_PARTS)}")
    options = ffi.new("ost_tool_options *", {"diameter": 0 if diameter_mm is None else pm(diameter_mm),
                                             "length": 0 if length_mm is None else pm(length_mm),
                                             "segments": segments, "part": _PARTS[part]})
    memory = ffi.new("ost_mesh *")
    call(lib.ost_tool_make, _TOOLS[kind], options, memory)
    return Mesh._of_c(memory)
