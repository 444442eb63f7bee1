"""Kernels: which are compiled, when, and what is kept from one run to the next."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from io import StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar, NamedTuple

import numba
import numpy as np
import pytest

import abi
from abi import compiler_process, compiling, load_scene, plan, progress
from abi.arrays import read_only
from abi.compilation import jitable
from abi.compilation.kernel_stamp import fields_of, stamp
from abi.compiled import FLOATS, KERNELS, NEW_FLOATS, Kernel, compiled
from tests.kernel_forms import kernels_as


def test_every_kernel_is_compiled_for_one_signature() -> None:
    abi.compile()
    kernels = compiling.all_kernels()
    assert len(kernels) > 25
    with kernels_as(compiled=True):
        for name in ("paper", "forest", "sculpture", "thin-plate", "wall-with-window"):
            for mode in ("least_squares", "pieces"):
                assert plan(load_scene(name).replace(quadratic={"mode": mode})).motion
    assert {kernel.name: len(kernel.of_numba.signatures) for kernel in kernels} == {
        kernel.name: 1 for kernel in kernels
    }


def helper(a: float) -> float:
    return 2 * a


def other_helper(a: float) -> float:
    """Docstrings do not count."""

    return 2 * a  # nor do comments


def doubled(numbers: Any, found: Any) -> float:
    for i in range(len(numbers)):
        found[i] = helper(numbers[i])
    return float(len(numbers))


@pytest.fixture
def kernel() -> Iterator[Kernel[..., float]]:
    made = compiled(example=(FLOATS, NEW_FLOATS))(doubled)
    yield made
    del KERNELS[made.name]


def test_a_kernel_does_the_same_as_python_and_compiled(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "helper", numba.njit(helper))
    numbers = np.array([1.0, 2.0, math.inf])
    numbers.setflags(write=False)
    for form in (False, True):
        if form:
            kernel.compile()
        assert kernel.compiled == form
        found = np.zeros(3)
        assert kernel(numbers, found) == 3
        np.testing.assert_array_equal(found, [2, 4, math.inf])


def test_threads_that_compile_the_same_kernel_wait_for_each_other(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "helper", numba.njit(helper))
    with ThreadPoolExecutor(4) as threads:
        for compilation in [threads.submit(kernel.compile) for _ in range(4)]:
            compilation.result()
    assert kernel.compiled


@pytest.mark.parametrize(
    "values",
    [
        pytest.param(np.zeros((2, 2)), id="two dimensions"),
        pytest.param(np.zeros(4)[::2], id="strided"),
        pytest.param(np.zeros(2, np.int64), id="integers"),
        pytest.param(np.zeros(2, np.float32), id="float32"),
        pytest.param(np.zeros(2, ">f8"), id="big-endian"),
        pytest.param([0.0, 0.0], id="list"),
    ],
)
def test_another_type_or_layout_is_an_error_and_not_compiled_for(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch, values: Any
) -> None:
    monkeypatch.setitem(globals(), "helper", numba.njit(helper))
    kernel.compile()
    assert kernel.compiled
    with pytest.raises(TypeError):
        kernel(values, np.zeros(2))


def test_a_compiled_kernel_writes_no_array_that_is_read_only(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "helper", numba.njit(helper))
    kernel.compile()
    found = read_only(np.zeros(2))
    with pytest.raises(TypeError):
        kernel(np.ones(2), found)
    np.testing.assert_array_equal(found, [0, 0])


def test_a_stamp_changes_with_what_is_compiled_and_with_nothing_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = stamp(doubled)
    assert stamp(doubled, "error_model") != before

    renamed = other_helper
    monkeypatch.setattr(renamed, "__qualname__", "helper")
    monkeypatch.setattr(renamed, "__name__", "helper")
    monkeypatch.setitem(globals(), "helper", renamed)
    assert stamp(doubled) == before

    monkeypatch.setitem(globals(), "helper", lambda a: 3 * a)
    assert stamp(doubled) != before


def test_a_stamp_changes_with_how_a_helper_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    before = stamp(doubled)
    monkeypatch.setitem(jitable._OPTIONS, helper, {"forceinline": True})
    assert stamp(doubled) != before


class Range(NamedTuple):
    low: float
    high: float


class Turned(NamedTuple):
    high: float
    low: float


def test_a_stamp_changes_with_the_order_of_fields() -> None:
    fields = fields_of((1, (FLOATS, Range(0.0, 1.0))))
    assert fields_of((1, (FLOATS, Turned(0.0, 1.0)))) != fields
    assert fields_of((2, (FLOATS, Range(3.0, 4.0)))) == fields


PLANS = """
import abi, sys
from abi.compiled import KERNELS
scene = abi.load_scene("paper")
x = 0.0
most = int(sys.argv[1])
used = []
while len(used) != most:
    x += 1e-3
    abi.plan(scene.replace(goal=[6 - x, 6, 6]))
    used.append(sum(kernel.compiled for kernel in KERNELS.values()) / len(KERNELS))
    if used[-1] == 1:
        break
