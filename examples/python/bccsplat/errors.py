"""Errors of calls. Each is an Error; those that Python knows of files are its own kinds as well."""
from __future__ import annotations

import enum
import os
from typing import Any

from . import _abi


def _status_values() -> list[tuple[str, int]]:
    return [(name.removeprefix("ERROR_"), value) for name, value in vars(_abi).items()
            if name in ("OK", "CANCELLED") or name.startswith("ERROR_")]


Status = enum.IntEnum("Status", _status_values())  # type: ignore[misc]


class Error(Exception):
    """A call that failed. `status` is a Status, `name` its C name; the text says what, where and what to try. It can be
    sent to other processes, so that one that a worker raises is raised where its result is asked for."""

    def __init__(self, status: int | str, name: str = "", text: str = "") -> None:
        """status: or the text alone, as loaders make errors of the same kind from what a worker of theirs raised."""
        if isinstance(status, str):
            text = status
            status = next((number for number, kind in _KINDS.items() if kind is type(self)), _abi.ERROR_INTERNAL)
        # Statuses of a newer library stay numbers.
        self.status: int = Status(status) if status in set(Status) else status
        self.name = name
        self.report: _abi.VerifyReport | None = None  # of Volume.verify
        super().__init__("%s (%s)" % (text, name) if name else text)
        self._text = text

    def __reduce__(self) -> tuple[Any, ...]:
        state = {key: value for key, value in self.__dict__.items() if key != "report"}  # a struct of C
        return type(self), (int(self.status), self.name, self._text), state


class Cancelled(Error):
    """A progress callback, a CancelToken or Renderer.cancel() ended the call."""


class WouldBlock(Error):
    """Bytes of a stream are not there yet. ranges: (offset, size) of what the call lacked."""

    ranges: list[tuple[int, int]] = []


class MissingFile(Error, FileNotFoundError):
    """A file or folder that is not there."""


class ForbiddenFile(Error, PermissionError):
    """A file or folder that this user may not read or write."""


class ExistingFile(Error, FileExistsError):
    """A file that would have been replaced: give another name, or overwrite=True."""


def refuse_existing(path: str | os.PathLike[str], overwrite: bool) -> None:
    """Raises ExistingFile where a file would be replaced that nobody said may be: before anything is read or computed."""
    if not overwrite and os.path.exists(path):
        raise ExistingFile(_abi.ERROR_FILE_EXISTS, "BCCSPLAT_ERROR_FILE_EXISTS",
                           "%s: exists already: give another name, or overwrite=True" % os.fspath(path))


_KINDS: dict[int, type[Error]] = {_abi.CANCELLED: Cancelled, _abi.ERROR_WOULD_BLOCK: WouldBlock,
                                  _abi.ERROR_FILE_NOT_FOUND: MissingFile, _abi.ERROR_PERMISSION_DENIED: ForbiddenFile,
                                  _abi.ERROR_FILE_EXISTS: ExistingFile}


def kind_of_status(status: int) -> type[Error]:
    """The class of a status."""
    return _KINDS.get(status, Error)
