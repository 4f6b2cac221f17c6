# SPDX-License-Identifier: BSD-3-Clause
"""What Gelenk is made of is named with versions and hashes, and nothing more than necessary is permitted."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.requirements import Requirement

ENTRY = re.compile(r"([a-z0-9-]+)==(\S+)((?: --hash=sha256:[0-9a-f]{64})+)")


@pytest.fixture(scope="module")
def locking(root: Path) -> Any:
    """The script that writes the lock."""
    spec = importlib.util.spec_from_file_location("lock", root / "cmake" / "lock.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def project(root: Path) -> dict[str, Any]:
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_lock_has_versions_and_hashes_of_all_requirements_and_no_addresses(
    root: Path, locking: Any, project: dict[str, Any]
) -> None:
    text = (root / "requirements.lock").read_text(encoding="utf-8")
    assert "://" not in text
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    found = [ENTRY.fullmatch(line) for line in lines]
    assert None not in found
    versions = {match[1]: match[2] for match in found if match is not None}
    assert list(versions) == sorted(versions)
    wanted = [Requirement(line) for line in locking.requirements(project)]
    assert len(wanted) > 30
    for requirement in wanted:
        if requirement.marker is None or requirement.marker.evaluate():
            version = versions[locking.normalized(requirement.name)]
            assert requirement.specifier.contains(version, prereleases=True), f"{requirement}: {version}"


def test_requirements_of_the_package_are_ranges_with_a_lower_end(
    locking: Any, project: dict[str, Any]
) -> None:
    assert all(
        re.fullmatch(r"[\w.-]+>=[\w.]+(,<[\w.]+)?", line) for line in project["project"]["dependencies"]
    )
    lowest = locking.lowest(project)
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lowest)
    assert {Requirement(line).name for line in project["project"]["dependencies"]} < {
        Requirement(line).name for line in lowest
    }


WORKFLOWS = sorted((Path(__file__).parent.parent / ".github" / "workflows").glob("*.yml"))


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_pin_actions_by_hash_and_may_only_read(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    flow = yaml.safe_load(text)
    assert flow["permissions"] == {"contents": "read"}
    assert all("permissions" not in job for job in flow["jobs"].values())
    used = re.findall(r"uses: (\S+)", text)
    assert used
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action) for action in used)
    steps = [step for job in flow["jobs"].values() for step in job["steps"]]
    checkouts = [step for step in steps if str(step.get("uses", "")).startswith("actions/checkout@")]
    assert checkouts
    assert all(step["with"]["persist-credentials"] is False for step in checkouts)


def test_what_takes_long_is_run_by_a_schedule(root: Path) -> None:
    flow = yaml.safe_load((root / ".github" / "workflows" / "weekly.yml").read_text(encoding="utf-8"))
    assert flow[True]["schedule"]  # `on` is true in YAML 1.1
    calls = {entry["call"] for entry in flow["jobs"]["make"]["strategy"]["matrix"]["include"]}
    assert {"studies", "sanitize", "fuzz", "lowest", "LOCKED=1 test"} == calls
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    for call in calls:
        assert re.search(rf"^{call.split()[-1]}:", makefile, re.MULTILINE)


def test_the_bill_of_materials_names_the_three_js_that_pages_contain(root: Path) -> None:
    pytest.importorskip("trimesh", reason="trimesh (the extra mesh) is not installed")
    script = root / "cmake" / "three_js.py"
    release = subprocess.run(
        [sys.executable, str(script), "--release"], capture_output=True, text=True, check=True
    ).stdout.strip()
    assert f"release {release}" in (root / "docs" / "viewer.md").read_text(encoding="utf-8")
    assert (
        "gelenk_component(three.js r${three_release} MIT" in (root / "cmake" / "GelenkSbom.cmake").read_text()
    )


def test_the_page_on_security_says_what_is_promised_and_how_to_report(root: Path) -> None:
    text = (root / "SECURITY.md").read_text(encoding="utf-8")
    titles = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert titles == ["What is promised", "What is checked", "Reporting a vulnerability"]
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"`make (?:LOCKED=1 )?(\w+)`", text):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)
    for link in re.findall(r"\]\(([^)#]+)", text):
        assert (root / link).exists()
