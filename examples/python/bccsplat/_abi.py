"""The C declarations of bccsplat.h, written by tests/abi/python_abi.py: do not edit."""
# fmt: off
from __future__ import annotations

from ctypes import (CFUNCTYPE, POINTER, Array, c_char_p, c_double, c_float, c_int32, c_int64, c_uint32,
                    c_uint64, c_void_p)
from typing import TYPE_CHECKING, Any

from ._structs import Fields, Struct

VERSION_MAJOR = 0
VERSION_MINOR = 1
VERSION_PATCH = 0
ABI_VERSION = 0
OK = 0
ERROR_INVALID_ARGUMENT = 1
ERROR_INVALID_STRUCT_SIZE = 2
ERROR_INVALID_HANDLE = 3
ERROR_WRONG_STATE = 4
ERROR_OUT_OF_DOMAIN = 5
ERROR_UNSUPPORTED = 6
ERROR_NOT_FOUND = 7
ERROR_NOT_BCC4 = 16
ERROR_UNSUPPORTED_VERSION = 17
ERROR_CORRUPT = 18
ERROR_TRUNCATED = 19
ERROR_CHECKSUM_MISMATCH = 20
ERROR_LIMIT_EXCEEDED = 21
ERROR_NONFINITE_VALUE = 22
ERROR_BOUND_NOT_MET = 23
ERROR_HOLE = 24
ERROR_OUT_OF_MEMORY = 32
ERROR_IO = 33
ERROR_FILE_NOT_FOUND = 34
ERROR_NO_SPACE = 35
ERROR_PERMISSION_DENIED = 36
ERROR_FILE_EXISTS = 37
ERROR_MEMORY_BUDGET = 38
ERROR_MISSING_FEATURE = 39
ERROR_WOULD_BLOCK = 40
CANCELLED = 48
ERROR_INTERNAL = 64
LOG_WARNING = 1
LOG_INFO = 2
BACKEND_DEFAULT = 0
BACKEND_AUTO = 1
BACKEND_CPU = 2
BACKEND_GPU = 3
READ_WOULD_BLOCK = -65536
TYPE_DEFAULT = 0
TYPE_U8 = 1
TYPE_U16 = 2
TYPE_F16 = 3
TYPE_F32 = 4
TYPE_I16 = 5
TYPE_I32 = 6
TYPE_F64 = 7
TYPE_I8 = 8
TYPE_U32 = 9
LATTICE_DEFAULT = 0
LATTICE_D4STAR = 1
LATTICE_BCC = 2
LATTICE_CC = 3
STORE_DEFAULT = 0
STORE_SAMPLES = 1
STORE_WAVELETS = 3
NONFINITE_DEFAULT = 0
NONFINITE_ERROR = 1
NONFINITE_HOLE = 2
NONFINITE_CLAMP = 3
MEASURE_DEFAULT = 0
MEASURE_SOME = 1
MEASURE_ALL = 2
ENDS_DEFAULT = 0
ENDS_PREDICT = 1
ENDS_MIRROR = 2
ENDS_PERIODIC = 3
FACES_DEFAULT = 0
FACES_PREDICT = 1
FACES_MIRROR = 2
FACES_PREDICT_X = 4
FACES_PREDICT_Y = 8
FACES_PREDICT_Z = 16
PERIODIC_X = 1
PERIODIC_Y = 2
PERIODIC_Z = 4
CHANNEL_SET_AIR = 1
CHANNEL_SET_RANGE = 2
CHANNEL_LABELS = 4
CHANNEL_QUANTITIES = 8
PARTIAL_DEFAULT = 0
PARTIAL_KEEP = 1
PARTIAL_RESUME = 2
PARTIAL_APPEND = 3
AXIS_DOWN = 1
PLAN_SET_LEVELS = 1
PLAN_AUTO_TIME_SCALE = 2
PLAN_EVERYTHING = 4
PLAN_ANY_THREAD = 8
PLAN_LARGE_FRAMES = 16
SERIES_FINISHED = 0
SERIES_UNFINISHED = 1
SERIES_OPEN_END = 2
SLAB_DEFAULT = 0
SLAB_MEAN = 1
SLAB_SUM = 2
SLAB_MAXIMUM = 3
METHOD_DEFAULT = 0
METHOD_MERGED = 1
METHOD_RESAMPLED = 2
METHOD_EXTRACTED = 3
SPACE_DEFAULT = 0
SPACE_INDEX = 1
SPACE_EVEN = 2
MOTION_DEFAULT = 0
MOTION_OFF = 1
MOTION_ON = 2
RANGES_MISSING = 1
BRICK_GRID_DEFAULT = 0
BRICK_GRID_SAMPLES = 1
BRICK_GRID_SITES = 2
PROJECTION_DEFAULT = 0
PROJECTION_ORTHOGRAPHIC = 1
PROJECTION_PERSPECTIVE = 2
SIDE_DEFAULT = 0
SIDE_BACK = 1
SIDE_FRONT = 2
SIDE_ANTERIOR_RAS = 3
SIDE_ANTERIOR_LPS = 4
DEPTH_RANGE_DEFAULT = 0
DEPTH_RANGE_ZERO_ONE = 1
DEPTH_RANGE_MINUS_ONE_ONE = 2
DEPTH_RANGE_REVERSED = 3
DEPTH_DEFAULT = 0
DEPTH_PLANAR = 1
DEPTH_RAY = 2
DEPTH_DEVICE = 3
CLIP_SPACE_DEFAULT = 0
CLIP_SPACE_WORLD = 1
CLIP_SPACE_VOLUME = 2
MAX_CLIPS = 32
MODE_DEFAULT = 0
MODE_COMPOSITE = 1
MODE_ISOSURFACE = 2
MODE_XRAY = 3
MODE_MAXIMUM = 4
LOOK_DEFAULT = 0
LOOK_CT_BONE = 1
LOOK_CT_SOFT = 2
LOOK_MR = 3
LOOK_FOG = 4
LOOK_FIRE = 5
LOOK_SIGNED = 6
LOOK_LABELS = 7
KIND_EMPTY = 0
KIND_CONSTANT = 1
KIND_LABELS = 2
KIND_LEVEL_SET = 3
KIND_SIGNED = 4
KIND_SOLID = 5
KIND_FOG = 6
KIND_DENSE = 7
LAYOUT_DEFAULT = 0
LAYOUT_VOLUME = 1
LAYOUT_PLANES = 2
LAYOUT_BOTH = 3
LAYOUT_FLAT = 4
PICK_VALUE = 1
PICK_MAXIMUM = 2
PICK_OPACITY = 3
QUALITY_DEFAULT = 0
QUALITY_DRAFT = 1
QUALITY_NORMAL = 2
QUALITY_FINE = 3
QUALITY_BEST = 4
SHADING_DEFAULT = 0
SHADING_OFF = 1
SHADING_ON = 2
PREINTEGRATE_DEFAULT = 0
PREINTEGRATE_OFF = 1
PREINTEGRATE_ON = 2
SMOOTH_EDGES_DEFAULT = 0
SMOOTH_EDGES_OFF = 1
SMOOTH_EDGES_ON = 2
SKIP_TRANSFER_FUNCTION = 1
SKIP_FRUSTUM = 2
SKIP_OCCLUSION = 4
SKIP_EMPTY_SHEETS = 8
SKIP_FINE_DETAIL = 16
SKIP_UNCHANGED = 32
RENDER_SET_ISO = 1
RENDER_SET_GRADIENT_NOISE = 2
MAX_ISO_SURFACES = 16
TRAIL_CONTENT_DEFAULT = 0
TRAIL_CLASSIFIED = 1
TRAIL_MEAN = 2
TRAIL_MAXIMUM = 3
TRAIL_COMBINE_DEFAULT = 0
TRAIL_PHYSICAL = 1
TRAIL_INTERLEAVED = 2
FRAME_RGBA = 1
FRAME_DEPTH = 2
FRAME_VALUE = 4
FRAME_TIME = 8
FRAME_DEEP = 16
IMAGE_PNG = 1
IMAGE_EXR = 2
IMAGE_DEEP_EXR = 3
PIXELS_F32 = 1
PIXELS_F16 = 2
PIXELS_SRGB8 = 3
PIXELS_SRGB8_PREMULTIPLIED = 4
OUTSIDE_DEFAULT = 0
OUTSIDE_HIDE = 1
OUTSIDE_HOLD = 2
OUTSIDE_LOOP = 3
INSTANCE_SET_COLOR_CHANNEL = 1
INSTANCE_SET_MASK_CHANNEL = 2

