# SPDX-License-Identifier: Apache-2.0
"""Builds osteon._osteon, the extension module that calls libosteon.

    include/osteon/*.h --C preprocessor--> declarations --cffi--> _osteon.c --compiler--> _osteon.abi3.so
            '-------------------------- #include -------------------'

The declarations that cffi needs are not written down in this package: they are derived from the public
headers at each build. The package therefore cannot use an outdated copy of a declaration. The generated C
file also includes the headers, and the compiler compares every function and every struct with cffi's
understanding of it. A declaration that the derivation below misreads, for example because of a new
attribute, does not compile. `osteon._c` compares the versions when the module is imported.

The library is found in one of two ways:

    OSTEON_BUILD=DIR   a build folder of osteon; the library is DIR/.libs/libosteon.so
    pkg-config osteon  an installed library; OSTEON_DESTDIR=DIR is the folder of `make install DESTDIR=DIR`,
                       which no recorded path contains
"""
import json
import os
import re
import shlex
import subprocess
import tempfile

from cffi import FFI

HERE = os.path.dirname(os.path.abspath(__file__))
# osteon.h does not include plugin.h, because a plugin is not linked to the library
HEADERS = "#include <osteon/osteon.h>\n#include <osteon/plugin.h>\n"

# The functions of Python that C calls, apart from the slots of the plugin (osteon/_c.py).
CALLBACKS = """
bool osteon_py_progress(void *user, const char *stage, double share);
void osteon_py_device(const ost_device_info *device, void *user);
ost_status osteon_py_chunk(void *user, const int32_t *at, const uint32_t *words, ost_error *err);
"""

# The extension module is also a plugin of osteon (osteon/plugin.h). libosteon loads the file of the module, which the
# process has already loaded, so that the slots of the table call Python functions of the same process. The slots
# `snap` and `steps` remain empty: the host executes these steps.
PLUGIN = """
static const ost_plugin osteon_py_table = {
    .size = sizeof osteon_py_table,
    .abi = OST_PLUGIN_ABI,
    .arithmetic = OST_ARITHMETIC_VERSION,
    .name = "python",
    .description = "A function in Python that removes bone.",
    %s
};

OST_PLUGIN_EXPORT const ost_plugin *ost_plugin_entry(uint32_t host_abi)
{
    return host_abi == OST_PLUGIN_ABI ? &osteon_py_table : NULL;
}
"""

# The servo loop of osteon.operation. No Python runs in a tick; another thread ends the loop.
LOOP = """
typedef struct osteon_py_loop osteon_py_loop;
osteon_py_loop *osteon_py_loop_make(ost_operation *operation);
void osteon_py_loop_free(osteon_py_loop *loop);
void osteon_py_loop_stop(osteon_py_loop *loop);
ost_status osteon_py_loop_run(osteon_py_loop *loop, ost_haptic *device, const ost_servo_options *options,
                              ost_servo_report *report, ost_error *err);
"""
LOOP_SOURCE = """
#include <stdatomic.h>
#include <stdlib.h>

struct osteon_py_loop {
    ost_operation *operation; /* borrowed */
    atomic_bool stopped;
};

static osteon_py_loop *osteon_py_loop_make(ost_operation *operation)
{
    osteon_py_loop *loop = calloc(1, sizeof *loop);
    if (loop)
        loop->operation = operation;
    return loop;
}

static void osteon_py_loop_free(osteon_py_loop *loop)
{
    free(loop);
}

static void osteon_py_loop_stop(osteon_py_loop *loop)
{
    atomic_store(&loop->stopped, true);
}

static bool osteon_py_loop_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    osteon_py_loop *loop = user;
    return !atomic_load(&loop->stopped) && ost_operation_tick(loop->operation, sample, wrench);
}

static void osteon_py_loop_done(void *user, uint64_t number, uint32_t exec_ns)
{
    ost_operation_done(((osteon_py_loop *)user)->operation, number, exec_ns);
}

static ost_status osteon_py_loop_run(osteon_py_loop *loop, ost_haptic *device, const ost_servo_options *options,
                                     ost_servo_report *report, ost_error *err)
{
    return ost_servo_run(device, options, osteon_py_loop_tick, osteon_py_loop_done, loop, report, err);
}
"""


def run(*command, text=None):
    """Runs a command and returns its output."""
    return subprocess.run(command, input=text, stdout=subprocess.PIPE, check=True, universal_newlines=True).stdout


def build_tree(folder):
    """Returns the include folder, the library folder and the command of a build folder."""
    with open(os.path.join(folder, "Makefile"), encoding="utf-8") as file:
        source = re.search(r"^abs_top_srcdir = (.*)$", file.read(), re.M)
    libraries = os.path.join(os.path.abspath(folder), ".libs")
    if not source or not os.path.exists(os.path.join(libraries, "libosteon.so")):
        raise SystemExit(f"OSTEON_BUILD={folder}: not a build folder of osteon with a shared library; run make there")
    return os.path.join(source.group(1), "include"), libraries, os.path.join(os.path.abspath(folder), "osteon")


