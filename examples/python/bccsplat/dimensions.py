"""Which dimension of a dataset is time, z, y or x: as its coordinate's attributes say, as CF has them, else its name, and where
neither does its place among the others."""
from __future__ import annotations

from typing import Any, Sequence

ROLES = "tzyx"

_STANDARD = {"time": "t", "forecast_period": "t", "longitude": "x", "grid_longitude": "x", "projection_x_coordinate": "x",
             "latitude": "y", "grid_latitude": "y", "projection_y_coordinate": "y"}
_UNITS = {"x": ("degrees_east", "degree_east", "degree_e", "degrees_e"),
          "y": ("degrees_north", "degree_north", "degree_n", "degrees_n"),
          "z": ("hpa", "pa", "mbar", "millibar", "millibars"),
          "t": ("s", "sec", "second", "seconds", "min", "minute", "minutes", "h", "hr", "hour", "hours", "d", "day", "days", "ms")}
_NAMES = {"t": ("t", "time", "times", "frame", "frames", "step", "timestep"), "x": ("x", "lon", "longitude", "nx", "xdim"),
          "y": ("y", "lat", "latitude", "ny", "ydim"),
          "z": ("z", "lev", "level", "depth", "height", "altitude", "nz", "zdim", "plev", "pressure")}


def role_by_attributes(coordinate: Any) -> str | None:
    """One of t, z, y, x, as the attributes of a coordinate say, or that it holds dates."""
    attrs = {key: str(coordinate.attrs.get(key, "")).lower() for key in ("axis", "units", "standard_name", "positive")}
    if attrs["axis"] in tuple(ROLES):
        return attrs["axis"]
    is_dates = coordinate.dtype.kind in "mM" or (coordinate.dtype.kind == "O" and coordinate.size and
                                                 hasattr(coordinate.values.flat[0], "timetuple"))
    if is_dates or " since " in attrs["units"]:
        return "t"
    by_units = next((role for role, units in _UNITS.items() if attrs["units"] in units), None)
    if by_units in ("x", "y") or attrs["standard_name"] in _STANDARD:
        return _STANDARD.get(attrs["standard_name"], by_units)
    return "z" if attrs["positive"] in ("up", "down") else by_units


def role_by_name(name: Any) -> str | None:
    """The same by the name of a dimension."""
    return next((role for role, names in _NAMES.items() if str(name).lower() in names), None)


def roles_of(dataset: Any, names: Sequence[Any]) -> dict[str, Any]:
    """The name of the dimension that is time, z, y and x each, of three or four. Of three that are not all of space the
    one of these that is missing has one sample; ValueError where two are one."""
    found: dict[str, Any] = {}
    for name in names:
        role = role_by_attributes(dataset[name]) if name in dataset.coords else None
        if role is not None and role in found:
            raise ValueError("%s and %s are both %s by their attributes: give dims=, the names of the dimensions of time, z, "
                             "y and x" % (found[role], name, role))
        if role is not None:
            found[role] = name
    for name in names:
        role = role_by_name(name)
        if role is not None and role not in found and name not in found.values():
            found[role] = name
    rest = [name for name in names if name not in found.values()]
    free = [role for role in ROLES if role not in found]
    if len(names) == 3 and len(rest) < len(free) and "t" in free:
        free.remove("t")
    found.update(zip(free[-len(rest):] if rest else [], rest))
    return found
