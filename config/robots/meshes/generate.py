#!/usr/bin/env python3
"""Writes the meshes of ur5.urdf (DAE) and panda.urdf (OBJ, STL) beside itself.

The shapes are drawn here, after the outer dimensions of the arms, from turned and swept parts; they are
no copies of the makers' CAD data. Standard library only. Run it after a change and commit what it writes.
"""

import math
import pathlib
import struct

HERE = pathlib.Path(__file__).resolve().parent
SEGMENTS = 28  # Vertices round a part.

# Materials: name to red, green, blue.
STEEL = ("steel", (0.72, 0.74, 0.76))
DARK = ("dark", (0.20, 0.21, 0.23))
BLUE = ("blue", (0.30, 0.55, 0.75))
WHITE = ("white", (0.90, 0.91, 0.92))


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(s * x for x in a)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return scaled(a, 1.0 / length)


def perpendicular(axis):
    """Two unit vectors that make a right-handed frame with the axis."""
    helper = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0)
    e1 = unit(cross(helper, axis))
    return e1, cross(axis, e1)


class Mesh:
    """Indexed triangles, counter-clockwise from outside."""

    def __init__(self):
        self.points = []
        self.triangles = []

    def rings(self, rings):
        """Joins rings of points (a ring of one point closes the surface), first to last."""
        first = []
        for ring in rings:
            first.append(len(self.points))
            self.points.extend(ring)
        for k in range(len(rings) - 1):
            low, high = rings[k], rings[k + 1]
            n = max(len(low), len(high))
            for i in range(n):
                j = (i + 1) % n
                a, b = first[k] + i % len(low), first[k] + j % len(low)
                c, d = first[k + 1] + i % len(high), first[k + 1] + j % len(high)
                if len(low) > 1:
                    self.triangles.append((a, b, d if len(high) > 1 else c))
                if len(high) > 1:
                    self.triangles.append((a, d, c))


def turned(mesh, origin, axis, profile, segments=SEGMENTS):
    """Turns a profile of (distance along the axis, radius) pairs about an axis."""
    axis = unit(axis)
    e1, e2 = perpendicular(axis)
    rings = []
    for along, radius in profile:
        centre = add(origin, scaled(axis, along))
        if radius == 0.0:
            rings.append([centre])
            continue
        ring = []
        for i in range(segments):
            angle = 2.0 * math.pi * i / segments
            ring.append(add(centre, add(scaled(e1, radius * math.cos(angle)),
                                        scaled(e2, radius * math.sin(angle)))))
        rings.append(ring)
    mesh.rings(rings)


def drum(mesh, origin, axis, low, high, radius, bevel=0.006, segments=SEGMENTS):
    """A cylinder from low to high along an axis, with round edges."""
    profile = [(low, 0.0)]
    for i in range(4):
        angle = math.pi / 2 * i / 3
        profile.append((low + bevel * (1 - math.sin(angle)), radius - bevel * (1 - math.cos(angle))))
    profile = [(low, 0.0)] + sorted(profile[1:], key=lambda p: p[0])
    upper = [(low + high - along, r) for along, r in reversed(profile)]
    turned(mesh, origin, axis, profile + upper, segments)


def dome(mesh, origin, axis, low, radius, height, segments=SEGMENTS):
    """A flat dome that sits on a drum's end."""
    profile = [(low - 0.004, 0.0), (low - 0.004, radius), (low, radius)]
    for i in range(1, 6):
        angle = math.pi / 2 * i / 6
        profile.append((low + height * math.sin(angle), radius * math.cos(angle)))
    turned(mesh, origin, axis, profile + [(low + height, 0.0)], segments)


def swept(mesh, path, segments=SEGMENTS):
    """A tube along a path of (point, radius) pairs, its ends rounded; the frame is carried along."""
    points = [p for p, _ in path]
    tangents = []
    for i in range(len(points)):
        a, b = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
        tangents.append(unit(add(b, scaled(a, -1.0))))
    e1, _ = perpendicular(tangents[0])

    def ring(centre, tangent, radius, e):
        f = cross(tangent, e)
        return [add(centre, add(scaled(e, radius * math.cos(2 * math.pi * i / segments)),
                                scaled(f, radius * math.sin(2 * math.pi * i / segments))))
                for i in range(segments)]

    rings = [[add(points[0], scaled(tangents[0], -0.3 * path[0][1]))],
             ring(add(points[0], scaled(tangents[0], -0.18 * path[0][1])), tangents[0],
                  0.8 * path[0][1], e1)]
    for (centre, radius), tangent in zip(path, tangents):
        e1 = unit(add(e1, scaled(tangent, -dot(e1, tangent))))
        rings.append(ring(centre, tangent, radius, e1))
    end, radius = path[-1]
    rings.append(ring(add(end, scaled(tangents[-1], 0.18 * radius)), tangents[-1], 0.8 * radius, e1))
    rings.append([add(end, scaled(tangents[-1], 0.3 * radius))])
    mesh.rings(rings)


