"""python_host_test.py TOP EXAMPLES SCRATCH: the Python package agrees with the C hosts and with the ABI lists, and
every function of the library is called through it."""
import ctypes
import os
import re
import shutil
import subprocess
import sys
import threading

try:
    import numpy as np
except ImportError:
    print("skipped: this Python has no numpy")
    sys.exit(77)

top, examples, scratch = sys.argv[1:]
sys.path.insert(0, os.path.join(top, "examples", "python"))
sys.dont_write_bytecode = True
import bccsplat  # noqa: E402
from bccsplat import Cancelled, CancelToken, Channel, Device, Error, Frame, RenderOptions, Renderer, Scene, Slice  # noqa: E402
from bccsplat import Status, TransferFunction, View, box_clips, camera_matrices  # noqa: E402
from bccsplat import Volume, WouldBlock, Writer, abi, join_parts, join_streams, look_at  # noqa: E402
from bccsplat import _library as loaded  # noqa: E402
from bccsplat.__main__ import main  # noqa: E402

called = set()


class Recorder:
    """The library, with a list of what was called."""

    def __getattr__(self, name):
        called.add(name)
        return getattr(recorded, name)


recorded, loaded.native = loaded.native, Recorder()
bccsplat.native = loaded.native


def raises(kind, status, function, *arguments, text="", **named):
    try:
        function(*arguments, **named)
    except kind as error:
        assert status is None or error.status == status, error
        assert text in str(error), error
        return error
    raise AssertionError("nothing was raised")


def layout():
    """Struct for struct and field for field as the compiler lays them out, and every constant."""
    structs = {}
    for line in open(os.path.join(top, "tests", "abi", "layout.txt"), encoding="utf-8"):
        if match := re.match(r"bccsplat_(\w+)\.(\w+) offset (\d+) size (\d+)", line):
            structs.setdefault(match[1], {})[match[2]] = (int(match[3]), int(match[4]))
        elif match := re.match(r"struct bccsplat_(\w+) size (\d+)", line):
            structs.setdefault(match[1], {})[""] = int(match[2])
        elif match := re.match(r"BCCSPLAT_(\w+) (-?\d+)", line):
            assert getattr(abi, match[1]) == int(match[2]), line
    assert len(structs) > 20
    for name, expected in structs.items():
        struct = getattr(abi, "".join(part.capitalize() for part in name.split("_")))
        fields = {field: (getattr(struct, field).offset, getattr(struct, field).size) for field, _ in struct._fields_}
        assert fields | {"": ctypes.sizeof(struct)} == expected, name


def blob(x, y, z, t):
    return np.exp(-((x - 10 - t) ** 2 + (y - 9) ** 2 + (z - 8) ** 2) / 18).astype(np.float32)


def write(device, target, **options):
    """21 x 19 x 17 voxels, 6 frames, from a transposed view, boxes, and a plain array."""
    z, y, x = np.mgrid[0:17, 0:19, 0:21]
    writer = Writer(device, target, (21, 19, 17, 6), channels=[Channel("density", "g", air_threshold=1e-4)],
                    affine=np.diag([2.0, 2, 2, 1]), spatial_unit="mm", time_unit="s", **options)
    with writer:
        writer.set_attribute("source", "made up: ü")
        writer.add_source("nowhere.raw", 12, 34)
        for t in range(6):
            frame = blob(x, y, z, t)
            if t == 1:
                frame = np.asfortranarray(frame)
            if t == 2:
                frame = [((0, 0, 0), frame[:, :, :11]), ((11, 0, 0), frame[:, ::-1][:, ::-1, 11:])]
            if t == 3:
                frame = frame.astype(">f4")
            writer.add_frame(frame, time=t / 2)
    return writer


def memory_file():
    """Bytes, and a function that writes to them."""
    stream = bytearray()

    def write_at(offset, data):
        stream.extend(bytes(max(0, offset + len(data) - len(stream))))
        stream[offset:offset + len(data)] = data

    return stream, write_at


def late(device, content):
    """Bytes that are not there yet: what is lacking is told, and what will be read is told in advance."""
    there, reads = set(), []

    def read_at(offset, buffer):
        if not there.issuperset(range(offset, offset + len(buffer))):
            return None
        reads.append((offset, len(buffer)))
        buffer[:] = content[offset:offset + len(buffer)]
        return len(buffer)

    def patient(call):
        while True:
            try:
                return call()
            except WouldBlock as error:
                assert error.ranges and error.status == Status.WOULD_BLOCK
                for offset, size in error.ranges:
                    there.update(range(offset, offset + size))

    volume = patient(lambda: Volume(device, (len(content), read_at, 1 << 16)))
    ranges = patient(lambda: volume.ranges(frame=2.5, interval=(-0.5, 0.5)))
    for offset, size in ranges.tolist():
        there.update(range(offset, offset + size))
    reads.clear()
    cut = volume.slice(frame=2.5, interval=(-0.5, 0.5))
    assert all(any(o <= offset and offset + size <= o + s for o, s in ranges.tolist()) for offset, size in reads)
    assert len(volume.ranges(frame=2.5, interval=(-0.5, 0.5), missing=True)) == 0
    assert len(volume.ranges(plane=(1, 1, 0, 1, -12))) > 0
    raises(ValueError, None, volume.ranges)
    with Volume(device, content) as same:
        assert np.array_equal(cut.sample_grid(), same.slice(frame=2.5, interval=(-0.5, 0.5)).sample_grid())


