# SPDX-License-Identifier: Apache-2.0
"""Files that other packages write: a file appears under its name only when it is complete."""
import contextlib
import os
from typing import Any, Iterator

from osteon.errors import FileError, OsteonError


@contextlib.contextmanager
def complete(path: Any) -> Iterator[str]:
    """Yields the name of a temporary file. It gets the name `path` after the block, and is deleted after an error."""
    name = os.fsdecode(path)
    temporary = os.path.join(os.path.dirname(name), f".{os.path.basename(name)}.{os.getpid()}")
    try:
        yield temporary
        os.replace(temporary, name)
    except OsteonError:
        raise
    except OSError as error:
        raise FileError(f"{name}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            os.remove(temporary)
