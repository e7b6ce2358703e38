# SPDX-License-Identifier: Apache-2.0
"""Calls of libosteon, for the other modules of the package.

    call(lib.ost_..., arguments) --> raises OsteonError with the text of ost_error
    Owned                        --> a C object, its free function, and the objects that must outlive it
    text, path_bytes, meta ...   --> conversions of strings and facts

cffi releases the GIL during each call of the library, so that other Python threads run. The C library allows one
thread at a time to use a backend and its objects. Each backend therefore has a lock, which is held during a call:
calls of several threads on one backend are executed one after another, and calls on different backends at the same
time. After os.fork(), the child must not use a backend of its parent, because the threads of OpenMP do not exist in
the child; the lock then raises an error.
"""
import os
import threading
import weakref
from typing import Any, Callable, Dict, List, Optional

from osteon._osteon import ffi, lib
from osteon.errors import UsageError, error_of

__all__ = ["Lock", "Owned", "call", "call_with_progress", "ffi", "lib", "meta_of", "meta_to", "path_bytes", "progress_handle", "text"]

if lib.ost_version_number() != lib.OST_VERSION:
    raise ImportError(f"the package osteon was built for libosteon {lib.OST_VERSION_MAJOR}.{lib.OST_VERSION_MINOR}."
                      f"{lib.OST_VERSION_PATCH}, but libosteon {ffi.string(lib.ost_version()).decode()} was loaded; "
                      "install the package again")


def call(function: Callable[..., int], *arguments: Any) -> None:
    """Calls a function whose last parameter is an ost_error*, and raises the error that it returns."""
    err = ffi.new("ost_error *")
    status = function(*arguments, err)
    if status:
        raise error_of(status, err)


class _Forked:
    """Replaces the locks of all backends in the child of a fork."""

    def __enter__(self) -> None:
        raise UsageError("a backend cannot be used in a process made by os.fork(); use multiprocessing with the start "
                         "method 'spawn', and open a backend in each process")

    def __exit__(self, *unused: Any) -> None:
        pass


class Lock:
    """The lock of a backend and its objects: `with lock.held: call(...)`."""

    _all: "weakref.WeakSet[Lock]" = weakref.WeakSet()

    def __init__(self) -> None:
        self.held: Any = threading.RLock()
        self.waiting: List[Any] = []  # objects that are freed after the present call
        Lock._all.add(self)

    def free(self, free: Callable[[Any], None], pointer: Any, keep: Any) -> None:
        """Frees an object, and those that could not be freed before.

        During a call of the library, a Python function that the library calls may drop the last reference of an object
        of the same backend. This object is freed later, because the C library makes one call at a time.
        """
        if isinstance(self.held, _Forked):
            return  # the child of a fork leaves the objects of its parent as they are
        self.waiting.append((free, pointer, keep))
        if self.held._is_owned():
            return
        with self.held:
            while self.waiting:
                function, item, _ = self.waiting.pop(0)
                function(item)


def _after_fork() -> None:
    for lock in list(Lock._all):
        lock.held = _Forked()


os.register_at_fork(after_in_child=_after_fork)


class Owned:
    """A C object with one owner. It is freed by close(), at the end of a `with` block, or with its last reference.

    Parameters
    ----------
    pointer : ffi.CData
        The object.
    free : callable
        The function that frees it.
    lock : Lock
        The lock of its backend.
    keep : object
        Python objects that must not be freed before this one.
    """

    def __init__(self, pointer: Any, free: Callable[[Any], None], lock: Lock, keep: Any = None) -> None:
        self._pointer = pointer
        self._lock = lock
        # The finalizer refers to `keep`, so that a backend is closed after its objects are freed, also at exit.
        self._finalizer = weakref.finalize(self, lock.free, free, pointer, keep)

    @property
    def _c(self) -> Any:
        if self._pointer is None:
            raise UsageError(f"the {type(self).__name__} is closed")
        return self._pointer

    def close(self) -> None:
        """Frees the object. It must not be used afterwards. A second call has no effect."""
        self._pointer = None
        self._finalizer()

    @property
    def closed(self) -> bool:
        """True after close()."""
        return self._pointer is None

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *unused: Any) -> None:
        self.close()


def text(pointer: Any) -> str:
    """Returns a C string as str; "" for NULL."""
    return ffi.string(pointer).decode("utf-8", "replace") if pointer else ""


def path_bytes(path: Any) -> bytes:
    """Returns a file name in the form that the C library reads."""
    return os.fsencode(path)


def meta_of(meta: Any) -> Dict[str, str]:
    """Returns the facts of a header as a dict, in their order."""
    return {text(meta.entry[i].key): text(meta.entry[i].value) for i in range(meta.count)}


def meta_to(meta: Any, facts: Optional[Dict[str, str]]) -> None:
    """Writes the facts of a dict to an ost_meta."""
    for key, value in (facts or {}).items():
        call(lib.ost_meta_set, meta, key.encode(), str(value).encode())


class _Progress:
    def __init__(self, function: Callable[[str, float], Any]) -> None:
        self.function = function
        self.error: Optional[BaseException] = None


@ffi.def_extern()
def osteon_py_progress(user: Any, stage: Any, share: float) -> bool:
    """Calls a progress function. The operation is cancelled if it returns False or raises an exception."""
    progress = ffi.from_handle(user)
    try:
        return progress.function(text(stage), share) is not False
    except BaseException as error:  # pylint: disable=broad-except  # no exception may leave the C library
        progress.error = error
        return False


def progress_handle(function: Optional[Callable[[str, float], Any]], options: Any) -> Any:
    """Sets the members `progress` and `progress_user` of options, and returns the object to keep during the call."""
    if function is None:
        return None
    progress = _Progress(function)
    handle = ffi.new_handle(progress)
    options.progress = lib.osteon_py_progress
    options.progress_user = handle
    return progress, handle


def call_with_progress(keep: Any, function: Callable[..., int], *arguments: Any) -> None:
    """Calls a function with a progress callback, and raises the exception that the callback raised."""
    try:
        call(function, *arguments)
    except Exception:
        if keep is not None and keep[0].error is not None:
            raise keep[0].error from None
        raise
