"""Render a job of time_to_error.py with Blender's Cycles on CPU, two threads; runs inside Blender (written for 3.4).

    blender -b -P cycles_scene.py -- JOB.json OUT.exr SPP SEED

No denoising, no clamping, fixed samples, caustics on, box filter. A first picture of one sample warms it up; printed is the user CPU
of the second, with the scene's data kept. Glossy surfaces are the Principled BSDF, glass the Glass BSDF.
"""

import json
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bpy
import numpy as np
from mathutils import Matrix, Vector

import jobs

job_file, out, spp, seed = sys.argv[sys.argv.index("--") + 1 :][:4]
job = json.load(open(job_file))
scene = jobs.scene_of(job)
sc = bpy.context.scene
for o in list(bpy.data.objects):
    bpy.data.objects.remove(o)


def rgba(c):
    return tuple(float(x) for x in c[:3]) + (1.0,)


def picture(tree, file, data):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(file)
    if data:
        node.image.colorspace_settings.name = "Non-Color"
    return node


def material(m):
    made = bpy.data.materials.new(m.name or "m")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    link = tree.links.new
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if m.kind == "glass":
        node = tree.nodes.new("ShaderNodeBsdfGlass")
        node.inputs["Roughness"].default_value = 0.0
        node.inputs["IOR"].default_value = m.ior
    elif m.kind == "matte":
        node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    else:
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.inputs["Metallic"].default_value = m.metallic
        node.inputs["Roughness"].default_value = m.roughness
    color = node.inputs["Base Color" if "Base Color" in node.inputs else "Color"]
    color.default_value = rgba(m.color)
    if m.checker is not None:
        # A checker of the plane: cells of space half a cell off it
        place = tree.nodes.new("ShaderNodeNewGeometry")
        moved = tree.nodes.new("ShaderNodeVectorMath")
        missing = next(axis for axis in "xyz" if axis not in m.checker["axes"])
        moved.inputs[1].default_value = [0.5 * m.checker["side"] * (axis == missing) for axis in "xyz"]
        cells = tree.nodes.new("ShaderNodeTexChecker")
        cells.inputs["Scale"].default_value = 1 / m.checker["side"]
        cells.inputs["Color1"].default_value, cells.inputs["Color2"].default_value = [rgba(c) for c in reversed(m.checker["colors"])]
        link(moved.inputs[0], place.outputs["Position"])
        link(cells.inputs["Vector"], moved.outputs[0])
        link(color, cells.outputs["Color"])
    if m.color_map:
        link(color, picture(tree, m.color_map, False).outputs["Color"])
    if m.surface_map and m.kind == "glossy":
        split = tree.nodes.new("ShaderNodeSeparateRGB")
        link(split.inputs[0], picture(tree, m.surface_map, True).outputs["Color"])
        link(node.inputs["Roughness"], split.outputs["G"])
        link(node.inputs["Metallic"], split.outputs["B"])
    if m.normal_map:
        bend = tree.nodes.new("ShaderNodeNormalMap")
        link(bend.inputs["Color"], picture(tree, m.normal_map, True).outputs["Color"])
        link(node.inputs["Normal"], bend.outputs["Normal"])
    shader = node.outputs[0]
    if any(m.emission):
        glow, add = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
        strength = max(m.emission)
        glow.inputs["Color"].default_value = rgba([e / strength for e in m.emission])
        glow.inputs["Strength"].default_value = strength
        link(add.inputs[0], shader)
        link(add.inputs[1], glow.outputs[0])
        shader = add.outputs[0]
    if m.alpha == "BLEND" and m.color_map:
        mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
        link(mix.inputs[0], picture(tree, m.color_map, False).outputs["Alpha"])
        link(mix.inputs[1], clear.outputs[0])
        link(mix.inputs[2], shader)
        shader = mix.outputs[0]
    link(output.inputs["Surface"], shader)
    return made


