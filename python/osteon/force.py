# SPDX-License-Identifier: Apache-2.0
"""Force feedback: the force and the torque that a tool in contact with bone exerts on the hand.

    Pose of the device --Force.step--> ForceResult: pose of the tool, force, torque
                                            '--tool--> World.step_pose, which removes the bone

Forces are in N and torques in N m, in the bone's frame (LPS); torques are about the tool's origin. Lengths in
parameters are in m, unlike the rest of the package, as in parameter files (docs/reference/force.md).
osteon.Operation combines the force with a world, the motor and the safety layer.

Threads: a Force may be used where its bone may be used: one thread at a time can use a backend and its objects, and
calls of other threads wait. The GIL is released during a step.
"""
import math
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Tuple

from osteon._c import Owned, call, ffi, lib, path_bytes, text
from osteon.bone import Bone
from osteon.errors import RangeError, UsageError, error_of
from osteon.event import Pose
from osteon.tool import Tool

__all__ = ["Force", "ForceKey", "ForceParams", "ForceResult", "rad_s_of"]

Triple = Tuple[float, float, float]

_MODES = {"energy": lib.OST_FORCE_ENERGY, "instant": lib.OST_FORCE_INSTANT}
# The members of ost_safety_params whose names differ from the names in a parameter file.
_SAFETY = {"max_force": "max_force_n", "max_torque": "max_torque_nm", "slew": "slew_n", "ramp": "ramp_s",
           "stale_ticks": "max_ticks_without_sample", "stored_energy": "stored_j"}


class ForceKey(NamedTuple):
    """The description of a parameter: its unit, a sentence with its source, and the accepted range."""

    unit: str
    about: str
    lo: float
    hi: float


def _keys() -> Dict[str, ForceKey]:
    found = {}
    for index in range(lib.ost_force_key_count()):
        key = lib.ost_force_key_at(index)
        found[text(key.name)] = ForceKey(text(key.unit), text(key.about), key.lo, key.hi)
    return found


def rad_s_of(rpm: float) -> float:
    """Converts revolutions per minute to rad/s."""
    return rpm * 2 * math.pi / 60


class ForceParams:
    """Parameters of the force and of the safety layer. They do not change after they are made.

    Parameters
    ----------
    mode : {"energy", "instant"}
        The force law.
    **values : float
        Values by the names of a parameter file, for example stiffness=200; ForceParams.KEYS lists all names, and
        docs/reference/force.md describes them. Parameters that are not given have their default values.

    Raises
    ------
    UsageError
        If a name is unknown.
    RangeError
        If a value is outside the range of its parameter.

    Examples
    --------
    >>> ForceParams(stiffness=200)["stiffness"]
    200.0
    """

    KEYS: Dict[str, ForceKey] = _keys()

    def __init__(self, mode: str = "energy", **values: float) -> None:
        if mode not in _MODES:
            raise UsageError(f"force law {mode!r}: expected energy or instant")
        self._force = ffi.new("ost_force_params *", lib.ost_force_defaults())
        self._safety = ffi.new("ost_safety_params *", lib.ost_safety_defaults())
        self._force.mode = _MODES[mode]
        self.mode = mode
        members = {name for name, _ in ffi.typeof("ost_force_params").fields}
        for name, value in values.items():
            key = self.KEYS.get(name)
            if key is None:
                raise UsageError(f"force parameter {name!r}: expected one of {', '.join(self.KEYS)}")
            if not key.lo <= value <= key.hi:
                raise RangeError(f"force parameter {name}: {value}; expected {key.lo:g} to {key.hi:g} {key.unit}")
            if name in members:
                setattr(self._force, name, float(value))
            elif name in ("stale_ticks", "dead_man"):
                setattr(self._safety, _SAFETY.get(name, name), int(value))
            else:
                setattr(self._safety, _SAFETY.get(name, name), float(value))

    @classmethod
    def read(cls, path: Any, mode: str = "energy") -> "ForceParams":
        """Reads a parameter file, as `osteon sim --force-params` does."""
        made = cls(mode)
        call(lib.ost_force_params_read, path_bytes(path), made._force, made._safety)
        return made

    def density(self, hu: int) -> float:
        """Returns the density, in g/cm3, of bone with a number of Hounsfield units."""
        return float(lib.ost_force_density(self._force, hu))

    def energy(self, hu: int) -> float:
        """Returns the energy, in J/m3, to cut bone with a number of Hounsfield units."""
        return float(lib.ost_force_energy(self._force, hu))

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    @property
    def values(self) -> Dict[str, float]:
        """All values by their names."""
        return {name: float(lib.ost_force_key_value(index, self._force, self._safety))
                for index, name in enumerate(self.KEYS)}


