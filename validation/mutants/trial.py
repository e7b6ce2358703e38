# SPDX-License-Identifier: Apache-2.0
"""Runs a program on the campaign's cases and finds the first difference from the unmutated program.

A backend's trace (validation/trace.h) is read from a pipe and compared,
record by record, with the digests of the trace of the unmutated program. The run
ends at the first difference. Except for their ends, the traces of all backends
are equal byte by byte, so this comparison is equivalent to that of a campaign.

A mutant of code that all backends share changes both sides of that comparison.
Then the campaign itself runs, and its verdict decides.
"""
import hashlib
import json
import os
import re
import resource
import select
import signal
import struct
import subprocess
import threading
import time

from build import LIVE

HEAD = 32


class Limits:
    def __init__(self, memory_mb=8192, least_s=10):
        self.memory, self.least_s = memory_mb << 20, least_s

    def apply(self, seconds):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (self.memory, self.memory))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))


def environment(scratch):
    """Returns the environment of programs under test: separate caches, threads that wait without spinning, one locale."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(("OST_", "MAKE", "MFLAGS"))}
    env.update(LC_ALL="C", OMP_WAIT_POLICY="passive", HOME=scratch, TMPDIR=scratch, XDG_CACHE_HOME=os.path.join(scratch, "cache"),
               POCL_CACHE_DIR=os.path.join(scratch, "pocl"))
    for name in ("XDG_CACHE_HOME", "POCL_CACHE_DIR"):
        os.makedirs(env[name], exist_ok=True)
    return env


class Process:
    """A program in its own process group, with limits. Its output is read from a pipe until a deadline."""

    def __init__(self, command, scratch, cpu_s, limits, trace=False, wall_s=None):
        self.deadline = time.monotonic() + (wall_s if wall_s is not None else 5 * cpu_s + 20)
        read, write = os.pipe()
        command = [w.replace("@TRACE@", f"/dev/fd/{write}") for w in command]
        self.log = open(os.path.join(scratch, "said"), "w+b")
        self.p = subprocess.Popen(command, cwd=scratch, env=environment(scratch), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL if trace else write,
                                  stderr=self.log, pass_fds=(write,) if trace else (), start_new_session=True, preexec_fn=lambda: limits.apply(cpu_s))
        LIVE.add(self.p.pid)
        os.close(write)
        self.pipe, self.late = read, False

    def read(self):
        """Returns the next bytes. They are empty at the end and after the deadline."""
        left = self.deadline - time.monotonic()
        if left <= 0 or not select.select([self.pipe], [], [], left)[0]:
            self.late = True
            return b""
        return os.read(self.pipe, 1 << 20)

    def said(self):
        """Returns the last line of the program's messages."""
        self.log.seek(0)
        lines = self.log.read(1 << 16).decode(errors="replace").strip().splitlines()
        return lines[-1][:200] if lines else ""

    def end(self, kill):
        """Waits for the process, or kills its group. Returns the exit status (negative for a signal), or None after the
        deadline."""
        try:
            if not kill and not self.late:
                try:
                    self.p.wait(max(0.1, self.deadline - time.monotonic()))
                except subprocess.TimeoutExpired:
                    self.late = True
            if kill or self.late:
                os.killpg(self.p.pid, signal.SIGKILL)
                self.p.wait()
        except ProcessLookupError:
            self.p.wait()
        finally:
            LIVE.discard(self.p.pid)
            os.close(self.pipe)
            self.last_line = self.said()
            self.log.close()
        return None if self.late or self.p.returncode == -signal.SIGXCPU else self.p.returncode


def how_it_ended(status):
    """Returns a word for an abnormal end, or None for a normal one."""
    if status is None:
        return "time"
    if status < 0:
        return f"crash: {signal.Signals(-status).name}"
    return f"exit status {status}" if status else None


def stage_names(source):
    """Returns the names of a trace's stages by their numbers, as defined in the measured commit."""
    with open(os.path.join(source, "validation/trace.c"), encoding="utf-8") as f:
        found = re.search(r"stage_names\[TRACE_STAGES\] = \{([^}]*)\}", f.read())
    return re.findall(r'"(\w+)"', found.group(1))


