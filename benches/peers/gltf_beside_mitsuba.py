"""The same glTF file through tiltshift and Mitsuba 3: do they agree within their noise?

    python gltf_beside_mitsuba.py TILTSHIFT MODEL --out FOLDER [--case cornell|helmet] [--looks full] [--model own|same]
                                  [--spp 256,256] [--size 480x480] [--texture 256]

Both get the same file (a copy that gltf_parts.edit wrote), the same camera, as many bounces, a box filter, linear values, two seeds. With
A, B of one program, its picture is (A + B) / 2 and its noise rms(A - B) / 2. Printed: RMSE between the two pictures, what both noises
predict, sqrt(a^2 + b^2), and their ratio. What --out gets: the two pictures, and their difference around grey. Needs pip
`mitsuba drjit numpy OpenEXR pillow` and libLLVM (../../README: apt `libllvm19`).
"""

import argparse
import os
import subprocess
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import gltf_parts

# Cameras, light and the emission that the lamp's 100 is replaced by
CASES = {
    "cornell": dict(position=[-278, 273, 800], look_at=[-278, 273, 0], fov_deg=39.3, sky=[0, 0, 0], emission=15.0, bounces=8, scale=100),
    "helmet": dict(position=[0.5, 0.6, 1.25], look_at=[0, 0.345, 0.03], fov_deg=36, sky=[1, 1, 1], emission=None, bounces=12, scale=1),
}


def scene_file(path, model, case, size):
    """The project's own scene file for the same view."""
    q = ", ".join
    text = f"""format = 1
metres_per_unit = 1.0
sky = {case["sky"]}
[render]
bounces = {case["bounces"]}
[meshes.model]
file = "{os.path.abspath(model)}"
[[objects]]
mesh = "model"
[camera]
position = {[float(x) for x in case["position"]]}
look_at = {[float(x) for x in case["look_at"]]}
[lens]
focus = {{ distance = {float(np.linalg.norm(np.subtract(case["position"], case["look_at"])))} }}
[film]
size = [{size[0]}, {size[1]}]
window = {{ fov_deg = {case["fov_deg"]} }}
"""
    open(path, "w").write(text)


def read(path):
    import OpenEXR

    c = OpenEXR.File(path, separate_channels=True).channels()
    return np.stack([c[k].pixels for k in "RGB"], -1).astype(float)


def ours(binary, scene, out, spp, seed):
    command = [binary, "render", scene, "-o", out, "--rgbd", out + ".rgbd.exr", "--spp", str(spp), "--seed", str(seed)]
    command += ["--layers", "1", "--rgbd-spp", "2", "--overscan", "0"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return read(out)


def rms(x):
    return float(np.sqrt(np.mean(x * x)))


def to_png(path, linear):
    from PIL import Image

    x = np.clip(linear, 0, 1)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    Image.fromarray((x * 255 + 0.5).astype(np.uint8)).save(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("gltf")
    parser.add_argument("--out", required=True)
    parser.add_argument("--case", choices=CASES, required=True)
    parser.add_argument("--looks", default="full")
    parser.add_argument("--model", choices=("own", "same"), default="own")
    parser.add_argument("--spp", default="256,256", help="tiltshift's, Mitsuba's")
    parser.add_argument("--size", default="320x320")
    parser.add_argument("--texture", type=int)
    parser.add_argument("--bounces", type=int)
    args = parser.parse_args()
    case = dict(CASES[args.case])
    if args.bounces is not None:
        case["bounces"] = args.bounces
    size = [int(x) for x in args.size.split("x")]
    spp = [int(x) for x in args.spp.split(",")]
    name = f"{args.case}_{args.looks}_{args.texture or 'all'}_{args.model}"
    folder = os.path.join(args.out, name)
    os.makedirs(folder, exist_ok=True)
    file = gltf_parts.edit(args.gltf, folder, args.looks, args.texture, case["emission"])
    toml = os.path.join(folder, "scene.toml")
    scene_file(toml, file, case, size)
    a = [ours(args.tiltshift, toml, os.path.join(folder, f"ours{seed}.exr"), spp[0], seed) for seed in (1, 2)]

    import mitsuba_scene as ms

    parts = gltf_parts.read(file, folder)
    scene = ms.build(parts, dict(case, size=size), args.model, folder, case["sky"])
    integrator = ms.path_tracer(case["bounces"])
    b = [ms.render(scene, integrator, spp[1], seed) for seed in (1, 2)]
    A, B = (a[0] + a[1]) / 2, (b[0] + b[1]) / 2
    noise = [rms(a[0] - a[1]) / 2, rms(b[0] - b[1]) / 2]
    error, expected = rms(A - B), float(np.hypot(*noise))
    print(
        f"{name}: {len(parts)} parts, {sum(len(p.F) for p in parts)} triangles; mean {A.mean():.4f} | {B.mean():.4f}; noise {noise[0]:.5f} | {noise[1]:.5f}; "
        f"RMSE {error:.5f}, expected {expected:.5f}, ratio {error / expected:.3f}; mean difference {np.mean(A - B):+.5f}",
        flush=True,
    )
    np.savez_compressed(os.path.join(folder, "pictures.npz"), ours=A.astype(np.float32), mitsuba=B.astype(np.float32))
    difference = 0.5 + 4 * (A - B)
    strip = np.concatenate([A, B], 1)
    to_png(os.path.join(folder, "pictures.png"), strip)
    from PIL import Image

    Image.fromarray((np.clip(difference, 0, 1) * 255).astype(np.uint8)).save(os.path.join(folder, "difference.png"))


if __name__ == "__main__":
    main()
