"""Ctrl-C: while the main thread is in a call of the library, the interpreter's own handler of SIGINT wakes a thread that
cancels the call's token. The call returns, and KeyboardInterrupt is raised as anywhere else in Python."""
from __future__ import annotations

import os
import signal
import socket
import threading
from typing import Any, Callable, Sequence


class Watcher:
    """A thread that sleeps until a signal comes, and cancels what the main thread is in."""

    def __init__(self, cancel: Callable[[Any], None]) -> None:
        self._cancel, self._lock = cancel, threading.Lock()
        self._token: Any = None
        self.fired = False
        self._others = -1  # where somebody else hears of signals
        self._read, self._write = socket.socketpair()
        self._write.setblocking(False)
        threading.Thread(target=self._listen, name="bccsplat-interrupt", daemon=True).start()

    def _listen(self) -> None:
        while heard := self._read.recv(64):
            with self._lock:
                if signal.SIGINT in heard and self._token is not None:
                    self.fired = True
                    self._cancel(self._token)
                others = self._others
            if others >= 0:
                try:
                    os.write(others, heard)
                except OSError:  # full, or closed meanwhile
                    pass

    def run(self, token: Any, reset: Callable[[Any], None], function: Callable[..., int],
            arguments: Sequence[Any]) -> int:
        """The call, which ends with KeyboardInterrupt where SIGINT comes."""
        before = signal.set_wakeup_fd(self._write.fileno(), warn_on_full_buffer=False)
        outer = self._token
        with self._lock:
            self._token = token
            if before != self._write.fileno():
                self._others = before
        try:
            status = function(*arguments)
        finally:
            with self._lock:
                self._token, fired, self.fired = outer, self.fired, False
                if before != self._write.fileno():
                    self._others = -1
            signal.set_wakeup_fd(before)
            if fired:
                reset(token)
        if fired:
            raise KeyboardInterrupt
        return status


_watcher: Watcher | None = None


def _forget() -> None:
    global _watcher
    _watcher = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)  # a child has no threads


def is_answered() -> bool:
    """Whether this is the main thread, and SIGINT raises KeyboardInterrupt in it."""
    return threading.current_thread() is threading.main_thread() and \
        signal.getsignal(signal.SIGINT) is signal.default_int_handler


def run(token: Any, cancel: Callable[[Any], None], reset: Callable[[Any], None], function: Callable[..., int],
        arguments: Sequence[Any]) -> int:
    """Calls a function of the library that looks at a token."""
    global _watcher
    if not is_answered():
        return function(*arguments)
    if _watcher is None:
        _watcher = Watcher(cancel)
    return _watcher.run(token, reset, function, arguments)


def remember() -> None:
    """Of a KeyboardInterrupt that came in a callback which cannot raise it."""
    if _watcher is not None:
        _watcher.fired = True