def family_names(source):
    """Returns the families of generated cases in the smoke tier, as listed in the measured commit's plan."""
    with open(os.path.join(source, "validation/plan.c"), encoding="utf-8") as f:
        rows = re.findall(r'\[PLAN_\w+\] = \{"(\w+)",\s*"[^"]*",\s*\{(\d+),', f.read())
    return [name for name, count in rows if int(count) > 0]


def records(process, stages):
    """Yields (head, digest of the body) for each record of a trace, which is read from the process's pipe.

    The end record is omitted: it has the paths that the backend entered and its times, which are not results.
    """
    end = stages.index("end")
    data = b""
    while True:
        while len(data) < HEAD:
            more = process.read()
            if not more:
                return
            data += more
        head, size = data[:HEAD], struct.unpack_from("<Q", data, 16)[0]
        body, data = hashlib.blake2b(digest_size=16), data[HEAD:]
        while size:
            if not data:
                data = process.read()
                if not data:
                    return
            part, data = data[:size], data[size:]
            body.update(part)
            size -= len(part)
        if struct.unpack_from("<I", head, 4)[0] != end:
            yield head, body.digest()


def place(family, head, stages):
    _, stage, case, item = struct.unpack_from("<4sIII", head)
    stage = stages[stage] if stage < len(stages) else str(stage)
    return f"{family}/{case}", stage + (f" {item}" if stage in ("snap", "tool", "collide", "steps", "tick") else "")


