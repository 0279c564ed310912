#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""make_patterns.py [FOLDER]: writes the sewing patterns of data/patterns.

The patterns fit the mannequin with its arms out, data/bodies/mannequin_arms_out.ply: z up, facing -y, 1.7 m tall.
Lengths are centimetres. A panel is drawn as it is seen from its outer side, its edges counter-clockwise.
"""
import json
import math
import os
import sys

# Measured on the mannequin, cm. Girths are of horizontal sections.
CHEST_GIRTH = 82.5      # at z = 120
WAIST_GIRTH = 65.0      # at z = 105
HIP_GIRTH = 97.0        # at z = 85
THIGH_GIRTH = 51.0      # at z = 74
NECK_GIRTH = 37.1       # at z = 146
SHOULDER_JOINT = (17.0, 1.2, 136.5)
UPPER_ARM_GIRTH = 28.9  # across the arm
ARM_ANGLE = 50.0        # degrees from hanging down

WAIST, UNDERARM, CROTCH = 105.0, 119.0, 74.0
SHOULDER_TIP, NECK_POINT = (18.5, 144.0), (7.5, 147.0)
FRONT, BACK = -18.0, 20.0  # y of the panels of trunk and legs: 4 cm and more clear of the body
MIRROR = {"left": "right", "right": "left"}


class Panel:
    """Points and named edges; `edges` is a list of (name, start, curve), curve: control points or None."""

    def __init__(self, points, edges, labels=()):
        self.points, self.edges, self.labels = points, edges, dict(labels)

    def mirrored(self):
        """The same panel of the other half of the body. Edges keep their names."""
        points = [(-x, y) for x, y in self.points]
        n = len(self.edges)
        edges = []
        for i in reversed(range(n)):
            name, start, curve = self.edges[i]
            end = self.edges[(i + 1) % n][1]
            edges.append((name, end, curve and [(-x, y) for x, y in reversed(curve)]))
        return Panel(points, edges, self.labels)

    def end_of(self, i):
        return self.edges[(i + 1) % len(self.edges)][1]

    def index(self, name):
        return [edge[0] for edge in self.edges].index(name)

    def length(self, name):
        i = self.index(name)
        a, b = self.points[self.edges[i][1]], self.points[self.end_of(i)]
        line = [a] + list(self.edges[i][2] or []) + [b]
        points = [bezier(line, k / 200) for k in range(201)]
        return sum(math.dist(points[k], points[k + 1]) for k in range(200))

    def text(self, translation, rotation):
        out = []
        for i, (name, start, curve) in enumerate(self.edges):
            end = self.end_of(i)
            edge = {"endpoints": [start, end]}
            if curve:
                a, b = self.points[start], self.points[end]
                kind = {1: "quadratic", 2: "cubic"}[len(curve)]
                edge["curvature"] = {"type": kind, "params": [relative(a, b, p) for p in curve]}
            if name in self.labels:
                edge["label"] = self.labels[name]
            out.append(edge)
        return {"translation": translation, "rotation": rotation, "label": "",
                "vertices": [[rounded(x), rounded(y)] for x, y in self.points], "edges": out}


def rounded(x):
    return round(x, 6) + 0.0


def bezier(line, t):
    while len(line) > 1:
        line = [((1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]) for a, b in zip(line, line[1:])]
    return line[0]


def relative(a, b, p):
    """Of the point p: along the edge from a to b, and to its left, in lengths of the edge."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    x, y = p[0] - a[0], p[1] - a[1]
    square = dx * dx + dy * dy
    return [rounded((x * dx + y * dy) / square), rounded((y * dx - x * dy) / square)]


class Pattern:
    def __init__(self, name):
        self.name, self.panels, self.texts, self.stitches = name, {}, {}, []

    def add(self, name, panel, translation, rotation):
        self.panels[name] = panel
        self.texts[name] = panel.text(translation, rotation)

    def front(self, name, panel, x=0.0, z=0.0, y=FRONT):
        self.add(name, panel, [x, y, z], [90, 0, 0])

    def back(self, name, panel, x=0.0, z=0.0, y=BACK):
        self.add(name, panel, [x, y, z], [90, 0, 180])

    def sew(self, a, edge_a, b, edge_b):
        sides = [{"panel": n, "edge": self.panels[n].index(e)} for n, e in ((a, edge_a), (b, edge_b))]
        self.stitches.append(sides)

    def write(self, folder):
        text = {"pattern": {"panels": self.texts, "stitches": self.stitches, "panel_order": list(self.texts)},
                "parameters": {}, "parameter_order": [],
                "properties": {"units_in_meter": 100, "curvature_coords": "relative",
                               "normalize_panel_translation": False}}
        with open(os.path.join(folder, self.name + ".json"), "w", encoding="utf-8") as file:
            json.dump(text, file, indent=1)
            file.write("\n")


