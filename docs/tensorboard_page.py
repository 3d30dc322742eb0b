"""Make the picture of TensorBoard's page: a small sweep, the running page, headless Chromium.

python docs/tensorboard_page.py [FOLDER]

FOLDER holds runs; without it four small trainings are made. Needs `chromium` (Debian's package) or
Google Chrome on the path.
"""

import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

PICTURE = Path(__file__).parent / "figures" / "tensorboard.png"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SWEEP = ("-m", "debug=tiny", "optimizer=levenberg_marquardt,lbfgs", "seed=0,1")
# the page fetches its data in the background; virtual time runs on while it does
PATIENCE_MS = 30_000
LONGEST_START_S = 120.0


def free_port() -> int:
    """Return a port of this machine that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_for(url: str) -> None:
    """Wait until the page of the runs answers, and has found runs."""
    until = time.monotonic() + LONGEST_START_S
    while time.monotonic() < until:
        try:
            with urllib.request.urlopen(f"{url}/data/runs", timeout=10) as answer:
                if answer.read().strip() != b"[]":
                    return
        except OSError:
            pass
        time.sleep(0.5)
    sys.exit(f"error: TensorBoard shows no run within {LONGEST_START_S:.0f} s")


def main() -> None:
    """Make the picture."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        sys.exit(f"error: none of {', '.join(BROWSERS)} is installed")
    with tempfile.TemporaryDirectory() as scratch:
        runs = Path(sys.argv[1] if len(sys.argv) > 1 else scratch)
        if len(sys.argv) == 1:
            train = (sys.executable, "-m", "narx.experiments.train", *SWEEP)
            subprocess.run([*train, f"hydra.sweep.dir={runs}"], check=True)
        port = free_port()
        server = subprocess.Popen(
            [sys.executable, "-m", "tensorboard.main", "--logdir", runs, "--port", str(port)],
            stderr=subprocess.DEVNULL,
        )
        try:
            url = f"http://127.0.0.1:{port}"
            wait_for(url)
            subprocess.run(
                [
                    browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                    "--window-size=1800,900", f"--virtual-time-budget={PATIENCE_MS}",
                    f"--user-data-dir={scratch}/browser", f"--screenshot={PICTURE}",
                    f"{url}/#hparams",
                ],
                check=True,
            )  # fmt: skip
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
