"""Python functions as streams of the library: bytes come from and go to wherever a host likes."""
from __future__ import annotations

import ctypes
from typing import Callable, Union

from . import _abi, interrupt
from ._library import Watch, read_failures

# offset, buffer: fill it and return the number of bytes read, or None for bytes that are not there yet; called from any
# thread, several at once
ReadAt = Callable[[int, memoryview], Union[int, None]]
# size and read_at, and a merge_gap where reads cost time
Source = Union[tuple[int, ReadAt], tuple[int, ReadAt, int]]
# offset, bytes: write all of them there; an exception fails the call
WriteAt = Callable[[int, memoryview], None]
# all that was written is to be durable; an exception fails the call
Flush = Callable[[], None]


def read_stream(source: Source) -> _abi.ReadStream:
    size, read_at, *gap = source

    def read(_user: int | None, offset: int, buffer: int, wanted: int) -> int:
        try:
            with interrupt.host_code:
                done = read_at(offset, memoryview((ctypes.c_char * wanted).from_address(buffer)).cast("B"))
            return _abi.READ_WOULD_BLOCK if done is None else done
        except Exception as error:  # it may be in a thread of the library: the call fails with IO, of which this is the cause
            read_failures.append(error)
            return -1
        except BaseException:  # Ctrl-C
            interrupt.interrupt()
            return -1

    return _abi.ReadStream(size=size, read_at=_abi.bccsplat_read_at_fn(read), merge_gap=gap[0] if gap else 0)


def write_stream(write_at: WriteAt, watch: Watch, flush: Flush | None = None) -> _abi.WriteStream:
    """What the functions raise comes out of the call that `watch` is given to."""

    def write(_user: int | None, offset: int, buffer: int, size: int) -> int:
        try:
            with interrupt.host_code:
                write_at(offset, memoryview((ctypes.c_char * size).from_address(buffer)).cast("B").toreadonly())
            return size
        except BaseException as error:
            watch.error = error
            return -1

    def flushed(_user: int | None) -> int:
        try:
            if flush is not None:
                with interrupt.host_code:
                    flush()
            return 0
        except BaseException as error:
            watch.error = error
            return 1

    return _abi.WriteStream(write_at=_abi.bccsplat_write_at_fn(write),
                            flush=_abi.bccsplat_flush_fn(flushed) if flush else _abi.bccsplat_flush_fn(0))
