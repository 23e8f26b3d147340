"""The scenes that time_to_error.py gives to each renderer: one view of each, untilted, since none of the others tilts."""

import os
import re
from dataclasses import dataclass

import gltf_parts
import toml_parts
from gltf_beside_mitsuba import CASES, scene_file

SIZE = [320, 180]


@dataclass
class Scene:
    parts: list
    view: dict
    sky: list
    suns: list
    bounces: int


def write(name, folder, root, shared):
    """-> a job: what it is made of, and our scene file for it."""
    os.makedirs(folder, exist_ok=True)
    toml = os.path.join(folder, f"{name}.toml")
    if name in CASES:
        case = dict(CASES[name], size=[240, 240])
        model = {"cornell": "CornellBox/CornellBox.glb", "helmet": "FlightHelmet/FlightHelmet.gltf"}[name]
        file = gltf_parts.edit(os.path.join(shared, "data/scenes/bevy", model), os.path.join(folder, name), "full", 1024, case["emission"])
        scene_file(toml, file, case, case["size"])
        return dict(name=name, toml=toml, shot=None, gltf=file, case=case, folder=folder)
    text = open(os.path.join(root, f"data/scenes/{name}.toml")).read()
    if name in ("town", "landscape"):
        # The sun alone: ambient light is no light of theirs
        text = re.sub(r"(?m)^\w+ = \{ ambient = .*\n", "", text)
        text = re.sub(r"(?m)^sky = .*$", "sky = 0", text)
    if name == "town":
        view = dict(position=[-46, 62, 112], look_at=[4, 0, 2], fov_deg=39.6, radius=1.0, focus=140.0)
    elif name == "landscape":
        view = dict(position=[-12.092238, 37.355339, 33.223151], look_at=[0, 2, 0], fov_deg=35.0, radius=1.0, focus=50.0)
    else:
        view = dict(position=[3, 11.5, 53], look_at=[0.5, 6.3, 0], fov_deg=29.4, radius=1.5, focus=47.5)
    text += f"""
[shots.bench]
lens.focus = {{ distance = {view["focus"]} }}
lens.aperture = {{ radius = {view["radius"]} }}
film.window = {{ fov_deg = {view["fov_deg"]} }}
film.size = {SIZE}
"""
    open(toml, "w").write(text)
    return dict(name=name, toml=toml, shot="bench", view=dict(view, size=SIZE), folder=folder)


def scene_of(job):
    """The parts of a job."""
    if "gltf" in job:
        case = job["case"]
        view = {k: case[k] for k in ("position", "look_at", "fov_deg", "size")}
        return Scene(gltf_parts.read(job["gltf"], job["folder"]), view, case["sky"], [], case["bounces"])
    read = toml_parts.read(job["toml"], job["shot"], 48)
    # A sun's light is not counted among what goes from surface to surface
    bounces = read.bounces + 1 if read.suns else read.bounces
    return Scene(read.parts, job["view"], read.sky, read.suns, bounces)
