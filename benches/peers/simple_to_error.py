"""`simple` through tiltshift, POV-Ray and Cycles, in turns: user CPU seconds to a noise of 0.01 RMSE.

    python simple_to_error.py TILTSHIFT --shared ../../../shared --out FOLDER [--runs 3] [--spp 32,16]

The scene, its scripts and their caveats are those of shared/peers/trace/bench (gen.py, pov.sh, bl.py): 1280x720, untilted lens of radius
0.3, one shadow ray per hit, 2 threads. tiltshift gets simple.obj and `--noise 0.01`; POV-Ray the analytic shapes. Whole processes, user
seconds. Error: tiltshift and Cycles rms(A - B) / sqrt(2) of two seeds; POV-Ray, which has no seeds, against a picture of tiltshift of 1024 samples,
whose noise is taken off. Cycles is asked for the sun alone (--sun-only), as its ambient emission would light neighbours. Time to 0.01 is
seconds x (error / 0.01)^2.
"""

import argparse
import os
import re
import resource
import statistics
import subprocess
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from gltf_beside_mitsuba import read, rms

TARGET = 0.01


def scene(path, shared):
    s, c = np.sin(np.radians(41.2)), np.cos(np.radians(41.2))
    open(path, "w").write(
        f"""format = 1
[meshes.simple]
file = "{shared}/reference/scenes/simple.obj"
[[objects]]
mesh = "simple"
[lights]
fill = {{ ambient = {{ strength = 0.25 }} }}
sun = {{ sun = {{ toward = [-0.45, 1.0, 0.35], strength = 0.75 }} }}
[camera]
position = [0, {0.9 + 11 * s}, {11 * c}]
look_at = [0, 0.9, 0]
[lens]
focus = {{ distance = 11.0 }}
aperture = {{ radius = 0.3 }}
[film]
size = [1280, 720]
window = {{ q = [{-0.325 * 16 / 9}, -0.325, {0.325 * 16 / 9}, 0.325] }}
"""
    )


def user(command, **options):
    """-> user CPU seconds of a process and all it starts, and what it says."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode:
        raise SystemExit(done.stdout[-2000:] + done.stderr[-2000:])
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.stdout + done.stderr


def png16(path):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    x = np.array(mi.Bitmap(path))
    return x[..., :3] / float(np.iinfo(x.dtype).max)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("--shared", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--spp", default="32,16", help="POV-Ray's, Cycles'")
    args = parser.parse_args()
    pov_spp, cycles_spp = args.spp.split(",")
    shared = os.path.abspath(args.shared)
    bench = os.path.join(shared, "peers/trace/bench")
    os.makedirs(args.out, exist_ok=True)
    os.chdir(args.out)
    scene("simple.toml", shared)
    if not os.path.exists("simple.pov"):
        user([sys.executable, os.path.join(bench, "gen.py")])
    small = ["--layers", "1", "--rgbd-spp", "2", "--overscan", "0", "--rgbd", "frame.exr"]
    threads = dict(os.environ, RAYON_NUM_THREADS="2")

    def ours(seed):
        out = f"ours{seed}.exr"
        seconds, _ = user([args.tiltshift, "render", "simple.toml", "-o", out, "--noise", str(TARGET), "--seed", str(seed), *small], env=threads)
        return seconds, read(out)

    def pov(_):
        seconds, _ = user([os.path.join(bench, "pov.sh"), "simple.pov", "pov.png", pov_spp])
        return seconds, png16("pov.png")

    def cycles(seed):
        path = os.pathsep.join(p for p in sys.path if "site-packages" in p)
        command = ["blender", "-b", "-P", os.path.join(bench, "bl.py"), "--", "simple.npz", f"bl{seed}.exr", cycles_spp, str(seed), "--sun-only"]
        seconds, _ = user(command, env=dict(os.environ, PYTHONPATH=path))
        return seconds, read(f"bl{seed}.exr")

    times, pictures = {}, {}
    for run in range(args.runs):
        for name, render in (("tiltshift", ours), ("pov", pov), ("cycles", cycles)):
            seconds, picture = render(run + 1)
            times.setdefault(name, []).append(seconds)
            pictures.setdefault(name, []).append(picture)
    user([args.tiltshift, "render", "simple.toml", "-o", "reference.exr", "--spp", "1024", "--seed", "77", *small], env=threads)
    reference = read("reference.exr")
    for name in times:
        p = pictures[name]
        if name == "pov":
            error = rms(p[0] - reference)
        else:
            error = statistics.median(rms(a - b) / 2**0.5 for i, a in enumerate(p) for b in p[:i])
        seconds = statistics.median(times[name])
        print(
            f"{name}: user s {' '.join(f'{t:.2f}' for t in times[name])}, error {error:.5f}, mean {np.mean(p[0]):.5f}, "
            f"to {TARGET}: {seconds * (error / TARGET) ** 2:.2f} s; load {os.getloadavg()[0]:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
