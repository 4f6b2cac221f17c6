# SPDX-License-Identifier: BSD-3-Clause
"""Linear models of scenes that nobody drives."""

from __future__ import annotations

import control
import numpy as np
import pytest
import warned
from mechanisms import four_bar

import gelenk


@warned.MOVING
def test_scene_without_inputs_and_with_one_output_is_a_state_space_too() -> None:
    """python-control takes D of shape (1, 0) for one of shape (0, 0)."""
    source = four_bar(1.1)
    source.pop("motors", None)
    found = gelenk.linearize(source, outputs=["A.phi"], states=["A.phi", "A.w"])
    assert (found.ninputs, found.noutputs, found.nstates) == (0, 1, 2)
    assert (found.B.shape, found.D.shape) == ((2, 0), (1, 0))
    assert found.output_labels == ["A_phi"]
    # Its free response is that of the two eigenvalues.
    response = control.initial_response(found, [0.0, 0.1], [1.0, 0.0])
    poles = found.poles()
    expected = np.real(
        (poles[1] * np.exp(0.1 * poles[0]) - poles[0] * np.exp(0.1 * poles[1])) / (poles[1] - poles[0])
    )
    assert response.outputs.ravel()[-1] == pytest.approx(expected, rel=1e-9)