def bent(start, corner, end, radius_start, radius_end, steps=9):
    """A path from start to end that is rounded off at the corner (a quadratic Bezier curve)."""
    path = []
    for i in range(steps):
        s = i / (steps - 1)
        point = add(add(scaled(start, (1 - s) ** 2), scaled(corner, 2 * s * (1 - s))),
                    scaled(end, s * s))
        path.append((point, (1 - s) * radius_start + s * radius_end))
    return path


# --- files ----------------------------------------------------------------------------------------


def write_stl(path, parts):
    """Binary STL: no colours, no shared points."""
    with open(path, "wb") as file:
        facets = [tuple(mesh.points[i] for i in t) for _, mesh in parts for t in mesh.triangles]
        file.write(b"made by generate.py".ljust(80, b" "))
        file.write(struct.pack("<I", len(facets)))
        for a, b, c in facets:
            normal = cross(add(b, scaled(a, -1.0)), add(c, scaled(a, -1.0)))
            length = math.sqrt(dot(normal, normal)) or 1.0
            file.write(struct.pack("<12fH", *scaled(normal, 1.0 / length), *a, *b, *c, 0))


def write_obj(path, parts):
    """Wavefront OBJ with its material file."""
    materials = {}
    lines = ["# made by generate.py", f"mtllib {path.stem}.mtl"]
    first = 1
    for (name, colour), mesh in parts:
        materials[name] = colour
        lines.append(f"usemtl {name}")
        lines += ["v %.5f %.5f %.5f" % p for p in mesh.points]
        lines += ["f %d %d %d" % tuple(first + i for i in t) for t in mesh.triangles]
        first += len(mesh.points)
    path.write_text("\n".join(lines) + "\n")
    text = ["# made by generate.py"]
    for name, colour in materials.items():
        text += [f"newmtl {name}", "Kd %.2f %.2f %.2f" % colour]
    path.with_suffix(".mtl").write_text("\n".join(text) + "\n")


