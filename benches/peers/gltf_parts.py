"""A glTF file as plain arrays, for renderers that do not read it themselves.

    parts = read("model.gltf", "folder for pictures")      # a list of Part
    edit("model.gltf", "folder", "diffuse", texture=256)   # a copy with simpler materials; -> its path

Nodes with their transforms, meshes, smooth normals, texture coordinates, materials (base colour, metallic-roughness, normal and
emissive textures, alpha), no cameras, lights, skins or morph targets. Written apart from the project's own reader, so that a fault of
that one shows.
"""

import base64
import json
import os
import struct
from dataclasses import dataclass, field

import numpy as np

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Material:
    """How a surface looks; maps are paths of pictures."""

    name: str = ""
    kind: str = "matte"  # matte, glossy or glass
    color: list = field(default_factory=lambda: [0.8, 0.8, 0.8])
    color_map: str = None
    metallic: float = 0.0
    roughness: float = 1.0
    ior: float = 1.5
    surface_map: str = None  # green: roughness, blue: metallic
    normal_map: str = None
    emission: list = field(default_factory=lambda: [0.0, 0.0, 0.0])
    alpha: str = "OPAQUE"
    checker: dict = None
    is_light: bool = False  # whether renderers shall sample it


@dataclass
class Part:
    """Triangles of one material in the world; N and UV may be None."""

    V: np.ndarray
    F: np.ndarray
    N: np.ndarray
    UV: np.ndarray
    material: Material


def document(path):
    """-> the JSON of a .gltf or .glb, and its buffers."""
    data = open(path, "rb").read()
    blob = None
    if data[:4] == b"glTF":
        size = struct.unpack("<I", data[12:16])[0]
        doc = json.loads(data[20 : 20 + size])
        blob = data[28 + size :]
    else:
        doc = json.loads(data)
    here = os.path.dirname(os.path.abspath(path))
    buffers = []
    for buffer in doc["buffers"]:
        uri = buffer.get("uri")
        if uri is None:
            buffers.append(blob)
        elif uri.startswith("data:"):
            buffers.append(base64.b64decode(uri.split(",", 1)[1]))
        else:
            buffers.append(open(os.path.join(here, uri), "rb").read())
    return doc, buffers


def accessor(doc, buffers, index):
    a = doc["accessors"][index]
    view = doc["bufferViews"][a["bufferView"]]
    kind, width = np.dtype(TYPES[a["componentType"]]), WIDTHS[a["type"]]
    start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize * width)
    raw = np.frombuffer(buffers[view["buffer"]], np.uint8, count=stride * (a["count"] - 1) + kind.itemsize * width, offset=start)
    rows = np.lib.stride_tricks.as_strided(raw, (a["count"], kind.itemsize * width), (stride, 1))
    values = np.ascontiguousarray(rows).view(kind).reshape(a["count"], width)
    return values / np.iinfo(kind).max if a.get("normalized") else values


