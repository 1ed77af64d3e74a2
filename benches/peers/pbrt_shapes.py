"""Meshes of pbrt-v4 files: PLY files, and Loop's subdivision: for pbrt_mitsuba.py."""

import gzip
import re

import numpy as np

KINDS = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
         "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"}


def read_ply(path):
    """Points, triangles, normals and texture coordinates; quadrilaterals are two triangles, 0-1-2 and 0-2-3."""
    data = open(path, "rb").read()
    data = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
    head = re.match(rb"ply.*?end_header[^\n]*\n", data, re.S)
    lines = head.group(0).decode("latin1").split("\n")
    body, form, elements = data[head.end():], None, []
    for line in lines:
        word = line.split()
        if word[:1] == ["format"]:
            form = word[1]
        elif word[:1] == ["element"]:
            elements.append((word[1], int(word[2]), []))
        elif word[:1] == ["property"]:
            elements[-1][2].append(word[1:])
    order = ">" if form == "binary_big_endian" else "<"
    texts = body.split() if form == "ascii" else None
    at, vertices, faces = 0, None, []
    for name, count, properties in elements:
        if not any(p[0] == "list" for p in properties):
            kind = np.dtype([(p[1], order + KINDS[p[0]]) for p in properties])
            if texts is not None:
                n = count * len(properties)
                rows = np.array(texts[at:at + n], dtype=float).reshape(count, -1)
                columns, at = {p[1]: rows[:, k] for k, p in enumerate(properties)}, at + n
            else:
                rows = np.frombuffer(body, kind, count, at)
                columns, at = {p[1]: rows[p[1]].astype(float) for p in properties}, at + kind.itemsize * count
            vertices = columns if name == "vertex" else vertices
            continue
        if texts is None and len(properties) == 1:
            # Nearly always all faces have three corners.
            first, index = (order + KINDS[k] for k in properties[0][1:3])
            row = np.dtype([("n", first), ("i", index, 3)])
            if len(body) - at >= count * row.itemsize and (np.frombuffer(body, row, count, at)["n"] == 3).all():
                faces, at = np.frombuffer(body, row, count, at)["i"], at + count * row.itemsize
                continue
        for corners, at in lists(body, texts, order, at, count, properties):
            if name == "face":
                faces += [corners[:3]] if len(corners) == 3 else [corners[:3], [corners[0], *corners[2:4]]]
    stack = lambda *names: np.stack([vertices[n] for n in names], axis=1) if all(n in vertices for n in names) else None
    uv = stack("u", "v")
    uv = stack("s", "t") if uv is None else uv
    return stack("x", "y", "z"), np.array(faces, dtype=int).reshape(-1, 3), stack("nx", "ny", "nz"), uv


def lists(body, texts, order, at, count, properties):
    """The corners of each face, and where the next one begins."""
    for _ in range(count):
        corners = []
        for p in properties:
            if texts is not None:
                n = int(texts[at]) if p[0] == "list" else 1
                row, at = texts[at + (p[0] == "list"):at + n + (p[0] == "list")], at + n + (p[0] == "list")
            elif p[0] == "list":
                kinds = [np.dtype(order + KINDS[k]) for k in p[1:3]]
                n = int(np.frombuffer(body, kinds[0], 1, at)[0])
                at += kinds[0].itemsize
                row, at = np.frombuffer(body, kinds[1], n, at), at + n * kinds[1].itemsize
            else:
                row, at = [], at + np.dtype(KINDS[p[0]]).itemsize
            if p[-1] in ("vertex_indices", "vertex_index"):
                corners = [int(x) for x in row]
        yield corners, at


