"""What the structs of the C interface are in Python: texts are str, arrays that a pointer looks at are given as they are and live as
long as the struct, and a number is never taken for an address."""
from __future__ import annotations

import ctypes
from ctypes import Array, Structure, c_char_p, c_void_p, sizeof
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

# Numbers in a row, and all numbers, of pointers whose count is not that of single numbers.
_WIDTHS = {("TransferFunction", "colors"): 4, ("TransferFunction", "opacities"): 2}
_SIZES = {("SliceOptions", "point"): 4, ("SliceOptions", "basis"): 12, ("SliceOptions", "box"): 6}


@lru_cache(maxsize=None)
def kinds_of(struct: type[Structure]) -> dict[str, Any]:
    """The ctypes type of each field."""
    return {field[0]: field[1] for field in struct._fields_}


def is_pointer(kind: Any) -> bool:
    """Whether fields of that type hold an address, which only ctypes may make."""
    return isinstance(kind, type) and (kind is c_void_p or issubclass(kind, ctypes._Pointer))


@lru_cache(maxsize=None)
def counter_of(struct: type[Structure], name: str) -> str | None:
    """The field that counts what a pointer looks at: color_count of colors, or the struct's only count."""
    single = name[:-3] + "y" if name.endswith("ies") else name[:-1]
    return next((count for count in (single + "_count", "count") if count in kinds_of(struct)), None)


class Fields(Structure):
    """A struct whose fields take and give what Python has: see the top of this module."""

    if not TYPE_CHECKING:  # which would find no misspelt field any more

        def __getattribute__(self, name: str) -> Any:
            value = super().__getattribute__(name)
            if isinstance(value, bytes):
                return value.decode(errors="replace")
            return "" if value is None and kinds_of(type(self)).get(name) is c_char_p else value

        def __setattr__(self, name: str, value: Any) -> None:
            kind = kinds_of(type(self)).get(name)
            if kind is c_char_p:
                value = self._text(name, value)
            elif is_pointer(kind):
                value = self._pointer(name, kind, value)
            elif value is not None and name in (most := self.__dict__.get("_counts", {})) and value > most[name]:
                raise ValueError(f"{name} of {type(self).__name__} cannot be {value}: {most[name]} are given")
            super().__setattr__(name, value)

    def _text(self, name: str, value: Any) -> bytes | None:
        if value is not None and not isinstance(value, (str, bytes)):
            raise TypeError(f"{name} of {type(self).__name__} is a text, not {value!r}")
        return value.encode() if isinstance(value, str) else value

    def _pointer(self, name: str, kind: Any, value: Any) -> Any:
        """What ctypes takes for a pointer. Arrays of its type are looked into; others, and sequences, are copied."""
        if value is None or isinstance(value, kind):
            return value
        count, made = counter_of(type(self), name), None
        if kind is c_void_p:
            wanted = "an array of numpy, or a handle"
            made = self._memory(name, value)
        elif issubclass(kind._type_, Structure):
            wanted = f"a {kind._type_.__name__}" + (", or a sequence of these" if count or name.endswith("s") else "")
            made = array_of_structs(kind._type_, [value] if count and isinstance(value, Structure) else value)
        else:
            wanted = "a sequence or an array of numbers"
            made = self._numbers(name, kind._type_, value)
        if made is None:
            raise TypeError(f"{name} of {type(self).__name__} is {wanted}, not {value!r}")
        if isinstance(made, Array) and count:
            rows = len(made) // _WIDTHS.get((type(self).__name__, name), 1)
            self.__dict__.setdefault("_counts", {})[count] = rows
            setattr(self, count, rows)
        return made

    def _memory(self, name: str, value: Any) -> c_void_p | None:
        if (handle := getattr(value, "pointer", None)) is not None and isinstance(handle, c_void_p):
            self.__dict__.setdefault("_held", {})[name] = value
            return handle
        if isinstance(value, (Array, Structure, ctypes._Pointer)):
            return ctypes.cast(value if isinstance(value, ctypes._Pointer) else ctypes.pointer(value), c_void_p)
        if isinstance(value, np.ndarray):
            address: c_void_p = value.ctypes.data_as(c_void_p)  # which holds the array
            self.__dict__.setdefault("_held", {})[name] = value
            return address
        return None

    def _numbers(self, name: str, kind: Any, values: Any) -> Any:
        """An array of ctypes of numbers in order; None of what is none."""
        if isinstance(values, Array) and values._type_ is kind:
            return values
        try:
            found = np.asarray(values)
            if not found.ndim or found.dtype.kind not in "biuf":
                return None
            found = np.ascontiguousarray(found, np.dtype(kind))
        except (TypeError, ValueError):
            return None
        place = type(self).__name__, name
        size, width = _SIZES.get(place), _WIDTHS.get(place, 1)
        if size not in (None, found.size) or (width > 1 and found.shape[1:] != (width,)):
            raise ValueError("%s of %s are %s, not an array of shape %r" %
                             (name, place[0], "%d numbers" % size if size else "rows of %d numbers" % width, found.shape))
        made = kind * found.size
        return made.from_buffer(found) if found.flags.writeable else made.from_buffer_copy(found)


def array_of_structs(kind: Any, value: Any) -> Any:
    """A pointer to one struct, or an array of some; None of what is neither."""
    if isinstance(value, kind):
        return ctypes.pointer(value)
    if isinstance(value, Array):
        return value if value._type_ is kind else None
    if not isinstance(value, Sequence) or not all(isinstance(one, kind) for one in value):
        return None
    return (kind * len(value))(*value)


class Struct(Fields):
    """A cleared struct that knows its size; field values may be given by name, constants by the name of theirs:
    slab="mean" is SLAB_MEAN."""

    struct_size: int

    def __init__(self, **values: Any) -> None:
        from ._abi import constant  # which is made of these
        kinds = kinds_of(type(self))
        for name, value in values.items():
            if name not in kinds:
                near = get_close_matches(name, kinds, 1)
                hint = f"did you mean {near[0]!r}? " if near else ""
                raise TypeError(f"{type(self).__name__} has no {name!r}: {hint}"
                                f"it has {', '.join(type(self).told())}")
            if isinstance(value, str) and kinds[name] is not c_char_p and not is_pointer(kinds[name]):
                values[name] = constant(name.upper(), value)
        super().__init__()
        self.struct_size = sizeof(self)
        for name in sorted(values, key=lambda name: not is_pointer(kinds[name])):  # what these look at is counted
            self._set(name, values[name], is_pointer(kinds[name]) or kinds[name] is c_char_p)

    def _set(self, name: str, value: Any, is_told: bool) -> None:
        try:
            setattr(self, name, value)
        except TypeError as error:
            if is_told:
                raise
            raise TypeError(f"{name} of {type(self).__name__} cannot be {value!r}: {error}") from None
        if isinstance(value, int) and isinstance(kept := getattr(self, name), int) and kept != value:
            raise ValueError(f"{name} of {type(self).__name__} cannot be {value}")

    @classmethod
    def told(cls) -> list[str]:
        """Names of the fields that hold something to read."""
        hidden = ("reserved", "set_mask", "progress")
        return [field[0] for field in cls._fields_[1:] if not field[0].startswith(hidden)]

    def __repr__(self) -> str:
        shown = [(name, getattr(self, name)) for name in type(self).told()]
        texts = [f"{name}={list(value) if isinstance(value, Array) else value!r}" for name, value in shown]
        return f"{type(self).__name__}({', '.join(texts)})"
