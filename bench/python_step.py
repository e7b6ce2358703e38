#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the calls of World.step from Python, and their overhead.

    PYTHON bench/python_step.py [REPEATS]        the package osteon must be installed

The path reams a generated glenoid. The overhead of a call is the time of a tick in which the tool is far from the bone,
so that the library does almost nothing; the time within the library is part of it. The time of a tick in the command is
run_ms / ticks of `osteon ream`, which executes the same ticks without Python. Prints the best of REPEATS (default 5).
The last line is one run of the same path in real time, a thousand ticks a second.
"""
import json
import os
import subprocess
import sys
import tempfile
import time

import osteon
from osteon.cases import command


def best(repeats, prepare, run):
    """Returns the least time of run(prepare()) in microseconds per tick."""
    least = float("inf")
    for _ in range(repeats):
        world, path = prepare()
        begin = time.perf_counter()
        run(world, path)
        least = min(least, (time.perf_counter() - begin) / len(path))
        world.bone.close()
    return least * 1e6


def by_step(world, path):
    step = world.step
    for tick in path.ticks:
        step(tick)


def by_pose(world, ticks):
    step_pose = world.step_pose
    for t_ns, pose, rpm in ticks:
        step_pose(t_ns, pose, rpm=rpm)


def by_run(world, path):
    world.run(path)


def by_operation(world, poses):
    tick = osteon.Operation(world).tick
    for pose in poses:
        tick(pose)


def in_real_time(world, path):
    """Executes a tick at each millisecond. Returns the times of the calls in microseconds, and the late ticks."""
    times, late, begin = [], 0, time.perf_counter()
    for number, tick in enumerate(path.ticks):
        due = begin + number * 1e-3
        wait = due - time.perf_counter()
        if wait > 0:
            time.sleep(wait)
        start = time.perf_counter()
        late += start > due + 1e-3
        world.step(tick)
        times.append((time.perf_counter() - start) * 1e6)
    return sorted(times), late


def main():
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    ct = osteon.phantom.ct("glenoid")
    with osteon.Backend() as backend, tempfile.TemporaryDirectory() as folder:
        start = backend.bone(ct)
        tool = backend.voxelize(osteon.phantom.tool("reamer"))
        near = osteon.Path.builtin("glenoid-ream", osteon.Glenoid.of_meta(ct.meta), tool).turned()
        far = osteon.Path(near.ticks.copy())
        far.ticks["t_pm"] += osteon.pm(500)
        start.write(os.path.join(folder, "bone.nrrd"))
        tool.write(os.path.join(folder, "tool.nrrd"))

        def world(path):
            return lambda: (osteon.World(start.copy(), [tool]), path)

        hand = osteon.Path.builtin("glenoid-ream", osteon.Glenoid.of_meta(ct.meta), tool)
        far_hand = osteon.Path(hand.ticks.copy())
        far_hand.ticks["t_pm"] += osteon.pm(500)
        poses = [(int(t["t_ns"]), pose, int(t["rpm"])) for t, pose in zip(near.ticks, near.poses())]
        far_poses = [(int(t["t_ns"]), pose, int(t["rpm"])) for t, pose in zip(far.ticks, far.poses())]
        in_command = min(json.loads(subprocess.run(
            [command(), "ream", "--bone", os.path.join(folder, "bone.nrrd"), "--tool",
             os.path.join(folder, "tool.nrrd"), "--path", "builtin:glenoid-ream", "--out",
             os.path.join(folder, "out.nrrd"), "--json", "--quiet"],
            stdout=subprocess.PIPE, check=True).stdout)["run_ms"] for _ in range(repeats)) * 1e3 / len(near)
        print(f"{len(near)} ticks, backend {backend.spec} {backend.settings}; best of {repeats}")
        print(f"{'':24}{'far: us/call':>14}{'reaming: us/call':>18}{'calls/s':>10}")
        for name, run, far_path, near_path in (("World.step", by_step, far, near),
                                               ("World.step_pose", by_pose, far_poses, poses),
                                               ("World.run, per tick", by_run, far, near),
                                               ("Operation.tick, force", by_operation, far_hand.poses(),
                                                hand.poses())):
            away, cutting = best(repeats, world(far_path), run), best(repeats, world(near_path), run)
            print(f"{name:24}{away:14.2f}{cutting:18.2f}{1e6 / cutting:10.0f}")
        print(f"{'the command, per tick':24}{'':14}{in_command:18.2f}{1e6 / in_command:10.0f}")
        times, late = in_real_time(*world(near)())
        print(f"1 kHz: a call takes {times[len(times) // 2]:.0f} us median, {times[len(times) * 99 // 100]:.0f} us at "
              f"99 %, {times[-1]:.0f} us at most; {late} of {len(times)} ticks began more than 1 ms late")


if __name__ == "__main__":
    main()
