import os

from softsample.dependencies import dependencies, state_of_kernels


def write(folder, files):
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_a_script_rests_on_what_it_imports_directly_or_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(
        tmp_path,
        {
            "script.py": "import os\nfrom softsample.a import f\nfrom softsample import b\n",
            "src/softsample/__init__.py": "",
            "src/softsample/a.py": "def f():\n    import softsample.effects\n",
            "src/softsample/b.py": "",
            "src/softsample/unused.py": "import softsample.b\n",
            "src/softsample/effects/__init__.py": "found = iter_modules(__path__)\n",
            "src/softsample/effects/one.py": "",
        },
    )
    found = dependencies(tmp_path / "script.py", tmp_path / "src")
    names = ["__init__", "a", "b", "effects/__init__", "effects/one"]
    assert found == [os.path.join("src", "softsample", f"{name}.py") for name in names]


def test_the_state_of_kernels_is_of_compiled_sources_and_laws_alone(tmp_path):
    write(
        tmp_path / "softsample",
        {"k.py": "from numba import njit\n", "constitutive/law.py": "", "other.py": "# numba\n"},
    )
    before = state_of_kernels(tmp_path)
    (tmp_path / "softsample/other.py").write_text("x = 1\n")
    assert state_of_kernels(tmp_path) == before
    for name in ("k.py", "constitutive/law.py"):
        (tmp_path / "softsample" / name).write_text("from numba import njit, prange\n")
        after = state_of_kernels(tmp_path)
        assert after != before
        before = after
