"""Scenes: extended, made on the fly, in one fidelity or another, with the outputs asked for."""

from pathlib import Path

import pytest

from codegen import Model, ModelError, build
from codegen.declare.scene import Scene
from codegen.derive.equations import derive
from codegen.errors import InputError
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes


def sledge() -> Model:
    """A sledge on a rough guide, pulled by a spring, before a wall."""
    model = Model("sledge", gravity=(0, -9.81))
    mu = model.parameter("mu", 0.2)
    body = model.body("body", mass=2.0, inertia=0.1)
    load = model.body("load", mass=1.0, inertia=0.1)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    model.revolute("pin", body.at(0, 0), load.at(0, 0))
    model.weld("tray", body.at(0, 0), load.at(0, 0))
    model.alternatives("fixing", {"pinned": ["pin"], "welded": ["tray"]})
    model.spring("spring", model.ground.at(-1, 0), body, 50.0, free_length=1.0)
    model.friction("rub", guide, mu, creep=1e-3, static=0.3, fidelity="sticking")
    model.contact(
        "wall", gap=1 - body.x, stiffness=1e4, damping=5.0, restitution=0.5, fidelity="penalty"
    )
    model.driver("crane", load.phi, 0)
    model.track("nose", body.at(0.5, 0))
    model.track("hook", load)
    model.scene("slide", ["spring", "rub"], start={body.x: 0.5, body.vx: 0.0})
    return model


def kinds(model: Model, scene: Scene) -> dict[str, str]:
    return {e.name: e.kind for e in derive(model, valid_scenes(model, scene)[0]).effects}


def test_extension_has_all_but_what_it_says() -> None:
    model = sledge()
    base = model.scenes["slide"]
    more = model.scene("more", ["gravity"], extends="slide", parameters={"mu": 0.5})
    assert more.effects == ("gravity", "spring", "rub")
    assert more.start == base.start
    fewer = model.scene("fewer", extends=more, without=["spring"], start={"body.x": 0.2})
    assert fewer.effects == ("gravity", "rub")
    assert dict(fewer.start) == {"body.x": 0.2, "body.vx": 0.0}
    assert dict(fewer.parameters) == {"mu": 0.5}
    again = model.scene("again", ["spring"], extends=fewer, analysis="equilibrium")
    assert again.effects == more.effects
    assert again.analysis == "equilibrium"


def test_an_empty_mapping_takes_over_none() -> None:
    model = sledge()
    x = model.bodies["body"].x
    model.scene("base", ["spring"], start={x: 0.2}, guess={"load.phi": 1}, until={"far": x > 1})
    none = {word: {} for word in ("start", "guess", "until")}
    bare = model.scene("bare", extends="base", **none)
    assert (bare.start, bare.guess, bare.until) == ((), (), ())
    kept = model.scene("kept", extends="base", parameters={"mu": 0.5})
    assert [one.name for one in kept.until] == ["far"]
    assert model.scene("plain", extends="kept", parameters={}).parameters == ()


def test_start_values_go_with_the_body_that_is_left_out() -> None:
    model = sledge()
    model.scene("turned", ["spring"], start={"load.phi": 0.3, "body.x": 0.1})
    alone = model.scene("turned").without("load")
    assert alone.start == (("body.x", 0.1),)
    assert valid_scenes(model, alone)[0].bodies == ("body",)


def test_outputs_go_with_the_element_that_is_left_out() -> None:
    model = sledge()
    asked = ["energy", "force(spring)", "power(rub)", "reaction(guide)"]
    model.scene("seen", ["spring", "rub"], outputs=asked)
    free = model.scene("seen").without("rub")
    assert free.name == "seen_without_rub"
    assert free.outputs == ("energy", "force(spring)", "reaction(guide)")
    assert valid_scenes(model, free)
    with pytest.raises(ModelError, match=r"'power\(rub\)' needs effect 'rub'"):
        valid_scenes(model, model.scene("seen").without("rub").with_(outputs=asked))