def trunk(hem, half_hem, half_chest, neck_depth, sleeve_hole, split_neck=False):
    """Front or back of a top. Edges: hem, side_left, hole_left, shoulder_left, neck..., of the viewer's right first."""
    tip, neck = SHOULDER_TIP, NECK_POINT
    points = [(-half_hem, hem), (half_hem, hem), (half_chest, UNDERARM), tip, neck,
              (-neck[0], neck[1]), (-tip[0], tip[1]), (-half_chest, UNDERARM)]
    deep = neck[1] - neck_depth
    edges = [("hem", 0, None), ("side_right", 1, None), ("hole_right", 2, [sleeve_hole]), ("shoulder_right", 3, None)]
    if split_neck:
        points.append((0.0, deep))
        edges += [("neck_right", 4, [(neck[0] - 1.0, deep)]), ("neck_left", 8, [(1.0 - neck[0], deep)])]
    else:
        edges.append(("neck", 4, [(neck[0] - 1.0, deep - 0.3 * neck_depth), (1.0 - neck[0], deep - 0.3 * neck_depth)]))
    edges += [("shoulder_left", 5, None), ("hole_left", 6, [(-sleeve_hole[0], sleeve_hole[1])]), ("side_left", 7, None)]
    return Panel(points, edges)


def half_sleeve(hole_length, length, half_width, half_cuff):
    """Half of a set-in sleeve, seen from its outer side with the shoulder at its left. The cap is as long as the hole
    of the arm with 2 % ease."""
    low, high = -0.5 * half_width, 0.5 * half_width
    cuff_low = 0.5 * (low + high) - 0.5 * half_cuff
    for step in range(200):  # the height of the cap
        height = 0.1 * step
        under = 14.0
        top = under - height
        panel = Panel([(under, low), (length, cuff_low), (length, cuff_low + half_cuff), (top, high)],
                      [("under", 0, None), ("cuff", 1, None), ("over", 2, None),
                       ("cap", 3, [(top - 0.5, high - 0.35 * half_width), (under - 0.35 * height, low + 0.3 * half_width)])])
        if panel.length("cap") >= 1.02 * hole_length:
            return panel
    raise ValueError("the hole of the arm is too long for the sleeve")


def add_sleeves(pattern, sleeve_front, sleeve_back):
    """Front halves 10 cm before the arm, back halves 10 cm behind it, in the plane of the arm."""
    tilt = 90.0 - ARM_ANGLE
    x, y, z = SHOULDER_JOINT
    for name, sleeve, offset, turn in (("front", sleeve_front, -10.0, 0), ("back", sleeve_back, 10.0, 180)):
        # Seen from the front, the left arm points to the right; seen from the back, to the left.
        as_drawn, other = sleeve, sleeve.mirrored()
        left, right = (as_drawn, other) if name == "front" else (other, as_drawn)
        sign = 1.0 if name == "front" else -1.0
        pattern.add("left_sleeve_" + name, left, [x, y + offset, z], [90, sign * tilt, turn])
        pattern.add("right_sleeve_" + name, right, [-x, y + offset, z], [90, -sign * tilt, turn])


def sew_top(pattern, sleeves):
    """Seams of a front and a back; a back is drawn from behind, so that its right side is the wearer's."""
    for side in ("left", "right"):
        # Front: the wearer's left is at the viewer's right.
        front, back = MIRROR[side], side
        pattern.sew("front", "side_" + front, "back", "side_" + back)
        pattern.sew("front", "shoulder_" + front, "back", "shoulder_" + back)
        if sleeves:
            pattern.sew(side + "_sleeve_front", "cap", "front", "hole_" + front)
            pattern.sew(side + "_sleeve_back", "cap", "back", "hole_" + back)
            pattern.sew(side + "_sleeve_front", "over", side + "_sleeve_back", "over")
            pattern.sew(side + "_sleeve_front", "under", side + "_sleeve_back", "under")