def uneven_axes(device, folder):
    """Depths come back as they were, and the world has them."""
    depths, path = np.array([0, 10, 20, 30, 50, 100, 200, 500.0]), os.path.join(folder, "depths.bcc4")
    x, y = np.meshgrid(np.arange(9), np.arange(7))
    field = np.array([20 * np.exp(-d / 100) + np.sin(.5 * x) * np.cos(.4 * y) for d in depths], np.float32)
    axes = [(None, "km", False), (None, "km", False), (depths, "m", True)]
    with Writer(device, path, (9, 7, 8, 1), affine=np.diag([1, 1, -500 / 7, 1]), axes=axes, abs_error=0.01) as writer:
        writer.add_frame(field, time=0)
    volume = Volume(device, path)
    values, unit, down = volume.axis(2)
    assert values.tolist() == depths.tolist() and unit == "m" and down
    assert volume.info().spatial_unit == "" and volume.axis(0)[1] == "km"
    world = volume.index_to_world([[3, 2, i] for i in range(8)])
    assert np.abs(world[:, 2] + depths).max() < 1e-9
    got = volume.evaluate_world(np.c_[world, np.zeros(8)])[0]
    assert np.abs(got - field[:, 2, 3]).max() < 0.011
    assert np.abs(volume.read_frame(0, (1, 0, 2), (4, 3, 8)) - field[2:8, 0:3, 1:4]).max() < 0.011
    even = volume.slice(frame=0, space="even").sample_grid()  # at even depths
    assert abs(even[7, 2, 3] - field[7, 2, 3]) < 0.1 and np.abs(even[1] - field[1]).max() > 5


def files(device, folder):
    """Path, stream and memory are the same file; what Python raises comes out of the call that met it."""
    path, progress = os.path.join(folder, "s.bcc4"), []
    write(device, path, overwrite=True, progress=progress.append)
    assert progress == sorted(progress) and progress[-1] == 1
    content = open(path, "rb").read()
    stream, write_at = memory_file()
    flushes = []
    write(device, write_at, flush=lambda: flushes.append(len(stream)))
    assert bytes(stream) == content and flushes[-1] == len(content)

    def full(_offset, _data):
        raise OSError("the archive is full")

    raises(OSError, None, write, device, full, text="archive is full")
    raises(Error, Status.FILE_EXISTS, write, device, path)
    raises(ZeroDivisionError, None, write, device, path, overwrite=True, progress=lambda fraction: 1 / 0)
    assert open(path, "rb").read() == content  # neither attempt touched it
    raises(ValueError, None, Writer, device, path, (1, 1, 1), lattice="fcc", text="d4star")
    # Options by the names of the header, and these only; constants by theirs.
    raises(TypeError, None, Writer, device, path, (1, 1, 1), abs_eror=1e-3, text="unexpected keyword argument 'abs_eror'")
    raises(TypeError, None, abi.WriterOptions, abs_eror=1e-3, text="did you mean 'abs_error'?")
    raises(ValueError, None, Writer, device, path, (1, 1, 1), measure="much", text="all")
    assert abi.WriterOptions(measure="all", faces="mirror", partial="keep").measure == abi.MEASURE_ALL

    def read_at(offset, buffer):
        buffer[:] = content[offset:offset + len(buffer)]
        return len(buffer)

    late(device, content)
    volumes = [Volume(device, source) for source in (path, content, bytearray(content), (len(content), read_at))]
    points = np.random.default_rng(1).uniform([0, 0, 0, 0], [20, 18, 16, 5], (100, 4))
    values = [volume.evaluate(points) for volume in volumes]
    assert all(np.array_equal(values[0], other) for other in values)
    assert np.abs(values[0] - blob(*points.T)).max() < 0.02
    out = np.zeros(100, np.float32)
    assert volumes[0].evaluate(points, out=out) is out and np.array_equal(out, values[0])
    for call in (volumes[0].evaluate, volumes[0].evaluate_with_gradients):
        raises(ValueError, None, call, np.zeros((3000, 3)), text="[..., 4], not (3000, 3)")
        raises(ValueError, None, call, 4.0)
    again, slopes = volumes[0].evaluate_with_gradients(points)
    assert np.array_equal(again, out)
    inner, step = points.clip(0.1, 4.9), np.array([1e-3, 0, 0, 0])
    rise = (volumes[0].evaluate(inner + step) - volumes[0].evaluate(inner - step)) / 2e-3
    assert np.abs(volumes[0].evaluate_with_gradients(inner)[1][:, 0] - rise).max() < 2e-3
    info = volumes[0].info()
    affine = np.array(info.affine[:]).reshape(4, 4)
    placed = np.c_[inner[:, :3] @ affine[:3, :3].T + affine[:3, 3], [volumes[0].index_to_time(t) for t in inner[:, 3]]]
    assert np.abs(volumes[0].evaluate_world(placed)[0] - volumes[0].evaluate(inner)).max() < 1e-3
    assert np.isnan(volumes[0].evaluate_world(placed - [1e6, 0, 0, 0])[0]).all()
    assert np.abs(volumes[0].index_to_world(inner[:, :3]) - placed[:, :3]).max() < 1e-9
    assert np.abs(volumes[0].world_to_index(placed[:, :3]) - inner[:, :3]).max() < 1e-9
    assert volumes[0].axis(2)[0].size == 0 and volumes[0].axis(2)[1:] == ("", False)
    uneven_axes(device, folder)
    recorded_evaluate(volumes[0], points, out)
    partly = raises(Error, Status.OUT_OF_DOMAIN, volumes[0].evaluate, [[0, 0, 0, 0], [99, 0, 0, 0]], out=out[:2])
    assert partly.name == "BCCSPLAT_ERROR_OUT_OF_DOMAIN" and np.isnan(out[1]) and not np.isnan(out[0])
    raises(Error, Status.IO, Volume, device, (len(content), lambda offset, buffer: 1 / 0))
    missing = os.path.join(folder, "missing.bcc4")
    raises(Error, Status.FILE_NOT_FOUND, Volume, device, missing, text="missing.bcc4")
    return volumes[0]


def recorded_evaluate(volume, points, expected):
    """The call without a channel, which the package has no use for."""
    values = np.empty(len(points), np.float32)
    loaded.call("volume_evaluate", volume.pointer, len(points), points.ctypes.data, values.ctypes.data, None)
    assert np.array_equal(values, expected)


