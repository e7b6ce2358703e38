# SPDX-License-Identifier: Apache-2.0
"""Tests sessions that the package records and the command replays, and sessions recorded by the command."""
import numpy as np
import pytest

import osteon
from osteon import session


def test_record_and_replay(tmp_path, scene, command):
    bone, tool, path = scene
    start = bone.copy()
    totals = session.record(osteon.World(bone, [tool]), path, tmp_path / "p.session", sync=False)
    assert totals.ticks == len(path)
    out = command("replay", tmp_path / "p.session")
    assert "are as recorded" in out and bone.digest() in out
    read = session.read(tmp_path / "p.session")
    assert np.array_equal(read.ticks["tick"], path.ticks) and read.missing == "" and read.end_digest == bone.digest()
    assert read.header["bone_sha256"] == start.digest() and read.ticks["removed"].sum() == totals.removed_voxels
    result = session.replay(read, osteon.World(start, [tool]))
    assert result == session.Replay(len(path), True, None, True)
    assert np.array_equal(osteon.Path.read(tmp_path / "p.session").ticks, path.ticks)


def test_replay_of_command_session(tmp_path, inputs, command):
    command("ream", "--bone", inputs / "ct.nrrd", "--tool", inputs / "peg.stl", "--path", "builtin:peg-hole",
            "--out", tmp_path / "c.nrrd", "--record", tmp_path / "c.session")
    with osteon.Backend("ref") as backend:
        world = osteon.World(backend.read_bone(inputs / "ct.nrrd"), [backend.read_tool(inputs / "peg.stl")])
        assert session.replay(tmp_path / "c.session", world).equal
    header = session.read(tmp_path / "c.session").header
    with osteon.Backend() as backend:
        world = osteon.World(backend.read_bone(inputs / "ct.nrrd"), [backend.read_tool(inputs / "peg.stl")])
        mine = session.header_of(world)
    names = [key for key in header if key.startswith(("bone_", "tool_sha256", "config", "load."))]
    assert {key: header[key] for key in names} == {key: mine[key] for key in names}


def test_difference_is_located(tmp_path, scene):
    bone, tool, path = scene
    first = next(number for number, step in enumerate(osteon.World(bone.copy(), [tool]).steps(path)) if step.removed)
    whole = bone.copy()
    session.record(osteon.World(bone, [tool]), path, tmp_path / "p.session", sync=False)
    data = whole.voxels()
    data[data > 0] += 1  # from the first removed voxel on, the densities of the reports differ
    whole.upload(data)
    result = session.replay(tmp_path / "p.session", osteon.World(whole, [tool]))
    assert not result.equal and result.first_difference == first


def test_interrupted_and_damaged_sessions(tmp_path, scene, command):
    bone, tool, path = scene
    world = osteon.World(bone, [tool])
    with session.Recorder(tmp_path / "i.session", session.header_of(world), sync=False) as recorder:
        recorder.note(5, "a note")
        for number, step in enumerate(world.steps(path[:50])):
            recorder.put(path.ticks[number], step, world.step_digest)
        assert recorder.state["put"] == 51
    read = session.read(tmp_path / "i.session")
    assert len(read.ticks) == 50 and read.end_digest is None and read.missing and read.notes == [(5, "a note")]
    whole = (tmp_path / "i.session").read_bytes()
    (tmp_path / "d.session").write_bytes(whole[:-100])
    assert len(session.read(tmp_path / "d.session").ticks) < 50
    session.repair(tmp_path / "d.session", tmp_path / "r.session")
    command("info", tmp_path / "d.session", "--repair", tmp_path / "c.session")
    assert (tmp_path / "r.session").read_bytes() == (tmp_path / "c.session").read_bytes()
    assert np.array_equal(session.read(tmp_path / "r.session").ticks, session.read(tmp_path / "d.session").ticks)
    (tmp_path / "n.session").write_bytes(b"nothing")
    with pytest.raises(osteon.InputError):
        session.read(tmp_path / "n.session")
    with pytest.raises(osteon.OsteonError):
        session.Recorder(tmp_path / "none" / "x.session", {})
