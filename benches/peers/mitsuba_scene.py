"""Parts of gltf_parts.py or toml_parts.py as a Mitsuba 3 scene (llvm_ad_rgb), and its pictures.

Two ways to say how glossy surfaces look:

    own         Mitsuba's `principled` (Disney 2012: retro-reflective base, Schlick's Fresnel, GGX without what facets reflect to
                each other); maps through `bitmap`, `normalmap`, `mask`
    same        the project's model written again below as a Mitsuba BSDF from its description (GGX with Smith's
                height-correlated shadowing, exact Fresnel over a base that gets what the coat lets through, Turquin's compensation),
                with tables of its own making
"""

import os

os.environ.setdefault("DRJIT_LIBLLVM_PATH", "/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)

STEPS = 48  # of roughness and of the root of the cosine
SMOOTH = 0.03


def fresnel(cosine, eta):
    """Of a dielectric, exact; numpy or Dr.Jit."""
    lib = np if isinstance(cosine, np.ndarray) else dr
    through = lib.sqrt(lib.maximum(1 - (1 - cosine * cosine) / (eta * eta), 0))
    a = (eta * cosine - through) / (eta * cosine + through)
    b = (cosine - eta * through) / (cosine + eta * through)
    return 0.5 * (a * a + b * b)


def albedo(share):
    """How much rough facets reflect by roughness and root of the cosine, and its mean over directions.

    The facets' normals are taken from the distribution itself (not from those that are seen, as the project does), on a lattice.
    """
    k = np.arange(1 << 14)
    u, v = (k + 0.5) / len(k), (k * 0.6180339887498949) % 1
    table = np.zeros((STEPS, STEPS))
    for row in range(STEPS):
        alpha = max((row / (STEPS - 1)) ** 2, 1e-6)
        cos_h = np.sqrt((1 - u) / (1 + (alpha * alpha - 1) * u))
        sin_h = np.sqrt(np.maximum(1 - cos_h * cos_h, 0))
        h = np.stack([sin_h * np.cos(2 * np.pi * v), sin_h * np.sin(2 * np.pi * v), cos_h])
        for column in range(STEPS):
            c = max((column / (STEPS - 1)) ** 2, 1e-4)
            if row == 0:
                table[row, column] = share(np.array([c]))[0]
                continue
            o = np.array([np.sqrt(1 - c * c), 0, c])
            oh = o @ h
            i = 2 * oh * h - o[:, None]
            ok = (oh > 0) & (i[2] > 0)
            ci = np.where(ok, i[2], 1.0)

            def lam(z):
                return 0.5 * (np.sqrt(1 + alpha * alpha * (1 - z * z) / (z * z)) - 1)

            g = 1 / (1 + lam(c) + lam(ci))
            table[row, column] = np.mean(np.where(ok, share(np.clip(oh, 0, 1)) * g * np.abs(oh) / (c * cos_h), 0))
    t = np.linspace(0, 1, 2049)
    mean = np.array([np.trapezoid(np.interp(t, np.linspace(0, 1, STEPS), r) * 4 * t**3, t) for r in table])
    return np.minimum(table, 1.0), mean


class Tables:
    known = {}

    def __init__(self, share):
        table, mean = albedo(share)
        self.table, self.mean_of = mi.Float(table.ravel()), mi.Float(mean)

    @staticmethod
    def of(name, share):
        if name not in Tables.known:
            Tables.known[name] = Tables(share)
        return Tables.known[name]

    def place(self, t):
        at = dr.clip(t, 0, 1) * (STEPS - 1)
        step = dr.minimum(mi.UInt32(at), STEPS - 2)
        return step, at - mi.Float(step)

    def share(self, roughness, cosine):
        column, x = self.place(dr.sqrt(dr.maximum(cosine, 0)))
        row, y = self.place(roughness)

        def at(r):
            a = dr.gather(mi.Float, self.table, r * STEPS + column)
            return a + x * (dr.gather(mi.Float, self.table, r * STEPS + column + 1) - a)

        low = at(row)
        return low + y * (at(row + 1) - low)

    def mean(self, roughness):
        row, y = self.place(roughness)
        low = dr.gather(mi.Float, self.mean_of, row)
        return low + y * (dr.gather(mi.Float, self.mean_of, row + 1) - low)


LOOKS = []  # what a BSDF is made of, by number: Mitsuba's properties hold no Python objects


class Same(mi.BSDF):
    """Matte and glossy surfaces with their maps, seen from both sides."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        look = LOOKS[int(props["look"])]
        self.look = look
        self.color, self.surface, self.normals = look["color"], look["surface"], look["normals"]
        self.matte, self.metallic, self.roughness, self.ior = look["matte"], look["metallic"], look["roughness"], look["ior"]
        self.checker = look["checker"]
        if not self.matte:
            self.coat = Tables.of(("coat", self.ior), lambda c: fresnel(c, self.ior))
            self.perfect = Tables.of("perfect", lambda c: np.ones_like(c))
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        if not self.matte and self.surface is None and self.roughness < SMOOTH:
            flags |= mi.BSDFFlags.DeltaReflection
        self.m_components = [flags]
        self.m_flags = flags

    def surface_at(self, si, active):
        """-> the frame, the normal of what is seen, and the numbers there."""
        seen = si.to_world(si.wi)
        side = dr.select(dr.dot(si.n, seen) < 0, mi.Float(-1), mi.Float(1))
        outward = si.n * side
        smooth = dr.select(dr.dot(si.sh_frame.n, si.n) > 0, si.sh_frame.n, si.n)
        normal = dr.select(dr.dot(smooth * side, seen) > 1e-3, smooth * side, outward)
        if self.normals is not None:
            s = dr.normalize(si.dp_du - smooth * dr.dot(smooth, si.dp_du))
            t = -si.dp_dv
            t = t - smooth * dr.dot(smooth, t)
            t = dr.normalize(t - s * dr.dot(s, t))
            texel = self.normals.eval_3(si, active) * 2 - 1
            bent = dr.normalize(s * texel.x + t * texel.y + smooth * texel.z) * side
            ok = (dr.dot(bent, seen) > 1e-3) & dr.isfinite(bent.x)
            normal = dr.select(ok, bent, normal)
        color = self.color.eval(si, active)
        if self.checker is not None:
            a, b = [{"x": si.p.x, "y": si.p.y, "z": si.p.z}[axis] for axis in self.checker["axes"]]
            side_length = self.checker["side"]
            tile = mi.Int32(dr.floor(a / side_length)) + mi.Int32(dr.floor(b / side_length))
            first, second = [mi.Color3f(c) for c in self.checker["colors"]]
            color = dr.select((tile & 1) == 0, first, second)
        metallic, roughness = mi.Float(self.metallic), mi.Float(self.roughness)
        if self.surface is not None:
            texel = self.surface.eval_3(si, active)
            metallic, roughness = metallic * texel.z, roughness * texel.y
        return mi.Frame3f(normal), outward, seen, dr.clip(color, 0, 1), metallic, dr.clip(roughness, 0, 1)

    def facets(self, o, cosine, color, metallic, roughness):
        smooth = roughness < SMOOTH
        lost = dr.select(smooth, 0, 1 / dr.maximum(self.perfect.share(roughness, o.z), 0.05) - 1)
        c = dr.clip(cosine, 0, 1)
        metal = (color + (1 - color) * (1 - c) ** 5) * (1 + color * lost)
        return dr.lerp(mi.Color3f(fresnel(c, self.ior)), metal, metallic)

    def base(self, o, color, metallic, roughness):
        entering = dr.maximum(1 - self.coat.mean(roughness), 1e-3)
        return color * ((1 - metallic) * (1 - self.coat.share(roughness, o.z)) / entering)

    def chance(self, o, color, metallic, roughness):
        f = dr.maximum(dr.max(self.facets(o, o.z, color, metallic, roughness)), self.coat.share(roughness, o.z) * (1 - metallic))
        b = dr.max(self.base(o, color, metallic, roughness))
        return dr.select(b <= 0, 1, dr.clip(f / (f + b), 0.1, 0.9))

    def share_and_density(self, o, i, color, metallic, roughness):
        below = self.base(o, color, metallic, roughness) * ((1 - self.coat.share(roughness, i.z)) * i.z / dr.pi)
        alpha = roughness * roughness
        h = dr.normalize(o + i)
        t = alpha * alpha * h.z * h.z + h.x * h.x + h.y * h.y
        d = alpha * alpha / (dr.pi * t * t)

        def lam(w):
            return 0.5 * (dr.sqrt(1 + alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1)

        reflected = d / (4 * o.z * (1 + lam(o) + lam(i)))
        density = d / (4 * o.z * (1 + lam(o)))
        smooth = roughness < SMOOTH
        f = self.facets(o, dr.dot(o, h), color, metallic, roughness)
        chance = self.chance(o, color, metallic, roughness)
        value = below + dr.select(smooth, 0, f * reflected)
        return value, chance * dr.select(smooth, 0, density) + (1 - chance) * i.z / dr.pi, chance

    def eval_pdf(self, ctx, si, wo, active=True):
        frame, outward, seen, color, metallic, roughness = self.surface_at(si, active)
        world = si.to_world(wo)
        o, i = frame.to_local(seen), frame.to_local(world)
        ok = active & (o.z > 0) & (i.z > 0) & (dr.dot(world, outward) > 0)
        o.z, i.z = dr.maximum(o.z, 1e-6), dr.maximum(i.z, 1e-6)
        if self.matte:
            value, density = color * (i.z / dr.pi), i.z / dr.pi
        else:
            value, density, _ = self.share_and_density(o, i, color, metallic, roughness)
        return dr.select(ok, value, 0), dr.select(ok, density, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        frame, outward, seen, color, metallic, roughness = self.surface_at(si, active)
        o = frame.to_local(seen)
        o.z = dr.maximum(o.z, 1e-6)
        i = mi.warp.square_to_cosine_hemisphere(sample2)
        bs = mi.BSDFSample3f()
        is_delta = mi.Bool(False)
        if not self.matte:
            chance = self.chance(o, color, metallic, roughness)
            alpha = dr.maximum(roughness * roughness, 1e-5)
            # Facets that are seen (Heitz 2018)
            st = dr.normalize(mi.Vector3f(alpha * o.x, alpha * o.y, o.z))
            across = st.x * st.x + st.y * st.y
            t1 = dr.select(across > 0, mi.Vector3f(-st.y, st.x, 0) / dr.sqrt(dr.maximum(across, 1e-20)), mi.Vector3f(1, 0, 0))
            t2 = dr.cross(st, t1)
            r, phi = dr.sqrt(sample2.x), 2 * dr.pi * sample2.y
            p1, p2 = r * dr.cos(phi), r * dr.sin(phi)
            s = 0.5 * (1 + st.z)
            p2 = (1 - s) * dr.sqrt(dr.maximum(1 - p1 * p1, 0)) + s * p2
            n = p1 * t1 + p2 * t2 + dr.sqrt(dr.maximum(1 - p1 * p1 - p2 * p2, 0)) * st
            h = dr.normalize(mi.Vector3f(alpha * n.x, alpha * n.y, dr.maximum(n.z, 0)))
            takes = sample1 < chance
            is_delta = takes & (roughness < SMOOTH)
            glossy = dr.normalize(2 * dr.dot(o, h) * h - o)
            i = dr.select(takes, dr.select(roughness < SMOOTH, mi.Vector3f(-o.x, -o.y, o.z), glossy), i)
        world = frame.to_world(i)
        ok = active & (i.z > 0) & (dr.dot(world, outward) > 0)
        i.z = dr.maximum(i.z, 1e-6)
        if self.matte:
            weight, density = color, i.z / dr.pi
        else:
            value, density, chance = self.share_and_density(o, i, color, metallic, roughness)
            weight = dr.select(is_delta, self.facets(o, o.z, color, metallic, roughness) / chance, value / density)
            density = dr.select(is_delta, 1, density)
            ok &= density > 0
        bs.wo = si.to_local(world)
        bs.pdf = dr.select(ok, density, 0)
        bs.eta = 1.0
        bs.sampled_component = 0
        bs.sampled_type = dr.select(is_delta, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.GlossyReflection))
        return bs, dr.select(ok, weight, 0)

    def to_string(self):
        return "Same[]"


mi.register_bsdf("same", lambda props: Same(props))


def bitmap(file, raw, channel=None, scale=1.0):
    """A texture; of one channel, times a factor, on request."""
    if file is None:
        return None
    if channel is None:
        return {"type": "bitmap", "filename": file, "raw": raw, "wrap_mode": "repeat"}
    texels = np.array(mi.Bitmap(file).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False))
    if mi.Bitmap(file).srgb_gamma():
        # Bytes as they are: undo the curve that was taken for granted
        texels = np.array(mi.Bitmap(file).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True)) / np.float32(255)
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(texels[..., channel : channel + 1] * scale)), "raw": True}


def alpha_of(file):
    from PIL import Image

    rgba = np.asarray(Image.open(file).convert("RGBA"), np.float32) / 255
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(rgba[..., 3:])), "raw": True}


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values[:3]]}


def tinted(m):
    """Base colour as a texture of Mitsuba."""
    if m.color_map is None:
        return rgb(m.color)
    if max(abs(c - 1) for c in m.color) > 1e-6:
        raise SystemExit(f"{m.name}: a base colour factor over a texture is not done here")
    return bitmap(m.color_map, False)


def bsdf(m, model):
    if m.kind == "glass":
        if m.ior == 1:
            raise SystemExit("glass of index 1 is not done here")
        return {"type": "dielectric", "int_ior": m.ior, "ext_ior": 1.0, "specular_transmittance": rgb(m.color)}
    if model == "same":
        textures = [mi.load_dict(t) if t else None for t in (tinted(m), bitmap(m.surface_map, True), bitmap(m.normal_map, True))]
        LOOKS.append(
            dict(
                zip(("color", "surface", "normals"), textures),
                matte=m.kind == "matte",
                metallic=m.metallic,
                roughness=m.roughness,
                ior=m.ior,
                checker=m.checker,
            )
        )
        made = {"type": "same", "look": len(LOOKS) - 1}
    else:
        color = tinted(m)
        if m.checker is not None:
            raise SystemExit("a checker in the world needs the model `same`")
        if m.kind == "matte":
            made = {"type": "diffuse", "reflectance": color}
        else:
            made = {
                "type": "principled",
                "base_color": color,
                "metallic": bitmap(m.surface_map, True, 2, m.metallic) or m.metallic,
                "roughness": bitmap(m.surface_map, True, 1, m.roughness) or max(m.roughness, 0.02),
                "eta": m.ior,
            }
        if m.normal_map is not None:
            made = {"type": "normalmap", "normalmap": bitmap(m.normal_map, True), "bsdf": made}
        made = {"type": "twosided", "bsdf": made}
    if m.alpha == "BLEND" and m.color_map is not None:
        made = {"type": "mask", "opacity": alpha_of(m.color_map), "bsdf": made}
    return made


def mesh(part, name, made, folder):
    """A mesh through a PLY file."""
    m = mi.Mesh(name, len(part.V), len(part.F), has_vertex_normals=part.N is not None, has_vertex_texcoords=part.UV is not None)
    p = mi.traverse(m)
    p["vertex_positions"] = mi.Float(np.asarray(part.V, np.float32).ravel())
    p["faces"] = mi.UInt32(np.asarray(part.F, np.uint32).ravel())
    if part.N is not None:
        p["vertex_normals"] = mi.Float(np.asarray(part.N, np.float32).ravel())
    if part.UV is not None:
        p["vertex_texcoords"] = mi.Float(np.asarray(part.UV, np.float32).ravel())
    p.update()
    os.makedirs(folder, exist_ok=True)
    file = os.path.join(folder, f"{name}.ply")
    m.write_ply(file)
    return {"type": "ply", "filename": file, "bsdf": made, "face_normals": part.N is None}


def build(parts, view, model, folder, sky=(0, 0, 0), suns=()):
    """-> a scene. view: position, look_at, fov_deg, size, and perhaps radius and focus of a thin lens."""
    scene = {"type": "scene", "sensor": sensor(view)}
    if max(sky) > 0:
        scene["sky"] = {"type": "constant", "radiance": rgb(sky)}
    made = {}
    for k, part in enumerate(parts):
        m = part.material
        if id(m) not in made:
            made[id(m)] = mi.load_dict(bsdf(m, model))
        shape = mesh(part, f"part{k}", made[id(m)], folder)
        if any(m.emission):
            shape["emitter"] = {"type": "area", "radiance": rgb(m.emission)}
            # Both sides glow, Mitsuba's area lights on one: put another just behind it (far enough for f32)
            other = type(part)(part.V - 2e-6 * np.abs(part.V).max() * normals(part), part.F[:, ::-1], None if part.N is None else -part.N, part.UV, m)
            back = mesh(other, f"part{k}back", made[id(m)], folder)
            back["emitter"] = {"type": "area", "radiance": rgb(m.emission)}
            scene[f"part{k}back"] = back
        scene[f"part{k}"] = shape
    for k, (toward, strength) in enumerate(suns):
        irradiance = rgb([np.pi * x for x in strength])
        scene[f"sun{k}"] = {"type": "directional", "direction": [-float(x) for x in toward], "irradiance": irradiance}
    return mi.load_dict(scene)


def normals(part):
    """A unit normal per vertex, by the triangles it belongs to."""
    p = part.V[part.F]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    out = np.zeros_like(part.V)
    for k in range(3):
        np.add.at(out, part.F[:, k], n)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-30)


def sensor(view):
    width, height = view["size"]
    look = mi.ScalarTransform4f().look_at(list(view["position"]), list(view["look_at"]), list(view.get("up", [0, 1, 0])))
    made = {
        "type": "thinlens" if view.get("radius") else "perspective",
        "to_world": look,
        "fov": float(view["fov_deg"]),
        "fov_axis": "x",
        "near_clip": 1e-3 * float(view.get("scale", 1)),
        "far_clip": 1e5 * float(view.get("scale", 1)),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        "sampler": {"type": view.get("sampler", "independent"), "sample_count": 16},
    }
    if view.get("radius"):
        made |= {"aperture_radius": float(view["radius"]), "focus_distance": float(view["focus"])}
    return made


def path_tracer(bounces):
    """The same series as the project's: light goes from surface to surface so often; no path ends by chance."""
    return mi.load_dict({"type": "path", "max_depth": bounces + 1, "rr_depth": 100000})


def render(scene, integrator, spp, seed, most=64):
    """-> H x W x 3, in passes that bound memory."""
    passes = max(1, -(-spp // most))
    each = spp // passes
    total = 0
    for k in range(passes):
        total = total + np.array(mi.render(scene, integrator=integrator, spp=each, seed=seed * 100003 + k), np.float64)
    return total / passes
