# SPDX-License-Identifier: Apache-2.0
"""Tests sessions as pandas frames, HDF5 and MCAP. The files are read by the libraries of these formats."""
import json
import sys

import numpy as np
import pytest

import osteon
from osteon import session

EVENTS, POSES = "physics_data/intermittent_data/", "physics_data/continuous_data/high_frequency_poses/"


@pytest.fixture
def recorded(tmp_path, scene):
    """Returns a session of a peg hole with a note and with a force in some ticks, the bone before it, and the tool."""
    bone, tool, path = scene
    start, world = bone.copy(), osteon.World(bone, [tool])
    with session.Recorder(tmp_path / "s.session", session.header_of(world), sync=False) as recorder:
        recorder.note(7_000_000, 'a "note"')
        for number, step in enumerate(world.steps(path)):
            recorder.put(path.ticks[number], step, world.step_digest)
        recorder.finish(world.totals, bone.digest())
    made = session.read(tmp_path / "s.session")
    made.ticks["force_un"][10:20] = (1_500_000, -2, 0)
    made.ticks["torque_unm"][15] = (0, 0, -3_000_000)
    made.ticks["buttons"][12] = 5
    return made, start, tool


def test_frame(recorded):
    pytest.importorskip("pandas")
    made, _, _ = recorded
    frame = made.frame()
    assert len(frame) == len(made.ticks) and frame["removed"].sum() == made.ticks["removed"].sum() > 0
    for name, letters in (("t_pm", "xyz"), ("q30", "wxyz")):
        columns = frame[[f"{name}_{letter}" for letter in letters]].to_numpy()
        assert np.array_equal(columns, made.ticks["tick"][name])
    assert np.array_equal(frame[["force_un_x", "force_un_y", "force_un_z"]].to_numpy(), made.ticks["force_un"])
    assert frame["digest"].dtype == np.uint64 and frame["t_ns"].iloc[-1] == made.ticks["tick"]["t_ns"][-1]


def test_hdf5(tmp_path, recorded):
    h5py = pytest.importorskip("h5py")
    made, start, tool = recorded
    ticks = made.ticks
    made.write_hdf5(tmp_path / "s.hdf5")
    with h5py.File(tmp_path / "s.hdf5", "r") as file:
        pose = file[POSES + "drill_pose/pose"][:]
        assert np.array_equal(np.rint(pose[:, :3] * 1e12).astype(np.int64), ticks["tick"]["t_pm"])
        assert np.array_equal((pose[:, [6, 3, 4, 5]] * 2**30).astype(np.int32), ticks["tick"]["q30"])
        assert np.allclose(file[POSES + "drill_pose/time_stamp"][:] * 1e9, ticks["tick"]["t_ns"], atol=0.5)
        assert file[POSES + "anatomy_pose/pose"][:].tolist() == [[0, 0, 0, 0, 0, 0, 1]]
        wrench = file[EVENTS + "drill_force_feedback/wrench"][:]
        assert wrench.shape == (10, 6) and wrench[5].tolist() == [1.5, -2e-6, 0, 0, 0, -3]
        assert np.array_equal(file[EVENTS + "drill_force_feedback/time_stamp"][:], ticks["tick"]["t_ns"][10:20] / 1e9)
        assert file[EVENTS + "burr_change/tool"][:].tolist() == [0]
        removed = file[EVENTS + "voxels_removed/voxel_count"][:]
        assert np.array_equal(removed, ticks["removed"][ticks["removed"] > 0])
        assert file[EVENTS + "voxels_removed/voxel_removed"].shape == (0, 4)
        spacing = [float(v) for v in made.header["bone_spacing_mm"].split(",")]
        assert file["metadata_v3/voxel_volume"][()] == pytest.approx(np.prod(spacing))
        assert file["metadata_v3/voxel_volume"].attrs["units"].startswith("mm^3")
        assert f"bone_sha256: {start.digest()}\n" in file["metadata_v3/osteon_session"].asstr()[()]
        vision = file["vision_data/continuous_data"]
        assert (np.diff(vision["time"][:]) >= 0.02 - 1e-9).all() and len(vision["time"]) > len(ticks) // 25
        for name in ("drill", "volume"):
            assert vision["pose_mastoidectomy_" + name].shape == (len(vision["time"]), 7)
        assert len(file["vision_data/intermittent_data"]) == 0
    assert sorted(item.name for item in tmp_path.iterdir()) == ["s.hdf5", "s.session"]


