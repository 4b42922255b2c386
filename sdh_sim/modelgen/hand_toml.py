"""Write models/schunk_sdh2/hand.toml, from sdh2_constants."""

from __future__ import annotations

from sdh_sim.modelgen.toml_text import toml_array, toml_table, toml_value
from sdh_sim.robot import sdh2_constants as c

HEADER = """# Schunk SDH-2: what the model sdh2.xml does not say. Written by
# `python -m sdh_sim.modelgen.hand`
# from the tables in sdh_sim/robot/sdh2_constants.py, which name the source of each number.
# Motors are in the order of libsdh's axes; lengths in m, angles in rad, torques in N m.
"""


def hand_toml() -> str:
    """The content of the file."""
    top = {"name": "schunk_sdh2", "model": "sdh2.xml", "palm": "palm"}
    lines = [HEADER + "\n".join(f"{key} = {toml_value(value)}" for key, value in top.items())]
    lines.append(
        f"groups = {toml_value(c.TORQUE_GROUPS)}  # of motors, in the order of --torque-limit"
    )
    for m in c.MOTORS:
        spread = m.kind == "spread"
        lines += toml_table(
            f"motors.{m.name}",
            {
                "group": "distal" if m.kind == "distal" else "proximal",
                "finger": m.finger,
                "rated": c.DATASHEET_TORQUE[m.kind],
                "speed": c.MAX_SPEED[m.kind],
                "closing_speed": c.CLOSING_SPEED,
                "flexes": 0 if spread else 1,
            },
        )
    for f in c.FINGERS:
        lines += toml_table(
            f"fingers.{f.name}",
            {
                "bodies": [f"{f.name}_knuckle"],
                "stops": [m.name for m in c.MOTORS if m.finger == f.name and m.kind != "spread"],
                "tip": f"{f.name}_distal",
                "tip_position": [0.0, 0.0, c.DISTAL_LENGTH],
                "pad_ahead": float(c.DISTAL_PROFILE[:, 0].max()) * 1e-3,
            },
        )
    for kind, profile in c.PAD_PROFILE.items():
        rows, columns = range(len(profile)), range(c.TAXEL_COLUMNS)
        missing = [[r, k] for r in rows for k in columns if not c.taxel_is_live(kind, r, k)]
        lines += toml_array(kind, c.TAXEL_COLUMNS, c.TAXEL_PITCH, profile, missing)
    for finger, kind in c.PADS:
        pad = f"{finger}_{kind}"
        lines += toml_table(f"pads.{pad}", {"body": pad, "array": kind})
    for name, shape in c.PRESHAPES.items():
        kinds = {"spread": (shape.spread, 0.0), "proximal": shape.proximal, "distal": shape.distal}
        ends = [kinds[m.kind] for m in c.MOTORS]
        reach: dict[str, object] = {"centre": c.CLOSING_CENTRE[name], "depth": c.GRASP_DEPTH[name]}
        if name in c.PRECISION_PRESHAPES:
            reach["precision_depth"] = c.PRECISION_DEPTH
        lines += toml_table(
            f"closings.{name}",
            {
                "open": [float(start) for start, _ in ends],
                "travel": [float(gain) for _, gain in ends],
                "rate": c.CLOSING_RATE,
                "squeeze": [
                    m.name for m, (_, gain) in zip(c.MOTORS, ends, strict=True)
                    if m.kind != "spread" and gain > 0.0
                ],
                **reach,
            },
        )  # fmt: skip
    return "\n".join(lines) + "\n"
