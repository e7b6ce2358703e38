# SPDX-License-Identifier: Apache-2.0
"""Compares operations, whose ticks are made by a program or by the servo loop, with those of `osteon sim`."""
import os
import subprocess
import sys
import time

import numpy as np
import pytest

import osteon
from osteon import session

SAME = ["number", "tick", "flags", "buttons", "digest", "removed", "touched", "poses", "fault", "force_un",
        "torque_unm"]  # everything that does not depend on time


@pytest.fixture
def reamer(backend, inputs):
    return backend.read_tool(inputs / "reamer.stl")


def hand(bone, tool, name="glenoid-ream"):
    """Returns a path of the hand. An operation adds the rotation of the motor."""
    return osteon.Path.builtin(name, osteon.Glenoid.of_meta(bone.meta), tool)


def test_loop_equals_command(tmp_path, backend, inputs, reamer, command):
    bone = backend.read_bone(inputs / "ct.nrrd")
    hand(bone, reamer).write_csv(tmp_path / "p.csv")
    command("sim", "--headless", "--bone", inputs / "ct.nrrd", "--tool", inputs / "reamer.stl", "--device",
            "sim:seed=2,tremor=50", "--path", tmp_path / "p.csv", "--no-clock", "--seconds", "2", "--force", "energy",
            "--record", tmp_path / "c.session", "--out", tmp_path / "c.nrrd")
    with osteon.Operation(osteon.World(bone, [reamer]), record=tmp_path / "p.session", device="sim") as operation:
        operation.start(device="sim:seed=2,tremor=50", path=osteon.Path.read(tmp_path / "p.csv"), ticks=2000,
                        clock=False)
        report = operation.wait()
    assert (report.end, report.ticks) == ("ticks", 2000)
    theirs, mine = session.read(tmp_path / "c.session"), session.read(tmp_path / "p.session")
    for name in SAME:
        assert np.array_equal(theirs.ticks[name], mine.ticks[name]), name
    assert np.abs(mine.ticks["force_un"]).max() > 10_000 and mine.ticks["removed"].sum() > 100
    assert mine.end_digest == theirs.end_digest == bone.digest()
    forces = [key for key in theirs.header if key.startswith("force.") and key != "force.max_force_from"]
    assert forces and all(mine.header[key] == theirs.header[key] for key in forces)
    assert "are as recorded" in command("replay", tmp_path / "p.session")


def test_ticks_of_a_program(tmp_path, backend, inputs, reamer, command):
    bone = backend.read_bone(inputs / "ct.nrrd")
    start = bone.copy()
    path = hand(bone, reamer)
    with osteon.Operation(osteon.World(bone, [reamer]), record=tmp_path / "p.session") as operation:
        ticks = [operation.tick(pose) for pose in path.poses()]
        report = operation.report
    read = session.read(tmp_path / "p.session")
    assert [t.removed for t in ticks] == read.ticks["removed"].tolist()
    assert np.array_equal(np.rint(np.array([t.force_n for t in ticks]) * 1e6), read.ticks["force_un"])
    assert [t.pose.t_pm for t in ticks] == [tuple(v) for v in read.ticks["tick"]["t_pm"].tolist()]
    removed = int(((start.voxels() > 0) & (bone.voxels() == 0)).sum())
    assert sum(t.removed for t in ticks) == removed > 1000
    assert report.ticks == len(path) and report.touching_ticks > 100 and report.peak_axial_n > 1
    assert report.peak_n == max(float(np.linalg.norm(t.force_n)) for t in ticks)
    assert "are as recorded" in command("replay", tmp_path / "p.session")


def test_tool_is_at_pose_without_force(backend, inputs, reamer):
    bone = backend.read_bone(inputs / "ct.nrrd")
    other = bone.copy()
    path = hand(bone, reamer)
    with osteon.Operation(osteon.World(bone, [reamer]), force=None) as operation:
        for pose in path.poses():
            assert operation.tick(pose).force_n == (0, 0, 0)
    osteon.World(other, [reamer]).run(path.turned())
    assert bone.digest() == other.digest()


