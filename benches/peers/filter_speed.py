"""What the blur alone costs: `tiltshift filter` beside GEGL's lens-blur, start, reading and writing taken off.

    python filter_speed.py TILTSHIFT INPUTS [--runs 5] [--cases 720:20 2160:80 ...] [--timeout 120] [--json FILE]

TILTSHIFT is the binary; INPUTS holds s_HEIGHT.exr (colour and depth), s_HEIGHT_rgb.exr and s_HEIGHT_coc01.exr, as
filter_speed_inputs.py writes them. A case is HEIGHT:D, D the largest blur DIAMETER in px. Per run and case, one after the other:
tiltshift (whole), GEGL with one lens-blur, GEGL with four in a chain (one process, one shared mask, so that each really runs;
--chain N for more), tiltshift --method pinhole (start, reading, writing). Net of a run:

    GEGL: (four - one) / 3        tiltshift: whole - pinhole

User CPU seconds are the measure on a busy machine; wall seconds stand beside them. Figures: median (min-max) of the runs; the net
figures are medians of the runs' own differences. The script says so and fails if GEGL's four blurs do not cost more than its one.
Only the standard library is needed, and `gegl` on the path. The lens options (focal length, sensor, focus, aperture) are those of
the scene `simple` of the Blender references; change them for other inputs.
"""

import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time

CASES = ["720:20", "720:40", "720:80", "720:160", "2160:20", "2160:80"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tiltshift")
    parser.add_argument("inputs")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--cases", nargs="+", default=CASES, metavar="HEIGHT:D")
    parser.add_argument("--timeout", type=float, default=120, help="wall seconds for one process; a case that hits it is not run again")
    parser.add_argument("--gegl", default="gegl")
    parser.add_argument("--chain", type=int, default=4, metavar="N", help="lens-blurs in GEGL's longer chain (default 4)")
    parser.add_argument("--only", choices=("tiltshift", "gegl"), help="measure one side")
    parser.add_argument("--extra", default="", help="more options for tiltshift filter, in one string")
    parser.add_argument("--nice", type=int, default=0, help="added to the niceness of what is measured")
    parser.add_argument("--json", help="also write every single figure here")
    parser.add_argument("--focal-length", type=float, default=50, help="mm")
    parser.add_argument("--sensor-width", type=float, default=36, help="mm")
    parser.add_argument("--focus-distance", type=float, default=10, help="m")
    parser.add_argument("--aperture-radius", type=float, default=305, help="mm; the lens that gives --reference-diameter at --reference-height")
    parser.add_argument("--reference-diameter", type=float, default=40, help="px")
    parser.add_argument("--reference-height", type=int, default=720, help="px")
    return parser.parse_args()


def measure(command, timeout, nice):
    """-> (user s, wall s, peak MiB), or None when it took longer than allowed."""
    with tempfile.TemporaryFile() as errors:
        start = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, preexec_fn=(lambda: os.nice(nice)) if nice else None)
        late = threading.Event()

        def stop():
            late.set()
            process.kill()

        timer = threading.Timer(timeout, stop)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        if late.is_set():
            return None
        if process.returncode:
            errors.seek(0)
            sys.exit(f"{' '.join(command)}\nended with {process.returncode}:\n{errors.read().decode(errors='replace')[-2000:]}")
    return usage.ru_utime, wall, usage.ru_maxrss / 1024


def commands(args, height, diameter, out):
    base = os.path.join(os.path.abspath(args.inputs), f"s_{height}")
    for name in (".exr", "_rgb.exr", "_coc01.exr"):
        if not os.path.exists(base + name):
            sys.exit(f"{base + name} is not there: see filter_speed_inputs.py")
    radius = args.aperture_radius * diameter / args.reference_diameter * args.reference_height / height
    ours = [args.tiltshift, "filter", base + ".exr", "-o", os.path.join(out, "ours.exr")]
    ours += ["--focal-length", f"{args.focal_length:g}", "--sensor-width", f"{args.sensor_width:g}"]
    ours += ["--aperture-radius", f"{radius:.6g}", "--focus-distance", f"{args.focus_distance:g}"]
    blur = ["gegl:lens-blur", f"radius={diameter / 2:g}", "linear-mask=true"]
    mask = ["aux=[", "gegl:load", f"path={base}_coc01.exr", "id=mask", "]"]

    def gegl(times):
        chain = blur + mask + (blur + ["aux=[", "ref=mask", "]"]) * (times - 1)
        return [args.gegl, base + "_rgb.exr", "-o", os.path.join(out, f"gegl{times}.exr"), "--", *chain]

    return {
        "ours": ours + args.extra.split(),
        "gegl1": gegl(1),
        "chain": gegl(args.chain),
        "pinhole": ours[:4] + [os.path.join(out, "pinhole.exr")] + ours[5:] + ["--method", "pinhole"],
    }


