# SPDX-License-Identifier: BSD-3-Clause
"""The parts of a scene kept or removed for a list of requested outputs, and what is reported about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import jsonschema
import numpy as np
import pytest
import warned
from fmpy.validation import validate_fmu
from many_islands import many_islands
from mechanisms import Scene, body, four_bar, frame, joint, rod, scene

import gelenk
from gelenk import _core

pytestmark = warned.MOVING


def names_in(source: gelenk.Scene, section: str) -> set[str]:
    return set(source.to_dict()[section])


def test_part_contains_only_the_elements_that_act_on_it() -> None:
    whole = gelenk.load(many_islands(6, parameters="all"))
    part = whole.with_outputs(["i3_Q.phi"]).pruned()
    assert names_in(part, "bodies") == {"i3_pinion", "i3_wheel"}
    assert names_in(part, "joints") == {"i3_P", "i3_Q"}
    assert names_in(part, "motors") == {"i3_drive"}
    assert names_in(part, "constraints") == {"i3_mesh"}
    assert names_in(part, "sensors") == {"i3_load"}  # a reaction output requires spatial algebra
    others = {"i0", "i1", "i2", "i4", "i5"}
    own = {n for n in whole.parameters if n.split("_")[0] not in others}
    assert {n for n in own if n.startswith("i3")}
    assert set(part.parameters) == own
    assert part.pruned() is part


def test_immobile_bodies_are_kept_if_something_is_attached() -> None:
    part = gelenk.load(many_islands(6)).with_outputs(["i1_A.phi"]).pruned()
    assert names_in(part, "bodies") == {"i1_block", "i1_bob"}
    assert names_in(part, "joints") == {"i1_W", "i1_A"}
    assert names_in(part, "sensors") == set()


def two_on_one_table() -> Scene:
    """Two pendulums on one table that is welded to the ground, one on another table, and a load on each."""
    hinge = {"axis": [0, 1, 0], "start": {"phi": 0.4}}
    return scene(
        {
            "table": body(3.0), "shelf": body(1.0),
            "left": rod(1.0, 0.5), "right": rod(2.0, 0.5), "far": rod(1.0, 1),
        },
        {
            "T": joint("weld", frame("ground"), frame("table")),
            "H": joint("weld", frame("table", (1, 0, 0)), frame("shelf")),
            "L": joint("revolute", frame("table"), frame("left"), **hinge),
            "R": joint("revolute", frame("shelf"), frame("right"), **hinge),
            "F": joint("revolute", frame("ground"), frame("far"), **hinge),
        },
        gravity=[0, 0, -9.81],
        forces={f"on_{b}": {"type": "wrench", "body": b, "input": True} for b in ("left", "far", "shelf")},
        sensors={
            "where": {"type": "frame", "body": "shelf"}, "all": {"type": "energy"},
            "tip": {"type": "frame", "body": "far"},
        },
    )  # fmt: skip


def test_ground_and_welded_bodies_do_not_couple_islands() -> None:
    part = gelenk.load(two_on_one_table()).with_outputs(["L.phi"]).pruned()
    assert names_in(part, "bodies") == {"table", "shelf", "left"}
    assert names_in(part, "joints") == {"T", "H", "L"}
    assert names_in(part, "forces") == {"on_left", "on_shelf"}


def test_outputs_of_immobile_bodies_can_be_requested() -> None:
    source = gelenk.load(two_on_one_table())
    plant = gelenk.Simulation(source.with_outputs(["where.r[1]"]))
    plant.initialize()
    assert [s.name for s in plant.outputs] == ["where.r[1]"]
    assert plant.values() == [1.0]
    assert plant.size.velocities == 0


@pytest.mark.parametrize("wanted", [["all.total"], ["all.kinetic", "L.phi"]])
def test_total_energy_requires_the_whole_scene(wanted: list[str]) -> None:
    source = gelenk.load(two_on_one_table())
    part = source.with_outputs(wanted).pruned()
    assert names_in(part, "bodies") == names_in(source, "bodies")
    assert gelenk.inspect(source, outputs=wanted).left_out == ""


@pytest.mark.parametrize("reduction", ["outputs", "islands"])
def test_disabled_reductions_keep_the_whole_scene(reduction: str) -> None:
    """Without `islands` the scene is one system with common steps:
    its parts do not move exactly as they would alone.
    """
    source = gelenk.load(two_on_one_table())
    off = gelenk.Simulation(source.with_outputs(["L.phi"]).without([reduction]))
    on = gelenk.Simulation(source.with_outputs(["L.phi"]))
    assert (off.size.bodies, on.size.bodies) == (3, 1)
    assert [s.name for s in off.outputs] == [s.name for s in on.outputs] == ["L.phi"]


def test_inspection_reports_removed_parts() -> None:
    source = gelenk.load(two_on_one_table())
    report = gelenk.inspect(source, outputs=["L.*"])
    sentence = (
        "omitted, because no requested output depends on it: 2 islands (bodies right and far; joints R and F)"
    )
    assert report.left_out == sentence == report.to_dict()["left_out"]
    assert sentence in report.reductions["outputs"].notes
    assert (report.described.bodies, report.reduced.bodies) == (5, 1)
    assert (report.described.islands, report.reduced.islands) == (1, 1)
    assert "omitted, because" in " ".join(str(report).split())
    assert gelenk.inspect(source).left_out == ""


def test_saved_scene_keeps_its_list_of_outputs(tmp_path: Path) -> None:
    wanted = gelenk.load(two_on_one_table()).with_outputs(["L.phi", "*.r[1]"])
    for path in (tmp_path / "s.yaml", tmp_path / "s.json"):
        wanted.save(path)
        again = gelenk.load(path)
        assert again.outputs == wanted.outputs == ("L.phi", "*.r[1]")
        assert again.with_outputs(None).outputs == ()
    for source in (wanted, wanted.pruned(), wanted.wanted_part()):
        jsonschema.Draft202012Validator(_schema()).validate(source.to_dict())
        assert gelenk.load(source.to_dict()).to_dict() == source.to_dict()
    assert wanted.without(["planar"]).outputs == wanted.outputs
    assert wanted.with_parameters({"gravity[3]": -1.6}).outputs == wanted.outputs


def _schema() -> dict[str, object]:
    import json

    found = json.loads(gelenk.io.export.schema())
    assert isinstance(found, dict)
    return found


def test_errors_in_removed_parts_are_reported() -> None:
    data = {**two_on_one_table(), "outputs": ["L.phi"]}
    data["bodies"]["far"]["mass"] = -1.0
    data["sensors"]["tip"]["body"] = "fra"
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(data)
    assert [line.split(": ")[1] for line in error.value.lines] == ["bodies.far.mass", "sensors.tip.body"]
    welds = two_on_one_table()
    welds["joints"]["X"] = joint("weld", frame("ground", (0, 0, 1)), frame("shelf"))
    source = gelenk.load(welds).with_outputs(["F.phi"])
    with pytest.raises(gelenk.SceneError, match="contradicts other welds"):
        gelenk.Simulation(source)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = gelenk.load(two_on_one_table())
    return gelenk.export_fmu(
        source, tmp_path_factory.mktemp("wanted") / "x.fmu", outputs=["L.a", "where.r[*]"]
    )


def test_fmu_has_the_requested_outputs_and_the_states(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    found = fmpy.read_model_description(str(fmu), validate=True)
    of = {c: [v.name for v in found.modelVariables if v.causality == c] for c in ("input", "output", "local")}
    assert of["output"] == ["L.a", "where.r[1]", "where.r[2]", "where.r[3]"]
    assert [n for n in of["local"] if n.split(".")[0] not in ("solver", "energy", "constraints")] == [
        "L.phi",
        "L.w",
        "der(L.phi)",
        "der(L.w)",
    ]
    assert {n.split(".")[0] for n in of["input"]} == {"on_left", "on_shelf"}
    assert [(u.variable.derivative.name, u.variable.name) for u in found.derivatives] == [
        ("L.phi", "der(L.phi)"), ("L.w", "der(L.w)"),
    ]  # fmt: skip
    parameters = {v.name.split(".")[0] for v in found.modelVariables if v.causality == "parameter"}
    assert not parameters & {"R", "F"}


def test_quaternion_of_a_state_and_its_rate_are_in_the_fmu(tmp_path: Path) -> None:
    source = gelenk.load(many_islands(6))
    out = gelenk.export_fmu(source, tmp_path / "free.fmu", outputs=["i4_F.r[3]"])
    assert validate_fmu(str(out)) == []
    found = fmpy.read_model_description(str(out), validate=True)
    assert len(found.derivatives) == 13
    models = [gelenk.linearize(s) for s in (source.with_outputs(["i4_F.r[3]"]), out)]
    for name in "ABCD":
        assert np.array_equal(getattr(models[0], name), getattr(models[1], name)), name


def test_linear_model_of_the_fmu_has_all_states(fmu: Path) -> None:
    source = gelenk.load(two_on_one_table())
    model = gelenk.linearize(fmu)
    whole = gelenk.linearize(source)
    assert model.state_labels == ["L_phi", "L_w"]
    assert model.output_labels == ["L_a", "where_r[1]", "where_r[2]", "where_r[3]"]
    x = [whole.state_labels.index(n) for n in model.state_labels]
    y = [whole.output_labels.index(n) for n in model.output_labels]
    assert np.array_equal(model.A, whole.A[np.ix_(x, x)])
    assert np.array_equal(model.C, whole.C[np.ix_(y, x)])


def test_outputs_of_a_linear_model_do_not_remove_parts() -> None:
    source = gelenk.load(two_on_one_table())
    whole = gelenk.linearize(source)
    for asked in (source, source.with_outputs(["L.phi"])):
        model = gelenk.linearize(asked, outputs=["R.phi"])
        assert model.state_labels == whole.state_labels
        assert np.array_equal(model.A, whole.A)
        assert np.array_equal(model.B, whole.B)
        assert np.array_equal(model.C, whole.C[[whole.output_labels.index("R_phi")]])


def test_inputs_and_parameters_of_removed_parts_are_accepted_and_checked() -> None:
    source = gelenk.load(two_on_one_table())
    given: dict[str, Any] = {"inputs": {"on_far.t[2]": 3.0, "on_left.t[2]": 0.5}, "stop": 0.1, "step": 0.01}
    whole = gelenk.simulate(source, **given)
    part = gelenk.simulate(source, outputs=["L.phi"], **given)
    assert np.array_equal(part["L.phi"], whole["L.phi"])
    started = gelenk.simulate(source, outputs=["L.phi"], parameters={"F.phi_start": 0.1}, **given)
    assert np.array_equal(started["L.phi"], whole["L.phi"])
    with pytest.raises(gelenk.UsageError, match="no such parameter or input"):
        gelenk.simulate(source, outputs=["L.phi"], parameters={"F.phi_strat": 0.1})
    with pytest.raises(gelenk.UsageError, match=r"on_far\.t\[4\]"):
        gelenk.simulate(source, outputs=["L.phi"], inputs={"on_far.t[4]": 1.0})
    with pytest.raises(gelenk.GelenkError, match=r"F\.phi_start"):
        gelenk.simulate(source, outputs=["L.phi"], parameters={"F.phi_start": "x"})


def test_requested_diagnostics_cover_all_islands() -> None:
    source = gelenk.load(two_on_one_table())
    result = gelenk.simulate(source, outputs=["L.phi", "energy.total"], stop=0.02, step=0.01)
    assert (
        result["energy.total"][0] == gelenk.simulate(source, stop=0.02, outputs=["all.total"])["all.total"][0]
    )


def test_modes_and_equilibria_refer_to_the_part() -> None:
    """A hanging rod of length L swings with sqrt(3 g / (2 L)) (uniform:
    I = m L²/3 about the revolute joint).
    """
    source = gelenk.load({**two_on_one_table(), "outputs": ["L.w"]})
    rest = gelenk.equilibrium(source)
    assert list(rest.values) == ["L.w"]
    found = gelenk.modes(source, at=rest.at)  # frequencies in rad/s
    (mode,) = found.modes
    assert {n.split(".")[0] for n in mode.shape} == {"L"}
    # The equilibrium is accurate to 1e-8 rad, whose square matters; the remainder is round-off.
    assert mode.natural_frequency == pytest.approx((1.5 * 9.81 / 0.5) ** 0.5, rel=1e-12)


def test_simulation_has_only_the_requested_outputs() -> None:
    plant = gelenk.Simulation(gelenk.load(four_bar(1.1)).with_outputs(["C.phi"]))
    plant.initialize()
    assert [s.name for s in plant.outputs] == ["C.phi"]
    with pytest.raises(gelenk.UsageError, match=r"A\.phi: no such output"):
        plant.output("A.phi")
    assert plant.independent_coordinates == ("A.phi",)


@pytest.mark.parametrize("outputs", [[], ["nothing.*"], ["L"], ["L.phi", "L.phi"], ["on_left.t[2]"]])
def test_invalid_lists_of_outputs_are_refused(outputs: list[str], tmp_path: Path) -> None:
    with pytest.raises(gelenk.UsageError, match="outputs: found"):
        gelenk.export_fmu(two_on_one_table(), tmp_path / "x.fmu", outputs=outputs)


def test_pruning_is_idempotent() -> None:
    part = gelenk.load(many_islands(6)).with_outputs(["i5_L.phi", "i2_S.s"])._core
    once = _core.write_scene_json(_core.wanted_part(part))
    again = _core.write_scene_json(_core.wanted_part(_core.read_scene_json(once, "")))
    assert again == once
