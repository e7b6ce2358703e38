# SPDX-License-Identifier: Apache-2.0
"""Adds the extension module to the package; pyproject.toml contains everything else."""
from setuptools import setup

setup(cffi_modules=["build_osteon.py:ffibuilder"])
