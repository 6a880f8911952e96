"""Blender: a .bcc4 as a volume whose moment follows the scene's frame, between stored frames as well.

Edit > Preferences > Add-ons > Install takes a zip file of this folder; then File > Import > bccsplat series (.bcc4). The
volume's properties say which moment is shown at which frame. Each moment is an OpenVDB file in a folder of the session, which
Blender, Cycles and EEVEE read as any other.
"""
import os
import sys

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import moments
from .series import Failure

bl_info = {"name": "bccsplat series", "author": "bccsplat", "version": (1, 0, 0), "blender": (3, 0, 0),
           "location": "File > Import", "description": "Volumes of .bcc4 files at any moment", "category": "Import-Export"}

def _changed(_settings, context):
    refresh(context.scene)


class Bcc4Preferences(bpy.types.AddonPreferences):
    """Where the library is, and how much room the moments take."""

    bl_idname = __name__
    package: StringProperty(name="Python package", subtype="DIR_PATH",
                            description="Folder that holds the package bccsplat; empty: Python's own")
    tool: StringProperty(name="Tool", subtype="FILE_PATH",
                         description="The program bcc4, for where the package does not load; empty: that in the search path")
    folder: StringProperty(name="Folder of moments", subtype="DIR_PATH",
                           description="Empty: a folder of the session, which goes with it")
    megabytes: IntProperty(name="Megabytes of moments", default=2048, min=1,
                           description="Moments that were looked at longest ago go beyond that")

    def draw(self, _context):
        for name in ("package", "tool", "folder", "megabytes"):
            self.layout.prop(self, name)


class Bcc4Settings(bpy.types.PropertyGroup):
    """Of a volume: its series, and which moment of it is shown. All numbers can be keyed."""

    path: StringProperty(name="Series", subtype="FILE_PATH", update=_changed, description="A .bcc4 file")
    timing: EnumProperty(name="Timing", update=_changed, items=[
        ("FRAMES", "Frames", "So many stored frames in a frame of the scene"),
        ("TIME", "Time", "So many units of the file's time in a second of the scene"),
        ("KEYED", "Keyed", "The stored frame is keyed")])
    start: FloatProperty(name="Start", update=_changed, description="Frame of the scene that shows the first moment")
    first: FloatProperty(name="First", update=_changed, description="Stored frame that is shown at the start")
    speed: FloatProperty(name="Speed", default=1, update=_changed,
                         description="1/4: slow motion of four times; below 0: backwards")
    frame: FloatProperty(name="Stored frame", update=_changed, description="Fractions are moments between frames")
    outside: EnumProperty(name="Outside", update=_changed, items=[
        ("HOLD", "Hold", "Before the first and behind the last moment these are shown"),
        ("HIDE", "Hide", "Nothing is shown there"),
        ("REPEAT", "Repeat", "The series begins anew; one that goes round does that by itself")])
    channels: StringProperty(name="Channels", update=_changed,
                             description="Names, separated by commas, of the grids to make; empty: all channels")
    level: IntProperty(name="Level", min=0, max=16, update=_changed,
                       description="1: every second sample along each axis, 2: every fourth, ...")
    threshold: FloatProperty(name="Threshold", default=-1, precision=4, update=_changed,
                             description="Values no further from the air's are left out; below 0: as the file says")
    error: StringProperty(name="Error")


def stored_frame(settings, series, scene):
    """The frame number of the series that a scene looks at; None: nothing is shown."""
    if settings.timing == "KEYED":
        return series.shown(settings.frame, settings.outside)
    since = (scene.frame_current_final - settings.start) * settings.speed
    if settings.timing == "FRAMES":
        return series.shown(settings.first + since, settings.outside)
    time = series.time_at(settings.first) + since * scene.render.fps_base / scene.render.fps
    return series.shown(series.frame_at(time), settings.outside)


def _preferences():
    return bpy.context.preferences.addons[__name__].preferences


def series_of(volume, settings):
    """The series of a volume, and what tells it from one that the file had before."""
    path = os.path.realpath(bpy.path.abspath(settings.path, library=volume.library))
    return moments.series_of(path, bpy.path.abspath(_preferences().package), bpy.path.abspath(_preferences().tool))


def moment_file(volume, settings, scene):
    """The path of the OpenVDB file that a volume shows in a scene; "": nothing."""
    key, series = series_of(volume, settings)
    frame = stored_frame(settings, series, scene)
    if frame is None:
        return ""
    folder = bpy.path.abspath(_preferences().folder) or os.path.join(bpy.app.tempdir, "bcc4")
    shown = {bpy.path.abspath(other.filepath) for other in bpy.data.volumes if other != volume}
    return moments.file_of(folder, key, series, frame, settings, shown, _preferences().megabytes << 20)


