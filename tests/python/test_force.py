# SPDX-License-Identifier: Apache-2.0
"""Compares the force with a closed form of docs/reference/force.md, and its parameters with those of the command."""
import math
import re

import numpy as np
import pytest

import osteon


def block(backend, hu):
    """Returns a block of bone with a uniform density whose face is at z = 0, and a ball of radius 5 mm as the tool."""
    geometry = osteon.Geometry.of((40, 60, 60), 0.5, (-15, -15, -20))
    bone = backend.bone(osteon.Volume(np.full(geometry.shape, hu, np.int16), geometry))
    n = 23
    z, y, x = (np.indices((n, n, n)) + 0.5) * 0.5 - n * 0.25
    ball = (x * x + y * y + z * z <= 25).astype(np.uint8)
    tool = backend.tool(osteon.ToolVolume(ball, osteon.ToolGeometry((n,) * 3, osteon.pm(0.5), osteon.pm3(-n * 0.25))))
    return bone, tool


def test_coupling_of_tool_that_does_not_cut(backend):
    bone, tool = block(backend, 1000)
    force = osteon.Force(bone, [tool], osteon.ForceParams(stiffness=250), rpm=0)
    top = 5.0
    for step in range(600):  # the hand moves 3 mm into the bone and rests there
        felt = force.step(osteon.Pose.of((0, 0, round(top - min(step, 300) * 0.01, 6))))
    depth_m = (felt.tool.t_pm[2] - osteon.pm(top - 3)) * 1e-12
    assert felt.touching > 0 and depth_m > 2e-3
    assert felt.force_n[2] == pytest.approx(250 * depth_m, rel=0.02)  # K times the depth of the hand
    assert felt.force_n[2] == pytest.approx(felt.axial_n * force.params["scale"], rel=0.02)
    assert max(abs(v) for v in felt.force_n[:2]) < 0.05 * felt.force_n[2]
    assert force.step(osteon.Pose.of((0, 0, 30))).touching == 0


def test_cutting_power_is_energy_per_volume(backend):
    """Tests hemispherical reaming at speed v (docs/reference/force.md). The power is u v pi R^2, and the force is
    2 pi u R v / (mu w) (pi/4 - r0 / 2R). Points nearer to the axis than r0 = 1 mm are treated as 1 mm from the axis."""
    bone, tool = block(backend, 1000)
    params = osteon.ForceParams(density_per_hu=0, density_at_0=1.95, energy=1e6)
    force, world = osteon.Force(bone, [tool], params), osteon.World(bone, [tool])
    powers, forces = [], []
    for step in range(3000):
        felt = force.step(osteon.Pose.of((0, 0, round(5 - step * 0.003, 6))))
        world.step_pose(step * 1_000_000, felt.tool)
        if step >= 2500:
            powers.append(felt.power_w)
            forces.append(felt.axial_n)
    speed = 3e-3  # in m/s; the speed of the hand, which the tool reaches in the steady state
    assert np.mean(powers) == pytest.approx(1e6 * speed * math.pi * 0.005 ** 2, rel=0.1)
    turns = 200 * 2 * math.pi / 60  # rad/s
    assert np.mean(forces) == pytest.approx(2 * math.pi * 1e6 * 0.005 * speed / (0.5 * turns) * (math.pi / 4 - 0.1),
                                            rel=0.05)


def test_parameters_equal_command(tmp_path, command):
    defaults = osteon.ForceParams().values
    printed = command("sim", "--print-force-params", "--device", "sim")
    for name, value in re.findall(r"^(\w+): ([-+.\de]+)", printed, re.M):
        assert defaults[name] == pytest.approx(float(value)), name
    # a parameter that is set by its name must be the parameter that the library reads under this name
    changed = {name: {"dead_man": 2, "stale_ticks": 7}.get(name, min(key.hi, defaults[name] * 1.5 + 1e-3))
               for name, key in osteon.ForceParams.KEYS.items()}
    assert osteon.ForceParams(**changed).values == changed
    (tmp_path / "p.force").write_text("".join(f"{name}: {value!r}\n" for name, value in changed.items()))
    assert osteon.ForceParams.read(tmp_path / "p.force").values == pytest.approx(changed)


def test_errors(tmp_path, backend, scene):
    bone, tool, _ = scene
    with pytest.raises(osteon.RangeError, match="force parameter stiffness: -1; expected 1 to 1e"):
        osteon.ForceParams(stiffness=-1)
    with pytest.raises(osteon.RangeError):
        osteon.ForceParams(energy=math.nan)
    with pytest.raises(osteon.UsageError, match="stifness.*stiffness"):
        osteon.ForceParams(stifness=1)
    with pytest.raises(osteon.UsageError, match="energy or instant"):
        osteon.ForceParams("thesis")
    (tmp_path / "bad.force").write_text("stiffness: many\n")
    with pytest.raises(osteon.InputError, match="bad.force"):
        osteon.ForceParams.read(tmp_path / "bad.force")
    force = osteon.Force(bone, [tool])
    with pytest.raises(osteon.RangeError):
        force.step(osteon.Pose((0, 0, 10**16)))
    with pytest.raises(osteon.UsageError):
        force.step(osteon.Pose(), tool=3)
    backend.close()
    with pytest.raises(osteon.UsageError):
        force.step(osteon.Pose())


def test_density_and_energy():
    """The energy must be energy * (density / reference_density)^2 (docs/reference/force.md)."""
    params = osteon.ForceParams()
    assert params.density(1000) > params.density(300) > 0
    ratio = params.density(1000) / params.density(300)
    assert params.energy(1000) / params.energy(300) == pytest.approx(ratio ** 2)
    assert osteon.ForceParams(energy=2 * params["energy"]).energy(300) == pytest.approx(2 * params.energy(300))
