# SPDX-License-Identifier: Apache-2.0
"""Tests poses, paths and worlds."""
import numpy as np
import pytest

import osteon


def test_poses():
    pose = osteon.Pose.of(("1.5", 0, -2), (0.8, 0, 0.6, 0))
    assert pose.t_pm == (1_500_000_000, 0, -2_000_000_000)
    assert pose.q30 == (858993459, 0, 644245094, 0)  # the example of AR-MAP-7
    assert np.allclose(osteon.Pose.of_matrix(pose.matrix_mm()).matrix_mm(), pose.matrix_mm(), atol=1e-8)
    with pytest.raises(osteon.UsageError):
        osteon.Pose.of_matrix(np.eye(3))
    with pytest.raises(osteon.RangeError):
        osteon.Pose(q30=(0, 0, 0, 0)).check()


def test_map_equals_example_of_specification():
    bone = osteon.Geometry((300, 300, 300), (470_000_000,) * 3, (-57_340_000_000, -54_755_000_000, 0))
    tool = osteon.ToolGeometry((74, 74, 42), 500_000_000, (-18_500_000_000, -18_500_000_000, -500_000_000))
    found = osteon.Map.of(osteon.Pose((12_000_000_000, -7_500_000_000, 30_250_000_000),
                                      (858993459, 0, 644245094, 0)), bone, tool)
    assert found.divisor == 576460751873926758500000000
    assert found.origin == (34000796832371564562559795200000000, -34762661917118460467698728960000000,
                            -90108978398322049941535457280000000)
    assert found.column[0] == (159094637945952872326758400000000, 0, 545467329344448482236170240000000)
    assert found.step.tolist() == [[275985, 0, 946235], [0, 985661, 0], [-946235, 0, 275985]]
    assert found.block_base((9, 6, 4)) == (38164811, 34319892, -2393270)
    u = found.affine @ (149, 103, 75, 1) * 2**20
    assert np.allclose(u, (29136152.168, 41219522.56, 5373742.288), atol=0.01)


def test_paths(tmp_path, scene, command):
    _, tool, path = scene
    assert path.ticks.dtype == osteon.TICK and (np.diff(path.ticks["t_ns"]) > 0).all()
    path.write_csv(tmp_path / "p.csv")
    again = osteon.Path.read(tmp_path / "p.csv")
    assert np.array_equal(again.ticks, path.ticks) and again.report["rows"] == len(path)
    assert len(path[3:7]) == 4
    poses = path.poses()[:5]
    made = osteon.Path.of_poses(poses, rpm=200)
    assert np.array_equal(made.ticks["t_pm"], path.ticks["t_pm"][:5]) and made.ticks["t_ns"].tolist() == [
        0, 10**6, 2 * 10**6, 3 * 10**6, 4 * 10**6]
    with pytest.raises(osteon.UsageError):
        osteon.Path(np.zeros(3))
    with pytest.raises(osteon.UsageError, match="glenoid-ream"):
        osteon.Path.builtin("nothing", osteon.Glenoid((0, 0, 0), (1, 0, 0), "right"), tool)


def test_glenoids():
    glenoid = osteon.Glenoid.of((-117.8, "196.5", -159), (1, 0, 0))
    assert glenoid.at_pm == (-117_800_000_000, 196_500_000_000, -159_000_000_000) and glenoid.side == "right"
    with pytest.raises(osteon.InputError):
        osteon.Glenoid.of((0, 0, 0), (1, 0, 0), "left")
    with pytest.raises(osteon.UsageError):
        osteon.Glenoid.of_meta({})


def test_steps_and_totals(scene):
    bone, tool, path = scene
    before = bone.voxels()
    world = osteon.World(bone, [tool])
    steps = [world.step(tick) for tick in path.ticks]
    totals = world.totals
    assert totals.ticks == len(path) and totals.removed_voxels == sum(s.removed for s in steps) > 0
    assert totals.poses == sum(s.poses for s in steps) and totals.removed_voxels == sum(totals.removed_by_class)
    assert totals.removed_voxels == np.count_nonzero(before) - np.count_nonzero(bone.voxels())
    other = osteon.World(bone.backend.bone(osteon.Volume(before, bone.geometry)), [tool])
    for number, pose in enumerate(path.poses()):
        step = other.step_pose(int(path.ticks["t_ns"][number]), pose, rpm=int(path.ticks["rpm"][number]),
                               lifted=bool(path.ticks["lifted"][number]))
        assert step == steps[number]
    assert other.bone.digest() == bone.digest()


def test_report_is_that_of_last_step(scene):
    bone, tool, path = scene
    world = osteon.World(bone, [tool])
    assert world.report is None
    for step in world.steps(path):
        assert world.report.removed == step.removed
        if step.removed:
            break
    assert world.report.by_class == world.totals.removed_by_class
    assert [c.name for c in world.classes] == ["cartilage", "cancellous", "cortical"]


