# SPDX-License-Identifier: BSD-3-Clause
"""The scenes of the stability map: each is about one way in which methods fail."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from gelenk.chart import mechanisms
from gelenk.chart.case import Array, Case, Jumps
from gelenk.chart.mechanisms import GRAVITY
from gelenk.chart.turning import passing, turning

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
# x [m] and theta [rad] of the light cart-pole, printed by its author (N. Parsons 2026).
LIGHT_CART_POLE = {
    9.3: (0.0656191393387692, 1.20651709172129),
    9.5: (1.38736119304381, -0.397769100457376),
    9.7: (1.96354957422484, -1.29997515003022),
    9.9: (1.99998277728396, -1.56527858004052),
    10.0: (1.99976328246162, -1.54912944189708),
}
TORQUE = Jumps(3.0, 10.0)  # N m


class WindowsTruth:
    """All cranks of an N-four-bar lean alike, so it is a pendulum: I phi'' = P g sin phi, phi from upright,
    I = (N+1)/3 + N kg m2, P = (N+1)/2 + N kg m.
    """

    def __init__(self, n: int, rate: float) -> None:
        self.n, self.rate = n, rate

    def __call__(self, times: Array) -> dict[str, Array]:
        """Joint states at times [s]."""
        moment, weight = (self.n + 1) / 3 + self.n, GRAVITY * ((self.n + 1) / 2 + self.n)
        phi, w = turning(
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
    """The coupler only translates: a pendulum with I = 2 I_O + m_c L2 = 0.132 kg m2, 3.8259 N m of weight."""
    phi, w = turning(
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
    """The rod leans as the crank does, mirrored, and the slider is at 2 cos phi. Generalised mass of phi:
    crank 1/3, rod 1/12 and its centre at (1.5 cos, 0.5 sin), slider.
    """

    def mass(x: Array) -> Array:
        s2 = np.sin(x) ** 2
        found: Array = 1 / 3 + 1 / 12 + 2.25 * s2 + 0.25 * (1 - s2) + 4 * s2
        return found

    phi, w = turning(mass, np.zeros_like, 0.3, 2.0, times)
    return {
        "A.phi": phi, "A.w": w, "B.phi": -2 * phi, "B.w": -2 * w, "C.phi": phi, "C.w": w,
        "P.s": 2 * np.cos(phi), "P.v": -2 * np.sin(phi) * w,
    }  # fmt: skip


def light_cart_pole_truth(times: Array) -> dict[str, Array]:
    """theta'^2 = 2 g (M+m) cos theta / (l (M + m sin2 theta)), x = m l (1 - sin theta) / (M+m), from the
    horizontal (N. Parsons 2026). theta = pi/2 sin psi makes of the swing a coordinate psi that only grows.
    """
    cart, bob, length = 1e-6, 1.0, 1.0
    whole, narrow = (
        cart + bob,
        math.sqrt(cart / bob),
    )  # rad: half the width of the dip in the mass at theta = 0

    def slowness(psi: Array) -> Array:
        delta = np.abs((psi % math.pi) - math.pi / 2)  # from the end of the swing
        delta = np.maximum(delta, 1e-30)
        lean = math.pi * np.sin(delta / 2) ** 2  # of the pole from the horizontal
        mass = length * (cart + bob * np.cos(lean) ** 2)
        found: Array = np.sqrt(mass / (2 * GRAVITY * whole * np.sin(lean))) * math.pi / 2 * np.sin(delta)
        return found

    def panel(psi: float) -> float:
        from_dip = abs((psi + math.pi / 2) % math.pi - math.pi / 2)
        return min(0.05, max(0.2 * narrow, 0.2 * from_dip))

    psi = passing(slowness, math.pi / 2, times, panel)
    theta = math.pi / 2 * np.sin(psi)
    rate = math.pi / 2 * np.cos(psi) / slowness(psi)
    share = bob * length / whole
    return {
        "track.s": share * (1 - np.sin(theta)), "track.v": -share * np.cos(theta) * rate,
        "hinge.phi": theta, "hinge.w": rate,
    }  # fmt: skip


def singular() -> list[Case]:
    """Mechanisms at positions where rows of their loops lose rank."""
    cases = [
        Case(
            f"n-four-bar-{n}",
            f"Equal bars in {n} window{'s' if n > 1 else ''} fall through positions, all bars in line, where "
            f"{n} more freedom{'s open' if n > 1 else ' opens'} for a moment.",
            mechanisms.windows(n),
            20.0,
            0.01,
            truth=WindowsTruth(n, 1.0),
        )
        for n in (1, 2, 10, 40)
    ]
    return [
        *cases,
        Case(
            "parallelogram",
            "Cranks go round thirteen times through change points, where the coupler could as well "
            "begin to turn; momentum says that it does not.",
            mechanisms.parallelogram(-math.pi / 2, 12.0), 10.0, 0.01, truth=parallelogram_truth,
        ),
        Case(
            "equal-slider-crank",
            "Crank and rod are equally long: at the dead centre the slider could stay for good.",
            mechanisms.equal_slider_crank(0.3, 2.0), 10.0, 0.01, truth=equal_slider_crank_truth,
        ),
        Case(
            "bricard", "A ring of six hinges: one row of its loop repeats the others at every position.",
            mechanisms.bricard(), 10.0, 0.01,
        ),
    ]  # fmt: skip


def stiff_and_uneven() -> list[Case]:
    """Scales of time and mass far apart."""
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
            "Dampers decay within 0.1 ms in motions of a second: explicit methods step as they do.",
            mechanisms.governor(), 10.0, 0.1,
            published=((10.0, "P.s", 0.6196229170613126),),
            source="a reduction to two coordinates, Radau at 1e-10",
        ),
        Case(
            "light-cart-pole",
            "The mass matrix is nearly singular for a microsecond at a time, rates reach 4429 rad/s.",
            mechanisms.light_cart_pole(), 10.0, 0.1,
            truth=light_cart_pole_truth, published=pole, source="Parsons 2026",
        ),
        Case(
            "heavy-top", "A top spins at 200 rad/s under gravity: fast rotation beside slow.",
            mechanisms.heavy_top(200.0), 2.0, 0.01,
        ),
        Case(
            "andrews", "Seven bars, three loops, all within 30 ms at 1400 rad/s; it starts in a dead point.",
            mechanisms.shipped("andrews"), 0.03, 1e-3, published=andrews,
            source="IVP Test Set, PSIDE at 1e-14",
        ),
        Case(
            "mass-ratio-1e8", "A coupler 1e8 times as heavy as the crank and the rocker that carry it.",
            mechanisms.uneven_four_bar(1e8), 5.0, 0.01,
        ),
        Case(
            "joint-stop",
            "A rocker strikes a stop of 1e6 N m/rad: forces with a corner, gone in a millisecond.",
            mechanisms.stopped_four_bar(), 5.0, 0.01,
        ),
    ]  # fmt: skip


def masters() -> list[Case]:
    """What a co-simulation master does, and for how long."""
    four_bar = mechanisms.shipped("four_bar")
    spans = ((1e-4, 1.0), (1e-3, 5.0), (1e-2, 5.0), (1e-1, 5.0))
    return [
        *(
            Case(
                f"torque-steps-{step:.0e}".replace("e-0", "e-"),
                f"Another torque at every communication step of {step:g} s: the past tells a method nothing.",
                four_bar, stop, step, {"drive.tau": TORQUE},
            )
            for step, stop in spans
        ),
        Case(
            "an-hour", "A four-bar without friction for an hour, judged by its energy: does error pile up?",
            mechanisms.four_bar(), 3600.0, 1.0, by_energy=True,
        ),
    ]  # fmt: skip


def awkward_starts() -> list[Case]:
    """Starts that do not fit, and one that is a dead point."""
    return [
        Case(
            "contradictory-speeds",
            "Crank and rocker are to keep start speeds that their loop does not allow: "
            "there is no such motion, which is to be told.",
            mechanisms.contradictory_four_bar(fixed=True), 5.0, 0.01, expected="refused",
        ),
        Case(
            "inconsistent-speeds", "The same start speeds as guesses: they have to be made consistent first.",
            mechanisms.contradictory_four_bar(fixed=False), 5.0, 0.01,
        ),
        Case(
            "blocked-crank", "A crank pushes from its dead point against a load that it cannot overcome; the "
            "slider's place, which tells nothing there, suggests itself as coordinate.",
            mechanisms.blocked_crank(), 2.0, 0.01,
        ),
    ]  # fmt: skip


def stability_cases() -> list[Case]:
    """All of them."""
    return [*singular(), *stiff_and_uneven(), *masters(), *awkward_starts()]


QUICK_CASES = ("n-four-bar-1", "equal-slider-crank", "andrews", "torque-steps-1e-2", "contradictory-speeds",
               "inconsistent-speeds", "blocked-crank")  # fmt: skip