@persistent
def refresh(scene, depsgraph=None):
    """Has every volume of a series show its moment; where that fails it shows nothing and says why. Keyed numbers are those of
    the evaluated volume: a render has others than what is on the screen."""
    for volume in bpy.data.volumes:
        if not volume.bcc4.path:
            continue
        settings = volume.evaluated_get(depsgraph).bcc4 if depsgraph else volume.bcc4
        error = ""
        try:
            file = moment_file(volume, settings, scene)
        except (Failure, OSError) as failed:
            file, error = "", str(failed)
            print("bcc4: %s: %s" % (volume.name, error), file=sys.stderr)
        if volume.filepath != file:
            volume.filepath = file
        if volume.bcc4.error != error:
            volume.bcc4.error = error


@persistent
def refresh_loaded(_path):
    """A file that was opened names moments of the session that wrote it."""
    refresh(bpy.context.scene)


def make_material(channels, size, name):
    """Smoke of the channel "density", or of the first, dense enough to be seen in a box of that size; colour and temperature by
    the channels of these names."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeVolumePrincipled")
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs["Volume"], output.inputs["Volume"])
    density = next((channel for channel in channels if channel.name == "density"), channels[0])
    shader.inputs["Density Attribute"].default_value = density.name
    shader.inputs["Density"].default_value = 20 / (max(density.high - density.air, 1e-30) * max(size, 1e-30))
    shader.inputs["Color"].default_value = (.9, .9, .9, 1)
    for channel in channels:
        if channel.name in ("color", "temperature"):
            shader.inputs[channel.name.title() + " Attribute"].default_value = channel.name
    return material


class Bcc4Import(bpy.types.Operator, ImportHelper):
    """Adds a volume whose moment follows the frame of the scene"""

    bl_idname = "import_volume.bcc4"
    bl_label = "Import bccsplat series"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".bcc4"
    filter_glob: StringProperty(default="*.bcc4", options={"HIDDEN"})
    size: FloatProperty(name="Size", default=2, min=0, description="Of the longest edge; 0: as the file has it")
    upright: BoolProperty(name="y is up", description="The file's y becomes Blender's z")
    channels: StringProperty(name="Channels", description="Names, separated by commas; empty: all")

    def execute(self, context):
        volume = bpy.data.volumes.new(os.path.splitext(os.path.basename(self.filepath))[0])
        # The channels first: with the path its moment is written.
        volume.bcc4.channels, volume.bcc4.path = self.channels, self.filepath
        if volume.bcc4.error:
            self.report({"ERROR"}, volume.bcc4.error)
            bpy.data.volumes.remove(volume)
            return {"CANCELLED"}
        _, series = series_of(volume, volume.bcc4)
        edges = [sum(v * v for v in series.affine[:3, axis]) ** .5 * (n - 1) for axis, n in enumerate(series.dims)]
        longest = max(edges) or 1.0
        scale = self.size / longest if self.size else 1.0
        thing = bpy.data.objects.new(volume.name, volume)
        thing.scale = [scale] * 3
        if self.upright:
            thing.rotation_euler[0] = 1.5707963267948966
        volume.materials.append(make_material(series.chosen(self.channels), longest, volume.name))
        context.collection.objects.link(thing)
        for other in context.selected_objects:
            other.select_set(False)
        thing.select_set(True)
        context.view_layer.objects.active = thing
        return {"FINISHED"}


class Bcc4Panel(bpy.types.Panel):
    """The series of a volume"""

    bl_label = "bccsplat series"
    bl_idname = "DATA_PT_bcc4"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "data"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "VOLUME"

    def draw(self, context):
        layout, settings = self.layout, context.object.data.bcc4
        layout.use_property_split = True
        shown = ["frame"] if settings.timing == "KEYED" else ["start", "first", "speed"]
        for name in ("path", "timing", *shown, "outside", "channels", "level", "threshold"):
            layout.prop(settings, name)
        if settings.error:
            layout.label(text=settings.error, icon="ERROR")


CLASSES = (Bcc4Preferences, Bcc4Settings, Bcc4Import, Bcc4Panel)


def _menu(self, _context):
    self.layout.operator(Bcc4Import.bl_idname, text="bccsplat series (.bcc4)")


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Volume.bcc4 = PointerProperty(type=Bcc4Settings)
    bpy.types.TOPBAR_MT_file_import.append(_menu)
    bpy.app.handlers.frame_change_post.append(refresh)
    bpy.app.handlers.load_post.append(refresh_loaded)


def unregister():
    bpy.app.handlers.load_post.remove(refresh_loaded)
    bpy.app.handlers.frame_change_post.remove(refresh)
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    del bpy.types.Volume.bcc4
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
    moments.forget()
