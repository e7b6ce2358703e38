# SPDX-License-Identifier: Apache-2.0
"""Makes a scratch build, and makes single objects and programs of it again with a mutant.

    make V=1 --log--> commands of every object and program
    mutant --overlay/--> objects that depend on its file --link--> program

The files of the build are never changed, so that several jobs can use one
build. A mutated object is the first on the linker's command line, so that the
linker does not use the archive's member with the same symbols.
"""
import functools
import os
import re
import shlex
import shutil
import signal
import subprocess

COMPILE_LIMIT = 180
LIVE = set()  # process groups that were started and have not been waited for


class BuildError(Exception):
    pass


def end_all():
    """Kills every running process group. Called by a signal handler."""
    for group in list(LIVE):
        try:
            os.killpg(group, signal.SIGKILL)
        except ProcessLookupError:
            pass


def run(command, cwd, limit, env=None, output=None):
    """Runs a command in a process group of its own. Returns (status, text); status is None after a timeout."""
    p = subprocess.Popen(command, cwd=cwd, env=env, stdin=subprocess.DEVNULL, stdout=output or subprocess.PIPE, stderr=subprocess.STDOUT if not output else None,
                         start_new_session=True)
    LIVE.add(p.pid)
    try:
        text = p.communicate(timeout=limit)[0]
    except subprocess.TimeoutExpired:
        os.killpg(p.pid, signal.SIGKILL)
        p.communicate()
        return None, "late"
    finally:
        LIVE.discard(p.pid)
    return p.returncode, (text or b"").decode(errors="replace")


def make_scratch(source, folder, configure, log=print):
    """Clones the commit of `source` and builds it with its log in FOLDER/build/build.log, unless this is done already."""
    build = os.path.join(folder, "build")
    done = os.path.join(build, "build.done")
    if os.path.exists(done):
        return build
    log(f"building in {folder}: once, some minutes")
    if not os.path.exists(os.path.join(folder, "configure.ac")):
        subprocess.run(["git", "clone", "-q", source, folder], check=True)
    os.makedirs(build, exist_ok=True)
    jobs = f"-j{os.cpu_count() or 1}"
    with open(os.path.join(build, "build.log"), "wb") as out:
        for command, cwd in ((["./bootstrap"], folder), (["../configure", *configure], build), (["make", "-Oline", jobs, "V=1"], build), (["make", "-Oline", jobs, "V=1", "check", "TESTS="], build)):
            if subprocess.run(command, cwd=cwd, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL).returncode != 0:
                raise BuildError(f"{' '.join(command)} failed; see {build}/build.log")
    open(done, "w").close()
    return build


def _words(line):
    try:
        return shlex.split(re.sub(r"`[^`]*`", "", line))
    except ValueError:
        return []


def parse_log(text):
    """Returns ({object: words of its command}, {program: words of its link command}) from a log of `make V=1`."""
    objects, programs = {}, {}
    for line in text.splitlines():
        if line.startswith("libtool: compile:"):
            words = shlex.split(line[len("libtool: compile:"):])
        elif re.match(r"(ccache )?\S*(gcc|clang|cc)\S* .*-c -o ", line):
            # automake writes a source as `test -f 'a.c' || echo '../'`a.c
            words = _words(re.sub(r"`test -f '([^']*)' \|\| echo '([^']*)'`", r"\2", line))
        elif line.startswith("libtool: link:") and " -o " in line:
            words = shlex.split(line[len("libtool: link:"):])
            if "-shared" not in words and not words[words.index("-o") + 1].endswith((".so", ".la")) and words[0] not in ("ar", "ln", "ranlib", "("):
                programs[words[words.index("-o") + 1]] = words
            continue
        else:
            continue
        if "-o" in words and "-c" in words:
            objects[words[words.index("-o") + 1]] = words
    return objects, programs