def volume_facts(volume):
    info, channel = volume.info(), volume.channel_info(volume.find_channel("density"))
    assert info.dims[:] == [21, 19, 17, 6] and info.spatial_unit == "mm" and channel.unit == "g"
    assert np.allclose(volume.times(), np.arange(6) / 2)
    z, y, x = np.mgrid[0:17, 0:19, 0:21]
    frames = [blob(x, y, z, t) for t in range(6)]
    assert np.array_equal(volume.frame_ranges(), [(frame.min(), frame.max()) for frame in frames])
    raises(Error, Status.NOT_FOUND, volume.frame_ranges, 1)
    assert volume.time_to_index(1.25) == 2.5 and volume.index_to_time(2.5) == 1.25
    assert volume.attributes()["source"] == volume.find_attribute("source") == "made up: ü"
    raises(Error, Status.NOT_FOUND, volume.find_channel, "colour")
    whole = volume.level_info(0)
    assert whole.layer_count == volume.info().layer_count and whole.sites_total == volume.info().sites_total
    raises(Error, Status.NOT_FOUND, volume.level_info, 1)
    assert volume.sources() == [("nowhere.raw", 12, 34)]
    report = volume.verify()
    assert report.damages == 0 and report.chunks > 0
    raises(Cancelled, Status.CANCELLED, volume.verify, lambda fraction: True)


def slices(volume):
    cut = volume.slice(time=1.25)
    box = cut.sample_grid()
    assert np.array_equal(Slice.at(volume, volume.time_to_index(1.25)).sample_grid(), box)
    raises(Error, Status.OUT_OF_DOMAIN, Slice.at_time, volume, 99)
    assert box.shape == (17, 19, 21) and cut.info().kernel == volume.info().kernel
    points = np.array([(10, 9, 8), (3, 4, 5), (13.5, 8, 7)])
    for call in (cut.evaluate, cut.evaluate_with_gradients):
        raises(ValueError, None, call, np.zeros((5, 4)), text="[..., 3], not (5, 4)")
    values, slopes = cut.evaluate_with_gradients(points)
    assert np.array_equal(values, cut.evaluate(points)) and slopes.shape == (3, 3)
    assert np.allclose(box[[8, 5], [9, 4], [10, 3]], values[:2], atol=1e-6)
    fine = cut.sample_grid((10, 9, 8), (0.5, 0.5, 0.5), (3, 2, 1))
    assert fine.shape == (1, 2, 3) and abs(fine[0, 0, 0] - values[0]) < 1e-6
    uvw, coefficients = cut.points()
    assert len(uvw) == len(coefficients) == cut.info().points > 0
    assert cut.look().iso_value == volume.look().iso_value
    oblique = volume.slice(plane=(-0.25, 0, 0, 1, 0))
    assert oblique.info().hyperplane[3] > 0.9
    volume.prefetch(3.25)
    assert Slice.at(volume, 3.25).info().bytes_read == 0
    raises(Error, Status.OUT_OF_DOMAIN, volume.prefetch, 17)
    part = Slice.at(volume, 2.5, box=((2, 3, 1), (5, 3, 6))).sample_grid()
    assert part.shape == (6, 1, 4)
    np.testing.assert_allclose(part, Slice.at(volume, 2.5).sample_grid()[1:7, 3:4, 2:6], atol=1e-5)
    mean = Slice.at(volume, 2.5, interval=(-1, 1)).sample_grid()
    assert 0 < np.abs(mean - box).max() < 0.2
    turned = Slice.along(volume, (10, 9, 8, 2.5), [(1, 1, 0, 0), (-1, 1, 0, 0), (0, 0, 1, 0)])
    assert abs(turned.evaluate([(0, 0, 0)])[0] - values[0]) < 0.01
    assert np.allclose(turned.info().origin, (10, 9, 8, 2.5))
    raises(ValueError, None, volume.slice)
    raises(TypeError, None, volume.slice, frame=3, levle=1, text="'levle'")
    assert np.array_equal(volume.slice(frame=2, slab="mean").sample_grid(), volume.slice(frame=2).sample_grid())
    raises(Error, Status.OUT_OF_DOMAIN, volume.slice, frame=17)
    return cut


