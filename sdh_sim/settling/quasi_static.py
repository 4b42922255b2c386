"""Hand and object moving slowly, increment by increment, contacts found anew in each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.poses import rotation_of
from sdh_sim.settling.increment import Contacts, Increment, Springs, solve_increment

if TYPE_CHECKING:
    from sdh_sim.settling.grasp_model import GraspModel, Touch

VISCOSITY = 200.0  # against the motion of an increment [N/m]
LONGEST = 1e-3  # motion of an increment [m]
TABLE_FRICTION = 0.5  # as models/cell has it; an object that is smoother in hand is so there, too
EASE = 4.0  # by so much the viscosity may fall from one increment to the next


@dataclass(frozen=True)
class Laws:
    """Forces that do not change during the motion.

    Attributes:
        stiffness: of every geom's contacts [N/m] (ngeom,).
        friction: coefficient of all contacts but those of a rougher object with the table.
        torque_limits: of the motors (k,) [N m or N].
        down: direction of the weight in the model's world (3,).
        weight: of the object [N].
        centre: its centre of mass in its frame (3,) [m].
    """

    stiffness: np.ndarray
    friction: float
    torque_limits: np.ndarray
    down: np.ndarray
    weight: float
    centre: np.ndarray


@dataclass(frozen=True)
class State:
    """Where hand and object are, and what their contacts and motors remember.

    Attributes:
        qpos: coordinates of the model.
        references: of the motors' servos (k,) [rad or m].
        geoms, points: of the contacts that bore a friction force (c, 2), (c, 3) [m].
        tangential: friction forces on the second geoms (c, 3) [N].
        normal: normal forces (c,) [N].
        torques: of the motors (k,) [N m or N].
        on_table: the table bears some of the object's weight.
        moved: greatest motion of a part in the last increment, times ``factor`` [m].
        factor: on the viscosity in that increment.
    """

    qpos: np.ndarray
    references: np.ndarray
    geoms: np.ndarray
    points: np.ndarray
    tangential: np.ndarray
    normal: np.ndarray
    torques: np.ndarray
    on_table: bool = False
    moved: float = np.inf
    factor: float = 1.0


class QuasiStatic:
    """Advances states of a grasp.

    Args:
        model: hand, object and table.
        laws: the forces between them.
        longest: motion of an increment at most [m].
        frozen: keep the contacts that the first state has, moved along with what they are on,
            instead of finding them anew: a comparison, not a method to use.
    """

    def __init__(
        self, model: GraspModel, laws: Laws, longest: float = LONGEST, frozen: bool = False
    ) -> None:
        self.model, self.laws, self._longest = model, laws, longest
        self._frozen: Touch | None = None
        self._freeze = frozen
        self._origin = np.zeros(0)
        self._viscosity = VISCOSITY * model.reach**2

    def start(self, qpos: np.ndarray, torques: np.ndarray) -> State:
        """A state without friction forces."""
        nothing = np.zeros((0, 3))
        return State(
            qpos, np.zeros(len(torques)), np.zeros((0, 2), int), nothing, nothing,
            np.zeros(0), torques,
        )  # fmt: skip

    def grip(self, state: State) -> State:
        """An increment of the hand alone: motors at their torque, the object where it is.

        A servo's stiffness keeps the increment small where nothing resists; the torque that it
        takes off comes back with the next one.
        """
        return self._advance(state, None)

    def release(self, state: State, torques: np.ndarray) -> State:
        """The state with servo references at which the motors exert these torques (k,) now."""
        self.model.look(state.qpos)
        return replace(
            state, references=self.model.moment_arms()[1] + torques / self.model.stiffness
        )

    def advance(self, state: State, load: float) -> State:
        """An increment of hand and object, under so many times the object's weight."""
        return self._advance(state, load)

    def _advance(self, state: State, load: float | None) -> State:
        """An increment; without a load the object does not move and motors keep their torque."""
        model, laws = self.model, self.laws
        model.look(state.qpos)
        arms, lengths = model.moment_arms()
        asked = model.stiffness * (state.references - lengths)
        force = state.torques if load is None else asked
        hand = model.mechanism()
        touch = self._touch(state.qpos)
        springs = Springs(
            np.concatenate((arms, hand.rows)),
            np.concatenate((force, hand.force)),
            np.concatenate((model.stiffness, hand.stiffness)),
            np.concatenate((-laws.torque_limits, hand.lower)),
            np.concatenate((laws.torque_limits, hand.upper)),
        )
        contacts = self._contacts(state, touch)
        free = np.ones(len(model.of_object), dtype=bool) if load is not None else ~model.of_object
        found = _solve(
            contacts, springs, self._load(load or 0.0), self._viscosity, model.reach, free,
            self._longest, state.factor / EASE,
        )  # fmt: skip
        on_table = (touch.geoms == model.table).any(axis=1) & (found.normal > 0.0)
        motors = len(arms)
        return State(
            qpos=model.move(state.qpos, found.motion),
            references=state.references,
            geoms=touch.geoms,
            points=touch.points,
            tangential=found.tangential,
            normal=found.normal,
            torques=state.torques if load is None else found.force[:motors],
            on_table=bool(on_table.any()),
            moved=float((np.abs(found.motion) * model.reach).max()) * found.factor,
            factor=found.factor,
        )

    def _touch(self, qpos: np.ndarray) -> Touch:
        if not self._freeze:
            return self.model.touch()
        if self._frozen is None:
            self._frozen, self._origin = self.model.touch(), qpos
        before = self._frozen
        moved = self.model.motion_between(self._origin, qpos)
        approach = np.einsum("ci,cij,j->c", before.normal, before.jacobian, moved)
        return before._replace(gap=before.gap + approach)

    def _contacts(self, state: State, touch: Touch) -> Contacts:
        stiffness = self.laws.stiffness[touch.geoms].min(axis=1)
        own = self.laws.friction
        on_table = (touch.geoms == self.model.table).any(axis=1)
        friction = np.where(on_table, min(own, TABLE_FRICTION), own)
        carried = carried_over(state, touch)
        return Contacts(touch.jacobian, touch.normal, touch.gap, stiffness, friction, carried)

    def _load(self, load: float) -> np.ndarray:
        """The object's weight as a generalised force; its turns are about its own axes."""
        model, laws = self.model, self.laws
        at = model.object_dof
        force = load * laws.weight * laws.down
        axes = rotation_of(model.data.xquat[model.object_body])
        generalised = np.zeros(model.model.nv)
        generalised[at : at + 3] = force
        generalised[at + 3 : at + 6] = np.cross(laws.centre, axes.T @ force)
        return generalised


