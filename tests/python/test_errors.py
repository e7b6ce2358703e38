# SPDX-License-Identifier: Apache-2.0
"""Tests the exceptions, and that the package agrees with the library."""
import inspect
import os
import pkgutil
import re

import pytest

import osteon
from osteon._osteon import ffi, lib


@pytest.mark.parametrize("call, kind, builtin, exit_status", [
    (lambda d: osteon.Backend("none"), osteon.UsageError, ValueError, 2),
    (lambda d: osteon.Backend("cl:platform=99"), osteon.OsteonError, Exception, None),
    (lambda d: osteon.Volume.read(d / "none.nrrd"), osteon.FileError, OSError, 2),
    (lambda d: osteon.Volume.read(d / "bad.nrrd"), osteon.InputError, ValueError, 2),
    (lambda d: osteon.Pose.of((9000, 0, 0)), osteon.RangeError, ValueError, 2),
    (lambda d: osteon.Pose.of((0, 0, 0), (2, 0, 0, 0)), osteon.RangeError, ValueError, 2),
])
def test_errors_have_the_text_of_the_library(tmp_path, call, kind, builtin, exit_status):
    (tmp_path / "bad.nrrd").write_text("NRRD0004\ntype: int16\nsizes: x\n\n")
    with pytest.raises(kind) as caught:
        call(tmp_path)
    assert isinstance(caught.value, builtin) and isinstance(caught.value, osteon.OsteonError)
    assert str(caught.value) and "\n" not in str(caught.value)
    assert exit_status in (None, caught.value.exit_status)


def test_every_status_has_an_exception():
    names = {value: name for value, name in ffi.typeof("ost_status").elements.items()}
    assert {int(s) for s in osteon.Status} == set(names)
    for status in osteon.Status:
        assert names[int(status)] in ("OST_" + status.name, "OST_ERR_" + status.name)
        if status:
            err = ffi.new("ost_error *", {"status": int(status), "text": b"why"})
            from osteon.errors import error_of
            error = error_of(int(status), err)
            assert error.status == status and str(error) == "why"


def test_every_public_function_of_the_headers_can_be_called():
    """The declarations are derived from the headers; none was lost by the derivation."""
    folder = os.path.join(os.environ["OSTEON_SOURCE"], "include", "osteon")
    declared = set()
    for name in os.listdir(folder):
        if name.endswith(".h"):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
            declared |= set(re.findall(r"OST_API[^;()]*?\b(ost_\w+)\(", text))
    assert len(declared) > 200
    assert not declared - set(dir(lib))


def test_versions():
    with open(os.path.join(os.environ["OSTEON_SOURCE"], "python", "pyproject.toml"), encoding="utf-8") as file:
        assert f'version = "{osteon.__version__}"' in file.read()


def test_everything_public_is_documented_and_typed():
    for module in pkgutil.iter_modules(osteon.__path__):
        if module.name in ("_osteon",):
            continue
        loaded = __import__("osteon." + module.name, fromlist=["x"])
        assert loaded.__doc__, module.name
        for name in getattr(loaded, "__all__", ()):
            value = getattr(loaded, name)
            if not (inspect.isclass(value) or inspect.isfunction(value)) or not value.__module__.startswith("osteon"):
                continue
            assert inspect.getdoc(value), f"{module.name}.{name}"
            members = [value] if inspect.isfunction(value) else [
                m for n, m in vars(value).items() if inspect.isfunction(m) and not n.startswith("_")]
            for member in members:
                assert inspect.getdoc(member), f"{module.name}.{name}.{member.__name__}"
                hints = inspect.signature(member)
                assert hints.return_annotation is not inspect.Signature.empty, f"{name}.{member.__name__}"
    assert os.path.exists(os.path.join(os.path.dirname(osteon.__file__), "py.typed"))
