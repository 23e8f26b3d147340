"""User CPU seconds until a picture's noise is 0.01 RMSE: tiltshift, Mitsuba 3 and Cycles on the same scenes, in turns.

    python time_to_error.py TILTSHIFT --out FOLDER --shared ../../../shared [--scenes town landscape cornell tabletop helmet] [--runs 3]

Two threads each. Noise is rms(A - B) / sqrt(2) of two seeds, linear values, peak anything; time to t is seconds x (noise / t)^2 from a
run at a number of samples that comes near it. tiltshift: the whole process with reading, tree and files; Mitsuba (`path`, independent
sampler, no chance in how long paths are): inside the process after warm-up; Cycles: inside Blender, data kept, after a first picture.
Needs pip `mitsuba drjit numpy OpenEXR pillow`, apt `libllvm19 blender`.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import jobs
from gltf_beside_mitsuba import read, rms, to_png

TARGET = 0.01
# Samples per pixel of tiltshift, Mitsuba, Cycles
SPP = {"town": (16, 32, 16), "landscape": (16, 32, 16), "cornell": (64, 256, 128), "helmet": (16, 32, 16), "tabletop": (128, 128, 64)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("--out", required=True)
    parser.add_argument("--shared", required=True)
    parser.add_argument("--scenes", nargs="+", default=list(SPP))
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--spp", help="instead of what stands here: three numbers")
    args = parser.parse_args()
    root = os.path.join(HERE, "../..")
    import drjit as dr
    import mitsuba_scene as ms

    dr.set_thread_count(2)
    for name in args.scenes:
        job = jobs.write(name, os.path.abspath(args.out), root, os.path.abspath(args.shared))
        job_file = os.path.join(args.out, f"{name}.json")
        json.dump(job, open(job_file, "w"))
        scene = jobs.scene_of(job)
        model = ms.build(scene.parts, scene.view, "same", os.path.join(args.out, name + "_ply"), scene.sky, suns=scene.suns)
        integrator = ms.path_tracer(scene.bounces)
        spp = [int(x) for x in args.spp.split(",")] if args.spp else SPP[name]

        def ours(seed):
            out = os.path.join(args.out, f"{name}_tiltshift{seed}.exr")
            command = [args.tiltshift, "render", job["toml"], "-o", out, "--rgbd", out + ".rgbd.exr", "--spp", str(spp[0]), "--seed", str(seed)]
            command += ["--layers", "1", "--rgbd-spp", "2", "--overscan", "0"] + (["--shot", job["shot"]] if job["shot"] else [])
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            subprocess.run(command, check=True, capture_output=True, env=dict(os.environ, RAYON_NUM_THREADS="2"))
            return read(out), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

        def mitsuba(seed):
            before = os.times().user
            picture = ms.render(model, integrator, spp[1], seed)
            return picture, os.times().user - before

        def cycles(seed):
            out = os.path.join(args.out, f"{name}_cycles{seed}.exr")
            command = ["blender", "-b", "-P", os.path.join(HERE, "cycles_scene.py"), "--", job_file, out, str(spp[2]), str(seed)]
            path = os.pathsep.join(p for p in sys.path if "site-packages" in p)
            done = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ, PYTHONPATH=path))
            line = [x for x in done.stdout.splitlines() if x.startswith("CYCLES")]
            if not line:
                raise SystemExit(done.stdout[-3000:] + done.stderr[-3000:])
            return read(out), float(line[0].split()[1])

        renderers = {"tiltshift": ours, "mitsuba": mitsuba, "cycles": cycles}
        ms.render(model, integrator, spp[1], 99)
        times, pictures = {k: [] for k in renderers}, {k: [] for k in renderers}
        for run in range(args.runs):
            for k, render in renderers.items():
                picture, seconds = render(run + 1)
                times[k].append(seconds)
                pictures[k].append(picture)
        print(f"{name}: load {os.getloadavg()[0]:.1f}, {scene.view['size']}, {sum(len(p.F) for p in scene.parts)} triangles, bounces {scene.bounces}")
        for k, n in zip(renderers, spp):
            noise = statistics.median(rms(a - b) / 2**0.5 for i, a in enumerate(pictures[k]) for b in pictures[k][:i])
            seconds = statistics.median(times[k])
            mean = np.mean(pictures[k], 0)
            to_png(os.path.join(args.out, f"{name}_{k}.png"), mean)
            print(
                f"  {k}: {n} spp, user s {' '.join(f'{t:.2f}' for t in times[k])}, noise {noise:.5f}, mean {mean.mean():.4f}, "
                f"to {TARGET}: {seconds * (noise / TARGET) ** 2:.3f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
