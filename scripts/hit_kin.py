# SPDX-License-Identifier: MIT
"""Kin of the hits of hits.py: sleeves on arms that bend or swing, and strips that are twisted."""
import math
import os


def tube(radius, from_x, to_x, around, along):
    """Vertices and triangles of a tube along x, open at both ends."""
    vertices, triangles = [], []
    for i in range(along + 1):
        x = from_x + (to_x - from_x) * i / along
        for j in range(around):
            a = 2 * math.pi * (j + 0.5 * (i % 2)) / around
            vertices.append([x, radius * math.cos(a), radius * math.sin(a)])
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            triangles += [[a, b, c], [b, d, c]] if i % 2 == 0 else [[a, d, c], [a, b, d]]
    return vertices, triangles


def limb(radius, from_x, to_x, around, along):
    """The same, closed."""
    vertices, triangles = tube(radius, from_x, to_x, around, along)
    n, last = len(vertices), along * around
    vertices += [[from_x, 0, 0], [to_x, 0, 0]]
    for j in range(around):
        k = (j + 1) % around
        triangles += [[n, k, j], [n + 1, last + j, last + k]]
    return vertices, triangles


def bent_in_an_arc(vertices, angle, half):
    """The centre line, along x, becomes an arc over 2 half about z, with straight ends."""
    out = []
    for x, y, z in vertices:
        if angle == 0.0:
            out.append([x, y, z])
            continue
        curvature = angle / (2 * half)
        s = max(-half, min(half, x))
        a = curvature * s
        cx, cy = math.sin(a) / curvature + (x - s) * math.cos(a), (1 - math.cos(a)) / curvature + (x - s) * math.sin(a)
        out.append([cx - y * math.sin(a), cy + y * math.cos(a), z])
    return out


def skinned(vertices, angle, half):
    """Each vertex goes to the mean of where its two bones take it, so that the skin of the elbow folds inwards."""
    out = []
    for x, y, z in vertices:
        share = max(0.0, min(1.0, 0.5 + 0.5 * x / half))
        upper, lower = ((x * math.cos(a) - y * math.sin(a), x * math.sin(a) + y * math.cos(a)) for a in (-0.5 * angle, 0.5 * angle))
        out.append([(1 - share) * upper[0] + share * lower[0], (1 - share) * upper[1] + share * lower[1], z])
    return out


def write_obj(path, vertices, triangles):
    with open(path, "w", encoding="utf-8") as file:
        for p in vertices:
            file.write("v %.9g %.9g %.9g\n" % tuple(p))
        for t in triangles:
            file.write("f %d %d %d\n" % tuple(i + 1 for i in t))


def elbow(draw, folder):
    """A sleeve on an arm that bends, or a strip in the bend. The files of the arm are written to the folder."""
    radius, length = draw.uniform(0.035, 0.055), draw.uniform(0.2, 0.3)
    way, cloth = draw.one_of(["arc", "skin", "skin"]), draw.one_of(["sleeve", "sleeve", "strip"])
    angle, seconds = math.radians(draw.uniform(100, 150)), draw.uniform(0.4, 1.2)
    half = radius * (draw.uniform(1.0, 1.4) if way == "arc" else draw.uniform(0.6, 1.4))
    if way == "arc":
        half = max(half, 0.5 * angle * radius * draw.uniform(1.0, 1.15))  # so that the skin has no fold
    bend = bent_in_an_arc if way == "arc" else skinned
    vertices, triangles = limb(radius, -length, length, 20, int(2 * length / 0.012))
    back, fps = draw.one_of([True, False]), 30
    n = max(3, int(seconds * fps))
    angles = [angle * (0.5 - 0.5 * math.cos(math.pi * i / n)) for i in range(n + 1)] + [angle] * 6
    if back:
        angles += [angle * (0.5 + 0.5 * math.cos(math.pi * i / n)) for i in range(1, n + 1)]
    files = []
    os.makedirs(folder, exist_ok=True)
    for i, a in enumerate(angles):
        files.append(f"arm_{i:03d}.obj")
        write_obj(os.path.join(folder, files[-1]), bend(vertices, a, half), triangles)
    piece, handles, held = elbow_cloth(draw, radius, angle, (way, cloth), lambda p, a: bend([p], a, half)[0], angles, fps)
    scene = {"geometry": [piece], "handles": handles, "gravity": [0, 0, -9.81] if cloth == "sleeve" else [0, -9.81, 0],
             "obstacles": [{"name": "arm", "sequence": {"files": files, "fps": fps}, "friction": draw.one_of([0.0, 0.3, 0.6])}],
             "contact": {"still_tangled": "carry"}, "time": {"frames": math.ceil(60 * (len(angles) - 1) / fps) + 10, "fps": 60}}
    return scene, f"{way}, {cloth}{' held' if held else ''}, {math.degrees(angle):.0f} degrees in {seconds:.2f} s{' and back' if back else ''}"


