"""bccsplat for Python, through ctypes and the standard library only.

    python3 bccsplat.py FILE.bcc4 OUT.png [TIME]

Covers opening, evaluating, slicing and drawing; include/bccsplat.h is the manual and a class or method here is the call
of the same name. Arrays come as memoryviews of floats, which numpy.asarray takes without a copy. The library is found
as libbccsplat.so.0, or where the environment variable BCCSPLAT_LIBRARY says.
"""
import ctypes
import os
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_float, c_int32, c_uint32, c_uint64, c_void_p

_library = ctypes.CDLL(os.environ.get("BCCSPLAT_LIBRARY", "libbccsplat.so.0"))


def _function(name, result, *arguments):
    function = getattr(_library, "bccsplat_" + name)
    function.restype, function.argtypes = result, arguments
    return function


_status_name = _function("status_name", c_char_p, c_int32)
_last_error = _function("last_error", c_char_p)


class Error(Exception):
    """A call that failed: `status` is the number, `name` its name."""

    def __init__(self, status):
        self.status, self.name = status, _status_name(status).decode()
        super().__init__(f"{_last_error().decode()} ({self.name})")


def _call(name, *arguments):
    """Declares a call that returns a status as a function that raises Error."""
    function = _function(name, c_int32, *arguments)

    def checked(*values):
        status = function(*values)
        if status != 0:
            raise Error(status)

    return checked


class _Struct(ctypes.Structure):
    """A cleared struct that knows its size; field values may be given by name."""

    def __init__(self, **values):
        super().__init__(struct_size=ctypes.sizeof(self), **values)


class VolumeInfo(_Struct):
    _fields_ = [("struct_size", c_uint32), ("lattice", c_int32), ("dims", c_uint64 * 4), ("cc_samples", c_uint64),
                ("sites_total", c_uint64), ("layer_count", c_uint64), ("scale", c_double), ("time_scale", c_double),
                ("affine", c_double * 16), ("time_first", c_double), ("time_last", c_double),
                ("mean_voxel", c_double), ("spatial_unit", c_char_p), ("time_unit", c_char_p), ("kernel", c_char_p),
                ("recommended_kernel", c_char_p), ("channel_count", c_uint32), ("time_uniform", c_int32),
                ("store", c_int32), ("has_holes", c_int32), ("bytes_file", c_uint64), ("bytes_runs", c_uint64),
                ("bytes_values", c_uint64), ("bytes_index", c_uint64), ("bytes_read", c_uint64),
                ("attribute_count", c_uint64)]


class Hyperplane(_Struct):
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("a", c_double), ("b", c_double), ("c", c_double),
                ("d", c_double), ("e", c_double)]


class SliceInfo(_Struct):
    _fields_ = [("struct_size", c_uint32), ("lattice", c_int32), ("hyperplane", c_double * 5), ("origin", c_double * 4),
                ("basis", c_double * 4 * 3), ("extent", c_double * 2 * 3), ("dims", c_uint64 * 3),
                ("affine", c_double * 16), ("bounds", c_double * 2), ("air", c_double), ("points", c_uint64),
                ("bytes_read", c_uint64), ("milliseconds", c_double), ("kernel", c_char_p)]


class Plane(_Struct):
    _fields_ = [("struct_size", c_uint32), ("components", c_uint32), ("width", c_uint32), ("height", c_uint32),
                ("pixels", POINTER(c_float)), ("row_bytes", c_uint64)]


class ImageOptions(_Struct):
    _fields_ = [("struct_size", c_uint32), ("overwrite", c_int32), ("use_background", c_uint32),
                ("reserved", c_uint32), ("background", c_double * 3)]


class _Handle:
    """Owns one reference to an object of the library."""

    def __init__(self, kind):
        self._release = _function(kind + "_release", None, c_void_p)
        self.pointer = c_void_p()

    def __del__(self):
        self._release(self.pointer)


class Device(_Handle):
    _create = staticmethod(_call("device_create", c_void_p, POINTER(c_void_p)))

    def __init__(self):
        super().__init__("device")
        self._create(None, byref(self.pointer))


