# SPDX-License-Identifier: Apache-2.0
"""Tests backends and bones: imports, copies, digests, events, lifetimes and threads."""
import gc
import multiprocessing
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import osteon


def test_lists():
    found = {b["name"]: b for b in osteon.backends()}
    assert found["cpu"]["available"] and found["ref"]["available"]
    assert all(d["available"] or d["reason"] for d in osteon.devices())
    with osteon.Backend("cpu:threads=2") as backend:
        assert backend.name == "cpu" and backend.settings["threads"] == 2


def test_import_equals_command(tmp_path, backend, inputs, command):
    bone = backend.read_bone(inputs / "ct.nrrd", digests=True)
    bone.write(tmp_path / "p.nrrd")
    assert (tmp_path / "p.nrrd").read_bytes() == (inputs / "bone.nrrd").read_bytes()
    reported = command.json("import", inputs / "ct.nrrd", "--out", tmp_path / "c.nrrd")
    assert [s["digest"] for s in bone.imported["stages"]] == [s["sha256"] for s in reported["stages"]]
    assert bone.info.active_voxels == np.count_nonzero(bone.voxels())
    options = dict(cubic_mm="0.6", threshold=200, chunk_size=16, resample="nearest")
    other = backend.read_bone(inputs / "ct.nrrd", crop=((2, 3, 4), (40, 70, 30)), **options)
    other.write(tmp_path / "p2.nrrd")
    command("import", inputs / "ct.nrrd", "--out", tmp_path / "c2.nrrd", "--cubic", "0.6", "--threshold", "200",
            "--chunk", "16", "--resample", "nearest", "--crop", "2:40,3:70,4:30")
    assert (tmp_path / "p2.nrrd").read_bytes() == (tmp_path / "c2.nrrd").read_bytes()


def test_bone_from_memory(backend, inputs):
    volume = osteon.Volume.read(inputs / "ct.nrrd")
    assert backend.bone(volume).digest() == backend.read_bone(inputs / "ct.nrrd").digest()


def test_every_backend_is_equal(inputs):
    digests = set()
    for spec in ("ref", "cpu:isa=scalar,threads=1", "cpu:threads=3"):
        with osteon.Backend(spec) as backend:
            bone = backend.read_bone(inputs / "ct.nrrd")
            tool = backend.read_tool(inputs / "peg.stl")
            path = osteon.Path.builtin("peg-hole", osteon.Glenoid.of_meta(bone.meta), tool).turned()
            osteon.World(bone, [tool]).run(path)
            digests.add(bone.digest())
    assert len(digests) == 1


def test_voxels(backend, inputs):
    bone = backend.read_bone(inputs / "ct.nrrd")
    array = bone.voxels()
    assert array.shape == bone.geometry.shape and array.dtype == np.int16
    out = np.empty((2,) + array.shape[1:], np.int16)
    assert bone.voxels(5, 2, out=out) is out and np.array_equal(out, array[5:7])
    with pytest.raises(osteon.UsageError):
        bone.voxels(out=np.empty((1, 1, 1), np.int16))
    with pytest.raises(osteon.OsteonError):
        bone.voxels(10**6, 1)
    points = np.array([[3, 5, 7], [0, 0, 0], [-1, 0, 0], [20, 40, 44]])
    assert bone.sample(points).tolist() == [array[7, 5, 3], array[0, 0, 0], 0, array[44, 40, 20]]
    copy = bone.copy()
    copy.upload(np.zeros((1,) + array.shape[1:], np.int16), 44)
    assert not copy.voxels(44, 1).any() and np.array_equal(bone.voxels(), array)
    changed = np.argwhere((copy.leaves() != bone.leaves()).any(axis=-1))
    assert len(changed) and set(changed[:, 0]) == {1}  # slice 44 is in the second layer of leaves


def test_remove_and_collide(scene):
    bone, tool, path = scene
    pose = path.poses()[len(path) // 2]
    before = bone.voxels()
    hit = bone.collide(tool, pose)
    assert np.array_equal(bone.voxels(), before) and hit.removed > 0
    report = bone.remove(tool, [pose, pose])
    gone = before[(bone.voxels() == 0) & (before != 0)]
    assert report.same(hit) and report.removed == len(gone) and sum(report.density) == int(gone.sum())
    assert report.chunks["voxels"].sum() == report.removed and sorted(report.chunks["chunk"]) == list(
        report.chunks["chunk"])
    assert bone.overlap(tool, pose) == 0


def test_objects_are_freed_in_order(inputs):
    backend = osteon.Backend()
    bone = backend.read_bone(inputs / "ct.nrrd")
    tool = backend.read_tool(inputs / "peg.stl")
    world = osteon.World(bone, [tool])
    del backend
    gc.collect()
    assert world.step(osteon.Path.of_poses([osteon.Pose()]).ticks[0]).removal
    bone.backend.close()
    assert bone.closed and tool.closed and world.closed
    bone.close()
    for use in (bone.voxels, tool.digest, lambda: world.totals, lambda: world.step_digest):
        with pytest.raises(osteon.UsageError, match="closed"):
            use()


def test_objects_are_freed_after_a_call(backend, inputs):
    """A progress function closes a bone of the backend during an import. The bone must be freed after the import."""
    bones = [backend.read_bone(inputs / "ct.nrrd") for _ in range(2)]
    waiting = []

    def close(stage, share):
        while bones:
            bones.pop().close()
        waiting.append(len(backend._lock.waiting))

    digest = backend.read_bone(inputs / "ct.nrrd", progress=close).digest()
    assert waiting[0] == 2
    with backend.read_bone(inputs / "ct.nrrd") as bone:
        assert bone.digest() == digest
    assert not backend._lock.waiting


def test_objects_that_exist_at_exit():
    code = ("import osteon\nb = osteon.Backend()\nx = b.bone(osteon.phantom.ct('glenoid'))\n"
            "w = osteon.World(x, [b.voxelize(osteon.phantom.tool('peg'))])\nprint(x.info.active_voxels > 0)")
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    assert done.stdout.strip() == b"True"


def test_threads_share_a_backend(scene):
    bone, tool, path = scene
    pose = path.poses()[len(path) // 2]
    expected = bone.collide(tool, pose)
    wrong = []

    def work():
        for _ in range(20):
            if not bone.collide(tool, pose).same(expected):
                wrong.append(1)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_gil_is_released(backend, inputs):
    """Another thread must run during calls of the library, although Python itself never switches threads."""
    ended, counted = threading.Event(), [0]

    def count():
        while not ended.is_set():
            counted[0] += 1
            time.sleep(0.0001)  # releases the GIL

    bone = backend.read_bone(inputs / "ct.nrrd")
    thread = threading.Thread(target=count)
    thread.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    try:
        start, calls = counted[0], 0
        while counted[0] < start + 5 and calls < 2000:
            bone.digest()
            calls += 1
        during = counted[0] - start
    finally:
        sys.setswitchinterval(interval)
        ended.set()
        thread.join()
    assert during >= 5


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_forked_process_is_refused(backend, inputs):
    bone = backend.read_bone(inputs / "ct.nrrd")

    def child(queue):
        try:
            bone.digest()
            queue.put("no error")
        except osteon.UsageError as error:
            queue.put(str(error))

    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(target=child, args=(queue,))
    process.start()
    assert "spawn" in queue.get(timeout=60)
    process.join(60)
    assert process.exitcode == 0