def elbow_cloth(draw, radius, angle, kind, place, angles, fps):
    """The piece, its handles, and whether one end of a sleeve is held on the upper arm."""
    way, cloth = kind
    if cloth == "strip":
        width, length = draw.uniform(0.04, 0.12), draw.uniform(0.15, 0.3)
        turned = {"rotation": {"axis": [1, 0, 0], "angle_deg": 90}, "translation": [0, radius + 0.004, 0]}
        draw.random()
        cells = [int(length / 0.012), max(3, int(width / 0.012))]
        return {"name": "strip", "size": [length, width], "cells": cells, "transformation": turned}, [], False
    room, around = draw.uniform(0.004, 0.015), 24
    cell = 2 * math.pi * (radius + room) / around
    a, b = -draw.uniform(0.08, 0.16), draw.uniform(0.08, 0.16)
    vertices, triangles = tube(radius + room, a, b, around, max(4, int((b - a) / cell)))
    held = draw.one_of([True, False])
    if way == "skin" and -a < 1.2 * (radius + room) * math.tan(0.5 * angle):
        held = False  # the handle would lie inside the lower arm
    piece = {"name": "sleeve", "mesh": {"vertices": [[round(c, 9) for c in p] for p in vertices], "triangles": triangles}}
    if not held:
        return piece, [], False
    motion = [{"time": i / fps, "translation": [p - q for p, q in zip(place([a, 0, 0], x), [a, 0, 0])],
               "rotation": {"axis": [0, 0, 1], "angle_deg": -0.5 * math.degrees(x)}} for i, x in enumerate(angles)]
    motion[0] = {"time": 0}
    return piece, [{"geometry": "sleeve", "select": {"vertices": list(range(around))}, "motion": motion}], True


def twist(draw, _):
    """A strip held at both ends, one of which turns two to eight times and comes nearer."""
    length, width, cell = draw.uniform(0.2, 0.5), draw.uniform(0.03, 0.12), draw.uniform(0.006, 0.012)
    angle, rate = draw.uniform(720, 3000), draw.power(360, 2000)
    seconds, nearer, n = angle / rate, draw.uniform(0.0, 0.6) * length, math.ceil(angle / 90)
    motion = [{"time": 0}] + [{"time": seconds * i / n, "translation": [-nearer * (i / n) ** 2, 0, 0],
                               "rotation": {"axis": [1, 0, 0], "angle_deg": (angle * i / n) % 360}} for i in range(1, n + 1)]
    draw.random()
    cells = [int(length / cell), max(3, int(width / cell))]
    scene = {"gravity": [0, 0, draw.one_of([0, -9.81])], "geometry": [{"name": "strip", "size": [length, width], "cells": cells}],
             "handles": [{"select": {"edge": "x0"}}, {"select": {"edge": "x1"}, "motion": motion}],
             "contact": {"rest_gap": draw.one_of([0.001, 0.002]), "still_tangled": "carry"},
             "time": {"frames": math.ceil(60 * seconds) + 10, "fps": 60}}
    return scene, f"{length:.2f} x {width:.2f} m, {angle:.0f} degrees at {rate:.0f} degrees/s, {nearer:.2f} m nearer"


def sleeve(draw, _):
    """A sleeve on an arm that turns about its shoulder at 800 to 1,500 degrees/s."""
    radius, length, room = draw.uniform(0.03, 0.06), draw.uniform(0.4, 0.7), draw.uniform(0.003, 0.015)
    around, a = draw.one_of([20, 24, 32]), draw.uniform(0.02, 0.1)
    b, cell = a + draw.uniform(0.25, 0.55), 2 * math.pi * (radius + room) / around
    vertices, triangles = tube(radius + room, a, b, around, max(4, int((b - a) / cell)))
    held, rate, angle = draw.one_of([False, False, True]), draw.uniform(800, 1500), draw.uniform(60, 170)
    draw.random()
    axis, seconds = draw.one_of([[0, 0, 1], [0, 1, 0]]), angle / rate
    turned = {"axis": axis, "angle_deg": angle}
    keys = [{"time": 0}, {"time": 0.05}, {"time": 0.05 + seconds, "rotation": turned}]
    if draw.one_of([False, True]):
        keys += [{"time": 0.05 + 2 * seconds}, {"time": 0.05 + 3 * seconds, "rotation": turned}]
    arm = limb(radius, 0.0, length, 24, 20)
    friction = draw.one_of([0.0, 0.3, 0.3, 0.6])
    scene = {"geometry": [{"name": "sleeve", "mesh": {"vertices": [[round(c, 9) for c in p] for p in vertices], "triangles": triangles}}],
             "obstacles": [{"name": "arm", "mesh": {"vertices": arm[0], "triangles": arm[1]}, "motion": keys, "friction": friction}],
             "contact": {"still_tangled": "carry"}, "time": {"frames": math.ceil(60 * keys[-1]["time"]) + 15, "fps": 60}}
    if held:
        scene["handles"] = [{"select": {"vertices": list(range(around))}, "motion": shoulder_motion(keys, a, axis)}]
    return scene, f"{b - a:.2f} m{' held' if held else ''}, {1000 * room:.0f} mm of room, {angle:.0f} degrees at {rate:.0f} degrees/s, mu {friction}"


def shoulder_motion(keys, distance, axis):
    """Of particles about a point of the arm at a distance from the shoulder; a handle turns about its own centre."""
    motion, parts = [{"time": 0}], 8
    for before, after in zip(keys, keys[1:]):
        a, b = (k.get("rotation", {}).get("angle_deg", 0.0) for k in (before, after))
        for i in range(1, parts + 1):
            angle, time = a + (b - a) * i / parts, before["time"] + (after["time"] - before["time"]) * i / parts
            c, s = distance * math.cos(math.radians(angle)), distance * math.sin(math.radians(angle))
            place = [c - distance, 0, -s] if axis[1] else [c - distance, s, 0]
            motion.append({"time": time, "translation": place, **({"rotation": {"axis": axis, "angle_deg": angle}} if angle else {})})
    return motion


KINDS = {"elbow": elbow, "sleeve": sleeve, "twist": twist}