def tee():
    pattern = Pattern("tee")
    half = (CHEST_GIRTH + 20.0) / 4.0
    pattern.front("front", trunk(84.0, half + 0.5, half, 8.0, (19.0, 124.0)))
    pattern.back("back", trunk(84.0, half + 0.5, half, 2.5, (19.5, 124.0)))
    width = (UPPER_ARM_GIRTH + 16.0) / 2.0
    add_sleeves(pattern, half_sleeve(pattern.panels["front"].length("hole_right"), 28.0, width, 0.86 * width),
                half_sleeve(pattern.panels["back"].length("hole_right"), 28.0, width, 0.86 * width))
    sew_top(pattern, sleeves=True)
    return pattern


def hooded_top():
    pattern = Pattern("hooded_top")
    half = (CHEST_GIRTH + 24.0) / 4.0
    pattern.front("front", trunk(80.0, half, half, 8.0, (19.0, 124.0), split_neck=True))
    pattern.back("back", trunk(80.0, half, half, 2.5, (19.5, 124.0), split_neck=True))
    width = (UPPER_ARM_GIRTH + 18.0) / 2.0
    add_sleeves(pattern, half_sleeve(pattern.panels["front"].length("hole_right"), 52.0, width, 0.6 * width),
                half_sleeve(pattern.panels["back"].length("hole_right"), 52.0, width, 0.6 * width))
    sew_top(pattern, sleeves=True)
    # Half of the hood, from the wearer's left: the back is at the right. Its lower edges are those of the neckline.
    front, back = pattern.panels["front"].length("neck_left"), pattern.panels["back"].length("neck_left")
    shoulder = (1.5, 148.5)
    points = [(shoulder[0] - 0.82 * front, shoulder[1] - 0.57 * front), shoulder,
              (shoulder[0] + 0.98 * back, shoulder[1] - 0.2 * back), (-10.5, 179.0)]
    hood = Panel(points, [("neck_front", 0, None), ("neck_back", 1, None), ("crown", 2, [(19.0, 162.0), (12.0, 182.0)]),
                          ("opening", 3, None)])
    pattern.add("left_hood", hood, [10.5, 0, 7.0], [90, 0, 90])
    pattern.add("right_hood", hood.mirrored(), [-10.5, 0, 7.0], [90, 0, -90])
    pattern.sew("left_hood", "crown", "right_hood", "crown")
    for side in ("left", "right"):
        pattern.sew(side + "_hood", "neck_front", "front", "neck_" + MIRROR[side])
        pattern.sew(side + "_hood", "neck_back", "back", "neck_" + side)
    return pattern


def skirt():
    pattern = Pattern("flared_skirt")
    half, height, gather, hem = (WAIST_GIRTH + 8.0) / 4.0, 4.0, 1.15, 42.0
    band = Panel([(-half, WAIST - 2.0), (half, WAIST - 2.0), (half, WAIST - 2.0 + height), (-half, WAIST - 2.0 + height)],
                 [("lower", 0, None), ("side_right", 1, None), ("upper", 2, None), ("side_left", 3, None)],
                 {"upper": "waist"})
    top = WAIST - 3.0
    sheet = Panel([(-hem, 55.0), (hem, 55.0), (gather * half, top), (-gather * half, top)],
                  [("hem", 0, [(0.0, 48.0)]), ("side_right", 1, None), ("upper", 2, [(0.0, top - 5.0)]),
                   ("side_left", 3, None)])
    pattern.front("front", sheet)
    pattern.back("back", sheet)
    pattern.front("band_front", band)
    pattern.back("band_back", band)
    for side in ("left", "right"):
        pattern.sew("front", "side_" + MIRROR[side], "back", "side_" + side)
        pattern.sew("band_front", "side_" + MIRROR[side], "band_back", "side_" + side)
    pattern.sew("band_front", "lower", "front", "upper")
    pattern.sew("band_back", "lower", "back", "upper")
    return pattern


