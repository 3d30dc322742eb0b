from narx.experiments.method_labels import (
    drawn_rows,
    line_styles,
    method_block,
    method_colour,
    method_label,
    method_order,
)

NAMES = (
    "narx", "narx_smoothed", "gyro_integration", "pseudo_integrator", "complementary_filter",
    "giof", "two_point", "vqf", "madgwick", "mahony",
)  # fmt: skip


def test_every_method_has_its_own_label_and_colour():
    assert len({method_label(name) for name in NAMES}) == len(NAMES)
    assert len({method_colour(name) for name in NAMES}) == len(NAMES)
    assert all(method_label(name) != name for name in NAMES)


def test_order():
    assert method_order(["zeta", "vqf", "narx", "alpha", "complementary_filter", "narx"]) == [
        "complementary_filter", "vqf", "alpha", "zeta", "narx",
    ]  # fmt: skip
    rows = ["vqf_same", "vqf", "vqf_chosen", "vqf_heading_zero", "vqf_same_chosen", "narx"]
    assert method_order(rows) == [
        "vqf", "vqf_chosen", "vqf_heading_zero", "narx", "vqf_same", "vqf_same_chosen",
    ]  # fmt: skip


def test_a_row_label_names_its_form():
    assert method_label("vqf_heading_zero_chosen") == "VQF, heading 0, chosen"
    assert method_label("vqf_same") == "VQF, heading leak"
    assert method_label("leaky_integrator_same") == "Leaky integrator, tracker"
    assert method_label("leaky_integrator_start_up_chosen") == "Leaky integrator, start-up, chosen"
    assert method_label("pseudo_integrator_same") == "PI, start-up"
    assert method_block("leaky_integrator_start_up") == method_block("narx")
    assert method_label("giof", {"giof"}) == "GIOF, not causal"
    assert method_block("leaky_integrator_same_chosen") == method_block("narx")
    assert method_block("leaky_integrator_chosen") == method_block("narx_axis_by_axis")
    assert method_block("narx") != method_block("vqf")
    assert method_colour("vqf_same_chosen") == method_colour("vqf")


def test_a_figure_shows_a_few_rows():
    few = ["zero", "narx", "mahony"]
    assert drawn_rows(few) == method_order(few)
    many = [*few, "vqf", "vqf_same", "leaky_integrator", "leaky_integrator_same", "constant"]
    assert drawn_rows(many) == ["narx", "leaky_integrator_same", "vqf_same"]
    assert drawn_rows([*many, "vqf_same_chosen"])[-1] == "vqf_same_chosen"
    assert drawn_rows("abcdefgh") == list("abcdef")


def test_an_unknown_method_keeps_its_colour():
    assert method_label("my_filter") == "my_filter"
    assert method_colour("my_filter") == method_colour("my_filter")
    assert method_colour("my_filter").startswith("#")


def test_forms_of_a_method_have_its_colour_and_lines_of_their_own():
    rows = ["narx", "vqf", "vqf_chosen", "vqf_same", "vqf_chosen"]
    styles = line_styles(rows)
    assert list(styles) == ["narx", "vqf", "vqf_chosen", "vqf_same"]
    assert styles["narx"] == styles["vqf"] == "-"
    assert len({styles["vqf"], styles["vqf_chosen"], styles["vqf_same"]}) == 3
    # that of the reference
    assert not {"--", "dashed"} & set(styles.values())