def pictures(device, volume, cut, folder):
    renderer = Renderer(device)
    raises(Error, Status.WRONG_STATE, renderer.stats)
    renderer.set_slice(cut)
    frame = Frame(device, 60, 40, Frame.RGBA | Frame.DEPTH)
    pixels = frame.rgba()  # a view: it sees every later picture
    renderer.render(frame)
    first = pixels.copy()
    assert first.shape == (40, 60, 4) and 0 < first[..., 3].max() <= 1 and frame.depth().shape == (40, 60)
    raises(Error, Status.NOT_FOUND, frame.channel, Frame.TIME)
    assert np.array_equal(frame.copy("f32"), first) and np.abs(frame.copy("f16") - first).max() < 1e-3
    assert np.array_equal(frame.copy("F32"), first) and np.array_equal(frame.copy_part(0, 0, 60, 40, abi.PIXELS_F32), first)
    straight, multiplied = frame.copy(), frame.copy("srgb8_premultiplied")
    assert straight.dtype == np.uint8 and np.array_equal(straight[..., 3], np.round(first[..., 3] * 255))
    assert np.all(multiplied <= straight) and multiplied.any() and frame.copy("f16", Frame.DEPTH).shape == (40, 60)
    raises(Error, Status.INVALID_ARGUMENT, frame.copy, "srgb8", Frame.DEPTH)
    wide = np.zeros((40, 80, 4), np.float32)
    renderer.render(Frame.wrap(device, wide[:, :60]))
    assert np.array_equal(wide[:, :60], first) and not wide[:, 60:].any()
    kept = np.zeros((40, 60, 4), np.float32)
    kept.flags.writeable = False
    one_row = np.lib.stride_tricks.as_strided(wide, (40, 60, 4), (0, 16, 4))
    for pixels_of_others in (kept, one_row):
        raises(ValueError, None, Frame.wrap, device, pixels_of_others, text="writable float32")
        raises(ValueError, None, Frame.wrap_planes, device, 60, 40, {Frame.RGBA: pixels_of_others}, text="writable float32")
    upside_down, depth = np.zeros((40, 60, 4), np.float32), np.zeros((40, 70), np.float32)
    planes = Frame.wrap_planes(device, 60, 40, {Frame.RGBA: upside_down[::-1], Frame.DEPTH: depth[:, :60],
                                                Frame.VALUE: None})
    renderer.render(planes)
    assert np.array_equal(upside_down[::-1], first) and np.array_equal(planes.rgba(), first)
    assert np.array_equal(depth[:, :60], frame.depth()) and not depth[:, 60:].any()
    assert planes.channel(Frame.VALUE).shape == (40, 60)
    raises(ValueError, None, Frame.wrap_planes, device, 60, 40, {Frame.DEPTH: depth}, text="[height, width]")
    raises(Error, Status.INVALID_ARGUMENT, Frame.wrap_planes, device, 60, 40, {64: None}, text="channel bit")
    copied = np.zeros((40, 60, 4), np.uint8)

    def tile(x, y, width, height):
        copied[y:y + height, x:x + width] = frame.copy_part(x, y, width, height)

    renderer.set_options(tile=tile)
    renderer.render(frame)
    assert np.array_equal(copied, straight)
    renderer.set_options(tile=lambda *_: True)
    raises(Cancelled, None, renderer.render, frame)
    renderer.set_options(tile=lambda *_: 1 / 0)
    raises(ZeroDivisionError, None, renderer.render, frame)
    renderer.set_options()

    renderer.set_transfer_function(TransferFunction.of(volume.look(mode="composite")))
    renderer.render(frame)
    assert np.array_equal(pixels, first)  # what nobody sets is this
    renderer.set_transfer_function(TransferFunction([(0, 1, 0, 0), (1, 1, 0, 0)], [(0, 0), (1, 0.9)]))
    renderer.set_options(shading="off", quality="draft")
    camera = cut.fit_camera(60, 40, 0, 0, "perspective")
    fitted = bccsplat.fit_camera(cut.seen_bounds(), 60, 40, side=volume.side(), rotate_x=0, rotate_y=0)
    assert fitted.position[2] > fitted.target[2] and fitted.up[1] == 1 and fitted.ortho_height < 40
    everything = TransferFunction([(0, 1, 1, 1)], [(0, 1)])
    assert cut.seen_bounds(everything)[:3] == (0, 0, 0)
    renderer.set_camera(camera)
    needs = cut.picture_needs(camera, 60, 40, quality="draft")
    assert needs.seen == 1 and needs.level == 0 and needs.box[3] > needs.box[0] and needs.distances_per_pixel > 0
    try:
        gpu = device.gpu_info()
        assert gpu.renderer and gpu.version and gpu.software in (0, 1)
    except Error as e:
        assert e.status == Status.MISSING_FEATURE, e
    try:  # without a context of the host's there is no texture to draw into
        renderer.render(Frame.wrap_gl(device, 1, 60, 40, replace=True))
        raise AssertionError("drawn into nothing")
    except Error as e:
        assert e.status == Status.MISSING_FEATURE, e
    renderer.set_lights([((0, 0, -1), (1, 1, 1))], ambient=1)
    renderer.render(frame)
    assert pixels[..., 0].any() and not pixels[..., 1].any()
    renderer.set_trail((-2, 0), content="classified", combine="physical", samples=8, intervals=2,
                       colors=[(0, 1, 0), (0, 0, 1)])
    renderer.render(frame)
    assert pixels[..., 1].any() and pixels[..., 2].any()
    of_parts = [TransferFunction([(0, *color)], [(0, 0), (1, 0.9)]) for color in ((0, 1, 0), (0, 0, 1))]
    listed = pixels.copy()
    renderer.set_trail((-2, 0), content="classified", combine="physical", samples=8, transfer_functions=of_parts)
    renderer.render(frame)
    assert np.array_equal(pixels, listed)  # the function of before in the colours of before
    raises(ValueError, None, renderer.set_trail, (-2, 0), intervals=3, transfer_functions=of_parts, text="2 transfer functions")
    raises(ValueError, None, renderer.set_trail, (-2, 0), intervals=3, weights=(1, 2), text="2 weights for 3")
    shown = []
    for weights in ((1, 1), (1, 3), (2, 6)):
        renderer.set_trail((-2, 0), samples=8, weights=weights, unlit=True)
        renderer.render(frame)
        shown.append(frame.rgba().copy())
    assert not np.array_equal(shown[0], shown[1]) and np.array_equal(shown[1], shown[2])
    renderer.set_trail(None)
    renderer.set_options(mode="maximum")
    renderer.set_camera(look_at((20, 18, -100), (20, 18, 16), ortho_height=40))
    renderer.render(frame)
    stats, seen = renderer.stats(), pixels[..., 0].copy()
    assert 0 < stats.points_after_cull <= stats.points_total
    assert seen.max() > 0.1 and not pixels[..., 1].any()  # red alone, as the function has it
    renderer.set_camera(look_at((20, 18, -100), (20 + 300, 18, 16), ortho_height=40))
    renderer.render(frame)
    assert not pixels[..., :3].any() and renderer.stats().points_after_cull < stats.points_after_cull
    renderer.set_camera(look_at((20, 18, -100), (20, 18, 16), ortho_height=40))
    raises(ValueError, None, renderer.set_options, mode="minimum")
    raises(TypeError, None, renderer.set_options, sheetstep=0.1, text="unexpected keyword argument 'sheetstep'")
    renderer.set_options(progress=lambda fraction: True)
    raises(Cancelled, Status.CANCELLED, renderer.render, frame)
    renderer.cancel()  # nothing under way: no effect
    renderer.set_options(progress=lambda fraction: 1 / 0)
    raises(ZeroDivisionError, None, renderer.render, frame)
    drawn = {}
    for choice in ("off", "on", None):
        renderer.set_options(preintegrate=choice)
        renderer.render(frame)
        drawn[choice] = frame.rgba().copy()
        assert renderer.stats().preintegrated == (choice == "on")
    assert np.array_equal(drawn["off"], drawn[None]) and not np.array_equal(drawn["off"], drawn["on"])
    surfaces = [(0.3, 0.5, (1, 0, 0)), (0.6, 1)]
    renderer.set_options(mode="isosurface", shading="off", smooth_edges="off", surfaces=surfaces)
    renderer.render(frame)
    drawn["two"] = pixels.copy()
    renderer.set_options(mode="isosurface", shading="off", smooth_edges="off", surfaces=surfaces[:1])
    renderer.render(frame)
    assert np.array_equal(pixels[..., 3] > 0, drawn["two"][..., 3] > 0) and drawn["two"][..., 3].max() == 1
    assert 0.5 <= pixels[..., 3].max() < 1 and np.array_equal(pixels[..., 0], pixels[..., 3]) and not pixels[..., 2].any()
    raises(Error, Status.INVALID_ARGUMENT, renderer.set_options, mode="isosurface", surfaces=[(0.3, 2)])
    raises(ValueError, None, renderer.set_options, preintegrate="sometimes")
    raises(ValueError, None, renderer.set_options, smooth_edges="sometimes")
    raises(Error, Status.INVALID_ARGUMENT, renderer.set_options, gradient_noise=-1)
    renderer.set_lights([((0, 0, -1), (1, 1, 1))], ambient=0.3, diffuse=0.7)
    for noise in (0, 1e6, None):
        renderer.set_options(gradient_noise=noise)
        renderer.render(frame)
        drawn[noise] = frame.rgba().copy()
    assert not np.array_equal(drawn[0], drawn[1e6]) and not np.array_equal(drawn[None], drawn[1e6])
    renderer.set_options()
    frame.save_png(os.path.join(folder, "p.png"), overwrite=True, background=(0, 0, 0))
    frame.save_exr(os.path.join(folder, "p.exr"), overwrite=True)
    raises(Error, Status.FILE_EXISTS, frame.save_png, os.path.join(folder, "p.png"))
    stream, write_at = memory_file()
    frame.save_stream(write_at, background=(0, 0, 0))
    for image in (bytes(stream), frame.to_bytes(background=(0, 0, 0))):
        assert image == open(os.path.join(folder, "p.png"), "rb").read()
    assert frame.to_bytes("exr") == open(os.path.join(folder, "p.exr"), "rb").read()
    raises(ZeroDivisionError, None, frame.to_bytes, progress=lambda fraction: 1 / 0)
    raises(ZeroDivisionError, None, frame.save_stream, lambda offset, data: 1 / 0)
    frame.close()
    pixels[0, 0] = 1  # still there
    with Frame(device, 60, 40, Frame.DEEP) as frame:
        raises(Error, Status.WRONG_STATE, frame.deep)
        renderer.set_options(deep_tolerance=0.01)
        renderer.render(frame)
        first, samples = frame.deep()
        assert first[0] == 0 and first[-1] == len(samples) > 0 and samples.shape[1] == 6
        for p in range(60 * 40):
            rgba = np.zeros(4)
            for z, z_back, opacity, red, green, blue in samples[first[p]:first[p + 1]].astype(float):
                assert z_back >= z
                rgba += (1 - rgba[3]) * np.array([red, green, blue, opacity])
            assert np.allclose(rgba, frame.rgba().reshape(-1, 4)[p], atol=1e-5)
        frame.save_deep_exr(os.path.join(folder, "d.exr"), overwrite=True, comments="deep")
    shared = renderer.share()
    renderer.close()
    shared.close()


