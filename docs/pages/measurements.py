"""docs/measurements.md: the definition of every measurement that ships, with a drawing."""

import math

from docs.pages import MADE
from docs.pages.sketch import WIDTH, Sketch
from studies import measurements, scenarios

SCENARIOS = {
    "thin_plate": ("perforation", "A hole in a thin plate", "section along the line of flight"),
    "debris_cloud": ("debris-cloud", "A debris cloud", "section along the line of flight, which points down"),
    "thick_plate": ("crater", "A crater in a thick block", "section along the line of flight"),
    "taylor_bar": ("taylor-bar", "A Taylor bar", "the bar at the end, on its wall"),
    "elastic_bar": ("elastic-bar", "An elastic bar", "push of the wall against time, and where the energy went"),
    "plate_impact": ("plate-impact", "A plate impact", "pressure across flyer and target before waves return"),
    "whipple_shield": ("shield", "A Whipple shield", "section along the line of flight, which points down"),
    "plugging": ("plugging", "Plugging of a plate", "section along the line of flight, which points down"),
    "deck": ("deck", "A deck of MPM3D", "all particles on the grid, whatever their bodies are"),
}  # fmt: skip


def pages() -> dict[str, str]:
    """docs/measurements.md."""
    parts = [
        "# Measurements\n",
        MADE.format(source="`studies/measurements/`"),
        "Numbers that are read off the state of a run. Each carries the parts of its uncertainty and the flags that "
        "speak against it. Its version rises when its definition changes; stored states are then measured again "
        "([how](how-to.md#measure-again)). An edge stands where a density, averaged over a cell, falls to half of its "
        "undisturbed value, unless the definition says otherwise.\n",
    ]
    for scenario, (file, title, caption) in SCENARIOS.items():
        parts += [f"## {title}\n", f"![{title}: {caption}](drawings/{file}.svg)\n"]
        for name in scenarios.load(scenario).measurements:
            each = measurements.load(name)
            unit = "ratio" if each.unit == "1" else each.unit
            parts += [
                f"**`{name}`** ({unit}, version {each.version}): {each.title}. "
                f"{each.meaning[0].upper()}{each.meaning[1:]}.\n"
            ]
    return {"measurements.md": "\n".join(parts)}


def drawings() -> dict[str, str]:
    """A drawing for each scenario."""
    sketches = (
        _perforation(),
        _debris_cloud(),
        _crater(),
        _taylor_bar(),
        _elastic_bar(),
        _plate_impact(),
        _shield(),
        _plugging(),
        _deck(),
    )
    files = (file for file, _, _ in SCENARIOS.values())
    return {f"{file}.svg": sketch.svg() for file, sketch in zip(files, sketches, strict=True)}


def _perforation() -> Sketch:
    sketch = Sketch("Diameters of a hole")
    wall = [(20, 120), (180, 120), (204, 88), (220, 80), (228, 104), (223, 135), (225, 150), (240, 168),
            (232, 205), (206, 212), (190, 180), (20, 180)]  # fmt: skip
    sketch.shape(wall)
    sketch.shape([(WIDTH - x, y) for x, y in wall])
    sketch.dashed(20, 150, WIDTH - 20, 150)
    sketch.dashed(0.5 * WIDTH, 20, 0.5 * WIDTH, 310)
    sketch.text(0.5 * WIDTH + 8, 32, "axis of the hole", "start")
    sketch.text(24, 112, "impact side", "start")
    for name, edge, y in (
        ("hole_diameter_lip", 218, 62),
        ("hole_diameter_midplane", 225, 150),
        ("hole_diameter", 240, 238),
        ("hole_diameter_areal", 229, 274),
    ):
        sketch.dashed(edge, 80, edge, y)
        sketch.dashed(WIDTH - edge, 80, WIDTH - edge, y)
        sketch.across(edge, WIDTH - edge, y, name)
    axes = ("hole_diameter_largest", "hole_diameter_smallest", "hole_diameter_mean_root")
    for row, name in enumerate(axes):
        sketch.text(24, 232 + 16 * row, name, "start", "#0072b2")
    return sketch