def test_scenes_made_on_the_fly_say_what_they_are() -> None:
    model = sledge()
    made = model.scene("slide").without("spring").with_("wall", fidelity="rigid")
    assert made.name == "slide_without_spring_with_wall_rigid"
    assert kinds(model, made) == {"rub": "friction", "wall": "rigid contact"}
    assert model.scene("slide").with_("wall", fidelity="rigid").without("spring").name == made.name
    assert list(model.scenes) == ["slide"]
    back = made.without("wall").with_("spring")
    assert (back.name, back.effects) == ("slide", ("spring", "rub"))


def test_names_are_fit_for_files_and_tell_changes_apart() -> None:
    model = sledge()
    slide = model.scene("slide")
    one, two = (slide.with_(parameters={"mu": mu}).name for mu in (0.1, 0.3))
    assert one != two != slide.name
    assert one == slide.with_(parameters={"mu": 0.1}).name
    wide = model.scene("s" * 90, ["spring", "rub"]).without("spring", "rub")
    assert len(wide.name) <= 100
    assert wide.name != model.scene("s" * 90).without("spring").with_("gravity").name


def test_scene_reads_aloud() -> None:
    text = str(sledge().scene("slide").without("load", "spring").with_(outputs=["energy"]))
    assert text.startswith("slide_without_load_spring_")
    assert text.splitlines()[0].endswith(": dynamics of sledge")
    for told in ("bodies      body", "acting      rub", "left out    spring, load",
                 "start       body.x = 0.5, body.vx = 0", "reported    energy"):  # fmt: skip
        assert told in text


@pytest.mark.parametrize(
    ("fidelity", "sticks", "static"),
    [("sticking", True, True), ("regularised", False, False), (None, True, True)],
)
def test_friction_is_taken_as_the_scene_says(
    fidelity: str | None, sticks: bool, static: bool
) -> None:
    model = sledge()
    scene = model.scene("slide")
    scene = scene.with_(fidelity={"rub": fidelity}) if fidelity else scene
    equations = derive(model, valid_scenes(model, scene)[0])
    (friction,) = (e.terms.friction for e in equations.effects if e.terms.friction)
    assert friction.sticks is sticks
    assert (friction.limit is not None) is static
    assert bool(equations.switches) is sticks


def test_effect_of_no_fidelity_is_not_there() -> None:
    model = sledge()
    none = model.scene("slide").with_(fidelity={"rub": "none"})
    (plain,) = valid_scenes(model, model.scene("slide").without("rub"))
    (chosen,) = valid_scenes(model, none)
    assert chosen.effects == plain.effects == ("spring",)
    assert derive(model, chosen).left_out == derive(model, plain).left_out


def test_declared_with_one_fidelity_is_the_same_effect(root: Path) -> None:
    rich = sledge()
    poor = Model("sledge")
    body = poor.body("body", mass=2.0, inertia=0.1)
    guide = poor.translational("guide", poor.ground, body, axis=(1, 0))
    poor.friction("rub", guide, 0.2, creep=1e-3)
    poor.scene("slide", ["rub"], start={body.x: 0.5, body.vx: 0.0})
    scene = rich.scene("slide").without("load", "spring").with_(fidelity={"rub": "regularised"})
    (one,) = derive(rich, valid_scenes(rich, scene)[0]).effects
    (other,) = derive(poor, poor.scenes["slide"]).effects
    substituted = str(one.terms.friction).replace("mu", "0.2")
    assert substituted == str(other.terms.friction)


def test_alternatives_take_one_choice_and_leave_the_others() -> None:
    model = sledge()
    joints = {
        choice: {c.name for c in derive(model, valid_scenes(model, scene)[0]).constraints}
        for choice, scene in {
            "default": model.scene("slide"),
            "welded": model.scene("slide").with_(fidelity={"fixing": "welded"}),
        }.items()
    }
    assert joints == {"default": {"guide", "pin"}, "welded": {"guide", "tray"}}