def write_dae(path, parts):
    """COLLADA 1.4.1, in metres, one geometry to a material."""
    effects, materials, geometries, nodes = [], [], [], []
    for index, ((name, colour), mesh) in enumerate(parts):
        tag = f"{name}{index}"
        positions = " ".join("%.5f %.5f %.5f" % p for p in mesh.points)
        indices = " ".join("%d %d %d" % t for t in mesh.triangles)
        effects.append(
            f'<effect id="{tag}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse>'
            f'<color>{colour[0]:.2f} {colour[1]:.2f} {colour[2]:.2f} 1</color></diffuse></lambert>'
            f"</technique></profile_COMMON></effect>")
        materials.append(f'<material id="{tag}-material" name="{name}">'
                         f'<instance_effect url="#{tag}-effect"/></material>')
        geometries.append(
            f'<geometry id="{tag}"><mesh><source id="{tag}-p"><float_array id="{tag}-a" '
            f'count="{3 * len(mesh.points)}">{positions}</float_array><technique_common>'
            f'<accessor source="#{tag}-a" count="{len(mesh.points)}" stride="3">'
            f'<param name="X" type="float"/><param name="Y" type="float"/>'
            f'<param name="Z" type="float"/></accessor></technique_common></source>'
            f'<vertices id="{tag}-v"><input semantic="POSITION" source="#{tag}-p"/></vertices>'
            f'<triangles material="m" count="{len(mesh.triangles)}">'
            f'<input semantic="VERTEX" source="#{tag}-v" offset="0"/><p>{indices}</p>'
            f"</triangles></mesh></geometry>")
        nodes.append(
            f'<node id="{tag}-node"><instance_geometry url="#{tag}"><bind_material>'
            f'<technique_common><instance_material symbol="m" target="#{tag}-material"/>'
            f"</technique_common></bind_material></instance_geometry></node>")
    newline = "\n"
    path.write_text(f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2024-01-01T00:00:00</created><modified>2024-01-01T00:00:00</modified>
<unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_effects>
{newline.join(effects)}
</library_effects>
<library_materials>
{newline.join(materials)}
</library_materials>
<library_geometries>
{newline.join(geometries)}
</library_geometries>
<library_visual_scenes><visual_scene id="scene">
{newline.join(nodes)}
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
""")


class Body:
    """Meshes of one link, one for each material."""

    def __init__(self):
        self.meshes = {}

    def __getitem__(self, material):
        return self.meshes.setdefault(material, Mesh())

    def parts(self):
        return list(self.meshes.items())

    def triangles(self):
        return sum(len(mesh.triangles) for mesh in self.meshes.values())


# --- UR5: frames as in ur5.urdf --------------------------------------------------------------------

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
O = (0.0, 0.0, 0.0)


def joint_housing(body, origin, axis, low, high, radius, cap):
    """The drum of a joint with a blue cap on its end at `high` (cap > 0) or at `low` (cap < 0)."""
    drum(body[STEEL], origin, axis, low, high, radius)
    if cap > 0:
        dome(body[BLUE], origin, axis, high, 0.93 * radius, 0.012)
    elif cap < 0:
        dome(body[BLUE], origin, scaled(axis, -1.0), -low, 0.93 * radius, 0.012)


def ur5():
    links = {}
    base = links["base"] = Body()
    turned(base[DARK], O, Z, [(0.0, 0.0), (0.0, 0.0745), (0.010, 0.0745), (0.014, 0.071),
                              (0.016, 0.0), ])
    turned(base[STEEL], O, Z, [(0.012, 0.0), (0.012, 0.071), (0.020, 0.064), (0.026, 0.060),
                               (0.034, 0.060), (0.034, 0.0)])

    shoulder = links["shoulder"] = Body()
    joint_housing(shoulder, O, Z, -0.053, 0.056, 0.060, +1)
    drum(shoulder[STEEL], O, Y, 0.0, 0.074, 0.057, 0.003)

    upper = links["upper_arm"] = Body()
    joint_housing(upper, O, Y, -0.060, 0.052, 0.060, +1)
    turned(upper[STEEL], O, Z, [(0.02, 0.0), (0.02, 0.054), (0.075, 0.054), (0.085, 0.049),
                                (0.34, 0.046), (0.35, 0.050), (0.40, 0.050), (0.40, 0.0)])
    turned(upper[DARK], O, Z, [(0.076, 0.0), (0.076, 0.0545), (0.079, 0.0545), (0.079, 0.0)])
    joint_housing(upper, (0.0, 0.0, 0.425), Y, -0.066, 0.052, 0.056, +1)

    forearm = links["forearm"] = Body()
    joint_housing(forearm, O, Y, -0.052, 0.052, 0.056, -1)
    turned(forearm[STEEL], O, Z, [(0.02, 0.0), (0.02, 0.048), (0.070, 0.048), (0.080, 0.042),
                                  (0.33, 0.037), (0.34, 0.040), (0.38, 0.040), (0.38, 0.0)])
    turned(forearm[DARK], O, Z, [(0.071, 0.0), (0.071, 0.0485), (0.074, 0.0485), (0.074, 0.0)])
    joint_housing(forearm, (0.0, 0.0, 0.39225), Y, -0.042, 0.046, 0.041, -1)

    wrist1 = links["wrist_1"] = Body()
    drum(wrist1[STEEL], O, Y, 0.047, 0.093, 0.039, 0.003)
    joint_housing(wrist1, (0.0, 0.093, 0.0), Z, -0.042, 0.046, 0.041, -1)

    wrist2 = links["wrist_2"] = Body()
    drum(wrist2[STEEL], O, Z, 0.047, 0.095, 0.039, 0.003)
    joint_housing(wrist2, (0.0, 0.0, 0.09465), Y, -0.042, 0.042, 0.041, -1)

    wrist3 = links["wrist_3"] = Body()
    turned(wrist3[STEEL], O, Y, [(0.043, 0.0), (0.043, 0.0375), (0.060, 0.0375), (0.063, 0.034),
                                 (0.063, 0.0)])
    turned(wrist3[DARK], O, Y, [(0.062, 0.0), (0.062, 0.0315), (0.0823, 0.0315), (0.0823, 0.0)])
    return links


# --- Panda: link frames are those of the DH table (Craig's convention) -----------------------------


def panda():
    links = {}
    link0 = links["link0"] = Body()
    turned(link0[WHITE], O, Z, [(0.0, 0.0), (0.0, 0.085), (0.014, 0.085), (0.030, 0.072),
                                (0.075, 0.066), (0.132, 0.064), (0.137, 0.060), (0.137, 0.0)])
    swept(link0[WHITE], [((-0.125, 0.0, 0.040), 0.034), ((-0.09, 0.0, 0.044), 0.040),
                         ((-0.04, 0.0, 0.055), 0.050), ((0.0, 0.0, 0.070), 0.060)])

    link1 = links["link1"] = Body()
    turned(link1[DARK], O, Z, [(-0.194, 0.0), (-0.194, 0.058), (-0.188, 0.058), (-0.188, 0.0)])
    turned(link1[WHITE], O, Z, [(-0.190, 0.0), (-0.190, 0.063), (-0.15, 0.063), (-0.09, 0.060),
                                (-0.03, 0.060), (0.0, 0.058), (0.020, 0.050), (0.020, 0.0)])
    drum(link1[WHITE], O, Y, -0.060, 0.060, 0.062, 0.014)

    link2 = links["link2"] = Body()
    drum(link2[DARK], O, Z, -0.064, 0.064, 0.050, 0.006)
    turned(link2[WHITE], O, scaled(Y, -1.0), [(0.0, 0.0), (0.0, 0.052), (0.05, 0.058),
                                              (0.10, 0.060), (0.128, 0.060), (0.132, 0.056),
                                              (0.132, 0.0)])

    link3 = links["link3"] = Body()
    turned(link3[DARK], O, Z, [(-0.186, 0.0), (-0.186, 0.056), (-0.180, 0.056), (-0.180, 0.0)])
    swept(link3[WHITE], [((0.0, 0.0, -0.175), 0.060), ((0.0, 0.0, -0.13), 0.060)] +
          bent((0.0, 0.0, -0.10), (0.0, 0.0, -0.02), (0.0825, 0.0, 0.0), 0.060, 0.050))
    drum(link3[WHITE], (0.0825, 0.0, 0.0), Y, -0.055, 0.055, 0.056, 0.012)

    link4 = links["link4"] = Body()
    drum(link4[DARK], O, Z, -0.059, 0.059, 0.045, 0.006)
    swept(link4[WHITE], bent((-0.005, 0.005, 0.0), (-0.0825, 0.02, 0.0), (-0.0825, 0.085, 0.0),
                             0.048, 0.056) + [((-0.0825, 0.115, 0.0), 0.057)])

    link5 = links["link5"] = Body()
    turned(link5[DARK], O, Z, [(-0.262, 0.0), (-0.262, 0.053), (-0.256, 0.053), (-0.256, 0.0)])
    turned(link5[WHITE], O, Z, [(-0.258, 0.0), (-0.258, 0.057), (-0.20, 0.057), (-0.12, 0.050),
                                (-0.05, 0.046), (0.0, 0.046), (0.030, 0.040), (0.042, 0.024),
                                (0.044, 0.0)])
    drum(link5[WHITE], O, Y, -0.052, 0.052, 0.048, 0.012)

    link6 = links["link6"] = Body()
    drum(link6[DARK], O, Z, -0.056, 0.056, 0.038, 0.006)
    swept(link6[WHITE], bent((0.0, 0.0, 0.0), (0.045, 0.005, 0.0), (0.088, 0.0, 0.0), 0.042, 0.046))
    drum(link6[WHITE], (0.088, 0.0, 0.0), Y, -0.048, 0.048, 0.050, 0.014)

    link7 = links["link7"] = Body()
    turned(link7[DARK], O, Z, [(0.048, 0.0), (0.048, 0.044), (0.053, 0.044), (0.053, 0.0)])
    turned(link7[WHITE], O, Z, [(0.052, 0.0), (0.052, 0.046), (0.085, 0.045), (0.093, 0.040),
                                (0.093, 0.0)])
    turned(link7[DARK], O, Z, [(0.092, 0.0), (0.092, 0.0315), (0.107, 0.0315), (0.107, 0.0)])
    return links


def main():
    for arm, links in (("ur5", ur5()), ("panda", panda())):
        folder = HERE / arm
        folder.mkdir(exist_ok=True)
        for name, body in links.items():
            # Both formats for the Panda: what has one colour is an STL, coloured by the URDF file.
            if arm == "ur5":
                write_dae(folder / f"{name}.dae", body.parts())
            elif len(body.parts()) == 1:
                write_stl(folder / f"{name}.stl", body.parts())
            else:
                write_obj(folder / f"{name}.obj", body.parts())
        print(arm, sum(body.triangles() for body in links.values()), "triangles")


if __name__ == "__main__":
    main()
