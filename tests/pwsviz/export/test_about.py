"""What a file or a caption says of a system: the law of every region by name, surfaces, jumps and transitions."""

import re

import pytest

import core
from pwsviz.export.about import about, release
from pwsviz.export.caption import caption
from pwsviz.scene.scene import Scene
from pwsviz.text.math_names import numbered, variable_name
from tests.pwsviz.own_systems import OWN_SYSTEMS, RELAY, WALL

SYSTEMS = {**core.CATALOGUE, **OWN_SYSTEMS}

BOTH_KINDS = core.PiecewiseSystem(
    name="wall and switch", variables=("x", "v"), surfaces=("x", "x - 1"),
    regions={"+-": core.Region(("v", "-1")), "++": core.Region(("v", "-2"))}, jumps={0: ("x", "-v")}, x0=(2.0, 0.0),
)  # fmt: skip

every_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=list(SYSTEMS))


def scene_of(system):
    scene = Scene()
    scene.use(system)
    return scene


def equations(system):
    return about(scene_of(system))["equations"].split("; ")


@every_system
def test_a_caption_names_all_regions_with_the_rate_of_every_variable(system):
    parts = equations(system)
    for key, law in system.regions.items():
        name = {"-": "g < 0", "+": "g > 0"}[key] if system.two_sided else f"region {key}"
        name = name.replace("-", "−") if system.surfaces else name
        where = "" if has_one_law(system) else f"{name}: "
        names = list(map(variable_name, system.variables))
        (told,) = [part for part in parts if part.startswith(f"{where}{names[0]}′ = ")]
        assert all(f"{variable}′ = " in told for variable in names)
        assert told.count("ψ") == len(law.psi)
    told = caption(scene_of(system), "Phase portrait")
    assert told.startswith(f"Phase portrait of the system “{system.name}”. ")
    assert len(told) < 1000, "no more than the figure"


def has_one_law(system):
    return system.two_sided and len(set(system.regions.values())) == 1


def test_equal_laws_are_told_once_and_very_long_ones_in_the_files_alone():
    assert equations(core.CATALOGUE["henon_heiles"])[0].startswith("x′ = u, ")
    told = caption(scene_of(core.CATALOGUE["three_bodies"]), "Order")
    surface = (
        f"they are those of {release()}. S = {{g = 0}} with g = (x₁ − x₂)² + (y₁ − y₂)² − D². Parameters: D = 0.6, "
    )
    assert "”. Three equal masses attract each other; " in told, "what it is, where its equations are not"
    assert f" Equations omitted for their length; {surface}" in told
    assert ". For g > 0: x′ = 2y" in caption(scene_of(core.CATALOGUE["elliptic_curve"]), "Order")
    assert "”. Equations: x′ = u, " in caption(scene_of(core.CATALOGUE["henon_heiles"]), "Order")
    assert "”. In region −−: x′ = " in caption(scene_of(core.CATALOGUE["chua"]), "Order")


@every_system
def test_no_two_quantities_of_a_region_have_the_same_name(system):
    for told in equations(system):
        names = re.findall(r"(ψ\S*) = ", told)
        assert len(set(names)) == len(names)
        assert not any(name.endswith("₁") for name in names[:1] if len(names) == 1)


def test_a_caption_says_jumps_where_nothing_but_jumps_occurs():
    steps, scheme = "by a shortened step that ends on the surface", "by Mannshardt’s transition scheme"
    cases = (("three_bodies", "jumps", steps), ("two_walls", "jumps", steps), ("thermostat", "crossings", scheme))
    for name, met, how in cases:
        scene = scene_of(core.CATALOGUE[name])
        assert f"; {met} located {how}" in about(scene)["integration"]
    assert "; crossings and jumps located by" in about(scene_of(BOTH_KINDS))["integration"]


def test_formulas_of_the_catalogue_have_no_zero_that_is_added_and_no_doubled_brackets():
    for system in core.CATALOGUE.values():
        told = "; ".join(equations(system))
        assert not re.search(r"(?<![\w.])0 [−+]|(?<![\w/])\((\w|\w·\w)\)|sqrt\(\(\(|\^\d*\.|_", told), system.name


@every_system
def test_a_caption_has_every_surface_every_jump_and_every_transition(system):
    parts = equations(system)
    names = ["g"] if system.two_sided else [numbered("g", k + 1) for k in range(len(system.surfaces))]
    laws = 1 if has_one_law(system) else len(system.regions)
    assert [part.partition(" = ")[0] for part in parts[laws:]][: len(names)] == names
    resets = [name for k, name in enumerate(names) if k in system.jumps]
    assert [part.split()[3] for part in parts if part.startswith("reset map at ")] == resets
    for way in system.transitions:
        (told,) = [part for part in parts if part.startswith(f"{way.mode} to {way.to} where ")]
        assert ("reset map" in told) == bool(way.jump)
    assert len(parts) == laws + len(names) + len(resets) + len(system.transitions)


