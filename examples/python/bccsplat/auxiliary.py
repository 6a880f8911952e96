"""Variables beside the fields: small ones of one dimension or none, such as the number of a run or the weights of levels. A file
keeps them as records variable.NAME; what is larger is no attribute of a file and is refused by name."""
from __future__ import annotations

import json
from importlib import import_module
from typing import Any, Mapping

import numpy as np

from . import records
from .arrays import Array

xarray: Any = import_module("xarray")
conventions: Any = import_module("xarray.conventions")

PREFIX = "variable."
_LARGEST = 4096


def is_small(variable: Any) -> bool:
    """Whether a file keeps it as a record."""
    return bool(variable.ndim <= 1 and variable.size <= _LARGEST and variable.dtype.kind in "biufUSOmM")


def encoded(values: Array) -> list[Any]:
    """Numbers and texts as JSON has them; NaN and infinities are texts."""
    flat = values.reshape(-1)
    if flat.dtype.kind == "f":
        return [float(value) if np.isfinite(value) else str(value) for value in flat]
    return [value.decode() if isinstance(value, bytes) else value for value in flat.tolist()]


def record_of(variable: Any, is_coordinate: bool) -> str:
    """The record of a variable of xarray."""
    plain = conventions.encode_cf_variable(variable.variable.copy(deep=False))
    values = np.asarray(plain.values)
    kind = "characters" if variable.dtype.kind == "U" else "text" if values.dtype.kind in "OUS" else values.dtype.name
    if kind == "text" and not all(isinstance(value, (str, bytes)) for value in values.reshape(-1).tolist()):
        raise ValueError("%s holds neither numbers nor texts nor dates, which no file keeps: drop it" % variable.name)
    kept = json.loads(json.dumps(dict(plain.attrs), default=records.plain), parse_constant=str)
    return json.dumps({"dims": [*map(str, plain.dims)], "type": kind, "values": encoded(values), "attributes": kept,
                       "coordinate": is_coordinate}, ensure_ascii=False)


def names(attributes: Mapping[str, str]) -> list[str]:
    """Of the variables that a file keeps so."""
    return [key[len(PREFIX):] for key in attributes if key.startswith(PREFIX)]


def read(attributes: Mapping[str, str], name: str, decode_times: bool) -> tuple[Any, bool]:
    """The variable of that name, and whether it is a coordinate."""
    record = records.read(attributes, PREFIX + name)
    values: Array = np.array(record["values"], {"text": object, "characters": str}.get(record["type"], record["type"]))
    made = xarray.Variable(record["dims"], values.reshape(values.shape if record["dims"] else ()),
                           records.arrays_of(record["attributes"]))
    if decode_times:
        try:
            made = conventions.decode_cf_variable(name, made)
        except (ValueError, OverflowError):  # such as months: the numbers say more than an error
            pass
    made.encoding["bcc4_beside"] = True
    return made, bool(record["coordinate"])
