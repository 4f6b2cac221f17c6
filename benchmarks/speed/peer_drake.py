# SPDX-License-Identifier: BSD-3-Clause
"""Drake: trees as continuous systems, loops by the discrete solver, the only one with ball constraints."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from benchmarks.speed import peer
from benchmarks.speed.tree import Tree
from pydrake.all import (
    Adder,
    ConstantVectorSource,
    DiagramBuilder,
    DiscreteContactApproximation,
    FixedOffsetFrame,
    LinearSpringDamper,
    MultibodyPlant,
    PrismaticJoint,
    PrismaticSpring,
    ResetIntegratorFromFlags,
    RevoluteJoint,
    RevoluteSpring,
    RigidTransform,
    RotationalInertia,
    RotationMatrix,
    Simulator,
    Sine,
    SpatialInertia,
)

CONTINUOUS = "runge_kutta3"
DISCRETE = "discrete"


@dataclass
class Plant:
    """A mechanism in a diagram with its motors, at its start. step [s]: of the discrete solver; 0:
    continuous.
    """

    tree: Tree
    step: float = 0.0
    motors: bool = True
    actuators: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.builder = DiagramBuilder()
        self.plant = self.builder.AddSystem(MultibodyPlant(self.step))
        self.plant.set_name("plant")
        if self.step:
            self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
        self.plant.mutable_gravity_field().set_gravity_vector(np.array(self.tree.gravity, float))
        self.bodies: list[Any] = []
        self.joints: list[Any] = []
        for i in range(len(self.tree.bodies)):
            self._add_body(i)
        self._add_rest()
        self.plant.Finalize()
        if self.actuators and self.motors:
            self._add_motors()
        elif self.actuators:
            self.builder.ExportInput(self.plant.get_actuation_input_port(), "torque")
        self.diagram = self.builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.own = self.plant.GetMyMutableContextFromRoot(self.context)
        for joint, b in zip(self.joints, self.tree.bodies, strict=True):
            (joint.set_translation if b.slides else joint.set_angle)(self.own, b.q)
            (joint.set_translation_rate if b.slides else joint.set_angular_rate)(self.own, b.v)

    def _body(self, i: int) -> Any:
        return self.plant.world_body() if i < 0 else self.bodies[i]

    def _add_body(self, i: int) -> None:
        b = self.tree.bodies[i]
        I = np.asarray(b.inertia, float)  # noqa: E741 (inertia)
        moments = RotationalInertia(I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2])
        inertia = SpatialInertia.MakeFromCentralInertia(b.mass, np.array(b.com, float), moments)
        self.bodies.append(self.plant.AddRigidBody(f"b{i}", inertia))
        place = RigidTransform(RotationMatrix(b.R), np.array(b.position, float))
        frame = self.plant.AddFrame(FixedOffsetFrame(f"f{i}", self._body(b.parent).body_frame(), place))
        kind = PrismaticJoint if b.slides else RevoluteJoint
        ends = (frame, self.bodies[-1].body_frame(), np.array(b.axis, float))
        joint = self.plant.AddJoint(kind(f"j{i}", *ends, damping=float(b.damping)))
        self.joints.append(joint)
        if b.driven:
            self.plant.AddJointActuator(f"m{i}", joint)
            self.actuators.append(i)
        if b.stiffness:
            spring = PrismaticSpring if b.slides else RevoluteSpring
            self.plant.AddForceElement(spring(joint, b.reference, b.stiffness))

    def _add_rest(self) -> None:
        for c in self.tree.closures:
            points = (np.array(c.at_first, float), np.array(c.at_second, float))
            self.plant.AddBallConstraint(self._body(c.first), points[0], self._body(c.second), points[1])
        for s in self.tree.springs:
            ends = (self._body(s.first), np.array(s.at_first, float), self._body(s.second))
            self.plant.AddForceElement(
                LinearSpringDamper(
                    *ends, np.array(s.at_second, float), s.length, s.stiffness, max(s.damping, 1e-12)
                )
            )

    def _add_motors(self) -> None:
        moved = [self.tree.bodies[i] for i in self.actuators]
        constant = self.builder.AddSystem(ConstantVectorSource(np.array([b.tau for b in moved])))
        numbers = [np.array([getattr(b, name) for b in moved]) for name in ("amplitude", "omega", "phase")]
        sine = self.builder.AddSystem(Sine(*numbers))
        total = self.builder.AddSystem(Adder(2, len(moved)))
        self.builder.Connect(constant.get_output_port(), total.get_input_port(0))
        self.builder.Connect(sine.get_output_port(0), total.get_input_port(1))
        self.builder.Connect(total.get_output_port(), self.plant.get_actuation_input_port())

    def coordinates(self) -> list[float]:
        """Return the joint coordinates by body."""
        return [
            float(joint.get_translation(self.own) if b.slides else joint.get_angle(self.own))
            for joint, b in zip(self.joints, self.tree.bodies, strict=True)
        ]


def forward(tree: Tree) -> None:
    """Time a step of the explicit Euler method in Drake's loop: one evaluation."""
    if tree.closures:
        return
    plant = Plant(tree)
    simulator = Simulator(plant.diagram, plant.context)
    ResetIntegratorFromFlags(simulator, "explicit_euler", 1e-6)
    simulator.Initialize()
    calls = max(20, 2000 // len(tree.bodies))

    def once() -> float:
        end = plant.context.get_time() + 1e-6 * calls
        return peer.timed(lambda: simulator.AdvanceTo(end)) / calls

    peer.print_time(tree.name, "explicit_euler step", peer.least(once))


def step(tree: Tree) -> None:
    """Time a step of 1 ms with a new torque, in a loop in Python as users write it."""
    discrete = bool(tree.closures)
    plant = Plant(tree, 1e-3 if discrete else 0.0, motors=False)
    simulator = Simulator(plant.diagram, plant.context)
    if not discrete:
        ResetIntegratorFromFlags(simulator, CONTINUOUS, 1e-3)
        simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.Initialize()
    torques = peer.torques(tree, peer.ROUNDS)[:, plant.actuators]
    port = plant.diagram.get_input_port(0)
    end: list[float] = []

    def once() -> float:
        start = plant.context.get_time()

        def loop() -> None:
            for k in range(peer.ROUNDS):
                port.FixValue(plant.context, torques[k])
                simulator.AdvanceTo(start + (k + 1) * 1e-3)

        taken = peer.timed(loop) / peer.ROUNDS
        end.extend(plant.coordinates())
        return taken

    taken = peer.least(once, 3)
    peer.print_time(tree.name, DISCRETE if discrete else CONTINUOUS, taken, end[: len(tree.bodies)])


def run(tree: Tree, method: str, setting: float) -> None:
    def once() -> peer.Run:
        plant = Plant(tree, setting if method == DISCRETE else 0.0)
        simulator = Simulator(plant.diagram, plant.context)
        if method != DISCRETE:
            ResetIntegratorFromFlags(simulator, method, tree.sample)
            integrator = simulator.get_mutable_integrator()
            integrator.set_fixed_step_mode(False)
            integrator.set_target_accuracy(setting)
        simulator.Initialize()
        return peer.sampled(
            tree, plant.coordinates, lambda end: (peer.timed(partial(simulator.AdvanceTo, end)), True)
        )

    peer.print_fastest(tree, method, setting, once, 2)


if __name__ == "__main__":
    peer.main(forward, step, run)