def matrix_of(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    m = np.eye(4)
    m[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def picture(doc, buffers, path, folder, index):
    """The file of a texture's picture; those inside the document are written to `folder`."""
    image = doc["images"][doc["textures"][index]["source"]]
    if "uri" in image and not image["uri"].startswith("data:"):
        return os.path.join(os.path.dirname(os.path.abspath(path)), image["uri"])
    if "uri" in image:
        data = base64.b64decode(image["uri"].split(",", 1)[1])
    else:
        view = doc["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        data = buffers[view["buffer"]][start : start + view["byteLength"]]
    os.makedirs(folder, exist_ok=True)
    out = os.path.join(folder, f"image{doc['textures'][index]['source']}.png")
    open(out, "wb").write(data)
    return out


def material_of(doc, buffers, path, folder, index):
    source = doc["materials"][index] if index is not None else {}
    pbr = source.get("pbrMetallicRoughness", {})

    def texture(info):
        return None if info is None else picture(doc, buffers, path, folder, info["index"])

    strength = source.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    m = Material(
        name=source.get("name", ""),
        color=pbr.get("baseColorFactor", [1, 1, 1, 1])[:3] if index is not None else [0.8] * 3,
        color_map=texture(pbr.get("baseColorTexture")),
        metallic=pbr.get("metallicFactor", 1.0) if index is not None else 0.0,
        roughness=pbr.get("roughnessFactor", 1.0),
        surface_map=texture(pbr.get("metallicRoughnessTexture")),
        normal_map=texture(source.get("normalTexture")),
        emission=[strength * e for e in source.get("emissiveFactor", [0, 0, 0])],
        alpha=source.get("alphaMode", "OPAQUE"),
    )
    is_matte = m.metallic == 0 and m.roughness >= 1 and m.surface_map is None
    m.kind = "matte" if is_matte else "glossy"
    m.is_light = any(m.emission)
    return m


def read(path, folder):
    """All triangles of the default scene, by node and material."""
    doc, buffers = document(path)
    parts, cache = [], {}

    def walk(index, world_from_parent):
        node = doc["nodes"][index]
        world = world_from_parent @ matrix_of(node)
        primitives = doc["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []
        for primitive in primitives:
            if primitive.get("mode", 4) != 4:
                continue
            names = primitive["attributes"]
            V = accessor(doc, buffers, names["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            N = None
            if "NORMAL" in names:
                N = accessor(doc, buffers, names["NORMAL"]) @ np.linalg.inv(world[:3, :3])
                N = N / np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-20)
            UV = accessor(doc, buffers, names["TEXCOORD_0"]) if "TEXCOORD_0" in names else None
            F = accessor(doc, buffers, primitive["indices"]).reshape(-1, 3) if "indices" in primitive else np.arange(len(V)).reshape(-1, 3)
            if np.linalg.det(world[:3, :3]) < 0:
                F = F[:, [0, 2, 1]]
            number = primitive.get("material")
            if number not in cache:
                cache[number] = material_of(doc, buffers, path, folder, number)
            parts.append(Part(V, F.astype(np.uint32), N, UV, cache[number]))
        for child in node.get("children", []):
            walk(child, world)

    for root in doc["scenes"][doc.get("scene", 0)]["nodes"]:
        walk(root, np.eye(4))
    return parts


def edit(path, folder, looks, texture=None, emission=None):
    """Writes a copy of a glTF file whose materials are simpler; -> its path.

    looks: full (as they are), diffuse (base colour alone), rough (metallic 0, roughness 0.5), metal (metallic 1, roughness 0.5);
    the last three keep colours and lose all other maps; a word +normals keeps normal maps, +alpha what lets light through,
    +flat drops smooth normals.
    texture: pictures are made this wide at most. emission: instead of every emissive strength.
    """
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None
    doc, buffers = document(path)
    looks, *keep = looks.split("+")
    os.makedirs(folder, exist_ok=True)
    for i, image in enumerate(doc.get("images", [])):
        index = next(k for k, t in enumerate(doc["textures"]) if t["source"] == i)
        file = picture(doc, buffers, path, folder, index)
        source = Image.open(file)
        if texture and source.width > texture:
            # Means of texels, colours as they are coded: the same file goes to all renderers
            source = source.resize((texture, texture * source.height // source.width), Image.BOX)
        name = f"image{i}_{texture or 'full'}.png"
        source.save(os.path.join(folder, name))
        image.clear()
        image["uri"] = name
    blob = b"".join(b + b"\0" * (-len(b) % 4) for b in buffers[:1])
    open(os.path.join(folder, "buffer.bin"), "wb").write(blob)
    doc["buffers"] = [{"uri": "buffer.bin", "byteLength": len(blob)}]
    for m in doc["materials"]:
        pbr = m.setdefault("pbrMetallicRoughness", {})
        if emission is not None and any(m.get("emissiveFactor", [0])):
            m.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {"emissiveStrength": emission}
        if looks == "full":
            continue
        pbr.pop("metallicRoughnessTexture", None)
        pbr["metallicFactor"] = 1.0 if looks == "metal" else 0.0
        pbr["roughnessFactor"] = 1.0 if looks == "diffuse" else 0.5
        if "normals" not in keep:
            m.pop("normalTexture", None)
        if "flat" in keep:
            for primitive in (p for mesh in doc["meshes"] for p in mesh["primitives"]):
                primitive["attributes"].pop("NORMAL", None), primitive["attributes"].pop("TANGENT", None)
        if "alpha" not in keep:
            m.pop("alphaMode", None)
    name = "_".join([looks, *keep, str(texture or "all")])
    out = os.path.join(folder, f"{name}.gltf")
    json.dump(doc, open(out, "w"))
    return out
