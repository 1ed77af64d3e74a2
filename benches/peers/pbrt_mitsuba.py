"""States a pbrt-v4 scene for Mitsuba 3, from pbrt's own documentation, without anything of bhs' reader: for pbrt_in_mitsuba.py.

What Mitsuba cannot state exactly raises NotStated."""

import math
import os

import numpy as np

from pbrt_meaning import GRID, diagonal, look_at, matrix, rotate, square_from_sphere, table, translation, under_coat
from pbrt_shapes import loop_subdivision, read_ply, write_ply
from pbrt_text import Directive, NotStated

class Reader:
    """Follows the directives of a file and gathers what is to be given to `mi.load_dict`."""

    def __init__(self, mi, spectra, folder, scratch):
        self.mi, self.spectra, self.folder, self.scratch = mi, spectra, folder, scratch
        self.scene, self.textures, self.named, self.objects = {"type": "scene"}, {}, {}, {}
        self.camera = self.group = None
        self.depth, self.size, self.iso = 5, (128, 72), 100
        self.state = dict(ctm=np.eye(4), material=Directive("Material", ["diffuse"]), light=None, flip=False)
        self.stack, self.systems = [], {}
        self.bsdfs = {}

    # ----------------------------------------------------------------------------------------------------------- directives

    def read(self, found):
        for d in found:
            getattr(self, "on_" + d.keyword, self.unknown)(d)
        return self

    def unknown(self, d):
        raise NotStated(d.keyword)

    def post(self, m):
        self.state["ctm"] = self.state["ctm"] @ m

    def on_Transform(self, d): self.state["ctm"] = matrix(d.args)
    def on_ConcatTransform(self, d): self.post(matrix(d.args))
    def on_Identity(self, d): self.state["ctm"] = np.eye(4)
    def on_Translate(self, d): self.post(translation(*d.args))
    def on_Scale(self, d): self.post(diagonal(*d.args))
    def on_Rotate(self, d): self.post(rotate(d.args[0], d.args[1:]))
    def on_LookAt(self, d): self.post(look_at(d.args[:3], d.args[3:6], d.args[6:]))
    def on_CoordinateSystem(self, d): self.systems[d.args[0]] = self.state["ctm"]
    def on_CoordSysTransform(self, d): self.state["ctm"] = self.systems[d.args[0]]
    def on_ReverseOrientation(self, d): self.state["flip"] = not self.state["flip"]
    def on_PixelFilter(self, d): pass
    def on_Sampler(self, d): pass

    def on_Film(self, d):
        self.size, self.iso = (d.get("xresolution"), d.get("yresolution")), d.get("iso", 100)

    def on_LightTransport(self, d):
        self.depth = d.get("maxdepth", 5)

    def on_AttributeBegin(self, d): self.stack.append(dict(self.state))
    def on_AttributeEnd(self, d): self.state = self.stack.pop()
    on_TransformBegin, on_TransformEnd = on_AttributeBegin, on_AttributeEnd

    def on_WorldBegin(self, d):
        self.state["ctm"] = np.eye(4)

    def on_Camera(self, d):
        if d.args[0] != "perspective" or "screenwindow" in d.params:
            raise NotStated(f"the camera {d.args[0]}, or its screen window")
        self.systems["camera"] = self.world_from_camera = np.linalg.inv(self.state["ctm"])
        self.camera = d

    def on_ObjectBegin(self, d):
        self.stack.append(dict(self.state))
        self.group = self.objects.setdefault(d.args[0], [])

    def on_ObjectEnd(self, d):
        self.state, self.group = self.stack.pop(), None

    def on_ObjectInstance(self, d):
        for shape, state in self.objects[d.args[0]]:
            self.add(shape, {**state, "ctm": self.state["ctm"] @ state["ctm"]})

    def on_Texture(self, d):
        self.textures[d.args[0]] = d

    def on_MakeNamedMaterial(self, d):
        self.named[d.args[0]] = Directive("Material", [d.get("type")], d.params)

    def on_Material(self, d): self.state["material"] = d
    def on_NamedMaterial(self, d): self.state["material"] = self.named[d.args[0]]
    def on_AreaLightSource(self, d): self.state["light"] = d

    def on_Shape(self, d):
        if self.group is None:
            self.add(d, self.state)
        else:
            self.group.append((d, dict(self.state)))

    # --------------------------------------------------------------------------------------------------- textures, materials

    def texture(self, d, name, default, is_float=False):
        """A parameter that may be a texture."""
        if d.kind(name) != "texture":
            values = self.spectra.number(d, name, default, self.folder, share=True)
            return float(values[0]) if is_float else table(GRID, values)
        t = self.textures[d.get(name)]
        if t.get("mapping", "uv") != "uv":
            raise NotStated("a mapping of textures")
        u, v = t.get("uscale", 1), t.get("vscale", 1)
        du, dv = t.get("udelta", 0), t.get("vdelta", 0)
        place = self.mi.ScalarTransform4f
        if t.args[2] == "imagemap":
            if t.get("scale", 1) != 1 or t.get("invert") or t.get("encoding", "sRGB") != "sRGB":
                raise NotStated("an imagemap with scale, invert, or encoding")
            wrap = {"repeat": "repeat", "clamp": "clamp"}[t.get("wrap", "repeat")]
            # The first row of a picture is at the top here and there, where v is 1 in pbrt and 0 in Mitsuba.
            return {"type": "bitmap", "filename": os.path.join(self.folder, t.get("filename")), "wrap_mode": wrap,
                    "filter_type": "nearest" if t.get("filter") == "point" else "bilinear",
                    "to_uv": place().translate([du, 1 - dv, 0]).scale([u, -v, 1])}
        if t.args[2] == "checkerboard":
            # A period is two fields.
            one, two = (self.texture(t, n, [x], False) for n, x in (("tex1", 1), ("tex2", 0)))
            return {"type": "checkerboard", "color0": one, "color1": two,
                    "to_uv": place().translate([du / 2, dv / 2, 0]).scale([u / 2, v / 2, 1])}
        if t.args[2] == "constant":
            return self.texture(t, "value", [1], is_float)
        raise NotStated(f"the texture {t.args[2]}")

    def alphas(self, d, prefix=""):
        """The two alphas of a rough surface; none where pbrt counts it as smooth."""
        out = []
        for name in ("uroughness", "vroughness"):
            if "texture" in (d.kind(prefix + name), d.kind(prefix + "roughness")):
                raise NotStated("a texture of roughness")
            r = d.get(prefix + name, d.get(prefix + "roughness", 0))
            out.append(math.sqrt(r) if d.get("remaproughness", True) else r)
        return None if max(out) < 1e-3 else [max(a, 1e-4) for a in out]

    def bsdf(self, d):
        """The material, once for all its shapes."""
        if id(d) not in self.bsdfs:
            self.bsdfs[id(d)] = (d, self.mi.load_dict(self.material(d)))
        return self.bsdfs[id(d)][1]

    def material(self, d):
        kind, spectra = d.args[0], self.spectra
        both = lambda bsdf: {"type": "twosided", "bsdf": bsdf}
        rough = lambda a: {"distribution": "ggx", "alpha_u": a[0], "alpha_v": a[1]}
        if kind == "diffuse":
            t = self.textures[d.get("reflectance")] if d.kind("reflectance") == "texture" else None
            if t and t.args[2] == "scale":
                # A darker picture is some of it and some of black.
                part = self.texture(t, "scale", [1], True)
                inner = self.material(Directive("Material", ["diffuse"], {"reflectance": t.params["tex"]}))
                black = both({"type": "diffuse", "reflectance": table(GRID, np.zeros(GRID.shape))})
                if isinstance(part, float) and part <= 1:
                    return self.blend(part, black, inner)
            return both({"type": "diffuse", "reflectance": self.texture(d, "reflectance", [0.5])})
        if kind == "conductor":
            alpha = self.alphas(d)
            if "reflectance" in d.params:
                r = np.clip(spectra.number(d, "reflectance", [1], self.folder, share=True), 0, 0.9999)
                eta, k = np.ones(GRID.shape), 2 * np.sqrt(r) / np.sqrt(1 - r)
            else:
                eta, k = (spectra.number(d, n, f"metal-Cu-{n}", self.folder) for n in ("eta", "k"))
            metal = {"eta": table(GRID, eta), "k": table(GRID, k)}
            return both({"type": "roughconductor", **rough(alpha), **metal} if alpha else {"type": "conductor", **metal})
        if kind in ("dielectric", "thindielectric", "coateddiffuse"):
            eta = spectra.number(d, "eta", [1.5], self.folder)
            if np.ptp(eta):
                raise NotStated("glass with dispersion")
            glass = {"int_ior": float(eta[0]), "ext_ior": 1.0}
            if kind == "thindielectric":
                return {"type": "thindielectric", **glass}
            alpha = self.alphas(d)
            if kind == "dielectric":
                return {"type": "roughdielectric", **rough(alpha), **glass} if alpha else {"type": "dielectric", **glass}
            if (alpha and alpha[0] != alpha[1]) or np.any(np.array(d.params.get("albedo", (0, [0]))[1]) != 0):
                raise NotStated("a coat that scatters, or of two roughnesses")
            thickness = d.get("thickness", 0.01)
            if thickness and d.kind("reflectance") == "texture":
                raise NotStated("a coat that absorbs, over a picture")
            if thickness:
                share = spectra.number(d, "reflectance", [0.5], self.folder, share=True)
                ground = table(GRID, under_coat(share, float(eta[0]), thickness))
            else:
                ground = self.texture(d, "reflectance", [0.5])
            ground = {"diffuse_reflectance": ground, "nonlinear": True, **glass}
            return both({"type": "roughplastic", "distribution": "ggx", "alpha": alpha[0], **ground} if alpha else {"type": "plastic", **ground})
        if kind == "mix":
            first, second = (self.material(self.named[n]) for n in d.values("materials"))
            return self.blend(self.texture(d, "amount", [0.5], True), first, second)
        if kind in ("interface", ""):
            return {"type": "null"}
        raise NotStated(f"the material {kind}")

    def blend(self, weight, first, second):
        """A mix, two-sided as a whole."""
        if {"conductor", "dielectric", "thindielectric", "plastic"} & {m.get("bsdf", m)["type"] for m in (first, second)}:
            # Mitsuba 3.9.1's `path` takes the light that it mirrors for one that its own sampling of lights finds too, and counts too little.
            raise NotStated("a mix with a smooth mirror")
        sides = [m["type"] == "twosided" for m in (first, second)]
        if any(sides) and not all(sides):
            raise NotStated("a mix of something clear and something opaque")
        inner = {"type": "blendbsdf", "weight": weight, "first": first["bsdf"] if all(sides) else first, "second": second["bsdf"] if all(sides) else second}
        return {"type": "twosided", "bsdf": inner} if all(sides) else inner

    # --------------------------------------------------------------------------------------------------------- lights, shapes

    def emission(self, d):
        if d.args[0] != "diffuse" or "filename" in d.params or "power" in d.params or d.get("twosided"):
            raise NotStated("an area light with a picture, `power`, or two sides")
        values = self.spectra.light(d, "L", self.folder) * d.get("scale", 1)
        return {"type": "area", "radiance": table(GRID, values)}

    def on_LightSource(self, d):
        kind, ctm, scale = d.args[0], self.state["ctm"], d.get("scale", 1)
        name = f"light{len(self.scene)}"
        if kind == "distant":
            to, start = np.array(d.params.get("to", (0, [0, 0, 1]))[1]), np.array(d.params.get("from", (0, [0, 0, 0]))[1])
            direction = ctm[:3, :3] @ (to - start)
            values = self.spectra.light(d, "L", self.folder) * scale * d.get("illuminance", 1)
            self.scene[name] = {"type": "directional", "direction": list(map(float, direction)), "irradiance": table(GRID, values)}
        elif kind == "infinite" and "filename" not in d.params:
            values = self.spectra.light(d, "L", self.folder) * scale * d.get("illuminance", math.pi) / math.pi
            self.scene[name] = {"type": "constant", "radiance": table(GRID, values)}
        elif kind == "infinite" and "illuminance" not in d.params:
            self.scene[name] = self.sky(os.path.join(self.folder, d.get("filename")), np.linalg.inv(ctm[:3, :3]), scale)
        else:
            raise NotStated(f"the light {kind}")

    def sky(self, path, light_from_world, scale, height=1024, finer=2):
        """A picture of the sky in Mitsuba's projection: +y up, the left edge at -z."""
        mi = self.mi
        picture = np.array(mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False))
        n = picture.shape[0]
        if picture.shape[1] != n:
            raise NotStated("a sky that is not square (an error in pbrt-v4)")
        width = 2 * height
        out = np.zeros((height, width, 3))
        for a in range(finer):
            for b in range(finer):
                theta = (np.arange(height) + (a + 0.5) / finer - 0.5) / (height - 1) * math.pi
                theta = np.clip(theta, 0, math.pi)[:, None]
                phi = (np.arange(width) + (b + 0.5) / finer)[None, :] / width * 2 * math.pi
                world = np.stack(np.broadcast_arrays(np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)))
                d = np.einsum("ij,jkl->ikl", light_from_world, world)
                u, v = square_from_sphere(d / np.linalg.norm(d, axis=0))
                out += picture[np.clip((v * n).astype(int), 0, n - 1), np.clip((u * n).astype(int), 0, n - 1)]
        # Mitsuba's white is its table of D65 over its own integral.
        white = mi.load_dict({"type": "d65"})
        its = np.array([float(np.ravel(np.array(self.d65_at(white, w)))[0]) for w in GRID])
        scale = scale / finer**2 / self.spectra.luminance(its)
        return {"type": "envmap", "bitmap": mi.Bitmap((out * scale).astype(np.float32))}

    def d65_at(self, white, wavelength):
        si = self.mi.SurfaceInteraction3f()
        si.wavelengths = self.mi.Spectrum(float(wavelength))
        return white.eval(si)

    def add(self, d, state):
        """A shape of Mitsuba's, in the world's coordinates."""
        kind, m, material = d.args[0], state["ctm"], state["material"]
        mirrored = np.linalg.det(m[:3, :3]) < 0
        turned = state["flip"] != mirrored  # pbrt turns the normals of shapes over
        if "alpha" in d.params and (d.kind("alpha") != "texture" or state["light"]):
            raise NotStated("`alpha` of a shape")
        shape = {"flip_normals": bool(turned)}
        if kind in ("sphere", "disk"):
            for n in ("zmin", "zmax", "phimax", "innerradius"):
                if n in d.params:
                    raise NotStated(f"a part of a {kind}")
            r = float(d.get("radius", 1))
            if kind == "sphere":
                lengths = np.linalg.norm(m[:3, :3], axis=0)
                if np.ptp(lengths) > 1e-5 * lengths.max():
                    raise NotStated("an ellipsoid")
                # A sphere that a transform mirrors keeps its outer side outside.
                shape = {"type": "sphere", "center": list(map(float, m[:3, 3])), "radius": r * float(lengths[0]), "flip_normals": bool(state["flip"])}
            else:
                place = m @ translation(0, 0, d.get("height", 0)) @ diagonal(r, r, 1) @ (diagonal(-1, 1, 1) if mirrored else np.eye(4))
                shape = {"type": "disk", "to_world": self.mi.ScalarTransform4f(place), "flip_normals": bool(state["flip"] != mirrored)}
        else:
            if kind == "trianglemesh":
                rows = lambda n, k: np.array(d.values(n), dtype=float).reshape(-1, k) if n in d.params else None
                points, faces = rows("P", 3), np.array(d.values("indices") if "indices" in d.params else [0, 1, 2]).reshape(-1, 3)
                normals, uv = rows("N", 3), rows("uv", 2)
            elif kind == "plymesh":
                points, faces, normals, uv = read_ply(os.path.join(self.folder, d.get("filename")))
            elif kind == "loopsubdiv":
                points, faces, normals = loop_subdivision(np.array(d.values("P"), dtype=float).reshape(-1, 3),
                                                          np.array(d.values("indices")).reshape(-1, 3), d.get("levels", 3))
                uv = None
            else:
                raise NotStated(f"the shape {kind}")
            points = points @ m[:3, :3].T + m[:3, 3]
            if normals is not None:
                normals = normals @ np.linalg.inv(m[:3, :3]) * (-1 if state["flip"] else 1)
                # The side of a face is that of its normals.
                face = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
                swap = (face * normals[faces].sum(axis=1)).sum(axis=1) < 0
            else:
                swap = np.full(len(faces), turned)
            faces = np.where(swap[:, None], faces[:, ::-1], faces)
            if state["light"]:
                normals = None
            path = os.path.join(self.scratch, f"{len(self.scene)}.ply")
            write_ply(path, points, faces, normals, uv)
            shape = {"type": "ply", "filename": path, "face_normals": normals is None}
        bsdf = self.bsdf(material)
        if "alpha" in d.params:
            bsdf = {"type": "mask", "opacity": self.texture(d, "alpha", [1], True), "bsdf": bsdf}
        if state["light"]:
            shape["emitter"] = self.emission(state["light"])
        self.scene[f"shape{len(self.scene)}"] = {**shape, "bsdf": bsdf}

    # ---------------------------------------------------------------------------------------------------------- the whole

    def finished(self, film):
        """What `mi.load_dict` takes, and whether the picture is to be mirrored: Mitsuba's cameras look with x to the left."""
        place = self.world_from_camera @ diagonal(-1, 1, 1)
        is_mirrored = np.linalg.det(place[:3, :3]) < 0
        if is_mirrored:
            place = self.world_from_camera
        lengths = np.linalg.norm(place[:3, :3], axis=0)
        if np.ptp(lengths) > 1e-3 * lengths.max():
            raise NotStated("a camera that is not scaled evenly")
        place = place @ diagonal(*(1 / lengths))
        lens = self.camera.get("lensradius", 0)
        sensor = {"type": "thinlens" if lens else "perspective", "fov": float(self.camera.get("fov", 90)), "fov_axis": "smaller",
                  "near_clip": 1e-3, "far_clip": 1e7, "to_world": self.mi.ScalarTransform4f(place), "sampler": {"type": "independent"}, "film": film}
        if lens:
            sensor.update(aperture_radius=float(lens), focus_distance=float(self.camera.get("focaldistance", 1e6)))
        integrator = {"type": "path", "max_depth": self.depth + 1, "rr_depth": 100000}
        return {**self.scene, "sensor": sensor, "integrator": integrator}, is_mirrored