bccsplat_progress_fn = CFUNCTYPE(c_int32, c_void_p, c_double)
bccsplat_log_fn = CFUNCTYPE(None, c_void_p, c_int32, c_char_p)
bccsplat_task_fn = CFUNCTYPE(None, c_void_p, c_uint64)
bccsplat_runner_fn = CFUNCTYPE(None, c_void_p, c_uint64, bccsplat_task_fn, c_void_p)
bccsplat_read_at_fn = CFUNCTYPE(c_int64, c_void_p, c_uint64, c_void_p, c_uint64)
bccsplat_write_at_fn = CFUNCTYPE(c_int64, c_void_p, c_uint64, c_void_p, c_uint64)
bccsplat_flush_fn = CFUNCTYPE(c_int32, c_void_p)
bccsplat_field_fn = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_void_p, c_void_p)
bccsplat_source_fn = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_uint32, c_void_p)
bccsplat_release_fn = CFUNCTYPE(None, c_void_p)
bccsplat_tile_fn = CFUNCTYPE(c_int32, c_void_p, c_uint32, c_uint32, c_uint32, c_uint32)


def constant(kind: str, name: str) -> int:
    """A constant of the header by its name without the prefix: constant("LATTICE", "d4star")."""
    names = [n.removeprefix(kind + "_") for n in globals() if n.startswith(kind + "_")]
    if not names:
        raise ValueError(f"{kind.lower()} is a number, not {name!r}")
    wanted = name.upper().replace("-", "_")
    if wanted not in names:
        raise ValueError(f"{kind.lower()} {name!r} is none of: {', '.join(names).lower()}")
    return int(globals()[kind + "_" + wanted])


class DeviceOptions(Struct):
    thread_count: int
    memory_budget: int
    log: Any
    log_user: Any
    runner: Any
    runner_user: Any
    max_sites: int
    max_reads: int
    reserved: int
    backend: int
    reserved2: int
    gpu_memory: int
    if TYPE_CHECKING:
        def __init__(self, *, thread_count: Any = ..., memory_budget: Any = ..., log: Any = ...,
            log_user: Any = ..., runner: Any = ..., runner_user: Any = ..., max_sites: Any = ...,
            max_reads: Any = ..., backend: Any = ..., gpu_memory: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("thread_count", c_int32), ("memory_budget", c_uint64),
        ("log", bccsplat_log_fn), ("log_user", c_void_p), ("runner", bccsplat_runner_fn),
        ("runner_user", c_void_p), ("max_sites", c_uint64), ("max_reads", c_uint32), ("reserved", c_uint32),
        ("backend", c_int32), ("reserved2", c_uint32), ("gpu_memory", c_uint64)]


class DeviceInfo(Struct):
    thread_count: int
    memory_budget: int
    memory_used: int
    memory_peak: int
    if TYPE_CHECKING:
        def __init__(self, *, thread_count: Any = ..., memory_budget: Any = ..., memory_used: Any = ...,
            memory_peak: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("thread_count", c_int32), ("memory_budget", c_uint64),
        ("memory_used", c_uint64), ("memory_peak", c_uint64)]


class GpuInfo(Struct):
    software: int
    compute: int
    reserved: int
    memory: int
    memory_used: int
    vendor: str
    renderer: str
    version: str
    if TYPE_CHECKING:
        def __init__(self, *, software: Any = ..., compute: Any = ..., memory: Any = ...,
            memory_used: Any = ..., vendor: Any = ..., renderer: Any = ..., version: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("software", c_int32), ("compute", c_int32),
        ("reserved", c_uint32), ("memory", c_uint64), ("memory_used", c_uint64), ("vendor", c_char_p),
        ("renderer", c_char_p), ("version", c_char_p)]


class ReadStream(Struct):
    reserved: int
    size: int
    read_at: Any
    user: Any
    merge_gap: int
    if TYPE_CHECKING:
        def __init__(self, *, size: Any = ..., read_at: Any = ..., user: Any = ...,
            merge_gap: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("size", c_uint64),
        ("read_at", bccsplat_read_at_fn), ("user", c_void_p), ("merge_gap", c_uint64)]


class WriteStream(Struct):
    reserved: int
    write_at: Any
    user: Any
    flush: Any
    if TYPE_CHECKING:
        def __init__(self, *, write_at: Any = ..., user: Any = ..., flush: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("write_at", bccsplat_write_at_fn),
        ("user", c_void_p), ("flush", bccsplat_flush_fn)]


class ChannelOptions(Struct):
    set_mask: int
    name: str
    unit: str
    source_type: int
    value_type: int
    air: float
    air_threshold: float
    range: Array[c_double]
    value_step: float
    if TYPE_CHECKING:
        def __init__(self, *, set_mask: Any = ..., name: Any = ..., unit: Any = ..., source_type: Any = ...,
            value_type: Any = ..., air: Any = ..., air_threshold: Any = ..., range: Any = ...,
            value_step: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("set_mask", c_uint32), ("name", c_char_p), ("unit", c_char_p),
        ("source_type", c_int32), ("value_type", c_int32), ("air", c_double), ("air_threshold", c_double),
        ("range", c_double * 2), ("value_step", c_double)]


class SeriesPart(Struct):
    reserved: int
    first: int
    end: int
    lead: int
    times: Any
    box_begin: Array[c_uint64]
    box_end: Array[c_uint64]
    if TYPE_CHECKING:
        def __init__(self, *, first: Any = ..., end: Any = ..., lead: Any = ..., times: Any = ...,
            box_begin: Any = ..., box_end: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("first", c_uint64), ("end", c_uint64),
        ("lead", c_uint64), ("times", POINTER(c_double)), ("box_begin", c_uint64 * 3),
        ("box_end", c_uint64 * 3)]


class Axis(Struct):
    flags: int
    count: int
    coordinates: Any
    unit: str
    if TYPE_CHECKING:
        def __init__(self, *, flags: Any = ..., count: Any = ..., coordinates: Any = ...,
            unit: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("flags", c_uint32), ("count", c_uint64),
        ("coordinates", POINTER(c_double)), ("unit", c_char_p)]


class WriterOptions(Struct):
    set_mask: int
    dims: Array[c_uint32]
    lattice: int
    store: int
    nonfinite: int
    overwrite: int
    fixed_predictions: int
    channel_count: int
    channels: Any
    affine: Array[c_double]
    spatial_unit: str
    time_unit: str
    scale: float
    time_scale: float
    recommended_kernel: str
    progress: Any
    progress_user: Any
    abs_error: float
    psnr: float
    measure: int
    partial: int
    lowpass: int
    levels: int
    part: Any
    ends: int
    faces: int
    scales: Array[c_double]
    live: int
    periodic_axes: int
    cancel_token: Any
    axes: Any
    wavelet_errors: Any
    abs_errors: Any
    if TYPE_CHECKING:
        def __init__(self, *, set_mask: Any = ..., dims: Any = ..., lattice: Any = ..., store: Any = ...,
            nonfinite: Any = ..., overwrite: Any = ..., fixed_predictions: Any = ...,
            channel_count: Any = ..., channels: Any = ..., affine: Any = ..., spatial_unit: Any = ...,
            time_unit: Any = ..., scale: Any = ..., time_scale: Any = ..., recommended_kernel: Any = ...,
            progress: Any = ..., progress_user: Any = ..., abs_error: Any = ..., psnr: Any = ...,
            measure: Any = ..., partial: Any = ..., lowpass: Any = ..., levels: Any = ..., part: Any = ...,
            ends: Any = ..., faces: Any = ..., scales: Any = ..., live: Any = ..., periodic_axes: Any = ...,
            cancel_token: Any = ..., axes: Any = ..., wavelet_errors: Any = ...,
            abs_errors: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("set_mask", c_uint32), ("dims", c_uint32 * 4),
        ("lattice", c_int32), ("store", c_int32), ("nonfinite", c_int32), ("overwrite", c_int32),
        ("fixed_predictions", c_int32), ("channel_count", c_uint32), ("channels", POINTER(ChannelOptions)),
        ("affine", c_double * 16), ("spatial_unit", c_char_p), ("time_unit", c_char_p), ("scale", c_double),
        ("time_scale", c_double), ("recommended_kernel", c_char_p), ("progress", bccsplat_progress_fn),
        ("progress_user", c_void_p), ("abs_error", c_double), ("psnr", c_double), ("measure", c_int32),
        ("partial", c_int32), ("lowpass", c_int32), ("levels", c_uint32), ("part", POINTER(SeriesPart)),
        ("ends", c_int32), ("faces", c_int32), ("scales", c_double * 4), ("live", c_uint32),
        ("periodic_axes", c_uint32), ("cancel_token", c_void_p), ("axes", POINTER(Axis)),
        ("wavelet_errors", POINTER(c_double)), ("abs_errors", POINTER(c_double))]