print(*used)
"""


def run(code: str, *arguments: str, **environment: str) -> str:
    there = {"PYTHONPATH": str(Path(abi.__file__).parents[1])} | environment
    out = subprocess.run(
        [sys.executable, "-P", "-c", code, *arguments],
        env=os.environ | there,
        check=True,
        capture_output=True,
        text=True,
        timeout=170,  # compilers may be at work beside it
    )
    assert out.stderr == ""
    return out.stdout


@pytest.mark.slow
def test_numba_is_imported_for_kernels_alone() -> None:
    code = """
import sys, abi, app.server.server, app.tab.session
from abi.tet_mesh import exclusion_kernels
print("numba" in sys.modules, end=" ")
exclusion_kernels.mark.compile()
print("numba" in sys.modules)
"""
    assert run(code).split() == ["False", "True"]


@pytest.mark.slow
def test_a_script_comes_to_run_compiled() -> None:
    abi.compile()
    used = [*map(float, run(PLANS, "-1").split())]
    assert used[0] == 0
    assert used[-1] == 1


class Event(threading.Event):
    """One that never comes, and tells how long it was waited for."""

    timeouts: ClassVar[list[float | None]] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.timeouts.append(timeout)
        return False


def test_a_plan_waits_for_loading_about_as_long_as_one_without_takes(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    compilation = compiling._Compilation()
    compilation.loaded, compilation._thread = Event(), threading.current_thread()
    monkeypatch.setattr(compiling, "_compilation", compilation)
    monkeypatch.setattr(compiling, "KERNELS", {"": kernel})
    compiling.wait_for_loading()
    kernel._interpreted = 7.0
    compiling.wait_for_loading()
    kernel._interpreted = 1e-9
    compiling.wait_for_loading()
    assert Event.timeouts == [None, 14.0, compiling._PATIENCE]


def test_plans_of_a_crowd_wait_for_kept_kernels_once_python_took_long(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    compilation, waited = compiling._Compilation(), []
    compilation._thread = threading.current_thread()
    monkeypatch.setattr(compiling, "_compilation", compilation)
    monkeypatch.setattr(compiling, "KERNELS", {"": kernel})
    here = threading.get_ident()

    def wait(event: threading.Event, _: object) -> None:
        if threading.get_ident() == here:  # and not in a plan that an earlier test began
            waited.append(event)

    monkeypatch.setattr(progress, "wait", wait)
    for needed in (0.9 * compiling._BEARABLE, 1.1 * compiling._BEARABLE):
        assert not waited
        kernel._interpreted = needed
        compiling.wait_for_kept()
    assert waited == [compilation.kept]
    compilation._thread = None
    compilation._work()
    compiling.wait_for_kept()
    assert len(waited) == 1


def test_what_plans_have_called_is_loaded_first(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    others = [compiled(example=(FLOATS, NEW_FLOATS))(doubled) for _ in range(3)]
    kernels = {str(k): one for k, one in enumerate((*others, kernel))}
    compilation, loaded = compiling._Compilation(), []

    def load(one: Kernel[..., Any]) -> bool:
        loaded.append((one, compilation.loaded.is_set()))
        return True

    monkeypatch.setattr(compiling, "KERNELS", kernels)
    monkeypatch.setattr(compiling, "all_kernels", lambda: list(kernels.values()))
    monkeypatch.setattr(compilation, "_load", load)
    kernel.interpret(np.ones(9), np.zeros(9))
    compilation.wanted.set()
    compilation._work()
    assert loaded[:2] == [(kernel, False), (others[0], True)]
    assert compilation.done.is_set()


def test_what_remains_is_told_by_the_share_of_what_was_missing(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = compiled(example=(FLOATS, NEW_FLOATS))(doubled)
    compilation = compiling._Compilation()
    assert compilation.share_done() is None
    compilation._missing, compilation._begun = (kernel, other), time.monotonic() - 25
    assert compilation.share_done() == 0.0
    assert not compilation.time_left()
    monkeypatch.setattr(other, "_run", other._compiled)
    assert compilation.share_done() == 0.5  # they are of one size
    assert compilation.time_left() == "30 s"
    compilation.done.set()
    assert compilation.share_done() is None
    assert not compilation.time_left()


@pytest.mark.slow
def test_a_script_ends_well_while_kernels_are_compiled(tmp_path: Path) -> None:
    # its end comes once other processes have begun
    late = PLANS + "\nfrom threading import Event\nEvent().wait(1.5)"
    assert float(run(late, "1", NUMBA_CACHE_DIR=str(tmp_path))) == 0


FORK = """
import os, threading, abi
from abi.compilation import dispatcher
from abi.tet_mesh import exclusion_kernels