def installed():
    """Returns the include folder, the library folder and the command of an installed osteon."""
    tool = shlex.split(os.environ.get("PKG_CONFIG", "pkg-config"))
    try:
        include, libraries, prefix = (run(*tool, f"--variable={name}", "osteon").strip()
                                      for name in ("includedir", "libdir", "exec_prefix"))
        return include, libraries, os.path.join(prefix, "bin", "osteon")
    except (OSError, subprocess.CalledProcessError):
        raise SystemExit("libosteon was not found: install osteon, so that `pkg-config osteon` finds it, or set "
                         "OSTEON_BUILD to a build folder") from None


def preprocess(include, *options):
    """Runs the preprocessor on the headers, with empty system headers, so that only osteon's declarations remain."""
    compiler = shlex.split(os.environ.get("CC", "cc"))
    with tempfile.TemporaryDirectory() as empty:
        for name in ("stdbool.h", "stddef.h", "stdint.h"):
            with open(os.path.join(empty, name), "w", encoding="ascii"):
                pass
        # cffi's types bool, size_t, int16_t etc. need no declaration; INT64_C is a macro of stdint.h
        return run(*compiler, "-E", "-P", "-nostdinc", "-undef", "-DINT64_C(x)=x", "-DINT32_C(x)=x", "-I", empty,
                   "-I", include, *options, "-", text=HEADERS)


def declarations_of(include):
    """Returns the types and functions of the headers, in the form that cffi reads.

    cffi 1.15 generates invalid C for parameters such as `const double columns[3][3]`. They are declared without const,
    which C allows for the call.
    """
    return re.sub(r"\bconst (\w+ \w+\[\d+\]\[\d+\])", r"\1", preprocess(include))


def constants(include):
    """Declares the macros of the headers that are integers or strings. The compiler determines the values."""
    lines = []
    for name, value in re.findall(r"^#define (OST_[A-Z0-9_]+) (.+)$", preprocess(include, "-dM"), re.M):
        if value.startswith('"'):
            lines.append(f"static char *const {name};")
        elif re.match(r"[(\d]|INT|OST_(?!STATUS_LIST|API|PRINTF)", value) and not name.endswith("_H"):
            kind = "double" if re.match(r"\d*\.\d", value) else "long long"
            lines.append(f"static const {kind} {name};")
    return "\n".join(sorted(lines)) + "\n"


def slots(declarations):
    """Returns the names of the plugin's slots and a prototype for each."""
    table = re.search(r"typedef struct ost_plugin \{(.*?)\} ost_plugin;", declarations, re.S).group(1)
    found = [slot for slot in re.findall(r"(\w+) \(\*(\w+)\)\(([^;]*)\);", table) if slot[1] not in ("snap", "steps")]
    return [name for _, name, _ in found], [f"{result} osteon_py_{name}({' '.join(arguments.split())});"
                                            for result, name, arguments in found]


def check_version(include):
    """Ends the build if the headers have a different version than the package."""
    header = dict(re.findall(r"^#define OST_VERSION_(MAJOR|MINOR|PATCH) (\d+)$", preprocess(include, "-dM"), re.M))
    found = ".".join(header[part] for part in ("MAJOR", "MINOR", "PATCH"))
    with open(os.path.join(HERE, "pyproject.toml"), encoding="utf-8") as file:
        wanted = re.search(r'^version = "(.*)"$', file.read(), re.M).group(1)
    if found != wanted:
        raise SystemExit(f"{include} has the headers of osteon {found}; this package needs osteon {wanted}")


def make():
    """Returns the builder that setuptools calls (setup.py)."""
    build = os.environ.get("OSTEON_BUILD")
    stage = "" if build else os.environ.get("OSTEON_DESTDIR", "")
    include, libraries, command = build_tree(build) if build else installed()
    if os.path.exists(os.path.join(HERE, "osteon", "bin", "osteon")):
        command = "bin/osteon"  # build-wheel has stored the command in the package
    include = stage + include
    check_version(include)
    declarations = declarations_of(include)
    names, prototypes = slots(declarations)
    callbacks = CALLBACKS.strip().split("\n") + prototypes
    table = PLUGIN % " ".join(f".{name} = osteon_py_{name}," for name in names)
    builder = FFI()
    builder.cdef(declarations + constants(include) + "static char *const OSTEON_PY_COMMAND;\n" + LOOP
                 + "void free(void *memory);\n"
                 + "\n".join('extern "Python" ' + line for line in callbacks))
    builder.set_source("osteon._osteon", HEADERS + f"#define OSTEON_PY_COMMAND {json.dumps(command)}\n"
                       + "\n".join("static " + line for line in callbacks) + table
                       + LOOP.split("\n", 2)[1] + LOOP_SOURCE, libraries=["osteon"], include_dirs=[include],
                       library_dirs=[stage + libraries], extra_compile_args=["-std=c11"],
                       # the path of the library is recorded unless the loader finds it anyway
                       runtime_library_dirs=[] if libraries.startswith("/usr/lib") else [libraries])
    return builder


ffibuilder = make()