def _debris_cloud() -> Sketch:
    sketch = Sketch("Length and radius of a debris cloud", 360)
    wall = [(20, 60), (190, 60), (214, 30), (226, 40), (228, 70), (222, 96), (204, 84), (20, 84)]
    sketch.shape(wall)
    sketch.shape([(WIDTH - x, y) for x, y in wall])
    sketch.dashed(20, 60, WIDTH - 20, 60)
    sketch.dashed(20, 84, WIDTH - 20, 84)
    half = [(340, 130), (296, 118), (262, 140), (248, 200), (262, 262), (300, 306), (340, 322)]
    sketch.shape([*half, *((WIDTH - x, y) for x, y in reversed(half[1:-1]))])
    for x, y, text in (
        (24, 18, "mass_before, momentum_before"),
        (24, 34, "kinetic_energy_before"),
        (24, 50, "internal_energy_before"),
        (90, 102, "mass_behind, momentum_behind"),
        (90, 118, "kinetic_energy_behind"),
        (90, 134, "internal_energy_behind"),
        (90, 150, "melted_share_behind"),
        (90, 166, "melted_share_projectile"),
        (440, 222, "fragments, largest_fragment"),
        (440, 238, "expansion_rate"),
        (440, 254, "fragment_size_grady: the smaller of"),
        (440, 270, "fragment_size_brittle and"),
        (440, 286, "fragment_size_ductile"),
        (440, 302, "fragment_size_liquid"),
        (350, 342, "tip_velocity_percent, tip_velocity_permille"),
        (350, 120, "rear_velocity"),
        (24, 346, "cloud_length_over_diameter: cloud_length / 2 cloud_radius"),
    ):
        sketch.text(x, y, text, "start", "#0072b2")
    sketch.dashed(0.5 * WIDTH, 20, 0.5 * WIDTH, 350)
    sketch.dashed(248, 200, 520, 200)
    sketch.across(248, 340, 196, "cloud_radius")
    sketch.along(500, 84, 200, "cloud_radius_place")
    sketch.dashed(300, 322, 200, 322)
    sketch.along(60, 84, 322, "cloud_length")
    return sketch


def _crater() -> Sketch:
    sketch = Sketch("Depth and diameter of a crater")
    wall = [(160, 90), (176, 62), (192, 58), (204, 90), (214, 140), (245, 195), (290, 228), (340, 238)]
    whole = wall + [(WIDTH - x, y) for x, y in reversed(wall[:-1])]
    sketch.shape([(20, 90), *whole, (WIDTH - 20, 90), (WIDTH - 20, 310), (20, 310)])
    sketch.dashed(20, 90, WIDTH - 20, 90)
    sketch.text(24, 84, "original surface", "start")
    sketch.across(204, WIDTH - 204, 90, "crater_diameter")
    sketch.dashed(326, 90, 326, 250)
    sketch.dashed(354, 90, 354, 250)
    sketch.along(340, 90, 238, "crater_depth")
    sketch.text(140, 204, "crater_volume", "end", "#0072b2")
    sketch.dashed(110, 58, 196, 58)
    sketch.along(120, 58, 90, "crater_lip_height")
    names = ("crater_diameter_largest", "crater_diameter_smallest", "crater_diameter_mean_root")
    for row, name in enumerate((*names, "crater_rebound: lost share of the largest depth")):
        sketch.text(340, 110 + 16 * row, name, colour="#0072b2")
    sketch.text(340, 268, "column of a quarter of the projectile's diameter")
    sketch.text(340, 292, "crater_depth_over_diameter = crater_depth / crater_diameter", colour="#0072b2")
    return sketch


def _taylor_bar() -> Sketch:
    sketch = Sketch("Final shape of a Taylor bar", 360)
    side = [(300, 30), (300, 170), (292, 220), (276, 262), (252, 290), (236, 310)]
    sketch.shape(side + [(WIDTH - x, y) for x, y in reversed(side)])
    sketch.path([(120, 310), (560, 310)])
    sketch.text(124, 328, "wall", "start")
    sketch.along(420, 30, 310, "final_length")
    sketch.across(236, 444, 338, "mushroom_diameter")
    sketch.across(276, 404, 262, "width_at_fifth")
    sketch.along(140, 262, 310, "0.2 L")
    sketch.text(124, 346, "L: initial length", "start")
    sketch.text(660, 60, "taylor_error: mean of the relative", "end", "#0072b2")
    sketch.text(660, 78, "errors of the three lengths", "end", "#0072b2")
    return sketch


