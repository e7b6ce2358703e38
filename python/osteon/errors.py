# SPDX-License-Identifier: Apache-2.0
"""Exceptions. A call of the C library that fails raises an exception with the library's message.

    OsteonError            .status, .exit_status
      DifferError          a check failed or two grids differ
      UsageError           an argument is wrong; also a ValueError
      InputError           the content of a file is wrong; also a ValueError
      RangeError           a value is outside the range of docs/spec/arithmetic.md; also a ValueError
      FileError            the system failed to read or write; also an OSError
      OutOfMemoryError     an allocation failed; also a MemoryError
      UnavailableError     not available in this build or on this machine
      CancelledError       a progress function cancelled the operation
      InternalError        a defect in osteon itself
"""
import threading
from enum import IntEnum
from typing import Any, Dict, Optional, Type

from osteon._osteon import ffi, lib

__all__ = ["CancelledError", "DifferError", "FileError", "InputError", "InternalError", "OsteonError",
           "OutOfMemoryError", "RangeError", "Status", "UnavailableError", "UsageError"]


class Status(IntEnum):
    """The status of a call of the C library (ost_status in osteon/status.h)."""

    OK = lib.OST_OK
    DIFFER = lib.OST_ERR_DIFFER
    USAGE = lib.OST_ERR_USAGE
    INPUT = lib.OST_ERR_INPUT
    RANGE = lib.OST_ERR_RANGE
    IO = lib.OST_ERR_IO
    MEMORY = lib.OST_ERR_MEMORY
    UNAVAILABLE = lib.OST_ERR_UNAVAILABLE
    CANCELLED = lib.OST_ERR_CANCELLED
    INTERNAL = lib.OST_ERR_INTERNAL


class OsteonError(Exception):
    """An error of osteon. The text is the message of the C library, one line for the user.

    Attributes
    ----------
    status : Status
        The status that the C function returned.
    """

    status: Status = Status.INTERNAL

    @property
    def exit_status(self) -> int:
        """Exit status of the `osteon` command for this error: 1, 2 or 3."""
        return int(lib.ost_status_exit(int(self.status)))


class DifferError(OsteonError):
    """A check failed, or two grids differ."""

    status = Status.DIFFER


class UsageError(OsteonError, ValueError):
    """An argument is wrong."""

    status = Status.USAGE


class InputError(OsteonError, ValueError):
    """The content of a file is wrong. The text contains the position."""

    status = Status.INPUT


class RangeError(OsteonError, ValueError):
    """A value is outside the range for which docs/spec/arithmetic.md proves its results."""

    status = Status.RANGE


class FileError(OsteonError, OSError):
    """The system failed to read or write a file."""

    status = Status.IO


class OutOfMemoryError(OsteonError, MemoryError):
    """An allocation of the C library failed."""

    status = Status.MEMORY


class UnavailableError(OsteonError):
    """Something is not available in this build or on this machine. The text contains the reason."""

    status = Status.UNAVAILABLE


class CancelledError(OsteonError):
    """A progress function returned False."""

    status = Status.CANCELLED


class InternalError(OsteonError):
    """A defect in osteon itself."""

    status = Status.INTERNAL


_CLASSES: Dict[int, Type[OsteonError]] = {
    int(kind.status): kind for kind in (DifferError, UsageError, InputError, RangeError, FileError, OutOfMemoryError,
                                        UnavailableError, CancelledError, InternalError)}


class _Pending(threading.local):
    """The exception of a Python function that the library called, until the call of the library ends."""

    error: Optional[BaseException] = None


pending = _Pending()


def error_of(status: int, err: Any) -> BaseException:
    """Returns the exception for a status and the ost_error that the call filled in.

    If a Python function that the library called raised an exception, this exception is the cause. An interrupt is
    returned itself.
    """
    text = ffi.string(err.text).decode("utf-8", "replace") or ffi.string(lib.ost_status_text(status)).decode()
    cause, pending.error = pending.error, None
    if cause is not None and not isinstance(cause, Exception):
        return cause
    error = _CLASSES.get(status, InternalError)(text)
    error.__cause__ = cause
    return error
