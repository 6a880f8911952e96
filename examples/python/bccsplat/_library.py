"""The shared library, its calls with their errors, and handles that give their reference back."""
from __future__ import annotations

import ctypes
import os
import re
from collections import deque
from ctypes import byref, c_void_p
from typing import Any, Callable, Sequence, TypeVar

from . import _abi, interrupt
from .errors import Error, WouldBlock, kind_of_status

Self = TypeVar("Self", bound="Handle")
# A fraction in [0, 1] that never falls; a true answer cancels the call.
Progress = Callable[[float], "bool | None"]


def _open() -> ctypes.CDLL:
    """BCCSPLAT_LIBRARY, else the library this package was installed with, else what the loader finds."""
    soname = "libbccsplat.so.%d" % _abi.ABI_VERSION
    here = os.path.dirname(os.path.abspath(__file__))
    try:
        with open(os.path.join(here, "library_path"), encoding="utf-8") as file:  # written by the installation
            beside = os.path.join(here, file.read().strip(), soname)
    except FileNotFoundError:
        beside = ""
    found = os.environ.get("BCCSPLAT_LIBRARY") or (beside if os.path.exists(beside) else soname)
    try:
        return ctypes.CDLL(found)
    except OSError as error:
        raise ImportError("bccsplat: the library does not load (%s): install a wheel, which has it inside, or set "
                          "BCCSPLAT_LIBRARY to %s" % (error, soname)) from None


native = _open()
for _name, (_result, *_arguments) in _abi.FUNCTIONS.items():
    _function = getattr(native, _name)
    _function.restype, _function.argtypes = _result, _arguments

if native.bccsplat_abi_version() != _abi.ABI_VERSION:
    raise ImportError("bccsplat: the library has another ABI version than this module: %d, not %d"
                      % (native.bccsplat_abi_version(), _abi.ABI_VERSION))


_UNSIGNED = (ctypes.c_uint32, ctypes.c_uint64)


def refused(error: ctypes.ArgumentError, arguments: Sequence[Any]) -> TypeError:
    """What ctypes says of an argument, as a sentence that tells its value."""
    place = re.match(r"argument (\d+)", str(error))
    value = repr(arguments[int(place[1]) - 1]) if place else "one of the arguments"
    return TypeError("%s is given where a number is wanted" % value)


# What streams raised since a call failed last, the newest last.
read_failures: deque[Exception] = deque(maxlen=8)


def failure(status: int) -> Error:
    """The error of a call of this thread that ended with a status. What a stream failed to read is its cause."""
    text, name = native.bccsplat_last_error().decode(), native.bccsplat_status_name(status).decode()
    error = kind_of_status(status)(status, name, text)
    if isinstance(error, WouldBlock):
        count = ctypes.c_uint64()
        native.bccsplat_last_lacking(None, 0, byref(count))
        pairs = (ctypes.c_uint64 * (2 * count.value))()
        native.bccsplat_last_lacking(pairs, count.value, None)
        error.ranges = [*zip(pairs[::2], pairs[1::2])]
    if read_failures and status == _abi.ERROR_IO:
        error.__cause__ = read_failures.pop()
        read_failures.clear()
    return error


def _cancel(token: Handle) -> None:
    native.bccsplat_cancel_token_cancel(token.pointer)


def _reset(token: Handle) -> None:
    native.bccsplat_cancel_token_reset(token.pointer)


def call(name: str, *arguments: Any, watch: Watch | None = None, token: Handle | None = None) -> None:
    """Calls bccsplat_NAME; raises Error, or what the host's own callback `watch` raised meanwhile. token: what the call
    looks at, which Ctrl-C cancels; None: that of a handle among the arguments."""
    function = getattr(native, "bccsplat_" + name)
    for argument, kind in zip(arguments, function.argtypes):
        if isinstance(argument, Closed):
            raise ValueError("a %s that was closed cannot be used any more: open or make it anew" % argument.kind)
        if kind in _UNSIGNED and isinstance(argument, int) and argument < 0:
            raise ValueError("%d is given where a number from 0 on is wanted" % argument)
        if token is None:
            token = getattr(argument, "token", None)
    try:
        status = function(*arguments) if token is None else interrupt.run(token, _cancel, _reset, function, arguments)
    except ctypes.ArgumentError as wrong:
        raise refused(wrong, arguments) from None
    if watch is not None and watch.error is not None:
        error, watch.error = watch.error, None
        raise error
    if status != _abi.OK:
        raise failure(status)