def test_refused_ticks_change_nothing(scene):
    bone, tool, path = scene
    world = osteon.World(bone, [tool])
    world.step(path.ticks[0])
    digest, totals = bone.digest(), world.totals
    far = path.ticks[1].copy()
    far["q30"] = (0, 1 << 30, 0, 0)
    with pytest.raises(osteon.RangeError):
        world.step(far)
    with pytest.raises(osteon.UsageError):
        world.step(path.ticks["t_ns"][0])
    assert bone.digest() == digest and world.totals == totals


def test_options(scene):
    bone, tool, path = scene
    copy = bone.copy()
    coarse = osteon.World(copy, [tool], sweep=False, removal_period_ns=50_000_000, classes=[("soft", 1), ("hard", 500)])
    totals = coarse.run(path)
    assert totals.poses == totals.removals < totals.ticks and len(totals.removed_by_class) == 2
    seen = []
    osteon.World(bone, [tool]).run(path, progress=lambda number, step: seen.append(number) or number < 9)
    assert seen == list(range(10))
    with pytest.raises(osteon.UsageError):
        osteon.World(bone, [tool], classes=[("a", 5), ("b", 5)])


def test_ream_equals_command(tmp_path, inputs, command):
    """The file written by the example of docs/guide/python.md must equal the file of the command."""
    facts = osteon.Volume.read(inputs / "ct.nii.gz").meta
    at, axis = facts["glenoid_at_mm"].split(), [float(v) for v in facts["glenoid_axis"].split()]
    backend = osteon.Backend()
    bone = backend.read_bone(inputs / "ct.nii.gz")
    tool = backend.read_tool(inputs / "reamer.stl")
    glenoid = osteon.Glenoid.of(at, axis, "right")
    path = osteon.Path.builtin("glenoid-ream", glenoid, tool).turned(rpm=200)
    osteon.World(bone, [tool]).run(path)
    bone.write(tmp_path / "p.nrrd")
    command("ream", "--bone", inputs / "ct.nii.gz", "--tool", inputs / "reamer.stl", "--path", "builtin:glenoid-ream",
            "--at", ",".join(at), "--axis", ",".join(str(v) for v in axis), "--side", "right",
            "--out", tmp_path / "c.nrrd")
    assert (tmp_path / "p.nrrd").read_bytes() == (tmp_path / "c.nrrd").read_bytes()


def test_pressing_paths(scene, backend, inputs):
    bone, tool, _ = scene
    glenoid = osteon.Glenoid.of_meta(bone.meta)
    for count in (1, 500):
        assert len(osteon.Path.press(glenoid, tool, count)) == count
    whole = osteon.Path.builtin("glenoid-press", glenoid, tool.geometry, 3)
    same = osteon.Path.press(glenoid, tool.geometry, len(whole), 3)
    assert np.array_equal(same.ticks, whole.ticks) and (same.ticks["tool"] == 3).all()
    with pytest.raises(osteon.OsteonError):
        osteon.Path.press(glenoid, tool, 10**9)


def test_sweeps(scene):
    """A sweep must remove the same voxels as World.step and have the same number of poses."""
    bone, tool, path = scene
    ticks = path.ticks[::40]
    again, world, poses = bone.copy(), osteon.World(bone, [tool]), osteon.Path(ticks).poses()
    removed = 0
    for number, tick in enumerate(ticks):
        step = world.step(tick)
        if not step.removal:
            continue
        sweep = poses[number - 1].sweep_to(poses[number], tool.geometry, bone.geometry.spacing_pm[0]) if number else (
            poses[:1])
        assert len(sweep) == step.poses and sweep[-1].t_pm == poses[number].t_pm
        assert again.remove(tool, sweep).removed == step.removed
        removed += step.removed
    assert removed > 100 and again.digest() == bone.digest()
    turned = osteon.Pose.of((0, 0, 0), (0, 1, 0, 0))
    with pytest.raises(osteon.RangeError):
        osteon.Pose().sweep_to(turned, tool.geometry, bone.geometry.spacing_pm[0])


def test_bone_at_glenoid(scene):
    bone, _, _ = scene
    glenoid = osteon.Glenoid.of_meta(bone.meta)
    inward, outward = bone.along_axis(glenoid)
    assert 90 < inward <= 100 and 0 <= outward < 10
    assert bone.in_front(glenoid) == 0
    away = osteon.Glenoid(glenoid.at_pm, tuple(-v for v in glenoid.axis), glenoid.side)
    assert bone.along_axis(away) == pytest.approx((outward, inward), abs=0.5)
    everything, near = bone.in_front(away), bone.in_front(away, 5, 10)
    assert 0 < near < everything <= bone.info.active_voxels


def test_classes():
    text = ",".join(f"{c.name}:{c.border}" for c in osteon.DEFAULT_CLASSES)
    assert osteon.DensityClass.parse(text) == osteon.DEFAULT_CLASSES
    assert osteon.DensityClass.parse("soft:120,hard:650")[1] == ("hard", 650)
    with pytest.raises(osteon.UsageError):
        osteon.DensityClass.parse("hard:650,soft:120")