def _deck() -> Sketch:
    sketch = Sketch("Sums over the particles on the grid")
    for x in range(60, 401, 34):
        sketch.dashed(x, 40, x, 244)
    for y in range(40, 245, 34):
        sketch.dashed(60, y, 400, y)
    sketch.shape([(94, 142), (196, 142), (196, 244), (94, 244)])
    sketch.shape([(264, 74), (366, 108), (332, 210), (230, 176)])
    sums = (
        ("kinetic_energy", "sum of m v v / 2"),
        ("internal_energy", "sum of m e"),
        ("momentum_x", "sum of m v along x"),
        ("momentum_y", "along y"),
        ("momentum_z", "along z"),
        ("largest_pressure", "of any particle"),
    )
    for row, (name, meaning) in enumerate(sums):
        sketch.text(430, 60 + 34 * row, f"{name}: {meaning}", "start", "#0072b2")
    return sketch


def _elastic_bar() -> Sketch:
    sketch = Sketch("Push of the wall, and shares of the energy")
    push = [(60, 200), (66, 62), (90, 72), (120, 60), (160, 70), (240, 62), (290, 72), (310, 150)]
    sketch.path([*push, (324, 222), (340, 200), (600, 200)])
    sketch.dashed(40, 200, 620, 200)
    sketch.dashed(60, 133, 520, 133)
    sketch.text(518, 128, "half of the mean push", "end")
    sketch.text(44, 40, "push of the wall", "start")
    sketch.text(618, 192, "time", "end")
    sketch.across(60, 306, 170, "contact_time")
    sketch.along(324, 200, 222, "wall_pull, over the largest push")
    for row, text in enumerate(("rear_face_place, rear_face_velocity:", "end away from the wall")):
        sketch.text(640, 60 + 16 * row, text, "end", "#0072b2")
    middle = ("middle_velocity, middle_stress:", "halfway along the axis, and the largest:")
    for row, text in enumerate((*middle, "middle_peak_velocity, middle_peak_stress")):
        sketch.text(640, 100 + 16 * row, text, "end", "#0072b2")
    rebound = "rebound_momentum: momentum away from the wall, over the initial one towards it"
    sketch.text(60, 268, rebound, "start", "#0072b2")
    x = 60.0
    shares = (
        ("rigid_energy", 190, "#7f7f7f99"),
        ("vibration_energy", 140, "#7f7f7f66"),
        ("strain_energy", 120, "#7f7f7f44"),
        ("lost_energy", 110, "#7f7f7f22"),
    )
    for name, width, fill in shares:
        sketch.shape([(x, 290), (x + width, 290), (x + width, 318), (x, 318)], fill)
        sketch.text(x + 0.5 * width, 308, name, colour="#0072b2")
        x += width
    return sketch


def _plate_impact() -> Sketch:
    sketch = Sketch("Plateau, fronts and free surface of a plate impact", 420)
    sketch.shape([(220, 80), (320, 80), (320, 230), (220, 230)], "#7f7f7f33")
    sketch.shape([(360, 80), (470, 80), (470, 230), (360, 230)], "#7f7f7f33")
    sketch.path([(40, 230), (178, 230), (190, 155), (200, 80), (490, 80), (502, 155), (514, 230), (640, 230)])
    sketch.dashed(340, 40, 340, 372)
    sketch.text(340, 34, "impact face")
    sketch.text(44, 248, "flyer", "start")
    sketch.text(636, 248, "target", "end")
    sketch.text(340, 70, "plateau_pressure, plateau_scatter, plateau_velocity", colour="#0072b2")
    for x, body in ((270, "flyer"), (415, "target")):
        sketch.text(x, 140, f"{body}_density", colour="#0072b2")
    sketch.across(220, 320, 200, "mass / volume")
    sketch.across(360, 470, 200, "mass / volume")
    sketch.text(340, 318, "mass / volume between the outermost layers of the plateau:")
    sketch.text(340, 336, "flyer_density_from_spacing, target_density_from_spacing", colour="#0072b2")
    sketch.dashed(190, 155, 190, 280)
    sketch.dashed(502, 155, 502, 280)
    sketch.across(190, 340, 276, "flyer_shock_front")
    sketch.across(340, 502, 276, "target_shock_front")
    sketch.text(340, 296, "fronts where the pressure falls to half")
    sketch.text(340, 364, "flyer_shock_speed, target_shock_speed: slope of the front's path", colour="#0072b2")
    sketch.text(340, 388, "rear of the target: free_surface_velocity, free_surface_peak, free_surface_minimum,")
    sketch.text(
        340, 406, "pullback_velocity between them; acoustic_stress and spall_strength are rho0 c0 / 2 times both"
    )
    return sketch


