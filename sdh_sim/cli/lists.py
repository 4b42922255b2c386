"""``sdh-sim objects``: what there is to grasp."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from sdh_sim.cli.console import output, plain_table


def objects(folders: Sequence[str] = ()) -> None:
    """Print the objects, or those of users' folders: mass, friction, extents, centre of mass.

    Raises:
        SettingsError: a folder that cannot be used.
    """
    from sdh_sim.objects import object_info, object_names, user_object

    users = [user_object(path) for path in folders]
    infos = [object_info(own.name, own.reference) for own in users]
    table = plain_table("object", "mass kg", "friction", "extents mm", "centre of mass mm")
    for info in infos or [object_info(name) for name in object_names()]:
        table.add_row(
            info.name,
            f"{info.mass_kg:.3f}",
            f"{info.friction:.2f}",
            " × ".join(_millimetres(info.extents_m)),
            ", ".join(_millimetres(info.com_m, digits=2)),
        )
    output().print(table)
    for own, info in zip(users, infos, strict=True):
        line = (
            f"{info.name}: {own.file}, {own.parts} collision shape{'s'[: own.parts > 1]}"
            + ("" if own.hull_ratio is None else f", hulls {own.hull_ratio:.3f} × its volume")
            + f"; stands {1e3 * info.height:.1f} mm high, "
            f"{2e3 * info.half_narrow:.1f} × {2e3 * info.half_wide:.1f} mm wide; moments of "
            f"inertia {' '.join(f'{v:.3g}' for v in info.inertia_kgm2.diagonal())} kg m²; "
            f"sha256 {own.reference.sha256[:12]}"
        )
        output().print(line, markup=False, soft_wrap=True, highlight=False)
        if own.reference.notes:
            told = f"  {'; '.join(own.reference.notes)}"
            output().print(told, markup=False, soft_wrap=True, highlight=False)


def _millimetres(values: Iterable[float], digits: int = 1) -> list[str]:
    # Zero is added since a rounded -0.001 would print as -0.00.
    return [f"{round(1000.0 * float(value), digits) + 0.0:.{digits}f}" for value in values]
