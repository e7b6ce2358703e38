# SPDX-License-Identifier: Apache-2.0
"""The part of the module that does not use Slicer."""
