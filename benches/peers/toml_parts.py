"""A scene file of the project (data/scenes) as plain arrays, for renderers that do not read it.

    scene = read("data/scenes/town.toml", "swing")     # -> Scene: parts, view, sky, suns, ambient, bounces

Shapes become triangles: spheres, cylinders and cones with `facets` sides around, and smooth normals. An endless plane ends after 2000
units. No textures, meshes from files, spots, points or environments.
"""

import os
import sys
import tomllib
from dataclasses import dataclass

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from gltf_parts import Material, Part

BITS = (1 << 64) - 1


@dataclass
class Scene:
    parts: list
    view: dict
    sky: list
    suns: list  # of (toward, strength)
    ambient: list
    bounces: int


def three(x):
    return [float(x)] * 3 if isinstance(x, (int, float)) else [float(v) for v in x]


class Numbers:
    """SplitMix64, as FORMAT.md's scatter uses it."""

    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & BITS
        x = ((self.state ^ (self.state >> 30)) * 0xBF58476D1CE4E5B9) & BITS
        x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & BITS
        return ((x ^ (x >> 31)) >> 11) / (1 << 53)

    def between(self, low, high):
        share = np.array([self.next() for _ in range(3)])
        return low + share * (high - low)


def affine(translate, angles_deg, scale):
    """Scales, then turns about z, x and y in this order, then moves."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(angles_deg)), np.sin(np.radians(angles_deg))
    rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    m = np.eye(4)
    m[:3, :3] = ry @ rx @ rz * np.array(three(scale))
    m[:3, 3] = translate
    return m


def placed(p):
    return affine(p.get("translate", [0, 0, 0]), p.get("rotate_deg", [0, 0, 0]), p.get("scale", 1))


def scattered(s):
    """The maps of all copies of a scatter."""
    numbers, maps, places = Numbers(s["seed"]), [], []
    low, high, turn = np.array(s["from"], float), np.array(s["to"], float), np.array(s.get("turn_deg", [0, 0, 0]), float)
    least, most = s.get("scale", [1, 1])
    for _ in range(30 * s["count"]):
        if len(maps) == s["count"]:
            break
        place, angles = numbers.between(low, high), numbers.between(-turn, turn)
        scale = least * (most / least) ** numbers.next()
        if any(np.linalg.norm(place - other) < s.get("spacing", 0) for other in places):
            continue
        maps.append(affine(place, angles, scale))
        places.append(place)
    return maps


def shape(spec, facets):
    """-> V, F, N (None: flat)."""
    (kind, s), = spec.items()
    ring = np.linspace(0, 2 * np.pi, facets, endpoint=False)
    c, sn = np.cos(ring), np.sin(ring)
    nxt = (np.arange(facets) + 1) % facets
    k = np.arange(facets)
    if kind == "plane":
        x, z = [0.5 * v for v in s.get("size", [4000, 4000])]
        return np.array([[-x, 0, -z], [x, 0, -z], [x, 0, z], [-x, 0, z]], float), np.array([[0, 2, 1], [0, 3, 2]]), None
    if kind == "box":
        h = 0.5 * np.array(three(s["size"]))
        V = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * h
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        return V, np.array([t for a, b, cc, d in quads for t in ([a, b, cc], [a, cc, d])]), None
    if kind == "sphere":
        rows = facets // 2
        t = np.linspace(0, np.pi, rows + 1)
        V = np.array([[np.sin(a) * x, np.cos(a), np.sin(a) * z] for a in t for x, z in zip(c, sn)])
        F = []
        for r in range(rows):
            a, b = r * facets, (r + 1) * facets
            if r > 0:
                F.append(np.stack([a + k, a + nxt, b + k], 1))
            if r < rows - 1:
                F.append(np.stack([a + nxt, b + nxt, b + k], 1))
        return V * s["radius"], np.concatenate(F), V
    if kind in ("cylinder", "cone"):
        r, h = s["radius"], s["height"]
        low = np.stack([r * c, 0 * c, r * sn], 1)
        if kind == "cylinder":
            high = low + [0, h, 0]
            n = np.stack([c, 0 * c, sn], 1)
            V = np.concatenate([low, high, low, high, [[0, 0, 0], [0, h, 0]]])
            N = np.concatenate([n, n, 0 * n + [0, -1, 0], 0 * n + [0, 1, 0], [[0, -1, 0], [0, 1, 0]]])
            side = [np.stack([k, facets + k, facets + nxt], 1), np.stack([k, facets + nxt, nxt], 1)]
            caps = [
                np.stack([2 * facets + k, 2 * facets + nxt, np.full(facets, 4 * facets)], 1),
                np.stack([3 * facets + nxt, 3 * facets + k, np.full(facets, 4 * facets + 1)], 1),
            ]
            return V, np.concatenate(side + caps), N
        n = np.stack([h * c, np.full(facets, r), h * sn], 1) / np.hypot(r, h)
        middle = np.stack([h * np.cos(ring + np.pi / facets), np.full(facets, r), h * np.sin(ring + np.pi / facets)], 1) / np.hypot(r, h)
        V = np.concatenate([low, np.tile([[0, h, 0]], (facets, 1)), low, [[0, 0, 0]]])
        N = np.concatenate([n, middle, 0 * n + [0, -1, 0], [[0, -1, 0]]])
        side = np.stack([k, facets + k, nxt], 1)
        cap = np.stack([2 * facets + k, 2 * facets + nxt, np.full(facets, 3 * facets)], 1)
        return V, np.concatenate([side, cap]), N
    raise SystemExit(f"shape {kind} is not done here")


def material(name, spec):
    checker = spec.get("checker")
    glossy = "roughness" in spec or "metallic" in spec
    glass = spec.get("glass")
    return Material(
        name=name,
        kind="glass" if glass else "glossy" if glossy else "matte",
        color=three(spec.get("color", 1.0 if glass else 0.0)),
        metallic=float(spec.get("metallic", 0)),
        roughness=float(spec.get("roughness", 0 if glossy else 1)),
        ior=float((glass or spec).get("ior", 1.5)),
        emission=three(spec.get("emission", 0)),
        is_light=spec.get("area_light", False),
        checker=checker and dict(colors=[three(x) for x in checker["colors"]], side=checker["side"], axes=checker.get("axes", "xz")),
    )


def laid_over(base, over):
    """A shot's keys over the file's own, value by value."""
    out = {k: dict(v) for k, v in base.items()}
    for part in ("camera", "lens", "film"):
        out.setdefault(part, {}).update(over.get(part, {}))
    return out


def view_of(doc, shot):
    chain = []
    while shot:
        spec = doc["shots"][shot]
        chain.append(spec)
        shot = spec.get("from")
    v = {k: dict(doc.get(k, {})) for k in ("camera", "lens", "film")}
    for spec in reversed(chain):
        v = laid_over(v, spec)
    return v


def read(path, shot, facets=64):
    doc = tomllib.load(open(path, "rb"))
    materials = {name: material(name, spec) for name, spec in doc["materials"].items()}
    shapes = {name: shape(spec, facets) for name, spec in doc.get("shapes", {}).items()}
    for name, spec in doc.get("meshes", {}).items():
        shapes[name] = np.array(spec["vertices"], float), np.array(spec["triangles"]), None
    gathered = {}

    def put(what, material_name, m):
        V, F, N = shapes[what]
        V = V @ m[:3, :3].T + m[:3, 3]
        if N is not None:
            N = N @ np.linalg.inv(m[:3, :3])
            N = N / np.linalg.norm(N, axis=1, keepdims=True)
        else:
            # Flat faces: three vertices each, so that smooth and flat shapes join in one mesh
            p = V[F]
            n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
            n = n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)
            V, N, F = p.reshape(-1, 3), np.repeat(n, 3, 0), np.arange(3 * len(F)).reshape(-1, 3)
        gathered.setdefault(material_name, []).append((V, F, N))

    for o in doc["objects"]:
        maps = [placed(p) for p in o.get("placements", [])] + (scattered(o["scatter"]) if "scatter" in o else [])
        for m in maps or ([np.eye(4)] if "placements" not in o and "scatter" not in o else []):
            pieces = doc["groups"][o["group"]] if "group" in o else [o]
            for piece in pieces:
                put(piece.get("shape", piece.get("mesh")), piece["material"], m @ placed(piece.get("place", {})))
    parts = []
    for name, pieces in gathered.items():
        offset, Vs, Fs, Ns = 0, [], [], []
        for V, F, N in pieces:
            Vs.append(V), Ns.append(N), Fs.append(F + offset)
            offset += len(V)
        parts.append(Part(np.concatenate(Vs), np.concatenate(Fs), np.concatenate(Ns), None, materials[name]))
    suns, ambient = [], np.zeros(3)
    for light in doc.get("lights", {}).values():
        (kind, spec), = light.items()
        if kind == "sun":
            suns.append((np.array(spec["toward"]) / np.linalg.norm(spec["toward"]), np.array(three(spec["strength"])) * three(spec.get("color", 1))))
        elif kind == "ambient":
            ambient = ambient + np.array(three(spec["strength"])) * three(spec.get("color", 1))
        else:
            raise SystemExit(f"light {kind} is not done here")
    return Scene(parts, view_of(doc, shot), three(doc.get("sky", 0)), suns, list(ambient), doc.get("render", {}).get("bounces", 0))