class Box(Struct):
    type: int
    data: Any
    begin: Array[c_int64]
    dims: Array[c_int64]
    stride_bytes: Array[c_int64]
    if TYPE_CHECKING:
        def __init__(self, *, type: Any = ..., data: Any = ..., begin: Any = ..., dims: Any = ...,
            stride_bytes: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("type", c_int32), ("data", c_void_p), ("begin", c_int64 * 3),
        ("dims", c_int64 * 3), ("stride_bytes", c_int64 * 3)]


class LayerGeometry(Struct):
    coset: int
    dims: Array[c_int64]
    origin: Array[c_double]
    step: Array[c_double]
    frame: float
    layer_count: int
    if TYPE_CHECKING:
        def __init__(self, *, coset: Any = ..., dims: Any = ..., origin: Any = ..., step: Any = ...,
            frame: Any = ..., layer_count: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("coset", c_int32), ("dims", c_int64 * 3),
        ("origin", c_double * 3), ("step", c_double * 3), ("frame", c_double), ("layer_count", c_int64)]


class WriterReport(Struct):
    slabs_reused: int
    frames: int
    cc_samples: int
    cc_relevant: int
    sites_total: int
    sites_kept: int
    holes: int
    clamped: int
    nonfinite: int
    bytes_source: int
    bytes_file: int
    bytes_runs: int
    bytes_values: int
    bytes_index: int
    frames_measured: int
    corrected: int
    bytes_corrections: int
    coding_max: float
    coding_rmse: float
    sites_outside: int
    if TYPE_CHECKING:
        def __init__(self, *, slabs_reused: Any = ..., frames: Any = ..., cc_samples: Any = ...,
            cc_relevant: Any = ..., sites_total: Any = ..., sites_kept: Any = ..., holes: Any = ...,
            clamped: Any = ..., nonfinite: Any = ..., bytes_source: Any = ..., bytes_file: Any = ...,
            bytes_runs: Any = ..., bytes_values: Any = ..., bytes_index: Any = ...,
            frames_measured: Any = ..., corrected: Any = ..., bytes_corrections: Any = ...,
            coding_max: Any = ..., coding_rmse: Any = ..., sites_outside: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("slabs_reused", c_uint32), ("frames", c_uint64),
        ("cc_samples", c_uint64), ("cc_relevant", c_uint64), ("sites_total", c_uint64),
        ("sites_kept", c_uint64), ("holes", c_uint64), ("clamped", c_uint64), ("nonfinite", c_uint64),
        ("bytes_source", c_uint64), ("bytes_file", c_uint64), ("bytes_runs", c_uint64),
        ("bytes_values", c_uint64), ("bytes_index", c_uint64), ("frames_measured", c_uint64),
        ("corrected", c_uint64), ("bytes_corrections", c_uint64), ("coding_max", c_double),
        ("coding_rmse", c_double), ("sites_outside", c_uint64)]


class ErrorReport(Struct):
    reserved: int
    frame: int
    samples: int
    max_abs: float
    rmse: float
    peak: float
    psnr: float
    non_air_samples: int
    non_air_max_abs: float
    non_air_rmse: float
    non_air_psnr: float
    voxel: Array[c_uint64]
    expected: float
    got: float
    uncorrected_max_abs: float
    corrected: int
    lost: int
    if TYPE_CHECKING:
        def __init__(self, *, frame: Any = ..., samples: Any = ..., max_abs: Any = ..., rmse: Any = ...,
            peak: Any = ..., psnr: Any = ..., non_air_samples: Any = ..., non_air_max_abs: Any = ...,
            non_air_rmse: Any = ..., non_air_psnr: Any = ..., voxel: Any = ..., expected: Any = ...,
            got: Any = ..., uncorrected_max_abs: Any = ..., corrected: Any = ...,
            lost: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("frame", c_uint64), ("samples", c_uint64),
        ("max_abs", c_double), ("rmse", c_double), ("peak", c_double), ("psnr", c_double),
        ("non_air_samples", c_uint64), ("non_air_max_abs", c_double), ("non_air_rmse", c_double),
        ("non_air_psnr", c_double), ("voxel", c_uint64 * 3), ("expected", c_double), ("got", c_double),
        ("uncorrected_max_abs", c_double), ("corrected", c_uint64), ("lost", c_uint64)]


class JoinOptions(Struct):
    overwrite: int
    progress: Any
    progress_user: Any
    cancel_token: Any
    compare_levels: int
    reserved: int
    if TYPE_CHECKING:
        def __init__(self, *, overwrite: Any = ..., progress: Any = ..., progress_user: Any = ...,
            cancel_token: Any = ..., compare_levels: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("overwrite", c_int32), ("progress", bccsplat_progress_fn),
        ("progress_user", c_void_p), ("cancel_token", c_void_p), ("compare_levels", c_int32),
        ("reserved", c_int32)]


class SourceBoxes(Struct):
    reserved: int
    boxes: Any
    count: int
    release: Any
    keeper: Any
    if TYPE_CHECKING:
        def __init__(self, *, boxes: Any = ..., count: Any = ..., release: Any = ...,
            keeper: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("boxes", POINTER(Box)),
        ("count", c_uint64), ("release", bccsplat_release_fn), ("keeper", c_void_p)]


bccsplat_boxes_fn = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_uint32, c_void_p, c_void_p, POINTER(SourceBoxes))


class PlanChannel(Struct):
    type: int
    missing: int
    kind: int
    step: float
    offset: float
    active: Any
    if TYPE_CHECKING:
        def __init__(self, *, type: Any = ..., missing: Any = ..., kind: Any = ..., step: Any = ...,
            offset: Any = ..., active: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("type", c_int32), ("missing", c_int32), ("kind", c_uint32),
        ("step", c_double), ("offset", c_double), ("active", POINTER(c_uint64))]


class PlanOptions(Struct):
    set_mask: int
    wish: Any
    channels: Any
    times: Any
    frame: Any
    frame_user: Any
    density: float
    exact: int
    reserved: int
    boxes: Any
    memory: int
    name: str
    if TYPE_CHECKING:
        def __init__(self, *, set_mask: Any = ..., wish: Any = ..., channels: Any = ..., times: Any = ...,
            frame: Any = ..., frame_user: Any = ..., density: Any = ..., exact: Any = ..., boxes: Any = ...,
            memory: Any = ..., name: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("set_mask", c_uint32), ("wish", POINTER(WriterOptions)),
        ("channels", POINTER(PlanChannel)), ("times", POINTER(c_double)), ("frame", bccsplat_source_fn),
        ("frame_user", c_void_p), ("density", c_double), ("exact", c_int32), ("reserved", c_uint32),
        ("boxes", bccsplat_boxes_fn), ("memory", c_uint64), ("name", c_char_p)]


class VolumeOptions(Struct):
    salvage: int
    kernel: str
    cache_bytes: int
    cancel_token: Any
    shape: Array[c_double]
    if TYPE_CHECKING:
        def __init__(self, *, salvage: Any = ..., kernel: Any = ..., cache_bytes: Any = ...,
            cancel_token: Any = ..., shape: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("salvage", c_int32), ("kernel", c_char_p),
        ("cache_bytes", c_uint64), ("cancel_token", c_void_p), ("shape", c_double * 3)]