class Watch:
    """A Python progress function as a C callback. An exception inside cancels the call and comes out of it."""

    def __init__(self, progress: Progress | None) -> None:
        self.error: BaseException | None = None

        def report(_user: int | None, fraction: float) -> int:
            try:
                with interrupt.host_code:
                    return 1 if progress is not None and progress(fraction) else 0
            except BaseException as error:  # ctypes would print and forget it
                self.error = error
                return 1

        self.function = _abi.bccsplat_progress_fn(report) if progress else _abi.bccsplat_progress_fn(0)


def choose(kind: str, value: int | str | None) -> int:
    """A constant by number or name; None: 0, the default."""
    if value is None:
        return 0
    return value if isinstance(value, int) else _abi.constant(kind, value)


def encode(text: str | None) -> bytes | None:
    """A text as the library takes it; TypeError of what is none."""
    if text is not None and not isinstance(text, str):
        raise TypeError("%r is given where a text is wanted" % (text,))
    return None if text is None else text.encode()


def decode(text: bytes | None) -> str:
    return "" if text is None else text.decode()


class Pointer(c_void_p):
    """The pointer of a handle. token: what calls of the object look at, which Ctrl-C cancels; None: none."""

    token: Handle | None = None


class Closed(Pointer):
    """The pointer of a handle that was closed: NULL, and what it was of."""

    kind = ""


class Handle:
    """One reference to an object of the library. `close`, the end of a with block or of the last Python reference
    gives it back; arrays that look into the object keep it alive by a reference of their own."""

    _kind = ""
    # What is made anew in a forked process, and what is no more than memory.
    _RENEWED, _MEMORY = ("device", "volume", "slice"), ("frame", "cancel_token")

    def __init__(self) -> None:
        self._pointer = Pointer()
        self._process = os.getpid()

    @property
    def pointer(self) -> Pointer:
        """Of the object. The threads and locks of a process are not those of one that was forked from it: there devices,
        volumes and slices are made once more, and what else is more than memory is refused."""
        if self._process != os.getpid() and self._pointer and self._kind not in self._MEMORY:
            if self._kind not in self._RENEWED:
                raise ValueError("a %s of the process that this one was forked from cannot be used here: make it in this one" %
                                 self._kind)
            self._create(*self._recipe, watch=self._watched, token=self._pointer.token)
        return self._pointer

    def _create(self, function: str, *arguments: Any, watch: Watch | None = None, token: Handle | None = None) -> None:
        """Makes the object. Handles among the arguments are given by their pointers; what pointers among them look into
        lives as long as they do. token: what the object keeps of its options."""
        pointer = Pointer()
        pointer.token = token
        given = [argument.pointer if isinstance(argument, Handle) else argument for argument in arguments]
        call(function, *given, byref(pointer), watch=watch, token=token)
        self._pointer, self._process = pointer, os.getpid()
        if self._kind in self._RENEWED:
            self._recipe, self._watched = (function, *arguments), watch

    def close(self) -> None:
        """Gives the reference back now; the object cannot be used through this handle any more."""
        pointer, closed = self._pointer, Closed()
        closed.kind, self._pointer = self._kind, closed
        if self._process == os.getpid():  # a forked child has none of the parent's threads to end
            getattr(native, "bccsplat_%s_release" % self._kind)(pointer)

    def share(self: Self) -> Self:
        """Another handle of the same object."""
        other = object.__new__(type(self))
        getattr(native, "bccsplat_%s_retain" % self._kind)(self.pointer)
        other.__dict__.update(self.__dict__)
        other._pointer = Pointer(self._pointer.value)
        other._pointer.token = self._pointer.token
        return other

    def __copy__(self: Self) -> Self:
        return self.share()

    def __deepcopy__(self: Self, _memo: Any) -> Self:
        return self.share()

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("a %s cannot be sent to another process: make it there, or send a volume, which is opened there "
                        "by its path" % self._kind.replace("_", " "))

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def __del__(self) -> None:
        # Nothing was created, or the interpreter is being torn down.
        if getattr(self, "_pointer", None) and native is not None:
            self.close()