def _shield() -> Sketch:
    sketch = Sketch("A shield: bumper, debris and wall", 496)
    middle = 0.5 * WIDTH
    for side in (-1, 1):
        bumper = [(middle + side * x, y) for x, y in ((300, 40), (70, 40), (58, 28), (62, 62), (76, 58), (300, 58))]
        sketch.shape(bumper)
    front = [(x, 270.0 + 38.0 * math.exp(-(((x - middle) / 110.0) ** 2))) for x in range(40, WIDTH - 39, 10)]
    sketch.shape([*front, *((x, y + 28.0) for x, y in reversed(front))])
    for number in range(48):
        angle, far = 0.55 * ((number * 0.618) % 1.0 - 0.5), 110.0 + 80.0 * ((number * 0.414) % 1.0)
        x, y = middle + far * 2.0 * angle, 40.0 + far * (1.0 - angle**2)
        sketch.shape([(x, y), (x + 4, y), (x + 4, y + 4), (x, y + 4)])
    sketch.across(middle - 58, middle + 58, 22, "bumper_hole_diameter")
    sketch.text(470, 130, "shield_momentum_behind", "start", "#0072b2")
    sketch.text(470, 148, "shield_kinetic_energy_behind", "start", "#0072b2")
    sketch.text(470, 220, "shield_tip_velocity", "start", "#0072b2")
    sketch.text(470, 112, "shield_rear_velocity", "start", "#0072b2")
    sketch.dashed(40, 298, WIDTH - 40, 298)
    sketch.dashed(170, 336, middle, 336)
    sketch.along(180, 298, 336, "wall_bulge")
    sketch.shape([(290, 350), (390, 350), (384, 360), (296, 360)])
    sketch.across(290, 390, 386, "wall_spall_diameter")
    sketch.text(400, 359, "wall_detached_spall, wall_spall_velocity", "start", "#0072b2")
    sketch.text(640, 320, "wall_momentum", "end", "#0072b2")
    sketch.text(middle, 260, "wall_crater_depth_over_thickness", colour="#0072b2")
    for row, text in enumerate(
        (
            "wall_perforated: 0 here; wall_hole_diameter where it is 1",
            "wall_failed: 1 here, because spall came off",
            "wall_attached_spall: 0 here; 1 where a gap within the wall is closed all round",
            "bumper_2_hole_diameter, bumper_3_hole_diameter, bumper_4_hole_diameter: holes of further bumpers",
            "shield_...: behind the last bumper",
        )
    ):
        sketch.text(middle, 412 + 18 * row, text, colour="#0072b2")
    return sketch


def _plugging() -> Sketch:
    sketch = Sketch("Projectile, plug and hole of a plugging", 360)
    middle = 0.5 * WIDTH
    half = [(20, 120), (150, 122), (268, 134), (262, 196), (150, 174), (20, 172)]
    sketch.shape(half)
    sketch.shape([(WIDTH - x, y) for x, y in half])
    sketch.shape([(280, 20), (WIDTH - 280, 20), (WIDTH - 280, 180), (280, 180)], "#7f7f7f33")
    sketch.shape([(278, 250), (WIDTH - 278, 250), (WIDTH - 280, 302), (280, 302)])
    sketch.dashed(middle, 20, middle, 345)
    sketch.text(24, 112, "front face", "start")
    sketch.text(24, 190, "rear face", "start")
    sketch.across(268, WIDTH - 268, 112, "hole_diameter_front")
    sketch.across(262, WIDTH - 262, 216, "hole_diameter_rear")
    sketch.dashed(60, 172, 250, 172)
    sketch.along(205, 172, 184, "dishing")
    sketch.text(middle, 50, "projectile_velocity, residual_velocity", colour="#0072b2")
    sketch.text(middle, 280, "plug_mass, plug_velocity", colour="#0072b2")
    times = (
        "perforated: 1 or 0",
        "first_contact: the projectile slows down",
        "plug_separation: no whole matter joins them",
    )
    for row, text in enumerate(times):
        sketch.text(WIDTH - 24, 290 + 18 * row, text, "end", "#0072b2")
    return sketch