class VolumeInfo(Struct):
    lattice: int
    dims: Array[c_uint64]
    cc_samples: int
    sites_total: int
    layer_count: int
    scale: float
    time_scale: float
    affine: Array[c_double]
    time_first: float
    time_last: float
    mean_voxel: float
    spatial_unit: str
    time_unit: str
    kernel: str
    recommended_kernel: str
    channel_count: int
    time_uniform: int
    store: int
    has_holes: int
    bytes_file: int
    bytes_runs: int
    bytes_values: int
    bytes_index: int
    bytes_read: int
    attribute_count: int
    part_first: int
    part_end: int
    scales: Array[c_double]
    planes_before: Array[c_uint32]
    planes_behind: Array[c_uint32]
    sites_outside: int
    level_count: int
    time_periodic: int
    time_end: float
    frames_expected: int
    periodic_axes: int
    series_state: int
    part_box_begin: Array[c_uint64]
    part_box_end: Array[c_uint64]
    if TYPE_CHECKING:
        def __init__(self, *, lattice: Any = ..., dims: Any = ..., cc_samples: Any = ...,
            sites_total: Any = ..., layer_count: Any = ..., scale: Any = ..., time_scale: Any = ...,
            affine: Any = ..., time_first: Any = ..., time_last: Any = ..., mean_voxel: Any = ...,
            spatial_unit: Any = ..., time_unit: Any = ..., kernel: Any = ..., recommended_kernel: Any = ...,
            channel_count: Any = ..., time_uniform: Any = ..., store: Any = ..., has_holes: Any = ...,
            bytes_file: Any = ..., bytes_runs: Any = ..., bytes_values: Any = ..., bytes_index: Any = ...,
            bytes_read: Any = ..., attribute_count: Any = ..., part_first: Any = ..., part_end: Any = ...,
            scales: Any = ..., planes_before: Any = ..., planes_behind: Any = ..., sites_outside: Any = ...,
            level_count: Any = ..., time_periodic: Any = ..., time_end: Any = ..., frames_expected: Any = ...,
            periodic_axes: Any = ..., series_state: Any = ..., part_box_begin: Any = ...,
            part_box_end: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("lattice", c_int32), ("dims", c_uint64 * 4),
        ("cc_samples", c_uint64), ("sites_total", c_uint64), ("layer_count", c_uint64), ("scale", c_double),
        ("time_scale", c_double), ("affine", c_double * 16), ("time_first", c_double),
        ("time_last", c_double), ("mean_voxel", c_double), ("spatial_unit", c_char_p),
        ("time_unit", c_char_p), ("kernel", c_char_p), ("recommended_kernel", c_char_p),
        ("channel_count", c_uint32), ("time_uniform", c_int32), ("store", c_int32), ("has_holes", c_int32),
        ("bytes_file", c_uint64), ("bytes_runs", c_uint64), ("bytes_values", c_uint64),
        ("bytes_index", c_uint64), ("bytes_read", c_uint64), ("attribute_count", c_uint64),
        ("part_first", c_uint64), ("part_end", c_uint64), ("scales", c_double * 4),
        ("planes_before", c_uint32 * 3), ("planes_behind", c_uint32 * 3), ("sites_outside", c_uint64),
        ("level_count", c_uint32), ("time_periodic", c_uint32), ("time_end", c_double),
        ("frames_expected", c_uint64), ("periodic_axes", c_uint32), ("series_state", c_int32),
        ("part_box_begin", c_uint64 * 3), ("part_box_end", c_uint64 * 3)]


class LevelInfo(Struct):
    slab_layers: int
    scales: Array[c_double]
    layer_count: int
    sites_total: int
    sites_kept: int
    bytes: int
    relative_rmse: float
    if TYPE_CHECKING:
        def __init__(self, *, slab_layers: Any = ..., scales: Any = ..., layer_count: Any = ...,
            sites_total: Any = ..., sites_kept: Any = ..., bytes: Any = ...,
            relative_rmse: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("slab_layers", c_uint32), ("scales", c_double * 4),
        ("layer_count", c_uint64), ("sites_total", c_uint64), ("sites_kept", c_uint64), ("bytes", c_uint64),
        ("relative_rmse", c_double)]


class ChannelInfo(Struct):
    value_type: int
    name: str
    unit: str
    air: float
    air_threshold: float
    value_scale: float
    value_offset: float
    range: Array[c_double]
    kept_range: Array[c_double]
    percentile_2: float
    percentile_998: float
    sites_kept: int
    cc_relevant: int
    holes: int
    histogram: Array[c_uint64]
    source_type: int
    labels: int
    error_bound: float
    lattice_rmse: float
    lattice_max_abs: float
    rmse: float
    max_abs: float
    corrections: int
    missing: int
    wavelet_error: float
    if TYPE_CHECKING:
        def __init__(self, *, value_type: Any = ..., name: Any = ..., unit: Any = ..., air: Any = ...,
            air_threshold: Any = ..., value_scale: Any = ..., value_offset: Any = ..., range: Any = ...,
            kept_range: Any = ..., percentile_2: Any = ..., percentile_998: Any = ..., sites_kept: Any = ...,
            cc_relevant: Any = ..., holes: Any = ..., histogram: Any = ..., source_type: Any = ...,
            labels: Any = ..., error_bound: Any = ..., lattice_rmse: Any = ..., lattice_max_abs: Any = ...,
            rmse: Any = ..., max_abs: Any = ..., corrections: Any = ..., missing: Any = ...,
            wavelet_error: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("value_type", c_int32), ("name", c_char_p), ("unit", c_char_p),
        ("air", c_double), ("air_threshold", c_double), ("value_scale", c_double), ("value_offset", c_double),
        ("range", c_double * 2), ("kept_range", c_double * 2), ("percentile_2", c_double),
        ("percentile_998", c_double), ("sites_kept", c_uint64), ("cc_relevant", c_uint64),
        ("holes", c_uint64), ("histogram", c_uint64 * 256), ("source_type", c_int32), ("labels", c_int32),
        ("error_bound", c_double), ("lattice_rmse", c_double), ("lattice_max_abs", c_double),
        ("rmse", c_double), ("max_abs", c_double), ("corrections", c_uint64), ("missing", c_uint64),
        ("wavelet_error", c_double)]


class VerifyReport(Struct):
    reserved: int
    chunks: int
    chunks_damaged: int
    bytes_checked: int
    first_damaged_offset: int
    damages: int
    unreadable: int
    first_unreadable_offset: int
    if TYPE_CHECKING:
        def __init__(self, *, chunks: Any = ..., chunks_damaged: Any = ..., bytes_checked: Any = ...,
            first_damaged_offset: Any = ..., damages: Any = ..., unreadable: Any = ...,
            first_unreadable_offset: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("chunks", c_uint64),
        ("chunks_damaged", c_uint64), ("bytes_checked", c_uint64), ("first_damaged_offset", c_uint64),
        ("damages", c_uint64), ("unreadable", c_uint64), ("first_unreadable_offset", c_uint64)]


class Hyperplane(Struct):
    reserved: int
    a: float
    b: float
    c: float
    d: float
    e: float
    if TYPE_CHECKING:
        def __init__(self, *, a: Any = ..., b: Any = ..., c: Any = ..., d: Any = ...,
            e: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("a", c_double), ("b", c_double),
        ("c", c_double), ("d", c_double), ("e", c_double)]


class SliceOptions(Struct):
    channel: int
    kernel: str
    interval: Array[c_double]
    spacing: float
    time_length: float
    lattice: int
    level: int
    progress: Any
    progress_user: Any
    thickness: float
    point: Any
    basis: Any
    slab: int
    method: int
    box: Any
    cancel_token: Any
    space: int
    once: int
    bandwidth: Array[c_double]
    motion: int
    reserved: int
    if TYPE_CHECKING:
        def __init__(self, *, channel: Any = ..., kernel: Any = ..., interval: Any = ..., spacing: Any = ...,
            time_length: Any = ..., lattice: Any = ..., level: Any = ..., progress: Any = ...,
            progress_user: Any = ..., thickness: Any = ..., point: Any = ..., basis: Any = ...,
            slab: Any = ..., method: Any = ..., box: Any = ..., cancel_token: Any = ..., space: Any = ...,
            once: Any = ..., bandwidth: Any = ..., motion: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("channel", c_uint32), ("kernel", c_char_p),
        ("interval", c_double * 2), ("spacing", c_double), ("time_length", c_double), ("lattice", c_int32),
        ("level", c_uint32), ("progress", bccsplat_progress_fn), ("progress_user", c_void_p),
        ("thickness", c_double), ("point", POINTER(c_double)), ("basis", POINTER(c_double)),
        ("slab", c_int32), ("method", c_int32), ("box", POINTER(c_double)), ("cancel_token", c_void_p),
        ("space", c_int32), ("once", c_uint32), ("bandwidth", c_double * 4), ("motion", c_int32),
        ("reserved", c_uint32)]


class SliceInfo(Struct):
    lattice: int
    hyperplane: Array[c_double]
    origin: Array[c_double]
    basis: Array[Array[c_double]]
    extent: Array[Array[c_double]]
    dims: Array[c_uint64]
    affine: Array[c_double]
    bounds: Array[c_double]
    air: float
    points: int
    bytes_read: int
    milliseconds: float
    kernel: str
    level: int
    reserved: int
    if TYPE_CHECKING:
        def __init__(self, *, lattice: Any = ..., hyperplane: Any = ..., origin: Any = ..., basis: Any = ...,
            extent: Any = ..., dims: Any = ..., affine: Any = ..., bounds: Any = ..., air: Any = ...,
            points: Any = ..., bytes_read: Any = ..., milliseconds: Any = ..., kernel: Any = ...,
            level: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("lattice", c_int32), ("hyperplane", c_double * 5),
        ("origin", c_double * 4), ("basis", c_double * 4 * 3), ("extent", c_double * 2 * 3),
        ("dims", c_uint64 * 3), ("affine", c_double * 16), ("bounds", c_double * 2), ("air", c_double),
        ("points", c_uint64), ("bytes_read", c_uint64), ("milliseconds", c_double), ("kernel", c_char_p),
        ("level", c_uint32), ("reserved", c_uint32)]


