"""A sample of declarations with arguments of the wrong kind; the campaign is `declarations`."""

from tests.fuzz import campaign

SAMPLE = 250


def test_declarations_of_the_wrong_kind_are_refused_by_name() -> None:
    found = campaign.run("declarations", 7, range(SAMPLE))
    assert found.findings == [], found.report()
