# SPDX-License-Identifier: Apache-2.0
"""Adds the extension module to the package; pyproject.toml contains everything else.

cffi restricts the module to Python's stable interface, so that one wheel fits Python 3.9 and all later versions.
build-wheel stores the command `osteon` in the package; the script then runs it.
"""
import os

from setuptools import setup

setup(cffi_modules=["build_osteon.py:ffibuilder"], options={"bdist_wheel": {"py_limited_api": "cp39"}},
      scripts=["scripts/osteon"] if os.path.exists("osteon/bin/osteon") else [])