def carried_over(state: State, touch: Touch) -> np.ndarray:
    """Friction forces of the last increment on the contacts found now (c, 3) [N].

    Contacts are the same where both geoms are. Where a pair has several, each of the new ones takes
    over from the nearest old one, which is shared evenly. The force turns with the surface: it
    keeps its size and its direction in the tangent plane.
    """
    carried = np.zeros((len(touch.gap), 3))
    known: dict[tuple[int, int], list[int]] = {}
    for k, pair in enumerate(map(tuple, state.geoms.tolist())):
        if state.normal[k] > 0.0:
            known.setdefault(pair, []).append(k)
    heirs: dict[int, list[int]] = {}
    for k, pair in enumerate(map(tuple, touch.geoms.tolist())):
        old = known.get(pair)
        if old is None:
            continue
        nearest = old[0]
        if len(old) > 1:
            distance = ((state.points[old] - touch.points[k]) ** 2).sum(axis=1)
            nearest = old[int(distance.argmin())]
        heirs.setdefault(nearest, []).append(k)
    for old, new in heirs.items():
        carried[new] = state.tangential[old] / len(new)
    size = np.sqrt((carried * carried).sum(axis=1))
    carried -= (carried * touch.normal).sum(axis=1)[:, None] * touch.normal
    left = np.sqrt((carried * carried).sum(axis=1))
    return carried * (size / np.maximum(left, 1e-12))[:, None]


def _solve(
    contacts: Contacts,
    springs: Springs,
    load: np.ndarray,
    viscosity: np.ndarray,
    reach: np.ndarray,
    free: np.ndarray,
    longest: float,
    factor: float,
) -> Increment:
    """As ``solve_increment``; coordinates that are not free (n,) do not move."""
    if free.all():
        return solve_increment(contacts, springs, load, viscosity, reach, longest, factor)
    found = solve_increment(
        contacts._replace(jacobian=np.ascontiguousarray(contacts.jacobian[:, :, free])),
        springs._replace(rows=np.ascontiguousarray(springs.rows[:, free])),
        load[free],
        viscosity[free],
        reach[free],
        longest,
        factor,
    )
    motion = np.zeros(len(load))
    motion[free] = found.motion
    return found._replace(motion=motion)