class Campaign:
    """The unmutated program's results, with which runs of mutated programs are compared."""

    def __init__(self, program, work, limits, stages, families, factor=5):
        self.stages = stages
        self.program, self.work, self.limits, self.factor = program, work, limits, factor
        self.families = families
        self.tried = {f: [1, 2.0] for f in self.families}  # number of detected mutants, and seconds spent
        self.known, self.took, self.lists = {}, {}, {}
        self.lock = threading.Lock()
        os.makedirs(work, exist_ok=True)

    def subjects(self, tier, scratch):
        """Returns the backends of a tier that are available here, as the campaign lists them."""
        if tier not in self.lists:
            # One small case is sufficient, because the list of backends does not depend on the cases.
            command = [self.program, "validate", "--json", "--tier", tier, "--only", "mesh/0"]
            status, text, _ = self._verdict(command, scratch, 7200)
            try:
                self.lists[tier] = [b["name"] for b in json.loads(text)["backends"] if b["available"]]
            except (ValueError, KeyError):
                raise RuntimeError(f"{' '.join(command[1:])}: the unmutated program ended with {status} and lists no backends") from None
        return self.lists[tier]

    def worker(self, program, tier, subject, family):
        return [program, "validate", "--tier", tier, "--only", family, "--worker", subject, "--trace", "@TRACE@"]

    def baseline(self, tier, subject, family, scratch):
        """Returns ([(head, digest)], CPU seconds) of the unmutated program. The records that all subjects make must be equal."""
        with self.lock:
            return self._baseline(tier, subject, family, scratch)

    def _baseline(self, tier, subject, family, scratch):
        path = os.path.join(self.work, f"{tier}-{family}-{subject}.json".replace(":", "_"))
        if (tier, subject, family) not in self.known:
            if not os.path.exists(path):
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                process = Process(self.worker(self.program, tier, subject, family), scratch, 7200, self.limits, trace=True, wall_s=7200)
                made = [(h.hex(), d.hex()) for h, d in records(process, self.stages)]
                status = process.end(False)
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                if status != 0:
                    raise RuntimeError(f"{subject}, {tier}, {family}: the unmutated program ended with {status}: {process.last_line}")
                with open(path + ".new", "w") as f:
                    json.dump({"records": made, "seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}, f)
                os.replace(path + ".new", path)
            with open(path) as f:
                data = json.load(f)
            self.known[tier, subject, family] = [(bytes.fromhex(h), bytes.fromhex(d)) for h, d in data["records"]], data["seconds"]
        made, seconds = self.known[tier, subject, family]
        for (t, _, f), (others, _) in list(self.known.items()):
            if (t, f) == (tier, family) and self.common(others) != self.common(made):
                raise RuntimeError(f"{tier}, {family}: unmutated backends differ; a campaign must be equal before mutants can be measured")
        return made, max(self.limits.least_s, self.factor * seconds)

    def common(self, made):
        """Returns the records that every subject makes. A backend whose voxels are on a device, for example, does not sample."""
        sample = self.stages.index("sample")
        return [(head, digest) for head, digest in made if struct.unpack_from("<I", head, 4)[0] != sample]

    def order(self):
        """Returns the families, beginning with those that detected the most mutants per second."""
        return sorted(self.families, key=lambda f: -self.tried[f][0] / self.tried[f][1])

    def differs(self, program, tier, subject, family, scratch):
        """Returns None if the traces of the mutated and the unmutated program are equal, else (case, stage, how)."""
        expected, seconds = self.baseline(tier, subject, family, scratch)
        process = Process(self.worker(program, tier, subject, family), scratch, seconds, self.limits, trace=True)
        count, found = 0, None
        for head, digest in records(process, self.stages):
            if count == len(expected) or (head, digest) != expected[count]:
                want = expected[min(count, len(expected) - 1)][0]
                found = (*place(family, want, self.stages), "failed" if head[4] == self.stages.index("failed") else "differs")
                break
            count += 1
        status = process.end(found is not None)
        if found is None and (status != 0 or count < len(expected)):
            found = (*place(family, expected[min(count, len(expected) - 1)][0], self.stages), how_it_ended(status) or "trace ends early")
        return found

    def killed(self, program, tier, subjects, scratch):
        """Returns the first (subject, case, stage, how) in which a mutated program differs, or None."""
        for family in self.order():
            for subject in subjects:
                begun = time.monotonic()
                found = self.differs(program, tier, subject, family, scratch)
                with self.lock:
                    self.tried[family][0] += found is not None
                    self.tried[family][1] += time.monotonic() - begun
                if found:
                    return (subject, *found)
        return None

    def shared(self, program, tier, subject, scratch):
        """Tests a mutant in code that all backends share. In this case the campaign of the mutated program must detect the mutant.

        First runs a campaign of the case whose trace differs or, if there is none, of a small case with the checks of
        values that are known in advance. Then runs the complete campaign.
        Returns two values: (subject, case, stage, how) or None, and True if a result changed.
        """
        suspect = None
        for who in (subject, "ref"):
            for family in self.order():
                found = self.differs(program, tier, who, family, scratch)
                if found and ("crash" in found[2] or found[2] == "time" or found[2].startswith("exit")):
                    return (who, *found), True
                if found:
                    suspect = found[0]
                    break
            if suspect:
                break
        options = ["--cpu-only", "--backends", ";".join([subject] + [s for s in self.subjects(tier, scratch) if s == "dense"])]
        runs = [["--only", suspect, *options], options] if suspect else [["--only", "import/0", *options]]
        runs.append([])
        for words in runs:
            found = self._noticed([program, "validate", "--json", "--tier", tier, "--jobs", "1", *words], scratch)
            if found:
                return (subject, *found), True
        return None, suspect is not None

    def _noticed(self, command, scratch):
        """Returns (case, stage, how) if a campaign's verdict differs from that of the unmutated program, otherwise None."""
        key = tuple(command[1:])
        if key not in self.took:
            status, _, seconds = self._verdict([self.program, *command[1:]], scratch, 7200)
            if status != 0:
                raise RuntimeError(f"{' '.join(command[1:])}: the unmutated program ended with {status}")
            self.took[key] = seconds
        status, text, _ = self._verdict(command, scratch, max(self.limits.least_s, self.factor * self.took[key]))
        if status == 0:
            return None
        try:
            made = json.loads(text)
        except ValueError:
            made = {}
        first = (made.get("findings") or [{}])[0]
        crash = made.get("results", {}).get("crashed", 0) or made.get("results", {}).get("timed out", 0)
        how = ("crash" if crash else "differs") if status == 1 else how_it_ended(status)
        return first.get("case", ""), str(first.get("stage", "")) or "verdict", how

    def _verdict(self, command, scratch, cpu_s):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = Process(command, scratch, cpu_s, self.limits)
        text = b""
        while True:
            more = process.read()
            if not more or len(text) > 1 << 26:
                break
            text += more
        status = process.end(False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return status, text, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
