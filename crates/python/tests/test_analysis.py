"""What the inputs reach."""

import pickle

import pytest

from bracketry import BracketryError, System, affinize, analyze


def test_the_unicycle_reaches_everything_by_one_bracket(models) -> None:
    analysis = analyze(System.from_file(models / "unicycle.toml"))
    assert (analysis.states, analysis.inputs, analysis.affine) == (3, 2, True)
    (mode,) = analysis.modes
    assert mode.growth == [2, 3]
    assert mode.accessible_dimension == 3
    assert mode.basis == ["g1", "g2", "[g1,g2]"]
    assert mode.autonomous == []
    assert analysis.switched is None
    assert analysis.markdown.startswith("#")
    assert analysis.latex.startswith("\\documentclass")


def test_numbers_are_those_of_the_command_line(models, command, timeless) -> None:
    for name in ("plate_published", "cart_pole", "emps"):
        path = models / f"{name}.toml"
        assert timeless(analyze(System.from_file(path)).json) == timeless(command("analyze", path))


def test_a_published_rank(models) -> None:
    """The ten states of the plate: nine dimensions in one friction mode, all of them together."""
    analysis = analyze(System.from_file(models / "plate_published.toml"))
    assert [m.accessible_dimension for m in analysis.modes] == [9] * 4
    assert analysis.modes[0].autonomous == ["x + X", "vx + Xd"]
    assert analysis.switched is not None
    assert analysis.switched.accessible_dimension == 10
    assert analysis.at_point is not None
    # Where the friction sticks, the smoothed model proves nothing of the model.
    assert analysis.at_point.stlc.verdict == "inconclusive"
    assert analysis.at_point.smoothed_stlc is not None
    assert analysis.at_point.smoothed_stlc.verdict == "yes"
    assert analysis.affinization.integrators == {"X": 2, "theta": 2}
    assert analysis.affinization.model is not None
    assert len(analysis.affinization.model.states) == 10


def test_a_point_of_ones_own_and_brackets(models) -> None:
    cart_pole = System.from_file(models / "cart_pole.toml")
    up = analyze(cart_pole, at={"th": 0})
    text = analyze(cart_pole, at="th=0")
    assert up.at_point == text.at_point
    assert up.at_point is not None and up.at_point.equilibrium is True
    tilted = analyze(cart_pole, at={"th": "pi/3"})
    assert tilted.at_point is not None and tilted.at_point.equilibrium is False
    bracket = analyze(System.from_file(models / "unicycle.toml"), brackets=["[g1,g2]"]).brackets
    assert bracket["[g1,g2]"] == ["sin(th)", "-cos(th)", "0"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"at": {"q": 1}}, "`q` is neither a state nor an input"),
        ({"at": "th"}, "has no value"),
        ({"brackets": ["[g1,g9]"]}, "g9"),
    ],
)
def test_what_cannot_be_asked(models, arguments, message) -> None:
    with pytest.raises(BracketryError, match=message):
        analyze(System.from_file(models / "unicycle.toml"), **arguments)


def test_outputs_that_are_not_there_determine_nothing() -> None:
    with pytest.raises(BracketryError, match="no outputs that could determine `x`"):
        analyze(System(states=["x"], inputs=["u"], dynamics=["u"]), determines=["x"])


def test_an_affine_form(models) -> None:
    found = affinize(System.from_file(models / "heading.toml"))
    assert found.method == "input_augmentation"
    assert found.model is not None
    assert found.model.states == ["x", "y", "u"]


def test_figures(models, tmp_path) -> None:
    analysis = analyze(System.from_file(models / "unicycle.toml"))
    assert analysis.figure_names == ["growth", "reach"]
    figure = analysis.figure("growth")
    assert figure.svg.startswith("<svg") and figure._repr_svg_() == figure.svg
    assert figure.png.startswith(b"\x89PNG")
    assert figure.save(tmp_path / "growth.png").read_bytes() == figure.png
    with pytest.raises(BracketryError, match="svg or .png"):
        figure.save(tmp_path / "growth.pdf")
    with pytest.raises(BracketryError, match="no figure `histogram`; there are growth, reach"):
        analysis.figure("histogram")


def test_a_result_travels_without_its_figures(models) -> None:
    analysis = analyze(System.from_file(models / "unicycle.toml"))
    copy = pickle.loads(pickle.dumps(analysis))
    assert copy.json == analysis.json
    assert copy.modes == analysis.modes
    with pytest.raises(BracketryError, match="do not travel"):
        copy.figure()


def test_the_report_is_the_text(models) -> None:
    analysis = analyze(System.from_file(models / "unicycle.toml"))
    assert str(analysis) == analysis.text
    assert analysis._repr_markdown_() == analysis.markdown
    assert "<pre>" in analysis._repr_html_()


def test_a_point_without_names_is_the_origin() -> None:
    system = System(states=["x", "v"], inputs=["u"], dynamics={"x": "v", "v": "u - sin(x)"})
    assert analyze(system).at_point is None
    origin = analyze(system, at={}).at_point
    assert origin == analyze(system, at={"x": 0, "u": 0}).at_point
    assert origin is not None and origin.linear_controllability_rank == 2
