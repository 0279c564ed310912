# SPDX-License-Identifier: MIT
"""What a module owes its interpreter: memory, threads, signals, exceptions, documentation."""

import ast
import inspect
import os
import pydoc
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import selvedge

from conftest import ROOT, ball_scene, sheet


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth(call, count):
    """Growth of memory over the second half of `count` calls, in bytes a call."""
    for _ in range(count // 2):
        call()
    before = resident_bytes()
    for _ in range(count - count // 2):
        call()
    return (resident_bytes() - before) / (count - count // 2)


def test_memory_stays_flat_over_ten_thousand_calls():
    x, t = sheet(2)
    up, down = x + [0, 0, 0.1], x - [0.01, 0.02, 0.1]
    q = np.random.default_rng(1).uniform(-1, 1, (20, 8, 3))
    simulation = selvedge.Simulation(ball_scene(cells=2))
    state = simulation.save()
    bad = np.full_like(x, np.nan)

    def refused():
        with pytest.raises(ValueError):
            selvedge.find_crossings(bad, t)

    calls = {
        "collisions": lambda: selvedge.find_collisions(up, down, t, (x, t)),
        "candidates": lambda: selvedge.find_candidates(up, down, t),
        "contacts": lambda: selvedge.find_contacts(up, t, 0.2, (x, t)),
        "impacts": lambda: selvedge.ccd.point_triangle(q),
        "errors": refused,
        "views": lambda: (simulation.positions, simulation.contacts(), simulation.flags()),
        "check": lambda: selvedge.check(up, t, against=(x, t)),
    }
    with selvedge.ThreadLimit(1):
        for call in calls.values():
            call()
        assert growth(lambda: [call() for call in calls.values()], 10_000 // len(calls)) < 200
        assert growth(lambda: simulation.restore(state), 400) < 2000, "restored states"


def long_step():
    simulation = selvedge.Simulation(ball_scene(cells=100))
    return lambda: simulation._core.step_towards(20)  # one call of the compiled half


def long_detection(find):
    x, t = sheet(100)
    body = x + [0.001, 0.002, -0.001]
    if find is selvedge.find_collisions:
        return lambda: find(x, x - [0, 0, 0.002], t, (body, t))
    return lambda: find(x, t, 0.003, (body, t))


def long_batch():
    q = np.random.default_rng(3).uniform(-1, 1, (300_000, 8, 3))
    return lambda: selvedge.ccd.edge_edge(q)


def long_check():
    x, t = sheet(200)
    return lambda: selvedge.check(x, t, against=(x - [0, 0, 0.001], t))


LONG = {
    "step": long_step,
    "find_collisions": lambda: long_detection(selvedge.find_collisions),
    "find_contacts": lambda: long_detection(selvedge.find_contacts),
    "batch": long_batch,
    "check": long_check,
}


@pytest.mark.parametrize("name", LONG)
def test_other_threads_run_during_a_long_call(name):
    call = LONG[name]()
    turns = []
    done = threading.Event()

    def count():
        while not done.is_set():
            turns.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    time.sleep(0.02)
    begin = time.monotonic()
    call()
    end = time.monotonic()
    done.set()
    thread.join()
    # Turns at the very ends may be those of the Python code around the compiled half.
    edge = 0.2 * (end - begin)
    assert end - begin > 0.004
    assert [turn for turn in turns if begin + edge < turn < end - edge]


def test_a_simulation_refuses_two_threads_at_once():
    simulation = selvedge.Simulation(ball_scene(cells=40, frames=100))
    faults = []

    def work():
        try:
            for _ in range(10):
                simulation.step()
        except RuntimeError as error:
            faults.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults and all("another thread uses this simulation" in fault for fault in faults)
    simulation.step()


def test_a_detector_refuses_two_threads_at_once():
    x, t = sheet(60)
    detector = selvedge.Detector()
    body = (x + [0.001, 0.002, -0.001], t)
    expected = len(detector.find_collisions(x, x - [0, 0, 0.002], t, body))
    faults, found = [], []

    def work():
        for _ in range(10):
            try:
                found.append(len(detector.find_collisions(x, x - [0, 0, 0.002], t, body)))
                detector.find_candidates(x, x, t)
            except RuntimeError as error:
                faults.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults and all("another thread uses this detector" in fault for fault in faults)
    assert set(found) <= {expected}
    assert len(detector.find_collisions(x, x - [0, 0, 0.002], t, body)) == expected


def test_two_simulations_run_in_two_threads_to_the_same_bits():
    hashes = [None, None]

    def work(k):
        simulation = selvedge.Simulation(ball_scene())
        simulation.advance_to_frame(6)
        hashes[k] = simulation.state_hash

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert hashes[0] == hashes[1] is not None


LONG_CALLS = {
    "advance": """
        simulation = selvedge.Simulation(scene)
        call = lambda: simulation.advance_to_frame(99999)
    """,
    "run": """
        call = lambda: selvedge.run(scene, folder)
    """,
    "check": """
        selvedge.run({**scene, "time": {"frames": 3}}, folder, every_step=True)
        import pathlib, shutil
        steps = pathlib.Path(folder) / "steps"
        (first,) = list(steps.glob("cloth_*1.*"))[:1]
        call = lambda: [selvedge.check(folder) for _ in range(100000)]
    """,
    "compare": """
        import json
        with open(folder + ".json", "w") as file:
            json.dump({**scene, "time": {"frames": 99999}}, file)
        call = lambda: selvedge.compare(folder + ".json", "dt=1e-3,1e-4", folder, reference=False)
    """,
    "find_collisions": """
        from conftest import sheet
        x, t = sheet(300)
        x = x * [0.01, 0.01, 1]  # every triangle meets hundreds
        detector = selvedge.Detector()
        call = lambda: detector.find_collisions(x, x - [0, 0, 0.1], t, (x - [0.3, 0.4, 50] * x[:1], t))
    """,
}


@pytest.mark.parametrize("name", LONG_CALLS)
def test_ctrl_c_ends_a_long_call(tmp_path, name):
    program = f"""
import sys
sys.path[:0] = {sys.path!r}
import selvedge
from conftest import ball_scene
scene = ball_scene(cells=6, frames=99999)
folder = {str(tmp_path / "out")!r}
{textwrap.dedent(LONG_CALLS[name])}
print("ready", flush=True)
try:
    call()
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.7)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=30)
    assert out == "interrupted\n"


def test_an_exception_of_a_callback_leaves_the_call():
    class Mine(Exception):
        pass

    def fail(*_):
        raise Mine("stop here")

    simulation = selvedge.Simulation(ball_scene())
    with pytest.raises(Mine, match="stop here"):
        simulation.advance_to_frame(2, before_step=fail)
    with pytest.raises(Mine):
        simulation.advance_to_frame(2, progress=fail)
    simulation.advance_to_frame(3)


def test_an_interrupted_detector_searches_again():
    x, t = sheet(80)
    body = (x - [0.0007, 0.0011, 0.001], t)
    call = (x, x - [0, 0, 0.002], t, body)
    detector = selvedge.Detector()
    expected = len(detector.find_collisions(*call))

    def fire():
        time.sleep(0.06)
        os.kill(os.getpid(), signal.SIGINT)

    interrupted = 0
    for _ in range(5):
        thread = threading.Thread(target=fire)
        thread.start()
        try:
            while True:
                detector.find_collisions(*call)
        except KeyboardInterrupt:
            interrupted += 1
        thread.join()
        assert len(detector.find_collisions(*call)) == expected
    assert interrupted == 5


def test_an_exception_of_the_progress_of_a_run_leaves_the_call(tmp_path):
    def fail(frame, seconds):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        selvedge.run(ball_scene(), tmp_path / "out", progress=fail)
    assert selvedge.run(ball_scene(), tmp_path / "out", overwrite=True)["clean"]


def test_the_stub_of_the_compiled_half_names_what_it_has():
    stub = ast.parse((ROOT / "bindings" / "python" / "selvedge" / "_core.pyi").read_text())
    core = selvedge._core

    def names(body):
        found = set()
        for node in body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                found.add(node.name)
            elif isinstance(node, ast.AnnAssign):
                found.add(node.target.id)
        return found

    assert names(stub.body) == {n for n in vars(core) if not n.startswith("__")}
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    for node in classes.values():
        if node.name != "SimulationFailed":
            kind = getattr(core, node.name)
            public_names = {n for n in vars(kind) if not n.startswith("_")}
            said = names(node.body).union(*(names(classes[base.id].body) for base in node.bases))
            assert said - {"__init__"} == public_names, node.name


# pybind11 gives its classes a metaclass and a general __init__; the names of array types exist for the stub alone.
OF_PYBIND11 = """
selvedge\\._core\\.(Bytes|Floats|Indices)
selvedge\\._core\\.(Batch|Detector|Drawn|Member|SavedState|Scene|Simulation|Surface|ThreadScope)
selvedge\\._core\\.(SavedState|Scene)\\.__init__
"""


def test_types_are_consistent_and_those_of_the_compiled_half(tmp_path):
    pytest.importorskip("mypy", reason="mypy is not installed (Debian: mypy)")
    cache = {"MYPY_CACHE_DIR": str(tmp_path / "cache"), "MYPYPATH": str(ROOT / "bindings" / "python")}

    def run(folder, *command):
        command = [sys.executable, "-m", *map(str, command)]
        return subprocess.run(
            command, env={**os.environ, **cache}, cwd=folder, capture_output=True, text=True
        )

    done = run(tmp_path, "mypy", "--strict", ROOT / "bindings" / "python" / "selvedge")
    assert done.returncode == 0, done.stdout + done.stderr
    allowed = tmp_path / "allowed.txt"
    allowed.write_text(OF_PYBIND11)
    done = run(tmp_path, "mypy.stubtest", "--allowlist", allowed, "selvedge._core")
    assert done.returncode == 0, done.stdout + done.stderr
    # What tells that mypy has read the types: it finds a wrong use.
    (tmp_path / "wrong.py").write_text("import selvedge\nx: str = selvedge.Simulation({}).steps\n")
    done = run(tmp_path, "mypy", "wrong.py")
    assert done.returncode == 1 and '"int"' in done.stdout, done.stdout + done.stderr


def public(kind):
    """Names of the methods that a class documents itself."""
    return [n for n in vars(kind) if not n.startswith("_") or n == "__init__" and vars(kind)["__doc__"]]


def test_every_public_name_is_documented_and_annotated():
    for module in (selvedge, selvedge.ccd):
        for name in module.__all__:
            value = getattr(module, name)
            if isinstance(value, tuple):
                continue
            assert inspect.getdoc(value), name
            functions = (
                [f for n, f in vars(value).items() if inspect.isfunction(f) and n in public(value)]
                if inspect.isclass(value)
                else [value] if inspect.isfunction(value) else []
            )
            for function in functions:
                signature = inspect.signature(function)
                assert signature.return_annotation is not inspect.Signature.empty, function
                for parameter in signature.parameters.values():
                    known = parameter.annotation is not inspect.Parameter.empty
                    assert known or parameter.name == "self", (function, parameter)
    text = pydoc.render_doc(selvedge, renderer=pydoc.plaintext)
    assert "find_collisions(x0" in text and "(n, 3) metres" in text


@pytest.mark.parametrize(
    "call",
    [
        lambda: selvedge.Scene(5),
        lambda: selvedge.Scene({}, folder=5),
        lambda: selvedge.Scene({}, changes=5),
        lambda: selvedge.Simulation(5),
        lambda: selvedge.Batch(5),
        lambda: selvedge.Batch([5]),
        lambda: selvedge.Detector(5),
        lambda: selvedge.Detector(min_separation="near"),
        lambda: selvedge.ThreadLimit("two"),
        lambda: selvedge.run({}, 5),
        lambda: selvedge.check(5),
        lambda: selvedge.measure(5),
        lambda: selvedge.render_result(5),
        lambda: selvedge.write_png(5, np.zeros((2, 2, 3), np.uint8)),
        lambda: selvedge.render(np.eye(3), [[0, 1, 2]], eye="here"),
        lambda: selvedge.render(np.eye(3), [[0, 1, 2]], colour=5),
        lambda: selvedge.render(np.eye(3), [[0, 1, 2]], width="wide"),
        lambda: selvedge.find_contacts(np.eye(3), [[0, 1, 2]], "near"),
        lambda: selvedge.find_collisions(np.eye(3), np.eye(3), [[0, 1, 2]], body=5),
    ],
)
def test_an_argument_of_another_type_is_refused_in_one_sentence(call):
    with pytest.raises((TypeError, ValueError)) as refused:
        call()
    sentence = str(refused.value)
    assert "\n" not in sentence and "incompatible" not in sentence and len(sentence.split()) > 3, sentence