def test_couplers_are_chosen_as_any_fidelity_is() -> None:
    model = Model("rods", gravity=(0, -9.81))
    end = model.body("end", 1.0, 1.0)
    model.coupler("rod", model.ground.at(0, 0), end, 1.0, mass=1.0, inertia=0.1)
    one = model.scene("one", ["gravity"], couplers={"rod": "link"})
    other = model.scene("other", ["gravity"], fidelity={"rod": "link"})
    assert (
        (one.bodies, one.fidelity)
        == (other.bodies, other.fidelity)
        == (("end",), (("rod", "link"),))
    )


@pytest.mark.parametrize(
    ("variation", "told"),
    [
        ('without("sprng")', "no 'sprng' to leave out; did you mean 'spr"),
        ('with_("wal")', "no 'wal' to take in; did you mean 'wall'"),
        ('without("wall")', "'wall' does not act in it"),
        ('with_("wall", fidelity="rgid")',
         "'wall' cannot be taken as 'rgid'; did you mean 'rigid'"),
        ('with_("spring", fidelity="rigid")', "spring 'spring' has one fidelity only"),
        ('with_(fidelity={"rubb": "sticking"})',
         "nothing called 'rubb' has fidelities; did you mean 'rub'"),
        ('with_("rub", fidelity=("sticking", "regularised"))', "takes one at a time"),
        ('with_(fidelity={"wall": "rigid"})', "'wall' has a fidelity but does not act"),
        ('with_(output=["energy"])', "no output=; did you mean 'outputs'"),
        ('with_(outputs=["enrgy"])', "no output 'enrgy'; did you mean 'energy'"),
        ('with_(outputs=["power(wal)"])',
         "no output 'power(wal)', as there is no 'wal'; did you mean 'wall'"),
        ('with_(outputs=["power(wall)"])',
         "'power(wall)' needs effect 'wall', which the scene leaves out; take 'wall' in"),
        ('without("load").with_(outputs=["reaction(pin)"])',
         "'reaction(pin)' needs joint 'pin', which the scene leaves out"),
        ('without("spring", "rub").with_(analysis="kinematics", outputs=["energy"])',
         "'energy' needs masses and forces"),
        ('with_(analysis="equilibrium", outputs=["powers"])', "'powers' needs a motion"),
        ('with_(outputs=["angle(spring)"])',
         "as spring 'spring' has no angle; ask for 'force(spring)' or 'length(spring)'"),
        ('with_(outputs=["reaction(spring)"])',
         "spring 'spring' is no joint; ask for 'force(spring)'"),
        ('with_(outputs=["force(guide)"])', "'guide' is no effect; ask for 'reaction(guide)'"),
        ('with_(outputs=["lenght(spring)"])',
         "no output 'lenght(spring)'; did you mean 'length(spring)'"),
        ('with_(outputs=["force(wall)"])',
         "'force(wall)' needs effect 'wall', which the scene leaves out; take 'wall' in"),
        ('with_(analysis="kinematics", outputs=["force(spring)"])',
         "'force(spring)' needs masses and forces"),
        ('with_(outputs=["power(guide)"])', "'guide' does no work"),
        ('with_(outputs=7)', "outputs=7 is no list"),
        ('with_(outputs=["point(nse)"])', "no tracked point 'nse'; did you mean 'nose'"),
        ('with_(outputs=["point(body)"])', "no tracked point 'body'"),
        ('with_(outputs=["power(nose)"])', "as there is no 'nose'"),
        ('with_(outputs=["work(sprng)"])', "did you mean 'spring'"),
        ('with_(outputs=["work(wall)"])',
         "'work(wall)' needs effect 'wall', which the scene leaves out; take 'wall' in"),
        ('with_(outputs=["work(guide)"])', "'guide' does no work"),
        ('without("load").with_(outputs=["point(hook)"])',
         "'point(hook)' needs body 'load', which the scene leaves out; take 'load' in"),
        ('with_(analysis="equilibrium", outputs=["work(rub)"])', "'work(rub)' needs a motion"),
        ('without("body", "load")', "no body takes part"),
        ('without("body")', "effect 'rub' needs body 'body'"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_variation_is_said(variation: str, told: str) -> None:
    model = sledge()
    with pytest.raises(InputError) as caught:
        valid_scenes(model, eval(f"slide.{variation}", {"slide": model.scene("slide")}))
    assert told in str(caught.value)
    assert valid_scenes(model, None)  # what is declared is as sound as before


@pytest.mark.parametrize(
    ("declaration", "told"),
    [
        ('m.scene("s", extends="slid")', "extends 'slid', which is no scene; did you mean"),
        ('m.scene("s", ["rub"], fidelity="sticking")', "fidelity='sticking' is no mapping"),
        ('m.scene("s", couplers={"rod": "link"})', "there is no coupler 'rod'"),
        ('m.alternatives("one", {"only": ["pin"]})', "1 choice is no choice"),
        ('m.alternatives("a", {"x": ["pni"], "y": []})', "there is no 'pni'; did you mean"),
        ('m.alternatives("a", {"x": [], "y": []}, default="z")', "no choice 'z'"),
        ('m.contact("c", gap=m.bodies["body"].x, restitution=0.5, fidelity="penalty")',
         "the fidelity 'penalty' needs stiffness="),
        ('m.friction("f", m.joints["guide"], 0.1, fidelity="regularised")',
         "the fidelity 'regularised' needs creep="),
        ('m.friction("f", m.joints["guide"], 0.1, creep=0.001, static=0.2)',
         "has both static= and creep="),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_declaration_is_said(declaration: str, told: str) -> None:
    model = sledge()
    eval(declaration, {"m": model})
    with pytest.raises(ModelError) as caught:
        valid_scenes(model, None)
    assert told in str(caught.value)


def test_all_problems_come_at_once() -> None:
    model = sledge()
    scene = model.scene("slide").without("sprng").with_("wal", outputs=["enrgy"])
    with pytest.raises(InputError) as caught:
        valid_scenes(model, scene)
    assert len(caught.value.problems) == 3


def test_both_choices_of_a_group_cannot_act() -> None:
    model = Model("two")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.torque("one", on=body, value=1.0)
    model.torque("other", on=body, value=2.0)
    model.alternatives("drive", {"weak": ["one"], "strong": ["other"]})
    model.scene("both", ["one", "other"])
    with pytest.raises(ModelError, match="'other' acts only in another choice of 'drive'"):
        valid_scenes(model, None)
    lone = Model("lone")
    body = lone.body("body", mass=1.0, inertia=1.0)
    lone.torque("one", on=body, value=1.0)
    lone.torque("other", on=body, value=2.0)
    lone.alternatives("drive", {"weak": ["one"], "strong": ["other"]})
    assert lone.scene("named", ["other"]).effects == ("other",)
    assert lone.scene("asked", fidelity={"drive": "strong"}).effects == ("other",)


def test_build_takes_scenes_made_on_the_fly(tmp_path: Path) -> None:
    model = sledge()
    scene = model.scene("slide").without("rub")
    report = build(model, ["slide", scene], tmp_path, compile=False)
    names = [path.name for path in report.paths]
    assert names == ["sledge__slide.py", "sledge__slide_without_rub.py"]
    text = report.paths[1].read_text()
    assert "build(sledge, scene=sledge.scene('slide').without('rub'))" in text
    assert not build(model, scene, tmp_path, compile=False).scenes[0].changed


def test_scene_of_a_file_serves_the_file_again(root: Path, tmp_path: Path) -> None:
    path = root / "models" / "slider_crank.py"
    scene = read_model(path).model.scene("compressor").without("gas")
    (made,) = build(path, scene, tmp_path, compile=False, settings={"J1": 900.0}).scenes
    assert made.scene == "compressor_without_gas"
    assert '("J1", 900.0' in made.path.read_text()
