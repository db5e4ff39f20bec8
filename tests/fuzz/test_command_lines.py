"""A sample of command lines with nonsense in them; the campaign is `tests.fuzz.command_lines`."""

from tests.fuzz import campaign, command_lines


def test_sound_command_lines_succeed() -> None:
    command_lines.prepare()
    for program, words in (
        ("codegen", ["build", "sound.py"]),
        ("codegen", ["elements", "gear"]),
        ("runtime", ["simulate", "sound.py", "--scene", "swing", "--t-end", "0.1"]),
    ):
        assert command_lines.fault(program, words) == ""


def test_command_lines_are_answered_in_sentences() -> None:
    campaigned = campaign.run("command_lines", 5, range(120))
    assert campaigned.findings == [], campaigned.report()