class Build:
    def __init__(self, folder, jobs_folder, compiler=None, linker=None):
        self.folder = os.path.abspath(folder)
        self.source = os.path.dirname(self.folder)
        self.work = os.path.abspath(jobs_folder)
        self.compiler = compiler
        with open(os.path.join(self.folder, "build.log"), errors="replace") as log:
            self.objects, self.programs = parse_log(log.read())
        if "osteon" not in self.programs:
            raise BuildError(f"{folder}/build.log has no link command of osteon")
        self.linker = linker if linker is not None else next((f"-fuse-ld={n}" for n in ("mold", "lld", "gold") if shutil.which({"lld": "ld.lld", "gold": "ld.gold"}.get(n, n))), "")
        self.users = self._users()
        os.makedirs(os.path.join(self.work, "unmutated"), exist_ok=True)

    def _source_of(self, words):
        """Returns the source file of a compile command, relative to the tree."""
        for word in words:
            if word.endswith((".c", ".cc")) and not word.startswith("-"):
                return os.path.relpath(os.path.join(self.folder, word), self.source)
        return None

    def _users(self):
        """Returns {file: objects that depend on it}, from the dependency files that the compiler wrote."""
        users = {}
        for name, words in self.objects.items():
            found = {self._source_of(words)}
            if "-MF" in words:
                listed = words[words.index("-MF") + 1]
                for path in (listed, re.sub(r"\.Tpo$", ".Plo", listed), re.sub(r"\.Tpo$", ".Po", listed)):
                    try:
                        with open(os.path.join(self.folder, path)) as f:
                            text = f.read().replace("\\\n", " ")
                    except OSError:
                        continue
                    rule = text.split("\n", 1)[0].split(":", 1)[-1]
                    found |= {os.path.relpath(os.path.join(self.folder, w), self.source) for w in rule.split()}
            for file in found - {None}:
                users.setdefault(file, []).append(name)
        return users

    def _command(self, words, overlay, out):
        """Returns the compile command, which uses the overlay's files before the tree's, without debug information and warnings."""
        result, skip = [], 0
        for i, word in enumerate(words):
            if skip:
                skip -= 1
            elif word in ("-MT", "-MF"):
                skip = 1
            elif word == "ccache" or word in ("-MD", "-MP", "-g") or word.startswith("-Werror"):
                pass
            elif word == "-o":
                skip = 1
            elif i and word.endswith(".c") and not word.startswith("-"):
                relative = os.path.relpath(os.path.join(self.folder, word), self.source)
                mine = os.path.join(overlay, relative)
                result.append(mine if os.path.exists(mine) else os.path.join(self.source, relative))
            else:
                result.append(word)
        at = 1 + (self.compiler is None)
        if self.compiler:
            result[0] = self.compiler
            at = 1
        else:
            at = 1
        includes = ["-I" + os.path.join(overlay, d) for d in ("src", "tests", ".")]
        prefixes = [f"-ffile-prefix-map={overlay}=", f"-ffile-prefix-map={self.source}="]
        return result[:at] + includes + result[at:] + ["-g0", "-w", *prefixes, "-o", out]

    def _plain(self, name):
        """Returns the unmutated object, compiled in the same way as mutated ones."""
        path = os.path.join(self.work, "unmutated", name.replace("/", "__"))
        if not os.path.exists(path):
            os.makedirs(os.path.join(self.work, "empty"), exist_ok=True)
            part = f"{path}.{os.getpid()}.{id(self) & 0xffff}"
            status, text = run(self._command(self.objects[name], os.path.join(self.work, "empty"), part), self.folder, COMPILE_LIMIT)
            if status != 0:
                raise BuildError(f"{name} does not compile unmutated: {text[-500:]}")
            os.replace(part, path)
        return path

    def objects_of(self, file, within=None):
        """Returns the objects that depend on a file and whose names begin with `within`, a prefix or a tuple of prefixes."""
        return sorted(o for o in self.users.get(file, []) if within is None or o.startswith(within))

    def compile(self, names, overlay, folder, limit=COMPILE_LIMIT):
        """Compiles objects. Returns (status, the objects that differ); status is "not compiled", "identical" or "differs"."""
        changed = []
        for name in names:
            out = os.path.join(folder, name.replace("/", "__"))
            status, _ = run(self._command(self.objects[name], overlay, out), self.folder, limit)
            if status != 0:
                return "not compiled", []
            with open(out, "rb") as a, open(self._plain(name), "rb") as b:
                if a.read() != b.read():
                    changed.append(out)
                else:
                    os.remove(out)
        return ("differs", changed) if changed else ("identical", [])

    @functools.cache
    def _strings(self):
        """Returns the arguments of build-aux/source-strings for the kernels, as used by make. They are cached, because make
        takes seconds to print them."""
        rule = subprocess.run(["make", "-n", "-s", "-W", "../src/cl/kernels/common.h", "src/cl/embedded.c"], cwd=self.folder, capture_output=True, text=True).stdout
        found = re.search(r"build-aux/source-strings (cl .*?) >", rule.replace("\\\n", " "))
        return shlex.split(found.group(1)) if found else []

    def embedded(self, overlay, folder):
        """Makes the object of the OpenCL program with the overlay's kernels. Returns None if it cannot be made."""
        name = next((o for o in self.objects if re.search(r"src/cl/.*embedded\.o$", o)), None)
        if not name or not self._strings():
            return None
        os.makedirs(os.path.join(overlay, "src/cl"), exist_ok=True)
        tree = os.path.join(folder, "kernels")
        shutil.rmtree(tree, ignore_errors=True)
        shutil.copytree(os.path.join(self.source, "src/cl/kernels"), os.path.join(tree, "src/cl/kernels"))
        shutil.copytree(os.path.join(overlay, "src/cl/kernels"), os.path.join(tree, "src/cl/kernels"), dirs_exist_ok=True)
        text = subprocess.run(["sh", os.path.join(self.source, "build-aux/source-strings"), *self._strings()], cwd=tree, capture_output=True)
        shutil.rmtree(tree)
        if text.returncode != 0:
            return None
        source, out = os.path.join(folder, "embedded.c"), os.path.join(folder, "embedded.o")
        with open(source, "wb") as f:
            f.write(text.stdout)
        words = [source if w.endswith("embedded.c") else w for w in self.objects[name]]
        command = self._command(words, os.path.join(self.work, "empty"), out)
        command = [source if w.endswith("embedded.c") else w for w in command]
        return out if run(command, self.folder, COMPILE_LIMIT)[0] == 0 else None

    def link(self, program, changed, out, instead=()):
        """Links a program with these objects before all others, or in place of the objects in `instead`."""
        words = [w for w in self.programs[program] if w != "ccache"]
        words = [dict(instead).get(w, w) for w in words]
        at = words.index("-o")
        words[at + 1] = out
        words[at + 2:at + 2] = [o for o in changed if o not in dict(instead).values()]
        words += [self.linker] if self.linker else []
        return run(words + ["-Wl,-s"], self.folder, COMPILE_LIMIT)
