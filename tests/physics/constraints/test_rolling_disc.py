# SPDX-License-Identifier: BSD-3-Clause
"""A disc rolling on a plane, against reduced equations, closed forms of steady turning and Newton's law."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, rotation
from models.disc import (
    ACROSS,
    AXIAL,
    MASS,
    RADIUS,
    ROLLED_AXIAL,
    WOBBLING,
    Rolling,
    disc,
    flying_disc,
    frequency_squared,
    steady,
    truth,
)
from models.running import Recording, assert_close, run
from scipy.spatial.transform import Rotation

import gelenk

TIMES = np.linspace(0, 4, 81)
PLANE_ROTATION, PLANE_POSITION = rotation([1, 2, -1], 0.9), np.array([0.3, -0.2, 0.5])


def turns(found: Recording) -> Rotation:
    return Rotation.from_quat(found.vector("hub.Q"))


@pytest.mark.parametrize("make", [disc, flying_disc])
def test_motion_and_contact_forces_match_the_reduced_equations(make: Callable[[], Scene]) -> None:
    found = run(make(), TIMES, tolerance=1e-11)
    for name, expected in truth(WOBBLING, TIMES).items():
        if name in found.values:
            assert_close(name, found[name], expected, 1e-9, "100 rtol")


def test_plane_may_have_any_pose() -> None:
    """Disc, plane and gravity are rotated and displaced together; coordinates are relative to the plane."""
    found = run(disc(R=PLANE_ROTATION, p=PLANE_POSITION), TIMES, tolerance=1e-11)
    expected = truth(WOBBLING, TIMES)
    for name in ("lean.phi", "base.s_x", "spin.phi", "tyre.f_n", "tyre.f_lat", "tyre.f_long"):
        assert_close(name, found[name], expected[name], 1e-9, "100 rtol")
    contact = np.array([expected[f"tyre.r[{i}]"] for i in (1, 2, 3)]).T
    assert_close(
        "contact", found.vector("tyre.r"), contact @ PLANE_ROTATION.T + PLANE_POSITION, 1e-9, "100 rtol"
    )


@pytest.mark.parametrize("make", [disc, flying_disc])
def test_contact_obeys_newtons_law_and_does_not_slip(make: Callable[[], Scene]) -> None:
    """The change of momentum, by the sensor at the hub, is the time integral of contact force and weight."""
    times = np.linspace(0, 1, 1001)
    found = run(make(), times, tolerance=1e-11)
    axis = turns(found).apply([0, 1, 0])
    normal = np.array([0, 0, 1.0])
    heading = np.cross(axis, normal)
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    force = (
        found["tyre.f_n"][:, None] * normal
        + found["tyre.f_long"][:, None] * heading
        + found["tyre.f_lat"][:, None] * np.cross(normal, heading)
    )
    total = force - [0, 0, MASS * GRAVITY]
    # Simpson's rule over each two steps of 1 ms: h^4 / 90 times fourth derivatives, about 2 N (10 rad/s)^4.
    added = (total[:-2:2] + 4 * total[1::2] + total[2::2]) * 1e-3 / 3
    momentum = MASS * found.vector("hub.v")
    assert_close("momentum", np.diff(momentum[::2], axis=0), added, 1e-11, "Simpson's rule")

    arm = found.vector("tyre.r") - found.vector("hub.r")
    slip = found.vector("hub.v") + np.cross(turns(found).apply(found.vector("hub.w")), arm)
    assert_close("slip", slip, 0, 1e-12, "projected")
    assert_close("height", found["tyre.r[3]"], 0, 1e-12, "projected")
    assert_close("radius", np.linalg.norm(arm, axis=1), RADIUS, 1e-12, "round-off")
    assert_close("in the disc's plane", np.sum(arm * axis, axis=1), 0, 1e-12, "round-off")


@pytest.mark.parametrize("make", [disc, flying_disc])
def test_energy_and_constraints_do_not_drift_in_ten_minutes(make: Callable[[], Scene]) -> None:
    """The forces of rolling do no work; the errors of the constraints do not grow."""
    found = run(make(), np.linspace(0, 600, 61), tolerance=1e-10)
    energy = found["energy.total"]
    assert np.ptp(energy) / energy[0] < 1e-9  # 10 rtol; 4000 wobbles
    assert found["constraints.position"].max() < 1e-11
    assert found["constraints.velocity"].max() < 1e-11


CIRCLES = [steady(0.2, 6.0), steady(-0.3, 12.0), steady(0.5, 4.5), steady(0.05, -9.0)]
SPEEDS = ["base.w", "lean.w", "spin.w"]


@pytest.mark.parametrize("circle", CIRCLES)
def test_steady_turning(circle: Rolling) -> None:
    """The closed form is an equilibrium of the three velocities and continues for ten seconds on a circle."""
    found = run(disc(circle), np.linspace(0, 10, 51), tolerance=1e-11)
    for name in ("lean.a", "base.wd", "spin.a"):
        assert_close(name, found[name][0], 0, 1e-12, "round-off of 10^2 rad/s2")
    assert_close("lean", found["lean.phi"], circle.lean, 1e-9, "100 rtol")
    spin = circle.spin + circle.yaw_rate * np.sin(circle.lean)
    radius = RADIUS * spin / circle.yaw_rate
    for name, offset in (("base.s_x", np.sin), ("base.s_y", lambda angle: 1 - np.cos(angle))):
        expected = radius * offset(circle.yaw_rate * found.time)
        assert_close(name, found[name], expected, 1e-8, "1000 rtol: 10 s, radii of 10 m")


@pytest.mark.parametrize("circle", CIRCLES)
def test_steady_turning_is_found_from_spin_and_lean(circle: Rolling) -> None:
    start = Rolling(circle.lean, 0.0, 0.9 * circle.yaw_rate, circle.spin)
    found = gelenk.equilibrium(
        disc(start), steady={"base.w": None, "spin.w": circle.spin}, hold={"lean.phi": circle.lean}
    )
    assert_close("yaw rate", found.values["base.w"], circle.yaw_rate, 1e-9, "residual 1e-8 or less")
    assert set(found.advancing) == {"base.s_x", "base.phi", "spin.phi"}


@pytest.mark.parametrize("circle", CIRCLES)
def test_steady_turning_is_marginal_with_the_frequency_of_the_closed_form(circle: Rolling) -> None:
    """Five coordinates, three velocities. Zero eigenvalues: cyclic coordinates, and families of circles."""
    model = gelenk.linear.linear_model(disc(circle))
    assert len(model.states) == 8
    assert set(model.states[5:]) == set(SPEEDS)  # the ones that are constant
    poles = sorted(np.linalg.eigvals(model.A), key=lambda s: s.imag)
    assert_close("frequency", poles[-1].imag, np.sqrt(frequency_squared(circle)), 1e-11, "round-off")
    assert_close("growth", [s.real for s in (poles[0], poles[-1])], 0, 1e-12, "round-off")
    assert abs(np.array(poles[1:-1])).max() < 1e-6  # zeros in a Jordan block of two: root of round-off


def test_upright_disc_is_unstable_below_the_critical_speed() -> None:
    """Stable straight ahead for w^2 > m g R A / (C (C + m R^2)) (Neimark & Fufaev 1972)."""
    critical = np.sqrt(MASS * GRAVITY * RADIUS * ACROSS / (AXIAL * ROLLED_AXIAL))
    for factor, grows in ((0.999, True), (1.001, False)):
        model = gelenk.linear.linear_model(disc(steady(0.0, factor * critical)))
        poles = np.linalg.eigvals(model.A)
        expected = frequency_squared(Rolling(0.0, 0.0, 0.0, factor * critical))
        assert (expected < 0) == grows == (poles.real.max() > 0.1)
        assert_close("pole", abs(poles).max(), np.sqrt(abs(expected)), 1e-10, "round-off, near a double zero")


def named_in(warning: str) -> set[str]:
    assert "is not an equilibrium: " in warning
    return {part.split()[0] for part in warning.partition("equilibrium: ")[2].split(", ")}


def test_coordinates_that_change_are_reported() -> None:
    """Of the default states, position, heading and spin angle change; the velocities are constant."""
    with pytest.warns(gelenk.OperatingPointWarning) as warned:
        gelenk.linearize(disc(steady(0.2, 6.0)))
    assert named_in(str(warned[0].message)) == {"base.s_x", "base.phi", "spin.phi"}  # the heading is x


@pytest.mark.parametrize(
    ("speeds", "changing"),
    [(["base.v_x", "base.v_y", "base.w"], "base.v_y"), (["base.v_x", "base.v_y", "spin.w"], "base.v_y")],
)
def test_velocities_that_change_distort_the_poles_of_a_stable_circle(
    speeds: list[str], changing: str
) -> None:
    """Poles with states vx and vy, which change with the heading, are not those of the wobble: a warning."""
    circle = steady(0.2, 6.0)
    states = ["base.s_x", "base.s_y", "base.phi", "lean.phi", "spin.phi", *speeds]
    with pytest.warns(gelenk.OperatingPointWarning) as warned:
        plant = gelenk.linearize(disc(circle), states=states)
    assert changing in named_in(str(warned[0].message))
    assert abs(plant.poles().imag.max() - np.sqrt(frequency_squared(circle))) > 0.01
    if "base.w" in speeds:
        assert plant.poles().real.max() > 0.3  # the disc that looked unstable


def test_velocities_in_the_axes_of_a_spinning_body_change_too() -> None:
    with pytest.warns(gelenk.OperatingPointWarning) as warned:
        plant = gelenk.linearize(flying_disc(steady(0.2, 6.0)))
    assert "free.w[1]" in named_in(str(warned[0].message))
    assert plant.poles().real.max() > 1


# Bounds of errors of angles, velocities and forces, at a tolerance of 1e-10 or with steps of 1 ms.
ADAPTIVE = ("ida", "erk", "cvode", "cvode-adams", "dirk")
SECOND_ORDER = ("generalized-alpha", "hht", "newmark")
BOUNDS = dict.fromkeys(ADAPTIVE, 1e-8) | {"rk4": 1e-7, "euler": 1.0} | dict.fromkeys(SECOND_ORDER, 3e-3)
INDEX1 = ("projection", "baumgarte", "udwadia-kalaba", "augmented-lagrangian", "penalty")
PENALTY = 3e-6  # the constraint error that causes its forces: lambda / (a Omega^2), docs/scene-format.md
COMPARED = ["lean.phi", "spin.phi", "base.s_x", *SPEEDS, "tyre.f_n", "tyre.f_lat", "tyre.f_long"]


def errors(formulation: str, integrator: str, step: float = 1e-3, stop: float = 1.0) -> float:
    source = disc()
    fixed = integrator not in ADAPTIVE
    source["solver"] = {
        "formulation": formulation, "integrator": integrator, **({"step": step} if fixed else {})
    }  # fmt: skip
    times = np.linspace(0, stop, 11)
    found: dict[str, list[float]] = {name: [] for name in COMPARED}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-10)
    index = {signal.name: i for i, signal in enumerate(plant.outputs)}
    for t in times:
        if t > 0:
            plant.step_to(float(t))
        values = plant.values()
        for name in COMPARED:
            found[name].append(values[index[name]])
    expected = truth(WOBBLING, times)
    return max(float(abs(np.array(found[name]) - expected[name]).max()) for name in COMPARED)


@warned.TIGHT
@pytest.mark.parametrize("integrator", BOUNDS)
@pytest.mark.parametrize("formulation", INDEX1)
def test_every_formulation_matches_the_reduced_equations(formulation: str, integrator: str) -> None:
    bound = max(BOUNDS[integrator], PENALTY if formulation == "penalty" else 0.0)
    assert errors(formulation, integrator) < bound


@pytest.mark.parametrize(
    ("formulation", "bound"),
    [("index3", 1e-6), ("stabilized-index2", 1e-8)],  # index 3: see test_dae_forms
)
def test_formulations_with_multipliers_as_unknowns_match_the_reduced_equations(
    formulation: str, bound: float
) -> None:
    assert errors(formulation, "ida") < bound


@pytest.mark.parametrize("integrator", SECOND_ORDER)
def test_index3_with_fixed_steps_matches_the_reduced_equations(integrator: str) -> None:
    assert errors("index3", integrator) < BOUNDS[integrator]


@pytest.mark.parametrize(("integrator", "order"), [("rk4", 4), ("euler", 1), *((n, 2) for n in SECOND_ORDER)])
def test_order_of_fixed_steps(integrator: str, order: int) -> None:
    """Halving the step divides the error by 2^order; rk4 uses larger steps, since 1 ms leads to round-off."""
    step = 1e-2 if integrator == "rk4" else 2e-3
    ratio = errors("projection", integrator, step) / errors("projection", integrator, step / 2)
    assert abs(np.log2(ratio) - order) < 0.35


def test_formulation_in_independent_coordinates_is_rejected() -> None:
    source = disc() | {"solver": {"formulation": "independent"}}
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.Simulation(gelenk.load(source)).initialize()
    assert str(error.value).endswith(
        "solver.formulation: found 'independent' with constraints.tyre, which constrains velocities but no "
        "positions, expected another formulation, such as projection"
    )


def fallen(source: Scene, tolerance: float) -> tuple[gelenk.Simulation, str]:
    """The plant after a step within one second has failed, and the error message."""
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, tolerance)

    def fall() -> None:
        for k in range(1, 101):
            plant.step_to(0.01 * k)

    with pytest.raises(gelenk.StepError) as error:
        fall()
    return plant, str(error.value)


FALLING = Rolling(0.3, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-11])
def test_step_fails_when_the_wheel_falls_flat(tolerance: float) -> None:
    """From rest. The plant keeps the state at the end of the last step, and its outputs can be read."""
    plant, why = fallen(disc(FALLING), tolerance)
    # Energy gives the rate; the fall takes the integral of its inverse.
    lean = np.linspace(0.3, np.pi / 2, 200001)[1:]
    work = 2 * MASS * GRAVITY * RADIUS * (np.cos(0.3) - np.cos(lean)) / (ACROSS + MASS * RADIUS**2)
    u = np.sqrt(lean - 0.3)  # d lean = 2 u du removes the singularity at the start
    flat_at = np.trapezoid(2 * u / np.sqrt(work), u)
    assert flat_at - 0.011 < plant.time < flat_at
    assert np.isfinite(plant.values()).all()
    assert 1.2 < plant.output("lean.phi") < np.pi / 2
    assert "The state is unchanged at t = 0.48 s" in why


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-11])
@pytest.mark.parametrize("make", [disc, flying_disc])
def test_wheel_that_lies_flat_is_reported(make: Callable[[Rolling], Scene], tolerance: float) -> None:
    _, why = fallen(make(FALLING), tolerance)
    assert "the wheel of wheel lies flat on its plane, where it has no contact point" in why


def test_wheel_that_lies_flat_at_the_start_is_rejected() -> None:
    with pytest.raises(gelenk.AssemblyError, match=r"constraints\.tyre: found the wheel flat on its plane"):
        gelenk.Simulation(gelenk.load(flying_disc(Rolling(np.pi / 2, 0.0, 0.0, 0.0)))).initialize()


def test_uncoupled_discs_are_islands_and_roll_independently() -> None:
    one, other = disc(), flying_disc(steady(0.5, 4.5))
    other["bodies"] = {"coin": other["bodies"]["wheel"]}
    other["joints"]["free"]["child"]["body"] = "coin"
    both = one | {
        "bodies": one["bodies"] | other["bodies"],
        "joints": one["joints"] | other["joints"],
        "constraints": one["constraints"] | {"edge": other["constraints"]["tyre"] | {"body": "coin"}},
    }
    assert gelenk.inspect(gelenk.load(both)).reduced.islands == 2
    found = run(both, TIMES, tolerance=1e-11)
    for name, expected in truth(WOBBLING, TIMES).items():
        assert_close(name, found[name], expected, 1e-9, "100 rtol")
    for name, expected in truth(steady(0.5, 4.5), TIMES).items():
        if name.startswith("tyre."):
            assert_close(name, found[name.replace("tyre", "edge")], expected, 1e-8, "1000 rtol: 10 rad/s")


def test_plane_on_a_body_welded_to_the_ground() -> None:
    source = disc()
    source["bodies"]["slab"] = {"mass": 4.0, "com": [0, 0, -0.1]}
    source["joints"]["bolt"] = {
        "type": "weld", "parent": {"body": "ground", "position": [0, 0, 0.3]}, "child": "slab"
    }  # fmt: skip
    source["constraints"]["tyre"]["on"] = {"body": "slab", "position": [0, 0, -0.3]}
    found = run(source, TIMES, tolerance=1e-11)
    for name, expected in truth(WOBBLING, TIMES).items():
        assert_close(name, found[name], expected, 1e-9, "100 rtol")


@pytest.mark.parametrize("corrections", [1, 2])
def test_fixed_number_of_corrections_keeps_the_constraints(corrections: int) -> None:
    """With rk4 and steps of equal cost: one correction leaves the square of the drift of a step."""
    source = disc() | {"solver": {"integrator": "rk4", "step": 1e-3, "corrections": corrections}}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    for k in range(1, 1001):
        plant.step_to(k * 1e-3)
        assert plant.diagnostics["constraints.position"] < 1e-12
        assert plant.diagnostics["constraints.velocity"] < 1e-9
    assert_close(
        "lean", plant.output("lean.phi"), truth(WOBBLING, np.array([0.0, 1.0]))["lean.phi"][-1], 1e-8, "rk4"
    )