class Grid(Struct):
    reserved: int
    origin: Array[c_double]
    step: Array[c_double]
    dims: Array[c_uint64]
    if TYPE_CHECKING:
        def __init__(self, *, origin: Any = ..., step: Any = ..., dims: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("origin", c_double * 3),
        ("step", c_double * 3), ("dims", c_uint64 * 3)]


class BrickOptions(Struct):
    grid: int
    type: int
    edge: int
    border: int
    reserved: int
    spacing: float
    range: Array[c_double]
    if TYPE_CHECKING:
        def __init__(self, *, grid: Any = ..., type: Any = ..., edge: Any = ..., border: Any = ...,
            spacing: Any = ..., range: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("grid", c_int32), ("type", c_int32), ("edge", c_uint32),
        ("border", c_uint32), ("reserved", c_uint32), ("spacing", c_double), ("range", c_double * 2)]


class BrickInfo(Struct):
    cosets: int
    bricks: Array[c_uint32]
    edge: int
    dims: Array[c_uint64]
    origin: Array[Array[c_double]]
    step: Array[c_double]
    brick_bytes: int
    scale: float
    offset: float
    empty: float
    kernel_radius: float
    kernel: Array[c_double]
    kernel_terms: int
    kernel_normalised: int
    if TYPE_CHECKING:
        def __init__(self, *, cosets: Any = ..., bricks: Any = ..., edge: Any = ..., dims: Any = ...,
            origin: Any = ..., step: Any = ..., brick_bytes: Any = ..., scale: Any = ..., offset: Any = ...,
            empty: Any = ..., kernel_radius: Any = ..., kernel: Any = ..., kernel_terms: Any = ...,
            kernel_normalised: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("cosets", c_uint32), ("bricks", c_uint32 * 3), ("edge", c_uint32),
        ("dims", c_uint64 * 3), ("origin", c_double * 3 * 2), ("step", c_double * 3),
        ("brick_bytes", c_uint64), ("scale", c_double), ("offset", c_double), ("empty", c_double),
        ("kernel_radius", c_double), ("kernel", c_double * 20), ("kernel_terms", c_uint32),
        ("kernel_normalised", c_uint32)]


class Camera(Struct):
    projection: int
    position: Array[c_double]
    target: Array[c_double]
    up: Array[c_double]
    fovy_degrees: float
    ortho_height: float
    if TYPE_CHECKING:
        def __init__(self, *, projection: Any = ..., position: Any = ..., target: Any = ..., up: Any = ...,
            fovy_degrees: Any = ..., ortho_height: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("projection", c_int32), ("position", c_double * 3),
        ("target", c_double * 3), ("up", c_double * 3), ("fovy_degrees", c_double),
        ("ortho_height", c_double)]


class Fit(Struct):
    projection: int
    side: int
    reserved: int
    rotate_x_degrees: float
    rotate_y_degrees: float
    bounds: Array[c_double]
    if TYPE_CHECKING:
        def __init__(self, *, projection: Any = ..., side: Any = ..., rotate_x_degrees: Any = ...,
            rotate_y_degrees: Any = ..., bounds: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("projection", c_int32), ("side", c_int32), ("reserved", c_uint32),
        ("rotate_x_degrees", c_double), ("rotate_y_degrees", c_double), ("bounds", c_double * 6)]


class View(Struct):
    use_matrices: int
    camera: Any
    world_to_view: Array[c_double]
    projection: Array[c_double]
    column_major: int
    depth_range: int
    y_down: int
    depth_kind: int
    picture_size: Array[c_uint32]
    region_begin: Array[c_uint32]
    depth: Any
    depth_row_bytes: int
    background: Any
    background_row_bytes: int
    if TYPE_CHECKING:
        def __init__(self, *, use_matrices: Any = ..., camera: Any = ..., world_to_view: Any = ...,
            projection: Any = ..., column_major: Any = ..., depth_range: Any = ..., y_down: Any = ...,
            depth_kind: Any = ..., picture_size: Any = ..., region_begin: Any = ..., depth: Any = ...,
            depth_row_bytes: Any = ..., background: Any = ..., background_row_bytes: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("use_matrices", c_uint32), ("camera", POINTER(Camera)),
        ("world_to_view", c_double * 16), ("projection", c_double * 16), ("column_major", c_uint32),
        ("depth_range", c_int32), ("y_down", c_uint32), ("depth_kind", c_int32),
        ("picture_size", c_uint32 * 2), ("region_begin", c_uint32 * 2), ("depth", POINTER(c_float)),
        ("depth_row_bytes", c_int64), ("background", POINTER(c_float)), ("background_row_bytes", c_int64)]


class Clip(Fields):
    normal: Array[c_double]
    offset: float
    space: int
    reserved: int
    instance: int
    _fields_ = [("normal", c_double * 3), ("offset", c_double), ("space", c_int32), ("reserved", c_uint32),
        ("instance", c_uint64)]


class TransferFunction(Struct):
    color_count: int
    colors: Any
    opacities: Any
    opacity_count: int
    reserved: int
    unit_distance: float
    if TYPE_CHECKING:
        def __init__(self, *, color_count: Any = ..., colors: Any = ..., opacities: Any = ...,
            opacity_count: Any = ..., unit_distance: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("color_count", c_uint32), ("colors", POINTER(c_double)),
        ("opacities", POINTER(c_double)), ("opacity_count", c_uint32), ("reserved", c_uint32),
        ("unit_distance", c_double)]


class Look(Struct):
    kind: int
    empty: Array[c_double]
    range: Array[c_double]
    iso_value: float
    color_count: int
    opacity_count: int
    colors: Array[Array[c_double]]
    opacities: Array[Array[c_double]]
    layout: int
    frame: int
    if TYPE_CHECKING:
        def __init__(self, *, kind: Any = ..., empty: Any = ..., range: Any = ..., iso_value: Any = ...,
            color_count: Any = ..., opacity_count: Any = ..., colors: Any = ..., opacities: Any = ...,
            layout: Any = ..., frame: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("kind", c_int32), ("empty", c_double * 2),
        ("range", c_double * 2), ("iso_value", c_double), ("color_count", c_uint32),
        ("opacity_count", c_uint32), ("colors", c_double * 4 * 64), ("opacities", c_double * 2 * 32),
        ("layout", c_int32), ("frame", c_uint32)]


class Light(Fields):
    direction: Array[c_double]
    color: Array[c_double]
    _fields_ = [("direction", c_double * 3), ("color", c_double * 3)]


class Lights(Struct):
    count: int
    lights: Any
    ambient: float
    diffuse: float
    specular: float
    shininess: float
    shadow: int
    occlusion: int
    if TYPE_CHECKING:
        def __init__(self, *, count: Any = ..., lights: Any = ..., ambient: Any = ..., diffuse: Any = ...,
            specular: Any = ..., shininess: Any = ..., shadow: Any = ..., occlusion: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("count", c_uint32), ("lights", POINTER(Light)),
        ("ambient", c_double), ("diffuse", c_double), ("specular", c_double), ("shininess", c_double),
        ("shadow", c_uint32), ("occlusion", c_uint32)]


class Ray(Struct):
    pick: int
    origin: Array[c_double]
    direction: Array[c_double]
    begin: float
    end: float
    threshold: float
    transfer_function: Any
    if TYPE_CHECKING:
        def __init__(self, *, pick: Any = ..., origin: Any = ..., direction: Any = ..., begin: Any = ...,
            end: Any = ..., threshold: Any = ..., transfer_function: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("pick", c_int32), ("origin", c_double * 3),
        ("direction", c_double * 3), ("begin", c_double), ("end", c_double), ("threshold", c_double),
        ("transfer_function", POINTER(TransferFunction))]


class Hit(Struct):
    found: int
    distance: float
    world: Array[c_double]
    uvw: Array[c_double]
    value: float
    gradient: Array[c_double]
    if TYPE_CHECKING:
        def __init__(self, *, found: Any = ..., distance: Any = ..., world: Any = ..., uvw: Any = ...,
            value: Any = ..., gradient: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("found", c_int32), ("distance", c_double),
        ("world", c_double * 3), ("uvw", c_double * 3), ("value", c_double), ("gradient", c_double * 3)]


class IsoSurface(Fields):
    value: float
    opacity: float
    color: Array[c_double]
    use_color: int
    reserved: int
    _fields_ = [("value", c_double), ("opacity", c_double), ("color", c_double * 3), ("use_color", c_uint32),
        ("reserved", c_uint32)]


