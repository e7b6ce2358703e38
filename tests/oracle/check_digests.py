#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes the digests that every campaign checks, with the oracle's implementation of AR-DIG.

The two grids are described in the comment in validation/common/golden.c.

Covers: AR-DIG-2, AR-DIG-3, AR-DIG-4, AR-DIG-5
"""
import os
import re
import sys
from types import SimpleNamespace

sys.dont_write_bytecode = True
from osteon_oracle import KIND_BONE, KIND_TOOL, grid_digest

MM = 10**9


def grid(dims, spacing, origin, voxels, threshold):
    return SimpleNamespace(dims=dims, spacing=spacing, origin=origin, voxels=voxels, threshold=threshold,
                           index=lambda i, j, k: i + dims[0] * (j + dims[1] * k))


def main():
    densities = [100 + i % 1000 for i in range(65 * 33)]
    bone = grid((65, 1, 33), (MM, MM, MM), (MM, -2 * MM, 3 * MM), [d if d >= 120 else 0 for d in densities], 120)
    classes = [(i + i // 33) % 3 for i in range(33 * 34 * 33)]
    tool = grid((33, 34, 33), (MM, MM, MM), (-MM, 0, 2 * MM), classes, 0)
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "../../validation/common/golden.c"), encoding="utf-8") as f:
        stated = dict(re.findall(r'(bone|tool)_expected\[\] = "([0-9a-f]{64})"', f.read()))
    made = {"bone": grid_digest(bone, KIND_BONE), "tool": grid_digest(tool, KIND_TOOL)}
    for name, digest in made.items():
        print(f"{name} {digest}")
        if stated.get(name) != digest:
            print(f"golden.c contains {stated.get(name)} for the {name}")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