def bricks_of_slice(cut):
    """Bricks put together again are the slice; those that are not listed are empty."""
    whole = cut.sample_grid()
    for dtype, tolerance in ((np.float32, 1e-4), (np.uint16, 1e-4), (np.uint8, 2 / 255)):
        bricks = cut.bricks(dtype=dtype, edge=4, border=2)
        nz, ny, nx = bricks.index.shape[1:]
        got = np.full((4 * nz, 4 * ny, 4 * nx), bricks.info.empty)
        for k, j, i in np.argwhere(bricks.index[0]):
            brick = bricks.values[bricks.index[0, k, j, i] - 1] * bricks.info.scale + bricks.info.offset
            got[4 * k:4 * k + 4, 4 * j:4 * j + 4, 4 * i:4 * i + 4] = brick[2:6, 2:6, 2:6]
            low, high = bricks.bounds[0, k, j, i]
            assert brick.min() >= low - tolerance * np.ptp(whole) and brick.max() <= high + tolerance * np.ptp(whole)
        got = got[:whole.shape[0], :whole.shape[1], :whole.shape[2]]
        assert np.abs(got - whole).max() <= tolerance * np.ptp(whole), dtype
    assert cut.bricks("sites").info.kernel_radius > 1
    raises(ValueError, None, cut.bricks, dtype=np.float64, text="float64")