def text(values, unit=""):
    if not values:
        return "-"
    return f"{statistics.median(values):.3f} ({min(values):.3f}-{max(values):.3f}){unit}"


def main():
    args = arguments()
    cases = [tuple(map(int, case.split(":"))) for case in args.cases]
    load = os.getloadavg()[0]
    print(f"{datetime.datetime.now():%Y-%m-%d %H:%M}, {os.cpu_count()} cores, load average {load:.2f}, {args.runs} runs, median (min-max), seconds")
    record = []
    for height, diameter in cases:
        with tempfile.TemporaryDirectory() as out:
            todo = commands(args, height, diameter, out)
            if args.only:
                todo = {name: c for name, c in todo.items() if (c[0] == args.gegl) == (args.only == "gegl")}
            got = {name: [] for name in ("ours", "gegl1", "chain", "pinhole")}
            too_long = set()
            for _ in range(args.runs):
                for name, command in todo.items():
                    if name in too_long:
                        continue
                    figures = measure(command, args.timeout, args.nice)
                    if figures is None:
                        too_long.add(name)
                    else:
                        got[name].append(figures)
        record.append({"height": height, "diameter": diameter, "runs": got, "too_long": sorted(too_long)})
        report(args, height, diameter, got, too_long)
    if args.json:
        with open(args.json, "w") as file:
            json.dump({"load_before": load, "load_after": os.getloadavg()[0], "fields": ["user s", "wall s", "peak MiB"], "cases": record}, file, indent=1)
    print(f"\nload average at the end {os.getloadavg()[0]:.2f}")


def report(args, height, diameter, got, too_long):
    print(f"\n{height} lines, largest blur {diameter} px diameter")
    titles = {"ours": "tiltshift", "pinhole": "tiltshift pinhole", "gegl1": "GEGL x 1", "chain": f"GEGL x {args.chain}"}
    for name, title in titles.items():
        if not got[name] and name not in too_long:
            continue
        user, wall, peak = ([run[i] for run in got[name]] for i in range(3))
        note = f"   stopped after {args.timeout:g} s" if name in too_long else ""
        print(f"  {title:<18} user {text(user):<24} wall {text(wall):<24} peak {max(peak, default=0):.0f} MiB{note}")
    net = {}
    for i, clock in enumerate(("user", "wall")):
        gegl = [(many[i] - one[i]) / (args.chain - 1) for one, many in zip(got["gegl1"], got["chain"])]
        ours = [whole[i] - floor[i] for whole, floor in zip(got["ours"], got["pinhole"])]
        net[clock] = (ours, gegl)
        ratio = f"{statistics.median(ours) / statistics.median(gegl):.2f}" if ours and gegl and statistics.median(gegl) > 0 else "-"
        whole = f"{statistics.median([r[i] for r in got['ours']]) / statistics.median([r[i] for r in got['gegl1']]):.2f}" if got["ours"] and got["gegl1"] else "-"
        print(f"  net {clock}: tiltshift {text(ours)}, GEGL {text(gegl)}, ratio {ratio}; whole processes {whole}", flush=True)
    one, many = ([run[0] for run in got[name]] for name in ("gegl1", "chain"))
    if one and many and statistics.median(many) <= 1.1 * statistics.median(one):
        sys.exit(f"GEGL's {args.chain} blurs cost hardly more than its one: they did not all run, or the machine is too busy")


if __name__ == "__main__":
    main()
