"""Inputs of filter_speed.py from an RGBZ EXR (needs numpy, scipy and OpenEXR).

    python filter_speed_inputs.py RGBZ.exr FOLDER --focus 10 --aperture 0.61 --max-diameter 40 [--heights 720 2160]

For each height H, a whole multiple of the picture's: s_H.exr (R, G, B, Z), s_H_rgb.exr and s_H_coc01.exr = |CoC diameter| / largest
diameter as grey (the same plane for every largest diameter: the aperture scales them alike). Enlarged: colour linear, depth by
repetition. --aperture is a diameter in scene units and --max-diameter the diameter in px that it gives in the picture as it is.
"""

import argparse
import os

import numpy as np
import OpenEXR
from scipy.ndimage import zoom

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("rgbz")
parser.add_argument("folder")
parser.add_argument("--focus", type=float, required=True)
parser.add_argument("--aperture", type=float, required=True)
parser.add_argument("--focal-px", type=float, help="default: 50 mm on a 36 mm wide sensor")
parser.add_argument("--max-diameter", type=float, required=True)
parser.add_argument("--heights", type=int, nargs="+", default=[720, 2160])
args = parser.parse_args()


def write(name, planes):
    planes = {k: np.ascontiguousarray(v, np.float32) for k, v in planes.items()}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, planes).write(os.path.join(args.folder, name))


channels = OpenEXR.File(args.rgbz, separate_channels=True).channels()
planes = {k: channels[k].pixels.astype(np.float32) for k in "RGBZ"}
height, width = planes["Z"].shape
os.makedirs(args.folder, exist_ok=True)
for h in args.heights:
    k, rest = divmod(h, height)
    if rest:
        raise SystemExit(f"{h} is no multiple of {height}")
    big = {c: zoom(planes[c], k, order=1, mode="nearest", grid_mode=True) if k > 1 else planes[c] for c in "RGB"}
    z = planes["Z"].repeat(k, 0).repeat(k, 1)
    diameter = args.aperture * (args.focal_px or 50 / 36 * width) * (1 / args.focus - 1 / z)
    coc = np.clip(np.abs(diameter) / args.max_diameter, 0, 1)
    write(f"s_{h}.exr", {**big, "Z": z})
    write(f"s_{h}_rgb.exr", big)
    write(f"s_{h}_coc01.exr", {c: coc for c in "RGB"})
    print(f"s_{h}: {z.shape[1]} x {h}, CoC {diameter.min():.2f} .. {diameter.max():.2f} px before enlarging")