def scenes(device, volume, cut):
    """A volume among a host's own things: by matrices, behind its depths, cut open, twice."""
    renderer, frame = Renderer(device), Frame(device, 60, 40)
    renderer.set_slice(cut)
    camera = cut.fit_camera(60, 40, projection="perspective")
    renderer.set_camera(camera)
    renderer.render(frame)
    whole = frame.rgba().copy()
    world_to_view, projection = camera_matrices(camera, 60, 40, 1, 1000, "reversed")
    view = View(world_to_view=world_to_view, projection=projection, depth_range="reversed")
    renderer.set_view(view)
    renderer.render(frame)
    assert np.allclose(frame.rgba(), whole, atol=2e-5)
    points = np.array([[3.0, 4, 5], [7, 8, 9]])
    pixels = view.project(points, 60, 40)
    assert np.allclose(view.unproject(pixels, 60, 40), points)
    clip = world_to_view @ [*points[0], 1]
    ndc = projection @ clip
    assert np.allclose(pixels[0, :2], [(ndc[0] / ndc[3] + 1) * 30, (1 - ndc[1] / ndc[3]) * 20])
    ends = view.unproject([(30, 20, 0), (30, 20, 1)], 60, 40)  # the ray of the picture's middle
    most = cut.pick(ends[0], ends[1] - ends[0], "maximum")
    assert most is not None and np.allclose(view.project([most.world[:]], 60, 40)[0, :2], (30, 20))
    assert np.isclose(cut.evaluate([most.uvw[:]])[0], most.value)
    met = cut.pick(ends[0], ends[1] - ends[0], threshold=most.value / 2)
    assert met is not None and met.distance < most.distance and np.isclose(met.value, most.value / 2, rtol=1e-2)
    assert cut.pick(ends[0], ends[0] - ends[1]) is None  # nothing is behind the eye
    bricks_of_slice(cut)
    near, behind = np.ones((40, 60), np.float32), np.full((40, 60, 4), 0.5, np.float32)  # depth 1 is the near plane
    renderer.set_view(View(world_to_view=world_to_view, projection=projection, depth_range="reversed", depth=near,
                           background=behind))
    renderer.render(frame)
    assert np.array_equal(frame.rgba(), behind)
    raises(ValueError, None, renderer.render, Frame(device, 61, 40))
    raises(ValueError, None, View, world_to_view=world_to_view)
    renderer.set_view(None)
    renderer.set_clips([(1, 0, 0, 1e6)])
    renderer.set_camera(camera)
    renderer.render(frame)
    assert np.array_equal(frame.rgba(), whole)
    renderer.set_clips([])
    faces = box_clips(np.diag([2.0, 3, 4, 1]))
    assert faces[0] == (0.5, 0, 0, 0) and faces[5] == (0, 0, -0.25, 1)
    needs = cut.view_needs(View(camera), 60, 40)
    assert list(needs.box) == list(cut.picture_needs(camera, 60, 40).box)

    scene = Scene(device)
    first = scene.add(volume, outside="hold")
    scene.set_time(volume.info().time_first)
    width, bounds = volume.info().dims[0], scene.bounds()
    view = View(scene.fit_camera(60, 40))
    assert scene.render(frame, view, RenderOptions(quality="draft")).complete == 1
    one = frame.rgba()[..., 3].sum()
    beside = np.eye(4)
    beside[0, 3] = bounds[3] - bounds[0]
    second = scene.add(volume, outside="hold", placement=beside, density=0.5)
    assert first == 1 and second == 2 and scene.bounds()[3] > bounds[3] and width > 1
    status = scene.render(frame, View(scene.fit_camera(60, 40)))
    assert status.drawn == 2
    scene.set_instance(second, outside="hold", placement=beside, trail={"interval": (0, 2), "weights": (1, 2)})
    assert scene.render(frame, View(scene.fit_camera(60, 40))).drawn == 2
    scene.set_instance(second, channel="density", color_channel="density", outside="hold", placement=beside)
    assert scene.render(frame, View(scene.fit_camera(60, 40))).drawn == 2
    raises(Error, Status.NOT_FOUND, scene.add, volume, color_channel="colour")
    scene.set_instance(second, hidden=True)
    scene.render(frame, view, RenderOptions(quality="draft"))
    assert np.isclose(frame.rgba()[..., 3].sum(), one)
    scene.set_clips([(1, 0, 0, -1e6)])
    assert scene.render(frame, view).drawn == 0 and not frame.rgba().any()
    scene.set_clips([abi.Clip(normal=(1, 0, 0), offset=1e6, space=abi.CLIP_SPACE_VOLUME, instance=first)])
    scene.set_lights([((1, 0, 0), (1, 1, 1))])
    calls = 0
    while not scene.render(frame, view, budget_ms=1e-3).complete:
        calls += 1
    assert calls > 0
    assert scene.ranges(first, volume.info().time_first, 60, 40, view).shape[1] == 2
    scene.prefetch(volume.info().time_first, 60, 40, view)
    scene.remove(second)
    raises(Error, Status.NOT_FOUND, scene.remove, second)
    scene.close()
    renderer.close()


def cancelling(device, folder):
    """A token ends every long call that has it, before it begins or under way, until it is reset."""
    path, token = os.path.join(folder, "s.bcc4"), CancelToken()
    assert not token.cancelled
    volume, renderer, frame = Volume(device, path, cancel=token), Renderer(device), Frame(device, 60, 40)
    cut = volume.slice(frame=2, cancel=token)
    renderer.set_slice(cut)
    renderer.set_options(cancel=token)
    renderer.render(frame)
    first = frame.rgba().copy()
    token.cancel()
    assert token.cancelled
    points = np.zeros((1, 4))
    for function, *arguments in ((Volume, device, path), (Slice.at, volume, 2.5), (Volume.prefetch, volume, 3.0),
                                 (write, device, path + ".never"),
                                 (join_parts, device, [path], path + ".never")):
        raises(Cancelled, Status.CANCELLED, function, *arguments, cancel=token)
    for method in (cut.sample_grid, cut.points, volume.verify):
        raises(Cancelled, Status.CANCELLED, method)
    raises(Cancelled, Status.CANCELLED, cut.evaluate, points[:, :3])
    raises(Cancelled, Status.CANCELLED, volume.evaluate, points)
    raises(Cancelled, Status.CANCELLED, renderer.render, frame)
    assert np.array_equal(frame.rgba(), first) and not os.path.exists(path + ".never")
    token.reset()
    assert volume.evaluate(points)[0] < 0.1 and cut.sample_grid().max() > 0.9
    renderer.render(frame)
    assert np.array_equal(frame.rgba(), first)
    with Writer(device, path + ".new", (9, 9, 9, 2), overwrite=True, cancel=token) as writer:
        writer.add_frame(np.zeros((9, 9, 9), np.float32), 0)
        token.cancel()
        raises(Cancelled, Status.CANCELLED, writer.add_frame, np.ones((9, 9, 9), np.float32), 1)
        token.reset()
        writer.add_frame(np.ones((9, 9, 9), np.float32), 1)  # as if the call had not been made
        assert writer.finish().frames == 2
    shared = token.share()
    token.close()
    shared.cancel()
    assert shared.cancelled


def layers(device, folder):
    """Lattice samples written directly: a constant comes back but for the kernel's ripple."""
    path = os.path.join(folder, "layers.bcc4")
    with Writer(device, path, (9, 9, 9, 5), overwrite=True, channels=[Channel(value_type="f32")]) as writer:
        writer.set_times(10, 2)
        for layer in range(writer.layer_geometry().layer_count):
            x, y, z, frame = writer.layer_coordinates(layer)
            writer.add_layer(0 * x + 0 * y + 0 * z + 3.0, layer)
        report = writer.finish()
    assert report.sites_kept == report.sites_total
    with Volume(device, path) as volume:
        assert np.allclose(volume.times(), [10, 12, 14, 16, 18])
        assert np.allclose(volume.evaluate([[4, 4, 4, 2.2], [1, 2, 3, 4]]), 3, atol=0.01)