class RenderOptions(Struct):
    set_mask: int
    mode: int
    quality: int
    shading: int
    disable_skips: int
    sheet_step: float
    iso_value: float
    opacity_stop: float
    reference: int
    tile_size: int
    progress: Any
    progress_user: Any
    deep_tolerance: float
    preintegrate: int
    smooth_edges: int
    gradient_noise: float
    cancel_token: Any
    surfaces: Any
    surface_count: int
    reserved: int
    depth_opacity: float
    tile: Any
    tile_user: Any
    backend: int
    reserved2: int
    if TYPE_CHECKING:
        def __init__(self, *, set_mask: Any = ..., mode: Any = ..., quality: Any = ..., shading: Any = ...,
            disable_skips: Any = ..., sheet_step: Any = ..., iso_value: Any = ..., opacity_stop: Any = ...,
            reference: Any = ..., tile_size: Any = ..., progress: Any = ..., progress_user: Any = ...,
            deep_tolerance: Any = ..., preintegrate: Any = ..., smooth_edges: Any = ...,
            gradient_noise: Any = ..., cancel_token: Any = ..., surfaces: Any = ..., surface_count: Any = ...,
            depth_opacity: Any = ..., tile: Any = ..., tile_user: Any = ..., backend: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("set_mask", c_uint32), ("mode", c_int32), ("quality", c_int32),
        ("shading", c_int32), ("disable_skips", c_uint32), ("sheet_step", c_double), ("iso_value", c_double),
        ("opacity_stop", c_double), ("reference", c_int32), ("tile_size", c_int32),
        ("progress", bccsplat_progress_fn), ("progress_user", c_void_p), ("deep_tolerance", c_double),
        ("preintegrate", c_int32), ("smooth_edges", c_int32), ("gradient_noise", c_double),
        ("cancel_token", c_void_p), ("surfaces", POINTER(IsoSurface)), ("surface_count", c_uint32),
        ("reserved", c_uint32), ("depth_opacity", c_double), ("tile", bccsplat_tile_fn),
        ("tile_user", c_void_p), ("backend", c_int32), ("reserved2", c_uint32)]


class PictureNeeds(Struct):
    level: int
    box: Array[c_double]
    seen: int
    reserved: int
    distances_per_pixel: float
    if TYPE_CHECKING:
        def __init__(self, *, level: Any = ..., box: Any = ..., seen: Any = ...,
            distances_per_pixel: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("level", c_uint32), ("box", c_double * 6), ("seen", c_int32),
        ("reserved", c_int32), ("distances_per_pixel", c_double)]


class Trail(Struct):
    content: int
    combine: int
    samples: int
    interval: Array[c_double]
    transfer_function: Any
    colors: Any
    intervals: int
    reserved: int
    transfer_functions: Any
    weights: Any
    unlit: int
    reserved2: int
    if TYPE_CHECKING:
        def __init__(self, *, content: Any = ..., combine: Any = ..., samples: Any = ..., interval: Any = ...,
            transfer_function: Any = ..., colors: Any = ..., intervals: Any = ...,
            transfer_functions: Any = ..., weights: Any = ..., unlit: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("content", c_int32), ("combine", c_int32), ("samples", c_uint32),
        ("interval", c_double * 2), ("transfer_function", POINTER(TransferFunction)),
        ("colors", POINTER(c_double)), ("intervals", c_uint32), ("reserved", c_uint32),
        ("transfer_functions", POINTER(TransferFunction)), ("weights", POINTER(c_double)),
        ("unlit", c_uint32), ("reserved2", c_uint32)]


class RenderStats(Struct):
    threads: int
    ms_transform: float
    ms_splat: float
    ms_shade: float
    ms_total: float
    cpu_ms: float
    points_total: int
    points_after_cull: int
    points_splatted: int
    points_occluded: int
    tiles: int
    sheets: int
    sheet_step: float
    coarse_level: int
    reserved: int
    preintegrated: int
    reserved2: int
    sheets_reused: int
    bricks_total: int
    bricks_invisible: int
    bricks_outside: int
    brick_visits: int
    visits_hidden: int
    visits_unread: int
    points_invisible: int
    sheets_skipped: int
    bytes_read: int
    level: int
    reserved3: int
    backend: int
    reserved4: int
    if TYPE_CHECKING:
        def __init__(self, *, threads: Any = ..., ms_transform: Any = ..., ms_splat: Any = ...,
            ms_shade: Any = ..., ms_total: Any = ..., cpu_ms: Any = ..., points_total: Any = ...,
            points_after_cull: Any = ..., points_splatted: Any = ..., points_occluded: Any = ...,
            tiles: Any = ..., sheets: Any = ..., sheet_step: Any = ..., coarse_level: Any = ...,
            preintegrated: Any = ..., sheets_reused: Any = ..., bricks_total: Any = ...,
            bricks_invisible: Any = ..., bricks_outside: Any = ..., brick_visits: Any = ...,
            visits_hidden: Any = ..., visits_unread: Any = ..., points_invisible: Any = ...,
            sheets_skipped: Any = ..., bytes_read: Any = ..., level: Any = ...,
            backend: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("threads", c_uint32), ("ms_transform", c_double),
        ("ms_splat", c_double), ("ms_shade", c_double), ("ms_total", c_double), ("cpu_ms", c_double),
        ("points_total", c_uint64), ("points_after_cull", c_uint64), ("points_splatted", c_uint64),
        ("points_occluded", c_uint64), ("tiles", c_uint64), ("sheets", c_uint64), ("sheet_step", c_double),
        ("coarse_level", c_int32), ("reserved", c_uint32), ("preintegrated", c_int32),
        ("reserved2", c_uint32), ("sheets_reused", c_uint64), ("bricks_total", c_uint64),
        ("bricks_invisible", c_uint64), ("bricks_outside", c_uint64), ("brick_visits", c_uint64),
        ("visits_hidden", c_uint64), ("visits_unread", c_uint64), ("points_invisible", c_uint64),
        ("sheets_skipped", c_uint64), ("bytes_read", c_uint64), ("level", c_uint32), ("reserved3", c_uint32),
        ("backend", c_int32), ("reserved4", c_uint32)]


class Deep(Struct):
    components: int
    width: int
    height: int
    sample_count: int
    first: Any
    samples: Any
    if TYPE_CHECKING:
        def __init__(self, *, components: Any = ..., width: Any = ..., height: Any = ...,
            sample_count: Any = ..., first: Any = ..., samples: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("components", c_uint32), ("width", c_uint32),
        ("height", c_uint32), ("sample_count", c_uint64), ("first", POINTER(c_uint64)),
        ("samples", POINTER(c_float))]


class Plane(Struct):
    components: int
    width: int
    height: int
    pixels: Any
    row_bytes: int
    if TYPE_CHECKING:
        def __init__(self, *, components: Any = ..., width: Any = ..., height: Any = ..., pixels: Any = ...,
            row_bytes: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("components", c_uint32), ("width", c_uint32),
        ("height", c_uint32), ("pixels", c_void_p), ("row_bytes", c_uint64)]


class ImageOptions(Struct):
    overwrite: int
    use_background: int
    reserved: int
    background: Array[c_double]
    frames_per_second: Array[c_int32]
    exposure_seconds: float
    comments: str
    progress: Any
    progress_user: Any
    cancel_token: Any
    if TYPE_CHECKING:
        def __init__(self, *, overwrite: Any = ..., use_background: Any = ..., background: Any = ...,
            frames_per_second: Any = ..., exposure_seconds: Any = ..., comments: Any = ...,
            progress: Any = ..., progress_user: Any = ..., cancel_token: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("overwrite", c_int32), ("use_background", c_uint32),
        ("reserved", c_uint32), ("background", c_double * 3), ("frames_per_second", c_int32 * 2),
        ("exposure_seconds", c_double), ("comments", c_char_p), ("progress", bccsplat_progress_fn),
        ("progress_user", c_void_p), ("cancel_token", c_void_p)]


class HostPlane(Fields):
    channel: int
    reserved: int
    pixels: Any
    row_bytes: int
    _fields_ = [("channel", c_uint32), ("reserved", c_uint32), ("pixels", c_void_p), ("row_bytes", c_int64)]


class GlTarget(Struct):
    texture: int
    width: int
    height: int
    depth_texture: int
    replace: int
    if TYPE_CHECKING:
        def __init__(self, *, texture: Any = ..., width: Any = ..., height: Any = ...,
            depth_texture: Any = ..., replace: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("texture", c_uint32), ("width", c_uint32), ("height", c_uint32),
        ("depth_texture", c_uint32), ("replace", c_int32)]


