"""An untilted shot by GEGL's lens-blur and Blender's Defocus node, as candidates for `tiltshift chart`.

    python untilted_chart.py TILTSHIFT data/scenes/simple.toml OUT [--shot blur] [--size 1280x720] [--runs 5]

Traces the shot's frame without overscan, writes what both programs read, runs each RUNS times in turns and prints the
`--candidate` options with the median wall seconds of the whole process (start, read, blur, write EXR; what `chart_command.svg`
shows of a method) in OUT/candidates.txt, one argument a line: xargs hands them to `tiltshift chart`. Needs numpy, OpenEXR, `gegl`
on the path and Python with `bpy` 5 for Blender (--bpy-python PATH; left out without). Both programs get the camera as an
untilted one of a 36 mm wide sensor: lens, focus and aperture come from the EXR's own attributes.
"""

import argparse
import os
import statistics
import subprocess
import sys
import time

import numpy as np
import OpenEXR

BLENDER = '''
import bpy, sys
rgb, z, out, focus, aperture, lens_mm, largest = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
camera = bpy.data.cameras.new("camera")
camera.lens, camera.sensor_width, camera.sensor_fit = float(lens_mm), 36, "HORIZONTAL"
camera.dof.focus_distance, camera.dof.aperture_fstop = float(focus), float(lens_mm) * 1e-3 / float(aperture)
scene.camera = bpy.data.objects.new("camera", camera)
scene.collection.objects.link(scene.camera)
color, depth = bpy.data.images.load(rgb), bpy.data.images.load(z)
depth.colorspace_settings.name = "Non-Color"
r = scene.render
(r.resolution_x, r.resolution_y), r.resolution_percentage = color.size, 100
r.use_compositing, r.compositor_device, r.compositor_precision = True, "CPU", "FULL"
tree = bpy.data.node_groups.new("compositor", "CompositorNodeTree")
scene.compositing_node_group = tree
tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
output = tree.nodes.new("NodeGroupOutput")
nodes = [tree.nodes.new("CompositorNodeImage") for _ in range(2)]
nodes[0].image, nodes[1].image = color, depth
defocus = tree.nodes.new("CompositorNodeDefocus")
defocus.use_zbuffer, defocus.bokeh, defocus.scene = True, "CIRCLE", scene
defocus.f_stop, defocus.blur_max = camera.dof.aperture_fstop, float(largest)
tree.links.new(nodes[0].outputs[0], defocus.inputs[0])
tree.links.new(nodes[1].outputs[0], defocus.inputs[1])
tree.links.new(defocus.outputs[0], output.inputs[0])
scene.view_settings.view_transform = "Raw"
s = r.image_settings
s.file_format, s.color_depth, s.exr_codec, s.color_mode = "OPEN_EXR", "32", "ZIP", "RGB"
r.filepath = out
bpy.ops.render.render(write_still=True)
'''


def channels(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        return {name: channel.pixels.astype(np.float32) for name, channel in file.channels().items()}, file.header()


def write(path, planes):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {name: np.ascontiguousarray(plane, np.float32) for name, plane in planes.items()}).write(path)


def seconds(command):
    started = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command[0]} ended with {done.returncode}: {done.stderr[-1000:]}")
    return time.perf_counter() - started


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("scene")
    parser.add_argument("out")
    parser.add_argument("--shot", default="blur")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--focus", type=float, required=True, help="depth of the plane of focus, scene units")
    parser.add_argument("--aperture", type=float, required=True, help="diameter of the lens, scene units")
    parser.add_argument("--focal-px", type=float, required=True, help="pixels per unit of x / z at this size")
    parser.add_argument("--bpy-python", help="a Python with bpy 5")
    args = parser.parse_args()
    out = os.path.abspath(args.out)
    os.makedirs(out, exist_ok=True)

    # The frame, and what the peers read of it
    frame = os.path.join(out, "frame.exr")
    subprocess.run([args.tiltshift, "render", args.scene, "--shot", args.shot, "--size", args.size, "--spp", "2", "--overscan", "0",
                    "--layers", "1", "-o", os.path.join(out, "truth.exr"), "--rgbd", frame], check=True)
    planes, _ = channels(frame)
    z = planes["Z"]
    diameter = args.aperture * args.focal_px * np.abs(1 / args.focus - 1 / z)
    largest = float(diameter.max())
    rgb, depth, coc = (os.path.join(out, name) for name in ("rgb.exr", "z.exr", "coc01.exr"))
    write(rgb, {c: planes[c] for c in "RGB"})
    write(depth, {c: np.where(np.isfinite(z), z, 1e10) for c in "RGB"})
    write(coc, {c: diameter / largest for c in "RGB"})
    print(f"largest diameter of the blur {largest:.1f} px, load average {os.getloadavg()[0]:.1f}")

    # Both in turns
    made = {"GEGL lens-blur": os.path.join(out, "gegl.exr")}
    commands = {"GEGL lens-blur": ["gegl", rgb, "-o", made["GEGL lens-blur"], "--", "gegl:lens-blur", f"radius={largest / 2:g}", "linear-mask=true",
                                   "aux=[", "gegl:load", f"path={coc}", "]"]}
    if args.bpy_python:
        lens_mm = args.focal_px * 36 / z.shape[1]
        made["Blender Defocus"] = os.path.join(out, "blender.exr")
        commands["Blender Defocus"] = [args.bpy_python, "-c", BLENDER, "--", rgb, depth, made["Blender Defocus"], str(args.focus), str(args.aperture),
                                       f"{lens_mm:g}", f"{largest / 2:g}"]
    times = {name: [] for name in commands}
    for _ in range(args.runs):
        for name, command in commands.items():
            times[name].append(seconds(command))
    with open(os.path.join(out, "candidates.txt"), "w") as file:
        for name, runs in times.items():
            print(f"{name}: median {statistics.median(runs):.3f} s ({min(runs):.3f}-{max(runs):.3f})")
            file.write(f"--candidate\n{name},{made[name]},{statistics.median(runs):.4f}\n")


if __name__ == "__main__":
    main()
