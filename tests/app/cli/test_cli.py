from __future__ import annotations

import io
import json
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path
from types import ModuleType

import pytest

from abi import assets
from abi.errors import AbiError
from abi.planner.planner import plan
from abi.scene.scene import Scene, load_scene, scene_names
from abi.search.compare import COMPARED
from abi.search.search import SEARCHES
from app.__main__ import main
from app.cli import sweep
from app.cli.exit_code import INCOMPLETE
from app.guard.policy import policy_for
from app.server.server import Server
from app.state.appearance import PLAIN
from tests.abi import meshes


def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *args: str
) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["abi", *args])
    try:
        main()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 0
    else:
        code = 0
    out, err = capsys.readouterr()
    return code, out, err


def test_plan_prints_a_complete_plan(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(monkeypatch, capsys, "plan")

    assert (code, err) == (0, "")
    assert json.loads(out)["error"] is None


def test_a_scene_goes_through_pipes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def given(text: str, *args: str) -> tuple[int, str, str]:
        stream = io.TextIOWrapper(io.BytesIO(text.encode()))
        monkeypatch.setattr(sys, "stdin", stream)
        return run(monkeypatch, capsys, *args)

    scene = load_scene("two-boxes").replace(quadratic={"mode": "clear"})
    code, out, _ = given(json.dumps(scene.to_dict()), "plan", "-", "--out", "-")
    assert code == 0
    assert json.loads(out)["scene"] == scene.to_dict()
    code, lines, _ = given(out, "verify", "-")
    assert (code, lines.count(": proven: ")) == (0, 3)

    code, out, _ = given("version: 1\nunit: mm\nmesh: {pitch: 2}\n", "plan", "-")
    assert json.loads(out)["scene"]["unit"] == "mm"
    code, _, err = given("version: [", "plan", "-")
    assert (code, err.count("\n")) == (2, 1)
    assert "stdin.yaml" in err


@pytest.mark.slow
def test_who_reads_only_the_beginning_gets_it_without_complaints() -> None:
    command = f"{sys.executable} -m app plan | head -n 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "{"
    assert done.stderr == ""


class Interrupting(ModuleType):
    """A module in whose place Ctrl+C comes, or comes in a callback and then is dropped."""

    def __init__(self, within_callback: bool) -> None:
        super().__init__("app.cli.command_line")
        self._within_callback = within_callback

    def run(self) -> None:
        if not self._within_callback:
            raise KeyboardInterrupt
        probe = Interrupted()
        del probe
        threading.Event().wait(20)
        raise AssertionError("the interrupt was lost")


class Interrupted:
    def __del__(self) -> None:
        raise KeyboardInterrupt


@pytest.mark.parametrize("within_callback", [False, True])
def test_an_interrupt_ends_the_command_wherever_it_comes(
    within_callback: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "app.cli.command_line", Interrupting(within_callback))
    # a shell has what it starts in the background ignore Ctrl+C
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert run(monkeypatch, capsys) == (130, "", "")
    finally:
        signal.signal(signal.SIGINT, before)


FULL = "abi: The output cannot be printed (no space left on device).\n"


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a full device")
@pytest.mark.parametrize(("args", "must_print"), [("--help", False), ("plan --list", True)])
def test_output_that_cannot_be_written_is_told_in_a_sentence(args: str, must_print: bool) -> None:
    command = f"{sys.executable} -m app {args}"
    full = subprocess.run(
        ["bash", "-c", f"{command} > /dev/full"], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (full.returncode, full.stderr) == (2, FULL)

    closed = subprocess.run(
        ["bash", "-c", f"{command} >&-"], stderr=subprocess.PIPE, text=True, check=False
    )
    assert closed.returncode == (2 if must_print else 0)
    assert closed.stderr.count("\n") == must_print


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a full device")
@pytest.mark.parametrize(("command", "must_print"), [("plan", 1), ("verify", 1), ("export", 0)])
def test_every_command_tells_that_its_output_cannot_be_written(
    command: str,
    must_print: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    args = [command]
    if command == "verify":
        args.append(str(tmp_path / "p.json"))
        Path(args[1]).write_text(json.dumps(plan(load_scene("paper")).to_dict()))
    if command == "export":
        args += ["paper", "--to", str(tmp_path / "a.csv")]
    with monkeypatch.context() as there:
        full = open("/dev/full", "w", encoding="utf-8")  # noqa: SIM115
        there.setattr(sys, "stdout", full)
        assert run(there, capsys, *args) == (2, "", FULL)
        full.close()  # what was not written is gone
    with monkeypatch.context() as there:
        there.setattr(sys, "__stdout__", None)
        code, _, err = run(there, capsys, *args)
    assert (code, err.count("\n")) == (2 * must_print, must_print)


@pytest.mark.parametrize(("scene", "code"), [("paper", 0), ("no-way", INCOMPLETE)])
def test_plan_compares_all_searches_only_when_asked(
    scene: str, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    done, out, _ = run(monkeypatch, capsys, "plan", scene, "--all-searches")

    searches = {search["algorithm"]: search for search in json.loads(out)["searches"]}
    assert done == code
    assert tuple(searches) == tuple(COMPARED)
    exact = {one["length"] for name, one in searches.items() if COMPARED[name].exact}
    assert (
        max(exact, default=0) == pytest.approx(min(exact, default=0))
        if code == 0
        else (exact == {None})
    )
    _, out, _ = run(monkeypatch, capsys, "plan", scene)
    assert [one["algorithm"] for one in json.loads(out)["searches"] or []] == (
        list(SEARCHES) if code == 0 else []
    )


def test_plan_list_names_the_scenes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(monkeypatch, capsys, "plan", "--list")

    assert code == 0
    assert tuple(out.split()) == scene_names()


def test_reproduce_sets_the_papers_figures_beside_ours(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(monkeypatch, capsys, "reproduce", "--format", "csv")

    assert (code, err) == (0, "")
    lines = out.splitlines()
    for verdict, *words in (
        ("depends on the mesh", "Dijkstra", "13.695"),
        ("holds", "printed polynomials", "11.358", "11.3581"),
        ("does not hold", "q1 by arccos", "24 %"),
    ):
        (line,) = (line for line in lines if all(word in line for word in words))
        assert line.endswith(f",{verdict}")


def test_no_plan_still_writes_the_json_and_exits_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "plan.json"
    code, out, err = run(monkeypatch, capsys, "plan", "no-way", "--out", str(target))

    assert (code, out) == (3, "")
    assert json.loads(target.read_text())["error"]["kind"] == "no_path"
    assert len(err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("plan", "nowhere"), "paper"),
        (("plan", "missing.yaml"), "missing.yaml"),
        (("plann",), "did you mean plan?"),
        (("plan", "--out", "/nowhere/at/all.json"), "all.json"),
        (("plan", "--fast"), "--fast"),
        (("serve", "--port", "99999"), "port"),
        (("serve", "nowhere", "--no-open"), "nowhere"),
        (("--port", "x"), "port"),
        (("serve", "--host", "256.1.1.1", "--no-open"), "--host is '256.1.1.1'"),
        (("serve", "--host", "example.invalid", "--no-open"), "--host is 'example.invalid'"),
        (("serve", "--host", "192.0.2.7", "--no-open"), "--host is '192.0.2.7'"),
        (("serve", "--host", "x" * 70, "--no-open"), "127.0.0.1"),
        (("serve", "--host", "", "--no-open"), "--host is ''"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    args: tuple[str, ...],
    words: str,
) -> None:
    code, out, err = run(monkeypatch, capsys, *args)

    assert (code, out) == (2, "")
    assert words in err
    assert len(err.strip().splitlines()) == 1


def test_help_tells_of_every_command_in_a_whole_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(monkeypatch, capsys, "--help")

    lines = out.partition("Commands:\n")[2].splitlines()
    assert code == 0
    assert {line.split()[0] for line in lines} >= {"serve", "plan", "verify", "export"}
    assert all(line.endswith(".") and "..." not in line for line in lines), lines


def test_a_broken_scene_file_names_the_field(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("version: 1\nmesh: {pitch: -3}\n")
    code, _, err = run(monkeypatch, capsys, "plan", str(path))

    assert code == 2
    assert "mesh.pitch" in err
    assert "-3" in err


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "kitchen-ur5e", "sculpture", "no-way"])
def test_the_plan_of_a_shipped_scene_can_be_verified_wherever_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    target = tmp_path / "plan.json"
    run(monkeypatch, capsys, "plan", name, "--out", str(target))
    data = json.loads(target.read_text())
    if data["error"] is not None:
        assert name == "no-way"
        return
    proven = all(data[curve]["certificate"] is not None for curve in ("bspline", "quadratic"))
    code, out, err = run(monkeypatch, capsys, "verify", str(target))

    assert code == (0 if proven else INCOMPLETE)
    assert out.startswith("bspline: proven")
    # which file a proof is about is said where it is not the one beside the plan
    files = {body["file"] for body in data["scene"]["obstacles"] if body["shape"] == "mesh"}
    assert len(err.splitlines()) == len(files)
    assert all(file in err for file in files)


@pytest.mark.slow
def test_a_plan_of_a_packed_scene_is_verified_with_its_zip(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A mesh that was no OBJ has another name in the zip than in the plan."""
    files = {"ball.stl": meshes.stl(meshes.sphere(1, 0.5))}
    obstacle = {"shape": "mesh", "file": "ball.stl", "position": [3, 3, 3]}
    data = {"version": 1, "obstacles": [obstacle], "arm": {"avoid": False}}
    data["quadratic"] = {"mode": "clear"}
    packed, target = tmp_path / "s.zip", tmp_path / "plan.json"
    packed.write_bytes(Scene.from_dict(data, files).pack())
    assert run(monkeypatch, capsys, "plan", str(packed), "--out", str(target))[0] == 0
    code, out, err = run(monkeypatch, capsys, "verify", str(target), "--meshes", str(packed))
    assert (code, err) == (INCOMPLETE, "")  # the arm alone, which avoids nothing
    assert out.startswith("bspline: proven")
    assert "quadratic: proven" in out


@pytest.mark.slow
def test_verify_looks_beside_the_plan_first_and_names_the_option(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target, folder = tmp_path / "plan.json", tmp_path / "meshes"
    run(monkeypatch, capsys, "plan", "sculpture", "--out", str(target))
    folder.mkdir()
    mesh = folder / "knot.obj"
    mesh.write_bytes(assets.path("scenes", "meshes", "knot.obj").read_bytes())
    code, out, err = run(monkeypatch, capsys, "verify", str(target))
    assert (code, err) == (0, "")
    assert "NOT" not in out

    # another mesh beside the plan is the one that counts, even where it is none
    corners = ("99 99 99", "-99 -99 99", "-99 99 -99", "99 -99 -99")
    faces = ("1 2 3", "1 4 2", "1 3 4", "2 4 3")
    lines = [f"v {corner}" for corner in corners] + [f"f {face}" for face in faces]
    mesh.write_text("\n".join(lines))
    code, out, err = run(monkeypatch, capsys, "verify", str(target))
    assert (code, err) == (INCOMPLETE, "")
    mesh.write_text("")
    code, out, err = run(monkeypatch, capsys, "verify", str(target))
    assert (code, out) == (2, "")
    assert "meshes/knot.obj" in err

    target.write_text(target.read_text().replace("knot.obj", "not-there.obj"))
    for name in ("not-there.obj", "../not-there.obj", "/etc/not-there.obj"):
        target.write_text(target.read_text().replace("meshes/not-there.obj", name))
        code, out, err = run(monkeypatch, capsys, "verify", str(target))
        assert (code, out) == (2, "")
        assert "--meshes" in err
        assert len(err.strip().splitlines()) == 1
        target.write_text(target.read_text().replace(name, "meshes/not-there.obj"))


@pytest.mark.parametrize(
    ("host", "shown"),
    [
        ("127.0.0.1", "127.0.0.1"),
        ("0.0.0.0", "127.0.0.1"),
        ("localhost", "localhost"),
        ("::1", "[::1]"),
        ("::", "[::1]"),
    ],
)
def test_the_address_shown_is_one_that_answers(host: str, shown: str) -> None:
    try:
        policy = policy_for(host, needs_token=False)
        server = Server(host, 0, PLAIN, policy)
    except AbiError:
        assert ":" in host, "every machine has IPv4"
        pytest.skip("no IPv6 here")
    try:
        assert server.url.startswith(f"http://{shown}:")
        with urllib.request.urlopen(server.url, timeout=10) as page:
            assert page.status == 200
    finally:
        server.stop()


@pytest.mark.parametrize(
    ("addresses", "listening"),
    [(["192.0.2.7", "127.0.0.1"], "127.0.0.1"), (["127.0.0.1"], "name.invalid")],
)
def test_a_name_with_an_address_elsewhere_is_served_on_the_one_here(
    monkeypatch: pytest.MonkeyPatch, addresses: list[str], listening: str
) -> None:
    def found(host: str | None, port: int, *_: object, **__: object) -> list[tuple[object, ...]]:
        hosts = addresses if host == "name.invalid" else [host]
        kind = (socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP, "")
        return [(*kind, (host, port)) for host in hosts]

    monkeypatch.setattr(socket, "getaddrinfo", found)
    server = Server("name.invalid", 0)
    try:
        assert server.viser.get_host() == listening
        assert server.url == f"http://name.invalid:{server.viser.get_port()}"
    finally:
        server.stop()


@pytest.mark.slow
def test_the_installed_command_answers() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "app", "plan", "thin-plate"], capture_output=True, text=True
    )

    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["path"]["length"] > 5.2


def test_export_writes_by_the_files_ending_or_by_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table, named = tmp_path / "motion.csv", tmp_path / "motion.txt"
    for args in ((str(table),), (str(named), "--format", "csv")):
        code, out, err = run(monkeypatch, capsys, "export", "paper", "--to", *args)
        assert (code, err) == (0, "")
        assert out.startswith(args[0])

    assert table.read_bytes() == named.read_bytes()
    assert len(table.read_text().splitlines()) == 402


def test_export_warns_of_a_motion_through_a_wall(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for file in ("a.csv", "a.ros.json", "a.mcap"):
        target = str(tmp_path / file)
        code, _, err = run(monkeypatch, capsys, "export", "wall-with-window", "--to", target)
        assert code == 0
        assert err.count("\n") == 1
        assert (
            "Warning: the arm's motion is not proven clear. The slide goes 0.549 cm into obstacle 2"
            in err
        )
    target = str(tmp_path / "a.scene")
    assert run(monkeypatch, capsys, "export", "wall-with-window", "--to", target)[2] == ""


@pytest.mark.slow
def test_export_warns_of_a_motion_past_the_joints_limits(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    fast = {"speed": 20.0, "acceleration": 1000.0, "deceleration": 1000.0, "law": "three_phase"}
    scene = load_scene("kitchen-ur5e").replace(obstacles=[], motion=fast)
    scene.save(tmp_path / "fast.yaml")
    target = tmp_path / "fast.script"
    code, _, err = run(
        monkeypatch, capsys, "export", str(tmp_path / "fast.yaml"), "--to", str(target)
    )
    assert code == 0
    assert "Warning: the motion passes limits of the joints." in err
    assert "motion.law: slowed" in err
    assert "PASSES LIMITS" in target.read_text()


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (("--to", "motion.docx"), "expected one of .csv"),
        (("--to", "motion.csv", "--format", "stl"), "expected one of csv"),
        (("--to", "none/motion.csv"), "cannot be written"),
        ((), "--to"),
    ],
)
def test_export_refuses_in_one_line(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    args: tuple[str, ...],
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run(monkeypatch, capsys, "export", "paper", *args)

    assert (code, out) == (2, "")
    assert expected in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_export_of_a_scene_without_a_plan_exits_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    code, _, err = run(monkeypatch, capsys, "export", "no-way", "--to", str(tmp_path / "a.csv"))
    assert (code, list(tmp_path.iterdir())) == (3, [])
    assert "no motion to export: No path" in err

    code, _, err = run(monkeypatch, capsys, "export", "no-way", "--to", str(tmp_path / "a.json"))
    assert code == 3
    assert json.loads((tmp_path / "a.json").read_text())["error"]["kind"] == "no_path"


@pytest.mark.slow
def test_sweep_writes_a_table_and_plots(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    study = tmp_path / "study.yaml"
    study.write_text("version: 1\nscenes: [paper, no-way]\nvary: {mesh.pitch: [1.2, 0.9]}\n")
    out = tmp_path / "found"

    code, printed, err = run(
        monkeypatch, capsys, "sweep", str(study), "--out", str(out), "--workers", "1"
    )

    assert code == 0
    assert "4/4" in err
    assert "mesh.pitch" in printed
    assert len((out / "plans.csv").read_text().splitlines()) == 5
    assert {path.name for path in out.glob("*.svg")} == {"gaps.svg", "clearances.svg", "times.svg"}


def test_the_table_of_a_study_keeps_its_units_and_shows_rounding_as_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    sweep.print_table([{"scene": "[b]x[/b]", "time [ms]": 12.5, "gap [%]": 1.1e-13}])
    printed = capsys.readouterr().out
    for words in ("time [ms]", "gap [%]", "[b]x[/b]", "│ 0 "):
        assert words in printed


@pytest.mark.slow
def test_a_study_of_a_wrong_scene_is_refused_without_a_bar(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "mine.yaml").write_text("version: 1\nmesh: {pitch: -1}\n")
    (tmp_path / "study.yaml").write_text("version: 1\nscenes: [mine.yaml]\n")
    args = "sweep", str(tmp_path / "study.yaml"), "--out", str(tmp_path / "found")
    code, out, err = run(monkeypatch, capsys, *args)
    assert (code, out) == (2, "")
    assert err.startswith("abi: The scene mine.yaml cannot be planned: mesh.pitch is -1")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["missing.yaml"], "study is 'missing.yaml'"),
        (["missing.yaml", "--workers", "2", "--scheduler", "tcp://a:1"], "exclude each other"),
    ],
)
def test_sweep_refuses_in_one_line(
    args: list[str],
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out, err = run(monkeypatch, capsys, "sweep", *args)

    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