class Instance(Struct):
    channel: int
    placement: Array[c_double]
    time_scale: float
    time_offset: float
    outside: int
    hidden: int
    transfer_function: Any
    density: float
    set_mask: int
    color_channel: int
    color_function: Any
    mask_channel: int
    mask_label_count: int
    mask_labels: Any
    trail: Any
    if TYPE_CHECKING:
        def __init__(self, *, channel: Any = ..., placement: Any = ..., time_scale: Any = ...,
            time_offset: Any = ..., outside: Any = ..., hidden: Any = ..., transfer_function: Any = ...,
            density: Any = ..., set_mask: Any = ..., color_channel: Any = ..., color_function: Any = ...,
            mask_channel: Any = ..., mask_label_count: Any = ..., mask_labels: Any = ...,
            trail: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("channel", c_uint32), ("placement", c_double * 16),
        ("time_scale", c_double), ("time_offset", c_double), ("outside", c_int32), ("hidden", c_uint32),
        ("transfer_function", POINTER(TransferFunction)), ("density", c_double), ("set_mask", c_uint32),
        ("color_channel", c_uint32), ("color_function", POINTER(TransferFunction)),
        ("mask_channel", c_uint32), ("mask_label_count", c_uint32), ("mask_labels", POINTER(c_double)),
        ("trail", POINTER(Trail))]


class SceneStatus(Struct):
    complete: int
    progress: float
    drawn: int
    cut: int
    level: int
    reserved: int
    bytes_read: int
    ms_cut: float
    ms_draw: float
    ms_total: float
    backend: int
    reserved2: int
    if TYPE_CHECKING:
        def __init__(self, *, complete: Any = ..., progress: Any = ..., drawn: Any = ..., cut: Any = ...,
            level: Any = ..., bytes_read: Any = ..., ms_cut: Any = ..., ms_draw: Any = ...,
            ms_total: Any = ..., backend: Any = ...) -> None: ...
    _fields_ = [("struct_size", c_uint32), ("complete", c_uint32), ("progress", c_double),
        ("drawn", c_uint32), ("cut", c_uint32), ("level", c_uint32), ("reserved", c_uint32),
        ("bytes_read", c_uint64), ("ms_cut", c_double), ("ms_draw", c_double), ("ms_total", c_double),
        ("backend", c_int32), ("reserved2", c_uint32)]