begun, pause, loaded = threading.Event(), threading.Event(), threading.Event()
load = dispatcher.compile_once

def slowly(*kernel):
    begun.set()
    pause.wait(0.5)
    load(*kernel)
    loaded.set()

dispatcher.compile_once = slowly
threading.Thread(target=exclusion_kernels.mark.compile).start()
begun.wait()
child = os.fork()
if child == 0:
    dispatcher.compile_once = load
    abi.compile()
    os._exit(0 if loaded.is_set() and abi.plan(abi.load_scene("paper")).error is None else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked")
def test_a_fork_waits_for_the_kernel_that_is_being_loaded() -> None:
    abi.compile()
    assert run(FORK).strip() == "0"


CACHED = """
import sys
from abi.obstacles import obstacle_set_kernels
from abi.tet_mesh import exclusion_kernels
for kernel in (exclusion_kernels.mark, obstacle_set_kernels.signed_distances):
    print(int(kernel.cached), end=" ")
    kernel.compile()
"""


@pytest.mark.slow
def test_without_a_compiler_all_runs_as_python() -> None:
    code = "import abi; abi.compile(); print(abi.plan(abi.load_scene('paper')).error)"
    assert run(code, NUMBA_DISABLE_JIT="1").strip() == "None"


@pytest.mark.slow
def test_on_a_full_disk_a_kernel_is_compiled_and_not_kept(tmp_path: Path) -> None:
    code = """
import resource, signal
from abi.tet_mesh import exclusion_kernels
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
kernel = exclusion_kernels.mark
kernel.compile()
print(kernel.compiled, kernel.cached)
"""
    assert run(code, NUMBA_CACHE_DIR=str(tmp_path)).split() == ["True", "False"]


def waiting_kernel(kernel: Kernel[..., Any]) -> Kernel[..., Any]:
    kernel.elsewhere = threading.Event()
    return kernel


def test_a_notebook_that_adds_to_the_builtins_meanwhile_stops_no_compilation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from abi.compilation import dispatcher

    failures = iter([RuntimeError("dictionary changed size during iteration")] * 2)

    def failing(**options: Any) -> Any:
        if (failure := next(failures, None)) is not None:
            raise failure
        return numba.njit(**options)

    monkeypatch.setattr(dispatcher, "numba", SimpleNamespace(njit=failing))
    assert dispatcher.jitted(lambda x: 2 * x, {})(4) == 8
    assert next(failures, None) is None


def test_a_compiling_process_that_is_gone_is_passed_over_in_silence(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(_: bool) -> subprocess.Popen[str]:
        child = subprocess.Popen(
            [sys.executable, "-c", ""], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        child.wait()
        return child

    monkeypatch.setattr(compiler_process, "start", gone)
    compiling._Compilation()._from_children([kernel])
    assert kernel.elsewhere is not None
    assert kernel.elsewhere.is_set()


def test_the_kernel_that_has_run_longest_for_its_size_is_compiled_next(
    kernel: Kernel[..., float],
) -> None:
    others = [compiled(example=(FLOATS, NEW_FLOATS))(doubled) for _ in range(3)]
    compilation, child = compiling._Compilation(), a_child()
    compilation._waiting = [*others[:2], kernel, others[2]]
    kernel.interpret(np.ones(9), np.zeros(9))
    assert compilation._tell_next(child) is kernel
    # without a need in the order of their modules, which share what they call
    assert [compilation._tell_next(child) for _ in range(4)] == [*others, None]
    assert told(child) == [one.name for one in (kernel, *others)]


def test_what_is_waited_for_and_what_is_foreseen_is_compiled_first(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    waited, first, second = (compiled(example=(FLOATS, NEW_FLOATS))(doubled) for _ in range(3))
    compilation, child = compiling._Compilation(), a_child()
    compilation._waiting = [second, first, kernel, waited]
    compilation._ending = True  # starts no thread
    monkeypatch.setattr(compiling, "_compilation", compilation)
    compiling.foresee((first, second))
    assert compilation.wanted.is_set()
    compilation._ending = False
    kernel._interpreted, waited._interpreted = 1.0, math.inf
    assert [compilation._tell_next(child) for _ in range(4)] == [waited, first, second, kernel]


def a_child() -> Any:
    """A process that hears what it is told, and does nothing."""
    return SimpleNamespace(stdin=StringIO())


def told(child: Any) -> list[str]:
    """Names of the kernels that a process was told to compile."""
    heard: str = child.stdin.getvalue()
    return heard.split()


@pytest.mark.parametrize(("seconds", "left"), [(0.7, 2), (0.3, 0)])
def test_what_a_long_program_has_run_as_python_is_compiled_for_the_next(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch, seconds: float, left: int
) -> None:
    kernels = [kernel, *(compiled(example=(FLOATS, NEW_FLOATS))(doubled) for _ in range(2))]
    compilation, children = compiling._Compilation(), [a_child(), a_child()]
    compilation._waiting, compilation._children = kernels, children
    for needed in kernels[:2]:
        needed._interpreted = seconds
    monkeypatch.setattr(compiling, "LOADING", threading.Lock())
    compilation.end()
    assert sum(len(told(child)) for child in children) == left
    assert compilation._tell_next(children[0]) is None


def test_the_need_of_a_kernel_grows_while_it_runs() -> None:
    needs: list[float] = []

    def look() -> None:
        needs.append(looking.need)

    looking: Kernel[[], None] = compiled(example=())(look)
    del KERNELS[looking.name]
    assert looking.need == 0
    looking()
    assert 0 < needs[0] < looking.need
    after = looking.need
    assert looking.need == after


def test_who_needs_a_kernel_waits_for_the_process_that_compiles_it(
    kernel: Kernel[..., float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(globals(), "helper", numba.njit(helper))
    waiting_kernel(kernel)
    assert kernel.elsewhere is not None
    with ThreadPoolExecutor(1) as threads:
        done = threads.submit(kernel.compile)
        while not math.isinf(kernel.need):
            assert not done.done()
        assert not kernel.compiled
        kernel.elsewhere.set()
        done.result()
    assert kernel.compiled


@pytest.mark.slow
def test_a_compiling_process_outlives_its_parent_by_the_kernels_it_was_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    child = compiler_process.start(gives_way=False)
    assert child is not None
    assert child.stdin is not None
    assert child.stdout is not None
    for name in ("tet_mesh.exclusion_kernels.mark", "obstacles.obstacle_set_kernels.nearest"):
        print(f"abi.{name}", file=child.stdin, flush=True)
    for pipe in (child.stdin, child.stdout):
        pipe.close()
    child.wait()
    assert list(tmp_path.rglob("*mark*.nbc"))
    assert list(tmp_path.rglob("*nearest*.nbc"))


def test_who_waits_for_the_compiler_hears_how_long_once_that_can_be_said() -> None:
    assert not compiling._time_left(None, 5.0)
    assert not compiling._time_left(0.05, 45.0)
    assert "left" not in compiling._words(0.05, "")
    assert compiling._time_left(0.5, 125.0) == "2 minutes"
    assert compiling._time_left(0.8, 4 * 44.0) == "50 s"
    assert "30% done, about 50 s left" in compiling._words(0.3, "50 s")
