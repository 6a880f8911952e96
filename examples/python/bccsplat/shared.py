"""What a process has once: a device, and each file that arrays look into, opened again where a process has not."""
from __future__ import annotations

import os
import threading
import weakref
from typing import Any, Union

from .device import Device
from .sources import is_url
from .volume import Volume

Path = Union[str, "os.PathLike[str]"]

_lock = threading.Lock()
_device: Device | None = None
_volumes: "weakref.WeakValueDictionary[tuple[Any, ...], Volume]" = weakref.WeakValueDictionary()


def default_device() -> Device:
    """The device of this process that calls use which are given none: as many threads as the machine has, no limit of
    memory. A process that was forked gets its own."""
    global _device
    with _lock:
        if _device is None:
            _device = Device()
        return _device


def _renew_lock() -> None:
    global _lock
    _lock = threading.Lock()


# Another thread may have held it in the parent.
os.register_at_fork(after_in_child=_renew_lock)


class SharedFile:
    """A file by name, which can be sent to other processes; all that use it in one of them share one open volume.

    path: made absolute, or a URL. kernel, cache_bytes, salvage: as of Volume. A file that was replaced since is opened anew.
    """

    def __init__(self, path: Path, *, kernel: str | None = None, cache_bytes: int = 0, salvage: int = 0) -> None:
        self.path: str = path if is_url(path) else os.path.abspath(os.fspath(path))  # type: ignore[assignment]
        self.options: dict[str, Any] = {"kernel": kernel, "cache_bytes": cache_bytes, "salvage": salvage}
        self._opened: Volume | None = None

    @property
    def volume(self) -> Volume:
        """The open volume. Its errors are those of opening a file."""
        if self._opened is None:
            self._opened = self._find()
        return self._opened

    def _find(self) -> Volume:
        try:
            found = os.stat(self.path)
            state = (found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns)
        except OSError:  # the library says what is wrong
            state = (0, 0, 0, 0)
        key = (self.path, state, *sorted(self.options.items()))
        device = default_device()
        with _lock:
            volume = _volumes.get(key)
            if volume is None:
                volume = _volumes[key] = Volume(device, self.path, **self.options)
            return volume

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path, "options": self.options, "_opened": None}