# Result and arguments of every function.
FUNCTIONS: dict[str, tuple[Any, ...]] = {
    "bccsplat_version": (c_int32,),
    "bccsplat_abi_version": (c_int32,),
    "bccsplat_build_info": (c_char_p,),
    "bccsplat_status_name": (c_char_p, c_int32,),
    "bccsplat_last_error": (c_char_p,),
    "bccsplat_last_lacking": (c_int32, c_void_p, c_uint64, c_void_p,),
    "bccsplat_kernel_name": (c_char_p, c_uint32,),
    "bccsplat_cancel_token_create": (c_int32, c_void_p,),
    "bccsplat_cancel_token_retain": (None, c_void_p,),
    "bccsplat_cancel_token_release": (None, c_void_p,),
    "bccsplat_cancel_token_cancel": (c_int32, c_void_p,),
    "bccsplat_cancel_token_reset": (c_int32, c_void_p,),
    "bccsplat_cancel_token_is_cancelled": (c_int32, c_void_p, c_void_p,),
    "bccsplat_device_create": (c_int32, POINTER(DeviceOptions), c_void_p,),
    "bccsplat_device_retain": (None, c_void_p,),
    "bccsplat_device_release": (None, c_void_p,),
    "bccsplat_device_get_info": (c_int32, c_void_p, POINTER(DeviceInfo),),
    "bccsplat_device_get_gpu_info": (c_int32, c_void_p, POINTER(GpuInfo),),
    "bccsplat_writer_create": (c_int32, c_void_p, c_char_p, POINTER(WriterOptions), c_void_p,),
    "bccsplat_writer_create_stream": (c_int32, c_void_p, POINTER(WriteStream), POINTER(WriterOptions),
        c_void_p,),
    "bccsplat_writer_add_frame": (c_int32, c_void_p, c_uint32, c_double, POINTER(Box), c_uint64,),
    "bccsplat_writer_get_part_frames": (c_int32, c_void_p, c_void_p, c_void_p,),
    "bccsplat_writer_get_part_box": (c_int32, c_void_p, c_void_p, c_void_p,),
    "bccsplat_writer_get_layer_geometry": (c_int32, c_void_p, c_int64, POINTER(LayerGeometry),),
    "bccsplat_writer_add_layer": (c_int32, c_void_p, c_uint32, c_int64, c_void_p, c_uint64,),
    "bccsplat_writer_add_field": (c_int32, c_void_p, c_uint32, bccsplat_field_fn, c_void_p,),
    "bccsplat_writer_set_times": (c_int32, c_void_p, c_double, c_double,),
    "bccsplat_writer_set_attribute": (c_int32, c_void_p, c_char_p, c_char_p,),
    "bccsplat_writer_add_source": (c_int32, c_void_p, c_char_p, c_uint64, c_uint32,),
    "bccsplat_writer_finish": (c_int32, c_void_p, POINTER(WriterReport),),
    "bccsplat_writer_finish_short": (c_int32, c_void_p, POINTER(WriterReport),),
    "bccsplat_writer_get_error": (c_int32, c_void_p, c_uint32, c_int64, POINTER(ErrorReport),),
    "bccsplat_writer_retain": (None, c_void_p,),
    "bccsplat_writer_release": (None, c_void_p,),
    "bccsplat_join_parts": (c_int32, c_void_p, c_uint64, c_void_p, c_char_p, POINTER(JoinOptions),
        POINTER(WriterReport),),
    "bccsplat_join_streams": (c_int32, c_void_p, c_uint64, POINTER(ReadStream), POINTER(WriteStream),
        POINTER(JoinOptions), POINTER(WriterReport),),
    "bccsplat_plan_create": (c_int32, c_void_p, POINTER(PlanOptions), c_void_p,),
    "bccsplat_plan_get_writer_options": (c_int32, c_void_p, POINTER(WriterOptions),),
    "bccsplat_plan_get_text": (c_int32, c_void_p, c_void_p,),
    "bccsplat_plan_get_json": (c_int32, c_void_p, c_void_p,),
    "bccsplat_plan_refine": (c_int32, c_void_p,),
    "bccsplat_plan_retain": (None, c_void_p,),
    "bccsplat_plan_release": (None, c_void_p,),
    "bccsplat_volume_open_file": (c_int32, c_void_p, c_char_p, POINTER(VolumeOptions), c_void_p,),
    "bccsplat_volume_open_memory": (c_int32, c_void_p, c_void_p, c_uint64, POINTER(VolumeOptions), c_void_p,),
    "bccsplat_volume_open_stream": (c_int32, c_void_p, POINTER(ReadStream), POINTER(VolumeOptions),
        c_void_p,),
    "bccsplat_volume_reopen": (c_int32, c_void_p, POINTER(ReadStream), c_void_p,),
    "bccsplat_volume_retain": (None, c_void_p,),
    "bccsplat_volume_release": (None, c_void_p,),
    "bccsplat_volume_get_info": (c_int32, c_void_p, POINTER(VolumeInfo),),
    "bccsplat_volume_get_level_info": (c_int32, c_void_p, c_uint32, POINTER(LevelInfo),),
    "bccsplat_volume_get_channel_info": (c_int32, c_void_p, c_uint32, POINTER(ChannelInfo),),
    "bccsplat_volume_find_channel": (c_int32, c_void_p, c_char_p, c_void_p,),
    "bccsplat_volume_get_times": (c_int32, c_void_p, c_void_p, c_uint64, c_void_p,),
    "bccsplat_volume_get_axis": (c_int32, c_void_p, c_uint32, POINTER(Axis),),
    "bccsplat_volume_index_to_world": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p,),
    "bccsplat_volume_world_to_index": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p,),
    "bccsplat_volume_get_frame_ranges": (c_int32, c_void_p, c_uint32, c_void_p, c_uint64, c_void_p,),
    "bccsplat_volume_time_to_index": (c_int32, c_void_p, c_double, c_void_p,),
    "bccsplat_volume_index_to_time": (c_int32, c_void_p, c_double, c_void_p,),
    "bccsplat_volume_get_attribute": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p,),
    "bccsplat_volume_find_attribute": (c_int32, c_void_p, c_char_p, c_void_p,),
    "bccsplat_volume_get_source": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p,),
    "bccsplat_volume_evaluate": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p,),
    "bccsplat_volume_evaluate_channel": (c_int32, c_void_p, c_uint32, c_uint64, c_void_p, c_void_p,
        c_void_p,),
    "bccsplat_volume_evaluate_world": (c_int32, c_void_p, c_uint32, c_uint64, c_void_p, c_void_p, c_void_p,
        c_void_p,),
    "bccsplat_volume_read_frame": (c_int32, c_void_p, c_uint32, c_uint64, c_void_p, c_void_p, c_void_p,),
    "bccsplat_volume_verify": (c_int32, c_void_p, bccsplat_progress_fn, c_void_p, POINTER(VerifyReport),),
    "bccsplat_slice_create": (c_int32, c_void_p, POINTER(Hyperplane), POINTER(SliceOptions), c_void_p,),
    "bccsplat_volume_slice_at": (c_int32, c_void_p, c_double, POINTER(SliceOptions), c_void_p,),
    "bccsplat_volume_prefetch": (c_int32, c_void_p, POINTER(Hyperplane), POINTER(SliceOptions),),
    "bccsplat_volume_get_ranges": (c_int32, c_void_p, POINTER(Hyperplane), POINTER(SliceOptions), c_uint32,
        c_void_p, c_uint64, c_void_p,),
    "bccsplat_slice_retain": (None, c_void_p,),
    "bccsplat_slice_release": (None, c_void_p,),
    "bccsplat_slice_get_info": (c_int32, c_void_p, POINTER(SliceInfo),),
    "bccsplat_slice_evaluate": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p,),
    "bccsplat_slice_sample_grid": (c_int32, c_void_p, POINTER(Grid), c_void_p,),
    "bccsplat_slice_get_points": (c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p,),
    "bccsplat_slice_get_brick_info": (c_int32, c_void_p, POINTER(BrickOptions), POINTER(BrickInfo),),
    "bccsplat_slice_find_bricks": (c_int32, c_void_p, POINTER(BrickOptions), c_void_p, c_void_p, c_void_p,),
    "bccsplat_slice_get_bricks": (c_int32, c_void_p, POINTER(BrickOptions), c_uint64, c_void_p, c_void_p,
        c_void_p,),
    "bccsplat_slice_fit_camera": (c_int32, c_void_p, c_int32, c_double, c_double, c_uint32, c_uint32,
        POINTER(Camera),),
    "bccsplat_fit_camera": (c_int32, POINTER(Fit), c_uint32, c_uint32, POINTER(Camera),),
    "bccsplat_volume_get_side": (c_int32, c_void_p, c_void_p,),
    "bccsplat_make_box_clips": (c_int32, c_void_p, POINTER(Clip),),
    "bccsplat_camera_get_matrices": (c_int32, POINTER(Camera), c_uint32, c_uint32, c_double, c_double,
        c_int32, c_uint32, c_void_p, c_void_p,),
    "bccsplat_view_project": (c_int32, POINTER(View), c_uint32, c_uint32, c_uint64, c_void_p, c_void_p,),
    "bccsplat_view_unproject": (c_int32, POINTER(View), c_uint32, c_uint32, c_uint64, c_void_p, c_void_p,),
    "bccsplat_slice_get_seen_bounds": (c_int32, c_void_p, POINTER(TransferFunction), c_void_p,),
    "bccsplat_volume_get_look": (c_int32, c_void_p, c_uint32, c_int32, c_int32, POINTER(Look),),
    "bccsplat_slice_get_look": (c_int32, c_void_p, c_int32, c_int32, POINTER(Look),),
    "bccsplat_slice_pick": (c_int32, c_void_p, POINTER(Ray), POINTER(Hit),),
    "bccsplat_slice_get_picture_needs": (c_int32, c_void_p, POINTER(Camera), c_uint32, c_uint32,
        POINTER(RenderOptions), POINTER(PictureNeeds),),
    "bccsplat_slice_get_view_needs": (c_int32, c_void_p, POINTER(View), POINTER(Clip), c_uint64, c_uint32,
        c_uint32, POINTER(RenderOptions), POINTER(PictureNeeds),),
    "bccsplat_renderer_create": (c_int32, c_void_p, c_void_p,),
    "bccsplat_renderer_retain": (None, c_void_p,),
    "bccsplat_renderer_release": (None, c_void_p,),
    "bccsplat_renderer_set_slice": (c_int32, c_void_p, c_void_p,),
    "bccsplat_renderer_set_trail": (c_int32, c_void_p, POINTER(Trail),),
    "bccsplat_renderer_set_camera": (c_int32, c_void_p, POINTER(Camera),),
    "bccsplat_renderer_set_view": (c_int32, c_void_p, POINTER(View),),
    "bccsplat_renderer_set_clips": (c_int32, c_void_p, POINTER(Clip), c_uint64,),
    "bccsplat_renderer_set_transfer_function": (c_int32, c_void_p, POINTER(TransferFunction),),
    "bccsplat_renderer_set_lights": (c_int32, c_void_p, POINTER(Lights),),
    "bccsplat_renderer_set_options": (c_int32, c_void_p, POINTER(RenderOptions),),
    "bccsplat_renderer_render": (c_int32, c_void_p, c_void_p,),
    "bccsplat_renderer_cancel": (c_int32, c_void_p,),
    "bccsplat_renderer_get_stats": (c_int32, c_void_p, POINTER(RenderStats),),
    "bccsplat_frame_create": (c_int32, c_void_p, c_uint32, c_uint32, c_uint32, c_void_p,),
    "bccsplat_frame_wrap": (c_int32, c_void_p, c_uint32, c_uint32, c_void_p, c_uint64, c_void_p,),
    "bccsplat_frame_wrap_planes": (c_int32, c_void_p, c_uint32, c_uint32, POINTER(HostPlane), c_uint64,
        c_void_p,),
    "bccsplat_frame_wrap_gl": (c_int32, c_void_p, POINTER(GlTarget), c_void_p,),
    "bccsplat_frame_retain": (None, c_void_p,),
    "bccsplat_frame_release": (None, c_void_p,),
    "bccsplat_frame_get_channel": (c_int32, c_void_p, c_uint32, POINTER(Plane),),
    "bccsplat_frame_copy": (c_int32, c_void_p, c_uint32, c_int32, c_void_p, c_int64,),
    "bccsplat_frame_copy_part": (c_int32, c_void_p, c_uint32, c_int32, c_uint32, c_uint32, c_uint32, c_uint32,
        c_void_p, c_int64,),
    "bccsplat_frame_get_deep": (c_int32, c_void_p, POINTER(Deep),),
    "bccsplat_frame_save_exr": (c_int32, c_void_p, c_char_p, POINTER(ImageOptions),),
    "bccsplat_frame_save_deep_exr": (c_int32, c_void_p, c_char_p, POINTER(ImageOptions),),
    "bccsplat_frame_save_png": (c_int32, c_void_p, c_char_p, POINTER(ImageOptions),),
    "bccsplat_frame_save_stream": (c_int32, c_void_p, c_int32, POINTER(WriteStream), POINTER(ImageOptions),),
    "bccsplat_frame_save_memory": (c_int32, c_void_p, c_int32, POINTER(ImageOptions), c_void_p, c_uint64,
        c_void_p,),
    "bccsplat_scene_create": (c_int32, c_void_p, c_void_p,),
    "bccsplat_scene_retain": (None, c_void_p,),
    "bccsplat_scene_release": (None, c_void_p,),
    "bccsplat_scene_add": (c_int32, c_void_p, c_void_p, POINTER(Instance), c_void_p,),
    "bccsplat_scene_set_instance": (c_int32, c_void_p, c_uint64, POINTER(Instance),),
    "bccsplat_scene_remove": (c_int32, c_void_p, c_uint64,),
    "bccsplat_scene_set_time": (c_int32, c_void_p, c_double,),
    "bccsplat_scene_set_clips": (c_int32, c_void_p, POINTER(Clip), c_uint64,),
    "bccsplat_scene_set_lights": (c_int32, c_void_p, POINTER(Lights),),
    "bccsplat_scene_get_bounds": (c_int32, c_void_p, c_void_p,),
    "bccsplat_scene_fit_camera": (c_int32, c_void_p, c_int32, c_double, c_double, c_uint32, c_uint32,
        POINTER(Camera),),
    "bccsplat_scene_render": (c_int32, c_void_p, POINTER(View), c_void_p, POINTER(RenderOptions), c_double,
        POINTER(SceneStatus),),
    "bccsplat_scene_prefetch": (c_int32, c_void_p, POINTER(View), c_uint32, c_uint32, POINTER(RenderOptions),
        c_double,),
    "bccsplat_scene_get_ranges": (c_int32, c_void_p, POINTER(View), c_uint32, c_uint32,
        POINTER(RenderOptions), c_double, c_uint64, c_uint32, c_void_p, c_uint64, c_void_p,),
}