def write_ply(path, points, faces, normals, uv):
    columns = [points] + ([normals] if normals is not None else []) + ([uv] if uv is not None else [])
    names = ["x", "y", "z"] + (["nx", "ny", "nz"] if normals is not None else []) + (["u", "v"] if uv is not None else [])
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *(f"property float {n}" for n in names),
             f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = np.zeros(len(faces), dtype=[("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, faces
    with open(path, "wb") as file:
        file.write("\n".join(lines).encode() + b"\n")
        file.write(np.concatenate(columns, axis=1).astype("<f4").tobytes() + rows.tobytes())


def subdivided(points, faces):
    """One step of Loop's subdivision, with pbrt's weights."""
    corners = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges, index, count = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True)
    index = index.ravel()
    opposite = np.zeros((len(edges), 3))
    np.add.at(opposite, index, points[np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])])
    ends, border = points[edges].sum(axis=1), count == 1
    odd = np.where(border[:, None], ends / 2, 3 / 8 * ends + opposite / 8)
    new = np.concatenate([smoothed(points, edges, border, lambda n: np.where(n == 3, 3 / 16, 3 / (8 * n)), 1 / 8), odd])
    a, b, c = (len(points) + index[k * len(faces):(k + 1) * len(faces)] for k in range(3))
    split = [(faces[:, 0], a, c), (a, faces[:, 1], b), (c, b, faces[:, 2]), (a, b, c)]
    return new, np.concatenate([np.stack(f, axis=1) for f in split])


def smoothed(points, edges, border, weight, at_border):
    """Each point moved towards its neighbours; one on a border towards those on the border alone."""
    valence, sums = np.zeros(len(points)), np.zeros_like(points)
    on, rim = np.zeros(len(points), bool), np.zeros_like(points)
    on[edges[border]] = True
    for i, j in ((0, 1), (1, 0)):
        np.add.at(valence, edges[:, i], 1)
        np.add.at(sums, edges[:, i], points[edges[:, j]])
        np.add.at(rim, edges[border, i], points[edges[border, j]])
    w = weight(valence)[:, None]
    return np.where(on[:, None], (1 - 2 * at_border) * points + at_border * rim, (1 - valence[:, None] * w) * points + w * sums)


def loop_subdivision(points, faces, levels):
    """pbrt's `loopsubdiv`: the points and normals of the limit. Normals of one side, whichever."""
    for _ in range(levels):
        points, faces = subdivided(points, faces)
    corners = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges, count = np.unique(corners, axis=0, return_counts=True)
    beta = lambda n: np.where(n == 3, 3 / 16, 3 / (8 * n))
    points = smoothed(points, edges, count == 1, lambda n: 1 / (n + 3 / (8 * beta(n))), 1 / 5)
    # The ring of neighbours of each point, in order.
    after = [{} for _ in points]
    for a, b, c in faces.tolist():
        after[a][b], after[b][c], after[c][a] = c, a, b
    normals = np.zeros_like(points)
    for v, ring in enumerate(after):
        starts = set(ring) - set(ring.values())
        at = first = starts.pop() if starts else next(iter(ring))
        row = [first]
        while at in ring and ring[at] != first:
            at = ring[at]
            row.append(at)
        p, n = points[row], len(row)
        k = np.arange(n)[:, None]
        if not starts and len(ring) == n:
            s, t = (np.cos(2 * np.pi * k / n) * p).sum(axis=0), (np.sin(2 * np.pi * k / n) * p).sum(axis=0)
        else:
            s, theta = p[-1] - p[0], np.pi / max(n - 1, 1)
            if n == 2:
                t = p[0] + p[1] - 2 * points[v]
            elif n == 3:
                t = p[1] - points[v]
            elif n == 4:
                t = -p[0] + 2 * p[1] + 2 * p[2] - p[3] - 2 * points[v]
            else:
                t = np.sin(theta) * (p[0] + p[-1]) + ((2 * np.cos(theta) - 2) * np.sin(k * theta) * p)[1:-1].sum(axis=0)
        normals[v] = np.cross(s, t)
    face = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    outward = np.zeros_like(points)
    for k in range(3):
        np.add.at(outward, faces[:, k], face)
    normals *= np.where((normals * outward).sum(axis=1) < 0, -1, 1)[:, None]
    return points, faces, normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
