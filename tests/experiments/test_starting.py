"""While a command's modules are imported: Ctrl-C ends in one line, the garbage collector pauses."""

import os
import subprocess
import sys

import pytest

IMPORTING = """
import gc, os, signal, sys, time
sys.argv[0] = {argument!r}
sys.orig_argv[1] = {original!r}
signal.signal(signal.SIGINT, signal.{handler})
import narx.experiments
print(gc.isenabled(), flush=True)
{then}
os.kill(os.getpid(), signal.SIGINT)
time.sleep(0.1)
print("went on")
"""
IMPORTED = (
    "from narx.experiments.starting import imported; imported(); print(gc.isenabled(), flush=True)"
)


def run(argument="-m", original="-m", handler="default_int_handler", then=""):
    script = IMPORTING.format(argument=argument, original=original, handler=handler, then=then)
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot interrupt itself")
@pytest.mark.parametrize("command", ["-m", "/usr/bin/narx-predict"])
def test_ctrl_c_during_the_imports_ends_in_one_line(command):
    done = run(argument=command, original=command)
    assert done.returncode == 130
    assert done.stdout == "False\n"
    (line,) = done.stderr.strip().splitlines()
    assert line == "interrupted: nothing has begun; repeat the command to start again"


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot interrupt itself")
def test_afterwards_the_command_itself_is_interrupted():
    done = run(then=IMPORTED)
    assert done.stdout == "False\nTrue\n"
    assert "KeyboardInterrupt" in done.stderr


@pytest.mark.parametrize(
    ("argument", "original"),
    [("/usr/bin/narx-train", "-m"), ("my_script.py", "my_script.py")],
    ids=["with the arguments of a command", "a script that imports the package"],
)
def test_other_processes_are_left_alone(argument, original):
    done = run(argument, original, handler="SIG_IGN")
    assert done.stdout == "True\nwent on\n"


def test_the_signal_remains_ignored_in_the_background():
    done = run(handler="SIG_IGN")
    assert (done.returncode, done.stdout) == (0, "False\nwent on\n")


@pytest.mark.concurrency
@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot interrupt itself")
def test_a_worker_ignores_ctrl_c_until_it_has_imported():
    assert run("/usr/bin/narx-train", "joblib.externals.loky").stdout == "True\nwent on\n"
    done = run("/usr/bin/narx-train", "joblib.externals.loky", then=IMPORTED)
    assert "KeyboardInterrupt" in done.stderr


MASKED = """
import os, signal, sys
# a process that was started in the background ignores the signal
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.argv = ["-m"]
import narx.experiments
from narx.experiments.compare import __main__ as compare
from narx.errors import UserError

def masking(*arguments):
    try:
        os.kill(os.getpid(), signal.SIGINT)
        signal.pause()
    except KeyboardInterrupt:
        raise UserError("while cleaning up") from None

compare.compare = masking
sys.argv = ["narx-compare", "."]
compare.main()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot interrupt itself")
def test_an_interruption_that_ends_in_another_error_is_one():
    done = subprocess.run(
        [sys.executable, "-c", MASKED], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 130
    assert done.stderr == "interrupted: repeat the command to start again\n"


@pytest.mark.skipif(sys.platform == "win32", reason="has no such pipes")
@pytest.mark.parametrize(("name", "unbuffered"), [("train", ""), ("train", "1"), ("compare", "")])
def test_a_closed_pipe_ends_the_command_without_a_message(name, unbuffered):
    with subprocess.Popen(
        [sys.executable, "-m", f"narx.experiments.{name}", "--help"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
    ) as process:  # fmt: skip
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


def test_an_unknown_backend_of_matplotlib_has_no_effect():
    script = (
        "import sys; sys.argv[0] = '-m'; import narx.experiments\n"
        "from narx.experiments.figures.canvas import save_figure"
    )
    environment = {**os.environ, "MPLBACKEND": "nonsense"}
    subprocess.run([sys.executable, "-c", script], env=environment, check=True)


def test_letters_that_the_terminal_does_not_have_are_printed_as_escapes():
    script = r"import sys; sys.argv[0] = '-m'; import narx.experiments; print('\u00fc \udcff')"
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "\\xfc \\udcff\n"