# Meshes, with smooth normals where there are any
made = {}
for k, part in enumerate(scene.parts):
    mesh = bpy.data.meshes.new(f"part{k}")
    F = np.ascontiguousarray(part.F, np.int32)
    mesh.vertices.add(len(part.V))
    mesh.vertices.foreach_set("co", np.asarray(part.V, np.float32).ravel())
    mesh.loops.add(F.size)
    mesh.loops.foreach_set("vertex_index", F.ravel())
    mesh.polygons.add(len(F))
    mesh.polygons.foreach_set("loop_start", np.arange(0, F.size, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(F), 3, np.int32))
    if part.UV is not None:
        uv = np.array(part.UV[F.ravel()], np.float32)
        uv[:, 1] = 1 - uv[:, 1]
        mesh.uv_layers.new().data.foreach_set("uv", uv.ravel())
    mesh.update(calc_edges=True)
    if part.N is not None:
        mesh.polygons.foreach_set("use_smooth", np.ones(len(F), bool))
        mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(np.asarray(part.N, np.float32).tolist())
    if id(part.material) not in made:
        made[id(part.material)] = material(part.material)
    mesh.materials.append(made[id(part.material)])
    sc.collection.objects.link(bpy.data.objects.new(f"part{k}", mesh))

# The camera looks along its -z
view = scene.view
eye, target = Vector(view["position"]), Vector(view["look_at"])
back = (eye - target).normalized()
right = Vector((0, 1, 0)).cross(back).normalized()
up = back.cross(right)
cam = bpy.data.cameras.new("camera")
cam_object = bpy.data.objects.new("camera", cam)
sc.collection.objects.link(cam_object)
sc.camera = cam_object
cam_object.matrix_world = Matrix([[right[i], up[i], back[i], eye[i]] for i in range(3)] + [[0, 0, 0, 1]])
cam.sensor_width, cam.sensor_fit = 36, "HORIZONTAL"
cam.lens = 18 / np.tan(np.radians(view["fov_deg"]) / 2)
cam.clip_start, cam.clip_end = 1e-3, 1e5
if view.get("radius"):
    cam.dof.use_dof = True
    cam.dof.focus_distance = view["focus"]
    cam.dof.aperture_fstop = cam.lens * 1e-3 / (2 * view["radius"])

for toward, strength in scene.suns:
    light = bpy.data.lights.new("sun", "SUN")
    brightest = max(strength)
    light.energy, light.angle, light.color = np.pi * brightest, 0.0, [s / brightest for s in strength]
    holder = bpy.data.objects.new("sun", light)
    sc.collection.objects.link(holder)
    holder.rotation_mode = "QUATERNION"
    holder.rotation_quaternion = Vector(toward).to_track_quat("Z", "Y")
world = sc.world or bpy.data.worlds.new("world")
sc.world = world
world.use_nodes = True
background = world.node_tree.nodes["Background"]
background.inputs[0].default_value, background.inputs[1].default_value = rgba(scene.sky), 1.0

sc.render.engine = "CYCLES"
cy = sc.cycles
cy.device, cy.seed, cy.use_denoising, cy.use_adaptive_sampling = "CPU", int(seed), False, False
bounces = max(scene.bounces - 1, 0)
cy.max_bounces = cy.diffuse_bounces = cy.glossy_bounces = cy.transmission_bounces = bounces
cy.transparent_max_bounces = 64
cy.min_light_bounces = cy.min_transparent_bounces = 64
cy.pixel_filter_type, cy.filter_width, cy.blur_glossy = "BOX", 1.0, 0.0
cy.sample_clamp_direct = cy.sample_clamp_indirect = 0
cy.caustics_reflective = cy.caustics_refractive = True
cy.light_sampling_threshold = 0
r = sc.render
r.resolution_x, r.resolution_y = view["size"]
r.resolution_percentage = 100
r.threads_mode, r.threads = "FIXED", 2
r.use_persistent_data = True
image = r.image_settings
image.file_format, image.color_depth, image.color_mode, image.exr_codec = "OPEN_EXR", "32", "RGB", "NONE"
sc.view_settings.view_transform = "Standard"
r.filepath = os.path.abspath(out)
cy.samples, cy.seed = 1, 12345
bpy.ops.render.render()
cy.samples, cy.seed = int(spp), int(seed)
sc.update_tag()
bpy.context.view_layer.update()
start = os.times().user
bpy.ops.render.render(write_still=True)
print(f"CYCLES {os.times().user - start:.3f}", flush=True)
