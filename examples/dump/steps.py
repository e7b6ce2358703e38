#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes the steps before the voxels of exported cases and writes them as a dump.

    osteon validate --export-cases cases --only steps/
    steps.py cases my-dump
    osteon compare my-dump

This program implements sections 9, 11 and 12 of docs/spec/arithmetic.md with Python's integers, which have
any width. It needs only Python 3.9. The rows of path.csv already contain the rotation of a motor.
docs/spec/dumps.md describes the files.
"""
import csv
import hashlib
import json
import os
import struct
import sys
from fractions import Fraction

VERTICES_MAX = 65536  # maximum number of vertices in a snap file


def rhe(numerator, denominator=1):
    """Returns the nearest integer, or the even one of two equally near integers (AR-INT-2)."""
    return round(Fraction(numerator, denominator))  # Python rounds halves to even


# ------------------------------------------------------------------ section 9: snapping


def read_obj(name):
    """Returns the vertices and the triangles of an exported OBJ, whose vertices are integers."""
    vertices, triangles = [], []
    with open(name, encoding="ascii") as file:
        for line in file:
            fields = line.split()
            if fields[0] == "v":
                vertices.append([int(c) for c in fields[1:]])
            elif fields[0] == "f":
                triangles.append([int(c) - 1 for c in fields[1:]])
    return vertices, triangles


def tool_grid(meshes, s):
    """Returns the dims and the corner of the grid around all meshes (AR-TOOL-2)."""
    used = [v[i] for v, triangles in meshes for t in triangles for i in t]
    corner = [rhe(2 * min(c) - s, 2 * s) * s - s for c in zip(*used)]
    far = [rhe(2 * max(c) + s, 2 * s) * s + s for c in zip(*used)]
    return [(b - a) // s for a, b in zip(corner, far)], corner


def snap(mesh, dims, corner, s):
    """Returns a mesh of snap-N.json and its vertices (AR-MESH-3, AR-MESH-4, AR-DIG-7)."""
    vertices, triangles = mesh
    f = max(n for n in range(11) if max(dims) << n <= 1 << 20)
    used = {i for t in triangles for i in t}
    snapped = [[rhe((c - o) << f, s) for c, o in zip(v, corner)] if i in used else [0, 0, 0]
               for i, v in enumerate(vertices)]
    kept = []
    for t in triangles:
        v0, v1, v2 = (snapped[i] for i in t)
        a, b = [q - p for p, q in zip(v0, v1)], [q - p for p, q in zip(v0, v2)]
        if any(a[i - 2] * b[i - 1] != a[i - 1] * b[i - 2] for i in range(3)):
            kept.append(t)
    digest = hashlib.sha256(struct.pack("<8sI3iq3qiQQQ", b"OSTEONM1", 2, *dims, s, *corner, f, len(snapped),
                                        len(kept), len(triangles) - len(kept)))
    for v in snapped:
        digest.update(struct.pack("<3i", *v))
    for t in kept:
        digest.update(struct.pack("<3I", *t))
    return {"dims": dims, "voxel_pm": s, "corner_pm": corner, "fraction_bits": f, "vertices": len(snapped),
            "triangles": len(kept), "dropped_triangles": len(triangles) - len(kept),
            "sha256": digest.hexdigest()}, snapped


# -------------------------------------------------------------- section 11: the sweep


def norm(q):
    return sum(c * c for c in q)


def rotation(q):
    """Returns the matrix M of AR-POSE-4. M divided by norm(q) is the rotation."""
    w, x, y, z = q
    return [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]


def image(pose, c):
    """Returns the position of a corner at a pose (AR-SWEEP-1)."""
    t, q = pose[:3], pose[3:]
    return [rhe(sum(m * v for m, v in zip(row, c)), norm(q)) + t[a] for a, row in enumerate(rotation(q))]


def pose_count(a, b, tool, s):
    """Returns the number of poses from a to b, or None if the motion is refused (AR-SWEEP-2, AR-SWEEP-3)."""
    p = sum(x * y for x, y in zip(a[3:], b[3:]))
    if 2 * p * p < norm(a[3:]) * norm(b[3:]):
        return None
    most = 0
    for k in range(8):
        c = [o + (k >> i & 1) * tool["dims"][i] * tool["voxel"] for i, o in enumerate(tool["corner"])]
        most = max(most, sum((y - x) ** 2 for x, y in zip(image(a, c), image(b, c))))
    n = 1
    while n <= 4096 and n * n * s * s < 4 * most:
        n += 1
    return n if n <= 4096 else None


def pose_between(a, b, k, n):
    """Returns pose k of n (AR-SWEEP-4)."""
    if sum(x * y for x, y in zip(a[3:], b[3:])) < 0:
        b = b[:3] + [-c for c in b[3:]]
    return [rhe((n - k) * x + k * y, n) for x, y in zip(a, b)]


def events(ticks, world, tools, s):
    """Yields for each tick whether it is refused, and the poses of its event (AR-MOTOR-5 to AR-SWEEP-6)."""
    period, before, event_time, begin = world["removal_period_ns"], None, 0, {}
    for tick in ticks:
        restarts = before is None or tick["tool"] != before["tool"] or tick["lifted"]
        turned = 0 if before is None else max(tick["rpm"], 0) * (tick["t_ns"] - before["t_ns"])
        turns = {tool: (pose, turn + turned) for tool, (pose, turn) in begin.items()}
        due = tick["rpm"] != 0 and (restarts or period == 0 or before["rpm"] == 0
                                    or tick["t_ns"] // period != event_time // period)
        poses, b = None, tick["pose"]
        if due and (restarts or not world["sweep"]):
            poses = [b]
        elif due:
            a, turn = turns[tick["tool"]]
            n = pose_count(a, b, tools[tick["tool"]], s) if turn <= 60 * 10**9 // 4 else None
            if n is None:  # a refused tick does not change the world
                yield True, None
                continue
            poses = [b] if n == 1 else [pose_between(a, b, k, n) for k in range(1, n + 1)]
        begin = turns
        if poses or tick["rpm"] == 0:
            begin[tick["tool"]] = b, 0
        if poses:
            event_time = tick["t_ns"]
        before = tick
        yield False, poses


def pairs(ticks, world, tools, s):
    """Yields the same as events for a case with the member "bone", in which each sweep begins at the previous tick."""
    for before, tick in zip([None] + ticks, ticks):
        a, b, n = None, tick["pose"], 1
        if before and before["tool"] == tick["tool"] and not tick["lifted"] and world["sweep"]:
            a = before["pose"]
            n = pose_count(a, b, tools[tick["tool"]], s)
        yield n is None, n and ([b] if n == 1 else [pose_between(a, b, k, n) for k in range(1, n + 1)])


# ---------------------------------------------------------------- section 12: the map


def pose_of(pose, bone, tool):
    """Returns a pose of steps-N.json (AR-MAP-1 to AR-MAP-5)."""
    t, m, n = pose[:3], rotation(pose[3:]), norm(pose[3:])
    s, one = bone["spacing"], 1 << 20
    divisor = n * tool["voxel"]
    column = [[one * m[b][a] * s for a in range(3)] for b in range(3)]
    origin = [one * (sum(m[b][a] * (bone["origin"][b] - t[b]) for b in range(3)) - n * tool["corner"][a])
              for a in range(3)]
    bases = []
    for first in zip(*((0, d // 2 // 16 * 16, (d - 1) // 16 * 16) for d in bone["dims"])):
        base = [rhe(origin[a] + sum(first[b] * column[b][a] for b in range(3)), divisor) for a in range(3)]
        bases.append(base if all(-2**29 <= u < 2**30 + 2**29 for u in base) else None)
    return {"pose": pose, "divisor": str(divisor), "origin": [str(v) for v in origin],
            "column": [[str(v) for v in row] for row in column],
            "step": [[rhe(v, divisor) for v in row] for row in column], "base": bases}


# -------------------------------------------------------------------------- files


def bone_grid(case):
    """Returns the bone's grid (AR-CUB-1). Cases of the family "steps" already contain it."""
    if "bone" in case:
        grid = case["bone"]
        return {"dims": grid["dims"], "spacing": grid["spacing_pm"][0], "origin": grid["origin_pm"]}
    ct, c = case["ct"], case["ct"]["cubic_pm"]
    return {"dims": [-(-n * s // c) for n, s in zip(ct["dims"], ct["spacing_pm"])], "spacing": c,
            "origin": [o + rhe(c - s, 2) for o, s in zip(ct["origin_pm"], ct["spacing_pm"])]}


def read_path(name):
    """Returns the ticks of path.csv (AR-POSE-2, AR-PATH-3)."""
    ticks = []
    with open(name, encoding="ascii") as file:
        for row in csv.DictReader(file):
            ticks.append({"t_ns": rhe(Fraction(row["t_s"]) * 10**9), "tool": int(row.get("tool", 0)),
                          "lifted": row["lifted"] == "1", "rpm": int(row["rpm"]),
                          "pose": [rhe(Fraction(row[c]) * 10**9) for c in ("x_mm", "y_mm", "z_mm")]
                                  + [rhe(Fraction(row[c]) * 2**30) for c in ("qw", "qx", "qy", "qz")]})
    return ticks


def write(folder, name, value):
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        json.dump(value, file)


def run_case(source, folder):
    with open(os.path.join(source, "case.json"), encoding="ascii") as file:
        case = json.load(file)
    os.makedirs(folder)
    tools = []
    for i, facts in enumerate(case["tools"]):
        dims, corner, s = facts["dims"], facts["corner_pm"], facts["voxel_pm"]
        names = [os.path.join(source, f"tool-{i}{part}-raw.obj") for part in ("", "-noncutting")]
        meshes = [read_obj(name) for name in names if os.path.exists(name)]
        if meshes:
            if not facts["grid_given"]:
                dims, corner = tool_grid(meshes, s)
            snapped = [snap(mesh, dims, corner, s) for mesh in meshes]
            write(folder, f"snap-{i}.json", {"meshes": [mesh for mesh, _ in snapped],
                                             "vertices": snapped[0][1][:VERTICES_MAX]})
        tools.append({"dims": dims, "corner": corner, "voxel": s})
    if not case["ticks"]:
        return
    bone, ticks = bone_grid(case), read_path(os.path.join(source, "path.csv"))
    of_ticks = pairs if "bone" in case else events
    for i, (refused, poses) in enumerate(of_ticks(ticks, case["world"], tools, bone["spacing"])):
        write(folder, f"steps-{i}.json",
              {"refused": refused, "removal": poses is not None, "t_ns": ticks[i]["t_ns"], "rpm": ticks[i]["rpm"],
               "pose": ticks[i]["pose"],
               "poses": [pose_of(pose, bone, tools[ticks[i]["tool"]]) for pose in poses or []]})


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: steps.py CASES DUMP")
    with open(os.path.join(sys.argv[1], "cases.json"), encoding="ascii") as file:
        cases = json.load(file)
    for case in cases["cases"]:
        run_case(os.path.join(sys.argv[1], case["folder"]), os.path.join(sys.argv[2], case["folder"]))
    write(sys.argv[2], "dump.json", {"osteon_dump": 1, "program": "examples/dump/steps.py", "tier": cases["tier"],
                                     "seed": cases["seed"], "only": cases["only"],
                                     "arithmetic": cases["arithmetic"]})


main()
