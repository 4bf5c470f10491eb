"""The command line: its help, and what it says where something is in the way."""

import errno
import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from pwsviz.__main__ import main
from pwsviz.report import figures_of_paper
from pwsviz.server import serving

ROOT = Path(__file__).parents[2]


@pytest.fixture
def taken():
    """A port on which somebody listens."""
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        yield other.getsockname()[1]


@pytest.fixture
def told(monkeypatch):
    """What `panel` is told, in place of serving."""
    arguments = []
    monkeypatch.setattr(serving.runpy, "run_module", lambda *_, **__: arguments.extend(sys.argv))
    monkeypatch.setattr(sys, "argv", list(sys.argv))
    monkeypatch.setattr(serving, "_refusal", lambda *_: None)
    return arguments


def values_of(option, arguments):
    return [arguments[k + 1] for k, word in enumerate(arguments) if word == option]


def test_serve_answers_with_the_page(tmp_path):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "pwsviz", "serve", "--no-show", "--port", str(port)]
    with subprocess.Popen(command, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}) as server:
        try:
            deadline = time.monotonic() + 60
            while server.poll() is None and time.monotonic() < deadline:
                try:
                    with urllib.request.urlopen(f"http://localhost:{port}/app", timeout=30) as page:
                        assert b"pwsviz" in page.read()
                    return
                except urllib.error.URLError:
                    time.sleep(0.2)
            pytest.fail(f"no answer; it has ended with {server.poll()}")
        finally:
            server.terminate()


@pytest.mark.parametrize("command", ["serve", "report"])
def test_help_has_examples_and_the_environment(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    text = capsys.readouterr().out
    assert ended.value.code == 0
    assert f"examples:\n  python -m pwsviz {command}" in text
    assert "PWSVIZ_CACHE" in text
    assert max(map(len, text.splitlines())) <= 120


def test_help_of_all_names_every_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    for command in ("serve", "report", "bench"):
        assert f"python -m pwsviz {command}" in text


def test_help_of_report_names_every_figure(capsys):
    with pytest.raises(SystemExit):
        main(["report", "--help"])
    text = capsys.readouterr().out
    assert [label for label in figures_of_paper() if label not in text] == []


def test_help_is_there_without_loading_what_serving_must_not_fork():
    barred = "('core', 'numba', 'panel')"
    code = f"import sys, pwsviz.__main__, pwsviz.server.serving; print([m for m in {barred} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    assert out.strip() == "[]"


def test_a_taken_port_is_said_and_another_offered(taken, capsys):
    assert main(["serve", "--no-show", "--port", str(taken), "--address", "127.0.0.1"]) == 1
    words = capsys.readouterr().err
    assert f"Port {taken} of 127.0.0.1 is taken" in words
    other = int(words.rsplit("--port ", 1)[1].rstrip(".\n"))
    serving.require_port(other, "127.0.0.1")


def test_an_address_of_another_machine_is_said(capsys):
    assert main(["serve", "--no-show", "--address", "192.0.2.1"]) == 1  # RFC 5737: nobody's
    assert "192.0.2.1 is not an address of this machine" in capsys.readouterr().err


def test_a_port_one_may_not_take_is_said(monkeypatch, capsys):
    monkeypatch.setattr(serving, "_bind", lambda *_: errno.EACCES)
    assert main(["serve", "--no-show", "--port", "80"]) == 1
    assert "Port 80 is not permitted to you" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--port", "70000"], ["--port", "x"], ["--num-procs", "-1"]])
def test_numbers_that_make_no_sense_are_refused(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["serve", *arguments])
    assert ended.value.code == 2
    assert f"argument {arguments[0]}: " in capsys.readouterr().err


def test_panel_is_told_every_option(told):
    origins = ["--allow-websocket-origin", "a.example", "--allow-websocket-origin", "b.example:80"]
    assert main(["serve", "--port", "6000", "--num-procs", "3", *origins, "--", "--prefix", "/x"]) == 0
    assert told[:2] == ["panel", "serve"]
    assert values_of("--port", told) == ["6000"]
    assert values_of("--num-procs", told) == ["3"]
    assert values_of("--allow-websocket-origin", told) == ["localhost:6000", "a.example", "b.example:80"]
    assert told[-3:] == ["--show", "--prefix", "/x"]


def test_panel_knows_all_that_it_is_told():
    from panel.command.serve import Serve

    known = {flag for flags, _ in Serve.args for flag in ([flags] if isinstance(flags, str) else flags)}
    given = serving.panel_arguments(5006, "localhost", True, 0, ["a.example"])
    assert {word for word in given if word.startswith("--")} <= known


def test_without_a_number_of_processes_panel_does_not_count_them_itself():
    (count,) = values_of("--num-procs", serving.panel_arguments(5006, "localhost", False, 0, []))
    assert int(count) >= 1


def test_who_listens_for_others_is_told_of_their_names(told, capsys):
    main(["serve", "--no-show", "--address", "0.0.0.0"])  # noqa: S104  (nothing listens: see `told`)
    assert "--allow-websocket-origin NAME:5006" in capsys.readouterr().err
    main(["serve", "--no-show"])
    assert capsys.readouterr().err == ""


def test_the_preloaded_scene_is_that_of_a_fresh_page():
    from pwsviz.page.explorer import Explorer
    from pwsviz.results.results import Results
    from pwsviz.scene.first import first_scene
    from pwsviz.server import preload

    results = Results()
    preload.RESULTS, kept = results, preload.RESULTS
    try:
        preload.compute_first_scene()
    finally:
        preload.RESULTS = kept
    computed = results.computed.copy()
    assert computed["run"] > 0
    page = Explorer(first_scene(), results)
    try:
        page.refresh()
        assert page.settle(30)
    finally:
        page.close()
    assert {kind: results.computed[kind] for kind in ("run", "orbit", "error", "curve")} == {
        kind: computed[kind] for kind in ("run", "orbit", "error", "curve")
    }
