"""blender_scene.py PART FOLDER: what blender_volumes_test.py runs in Blender, over the files that it has put into FOLDER."""
import glob
import os
import sys

import bpy
import numpy as np

PART, FOLDER = sys.argv[sys.argv.index("--") + 1:]
NEAR = 45  # dB that a picture is from that of the exported file


def path(name):
    return os.path.join(FOLDER, name)


def install():
    bpy.ops.preferences.addon_install(filepath=path("bcc4_volumes.zip"))
    bpy.ops.preferences.addon_enable(module="bcc4_volumes")


def set_scene(edge=128, samples=8):
    """A camera and a sun, and nothing that they see."""
    scene = bpy.context.scene
    for thing in [*bpy.data.objects]:
        bpy.data.objects.remove(thing)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (1, -4.2, 1), (1.5708, 0, 0)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 25, (.6, .4, 0)
    for thing in (camera, sun):
        scene.collection.objects.link(thing)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    scene.camera, scene.render.engine = camera, "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", samples, False
    scene.cycles.use_adaptive_sampling, scene.cycles.seed = False, 1
    scene.render.resolution_x = scene.render.resolution_y = edge
    scene.render.image_settings.color_depth = "16"
    scene.view_settings.view_transform = "Standard"
    return scene


def imported(name, **options):
    bpy.ops.import_volume.bcc4(filepath=path(name), upright=True, **options)
    return bpy.context.object


def loaded(file):
    """Pixels of a picture, as they are shown."""
    image = bpy.data.images.load(file)
    image.colorspace_settings.name = "Raw"
    pixels = np.array(image.pixels[:])
    bpy.data.images.remove(image)
    return pixels


