"""Lines of text that a run of a scene prints."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path

import numpy as np
from ase.units import GPa

from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.reference import Reference

_RATIOS = {"Maugis-Dugdale": "A/A_MD"}


def heading(scene: Scene, laws: Reference) -> str:
    """Return what is calculated, and the head of the table of steps.

    Parameters
    ----------
    scene : Scene
    laws : Reference
        Of the scene.

    Returns
    -------
    str
    """
    lines = [
        f"{scene.substrate.symbol}, spacing {scene.spacing:.3f} Å, "
        f"E* = {scene.contact_modulus / GPa:.4g} GPa; sphere of radius "
        f"{scene.radius / 10:.4g} nm, {scene.wall.label}"
    ]
    if laws.explanation:
        lines.append(f"Theory: {laws.explanation}")
    if laws.smooth.pull_off_force < 0.0:
        pull_off = laws.smooth.pull_off_force / NANONEWTON
        lines.append(f"Pull-off force: {pull_off:.4g} nN ({laws.smooth.label})")
    name = laws.smooth.name
    depth = "" if scene.path.control == "load" else f"{_depth(scene):>13}"
    ratio = _RATIOS.get(name, f"A/A_{name}")
    predicted = "" if laws.rough_above is None else "   Eq. (4)"
    lines.append(f"{ratio}: relative to theory, {laws.smooth.sphere}")
    return "\n".join(
        [
            *lines,
            "",
            f"   step{depth}   load (nN)   area (nm²)   {ratio:>9}{predicted}"
            "   time (s)",
        ]
    )


def row(
    scene: Scene,
    laws: Reference,
    record: LoadStep,
    total: int,
    left: float | None = None,
    kept: bool = False,
) -> str:
    """Return the line of a step.

    Parameters
    ----------
    scene : Scene
    laws : Reference
        Of the scene.
    record : LoadStep
    total : int
        Number of steps.
    left : float, optional
        Time left (s), if it is known.
    kept : bool
        Whether the step was calculated by an earlier run.

    Returns
    -------
    str
        It begins with the number of the step, as the record has it, and of the last.
    """
    force, touches = record.normal_force, record.repulsive_atoms > 0
    smooth = float(laws.smooth.contact_area(np.array(force))) if touches else np.nan
    depth = {"load": "", "penetration": f"{record.penetration:13.4f}"}.get(
        scene.path.control, f"{record.height:13.4f}"
    )
    predicted = ""
    if laws.rough_above is not None:
        predicted = _ratio(float(laws.rough_area(np.array(force))), smooth, 10)
    time = "       kept" if kept else f"{record.seconds:11.2f}"
    seconds = round(left or 0.0)
    after = f"   about {timedelta(seconds=seconds)} left" if seconds else ""
    return (
        f"{record.step:4d}/{total - 1:<3d}{depth}{force / NANONEWTON:11.4g}"
        f"{record.contact_area / 100:13.4g}{_ratio(record.contact_area, smooth, 12)}"
        f"{predicted}{time}{after}{_mark(scene, record)}"
    )


def effort(record: LoadStep) -> str:
    """Return a line on how a step was obtained.

    Parameters
    ----------
    record : LoadStep

    Returns
    -------
    str
    """
    return (
        f"          {record.iterations} iterations, {record.pairs:.0f} pairs of "
        f"transforms; window {record.window}, grid {record.grid}, "
        f"{record.memory / 1e9:.2g} GB; {record.max_force:.2g} of "
        f"{record.tolerance:.2g} eV/Å left"
    )


def time_left(
    costs: Sequence[float] | np.ndarray, records: Sequence[LoadStep], kept: int
) -> float | None:
    """Return the time that a path is likely to take until its end.

    Parameters
    ----------
    costs : array_like, shape (steps + 1,)
        Expected cost before each step and after the last, in any unit.
    records : sequence of LoadStep
        Of the steps that are done.
    kept : int
        How many of them took no time now.

    Returns
    -------
    float or None
        Time (s); None before the second step of this run, as the first one also pays
        for what all of them share.
    """
    done = len(records)
    if done < kept + 2:
        return None
    spent = sum(record.seconds for record in records[kept:])
    return float(spent * (costs[-1] - costs[done]) / (costs[done] - costs[kept]))


def farewell(folder: Path, pictures: Sequence[str], remarks: str = "") -> str:
    """Return where the results are, and how to look at them.

    Parameters
    ----------
    folder : path
    pictures : sequence of str
        Names of files.
    remarks : str
        What to tell before.

    Returns
    -------
    str
    """
    lines = ["", *([remarks] if remarks else []), f"Results are in {folder}:"]
    lines += [f"  {folder / name}" for name in pictures]
    if not pictures:
        lines.append(
            "  (no pictures: nothing touched, or matplotlib is not installed; when it "
            f"is: ase-roughcontact figure {folder})"
        )
    lines += [
        f"  {folder / 'curve.csv'}",
        f"  {folder / 'sweep.traj'}, all atoms",
        f"  {folder / 'view.traj'}, to look at:",
        f"    ase gui -R=-60x {folder / 'view.traj'}",
        "In the window of ase gui choose View > Colors > By tag (1: contact) or",
        "By initial charge (pressure in GPa), and step through the frames.",
    ]
    return "\n".join(lines)


def touching_height(scene: Scene, records: Sequence[LoadStep]) -> str:
    """Return a line on the height at which a path of heights touches, else nothing.

    Parameters
    ----------
    scene : Scene
    records : sequence of LoadStep

    Returns
    -------
    str
    """
    if scene.path.control != "height" or not records:
        return ""
    first = records[0].height + records[0].penetration
    return f"The sphere touches the flat surface at a height of {first:.4g} Å."


def largest_tension(laws: Reference, records: Sequence[LoadStep]) -> str:
    """Return a line on the largest tension of a path, empty if there is none.

    Parameters
    ----------
    laws : Reference
    records : sequence of LoadStep

    Returns
    -------
    str
    """
    forces = [record.normal_force for record in records if record.converged]
    least = min(forces, default=0.0)
    if least >= 0.0:
        return ""
    told = f"Largest tension of the path: {least / NANONEWTON:.4g} nN"
    if laws.smooth.pull_off_force < 0.0:
        pull_off = laws.smooth.pull_off_force / NANONEWTON
        told += f"; pull-off force: {pull_off:.4g} nN ({laws.smooth.label})"
    return f"{told}."


def _depth(scene: Scene) -> str:
    return "depth (Å)" if scene.path.control == "penetration" else "height (Å)"


def _mark(scene: Scene, record: LoadStep) -> str:
    """Return what is wrong with a step, and the load that pulled the indenter off."""
    if record.converged:
        return ""
    felt = record.repulsive_atoms + record.attractive_atoms
    target = float(scene.steps[record.step])
    if scene.path.control == "load" and target < 0.0 and not felt:
        return f"   PULLED OFF: no contact holds {target / NANONEWTON:.4g} nN"
    unit = " (forces in eV/Å)" if "force" in record.message else ""
    return f"   NOT CONVERGED: {record.message}{unit}"


def _ratio(area: float, other: float, width: int) -> str:
    """Return the ratio of two areas, a dash where there is none."""
    known = np.isfinite(area) and other > 0.0
    return f"{area / other:{width}.4f}" if known else f"{'-':>{width}}"
