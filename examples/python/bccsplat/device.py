"""Device: threads, memory budget, log."""
from __future__ import annotations

import sys
from ctypes import byref, c_void_p
from typing import Callable

from . import _abi
from ._library import Handle, call, choose, decode

# level ("warning" or "info"), message
Log = Callable[[str, str], None]
# count, body: run body(i) once for each i in range(count), in any order and on any threads, and return when all have.
Runner = Callable[[int, Callable[[int], None]], None]


class Device(Handle):
    """Threads and memory that volumes, writers and renderers share.

    threads: 0 for as many as the machine has. memory_budget: bytes that objects may hold for data, 0 for no limit.
    A runner replaces the device's own threads by the host's. max_reads: reads of volumes in flight, 0 for no limit.
    backend: "auto", "cpu" or "gpu", what pictures are drawn by. gpu_memory: bytes of volumes on the GPU, 0 for what it
    has.
    """

    _kind = "device"

    def __init__(self, threads: int = 0, memory_budget: int = 0, log: Log | None = None, runner: Runner | None = None,
                 max_sites: int = 0, max_reads: int = 0, backend: int | str | None = None,
                 gpu_memory: int = 0) -> None:
        super().__init__()
        options = _abi.DeviceOptions(thread_count=threads, memory_budget=memory_budget, max_sites=max_sites,
                                     max_reads=max_reads, backend=choose("BACKEND", backend),
                                     gpu_memory=gpu_memory)
        levels = {_abi.LOG_WARNING: "warning", _abi.LOG_INFO: "info"}

        def write_log(_user: int | None, level: int, message: bytes | None) -> None:
            assert log is not None
            log(levels.get(level, str(level)), decode(message))

        def run(_user: int | None, count: int, body: Callable[[int | None, int], None], task: int | None) -> None:
            assert runner is not None
            done = bytearray(count)

            def one(index: int) -> None:
                done[index] = 1
                body(task, index)

            try:
                runner(count, one)
            except Exception:
                sys.excepthook(*sys.exc_info())
            while (left := done.find(0)) >= 0:  # by a runner that raised: the library counts on every index
                one(left)

        # Kept as long as the device's Python objects: children of the device hold `_callbacks` too.
        self._callbacks = (_abi.bccsplat_log_fn(write_log) if log else _abi.bccsplat_log_fn(0),
                           _abi.bccsplat_runner_fn(run) if runner else _abi.bccsplat_runner_fn(0))
        options.log, options.runner = self._callbacks
        self._create("device_create", byref(options))

    def info(self) -> _abi.DeviceInfo:
        """Threads, and bytes of memory: the limit, held now, and held at most."""
        info = _abi.DeviceInfo()
        call("device_get_info", self.pointer, byref(info))
        return info

    def gpu_info(self) -> _abi.GpuInfo:
        """What the GPU is. Raises an error where there is none, with the reason."""
        info = _abi.GpuInfo()
        call("device_get_gpu_info", self.pointer, byref(info))
        return info


class Child(Handle):
    """An object that keeps its device, and the callbacks behind it, alive."""

    def __init__(self, device: Device) -> None:
        super().__init__()
        if not isinstance(device, Device):
            raise TypeError("device must be a bccsplat.Device, not %r" % (device,))
        self.device = device


def pointer_of(handle: Handle | None) -> c_void_p | None:
    return None if handle is None else handle.pointer
