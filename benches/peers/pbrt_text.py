"""Reads pbrt-v4 files into directives, states what is to differ for a comparison, and writes them again: for pbrt_in_mitsuba.py."""

import gzip
import re
from dataclasses import dataclass, field
from pathlib import Path

TOKEN = re.compile(r'#[^\n]*|"[^"]*"|[\[\]]|[^\s\[\]"#]+')
TYPES = {"integer", "float", "point", "point2", "point3", "vector", "vector2", "vector3", "normal", "normal3", "spectrum", "rgb", "blackbody",
         "bool", "string", "texture"}
# How many words in quotes belong to a directive before its parameters, where that is not one.
WORDS = {"Texture": 3, "MediumInterface": 2, "CoordinateSystem": 1}
OPTIONS = {"Film", "Sampler", "PixelFilter", "Integrator", "Accelerator", "Option"}


class NotStated(Exception):
    """What a program here cannot state."""


@dataclass
class Directive:
    keyword: str
    args: list = field(default_factory=list)
    params: dict = field(default_factory=dict)  # name -> (type, values)

    def get(self, name, default=None):
        """The one value of a parameter."""
        return self.params[name][1][0] if name in self.params else default

    def kind(self, name):
        return self.params[name][0] if name in self.params else None

    def values(self, name):
        return self.params[name][1]

    def text(self):
        out = [self.keyword]
        word = lambda v: f'"{v}"' if isinstance(v, str) else ("true" if v else "false") if isinstance(v, bool) else repr(v)
        if self.keyword in ("Transform", "ConcatTransform"):
            return f"{self.keyword} [ {' '.join(map(word, self.args))} ]"
        out += map(word, self.args)
        out += [f'"{kind} {name}" [ {" ".join(map(word, values))} ]' for name, (kind, values) in self.params.items()]
        return " ".join(out)


def number(token):
    value = float(token)
    return int(value) if value == int(value) and re.fullmatch(r"[+-]?\d+", token) else value


def directives(path, folder=None):
    """The directives of a file, with those of the files it includes; names of files start at the folder of the first."""
    folder = folder or Path(path).parent
    data = Path(path).read_bytes()
    tokens = [t for t in TOKEN.findall((gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data).decode("latin1")) if t[0] != "#"]
    at, found = 0, []
    while at < len(tokens):
        d = Directive(tokens[at])
        if not d.keyword[0].isalpha():
            raise NotStated(f"`{d.keyword[:20]}` where a directive stands in {path}")
        at += 1
        words = WORDS.get(d.keyword, 1)
        while at < len(tokens):
            token = tokens[at]
            if token[0] == '"':
                inside = token[1:-1].split()
                if len(inside) != 2 or inside[0] not in TYPES or (len(d.args) < words and d.keyword not in OPTIONS | {"Camera", "Attribute"} and not d.args):
                    d.args.append(token[1:-1])
                    at += 1
                    continue
                at += 1
                values = []
                if tokens[at] == "[":
                    end = tokens.index("]", at)
                    raw, at = tokens[at + 1:end], end + 1
                else:
                    raw, at = [tokens[at]], at + 1
                for v in raw:
                    v = v.strip('"') if inside[0] in ("bool",) else v
                    values.append(v == "true" if inside[0] == "bool" else v[1:-1] if v[0] == '"' else number(v))
                d.params[inside[1]] = (inside[0], values)
            elif token in "[]":
                at += 1
            elif token[0] in "+-.0123456789":
                d.args.append(number(token))
                at += 1
            else:
                break
        if d.keyword == "Include":
            found += directives(folder / d.args[0], folder)
        elif d.keyword == "Import":
            raise NotStated("Import")
        else:
            found.append(d)
    return found


# ------------------------------------------------------------------------------------------- what is other than in the file

def as_diffuse(d, named):
    """Makes any material `diffuse`, with its colour where it has one."""
    colour = next((d.params[n] for n in ("reflectance", "color") if n in d.params), ("rgb", [0.5, 0.5, 0.5]))
    d.params = {"type": ("string", ["diffuse"])} if named else {}
    d.args = d.args if named else ["diffuse"]
    d.params["reflectance"] = colour


def prepared(found, size, depth):
    """The same scene with the options of the comparison; and what else is other than in the file: text -> how often."""
    changed = {}
    count = lambda what: changed.__setitem__(what, changed.get(what, 0) + 1)
    out, film = [], {}
    for d in found:
        if d.keyword in OPTIONS:
            film = d.params if d.keyword == "Film" else film
            continue
        if d.keyword in ("MediumInterface", "MakeNamedMedium"):
            if d.keyword == "MakeNamedMedium":
                count("medium left out")
            continue
        d = Directive(d.keyword, list(d.args), dict(d.params))
        if d.keyword in ("Material", "MakeNamedMaterial"):
            named = d.keyword == "MakeNamedMaterial"
            kind = d.get("type") if named else d.args[0]
            for name in ("displacement", "normalmap"):
                if d.params.pop(name, None):
                    count(f"{name} left out")
            if kind == "coateddiffuse" and d.get("thickness", 0.01) != 0 and "texture" in (d.kind("reflectance"), d.kind("thickness")):
                d.params["thickness"] = ("float", [0])
                count("`coateddiffuse` with a picture with thickness 0")
            if kind in ("coatedconductor", "diffusetransmission", "hair", "measured", "subsurface"):
                as_diffuse(d, named)
                count(f"`{kind}` as `diffuse`")
        out.append(d)
    width, height = size
    options = [
        Directive("Film", ["rgb"], {"xresolution": ("integer", [width]), "yresolution": ("integer", [height])}),
        Directive("PixelFilter", ["box"]),
        Directive("Sampler", ["sobol"], {"pixelsamples": ("integer", [16])}),
        Directive("Integrator", ["path"], {"maxdepth": ("integer", [depth])}),
    ]
    for name in ("iso",):
        if name in film:
            options[0].params[name] = film[name]
    return options + out, changed


def picture_size(found, width, block):
    """`width` pixels across the longer side, of the film's shape, in whole blocks."""
    film = next((d for d in found if d.keyword == "Film"), Directive("Film"))
    x, y = film.get("xresolution", 1280), film.get("yresolution", 720)
    scale = width / max(x, y)
    return tuple(max(1, round(v * scale / block)) * block for v in (x, y))


def written(found):
    return "\n".join(d.text() for d in found) + "\n"
