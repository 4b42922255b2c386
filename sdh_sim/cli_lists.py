"""``sdh-sim objects`` and ``sdh-sim hand``: what there is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from sdh_sim.cli_console import output, plain_table


def objects() -> None:
    """Print the objects with mass, friction, extents and centre of mass."""
    from sdh_sim.objects import object_info, object_names

    table = plain_table("object", "mass kg", "friction", "extents mm", "centre of mass mm")
    for name in object_names():
        info = object_info(name)
        table.add_row(
            name,
            f"{info.mass_kg:.3f}",
            f"{info.friction:.2f}",
            " × ".join(_millimetres(info.extents_m)),
            ", ".join(_millimetres(info.com_m, digits=2)),
        )
    output().print(table)


def hand() -> None:
    """Print the joints with their limits and the tactile pads."""
    from sdh_sim.hand import joint_table, pad_table

    joints = plain_table("joint", "motor", "torque N m", "range rad", "speed rad/s", text=(0, 1))
    for name, motor, torque, reach, speed in joint_table():
        joints.add_row(name, str(motor), f"{torque:.4g}", _range(reach), f"{speed:.3g}")
    pads = plain_table("pad", "rows", "columns", "live taxels", "pitch mm")
    for name, rows, columns, live, pitch in pad_table():
        pads.add_row(name, str(rows), str(columns), str(live), f"{pitch:g}")
    output().print(joints)
    output().print(pads)


def _millimetres(values: Iterable[float], digits: int = 1) -> list[str]:
    return [f"{1000.0 * float(value):.{digits}f}" for value in values]


def _range(reach: Sequence[float]) -> str:
    return f"{reach[0]:.3f} to {reach[1]:.3f}"
