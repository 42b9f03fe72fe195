"""``colias doctor`` on healthy and on broken machines, and the reference frame."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from colias_sim import gl, reference
from dsnn import native
from experiments.bench.doctor import installed
from tests.helpers.processes import WITHOUT_GL


def doctored(colias, *options, **environment):
    """``colias doctor --json``, by the name of what was looked at."""
    command = [sys.executable, "-m", "experiments.bench.cli", "doctor", "--json", *options]
    known = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "MUJOCO_GL", "DSNN_FORM")}
    done = subprocess.run(
        command, cwd=colias.folder, env=known | environment, capture_output=True, text=True, timeout=120, check=False
    )
    report = json.loads(done.stdout)
    assert done.stderr == "" and report["ok"] == (done.returncode == 0)
    assert all(finding["remedy"] for finding in report["findings"] if finding["status"] == "fails")
    return done.returncode, {finding["name"]: finding for finding in report["findings"]}


def test_a_healthy_machine(colias):
    status, findings = doctored(colias)
    assert status == 0, [finding for finding in findings.values() if finding["status"] == "fails"]
    assert {"python", "packages", "lock", "renderer", "reference frame", "robot's camera", "rerun viewer"} <= set(
        findings
    )
    assert findings["renderer"]["message"].startswith(reference_renderer())
    assert ("llvmpipe" in findings["renderer"]["message"]) <= ("software" in findings["renderer"]["message"])
    assert findings["reference frame"]["status"] in ("ok", "notice")
    assert (
        "ms a frame" in findings["robot's camera"]["message"]
        and "ms a frame" in findings["network, reference"]["message"]
    )


def reference_renderer():
    reference.reference_frame()
    return gl.renderer()


@pytest.mark.parametrize(
    "environment, message, remedy",
    [
        ({"MUJOCO_GL": "quark"}, "MUJOCO_GL=quark", "unset the variable"),
        ({"PYTHONPATH": "without-egl"}, "no OpenGL library", "apt-get install libegl1 libgl1"),
    ],
    ids=["broken MUJOCO_GL", "no EGL"],
)
def test_what_cannot_draw_is_told_with_its_remedy(colias, environment, message, remedy):
    site = colias.folder / "without-egl"
    site.mkdir()
    (site / "sitecustomize.py").write_text(WITHOUT_GL)
    paths = (str(site), os.environ.get("PYTHONPATH", ""), str(installed.Path(__file__).parents[3]))
    if "PYTHONPATH" in environment:
        environment = {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    status, findings = doctored(colias, **environment)
    assert (status, findings["rendering"]["status"]) == (1, "fails")
    assert message in findings["rendering"]["message"] and remedy in findings["rendering"]["remedy"]
    assert findings["packages"]["status"] == "ok", "the other checks still answer"


def test_without_the_native_network_it_says_what_that_costs(monkeypatch):
    monkeypatch.setattr(native, "missing", lambda: "is not built")
    monkeypatch.delenv("DSNN_FORM", raising=False)
    findings = {finding.name: finding for finding in installed.network()}
    assert findings["network, native"].status == "notice" and "make setup" in findings["network, native"].remedy
    assert findings["network, chosen"].message == "reference"
    monkeypatch.setenv("DSNN_FORM", "native")
    assert installed.network()[-1].status == "fails"


def test_an_old_lock_names_what_differs(tmp_path, monkeypatch):
    monkeypatch.setattr(installed, "CHECKOUT", tmp_path)
    assert installed.lock().status == "ok", "not a checkout"
    lock = tmp_path / "requirements.lock"
    lock.write_text("numpy==1.0.0 \\\n    --hash=sha256:00\nnosuch==2 ; sys_platform == 'nowhere'\nnosuch-2==3\n")
    finding = installed.lock()
    assert finding.status == "notice" and "2 of 2 differ" in finding.message
    assert f"numpy is {np.__version__}, locked is 1.0.0" in finding.message and "nosuch-2 is missing" in finding.message
    lock.write_text("numpy>=1\n")
    assert installed.lock().status == "fails"


def test_packages_outside_their_ranges_fail(monkeypatch):
    assert installed.packages().status == "ok"
    monkeypatch.setattr(installed.importlib.metadata, "requires", lambda _: ["numpy<1", "nosuch; extra == 'train'"])
    finding = installed.packages()
    assert (
        finding.status == "fails"
        and f"numpy is {np.__version__}" in finding.message
        and "nosuch" not in finding.message
    )


def test_each_extra_is_told_with_what_it_lacks(monkeypatch):
    declared = installed.importlib.metadata.metadata("colias-sim").get_all("Provides-Extra")
    assert {finding.name for finding in installed.extras()} >= {f"extra [{name}]" for name in declared}
    assert {"fit", "live", "train", "video", "cluster"} <= set(declared)
    requires = [f"numpy<1; extra == '{name}'" for name in declared] + ["nosuch"]
    monkeypatch.setattr(installed.importlib.metadata, "requires", lambda _: requires)
    for finding in installed.extras()[: len(declared)]:
        assert finding.status == "optional", "nothing but a few commands needs an extra"
        assert f"numpy is {np.__version__}" in finding.message and "nosuch" not in finding.message


def test_a_tool_that_is_not_installed_is_optional_and_not_ok(monkeypatch):
    monkeypatch.setattr(installed.shutil, "which", lambda program: "/bin/qemu" if "qemu" in program else None)
    found = {finding.name: finding.status for finding in installed.extras() if finding.name in installed.TOOLS}
    assert found == {program: "ok" if "qemu" in program else "optional" for program in installed.TOOLS}


def test_the_reference_frame_is_the_one_that_is_kept():
    """Equal pixels wherever they were compared; another renderer may round some otherwise, and draws the same scene."""
    kept = reference.expected_frame()
    assert reference.digest(kept) == next(iter(reference.KNOWN))
    drawn = reference.reference_frame()
    assert drawn.shape == (72, 99, 3) and np.array_equal(drawn, reference.reference_frame())
    assert np.abs(drawn.astype(int) - kept).mean() < 2.0
