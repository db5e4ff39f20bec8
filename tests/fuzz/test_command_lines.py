"""Command lines with nonsense in them are answered in sentences."""

from random import Random

from tests.fuzz import command_lines


def test_sound_command_lines_succeed() -> None:
    command_lines.prepare()
    for words in (
        ["build", "sound.py"],
        ["elements", "gear"],
        ["simulate", "sound.py", "--scene", "swing", "--t-end", "0.1"],
    ):
        assert command_lines.fault(words) == ""


def test_command_lines_are_answered_in_sentences() -> None:
    judged = (command_lines.judge(Random(f"command_lines 5 {number}")) for number in range(120))
    assert list(filter(None, judged)) == []
