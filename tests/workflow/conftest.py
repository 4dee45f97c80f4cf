import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import toy

ROOT = Path(__file__).resolve().parents[2]
PARTS = (
    *("Snakefile", "Makefile", "requirements.lock", "profiles", "workflow", "config", "src"),
    "resources/MANIFEST.tsv",
)

HELD = """\
    if snakemake.wildcards.sample == {sample!r}:
        import os, pathlib, time
        pathlib.Path({pid!r}).write_text(str(os.getpid()))
        while not pathlib.Path({gate!r}).exists():
            time.sleep(0.02)
"""
"""What holds a job before it writes, put into its script."""


def wait_for(condition, seconds=60.0):
    """Wait until a condition holds; fail if it does not in time."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def contents(results):
    """All results by name, without what tells of time and cost, and hashes of that."""
    files = [path for path in results.rglob("*") if path.is_file()]
    return {
        name: without_costs(json.loads(path.read_text()))
        if path.suffix == ".json"
        else path.read_bytes()
        for path in files
        if not (name := str(path.relative_to(results))).startswith(("logs", "benchmarks"))
        and not name.endswith((".json.sha256", "costs.csv", "costs.csv.sha256"))
    }


def without_costs(value):
    """A JSON value without CPU times and without its record of provenance."""
    if isinstance(value, dict):
        kept = [key for key in value if key != "provenance" and not key.endswith("cpu_s")]
        return {key: without_costs(value[key]) for key in kept}
    return [without_costs(item) for item in value] if isinstance(value, list) else value


class HeldJob:
    """A job that waits before it writes its results, until it is released."""

    def __init__(self, folder: Path) -> None:
        self.pid_file, self.gate = folder / "held job", folder / "gate"

    def pid(self) -> int:
        """Process of the job, once it waits."""
        wait_for(lambda: self.pid_file.exists() and self.pid_file.read_text())
        return int(self.pid_file.read_text())

    def release(self) -> None:
        """Let this job, and all like it, go on."""
        self.gate.touch()


class Project:
    """A copy of the sources with a toy study, in which anything may be broken."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for part in PARTS:
            source, target = ROOT / part, folder / part
            target.parent.mkdir(parents=True, exist_ok=True)
            if source.is_symlink():
                target.symlink_to(os.readlink(source))
            elif source.is_dir():
                shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, target)
        self.study = folder / "my study"
        self.study.mkdir()
        self.table = toy.write_study(self.study)
        self.results = folder / "out"
        self.printed = folder / "printed.txt"
        self.python = sys.executable
        self.config_file = "config/test.yaml"
        self.cores = "2"
        self.runs = []

    def command(self, *arguments: str, config: tuple[str, ...] = ()) -> list[str]:
        """Snakemake command line on the toy study."""
        settings = (f"samples={self.table}", f"results={self.results}", *config)
        return [
            *(self.python, "-m", "snakemake", *arguments, "--cores", self.cores),
            *("--configfile", self.config_file, "--config", *settings),
        ]

    def environment(self, **more: str) -> dict[str, str]:
        """Environment without this checkout's sources on the path."""
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        return {**kept, "NO_COLOR": "1", **more}

    def run(self, *arguments: str, config: tuple[str, ...] = (), **environment: str):
        """Run Snakemake; returns exit status and everything that it printed."""
        run = subprocess.run(
            self.command(*arguments, config=config),
            cwd=self.folder,
            env=self.environment(**environment),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return run.returncode, run.stdout

    def start(self, *arguments: str) -> subprocess.Popen:
        """Start Snakemake in a process group of its own; what it prints goes to `printed`."""
        with self.printed.open("w") as printed:
            self.runs.append(
                subprocess.Popen(
                    self.command(*arguments),
                    cwd=self.folder,
                    env=self.environment(),
                    stdout=printed,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            )
        return self.runs[-1]

    def hold(self, rule: str, sample: str) -> HeldJob:
        """Have a sample's job of a rule wait before it writes its JSON result."""
        held = HeldJob(self.folder)
        script = self.folder / f"workflow/scripts/{rule}.py"
        wait = HELD.format(sample=sample, pid=str(held.pid_file), gate=str(held.gate))
        before, writes, after = script.read_text().partition("    io.write_json(")
        assert writes
        script.write_text(before + wait + writes + after)
        return held

    def run_study(self, *targets: str):
        """Run the toy study by the program's own command, as `make study` does.

        Returns exit status and everything that it printed.
        """
        options = [word for target in targets for word in ("--target", target)]
        run = subprocess.run(
            [
                *(self.python, "-m", "softsample", "run", self.study, "--cores", self.cores),
                *("--settings", self.config_file, "--results", self.results, *options),
            ],
            cwd=self.folder,
            env=self.environment(PYTHONPATH="src"),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return run.returncode, run.stdout

    @staticmethod
    def kill(process: subprocess.Popen) -> None:
        """SIGKILL Snakemake and its jobs."""
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture
def project(tmp_path):
    made = Project(tmp_path)
    yield made
    for run in made.runs:
        if run.poll() is None:
            made.kill(run)