def test_motor_faults_and_drop_outs(backend, inputs, reamer):
    bone = backend.read_bone(inputs / "ct.nrrd")
    digest, poses = bone.digest(), hand(bone, reamer).poses()
    operation = osteon.Operation(osteon.World(bone, [reamer]), motor=False)
    force = max(max(map(abs, operation.tick(pose).force_n)) for pose in poses[:1500])
    assert force > 0.5 and bone.digest() == digest  # the tool presses on bone and does not cut
    t = poses[1499].t_pm
    far = osteon.Pose((t[0], t[1], t[2] + osteon.pm(6)), poses[1499].q30)
    fault = operation.tick(far)
    assert fault.fault == "the pose jumped" and fault.force_n == (0, 0, 0) and fault.removed == 0
    assert operation.tick(osteon.Pose((0, 0, 0), (0, 0, 0, 0))).fault == "the pose turned too far, or is invalid"
    assert operation.tick(poses[1499], tool=1).fault == "there is no such tool"
    assert operation.tick(far, tracked=False).force_n == (0, 0, 0)
    assert operation.tick(far, lifted=True).fault == ""
    report = operation.report
    assert (report.faults, report.fault_ticks, report.dropouts) == (1, 3, 1)
    operation.close()
    with pytest.raises(osteon.UsageError):
        operation.tick(far)
    limited = osteon.Operation(osteon.World(bone, [reamer]), motor=False, force=osteon.ForceParams(max_force=0.1))
    assert 0.09 < max(float(np.linalg.norm(limited.tick(pose).force_n)) for pose in poses[:1500]) <= 0.1


def test_loop_follows_poses(backend, inputs, reamer):
    bone = backend.read_bone(inputs / "ct.nrrd")
    start, path = bone.voxels(), hand(bone, reamer)
    poses = path.poses()
    operation = osteon.Operation(osteon.World(bone, [reamer]), motor=False)
    active = np.zeros(bone.geometry.shape, bool)

    def take():
        for chunk in operation.changes():
            (x, y, z), whole = chunk.first, chunk.active
            to = active[z:z + whole.shape[0], y:y + whole.shape[1], x:x + whole.shape[2]]
            to[...] = whole[:to.shape[0], :to.shape[1], :to.shape[2]]

    take()
    assert np.array_equal(active, start > 0)
    operation.start(poses[0], realtime=False)
    operation.move(poses[0], lifted=True)
    operation.motor = True
    until = time.monotonic() + 60
    for pose in poses[::40]:
        operation.move(pose)
        time.sleep(0.01)
    while operation.state().removed_voxels == 0:  # on a slow machine, the tool arrives later
        assert time.monotonic() < until
        time.sleep(0.01)
    operation.motor = False
    assert operation.running and operation.wait(0) is None
    with pytest.raises(osteon.UsageError, match="running"):
        operation.tick(poses[0])
    report = operation.stop()
    assert report.end == "stopped" and report.ticks > 0 and not operation.running
    state = operation.state()
    take()
    assert np.array_equal(active, bone.voxels() > 0)
    assert state.removed_voxels == int((start > 0).sum() - active.sum()) == operation.world.totals.removed_voxels
    assert state.ticks == report.ticks - 1 or state.ticks == report.ticks


def test_errors(tmp_path, backend, inputs, reamer):
    bone = backend.read_bone(inputs / "ct.nrrd")
    world = osteon.World(bone, [reamer])
    with pytest.raises(osteon.UsageError, match="dead_man"):
        osteon.Operation(world, force=osteon.ForceParams(dead_man=1))
    with pytest.raises(osteon.UsageError, match="rpm"):
        osteon.Operation(world, rpm=10**6)
    operation = osteon.Operation(world)
    with pytest.raises(osteon.UsageError, match="nothing"):
        operation.start(device="nothing")
    with pytest.raises(osteon.UsageError, match="not started"):
        operation.stop()
    with pytest.raises(osteon.UsageError, match="move"):
        operation.move(osteon.Pose())
    with pytest.raises(osteon.RangeError):
        operation.start(osteon.Pose((0, 0, 10**16)))
    operation.tick(osteon.Pose())
    with pytest.raises(osteon.UsageError, match="new Operation"):
        operation.start()


def test_exit_while_loop_runs(inputs):
    """If the program exits while the loop runs, the objects of the backend must be freed after the end of the loop."""
    text = f"""
import osteon
backend = osteon.Backend("cpu:threads=2")
bone, tool = backend.read_bone({str(inputs / 'ct.nrrd')!r}), backend.read_tool({str(inputs / 'reamer.stl')!r})
operation = osteon.Operation(osteon.World(bone, [tool]))
operation.start(realtime=False)
print("runs")
"""
    done = subprocess.run([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=120,
                          universal_newlines=True, check=False, env=dict(os.environ))
    assert (done.returncode, done.stdout, done.stderr) == (0, "runs\n", "")


def test_haptic_devices(command):
    devices = {device["name"]: device for device in osteon.operation.haptic_devices()}
    assert devices["sim"]["available"] and devices["mouse"]["description"]
    assert all(device["available"] or device["reason"] for device in devices.values())
    listed = command("devices")
    for name, device in devices.items():
        assert name in listed and all(button in listed for button in device["buttons"])
