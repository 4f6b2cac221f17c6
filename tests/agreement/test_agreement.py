# SPDX-License-Identifier: BSD-3-Clause
"""Random scenes in which joints, loops, clutches, limits, gears and contacts meet are the same in all ways.

See compare.py for the ways. `make agreement` runs 20,000 scenes; a single one again, and made smaller, in the
folder tests: `python -m agreement --minimize 17`.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import programs
import pytest
from samples import thorough_beyond

from .drawn import FIRST_WITH_LOCKS, drawn
from .ways import run, run_values_only, with_solver

TRIALS, BLOCK = 300, 25
WITH_LOCKS = range(FIRST_WITH_LOCKS, FIRST_WITH_LOCKS + 100, BLOCK)
REFUSED = ("refused", "not started")  # ends of what a way reports that could not be run
MOST_REFUSED = 2  # of a block
# Beyond those: a step of dirk to a touch that rounding put just before its end; an open brake at the
# equilibrium of a spring, beside a wheel; contacts and joints that share a load; friction that turns a joint
# the other way; two frictions of three that reach their limits together. And what was wrong in silence:
# static friction that a jump of a motion elsewhere broke; a limit met again in the rounding of an impact that
# had left it; a report of a broken law in a large scene, whose unit was unknown; a corner that pulled while a
# joint elsewhere was at rest; sliding that begins within a step of dirk; steps that took the wrong one of two
# motions of a gear with losses, or the impulse of a stop for its load; a worm beside what sets out;
# a jump of a motion within rounding that ended static friction; a wheel that lands while its cart meets a
# limit; a gear with losses that was restored after a step with loads of the other sign; an oblique guide in
# time steps; joints that friction holds beside what slides elsewhere; joints and a contact that break away
# together; a series of impacts between three limits that contracts faster than it slows down; a lock that is
# released beside another one after a state is restored; steps whose gears with losses felt its impulse;
# friction that ends as a motion jumps within rounding, against the force; a gear that seizes together with a
# limit.
ONCE_WRONG = (
    12407, 6039, 2403, 4327, 3373, 5005, 4515, 5134, 6967, 9529, 5881, 9709, 10491,
    12282, 12585, 12264, 15886, 18255, 30110, 32247, 32553, 13780,
    17594, 30498, 31017, 31063, 34785, 40151, 40200, 40229, 40239,
)  # fmt: skip


def findings(first: int, count: int) -> list[dict[str, str]]:
    """In another process, so that a crash is reported."""
    folder = Path(__file__).parent.parent
    child = programs.run("-m", "agreement", count, first, "--jobs", 1, cwd=folder, timeout=1800)
    lines = child.stdout.splitlines()
    assert lines, child.stderr
    assert lines[-1].startswith(f"{count} trials"), child.stdout + child.stderr
    return [json.loads(line) for line in lines[:-1]]


@pytest.mark.parametrize(
    "first", thorough_beyond([*range(0, TRIALS, BLOCK), *WITH_LOCKS], [0, WITH_LOCKS[0]])
)
def test_all_ways_agree(first: int) -> None:
    found = findings(first, BLOCK)
    assert not [each for each in found if not each["way"].endswith(REFUSED)]
    assert len(found) <= MOST_REFUSED  # lest all agree because nothing runs


@pytest.mark.thorough
@pytest.mark.parametrize("seed", ONCE_WRONG)
def test_what_was_refused_or_wrong_once_is_not(seed: int) -> None:
    assert not findings(seed, 1)


def test_a_time_step_of_the_least_length_is_made() -> None:
    """It was repeated for ever, since rounding made it a little longer than the least one."""
    trial = drawn(15508)
    trial.points = 3
    assert np.isfinite(run_values_only(trial, parts=20)).all()


@pytest.mark.parametrize(
    ("seed", "cause"),
    [
        (206301, "a wheel that the ground holds is beyond its limit by rounding"),
        (205875, "a contact that closes turns a joint that was about to slip in the other direction"),
        (204758, "the same beside a limit without losses"),
    ],
)
def test_steps_do_not_become_as_short_as_rounding(seed: int, cause: str) -> None:
    made = run(with_solver(drawn(seed), max_evaluations=20_000))
    assert not made.refusal, cause
