#!/usr/bin/env python3
"""Large files: how long bhs takes to be ready to render them, and with how much memory.

    benches/load.py target/release/bhs [--scale 1] [--only ply,gltf,meshes,hair]

Makes a PLY file of 1 GB, a GLB file of 500 MB, a scene of 10,000 PLY files and one of 100,000 curves in a temporary folder, renders each at
16x12 pixels with one sample, and prints a table for docs/performance.md: seconds and processor seconds until the first ray, peak memory, and that
over the bytes of the meshes as they are in memory (positions, normals and texture coordinates in single precision, and indices). `--scale 0.5`
makes all half as large: time is linear if it halves. Nothing is left behind. Needs numpy.
"""
import argparse, json, pathlib, struct, subprocess, sys, tempfile
import numpy as np

HEAD = """Film "rgb" "integer xresolution" 16 "integer yresolution" 12
Sampler "sobol" "integer pixelsamples" 1
LookAt 0 2 -3  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
"""


def grid(n):
    """A hilly square of 2 (n-1)^2 triangles: positions, normals, texture coordinates, indices."""
    s = np.linspace(-1, 1, n, dtype=np.float32)
    x, z = np.meshgrid(s, s)
    y = 0.1 * np.sin(9 * x) * np.cos(7 * z)
    by_x, by_z = 0.9 * np.cos(9 * x) * np.cos(7 * z), -0.7 * np.sin(9 * x) * np.sin(7 * z)
    normals = np.stack([-by_x, np.ones_like(x), -by_z], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    points = np.stack([x, y, z], -1).reshape(-1, 3)
    uvs = np.stack([(x + 1) / 2, (z + 1) / 2], -1).reshape(-1, 2)
    at = np.arange(n * n, dtype=np.uint32).reshape(n, n)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    faces = np.stack([np.stack([a, c, b], -1), np.stack([a, d, c], -1)]).reshape(-1, 3)
    return points.astype("<f4"), normals.reshape(-1, 3).astype("<f4"), uvs.astype("<f4"), faces.astype("<u4")


def write_ply(path, mesh, with_all=True):
    points, normals, uvs, faces = mesh
    names = "x y z nx ny nz u v".split() if with_all else "x y z".split()
    header = "ply\nformat binary_little_endian 1.0\n" + f"element vertex {len(points)}\n"
    header += "".join(f"property float {name}\n" for name in names)
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<u4", 3)])
    rows["count"], rows["corners"] = 3, faces
    with open(path, "wb") as out:
        out.write(header.encode())
        np.hstack([points, normals, uvs] if with_all else [points]).astype("<f4").tofile(out)
        rows.tofile(out)


def write_glb(path, mesh):
    parts = [a.tobytes() for a in mesh]
    offsets = np.cumsum([0] + [len(p) for p in parts])
    views = [{"buffer": 0, "byteOffset": int(o), "byteLength": len(p)} for o, p in zip(offsets, parts)]
    kinds = [(5126, "VEC3"), (5126, "VEC3"), (5126, "VEC2"), (5125, "SCALAR")]
    counts = [len(mesh[0])] * 3 + [3 * len(mesh[3])]
    accessors = [{"bufferView": i, "componentType": c, "type": t, "count": n} for i, ((c, t), n) in enumerate(zip(kinds, counts))]
    accessors[0].update(min=[-1, -1, -1], max=[1, 1, 1])
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    document = {
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": int(offsets[-1])}], "bufferViews": views, "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 3}]}], "nodes": [{"mesh": 0}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<III", 0x46546C67, 2, int(28 + len(text) + offsets[-1])))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", int(offsets[-1]), b"BIN\0"))
        for part in parts:
            out.write(part)


def size(mesh):
    return sum(a.nbytes for a in mesh)


def side(nbytes, per_vertex):
    """Vertices along a side of the grid that takes so many bytes."""
    return int((nbytes / per_vertex) ** 0.5)


def ply(folder, scale):
    mesh = grid(side(1e9 * scale, 32 + 2 * 13))
    write_ply(folder / "large.ply", mesh)
    (folder / "scene.bhs").write_text(HEAD + 'Shape "plymesh" "string filename" "large.ply"\n')
    return size(mesh), (folder / "large.ply").stat().st_size


def gltf(folder, scale):
    mesh = grid(side(5e8 * scale, 32 + 2 * 12))
    write_glb(folder / "large.glb", mesh)
    (folder / "scene.bhs").write_text(HEAD + 'Shape "gltf" "string filename" "large.glb"\n')
    return size(mesh), (folder / "large.glb").stat().st_size


def meshes(folder, scale):
    count, mesh = int(10_000 * scale), grid(32)
    lines, total = [HEAD], 0
    for i in range(count):
        write_ply(folder / f"m{i}.ply", mesh)
        total += (folder / f"m{i}.ply").stat().st_size
        x, z = i % 100 / 50 - 1, i // 100 / 50 - 1
        lines.append(f'AttributeBegin Translate {x} 0 {z} Scale 0.01 0.01 0.01\nShape "plymesh" "string filename" "m{i}.ply" AttributeEnd\n')
    (folder / "scene.bhs").write_text("".join(lines))
    return count * size(mesh), total


def hair(folder, scale):
    random, lines = np.random.default_rng(1), [HEAD, 'Material "diffuse" "rgb reflectance" [0.5 0.3 0.1]\n']
    for _ in range(int(100_000 * scale)):
        (x, z), (dx, dz), h = random.uniform(-1, 1, 2), random.normal(0, 0.15, 2), random.uniform(0.5, 1)
        points = [x, 0, z, x, 0.4 * h, z, x + 0.4 * dx, 0.8 * h, z + 0.4 * dz, x + dx, h, z + dz]
        lines.append(f'Shape "curve" "point3 P" [{" ".join(f"{p:.4f}" for p in points)}] "float width0" 0.006 "float width1" 0.001\n')
    (folder / "scene.bhs").write_text("".join(lines))
    return None, (folder / "scene.bhs").stat().st_size


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("bhs")
    options.add_argument("--scale", type=float, default=1.0)
    options.add_argument("--only", default="ply,gltf,meshes,hair")
    given = options.parse_args()
    program = pathlib.Path(given.bhs).resolve()
    print("| what | on disk | triangles | seconds | processor seconds | peak memory | over the mesh data |\n|---|---|---|---|---|---|---|")
    for name in given.only.split(","):
        make = {"ply": ply, "gltf": gltf, "meshes": meshes, "hair": hair}.get(name)
        if make is None:
            sys.exit(f"there is no `{name}`: there are ply, gltf, meshes, hair")
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            mesh_bytes, on_disk = make(folder, given.scale)
            out, stats = folder / "out.exr", folder / "stats.json"
            subprocess.run([program, "render", folder / "scene.bhs", "-o", out, "--stats", stats, "--quiet"], check=True)
            found = json.loads(stats.read_text())
            peak, seconds, processor = found["peak_memory_bytes"], found["seconds"]["load"], found["processor_seconds"]["load"]
            # Of curves there is no mesh in a file: what they become is counted.
            triangles = found["triangles"]
            over = f"{peak / mesh_bytes:.2f}" if mesh_bytes else ""
            row = [name, f"{on_disk / 1e6:.0f} MB", f"{triangles:,}", f"{seconds:.1f}", f"{processor:.1f}", f"{peak / 1e6:.0f} MB", over]
            print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
