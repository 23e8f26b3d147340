"""A shot as four panels: pinhole, traced truth, filtered, and the difference of the last two, with the CPU seconds of each.

    python gallery.py TILTSHIFT SCENE.toml SHOT OUT.png [--size 640x360] [--spp 512] [--frame-spp 256] [--enlarge 1]

The pinhole picture and its time are those of the RGB-D frame with its layers, from which the filter starts. Needs pip
`numpy OpenEXR pillow`.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw, ImageFont

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from gltf_beside_mitsuba import read

TIMES = 8


def user(*command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.stderr


def srgb(x):
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def difference(d):
    """White where nothing differs; darker where the filter lacks a colour, in the other colours where it has too much."""
    more = np.maximum(d, 0)
    return np.clip(1 + np.minimum(d, 0) - 0.5 * (more[..., [1, 2, 0]] + more[..., [2, 0, 1]]), 0, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("scene")
    parser.add_argument("shot")
    parser.add_argument("out")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--spp", default="512")
    parser.add_argument("--frame-spp", default="256")
    parser.add_argument("--enlarge", type=int, default=1, help="show pictures so many times as large")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        at = lambda name: os.path.join(folder, name)
        render = [args.tiltshift, "render", args.scene, "--shot", args.shot, "--size", args.size]
        traced, _ = user(*render, "--spp", args.spp, "-o", at("truth.exr"), "--rgbd", at("none.exr"), "--layers", 1, "--rgbd-spp", 2, "--overscan", 0)
        layered, _ = user(*render, "--spp", 2, "-o", at("none.exr"), "--rgbd", at("frame.exr"), "--rgbd-spp", args.frame_spp)
        filtered, words = user(args.tiltshift, "filter", at("frame.exr"), "-o", at("filtered.exr"))
        user(args.tiltshift, "filter", at("frame.exr"), "-o", at("pinhole.exr"), "--method", "pinhole")
        truth, result, pinhole = [read(at(name)) for name in ("truth.exr", "filtered.exr", "pinhole.exr")]
    psnr = -10 * np.log10(np.mean((truth - result) ** 2))
    clipped = -10 * np.log10(np.mean((np.clip(truth, 0, 1) - np.clip(result, 0, 1)) ** 2))
    print(f"{args.scene} {args.shot}: traced {traced:.1f} s, frame {layered:.1f} s, filter {filtered:.2f} s; PSNR {psnr:.2f} dB, clipped to 0..1 {clipped:.2f} dB\n{words}")
    panels = [
        (f"pinhole with depth: {layered:.0f} CPU s", pinhole),
        (f"truth: traced, {args.spp} samples, {traced:.0f} CPU s", truth),
        (f"filtered: {filtered:.2f} CPU s", result),
    ]
    sheet(panels, args.enlarge).save(args.out, optimize=True)


def sheet(panels, enlarge):
    """Titles and linear pictures, the last two the truth and the result, and their difference."""
    (_, truth), (_, result) = panels[-2:]
    drawn = [(title, srgb(picture)) for title, picture in panels]
    drawn.append((f"filtered - truth, x {TIMES}", difference(TIMES * (np.clip(result, 0, 1) - np.clip(truth, 0, 1)))))
    height, width = [enlarge * side for side in truth.shape[:2]]
    made = Image.new("RGB", (2 * width, 2 * height))
    draw, font = ImageDraw.Draw(made), ImageFont.load_default(size=15)
    for i, (title, picture) in enumerate(drawn):
        x, y = i % 2 * width, i // 2 * height
        tile = Image.fromarray((picture * 255 + 0.5).astype(np.uint8)).resize((width, height), Image.BICUBIC)
        made.paste(tile, (x, y))
        box = draw.textbbox((x + 8, y + 6), title, font=font)
        draw.rectangle((box[0] - 4, box[1] - 4, box[2] + 4, box[3] + 4), fill=(0, 0, 0))
        draw.text((x + 8, y + 6), title, font=font, fill=(255, 255, 255))
    # 256 colours are enough to look at, and half the size
    return made.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


if __name__ == "__main__":
    main()