def test_hdf5_with_voxels(tmp_path, recorded):
    h5py = pytest.importorskip("h5py")
    made, start, tool = recorded
    before, after = start.voxels(), start.copy()
    made.write_hdf5(tmp_path / "v.hdf5", osteon.World(after, [tool]))
    with h5py.File(tmp_path / "v.hdf5", "r") as file:
        voxels = file[EVENTS + "voxels_removed"]
        rows, colors, count = (voxels[name][:] for name in ("voxel_removed", "voxel_color", "voxel_count"))
        assert np.array_equal(count, made.ticks["removed"][made.ticks["removed"] > 0])
        assert np.array_equal(np.bincount(rows[:, 0].astype(int)), count)
        assert np.array_equal(voxels["voxel_time_stamp"], made.ticks["tick"]["t_ns"][made.ticks["removed"] > 0] / 1e9)
        x, y, z = rows[:, 1:].astype(int).T
        assert np.array_equal(before[z, y, x] // 8, colors[:, 1]) and (colors[:, 4] == 255).all()
        before[z, y, x] = 0
        assert np.array_equal(before, after.voxels())
    data = start.voxels()
    data[data > 0] += 1
    start.upload(data)
    with pytest.raises(osteon.DifferError, match="tick"):
        made.write_hdf5(tmp_path / "w.hdf5", osteon.World(start, [tool]))
    with pytest.raises(osteon.FileError, match="none"):
        made.write_hdf5(tmp_path / "none" / "w.hdf5")
    made.header["note"] = "\0"  # h5py refuses this text, after the file was opened
    with pytest.raises(ValueError):
        made.write_hdf5(tmp_path / "w.hdf5")
    assert sorted(item.name for item in tmp_path.iterdir() if item.is_file()) == ["s.session", "v.hdf5"]


def test_mcap(tmp_path, recorded):
    reader = pytest.importorskip("mcap.reader")
    made, start, _ = recorded
    ticks = made.ticks
    ticks["tick"]["t_ns"] -= 4_000_000_000  # times before 0 are shifted
    made.write_mcap(tmp_path / "s.mcap")
    found = {}
    with open(tmp_path / "s.mcap", "rb") as file:
        opened = reader.make_reader(file, validate_crcs=True)
        for schema, channel, message in opened.iter_messages():
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            content, required = json.loads(message.data), json.loads(schema.data)["required"]
            assert sorted(content) == sorted(required)
            found.setdefault(channel.topic, (schema.name, []))[1].append((message.log_time, content))
        facts = {record.name: record.metadata for record in opened.iter_metadata()}["osteon session"]
    assert facts["bone_sha256"] == start.digest() and facts["mcap.time_shift_ns"] == str(-ticks["tick"]["t_ns"][0])
    assert {topic: name for topic, (name, _) in found.items()} == {
        "/tool/pose": "foxglove.PoseInFrame", "/tick": "osteon.Tick", "/device/wrench": "osteon.Wrench",
        "/note": "foxglove.Log"}
    poses = found["/tool/pose"][1]
    position = [[content["pose"]["position"][k] for k in "xyz"] for _, content in poses]
    assert np.array_equal(np.rint(np.array(position) * 1e12).astype(np.int64), ticks["tick"]["t_pm"])
    turn = [[content["pose"]["orientation"][k] for k in "wxyz"] for _, content in poses]
    assert np.array_equal((np.array(turn) * 2**30).astype(np.int32), ticks["tick"]["q30"])
    times = [time for time, _ in poses]
    assert np.array_equal(times, ticks["tick"]["t_ns"] - ticks["tick"]["t_ns"][0])
    assert times == [c["timestamp"]["sec"] * 10**9 + c["timestamp"]["nsec"] for _, c in poses]
    rows = [content for _, content in found["/tick"][1]]
    assert [row["removed"] for row in rows] == ticks["removed"].tolist() and rows[12]["buttons"] == 5
    assert int(rows[-1]["digest"], 16) == ticks["digest"][-1] and rows[0]["rpm"] == ticks["tick"]["rpm"][0]
    assert [content["force"] for _, content in found["/device/wrench"][1]] == [{"x": 1.5, "y": -2e-6, "z": 0}] * 10
    assert found["/device/wrench"][1][5][1]["torque"]["z"] == -3
    assert [content["message"] for _, content in found["/note"][1]] == ['a "note"']


def test_empty_session(tmp_path, scene):
    bone, tool, _ = scene
    with session.Recorder(tmp_path / "e.session", session.header_of(osteon.World(bone, [tool])), sync=False):
        pass
    made = session.read(tmp_path / "e.session")
    for module, write in (("h5py", made.write_hdf5), ("mcap", made.write_mcap)):
        pytest.importorskip(module)
        write(tmp_path / "e.out")
        assert (tmp_path / "e.out").stat().st_size > 0


@pytest.mark.parametrize("module, name", [("h5py", "write_hdf5"), ("mcap.writer", "write_mcap"), ("pandas", "frame")])
def test_missing_packages_are_named(tmp_path, recorded, monkeypatch, module, name):
    monkeypatch.setitem(sys.modules, module, None)
    arguments = [] if name == "frame" else [tmp_path / "x"]
    with pytest.raises(osteon.UnavailableError, match=r"pip install osteon\["):
        getattr(recorded[0], name)(*arguments)
    assert not (tmp_path / "x").exists()


def test_csv(tmp_path, scene, command):
    bone, tool, path = scene
    session.record(osteon.World(bone, [tool]), path, tmp_path / "s.session", sync=False)
    session.write_csv(tmp_path / "s.session", tmp_path / "a.csv")
    command("export", tmp_path / "s.session", "--out", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    with pytest.raises(osteon.OsteonError):
        session.write_csv(tmp_path / "a.csv", tmp_path / "c.csv")
