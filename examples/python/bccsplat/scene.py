"""Scene: volumes in a host's world."""
from __future__ import annotations

import ctypes
from ctypes import byref, c_uint64
from typing import Any, Sequence

import numpy as np

from . import _abi
from ._library import call, choose
from .arrays import Array, affine_of
from .device import Child, Device
from .render import Frame, RenderOptions, TransferFunction, View, clip_array, lights_struct, trail_struct
from .volume import Volume


class Scene(Child):
    """Volumes with a place and a time, drawn together.

        scene = Scene(device)
        left = scene.add(volume)
        right = scene.add(volume, placement=moved, time_offset=2)
        scene.set_time(5)
        scene.render(frame)
    """

    _kind = "scene"

    def __init__(self, device: Device) -> None:
        super().__init__(device)
        self._volumes: dict[int, Volume] = {}
        self._create("scene_create", device.pointer)

    @staticmethod
    def _instance(volume: Volume | None, placement: Any, outside: int | str | None, hidden: bool,
                  transfer_function: TransferFunction | None, color_channel: int | str | None,
                  color_function: TransferFunction | None, mask_channel: int | str | None,
                  mask_labels: Sequence[float], trail: dict[str, Any] | None, channel: int | str, time_scale: float,
                  time_offset: float, density: float) -> _abi.Instance:
        def channel_number(channel: int | str) -> Any:
            return channel if volume is None else volume.channel_number(channel)

        instance = _abi.Instance(outside=choose("OUTSIDE", outside), hidden=int(hidden), channel=channel_number(channel),
                                 time_scale=time_scale, time_offset=time_offset, density=density)
        if placement is not None:
            instance.placement[:] = affine_of(placement).reshape(16).tolist()
        if transfer_function is not None:
            instance.transfer_function = transfer_function.struct()
        if color_channel is not None:
            instance.set_mask |= _abi.INSTANCE_SET_COLOR_CHANNEL
            instance.color_channel = channel_number(color_channel)
            if color_function is not None:
                instance.color_function = color_function.struct()
        if mask_channel is not None:
            instance.set_mask |= _abi.INSTANCE_SET_MASK_CHANNEL
            instance.mask_channel, instance.mask_labels = channel_number(mask_channel), mask_labels
        if trail is not None:
            instance.trail = trail_struct(**trail)
        return instance

    def add(self, volume: Volume, *, placement: Any = None, outside: int | str | None = None, hidden: bool = False,
            transfer_function: TransferFunction | None = None, color_channel: int | str | None = None,
            color_function: TransferFunction | None = None, mask_channel: int | str | None = None,
            mask_labels: Sequence[float] = (), trail: dict[str, Any] | None = None, channel: int | str = 0,
            time_scale: float = 0.0, time_offset: float = 0.0, density: float = 0.0) -> int:
        """Returns the instance's number. placement: 4x4. outside: "hide", "hold" or "loop". color_channel: another channel,
        whose values say the colours, by color_function. mask_channel: one of labels, of which only mask_labels are drawn.
        Channels go by number or name.
        trail: what moved, as arguments of Renderer.set_trail: {"interval": (-2, 0)}.
        channel, time_scale, time_offset, density: as of bccsplat_instance."""
        instance = self._instance(volume, placement, outside, hidden, transfer_function, color_channel, color_function,
                                  mask_channel, mask_labels, trail, channel, time_scale, time_offset, density)
        number = ctypes.c_uint64()
        call("scene_add", self.pointer, volume.pointer, byref(instance), byref(number))
        self._volumes[number.value] = volume.share()  # and with it what the volume borrows from Python
        return number.value

    def set_instance(self, number: int, *, placement: Any = None, outside: int | str | None = None, hidden: bool = False,
                     transfer_function: TransferFunction | None = None, color_channel: int | str | None = None,
                     color_function: TransferFunction | None = None, mask_channel: int | str | None = None,
                     mask_labels: Sequence[float] = (), trail: dict[str, Any] | None = None, channel: int | str = 0,
                     time_scale: float = 0.0, time_offset: float = 0.0, density: float = 0.0) -> None:
        """All of it anew: what is not given is the default."""
        instance = self._instance(self._volumes.get(number), placement, outside, hidden, transfer_function, color_channel,
                                  color_function, mask_channel, mask_labels, trail, channel, time_scale, time_offset, density)
        call("scene_set_instance", self.pointer, number, byref(instance))

    def remove(self, number: int) -> None:
        """Takes the instance of that number out."""
        call("scene_remove", self.pointer, number)
        del self._volumes[number]

    def set_time(self, time: float) -> None:
        """The time of the scene, in the unit of its volumes."""
        call("scene_set_time", self.pointer, time)

    def set_clips(self, clips: Sequence[Any]) -> None:
        """Half-spaces that are kept: (a, b, c, d) of the world, or abi.Clip structs, which may name a space and an
        instance."""
        call("scene_set_clips", self.pointer, clip_array(clips), len(clips))

    def set_lights(self, lights: Sequence[tuple[Sequence[float], Sequence[float]]] = (), *, ambient: float = 0.0,
                   diffuse: float = 0.0, specular: float = 0.0, shininess: float = 0.0, shadow: bool = False,
                   occlusion: bool = False) -> None:
        """As those of a Renderer."""
        call("scene_set_lights", self.pointer,
             byref(lights_struct(lights, ambient, diffuse, specular, shininess, shadow, occlusion)))

    def bounds(self) -> tuple[float, ...]:
        """x0 y0 z0 x1 y1 z1 around all instances that are not hidden."""
        bounds = (ctypes.c_double * 6)()
        call("scene_get_bounds", self.pointer, bounds)
        return tuple(bounds)

    def fit_camera(self, width: int, height: int, rotate_x: float = 20, rotate_y: float = 30,
                   projection: int | str | None = None) -> _abi.Camera:
        """A view of all that is not hidden, turned by angles in degrees, for width x height pixels."""
        camera = _abi.Camera()
        call("scene_fit_camera", self.pointer, choose("PROJECTION", projection), rotate_x, rotate_y, width, height,
             byref(camera))
        return camera

    def render(self, frame: Frame, view: View | None = None, options: RenderOptions | None = None,
               budget_ms: float = 0) -> _abi.SceneStatus:
        """Draws the scene at its time. budget_ms: 0 until the picture is complete, else see status.complete: what is begun
        is kept for one view, so that several, each with a budget, need a scene each; volumes may be in all of them."""
        if view is not None:
            view.check(*frame.size)
        status, o = _abi.SceneStatus(), options or RenderOptions()
        call("scene_render", self.pointer, None if view is None else byref(view.struct), frame.pointer, byref(o.struct),
             budget_ms, byref(status), watch=o.watch)
        return status

    def ranges(self, instance: int, time: float, width: int, height: int, view: View | None = None,
               options: RenderOptions | None = None, *, missing: bool = False) -> Array:
        """Bytes [n, 2] (offset, size) of the file of an instance's volume that a picture at that time reads. missing:
        without what the volume's caches hold."""
        o = options or RenderOptions()
        arguments = (self.pointer, None if view is None else byref(view.struct), width, height, byref(o.struct), time,
                     instance, _abi.RANGES_MISSING if missing else 0)
        count = c_uint64()
        call("scene_get_ranges", *arguments, None, 0, byref(count), watch=o.watch)
        found = np.empty((count.value, 2), np.uint64)
        call("scene_get_ranges", *arguments, found.ctypes.data, len(found), byref(count), watch=o.watch)
        return found[:count.value]

    def prefetch(self, time: float, width: int, height: int, view: View | None = None,
                 options: RenderOptions | None = None) -> None:
        """Reads what a picture at that time will need."""
        o = options or RenderOptions()
        call("scene_prefetch", self.pointer, None if view is None else byref(view.struct), width, height,
             byref(o.struct), time, watch=o.watch)