class ForceResult(NamedTuple):
    """The result of a step (ost_force_result in osteon/force.h), before the safety layer.

    Attributes
    ----------
    tool : Pose
        Pose of the tool, which differs from the device's pose in contact.
    force_n, torque_nm : (float, float, float)
        Hand force in N and hand torque in N m.
    axial_n, off_axis_n : float
        Contact force along the tool's axis, positive if it opposes the advance of the tool, and perpendicular to it.
    cutting_nm : float
        Contact torque about the tool's axis.
    power_w : float
        Power used to cut bone.
    shaking_n : float
        Sum of the hand forces of the cutting points, weighted by density.
    touching : int
        Number of points of the tool's surface that touch bone.
    """

    tool: Pose
    force_n: Triple
    torque_nm: Triple
    axial_n: float
    off_axis_n: float
    cutting_nm: float
    power_w: float
    shaking_n: float
    touching: int


class Force(Owned):
    """The force of a bone on tools.

    Parameters
    ----------
    bone : Bone
        The bone, on a backend that can read single voxels: cpu, ref or cl.
    tools : sequence of Tool
        The tools, in the order of the world's tools.
    params : ForceParams, optional
        The parameters.
    rpm : float
        Speed of the motor in revolutions per minute, until motor() changes it.

    Examples
    --------
    >>> felt = force.step(pose)                                              # doctest: +SKIP
    >>> step = world.step_pose(t_ns, felt.tool)                              # doctest: +SKIP
    """

    _closes_first = -1

    def __init__(self, bone: Bone, tools: Iterable[Tool], params: Optional[ForceParams] = None, *,
                 rpm: float = int(lib.OST_RPM_REAMER)) -> None:
        parts: List[Tool] = list(tools)
        self.params = params or ForceParams()
        made = ffi.new("ost_force_params *", self.params._force[0])
        made.speed = rad_s_of(rpm)
        out = ffi.new("ost_force **")
        with bone._lock.held:
            call(lib.ost_force_create, bone._c, made, out)
        super().__init__(out[0], lib.ost_force_free, bone._lock, (bone, parts))
        bone.backend._adopt(self)
        self.bone, self.tools = bone, parts
        with self._lock.held:
            for tool in parts:
                call(lib.ost_force_add_tool, self._c, tool._c)
        self._result, self._pose, self._err = (ffi.new("ost_force_result *"), ffi.new("ost_pose *"),
                                               ffi.new("ost_error *"))

    def step(self, pose: Pose, tool: int = 0, period_s: float = 1e-3) -> ForceResult:
        """Advances a tool by one tick towards the device's pose. No bone is removed.

        Parameters
        ----------
        pose : Pose
            Pose of the device. It includes the rotation of the motor (see motor).
        tool : int
            Index of the tool. In its first step, a tool starts at the device's pose.
        period_s : float
            Duration of the tick in seconds.
        """
        pose.check()
        pose._store(self._pose)
        r = self._result
        with self._lock.held:
            if self.bone.closed:
                raise UsageError("the bone of this Force is closed")
            status = lib.ost_force_step(self._c, tool, self._pose, period_s, r, self._err)
            if status:
                raise error_of(status, self._err)
            return ForceResult(Pose._of_c(r.tool), tuple(r.force_n), tuple(r.torque_nm), r.axial_n, r.off_axis_n,
                               r.cutting_nm, r.power_w, r.shaking_n, r.touching)

    def motor(self, rpm: float, turned_rad: float = 0.0) -> None:
        """Sets the speed of the motor; 0: the tool presses on bone and does not cut.

        Parameters
        ----------
        turned_rad : float
            Angle by which the motor has turned the tool and the device's pose about the tool's z axis since the last
            step.
        """
        with self._lock.held:
            lib.ost_force_motor(self._c, rad_s_of(rpm), turned_rad)

    def set_pose(self, pose: Pose, tool: int = 0) -> None:
        """Sets the pose of a tool, which may differ from the device's pose."""
        pose.check()
        with self._lock.held:
            lib.ost_force_set_pose(self._c, tool, pose._c())
