"""A picture of a moment of a series, by Cycles on the CPU, with the add-on of this folder:

    blender -b --python-use-system-env --python render.py -- smoke.bcc4 26.5 smoke.png [EDGE [SAMPLES]]
"""
import os
import sys

import addon_utils
import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
addon_utils.enable("bcc4_volumes", default_set=True)

file, frame, picture, *rest = sys.argv[sys.argv.index("--") + 1:]
edge, samples = [*map(int, rest), *(256, 64)[len(rest):]]
scene = bpy.context.scene
for thing in [*bpy.data.objects]:
    bpy.data.objects.remove(thing)

bpy.ops.import_volume.bcc4(filepath=os.path.abspath(file), upright=True)
smoke = bpy.context.object
smoke.location = (-1, 1, 0)  # above the middle of the floor
frame = float(frame)
scene.frame_set(int(frame // 1), subframe=frame % 1)

bpy.ops.mesh.primitive_plane_add(size=40)
slate = bpy.data.materials.new("slate")
slate.use_nodes = True
slate.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (.05, .06, .09, 1)
slate.node_tree.nodes["Principled BSDF"].inputs["Specular"].default_value = 0
bpy.context.object.data.materials.append(slate)
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (.03, .04, .06, 1)
bpy.ops.object.light_add(type="SUN", rotation=(.7, .5, 0))
bpy.context.object.data.energy = 12
bpy.ops.object.camera_add(location=(0, -4.4, 1.5), rotation=(1.43, 0, 0))
scene.camera = bpy.context.object
scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", samples
scene.render.image_settings.color_mode = "RGB"
scene.cycles.use_denoising = False  # Debian has none
scene.render.resolution_x = scene.render.resolution_y = edge
scene.render.filepath = os.path.abspath(picture)
bpy.ops.render.render(write_still=True)
