# SPDX-License-Identifier: Apache-2.0
"""Reads the NRRD files that osteon writes (docs/spec/arithmetic.md section 16), attached, raw or gzip.

The reader is independent of osteon, so that the comparison uses the file's content and not data
that the same library has written and read back.
"""

import gzip
import struct
from fractions import Fraction

from osteon_oracle import Grid, decimal, length


def read_nrrd(path):
    """Reads a NRRD. Returns (Grid, facts). The origin of a tool's grid is its corner (AR-FILE-3)."""
    with open(path, "rb") as file:
        content = file.read()
    head, blank, body = content.partition(b"\n\n")
    assert blank, "no empty line after the header"
    lines = head.decode("ascii").split("\n")
    assert lines[0] == "NRRD0005", lines[0]
    fields, facts = {}, {}
    for line in lines[1:]:
        if line.startswith("#"):
            continue
        if ":=" in line:
            key, _, value = line.partition(":=")
            assert key.startswith("osteon_"), line
            facts[key[len("osteon_"):]] = value
        else:
            key, _, value = line.partition(": ")
            fields[key] = value
    assert fields["dimension"] == "3" and fields["space"] == "left-posterior-superior", fields
    dims = [int(n) for n in fields["sizes"].split()]
    rows = [[decimal(word)[0] for word in row.strip("()").split(",")] for row in fields["space directions"].split()]
    assert all(rows[a][b] == 0 for a in range(3) for b in range(3) if a != b), "directions are diagonal"
    spacing = [length(rows[a][a]) for a in range(3)]
    origin = [decimal(word)[0] * 10**9 for word in fields["space origin"].strip("()").split(",")]
    if fields["encoding"] == "gzip":
        assert body[:10] == b"\x1f\x8b\x08\x00" + bytes(4) + body[8:10], "gzip with a name or a time"
        body = gzip.decompress(body)
    else:
        assert fields["encoding"] == "raw", fields["encoding"]
    code = {"int16": "h", "uint8": "B"}[fields["type"]]
    voxels = list(struct.unpack(f"<{dims[0] * dims[1] * dims[2]}{code}", body))
    if facts.get("kind") == "tool":
        corner = [length(decimal(word)[0]) for word in facts["tool_corner_mm"].split()]
        assert all(o == c + Fraction(s, 2) for o, c, s in zip(origin, corner, spacing)), "origin is the first centre"
        origin = corner
    return Grid(dims, spacing, [int(o) for o in origin], voxels), facts
