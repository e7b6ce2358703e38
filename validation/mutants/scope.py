# SPDX-License-Identifier: Apache-2.0
"""The files that are mutated, and the backends on which a campaign can find their mutants."""
import os
import re

FOLDERS = ["src/core", "src/cpu", "src/cl"]

# Files of these folders that determine no voxel value of a campaign. Only the test suite can find faults in them.
OUTSIDE = {
    "src/core/clock.h": "time stamps",
    "src/core/decimal.c": "numbers of text files",
    "src/core/face_mesh.c": "meshes of visible faces, for pictures",
    "src/core/face_mesh.h": "meshes of visible faces, for pictures",
    "src/core/file.c": "reading files",
    "src/core/file.h": "reading files",
    "src/core/fit.c": "spheres and planes of landmarks",
    "src/core/fit.h": "spheres and planes of landmarks",
    "src/core/length.c": "lengths of text files",
    "src/core/memory_stream.c": "streams into memory of texts",
    "src/core/memory_stream.h": "streams into memory of texts",
    "src/core/mesh_facts.c": "volume and open edges of a mesh",
    "src/core/meta.c": "facts that travel with a grid",
    "src/core/motor.c": "the motor of the simulator's tools",
    "src/core/motor_table.h": "the motor of the simulator's tools",
    "src/core/path.c": "paths that are read from files",
    "src/core/pose_doubles.c": "poses for pictures, forces and devices",
    "src/core/printable.c": "text of messages",
    "src/core/printable.h": "text of messages",
    "src/core/shortest.c": "numbers of text files",
    "src/core/shortest.h": "numbers of text files",
    "src/core/status.c": "text of messages",
    "src/core/unsupported.c": "text of messages",
    "src/cl/absent.c": "builds without OpenCL",
    "src/cl/api.c": "a table of functions",
    "src/cl/api.h": "a table of functions",
    "src/cl/cache.c": "the cache of built programs",
    "src/cl/cache.h": "the cache of built programs",
    "src/cl/embedded.h": "declarations",
    "src/cl/error.c": "text of messages",
    "src/cl/error.h": "text of messages",
    "src/cl/face_mesh.c": "meshes of visible faces, for pictures",
    "src/cl/facts.c": "descriptions of devices",
    "src/cl/icd.c": "descriptions of drivers",
    "src/cl/kernels/face_mesh.cl": "meshes of visible faces, for pictures",
    "src/cl/key.c": "the cache of built programs",
    "src/cpu/face_mesh.c": "meshes of visible faces, for pictures",
    "src/cpu/face_mesh.h": "meshes of visible faces, for pictures",
    "src/cpu/ref/face_mesh.c": "meshes of visible faces, for pictures",
}


def files(source):
    """Returns all sources in scope, sorted."""
    out = []
    for top in FOLDERS:
        for folder, _, names in os.walk(os.path.join(source, top)):
            out += [os.path.relpath(os.path.join(folder, n), source) for n in names if n.endswith((".c", ".h", ".cl"))]
    return sorted(out)


def is_kernel(file):
    return file.startswith("src/cl/kernels/")


def is_shared(file):
    """Returns true if the reference and every other backend run the file's code."""
    return file.startswith("src/core/")


def subjects(file, available):
    """Returns all backends of a tier that run a file's code, beginning with those that are most likely to find a fault.

    A mutant has survived a tier only if it was run on all of these backends.
    """
    def those(*patterns):
        return list(dict.fromkeys(s for p in patterns for s in available if re.fullmatch(p, s)))

    if file in OUTSIDE or "/arm/" in file and not any("isa=neon" in s for s in available):
        return []
    cpus = ("cpu:isa=.*grain=1.*", "cpu:.*")
    if is_shared(file):
        return those("cpu:isa=(avx2|neon),threads=[2-9].*", *cpus)
    if file.startswith("src/cpu/ref/"):
        return ["ref"]
    if is_kernel(file):
        # An OpenCL device that is a CPU uses the kernel set for CPUs by default.
        mine, gpus = "cl:(?!.*kernels=gpu).*", "cl:.*kernels=gpu.*"
        return those(mine) if file.endswith("_cpu.cl") else those(gpus, mine)
    if file.startswith("src/cl/"):
        return those("cl:(?!.*kernels=gpu).*", "cl:.*")
    if "embree" in file:
        return those("cpu:voxelizer=embree.*")
    isa = re.search(r"_(avx2|avx512|neon)\.c$", file)
    if not isa:
        return those("cpu:isa=scalar,.*grain=1.*" if file.endswith("scalar.c") else cpus[0], *cpus)
    # An instruction set uses the functions of the next lower set that it does not replace (src/cpu/kernels.c). A backend
    # without a named set uses the last set.
    above = {"avx2": "avx2|avx512.*", "avx512": "avx512.*", "neon": "neon"}[isa.group(1)]
    return those(f"cpu:isa={isa.group(1)},.*grain=1.*", f"cpu:isa={isa.group(1)},.*", f"cpu:isa=({above}),.*", "cpu:(?!isa=).*")


def tests(file, programs):
    """Returns the test programs for a file, beginning with those for the file's own part."""
    base = re.sub(r"_(avx2|avx512|neon|scalar)$", "", os.path.splitext(os.path.basename(file))[0])
    wanted = ("tests/cl/", "tests/core/", "tests/cpu/", "tests/ref/", "tests/simd/", "tests/mesh/", "tests/api/", "tests/oracle/", "tests/validation/")
    if not file.startswith("src/cl/"):
        wanted = wanted[1:]
    part = "tests/" + file.split("/")[1] + "/"
    found = [p for p in programs if p.startswith(wanted) and "/.libs/" not in p]
    return sorted(found, key=lambda p: (base not in os.path.basename(p), not p.startswith(part), p))
