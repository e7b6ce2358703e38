# SPDX-License-Identifier: Apache-2.0
"""Lengths. The library computes with integers, in picometres: 1 mm = 1,000,000,000 pm.

A name that ends in `_pm` is an integer in picometres. A name that ends in `_mm` is a length in millimetres and may
be a str, an int, a float or a Decimal, which `pm` converts exactly. A float represents the shortest decimal that reads
back as this float, so 0.47, np.float32(0.47) and "0.47" are the same length.
"""
from decimal import Decimal
from typing import Any, Iterable, Tuple, Union

import numpy as np

from osteon._c import call, ffi, lib
from osteon.errors import RangeError, UsageError

__all__ = ["Length", "PM_PER_MM", "mm_text", "pm", "pm3", "to_mm"]

Length = Union[str, int, float, Decimal, np.number]
Vector = Tuple[int, int, int]

PM_PER_MM: int = int(lib.OST_PM_PER_MM)


def pm(mm: Length) -> int:
    """Converts a length in millimetres to picometres, rounded half to even.

    Parameters
    ----------
    mm : str, int, float or Decimal
        The length. A string must be one decimal, for example "0.48828125".

    Raises
    ------
    RangeError
        If the length is NaN, infinite or outside +-8 m.
    InputError
        If a string is not a decimal.
    UsageError
        If the value has another type.

    Examples
    --------
    >>> pm("0.47"), pm(0.47), pm(2)
    (470000000, 470000000, 2000000000)
    """
    out = ffi.new("ost_pm *")
    if isinstance(mm, np.float32):
        if not lib.ost_pm_from_float(float(mm), out):
            raise RangeError(f"{mm} mm: must be within +-8000 mm")
    elif isinstance(mm, (float, np.floating)):
        if not lib.ost_pm_from_double(float(mm), out):
            raise RangeError(f"{mm} mm: must be within +-8000 mm")
    elif isinstance(mm, (str, int, np.integer, Decimal)) and not isinstance(mm, bool):
        call(lib.ost_pm_parse, str(mm).encode(), out)
    else:
        raise UsageError(f"{mm!r}: expected a length in mm as str, int, float or Decimal")
    return int(out[0])


def pm3(mm: Union[Length, Iterable[Length]]) -> Vector:
    """Converts a vector x, y, z in millimetres to picometres. One length is used for all three axes."""
    if isinstance(mm, (str, int, float, Decimal, np.number)):
        return (pm(mm),) * 3
    x, y, z = mm
    return pm(x), pm(y), pm(z)


def to_mm(length_pm: int) -> float:
    """Returns a length in millimetres, rounded to the nearest float. For display only."""
    return float(lib.ost_pm_to_mm(int(length_pm)))


def mm_text(length_pm: int) -> str:
    """Returns a length in millimetres as the shortest exact decimal, for example "0.47"."""
    out = ffi.new("char[]", lib.OST_PM_TEXT)
    return ffi.string(lib.ost_pm_format(int(length_pm), out)).decode()


def vector(values: Iterable[Any]) -> Vector:
    """Returns three values as a tuple of int."""
    x, y, z = values
    return int(x), int(y), int(z)


def c_pm3(values: Iterable[Any]) -> Any:
    """Returns a vector as a dict that cffi assigns to an ost_pm3 or an ost_dims."""
    x, y, z = vector(values)
    return {"x": x, "y": y, "z": z}


def of_pm3(c_vector: Any) -> Vector:
    """Returns an ost_pm3 as a tuple."""
    return c_vector.x, c_vector.y, c_vector.z
