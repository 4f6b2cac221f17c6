# SPDX-License-Identifier: BSD-3-Clause
"""The test cases of the stability map: each provokes one kind of failure."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from gelenk.chart import mechanisms
from gelenk.chart.case import Array, Case, Jumps
from gelenk.chart.mechanisms import GRAVITY
from gelenk.chart.quadrature import monotonic_motion, rotation

type Truth = Callable[[Array], dict[str, Array]]

# The IVP Test Set's solution of Andrews' squeezer at 0.03 s (Lioen & de Swart; PSIDE at 1e-14): angle, rate.
ANDREWS = {
    "beta": (15.81077119629904, 1139.920302151208),
    "Theta": (-15.75637105984298, -1424.379294994111),
    "gamma": (0.04082224013073101, 11.03291221937134),
    "Phi": (-0.5347301163226948, 19.29337464421385),
    "delta": (0.5244099658805303, 0.5735699284790808),
    "Omega": (0.5347301163226948, -19.29337464421385),
    "epsilon": (1.048080741042263, 0.3231791658026955),
}
# x [m] and theta [rad] of the light cart-pole by time [s], published by its author (N. Parsons 2026).
LIGHT_CART_POLE = {
    9.3: (0.0656191393387692, 1.20651709172129),
    9.5: (1.38736119304381, -0.397769100457376),
    9.7: (1.96354957422484, -1.29997515003022),
    9.9: (1.99998277728396, -1.56527858004052),
    10.0: (1.99976328246162, -1.54912944189708),
}
TORQUE = Jumps(3.0, 10.0)  # N m


class FourBarChainTruth:
    """Closed form of the N-four-bar: all cranks are parallel, so that it is a pendulum.

    I phi'' = P g sin phi with phi from the upright, I = (N+1)/3 + N [kg m²], P = (N+1)/2 + N [kg m].
    """

    def __init__(self, n: int, rate: float) -> None:
        self.n, self.rate = n, rate

    def __call__(self, times: Array) -> dict[str, Array]:
        """Return the joint states by output name at times [s], each of shape (times,)."""
        moment, weight = (self.n + 1) / 3 + self.n, GRAVITY * ((self.n + 1) / 2 + self.n)
        phi, w = rotation(
            lambda x: np.full_like(x, moment), lambda x: weight * np.cos(x), 0.0, self.rate, times
        )
        crank = math.pi / 2 - phi
        out: dict[str, Array] = {}
        for i in range(self.n + 1):
            out |= {f"A{i}.phi": crank, f"A{i}.w": -w}
        for i in range(self.n):
            out |= {f"{joint}{i}.{kind}": x for joint in "BC" for kind, x in (("phi", -crank), ("w", w))}
        return out


def parallelogram_truth(times: Array) -> dict[str, Array]:
    """Return the joint states of the parallelogram at times [s].

    The coupler only translates: a pendulum with I = 2 I_O + m_c L² = 0.132 kg m² and a weight moment of
    3.8259 N m.
    """
    phi, w = rotation(
        lambda x: np.full_like(x, 2 * 0.03 + 0.8 * 0.09),
        lambda x: GRAVITY * (2 * 0.5 * 0.15 + 0.8 * 0.3) * np.sin(x),
        -math.pi / 2,
        12.0,
        times,
    )
    ends = dict.fromkeys("AD", (phi, w)) | dict.fromkeys("BC", (-phi, -w))
    return {
        f"{joint}.{kind}": x
        for joint, both in ends.items()
        for kind, x in zip(("phi", "w"), both, strict=True)
    }


def equal_slider_crank_truth(times: Array) -> dict[str, Array]:
    """Return the joint states of the equal-link slider-crank at times [s].

    The rod mirrors the crank, and the slider is at 2 cos phi. Generalized mass of phi: crank 1/3, rod 1/12
    and its center at (1.5 cos phi, 0.5 sin phi), slider.
    """

    def mass(x: Array) -> Array:
        s2 = np.sin(x) ** 2
        found: Array = 1 / 3 + 1 / 12 + 2.25 * s2 + 0.25 * (1 - s2) + 4 * s2
        return found

    phi, w = rotation(mass, np.zeros_like, 0.3, 2.0, times)
    return {
        "A.phi": phi, "A.w": w, "B.phi": -2 * phi, "B.w": -2 * w, "C.phi": phi, "C.w": w,
        "P.s": 2 * np.cos(phi), "P.v": -2 * np.sin(phi) * w,
    }  # fmt: skip


def light_cart_pole_truth(times: Array) -> dict[str, Array]:
    """Return the joint states of the light cart-pole at times [s].

    theta'^2 = 2 g (M+m) cos theta / (l (M + m sin² theta)), x = m l (1 - sin theta) / (M+m), released from
    the horizontal (N. Parsons 2026). With theta = pi/2 sin psi the coordinate psi grows monotonically.
    """
    cart, bob, length = 1e-6, 1.0, 1.0
    whole, narrow = (
        cart + bob,
        math.sqrt(cart / bob),
    )  # rad: half the width of the dip in the mass at theta = 0

    def slowness(psi: Array) -> Array:
        delta = np.abs((psi % math.pi) - math.pi / 2)  # distance from the end of the swing
        delta = np.maximum(delta, 1e-30)
        lean = math.pi * np.sin(delta / 2) ** 2  # angle of the pole from the horizontal
        mass = length * (cart + bob * np.cos(lean) ** 2)
        found: Array = np.sqrt(mass / (2 * GRAVITY * whole * np.sin(lean))) * math.pi / 2 * np.sin(delta)
        return found

    def panel(psi: float) -> float:
        from_dip = abs((psi + math.pi / 2) % math.pi - math.pi / 2)
        return min(0.05, max(0.2 * narrow, 0.2 * from_dip))

    psi = monotonic_motion(slowness, math.pi / 2, times, panel)
    theta = math.pi / 2 * np.sin(psi)
    rate = math.pi / 2 * np.cos(psi) / slowness(psi)
    ratio = bob * length / whole
    return {
        "track.s": ratio * (1 - np.sin(theta)), "track.v": -ratio * np.cos(theta) * rate,
        "hinge.phi": theta, "hinge.w": rate,
    }  # fmt: skip


def singular() -> list[Case]:
    """Return mechanisms at singular configurations, where the constraint Jacobian loses rank."""
    cases = [
        Case(
            f"n-four-bar-{n}",
            f"{f'A chain of {n} four-bars' if n > 1 else 'A four-bar'} with equal bars crosses singular "
            "configurations with "
            + (
                f"{n} additional instantaneous degrees of freedom."
                if n > 1
                else "1 additional instantaneous degree of freedom."
            ),
            mechanisms.four_bar_chain(n),
            20.0,
            0.01,
            truth=FourBarChainTruth(n, 1.0),
        )
        for n in (1, 2, 10, 40)
    ]
    return [
        *cases,
        Case(
            "parallelogram",
            "The cranks make thirteen revolutions through change points, where the coupler could also "
            "start to rotate; by its momentum it does not.",
            mechanisms.parallelogram(-math.pi / 2, 12.0), 10.0, 0.01, truth=parallelogram_truth,
        ),
        Case(
            "equal-slider-crank",
            "Crank and rod of equal length: at the dead center the slider could remain at rest.",
            mechanisms.equal_slider_crank(0.3, 2.0), 10.0, 0.01, truth=equal_slider_crank_truth,
        ),
        Case(
            "bricard", "Bricard's linkage of six hinges: one constraint equation is redundant everywhere.",
            mechanisms.bricard(), 10.0, 0.01,
        ),
    ]  # fmt: skip


def stiff_and_uneven() -> list[Case]:
    """Return mechanisms with widely different scales of time and mass."""
    andrews = tuple(
        (0.03, f"{joint}.{kind}", value)
        for joint, both in ANDREWS.items()
        for kind, value in zip(("phi", "w"), both, strict=True)
    )
    pole = tuple(
        (t, name, value)
        for t, both in LIGHT_CART_POLE.items()
        for name, value in zip(("track.s", "hinge.phi"), both, strict=True)
    )
    return [
        Case(
            "governor",
            "Stiff: damped modes decay within 0.1 ms in a motion of seconds, which limits explicit steps.",
            mechanisms.governor(), 10.0, 0.1,
            published=((10.0, "P.s", 0.6196229170613126),),
            source="a reduction to two coordinates, Radau at 1e-10",
        ),
        Case(
            "light-cart-pole",
            "The mass matrix is nearly singular for microseconds, at rates of up to 4429 rad/s.",
            mechanisms.light_cart_pole(), 10.0, 0.1,
            truth=light_cart_pole_truth, published=pole, source="Parsons 2026",
        ),
        Case(
            "heavy-top", "A top spins at 200 rad/s under gravity: fast and slow rotation.",
            mechanisms.heavy_top(200.0), 2.0, 0.01,
        ),
        Case(
            "andrews", "Seven bodies, three loops, 30 ms at up to 1400 rad/s; starts at a dead center.",
            mechanisms.shipped("andrews"), 0.03, 1e-3, published=andrews,
            source="IVP Test Set, PSIDE at 1e-14",
        ),
        Case(
            "mass-ratio-1e8", "The coupler is 1e8 times as heavy as the crank and the rocker that carry it.",
            mechanisms.uneven_four_bar(1e8), 5.0, 0.01,
        ),
        Case(
            "joint-stop",
            "A rocker strikes a stop of 1e6 N m/rad: non-smooth forces that last for a millisecond.",
            mechanisms.stopped_four_bar(), 5.0, 0.01,
        ),
    ]  # fmt: skip


def masters() -> list[Case]:
    """Return runs as in co-simulation: input jumps at each communication step, and a long run."""
    four_bar = mechanisms.shipped("four_bar")
    spans = ((1e-4, 1.0), (1e-3, 5.0), (1e-2, 5.0), (1e-1, 5.0))
    return [
        *(
            Case(
                f"torque-steps-{step:.0e}".replace("e-0", "e-"),
                f"A new torque at every communication step of {step:g} s invalidates the solver's history.",
                four_bar, stop, step, {"drive.tau": TORQUE},
            )
            for step, stop in spans
        ),
        Case(
            "an-hour", "A frictionless four-bar for an hour, judged by its energy: accumulation of errors.",
            mechanisms.four_bar(), 3600.0, 1.0, by_energy=True,
        ),
    ]  # fmt: skip


def awkward_starts() -> list[Case]:
    """Return runs with inconsistent start values, and one that starts at a dead center."""
    return [
        Case(
            "contradictory-speeds",
            "Fixed start speeds of crank and rocker violate the loop: "
            "there is no such motion, which must be reported.",
            mechanisms.contradictory_four_bar(fixed=True), 5.0, 0.01, expected="refused",
        ),
        Case(
            "inconsistent-speeds", "The same start speeds as initial guesses, which must be made consistent.",
            mechanisms.contradictory_four_bar(fixed=False), 5.0, 0.01,
        ),
        Case(
            "blocked-crank", "A crank pushes from its dead center against a load that it cannot overcome; "
            "the slider position, the obvious coordinate, does not determine the motion there.",
            mechanisms.blocked_crank(), 2.0, 0.01,
        ),
    ]  # fmt: skip


def stability_cases() -> list[Case]:
    """Return all test cases of the stability map."""
    return [*singular(), *stiff_and_uneven(), *masters(), *awkward_starts()]


QUICK_CASES = ("n-four-bar-1", "equal-slider-crank", "andrews", "torque-steps-1e-2", "contradictory-speeds",
               "inconsistent-speeds", "blocked-crank")  # fmt: skip