def test_expressions_are_printed_and_names_are_left_as_they_are():
    assert equations(RELAY)[2:] == [
        "pre-heat to off where top − u = 0, reset map (u, w) ↦ (u, w/2)", "off to pre-heat where u − 1/2 = 0",
    ]  # fmt: skip
    assert equations(WALL) == [
        "region +: x′ = v, v′ = −1, ψ = v²/2 + x",
        "g₁ = x",
        "reset map at g₁ = 0: (x, v) ↦ (x, −v·0.9)",
    ]
    bridge = equations(core.CATALOGUE["diode_bridge"])
    assert bridge[1].startswith("region −+: v′ = ω·w, u′ = ")
    assert bridge[3:] == ["g₁ = v − u", "g₂ = v + u"]


def test_a_region_called_as_a_parameter_keeps_its_name():
    regions = {"power": core.Region(("power", "0")), "reset": core.Region(("-1", "0"))}
    ways = (core.Transition("power", "1 - x", "reset"), core.Transition("reset", "x + 1", "power"))
    parameters = (core.Parameter("power", 2.0, latex="P"), core.Parameter("reset", 1.0, latex="R"))
    system = core.PiecewiseSystem(
        name="n", variables=("x", "y"), regions=regions, transitions=ways, parameters=parameters
    )
    parts = equations(system)
    assert parts[0].startswith("region power: x′ = P, y′ = 0")
    assert parts[2] == "power to reset where 1 − x = 0"


def test_the_start_of_a_study_is_named_and_sliding_only_where_a_run_slides():
    scene = Scene(starts=((-1.0, -1.0), (-1.0, -0.5)), selected=1)
    assert about(scene)["starts"] == "initial states 1 and 2: (x, y) = (−1, −1); (−1, −0.5)"
    assert about(scene, every_start=False)["starts"] == "initial state (x, y) = (−1, −0.5), start 2 of 2"
    assert about(scene, every_start=False, free="x")["starts"] == "initial states (x, y) with y = −0.5", "x is varied"
    assert "Initial states (x, y) with y = −0.5." in caption(scene, "Outcomes", every_start=False, free="x")
    assert "sliding" in caption(scene, "Phase portrait")
    assert "sliding" not in caption(scene, "Phase portrait", slid=False)


def test_a_variable_has_one_name_in_all_of_a_caption():
    told = caption(scene_of(core.CATALOGUE["vibrating_table"]), "State")
    assert "φ′ = ω" in told
    assert "Initial state (φ, y, v) = " in told
    assert "phi" not in told
    assert about(scene_of(core.CATALOGUE["vibrating_table"]))["variables"].startswith("phi (in equations φ), y, v;")
    assert "μₛ" in caption(scene_of(core.CATALOGUE["stick_slip"]), "State"), "no microseconds"


def test_a_caption_tells_integrators_as_they_are_declared_and_whose_the_tolerance_is():
    told = caption(Scene(methods=["taylor"]), "State")
    chosen = "taylor (Taylor series, order and step size chosen from a tolerance"
    longest = "with tolerance 10⁻¹², in steps of at most τ = 0.01 for t ≤ 20."
    assert f"by {chosen}, projected onto the level set of ψ) {longest}" in told
    assert caption(scene_of(core.CATALOGUE["chua"]), "State", how="runs of taylor").endswith(f"{chosen})."), "no ψ"
    told = caption(Scene(methods=["dmm4", "taylor"]), "State")
    composed = "dmm4 (composition of five steps of dmm2 (Suzuki), order 4)"
    assert f"by {composed} with step size τ = 0.01 and by taylor (Taylor series, " in told
    assert told.endswith(". dmm2: Discrete Multiplier Method, order 2."), "that of dmm4 names it"
    assert "Runs of dmm2 (Discrete Multiplier Method, order 2). Reference." in caption(
        Scene(), "Order", how="runs of dmm2; reference"
    )


def test_a_caption_has_numbers_as_fields_show_them_and_files_have_all_digits():
    scene = scene_of(core.CATALOGUE["chua"])
    told = caption(scene, "State")
    assert "β = 100/7, a = −8/7, b" in told
    assert "≈" not in told
    assert "β = 14.285714285714286," in about(scene)["parameters"]
    scene = Scene(starts=((2**0.5, 0.25), (0.5, 0.5)))
    told = caption(scene, "State")
    assert "initial states 1 and 2: (x, y) ≈ (1.4142, 0.25); (0.5, 0.5)." in told.lower()
    assert about(scene)["starts"] == "initial states 1 and 2: (x, y) = (1.4142135623730951, 0.25); (0.5, 0.5)"


def test_a_caption_says_what_s_is_and_leaves_a_typed_name_as_it_is():
    assert ". S = {g = 0} with g = " in caption(Scene(), "Phase portrait")
    system = core.PiecewiseSystem("my “x1” - 1e-3", ("x", "y"), ("1", "0"), ("1", "0"), "x", x0=(1.0, 0.0))
    assert caption(scene_of(system), "Order", how="a study").startswith("Order of the system “my ‘x1’ - 1e-3”. ")


@every_system
def test_the_region_in_which_a_run_begins_is_told_where_signs_of_surfaces_do_not_tell_it(system):
    told = about(scene_of(system))["starts"]
    if system.two_sided or system.laws.sides.shape[1]:
        assert "region" not in told
    else:
        run = core.integrate(system, (0.0, 1e-3), tau=1e-3, method="rk4")
        assert told.endswith(f", in region {run.system.modes[run.mode[0]].name}")
