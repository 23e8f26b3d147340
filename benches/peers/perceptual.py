"""FLIP and SSIM of the programs that define them, beside tiltshift's, on the ten pairs of crates/compare/tests/pairs.

    PARITY_PAIRS=DIR cargo test -p compare --test parity -- --ignored
    python perceptual.py DIR [--json crates/compare/tests/data/parity.json]

DIR holds NAME.reference.exr, NAME.candidate.exr and NAME.maps.exr (R: SSIM, G: LDR-FLIP, B: HDR-FLIP, as tiltshift has them).
Prints both means and the largest difference of the whole maps; --json writes the figures that the test is held to. Needs
flip-evaluator 1.7, scikit-image 0.26, OpenEXR 3.5 and numpy.

SSIM: structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1) of sRGB values clipped to
0..1, channel by channel; the mean of the whole map, where scikit-image's own leaves out 5 px of border. FLIP: evaluate(...) with
its default viewing conditions, LDR of linear values clipped to 0..1; the mean of its map in f64.
"""

import argparse
import json
import pathlib
from importlib.metadata import version

import flip_evaluator
import numpy as np
import OpenEXR
from skimage.metrics import structural_similarity

STRIDE = 97


def read(path):
    channels = OpenEXR.File(str(path)).channels()
    if "RGBA" in channels:
        return channels["RGBA"].pixels[..., :3].astype(np.float32)
    if "RGB" in channels:
        return channels["RGB"].pixels.astype(np.float32)
    return np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(np.float32)


def srgb(linear):
    x = np.clip(linear.astype(np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def ssim(reference, candidate):
    _, maps = structural_similarity(
        srgb(reference), srgb(candidate), gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=-1, full=True
    )
    return maps.mean(axis=-1)


def flip(reference, candidate, kind):
    if kind == "LDR":
        reference, candidate = np.clip(reference, 0, 1), np.clip(candidate, 0, 1)
    error, _, _ = flip_evaluator.evaluate(reference, candidate, kind, inputsRGB=False, applyMagma=False)
    return error[..., 0] if error.ndim == 3 else error


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", type=pathlib.Path)
parser.add_argument("--json", type=pathlib.Path)
options = parser.parse_args()

versions = {name: version(name) for name in ["flip-evaluator", "scikit-image"]}
print(", ".join(f"{name} {number}" for name, number in versions.items()))
print("| pair | SSIM: scikit-image / here | LDR-FLIP: its own / here | HDR-FLIP: its own / here | maps differ by at most |")
print("| --- | --- | --- | --- | --- |")
pairs = []
for path in sorted(options.folder.glob("*.reference.exr")):
    name = path.name.removesuffix(".reference.exr")
    reference, candidate = read(path), read(path.with_name(f"{name}.candidate.exr"))
    here = read(path.with_name(f"{name}.maps.exr"))
    maps = [ssim(reference, candidate), flip(reference, candidate, "LDR"), flip(reference, candidate, "HDR")]
    means = [map.astype(np.float64).mean() for map in maps]
    differences = [np.abs(here[..., i] - map).max() for i, map in enumerate(maps)]
    beside = " | ".join(f"{mean:.6f} / {here[..., i].astype(np.float64).mean():.6f}" for i, mean in enumerate(means))
    print(f"| {name} | {beside} | {', '.join(f'{d:.1e}' for d in differences)} |")
    figures = {
        key: {"mean": round(float(mean), 7), "map": [round(float(v), 5) for v in map.ravel()[::STRIDE]]}
        for key, mean, map in zip(["ssim", "flip_ldr", "flip_hdr"], means, maps)
    }
    pairs.append({"name": name, **figures})
if options.json:
    rows = ",\n".join("    " + json.dumps(pair) for pair in pairs)
    options.json.write_text(f'{{\n  "versions": {json.dumps(versions)},\n  "stride": {STRIDE},\n  "pairs": [\n{rows}\n  ]\n}}\n')