def picture(frame):
    """Of a scene at a frame, which may be fractional."""
    scene = bpy.context.scene
    scene.frame_set(int(frame // 1), subframe=frame % 1)
    scene.render.filepath = path("picture.png")
    bpy.ops.render.render(write_still=True)
    return loaded(path("picture.png"))


def exported_picture(like, frame):
    """That of a file which the tool exported, where the object `like` is, of the same material."""
    volume = bpy.data.volumes.new("exported")
    volume.filepath = path("export-%s.vdb" % frame)
    volume.materials.append(like.data.materials[0])
    thing = like.copy()
    thing.data = volume
    bpy.context.collection.objects.link(thing)
    like.hide_render = True
    found = picture(frame)
    like.hide_render = False
    bpy.data.objects.remove(thing)
    return found


def decibels(a, b):
    return float(-10 * np.log10(max(np.mean((a - b) ** 2), 1e-12)))


def hold(condition, what):
    print("%s: %s: %s" % (PART, "holds" if condition else "DOES NOT HOLD", what))
    if not condition:
        sys.exit(1)


def hold_moment(thing, found):
    """That a picture of frame 12.37 is that of its own moment, and not of those beside it."""
    there = decibels(found, exported_picture(thing, 12.37))
    beside = [decibels(found, exported_picture(thing, frame)) for frame in (12, 13)]
    hold(np.ptp(found.reshape(-1, 4)[:, :3]) > .3, "there is something to see")
    hold(there > NEAR, "frame 12.37 is %.1f dB from the exported moment" % there)
    hold(max(beside) < NEAR, "it is %.1f and %.1f dB from those of frames 12 and 13" % tuple(beside))


def grids(volume):
    """Names of its grids."""
    volume.grids.load()
    return sorted(grid.name for grid in volume.grids)


def refused(call, words):
    """That an operator refuses something, and reports these words."""
    try:
        call()
    except RuntimeError as error:
        hold(all(word in str(error) for word in words), "refused: %s" % str(error).strip())
    else:
        hold(False, "nothing is refused that should be, for %s" % words)


def hold_timing(thing):
    """Which moment is shown at which frame of the scene."""
    scene, settings = bpy.context.scene, thing.data.bcc4
    from bcc4_volumes import moments, stored_frame
    series = moments.series_of(os.path.realpath(path("smoke.bcc4")), "", "")[1]
    uneven = moments.series_of(os.path.realpath(path("uneven.bcc4")), "", "")[1]

    def at(now, of=series, **given):
        for name in ("timing", "start", "first", "speed", "outside", "frame"):
            settings[name] = 0  # without an update
        settings.timing, settings.outside, settings.speed = "FRAMES", "HOLD", 1
        for name, value in given.items():
            setattr(settings, name, value)
        scene.frame_set(int(now // 1), subframe=now % 1)
        found = stored_frame(settings, of, scene)
        return found if found is None else round(found, 4)

    scene.render.fps = 24
    hold([at(12.37), at(12.5, start=10), at(10, first=3.5)] == [12.37, 2.5, 13.5], "frames are stored frames from a start on")
    hold([at(49, speed=.25), at(4, speed=-1, first=19)] == [12.25, 15], "slow motion and backwards")
    hold([at(-3), at(25), at(-3, outside="HIDE"), at(25, outside="HIDE"), at(19, outside="HIDE")] == [0, 19, None, None, 19],
         "what is outside is held or hidden")
    hold([at(20, outside="REPEAT"), at(-1, outside="REPEAT")] == [1, 18], "or begins anew")
    hold([at(36, timing="TIME"), at(36, timing="TIME", speed=2, first=1), at(0, timing="TIME", first=4)] == [3, 7, 4],
         "seconds of the scene are units of the file's time")
    hold([at(24 * 9, uneven, timing="TIME"), at(24 * 7, uneven, timing="TIME", first=3)] == [3, 4], "at uneven times as well")
    hold(at(5, timing="KEYED", frame=7.25) == 7.25, "or the stored frame is given")
    at(0)


def hold_slow_motion(thing):
    """That slow motion repeats no picture, by a render of an animation."""
    scene = bpy.context.scene
    thing.data.bcc4.speed = .25
    scene.frame_start, scene.frame_end, scene.render.filepath = 40, 47, path("slow-####")
    scene.cycles.samples, scene.render.resolution_percentage = 4, 50
    bpy.ops.render.render(animation=True)
    found = [loaded(file) for file in sorted(glob.glob(path("slow-*.png")))]
    between = [decibels(a, b) for a, b in zip(found, found[1:])]
    hold(len(found) == 8 and max(between) < 60, "slow motion of four times repeats no picture: %.0f dB at most" % max(between))
    thing.data.bcc4.speed, scene.cycles.samples, scene.render.resolution_percentage = 1, 8, 100


def hold_keyed(thing, found):
    """That a keyed stored frame is that of the frame that is rendered, not of the screen's."""
    scene, settings = bpy.context.scene, thing.data.bcc4
    settings.timing = "KEYED"
    for frame, value in ((0, 0), (100, 18.5)):
        settings.frame = value
        settings.keyframe_insert("frame", frame=frame)
    for curve in thing.data.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    scene.frame_set(0)
    frame = 12.37 / 18.5 * 100
    there = decibels(found, picture(frame))
    hold(there > NEAR, "keyed, moment 12.37 at frame %.2f is the same picture: %.1f dB" % (frame, there))
    scene.frame_start = scene.frame_end = 67  # stored frame 12.395
    scene.frame_set(0)
    scene.render.filepath = path("keyed-####")
    bpy.ops.render.render(animation=True)
    near = decibels(found, loaded(path("keyed-0067.png")))
    hold(near > 40, "and is followed in an animation: %.1f dB" % near)
    thing.data.animation_data_clear()
    settings.timing = "FRAMES"


def hold_labels():
    """That labels are those of the nearest frame."""
    scene, found = bpy.context.scene, {}
    labels = imported("labels.bcc4")
    for frame in (.8, 1.2, 1.7):
        scene.frame_set(int(frame), subframe=frame % 1)
        with open(labels.data.filepath, "rb") as file:
            found[frame] = file.read()[57:]  # behind what tells files apart
    hold(found[.8] == found[1.2] != found[1.7], "labels are those of the nearest frame")
    bpy.data.objects.remove(labels)


def hold_files(thing):
    """Levels, channels and the room that moments take."""
    scene, settings, volume = bpy.context.scene, thing.data.bcc4, thing.data
    scene.frame_set(12)
    sizes = []
    for level in (0, 1):
        settings.level = level
        sizes.append(os.path.getsize(volume.filepath))
    hold(sizes[1] * 2 < sizes[0], "a coarser level is smaller: %d, %d bytes" % tuple(sizes))
    settings.level = 9
    hold(not volume.filepath and "no level 9" in settings.error, "a level that is not there shows nothing: " + settings.error)
    settings.level = 0
    hold(grids(volume) == ["density", "heat"] and not settings.error, "there is a grid for each channel")
    settings.channels = "heat"
    hold(grids(volume) == ["heat"], "or for those that are named")
    settings.channels = "density"
    whole = os.path.getsize(volume.filepath)
    settings.threshold = .5
    part = os.path.getsize(volume.filepath)
    settings.threshold = 1e6
    hold(os.path.getsize(volume.filepath) < 1000 < part < whole,
         "what is near to air is left out: %d bytes of %d" % (part, whole))
    settings.threshold, settings.channels = -1, ""
    folder = os.path.dirname(volume.filepath)
    with open(os.path.join(folder, "other.vdb"), "w", encoding="utf-8") as file:
        file.write("somebody else's")
    bpy.context.preferences.addons["bcc4_volumes"].preferences.megabytes = 1
    for frame in range(10):
        scene.frame_set(frame)
    left = sum(os.path.getsize(file) for file in glob.glob(os.path.join(folder, "*.bcc4.vdb")))
    hold(os.path.exists(volume.filepath) and 1 << 19 < left - os.path.getsize(volume.filepath) <= 1 << 20,
         "moments take no more room than they may: %d bytes" % left)
    hold(os.path.exists(os.path.join(folder, "other.vdb")), "other files stay")
    bpy.context.preferences.addons["bcc4_volumes"].preferences.megabytes = 2048


def package():
    install()
    scene = set_scene()
    refused(lambda: imported("none.bcc4"), ["none.bcc4"])
    refused(lambda: imported("absent.bcc4"), ["absent.bcc4"])
    refused(lambda: imported("smoke.bcc4", channels="fire"), ["no channel fire", "density, heat"])
    hold(not bpy.data.volumes, "what is refused leaves no volume")
    thing = imported("smoke.bcc4")
    thing.location = (0, 0, 0)
    found = picture(12.37)
    hold_moment(thing, found)
    scene.render.use_motion_blur = True
    blurred = decibels(found, picture(12.37))
    hold(blurred > NEAR, "shutters that open leave the moment: %.1f dB" % blurred)
    scene.render.use_motion_blur = False
    hold_keyed(thing, found)
    hold_timing(thing)
    hold_slow_motion(thing)
    hold_files(thing)
    hold_labels()
    scene.frame_set(12, subframe=.37)
    bpy.ops.wm.save_as_mainfile(filepath=path("smoke.blend"))
    np.save(path("found.npy"), found)
    os.rename(path("smoke.bcc4"), path("moved.bcc4"))
    scene.frame_set(3)
    hold(not thing.data.filepath and "smoke.bcc4" in thing.data.bcc4.error, "a file that went: " + thing.data.bcc4.error)
    os.rename(path("moved.bcc4"), path("smoke.bcc4"))
    scene.frame_set(4)
    hold(thing.data.filepath and not thing.data.bcc4.error, "and came back")


def reopened():
    install()
    bpy.ops.wm.open_mainfile(filepath=path("smoke.blend"))
    volume = bpy.data.volumes["smoke"]
    hold(os.path.exists(volume.filepath), "a scene that is opened again has its moment")
    there = decibels(np.load(path("found.npy")), picture(12.37))
    hold(there > NEAR, "and the same picture: %.1f dB" % there)


def tool():
    install()
    set_scene()
    refused(lambda: imported("none.bcc4"), ["none.bcc4"])
    refused(lambda: imported("smoke.bcc4"), ["name one of density, heat"])
    thing = imported("smoke.bcc4", channels="density")
    found = picture(12.37)
    hold_moment(thing, found)
    there = decibels(found, np.load(path("found.npy")))
    hold(there > NEAR, "the package has the same picture: %.1f dB" % there)


def neither():
    install()
    refused(lambda: imported("smoke.bcc4"), ["/nowhere/bcc4 does not run"])


{"package": package, "reopened": reopened, "tool": tool, "neither": neither}[PART]()
print("DONE", PART)