def refused_and_short(device, folder):
    """A frame that is refused does no harm, and a series may end before its time."""
    path = os.path.join(folder, "short.bcc4")
    with Writer(device, path, (9, 9, 9, 12), overwrite=True) as writer:
        for t in range(5):
            writer.add_frame(np.full((9, 9, 9), 1 + t, np.float32), t)
            raises(Error, Status.INVALID_ARGUMENT, writer.add_frame, np.zeros((9, 9, 9), np.float32), t,
                   text="does not rise")
        raises(Error, Status.WRONG_STATE, writer.finish, text="5 frames, not 12")
        assert writer.finish_short().frames == 5
    with Volume(device, path) as volume:
        assert np.allclose(volume.times(), [0, 1, 2, 3, 4])


def live(device, folder):
    """A series that is looked at while it is written."""
    path = os.path.join(folder, "live.bcc4")
    with Writer(device, path, (9, 9, 9, 40), overwrite=True, live=1) as writer:
        for t in range(30):
            writer.add_frame(np.full((9, 9, 9), 1 + t, np.float32), t)
        with Volume(device, path + ".partial") as volume:
            shown = volume.info().dims[3]
            assert volume.info().frames_expected == 40 and 10 < shown < 30
            before = volume.evaluate([[4, 4, 4, shown - 1.5]])
            assert volume.info().series_state == abi.SERIES_UNFINISHED
            writer.finish_short()
            with volume.reopen() as newer:  # the file has another name now
                assert newer.info().dims[3] == 30 and newer.info().series_state == abi.SERIES_FINISHED
                assert np.array_equal(newer.evaluate([[4, 4, 4, shown - 1.5]]), before)
    with Volume(device, path) as volume:
        assert volume.info().frames_expected == 0 and volume.info().dims[3] == 30
        assert np.array_equal(volume.evaluate([[4, 4, 4, shown - 1.5]]), before)


def goes_on(device, folder):
    """A finished file, and an unfinished one, are continued by what fits them; what does not is refused at once."""
    path = os.path.join(folder, "longer.bcc4")

    def made(frames, partial, **others):
        return Writer(device, path, (9, 9, 9, frames), partial=partial, **others)

    def add(writer, frames):
        for t in range(frames):
            writer.add_frame(np.full((9, 9, 9), 1 + t, np.float32), t)

    with made(12, abi.PARTIAL_DEFAULT) as writer:
        add(writer, 12)
    for others, text in (({"lattice": "CC"}, "lattice"), ({"channels": [Channel(air=3)]}, "air")):
        raises(Error, Status.WRONG_STATE, made, 15, abi.PARTIAL_APPEND, text=text, **others)
    with made(15, abi.PARTIAL_APPEND) as writer:
        add(writer, 15)
    with Volume(device, path) as volume:
        assert volume.info().dims[3] == 15
    os.remove(path)
    try:
        with made(40, abi.PARTIAL_KEEP) as writer:
            add(writer, 30)
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        pass
    raises(Error, Status.WRONG_STATE, made, 40, abi.PARTIAL_RESUME, text="distances", time_scale=2.0)
    with made(40, abi.PARTIAL_RESUME) as writer:
        add(writer, 40)
        assert writer.finish().slabs_reused > 0


def fields(device, folder):
    """A function of space and time, with a bound that is kept at every source sample."""
    path = os.path.join(folder, "field.bcc4")
    with Writer(device, path, (12, 11, 10, 5), overwrite=True, abs_error=1e-3) as writer:
        writer.add_field(lambda p: 1 + 0.1 * p[:, 0] + np.sin(0.5 * p[:, 1] + 0.3 * p[:, 3]))
        writer.finish()
        error = writer.error(0)
        assert 0 < error.max_abs <= 1e-3 and error.samples == 12 * 11 * 10 * 5
    with Volume(device, path) as volume:
        assert abs(volume.evaluate([[3, 4, 5, 2]])[0] - (1.3 + np.sin(2.6))) <= 1e-3

    for scale, expected in ((1.2, [1.2, 1.2, 1.2, 1]), ([.8, 1.1, 1.3], [.8, 1.1, 1.3, 1]),
                            ([.8, 1.1, 1.3, 1.7], [.8, 1.1, 1.3, 1.7])):
        with Writer(device, path, (31, 29, 27, 5), overwrite=True, scale=scale) as writer:
            writer.add_field(lambda p: 1 + 0.1 * p[:, 0])
        with Volume(device, path) as volume:
            assert np.allclose(volume.info().scales, expected, rtol=0.05), (scale, list(volume.info().scales))

    def giving_up(_points):
        raise KeyError("no field here")

    writer = Writer(device, path, (12, 11, 10, 5), overwrite=True)
    raises(KeyError, None, writer.add_field, giving_up)


