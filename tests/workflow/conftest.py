import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import toy

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("Snakefile", "profiles", "workflow", "config", "src", "resources/MANIFEST.tsv")


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

    def command(self, *arguments: str, config: tuple[str, ...] = ()) -> list[str]:
        """Snakemake command line on the toy study."""
        settings = (f"samples={self.table}", f"results={self.results}", *config)
        return [
            *(sys.executable, "-m", "snakemake", *arguments, "--cores", "2"),
            *("--configfile", "config/test.yaml", "--config", *settings),
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
        """Start Snakemake in a process group of its own."""
        return subprocess.Popen(
            self.command(*arguments),
            cwd=self.folder,
            env=self.environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    @staticmethod
    def kill(process: subprocess.Popen) -> None:
        """SIGKILL Snakemake and its jobs."""
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture
def project(tmp_path):
    return Project(tmp_path)
