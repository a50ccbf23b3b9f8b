"""A user's Python file gives its kernel, or a message that names the file and line."""

import os
import sys

import pytest

from vividc.cli.kernels import load_kernel
from vividc.errors import KernelError, VividcError

ONE = """\
import vividc

@vividc.kernel("void(float32[::1], int32)")
def double(x, n):
    for i in range(n):
        x[i] = x[i] + x[i]
"""
TWO = ONE + ONE.replace("import vividc\n", "").replace("double", "twice")


@pytest.fixture
def write(tmp_path):
    def to_file(text, name="k.py"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return to_file


def message(spec):
    with pytest.raises(VividcError) as caught:
        load_kernel(str(spec))
    assert caught.value.exit_code == 2
    return str(caught.value)


def test_the_only_kernel_needs_no_name(write):
    assert load_kernel(str(write(ONE))).name == "double"


def test_one_of_several_is_named(write):
    assert load_kernel(f"{write(TWO)}:twice").name == "twice"


def test_a_second_name_is_no_second_kernel(write):
    assert load_kernel(str(write(ONE + "\nalias = double\n"))).name == "double"


def test_kernel_is_found_by_its_own_name_too(write):
    text = ONE.replace('int32)")', 'int32)", name="x2")')
    assert load_kernel(f"{write(text)}:x2") is not None


def test_kernels_of_the_file_hide_imported_ones(write):
    write(ONE, "vividc_test_other.py")
    path = write(f"from vividc_test_other import double\n{ONE.replace('double', 'own')}")
    try:
        assert load_kernel(str(path)).name == "own"
        assert load_kernel(f"{path}:double").name == "double"
    finally:
        sys.modules.pop("vividc_test_other", None)


def test_several_kernels_and_none_named(write):
    path = write(TWO)
    text = message(path)
    assert "has several kernels: double, twice" in text
    assert f"hint: choose one: {path}:double" in text


def test_unknown_kernel_lists_the_known(write):
    text = message(f"{write(TWO)}:thrice")
    assert "has no kernel `thrice`" in text
    assert "double, twice" in text


def test_file_without_kernel(write):
    assert "has no kernel" in message(write("x = 1\n"))


def test_missing_file(tmp_path):
    assert message(tmp_path / "none.py").startswith(f"{tmp_path / 'none.py'}: cannot be read")


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("a = 1\nb = (\n", 2, "not Python"),
        ("a = 1\nb = a / 0\n", 2, "ZeroDivisionError: division by zero"),
        ("def f():\n    raise KeyError('k')\n\nf()\n", 2, "KeyError"),
        ("import sys\n\nsys.exit(3)\n", 3, "SystemExit: 3"),
        ("import no_such_module_at_all\n", 1, "ModuleNotFoundError"),
    ],
)
def test_failure_of_the_file_names_its_line(write, text, line, expected):
    path = write(text)
    found = message(path)
    assert found.startswith(f"{path}:{line}: ")
    assert expected in found


def test_a_file_that_starts_vividc_on_itself_is_stopped(write):
    """Without a main guard this was a chain of processes without end."""
    path = write(
        "import subprocess, sys\n"
        "code = 'from vividc.cli import main; main()'\n"
        "command = [sys.executable, '-c', code, 'compile', __file__]\n"
        "raise ValueError(subprocess.run(command, capture_output=True, text=True).stderr)\n"
    )
    assert "starts vividc on itself" in message(path)
    write(ONE)
    assert load_kernel(str(path)).name == "double"


def test_main_guard_is_not_entered(write):
    assert load_kernel(str(write(ONE + "\nif __name__ == '__main__':\n    raise ValueError\n")))


def test_bad_signature_keeps_its_own_message(write):
    path = write(ONE.replace("float32[::1]", "float64[::1]"))
    with pytest.raises(KernelError, match=rf"{path}:\d+: parameter x has type"):
        load_kernel(str(path))


def test_null_bytes(tmp_path):
    path = tmp_path / "k.py"
    path.write_bytes(b"x = 1\0\n")
    assert "not Python" in message(path)


@pytest.mark.parametrize("name", [b"k\xff.py", b"d\xff/k.py", b"k\xff.ll"])
def test_a_path_that_is_not_utf_8_is_refused(name, tmp_path):
    path = tmp_path / os.fsdecode(name)
    path.parent.mkdir(exist_ok=True)
    path.write_text(ONE)
    text = message(f"{path}:double")
    assert "must be UTF-8" in text
    assert "hint: rename it" in text


def test_an_edit_is_seen_at_once(write):
    """A cached .pyc of the same second and size must not be used."""
    assert load_kernel(str(write(ONE))).name == "double"
    assert load_kernel(str(write(ONE.replace("double", "triple")))).name == "triple"


def test_prints_go_to_stderr_and_the_import_path_is_restored(write, capsys):
    before = list(sys.path)
    load_kernel(str(write("print('hello')\n" + ONE)))
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "hello\n")
    assert sys.path == before
