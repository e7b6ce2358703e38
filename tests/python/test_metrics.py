# SPDX-License-Identifier: Apache-2.0
"""Compares the metrics of an operation with the debrief of the command."""
import numpy as np
import pytest

import osteon
from osteon import metrics, session


@pytest.fixture(scope="module")
def debriefs(tmp_path_factory, inputs, command):
    """Drills a peg hole and reams with the command. Returns the session and the reported metrics of both operations."""
    folder, bone, found = tmp_path_factory.mktemp("debriefs"), inputs / "ct.nrrd", []
    for tool, path in (("peg", "peg-hole"), ("reamer", "glenoid-ream")):
        mesh = osteon.Mesh.read(inputs / f"{tool}.stl")
        shift = osteon.pm3((0, 0, 4))  # the tip is not at the origin of the tool
        osteon.Mesh(mesh.vertices_pm + np.array(shift), mesh.triangles).write_stl(folder / f"{tool}.stl")
        done = command.json("ream", "--bone", bone, "--tool", folder / f"{tool}.stl", "--path", f"builtin:{path}",
                            "--planned", "2.5", "--trigonum", "-53.48,32.56,18.2", "--inferior-angle",
                            "-110.46,21.59,-98.72", "--out", folder / f"{path}.nrrd", "--record",
                            folder / f"{path}.session", "--debrief", folder / f"{path}.html")
        found.append((bone, folder / f"{tool}.stl", folder / f"{path}.session", done["metrics"]))
        bone = folder / f"{path}.nrrd"
    return found


def measured(backend, name, tool_file, session_file):
    bone, tool, recorded = backend.read_bone(name), backend.read_tool(tool_file), session.read(session_file)
    before = bone.download()
    assert session.replay(recorded, osteon.World(bone, [tool])).equal
    plan = metrics.Plan(osteon.Glenoid.of_meta(before.meta), 2.5, osteon.pm3(("-53.48", "32.56", "18.2")),
                        osteon.pm3(("-110.46", "21.59", "-98.72")))
    motion = metrics.Motion.of(recorded.ticks, [tool])
    return metrics.measure(before, bone, plan, motion), metrics.technique(motion, plan), plan


@pytest.mark.parametrize("index", [0, 1])
def test_values_equal_command(backend, debriefs, index):
    *files, expected = debriefs[index]
    made, ways, plan = measured(backend, *files)
    found = {**made.values, "removed_by_class_mm3": made.removed_by_class_mm3}
    found["depth_error_mm"] = found["reach_mm"] - plan.depth_mm
    of_the_page = {"verdict", "grade", "times_aim", "planned_mm"}
    names = set(expected) - of_the_page - {"technique"}
    assert len(names) >= 20 and len(expected["technique"]) >= 12
    for name in names:
        assert found[name] == pytest.approx(expected[name], rel=1e-6, abs=1e-6), name
    for name, value in expected["technique"].items():
        assert ways[name] == pytest.approx(value, rel=1e-6, abs=1e-6), name
    assert (made.values["hole"], made.values["reamed"]) == ((True, False), (False, True))[index]
    assert plan.angles_deg == pytest.approx((expected["version_planned_deg"], expected["inclination_planned_deg"]))


def test_maps(backend, debriefs):
    made, _, plan = measured(backend, *debriefs[1][:3])
    assert made.depth_mm.shape == made.drilled.shape == (81, 81) and made.drilled.dtype == bool
    cut = ~np.isnan(made.depth_mm) & ~np.isnan(made.after_mm)
    assert np.allclose((made.after_mm - made.before_mm)[cut], made.depth_mm[cut], atol=1e-5)
    assert made.values["depth_max_mm"] <= np.nanmax(made.depth_mm) + 1e-5
    hole, _, _ = measured(backend, *debriefs[0][:3])
    assert hole.drilled[36:45, 36:45].all() and not hole.drilled[:10].any() and not made.drilled.any()
    bone = backend.read_bone(debriefs[1][0]).download()
    without = metrics.measure(bone, osteon.Volume.read(str(debriefs[1][2]).replace(".session", ".nrrd")), plan)
    assert not without.values["reamed"] and without.values["removed_mm3"] == made.values["removed_mm3"]
    assert np.array_equal(without.after_mm, made.after_mm, equal_nan=True)


def test_plans_and_errors(backend, inputs):
    bone = backend.read_bone(inputs / "ct.nrrd")
    meta = dict(bone.meta)
    meta.pop("trigonum_mm", None)
    plan = metrics.Plan.of_meta(meta)
    assert plan.depth_mm == 3 and plan.trigonum_pm is None and plan.angles_deg is None
    meta.update(trigonum_mm="-53.48 32.56 18.2", inferior_angle_mm="-110.46 21.59 -98.72")
    assert metrics.Plan.of_meta(meta).trigonum_pm == (-53_480_000_000, 32_560_000_000, 18_200_000_000)
    with pytest.raises(osteon.InputError):
        metrics.measure(bone, bone, plan)
    with pytest.raises(osteon.OsteonError):
        metrics.measure(bone, osteon.phantom.ct("trabecular"), plan)
