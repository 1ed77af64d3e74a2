"""Writes the pictures beside it, with the libraries that other programs write theirs with.

    python3 -m venv /tmp/v && /tmp/v/bin/pip install OpenEXR==3.5.3 Pillow==13.0.0 numpy piexif==1.1.3
    /tmp/v/bin/python make.py

Each picture is 8 x 4 texels of the ramp below; `../foreign.rs` says what is right for each file.
"""

import io
import os
import struct
import zlib

import numpy as np
import OpenEXR
import piexif
from PIL import Image, ImageCms

HERE = os.path.dirname(os.path.abspath(__file__))
W, H = 8, 4


def ramp(kind=np.float32):
    """Red grows to the right, green downwards; blue is 1/4."""
    y, x = np.mgrid[0:H, 0:W]
    return [(x / 8).astype(kind), (y / 4).astype(kind), np.full((H, W), 0.25, kind)]


def exr(name, parts, **header):
    """`parts`: a list of (name, header, channels)."""
    made = []
    for part, own, channels in parts:
        # A dictionary of its own: the library puts its objects into it.
        channels = dict(channels)
        head = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **header, **own}
        if part:
            head["name"] = part
        made.append(OpenEXR.Part(head, channels, part) if part else OpenEXR.Part(head, channels))
    OpenEXR.File(made).write(os.path.join(HERE, name))


def box(x0, y0, x1, y1):
    return (np.array([x0, y0], np.int32), np.array([x1, y1], np.int32))


r, g, b = ramp()
rgb = {"R": r, "G": g, "B": b}
flat = np.full((H, W), 0.9, np.float32)
exr("layers.exr", [("", {}, {**rgb, "Albedo.R": flat, "Albedo.G": flat, "Albedo.B": flat})])
passes = {f"View Layer.{layer}.{c}": v for layer, chans in (("AO", dict.fromkeys("RGB", flat)), ("Combined", rgb)) for c, v in chans.items()}
exr("passes.exr", [("", {}, passes)])
exr("ambiguous.exr", [("", {}, {f"{n}.{c}": v for n in ("Diffuse", "Specular") for c, v in rgb.items()})])
exr("parts.exr", [("depth", {}, {"Z": flat}), ("picture", {}, rgb)])
exr("rec2020.exr", [("", {}, {c: np.full((H, W), v, np.float32) for c, v in zip("RGB", (0.5, 0.2, 0.1))})],
    chromaticities=(0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329))
exr("acescg.exr", [("", {}, {c: np.full((H, W), v, np.float32) for c, v in zip("RGB", (0.5, 0.2, 0.1))})],
    chromaticities=(0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767))
exr("half.exr", [("", {}, dict(zip("RGB", ramp(np.float16))))])
exr("uint.exr", [("", {}, {c: (8 * v).astype(np.uint32) for c, v in rgb.items()})])
exr("grey.exr", [("", {}, {"Y": r})])
exr("depth.exr", [("", {}, {"Z": r})])
exr("chroma.exr", [("", {}, {"Y": np.full((H, W), 0.5, np.float32), "RY": r * 0, "BY": r * 0})])
exr("alpha_z.exr", [("", {}, {"A": flat, "Z": flat})])
exr("odd.exr", [("", {}, {"R": np.where(r == 0.5, np.inf, r), "G": np.where(g == 0.5, np.nan, g), "B": -b})])
# Data within a display window of 16 x 8, and data that go beyond one of 4 x 2; windows need not begin at 0.
exr("cropped.exr", [("", {"dataWindow": box(6, 3, 13, 6), "displayWindow": box(-2, -1, 13, 6)}, rgb)])
exr("overscan.exr", [("", {"dataWindow": box(-2, -1, 5, 2), "displayWindow": box(0, 0, 3, 1)}, rgb)])
exr("outside.exr", [("", {"dataWindow": box(100, 0, 107, 3), "displayWindow": box(0, 0, 7, 3)}, rgb)])
# Large enough that every method compresses: the same ramp at 64 x 32.
large = {"R": np.repeat(np.repeat(r, 8, 0), 8, 1), "G": np.repeat(np.repeat(g, 8, 0), 8, 1), "B": np.full((32, 64), 0.25)}
large = {c: v.astype(np.float16) for c, v in large.items()}
exr("compression_no.exr", [("", {"compression": OpenEXR.NO_COMPRESSION}, rgb)])
for name in ("RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K32"):
    exr(f"compression_{name.lower()}.exr", [("", {"compression": getattr(OpenEXR, f"{name}_COMPRESSION")}, large)])
deep = np.empty((H, W), dtype=object)
for i in range(H * W):
    deep[i // W, i % W] = np.array([0.5, 0.25], np.float32)
exr("deep.exr", [("", {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}, {"R": deep, "G": deep, "B": deep})])
tiles = OpenEXR.TileDescription()
tiles.xSize = tiles.ySize = 4
tiles.mode = OpenEXR.LevelMode.ONE_LEVEL
exr("tiled.exr", [("", {"type": OpenEXR.tiledimage, "tiles": tiles}, rgb)])

# PNG and JPEG.
bytes_ = np.stack([np.round(255 * v) for v in (r, g, b)], -1).astype(np.uint8)
picture = Image.fromarray(bytes_)


def save(image, name, **how):
    image.save(os.path.join(HERE, name), **how)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def with_chunk(name, kind, data):
    out = io.BytesIO()
    picture.save(out, "PNG")
    png = out.getvalue()
    open(os.path.join(HERE, name), "wb").write(png[:33] + chunk(kind, data) + png[33:])


save(picture, "plain.png")
save(picture.quantize(32), "palette.png")
save(picture.convert("L"), "grey.png")
save(picture.convert("L").point(lambda v: 255 * (v > 60), "1"), "one_bit.png")
save(picture.convert("RGBA"), "alpha.png")
save(Image.fromarray((r * 65535).astype(np.uint16)), "grey16.png")
with_chunk("gama_linear.png", b"gAMA", struct.pack(">I", 100000))
with_chunk("gama_srgb.png", b"gAMA", struct.pack(">I", 45455))
with_chunk("srgb.png", b"sRGB", b"\0")
with_chunk("cicp_p3.png", b"cICP", bytes([12, 13, 0, 1]))
with_chunk("chrm.png", b"cHRM", struct.pack(">8I", 31270, 32900, 70800, 29200, 17000, 79700, 13100, 4600))
# A profile of which only the description is whole: header, one tag.
text = b"Display P3\0"
desc = b"desc" + bytes(4) + struct.pack(">I", len(text)) + text
profile = struct.pack(">I", 144 + len(desc)) + bytes(124) + struct.pack(">I", 1) + b"desc" + struct.pack(">II", 144, len(desc)) + desc
save(picture, "icc_p3.png", icc_profile=profile)
save(picture, "icc_srgb.png", icc_profile=ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
save(picture, "animated.png", save_all=True, append_images=[Image.new("RGB", (W, H))])

big = picture.resize((32, 16), Image.NEAREST)
how = {"quality": 95, "subsampling": 0}
save(big, "plain.jpg", **how)
save(big, "progressive.jpg", progressive=True, **how)
save(big.convert("L"), "grey.jpg", **how)
save(big.convert("CMYK"), "cmyk.jpg", **how)
save(big, "icc_p3.jpg", icc_profile=profile, **how)
exif = piexif.dump({"0th": {piexif.ImageIFD.Orientation: 6}})
# Stored as a camera does that was turned: upright it is the plain picture.
save(big.transpose(Image.ROTATE_90), "turned.jpg", exif=exif, **how)