class Volume(_Handle):
    _open_file = staticmethod(_call("volume_open_file", c_void_p, c_char_p, c_void_p, POINTER(c_void_p)))
    _get_info = staticmethod(_call("volume_get_info", c_void_p, POINTER(VolumeInfo)))
    _time_to_index = staticmethod(_call("volume_time_to_index", c_void_p, c_double, POINTER(c_double)))
    _evaluate = staticmethod(_call("volume_evaluate", c_void_p, c_uint64, POINTER(c_double), POINTER(c_float), c_void_p))

    def __init__(self, device, path):
        super().__init__("volume")
        self._open_file(device.pointer, os.fsencode(path), None, byref(self.pointer))

    def info(self):
        info = VolumeInfo()
        self._get_info(self.pointer, byref(info))
        return info

    def time_to_index(self, time):
        index = c_double()
        self._time_to_index(self.pointer, time, byref(index))
        return index.value

    def evaluate(self, points):
        """Values at points (x, y, z, t) of index space."""
        flat = [coordinate for point in points for coordinate in point]
        values = (c_float * (len(flat) // 4))()
        self._evaluate(self.pointer, len(values), (c_double * len(flat))(*flat), values, None)
        return memoryview(values).cast("B").cast("f")


class Slice(_Handle):
    _create = staticmethod(_call("slice_create", c_void_p, POINTER(Hyperplane), c_void_p, POINTER(c_void_p)))
    _get_info = staticmethod(_call("slice_get_info", c_void_p, POINTER(SliceInfo)))
    _sample_grid = staticmethod(_call("slice_sample_grid", c_void_p, c_void_p, POINTER(c_float)))

    def __init__(self, volume, a, b, c, d, e):
        super().__init__("slice")
        self._create(volume.pointer, byref(Hyperplane(a=a, b=b, c=c, d=d, e=e)), None, byref(self.pointer))

    @classmethod
    def at(cls, volume, frame):
        """The time slice at a frame number, which may be fractional."""
        return cls(volume, 0, 0, 0, 1, -frame)

    def info(self):
        info = SliceInfo()
        self._get_info(self.pointer, byref(info))
        return info

    def sample_grid(self):
        """The dense box at the source's resolution, indexed [z, y, x]."""
        nx, ny, nz = self.info().dims
        values = (c_float * (nx * ny * nz))()
        self._sample_grid(self.pointer, None, values)
        return memoryview(values).cast("B").cast("f", (nz, ny, nx))


class Frame(_Handle):
    RGBA = 1
    _create = staticmethod(_call("frame_create", c_void_p, c_uint32, c_uint32, c_uint32, POINTER(c_void_p)))
    _get_channel = staticmethod(_call("frame_get_channel", c_void_p, c_uint32, POINTER(Plane)))
    _save_png = staticmethod(_call("frame_save_png", c_void_p, c_char_p, POINTER(ImageOptions)))

    def __init__(self, device, width, height, channels=RGBA):
        super().__init__("frame")
        self._create(device.pointer, width, height, channels, byref(self.pointer))

    def rgba(self):
        """A copy of the pixels, linear and premultiplied, indexed [row, column, component]."""
        plane = Plane()
        self._get_channel(self.pointer, self.RGBA, byref(plane))
        rows = b"".join(ctypes.string_at(ctypes.addressof(plane.pixels.contents) + y * plane.row_bytes, plane.width * 16)
                        for y in range(plane.height))
        return memoryview(rows).cast("f", (plane.height, plane.width, 4))

    def save_png(self, path, overwrite=False):
        self._save_png(self.pointer, os.fsencode(path), byref(ImageOptions(overwrite=overwrite)))


class Renderer(_Handle):
    _create = staticmethod(_call("renderer_create", c_void_p, POINTER(c_void_p)))
    _set_slice = staticmethod(_call("renderer_set_slice", c_void_p, c_void_p))
    _render = staticmethod(_call("renderer_render", c_void_p, c_void_p))

    def __init__(self, device):
        super().__init__("renderer")
        self._create(device.pointer, byref(self.pointer))

    def set_slice(self, cut):
        self._set_slice(self.pointer, cut.pointer)

    def render(self, frame):
        self._render(self.pointer, frame.pointer)


def main(path, picture, time=None):
    device = Device()
    volume = Volume(device, path)
    frame_number = volume.time_to_index(float(time)) if time else (volume.info().dims[3] - 1) / 2
    renderer = Renderer(device)
    renderer.set_slice(Slice.at(volume, frame_number))
    frame = Frame(device, 512, 512)
    renderer.render(frame)
    frame.save_png(picture, overwrite=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
