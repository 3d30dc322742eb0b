from narx.experiments.method_labels import method_colour, method_label, method_order

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
        "complementary_filter", "narx", "vqf", "alpha", "zeta",
    ]  # fmt: skip


def test_an_unknown_method_keeps_its_colour():
    assert method_label("my_filter") == "my_filter"
    assert method_colour("my_filter") == method_colour("my_filter")
    assert method_colour("my_filter").startswith("#")
