"""Ctrl-C: while the main thread is in a call of the library, a thread that SIGINT wakes cancels the call's token. The call
returns, and KeyboardInterrupt is raised where it was made; in a function of the host that the call asked, it is raised there.
"""
from __future__ import annotations

import os
import signal
import socket
import threading
from typing import Any, Callable, Sequence


class HostCode(threading.local):
    """With it a callback marks where the host's own code runs."""

    depth = 0

    def __enter__(self) -> None:
        self.depth += 1

    def __exit__(self, *_exception: object) -> None:
        self.depth -= 1


host_code = HostCode()


class Watcher:
    """A thread that sleeps until a signal comes, and cancels what the main thread is in."""

    def __init__(self, cancel: Callable[[Any], None]) -> None:
        self._cancel, self._lock = cancel, threading.RLock()
        self._token: Any = None
        self._fired = False
        self._others = -1  # where somebody else hears of signals
        self._read, self._write = socket.socketpair()
        self._write.setblocking(False)
        self.handler = self._handle  # one object, by which it is known
        threading.Thread(target=self._listen, name="bccsplat-interrupt", daemon=True).start()

    def _fire(self) -> None:
        with self._lock:
            if self._token is not None:
                self._fired = True
                self._cancel(self._token)

    def _listen(self) -> None:
        while heard := self._read.recv(64):
            if signal.SIGINT in heard:
                self._fire()
            if self._others >= 0:
                try:
                    os.write(self._others, heard)
                except OSError:  # full, or closed meanwhile
                    pass

    def _handle(self, _signal: int, _frame: Any) -> None:
        """In the main thread, at a callback or after the call. In a callback an exception would be lost."""
        if host_code.depth:
            raise KeyboardInterrupt
        self._fire()

    def run(self, token: Any, reset: Callable[[Any], None], function: Callable[..., int],
            arguments: Sequence[Any]) -> int:
        """The call, which ends with KeyboardInterrupt where SIGINT comes."""
        handled, heard = signal.getsignal(signal.SIGINT), -1
        outer, depth, host_code.depth = (self._token, self._fired), host_code.depth, 0
        with self._lock:
            self._token, self._fired = token, False
        signal.signal(signal.SIGINT, self.handler)
        try:
            heard = signal.set_wakeup_fd(self._write.fileno(), warn_on_full_buffer=False)
            if heard != self._write.fileno():
                self._others = heard
            status = function(*arguments)
        finally:
            signal.set_wakeup_fd(heard)
            signal.signal(signal.SIGINT, handled)
            with self._lock:
                fired, (self._token, self._fired), host_code.depth = self._fired, outer, depth
                if heard != self._write.fileno():
                    self._others = -1
            if fired:
                reset(token)
        if fired:
            raise KeyboardInterrupt
        return status


_watcher: Watcher | None = None


def _forget() -> None:
    global _watcher
    if _watcher is not None and signal.getsignal(signal.SIGINT) is _watcher.handler:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    _watcher = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)  # a child has no threads


def is_answered() -> bool:
    """Whether this is the main thread, and SIGINT raises KeyboardInterrupt in it."""
    if threading.current_thread() is not threading.main_thread():
        return False
    handler = signal.getsignal(signal.SIGINT)
    return handler is signal.default_int_handler or (_watcher is not None and handler is _watcher.handler)


def run(token: Any, cancel: Callable[[Any], None], reset: Callable[[Any], None], function: Callable[..., int],
        arguments: Sequence[Any]) -> int:
    """Calls a function of the library that looks at a token."""
    global _watcher
    if not is_answered():
        return function(*arguments)
    if _watcher is None:
        _watcher = Watcher(cancel)
    return _watcher.run(token, reset, function, arguments)


def interrupt() -> None:
    """Ends the call that the main thread is in, whose callback was interrupted and has nobody to tell."""
    if _watcher is not None:
        _watcher._fire()
