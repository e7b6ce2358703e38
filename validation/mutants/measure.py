# SPDX-License-Identifier: Apache-2.0
"""Determines the outcome of one mutant. The mutant is compiled, compared, linked, and run until a difference is found."""
import os
import shutil
import threading
import time

import build as building
import operators
import scope
from trial import Process, how_it_ended

FIELDS = ["id", "file", "line", "operator", "old", "new", "text", "outcome", "by", "stage", "how", "seconds", "tiers", "commit", "seed"]
KERNELS_AS_C = "tests/cl/test_kernels_as_c"
# Objects that a mutated header can change; the remainder of the program has no effect on results.
PARTS = ("src/core/", "src/cpu/", "src/cl/")


class Measurement:
    def __init__(self, build, campaign, tiers, tests_limit_s=300):
        self.build, self.campaign, self.tiers, self.tests_limit_s = build, campaign, tiers, tests_limit_s
        self.lock = threading.Lock()
        self.test_seconds = {}
        self.note = {} # for each thread, information about a mutant that no tier detected

    def measure(self, m, folder):
        """Returns {"outcome", "by", "stage", "how", "seconds"}. `folder` belongs to the job and is emptied."""
        begun = time.monotonic()
        self.note.pop(threading.get_ident(), None)
        shutil.rmtree(folder, ignore_errors=True)
        scratch, overlay = os.path.join(folder, "run"), os.path.join(folder, "overlay")
        os.makedirs(scratch)
        with open(os.path.join(self.build.source, m.file), newline="") as f:
            text = operators.applied(f.read(), m)
        path = os.path.join(overlay, m.file)
        os.makedirs(os.path.dirname(path))
        with open(path, "w", newline="") as f:
            f.write(text)
        outcome = self._kernel(m, overlay, folder, scratch) if scope.is_kernel(m.file) else self._host(m, overlay, folder, scratch)
        shutil.rmtree(folder, ignore_errors=True)
        if outcome == ("survived",):
            outcome = ("survived", "", "", self.note.get(threading.get_ident(), ""))
        row = dict(zip(("outcome", "by", "stage", "how"), (*outcome, "", "", "", "")[:4]))
        row["seconds"] = f"{time.monotonic() - begun:.1f}"
        return row

    def _host(self, m, overlay, folder, scratch):
        objects = self.build.objects_of(m.file, PARTS)
        if not objects:
            return ("not built here",)
        state, changed = self.build.compile(objects, overlay, folder)
        if state != "differs":
            return (state,)
        program = os.path.join(folder, "osteon")
        if self.build.link("osteon", changed, program)[0] != 0:
            return ("not compiled",)
        # The kernels are not mutated. A device's compiler takes longer for them than all cases, so its cache is shared.
        compiled = os.path.join(self.campaign.work, "pocl")
        os.makedirs(compiled, exist_ok=True)
        os.symlink(compiled, os.path.join(scratch, "pocl"))
        return self._campaign(m, program, scratch) or self._tests(m, changed, folder, scratch)

    def _campaign(self, m, program, scratch):
        for tier in self.tiers:
            if tier == "tests":
                continue
            subjects = scope.subjects(m.file, self.campaign.subjects(tier, scratch))
            if not subjects:
                if m.file not in scope.OUTSIDE:
                    return ("not built here",)
                continue
            if scope.is_shared(m.file):
                found, changed = self.campaign.shared(program, tier, subjects[0], scratch)
                how = "a result changed in all backends" if changed else ""
            else:
                found, how = self.campaign.killed(program, tier, subjects, scratch), ""
            if found and scope.is_kernel(m.file) and found[3] == "exit status 3":
                return ("not compiled",)  # the device's compiler, or its driver, refused the program
            if found:
                return f"killed by {tier}", found[1], found[2], found[3]
            self.note[threading.get_ident()] = how
        return None

    def _tests(self, m, changed, folder, scratch, instead=()):
        if "tests" not in self.tiers:
            return ("survived",)
        for name in scope.tests(m.file, self.build.programs):
            if os.path.basename(name) in ("test_cl_growth", "test_scene"):
                continue
            found = self._test(name, changed, folder, scratch, instead)
            if found:
                return "killed by tests", name, "", found
        return ("survived",)

    def _test(self, name, changed, folder, scratch, instead=()):
        """Returns None if a test passes, otherwise a description of its end."""
        if name not in self.test_seconds:
            with self.lock:
                plain = os.path.join(folder, "plain")
                if self.build.link(name, [], plain)[0] != 0:
                    return None
                begun = time.monotonic()
                status = self._run(plain, scratch, self.tests_limit_s)
                self.test_seconds[name] = None if status != 0 else max(10, 5 * (time.monotonic() - begun))
                os.remove(plain)
        limit = self.test_seconds[name]
        if limit is None:
            return None  # no evidence, because the test also fails or times out without the mutant
        program = os.path.join(folder, "test")
        if self.build.link(name, changed, program, instead)[0] != 0:
            return None
        status = self._run(program, scratch, limit)
        os.remove(program)
        return None if status in (0, 77) else "fails" if status and status > 0 else how_it_ended(status)

    def _run(self, program, scratch, limit):
        process = Process([program], scratch, limit, self.campaign.limits)
        while process.read():
            pass
        return process.end(False)

    def _kernel(self, m, overlay, folder, scratch):
        """Runs a mutated kernel on the device of this machine, then as C. If the C compiler generates equal code, the mutant
        is identical."""
        state, changed = self.build.compile(self.build.objects_of(m.file, ("tests/cl/", *PARTS)), overlay, folder)
        if state != "differs":
            return (state,)
        host = [p for p in changed if not os.path.basename(p).startswith("tests__")]
        embedded = self.build.embedded(overlay, folder)
        program = os.path.join(folder, "osteon")
        if embedded is None or self.build.link("osteon", [*host, embedded], program)[0] != 0:
            return ("not compiled",)
        found = self._campaign(m, program, scratch)
        if found or "tests" not in self.tiers:
            return found or ("survived",)
        instead = [(n, p) for n in self.build.objects if (p := os.path.join(folder, n.replace("/", "__"))) in changed and p not in host]
        how = self._test(KERNELS_AS_C, host, folder, scratch, instead)
        return ("killed by tests", KERNELS_AS_C, "", how) if how else ("survived",)
