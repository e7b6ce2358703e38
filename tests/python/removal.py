# SPDX-License-Identifier: Apache-2.0
"""Removal of bone in numpy, written from docs/spec/arithmetic.md alone: sections 12 (the map) and 13 (removal).

The parameters of `removal` make deliberate mistakes.
"""
import math
from fractions import Fraction

import numpy as np


def half_even(numerator, denominator):
    """RHE of AR-INT-2; round() of a Fraction rounds halves to even."""
    return round(Fraction(numerator, denominator))


def half_up(numerator, denominator):
    """Makes a deliberate mistake: rounds a tie up."""
    return math.floor(Fraction(numerator, denominator) + Fraction(1, 2))


def coordinates(bone_shape, m, rhe):
    """Returns u_a of every voxel, [a][z, y, x], as AR-MAP-3 and AR-MAP-4 define it."""
    blocks = [-(-n // 16) for n in bone_shape]
    base = np.empty(blocks + [3], np.int64)
    for z, y, x in np.ndindex(*blocks):
        for a in range(3):
            exact = m.origin[a] + 16 * (x * m.column[0][a] + y * m.column[1][a] + z * m.column[2][a])
            # The base of a far block is limited, so that it fits int64. The block is outside of the tool in any case.
            base[z, y, x, a] = max(-2**40, min(2**40, rhe(exact, m.divisor)))
    step = [[rhe(m.column[b][a], m.divisor) for a in range(3)] for b in range(3)]
    z, y, x = np.ogrid[tuple(slice(n) for n in bone_shape)]
    for a in range(3):
        of_block = base[z // 16, y // 16, x // 16, a]
        yield of_block + x % 16 * step[0][a] + y % 16 * step[1][a] + z % 16 * step[2][a]


def removal(rhe=half_even, lost_layers=0, lower_border=False, removes_touched=False):
    """Returns a function for osteon.check.

    Parameters
    ----------
    rhe : callable
        The rounding of base and step.
    lost_layers : int
        Number of layers at the end of the tool's grid that are not read.
    lower_border : bool
        True if a coordinate on a border belongs to the voxel below it.
    removes_touched : bool
        True if noncutting voxels cut too.
    """
    def remove(bone, tool, event):
        active = bone > 0
        hit, met = np.zeros_like(active), np.zeros_like(active)
        for m in event.maps:
            i, j, k = ((u - lower_border) >> 20 for u in coordinates(bone.shape, m, rhe))
            nz, ny, nx = tool.shape
            inside = ((0 <= i) & (i < nx) & (0 <= j) & (j < ny) & (0 <= k) & (k < nz - lost_layers))
            found = np.zeros(bone.shape, np.uint8)
            found[inside] = tool[k[inside], j[inside], i[inside]]
            hit |= active & ((found == 1) | (removes_touched & (found == 2)))
            met |= active & (found == 2)
        bone[hit] = 0
        return int((met & ~hit).sum())
    return remove
