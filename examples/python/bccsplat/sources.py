"""Where the bytes of a volume come from, beside paths and bytes: open files, and files of fsspec by their URLs or objects, of
which only ranges are read."""
from __future__ import annotations

import os
import re
import threading
from importlib import import_module
from typing import Any

# Bytes between two ranges that are read along rather than asked for by themselves: what a request of some 20 ms costs.
_REMOTE_GAP = 1 << 18
_URL = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]+(://|::)")


def is_url(source: Any) -> bool:
    """Whether it is a text such as "https://..." or "s3://...", which fsspec opens."""
    return isinstance(source, str) and _URL.match(source) is not None


class RemoteFile:
    """A file of an fsspec filesystem; it can be sent to other processes."""

    def __init__(self, filesystem: Any, path: str) -> None:
        self.filesystem, self.path = filesystem, path
        self._process = os.getpid()
        self.size = self._size()

    @classmethod
    def of_url(cls, url: str) -> RemoteFile:
        """By its URL. ImportError that says what to install."""
        try:
            core = import_module("fsspec.core")
        except ImportError:
            raise ImportError("%s is opened by fsspec, which is not installed: python3 -m pip install fsspec, and what it "
                              "needs for this kind of URL (aiohttp, s3fs, gcsfs ...)" % url) from None
        return cls(*core.url_to_fs(url))

    def _size(self) -> int:
        size = self._there().info(self.path).get("size")
        if size is None:
            raise OSError("%s: the server does not tell the size of the file, so that its parts cannot be read" % self.path)
        return int(size)

    def _there(self) -> Any:
        if self._process != os.getpid():  # its threads are those of the parent
            made = type(self.filesystem)
            self.filesystem = made(*self.filesystem.storage_args, **self.filesystem.storage_options)
            self._process = os.getpid()
        return self.filesystem

    def read_at(self, offset: int, buffer: memoryview) -> int:
        """One request."""
        end = min(offset + len(buffer), self.size)
        found = self._there().cat_file(self.path, start=offset, end=end)
        if len(found) > end - offset:
            raise OSError("%s: the server gives the whole file where a part was asked for: copy it here, or serve it by a "
                          "server of ranges" % self.path)
        buffer[:len(found)] = found
        return len(found)

    def stream(self) -> tuple[int, Any, int]:
        """As Volume takes it."""
        return self.size, self.read_at, _REMOTE_GAP


class OpenFile:
    """A binary file that the caller has open: its position stays where it is."""

    def __init__(self, file: Any) -> None:
        self._file, self._lock = file, threading.Lock()
        at = file.tell()
        self.size = file.seek(0, os.SEEK_END)
        file.seek(at)

    def read_at(self, offset: int, buffer: memoryview) -> int:
        """At a place of the file, by one thread after another."""
        with self._lock:
            at = self._file.tell()
            try:
                self._file.seek(offset)
                found = self._file.read(len(buffer))
            finally:
                self._file.seek(at)
        buffer[:len(found)] = found
        return len(found)

    def stream(self) -> tuple[int, Any]:
        """As Volume takes it."""
        return self.size, self.read_at


def opened(source: Any) -> RemoteFile | OpenFile | None:
    """The source behind a URL, an object of fsspec or an open file; None: it is something else, such as a path."""
    if is_url(source):
        return RemoteFile.of_url(source)
    if hasattr(source, "fs") and hasattr(source, "path"):  # fsspec.open(...), or what that opened
        return RemoteFile(source.fs, source.path)
    if hasattr(source, "read") and hasattr(source, "seek"):
        if "b" not in getattr(source, "mode", "b") and not isinstance(getattr(source, "mode", "b"), int):
            raise TypeError("%r is open as text: open it with mode 'rb', or give its path" % (source,))
        return OpenFile(source)
    return None
