#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how the cost of an event and the memory of a bone grow, and compares them with a model (docs/log/0.2.md).

    PYTHON bench/python_scaling.py [REPEATS]        the package osteon must be installed

A ball cuts a cube of bone with voxels of 0.47 mm. A fresh event removes the ball's voxels from untouched bone; a steady
event repeats it. The constants of the model come from the two rows marked with *; the other rows test it. Times are the
least of REPEATS (default 21) and include the call from Python, about 3 us. The last column of the first table is the
difference of a fresh and a steady event per removed voxel.
"""
import sys
import time

import numpy as np

import osteon

SPACING_MM = 0.47
VOXEL_MM = 0.5
TURN = (0.8, 0.3, -0.4, 0.33)  # the tool is oblique to the grid of the bone


def cube(backend, side):
    """Makes a solid cube of bone with `side` voxels along each edge, whose first voxel is at 0."""
    geometry = osteon.Geometry((side, side, side), (osteon.pm(str(SPACING_MM)),) * 3, (0, 0, 0))
    return backend.bone(osteon.Volume(np.full((side, side, side), 700, np.int16), geometry))


def ball(backend, diameter_mm):
    """Makes a ball of cutting voxels whose centre is the origin of its frame."""
    side = int(np.ceil(diameter_mm / VOXEL_MM)) + 2
    x = (np.arange(side) - (side - 1) / 2) * VOXEL_MM
    inside = x[:, None, None] ** 2 + x[:, None] ** 2 + x ** 2 <= (diameter_mm / 2) ** 2
    corner = (-osteon.pm(str(VOXEL_MM)) * side // 2,) * 3
    return backend.tool(osteon.ToolVolume(inside.astype(np.uint8),
                                          osteon.ToolGeometry((side, side, side), osteon.pm(str(VOXEL_MM)), corner)))


def timed(step):
    begin = time.perf_counter()
    result = step()
    return (time.perf_counter() - begin) * 1e6, result


def event(start, tool, repeats):
    """Returns the least times in us of a fresh and of a steady event in the middle of the bone, and the voxels that the
    fresh event removes."""
    middle = start.geometry.dims[0] * SPACING_MM / 2
    pose = osteon.Pose.of([f"{middle + 0.1:.3f}"] * 3, TURN)
    fresh, steady, removed = float("inf"), float("inf"), 0
    for _ in range(repeats):
        world = osteon.World(start.copy(), [tool])
        took, result = timed(lambda: world.step_pose(0, pose))
        fresh, removed = min(fresh, took), result.removed
        for tick in range(1, 4):
            steady = min(steady, timed(lambda: world.step_pose(tick * 1000000, pose))[0])
        world.bone.close()
    return fresh, steady, removed


def row(*cells):
    print("".join(f"{cell:>14}" if isinstance(cell, str) else f"{cell:14.1f}" for cell in cells))


def by_size(repeats, threads):
    """The cost of a steady event grows with the ball's surface."""
    print(f"Size of the tool, {threads} thread(s), us: steady = a + b D^2")
    row("D, mm", "steady", "model", "fresh", "removed", "ns per voxel")
    with osteon.Backend(f"cpu:threads={threads}") as backend:
        measured = {}
        for diameter in (6, 12, 18, 24, 36, 48, 64):
            start = cube(backend, int(diameter / SPACING_MM) + 64)
            measured[diameter] = event(start, ball(backend, diameter), repeats)
            start.close()
    fitted = (12, 36)
    a, b = np.linalg.solve([[1, d * d] for d in fitted], [measured[d][1] for d in fitted])
    for d, (fresh, steady, removed) in measured.items():
        row(f"{d}{' *' if d in fitted else ''}", steady, a + b * d * d, fresh, f"{removed:,}",
            f"{(fresh - steady) * 1e3 / removed:.2f}")
    print(f"a = {a:.2f} us, b = {b:.4f} us/mm2\n")


def by_bone(repeats):
    """The cost of a steady event does not depend on the size of the bone. A bone needs 2 bytes for each voxel of a used
    chunk, and a bit for each voxel."""
    print("Size of the bone, ball of 24 mm, 1 thread: steady = constant")
    row("voxels", "steady, us", "MB", "MB, model")
    with osteon.Backend("cpu:threads=1") as backend:
        tool = ball(backend, 24)
        for side in (128, 256, 384, 512):
            start = cube(backend, side)
            steady = event(start, tool, repeats)[1]
            row(f"{side}^3", steady, start.info.resident_bytes * 1e-6, side ** 3 * (2 + 1 / 8) * 1e-6)
            start.close()


def main():
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 21
    with osteon.Backend() as backend:
        settings = backend.settings
    print(f"backend cpu, {settings}; least of {repeats}\n")
    for threads in (1, settings["threads"]):
        by_size(repeats, threads)
    by_bone(repeats)


if __name__ == "__main__":
    main()
