"""CancelToken: a wish to stop that stays."""
from __future__ import annotations

from ctypes import byref, c_int32, c_void_p

from ._library import Handle, call


class CancelToken(Handle):
    """Given as `cancel` to volumes, slices, writers, render options and calls that take long. Once cancelled, from any
    thread, those under way and those that come raise Cancelled until it is reset."""

    _kind = "cancel_token"

    def __init__(self) -> None:
        super().__init__()
        self._create("cancel_token_create")

    def cancel(self) -> None:
        """From any thread; those under way end within some milliseconds."""
        call("cancel_token_cancel", self.pointer)

    def reset(self) -> None:
        """For calls to come; those that were under way end all the same."""
        call("cancel_token_reset", self.pointer)

    @property
    def cancelled(self) -> bool:
        """Whether it is cancelled."""
        out = c_int32()
        call("cancel_token_is_cancelled", self.pointer, byref(out))
        return out.value != 0


def token_of(cancel: CancelToken | None) -> c_void_p | None:
    return None if cancel is None else cancel.pointer


def own_token(cancel: CancelToken | None) -> CancelToken:
    """The caller's token, or one that Ctrl-C alone cancels."""
    return CancelToken() if cancel is None else cancel