def hooks(folder):
    """Python's threads do the work, the budget is kept, parents outlive their names."""
    own, hosted = (os.path.join(folder, name) for name in ("own.bcc4", "hosted.bcc4"))
    write(Device(threads=1), own, overwrite=True)

    def runner(count, body):
        threads = [threading.Thread(target=lambda k=k: [body(i) for i in range(k, count, 2)]) for k in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    write(Device(threads=2, runner=runner), hosted, overwrite=True)
    assert open(own, "rb").read() == open(hosted, "rb").read()
    small = Device(threads=1, memory_budget=60_000)
    volume = Volume(small, own)
    raises(Error, Status.MEMORY_BUDGET, volume.slice, frame=2, text="budget")
    assert small.info().memory_peak <= 60_000
    cut = Volume(Device(threads=1), bytes(open(own, "rb").read())).slice(frame=2)
    assert cut.sample_grid().max() > 0.9


def log(folder):
    """Damage is told to the log."""
    content = bytearray(open(os.path.join(folder, "s.bcc4"), "rb").read())
    content[len(content) // 2] ^= 1
    messages = []
    report = Volume(Device(threads=1, log=lambda level, text: messages.append((level, text))), content).verify()
    levels = [level for level, _ in messages]
    assert levels.count("warning") == report.damages + 1 > 1  # the last: what is left whole
    assert levels[0] == "info" and "caches of" in messages[0][1]


def unreadable(folder):
    """What a stream fails to read is no damage, and not lost but where that is asked for."""
    content = open(os.path.join(folder, "s.bcc4"), "rb").read()
    failing = False

    def read_at(offset, buffer):
        if failing and offset <= len(content) // 2 < offset + len(buffer):
            raise OSError
        buffer[:] = content[offset:offset + len(buffer)]
        return len(buffer)

    for salvage in 1, 2:
        with Volume(Device(threads=1), (len(content), read_at), salvage=salvage) as volume:
            failing = True
            report = raises(Error, Status.IO, volume.verify).report
            failing = False
            assert report.damages == 0 and report.unreadable == 1 and report.first_unreadable_offset > 0


def reader_of(content):
    def read_at(offset, buffer):
        buffer[:] = content[offset:offset + len(buffer)]
        return len(buffer)

    return read_at


def parts(device, scratch):
    """A series in two parts, joined, is the file of one writer byte for byte."""
    z, y, x = np.mgrid[0:11, 0:12, 0:13]
    times = [0.5 * t for t in range(30)]
    names = [os.path.join(scratch, name) for name in ("whole.bcc4", "b.bcc4", "a.bcc4", "joined.bcc4")]
    for name, part in zip(names, (None, (12, 30), (0, 12))):
        options = {"ends": "predict", "part": part, "part_times": times, "overwrite": True}
        with Writer(device, name, (13, 12, 11, 30), **options) as writer:
            begin, end = writer.part_frames()
            assert writer.part_box() == ((0, 0, 0), (13, 12, 11))
            assert (begin, end) == (0, 30) if part is None else begin <= part[0] < part[1] <= end
            for t in range(begin, end):
                writer.add_frame(blob(x, y, z, 0.2 * t), times[t])
    fractions = []
    report = join_parts(device, names[1:3], names[3], overwrite=True, progress=fractions.append)
    assert report.frames == 30 and report.slabs_reused > 0
    assert fractions == sorted(fractions) and all(0 <= fraction <= 1 for fraction in fractions)
    whole, joined = (open(name, "rb").read() for name in (names[0], names[3]))
    assert whole == joined
    raises(Error, Status.FILE_EXISTS, join_parts, device, names[1:3], names[3])
    stream, write_at = memory_file()
    sources = [(len(part), reader_of(part)) for part in (open(name, "rb").read() for name in names[1:3])]
    assert join_streams(device, sources, write_at).bytes_file == len(stream) and bytes(stream) == whole
    raises(Error, Status.INVALID_ARGUMENT, join_parts, device, names[1:2], names[3], overwrite=True, text="0 to 11")
    raises(ValueError, None, Writer, device, names[3], (13, 12, 11, 30), part=(0, 12), text="all 30 frames")


def planned(device, folder):
    """A writer by a plan keeps what was wished for; a plan without steps to refine says so in the end."""
    z, y, x = np.mgrid[0:18, 0:20, 0:22]
    frames = [blob(x, y, z, 0.2 * t).astype(np.float32) for t in range(9)]
    plan = bccsplat.Plan(device, (22, 20, 18, 9), lambda frame, channel: frames[frame], psnr=45)
    assert "45" in plan.text and plan.writer_options().psnr == 45, plan.text
    assert plan.found["channels"][0]["nonfinite"] == 0 and plan.found["wavelets"]["psnr"] == 45, plan.found
    with plan.writer(os.path.join(folder, "planned.bcc4")) as writer:
        for t, values in enumerate(frames):
            writer.add_frame(values, t)
    with Volume(device, os.path.join(folder, "planned.bcc4")) as volume:
        off = Slice.at(volume, 4).sample_grid() - frames[4]
        assert np.sqrt(np.mean(off ** 2)) < 2 * np.ptp(frames[4]) * 10 ** (-45 / 20)
    for _ in range(3):
        plan.refine()
    raises(Error, Status.NOT_FOUND, plan.refine)


def hosts_agree():
    file, from_c, from_python = (os.path.join(scratch, name) for name in ("blobs.bcc4", "c.png", "python.png"))
    subprocess.run([os.path.join(examples, "write_in_situ"), file], check=True)
    subprocess.run([os.path.join(examples, "render_frame"), file, from_c, "4.5"], check=True)
    main(file, from_python, "4.5")
    assert open(from_c, "rb").read() == open(from_python, "rb").read()
    script = os.path.join(top, "examples", "python", "explore.py")
    run = subprocess.run([sys.executable, "-B", script, file, scratch], check=True, capture_output=True, text=True)
    assert "49 x 49 x 49, 17 frames" in run.stdout and run.stdout.endswith("explore_oblique.png\n"), run.stdout
    names = (os.path.join(scratch, "explore_%s.png" % kind) for kind in ("time", "trail", "oblique"))
    pictures = {open(name, "rb").read() for name in names}
    assert len(pictures) == 3 and min(map(len, pictures)) > 10_000


shutil.rmtree(scratch, ignore_errors=True)  # of an earlier run
os.makedirs(scratch)
layout()
assert bccsplat.version() == (abi.VERSION_MAJOR, abi.VERSION_MINOR, abi.VERSION_PATCH)
assert "compiler" in bccsplat.build_info() and bccsplat.kernel_names()[0] == "default"
hosts_agree()
with Device(threads=2) as device:
    volume = files(device, scratch)
    volume_facts(volume)
    cut = slices(volume)
    pictures(device, volume, cut, scratch)
    scenes(device, volume, cut)
    cancelling(device, scratch)
    layers(device, scratch)
    refused_and_short(device, scratch)
    live(device, scratch)
    goes_on(device, scratch)
    fields(device, scratch)
    parts(device, scratch)
    planned(device, scratch)
hooks(scratch)
log(scratch)
unreadable(scratch)
symbols = set(open(os.path.join(top, "tests", "abi", "symbols.txt"), encoding="utf-8").read().split())
assert set(abi.FUNCTIONS) == symbols
never = symbols - called - {"bccsplat_abi_version"}  # that one at import
for kind in ("device", "volume", "slice", "renderer", "frame", "writer", "cancel_token", "scene", "plan"):
    never.discard("bccsplat_%s_retain" % kind)  # one method for all: Handle.share
assert not never, never