def trousers():
    pattern = Pattern("trousers")
    waist, quarter, hem = 103.0, (WAIST_GIRTH + 11.0) / 4.0, 13.0

    def leg(extension, rise):
        """Of the wearer's left leg, seen from the front."""
        crotch = CROTCH - 2.0
        points = [(-extension, crotch), (10.0, hem), (30.0, hem), (quarter, waist), (0.0, waist + rise)]
        edges = [("inseam", 0, [(3.0, 45.0)]), ("hem", 1, None), ("outseam", 2, [(35.0, 84.0)]), ("waist", 3, None),
                 ("rise", 4, [(0.0, crotch + 12.0), (-0.3 * extension, crotch)])]
        return Panel(points, edges, {"waist": "waist"})

    front, back = leg(4.5, 0.0), leg(8.0, 2.0)
    pattern.front("left_front", front, x=6.5)
    pattern.front("right_front", front.mirrored(), x=-6.5)
    # Seen from behind, the left leg is at the left.
    pattern.back("left_back", back.mirrored(), x=10.0)
    pattern.back("right_back", back, x=-10.0)
    for side in ("left", "right"):
        pattern.sew(side + "_front", "outseam", side + "_back", "outseam")
        pattern.sew(side + "_front", "inseam", side + "_back", "inseam")
    pattern.sew("left_front", "rise", "right_front", "rise")
    pattern.sew("left_back", "rise", "right_back", "rise")
    return pattern


def dress():
    pattern = Pattern("dress_with_darts")
    middle, dart, outer = 6.5, 2.5, (WAIST_GIRTH + 8.0) / 4.0 - 6.5
    half = middle + dart + outer  # of the flat waist
    places = [-half, -middle - dart, -middle - dart / 2.0, -middle, middle, middle + dart / 2.0, middle + dart, half]
    names = ["waist_left", "dart_left_0", "dart_left_1", "waist_middle", "dart_right_0", "dart_right_1", "waist_right"]

    def bodice(tip, neck_depth):
        chest = (CHEST_GIRTH + 8.0) / 4.0
        neck, shoulder = (8.5, 146.0), (15.5, 143.5)
        waist = [(x, tip if i in (2, 5) else WAIST) for i, x in enumerate(places)]
        points = waist + [(chest, 124.0), shoulder, neck, (-neck[0], neck[1]), (-shoulder[0], shoulder[1]),
                          (-chest, 124.0)]
        deep = neck[1] - 1.3 * neck_depth
        edges = [(name, i, None) for i, name in enumerate(names)]
        edges += [("side_right", 7, None), ("hole_right", 8, [(15.5, 127.0)]), ("shoulder_right", 9, None),
                  ("neck", 10, [(7.0, deep), (-7.0, deep)]), ("shoulder_left", 11, None),
                  ("hole_left", 12, [(-15.5, 127.0)]), ("side_left", 13, None)]
        return Panel(points, edges)

    def skirt_part(depth):
        """From the waist down; its upper edge is that of the bodice, from right to left."""
        hip, hem = (HIP_GIRTH + 8.0) / 4.0, 33.0
        waist = [(x, WAIST - depth if i in (2, 5) else WAIST) for i, x in enumerate(places)]
        points = [(-hem, 58.0), (hem, 58.0)] + waist[::-1]
        edges = [("hem", 0, None), ("side_right", 1, [(hip + 0.5, 88.0)])]
        upper = {"waist_left": "waist", "waist_middle": "waist", "waist_right": "waist"}
        edges += [(name, 2 + i, None) for i, name in enumerate(names[::-1])]
        edges.append(("side_left", 9, [(-hip - 0.5, 88.0)]))
        return Panel(points, edges, upper)

    pattern.front("bodice_front", bodice(118.0, 8.0), z=0.5)
    pattern.back("bodice_back", bodice(116.0, 2.5), z=0.5)
    pattern.front("skirt_front", skirt_part(9.0), z=-0.5)
    pattern.back("skirt_back", skirt_part(12.0), z=-0.5)
    for part in ("bodice", "skirt"):
        for side in ("front", "back"):
            for dart_side in ("left", "right"):
                name = part + "_" + side
                pattern.sew(name, "dart_" + dart_side + "_0", name, "dart_" + dart_side + "_1")
    for side in ("left", "right"):
        for part in ("bodice", "skirt"):
            pattern.sew(part + "_front", "side_" + MIRROR[side], part + "_back", "side_" + side)
        pattern.sew("bodice_front", "shoulder_" + MIRROR[side], "bodice_back", "shoulder_" + side)
    for side in ("front", "back"):
        for part in ("left", "middle", "right"):
            pattern.sew("bodice_" + side, "waist_" + part, "skirt_" + side, "waist_" + part)
    return pattern


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "..", "data", "patterns")
    os.makedirs(folder, exist_ok=True)
    for pattern in (tee(), skirt(), trousers(), dress(), hooded_top()):
        pattern.write(folder)


if __name__ == "__main__":
    main()
