"""The methods on an 8-bit microcontroller: correctness and cost."""

import numpy as np
import pytest

from narx.experiments.embedded import __main__ as embedded


def test_what_is_missing_is_said(monkeypatch, capsys):
    monkeypatch.setattr(embedded.shutil, "which", lambda name: None)
    embedded.main()
    assert capsys.readouterr().out.startswith("embedded: skipped, not installed: avr-gcc, avr-size")


@pytest.mark.slow
@pytest.mark.skipif(bool(embedded.missing_programs()), reason="no avr-gcc or simavr")
def test_the_processor_gives_pythons_angles():
    costs = embedded.costs()
    assert len(costs) == 5
    for name, cost in costs.items():
        assert cost.difference_rad < 1e-4, name
        assert 0.0 < cost.mean_us <= cost.worst_us < 30_000.0
        assert cost.flash_bytes < 32_768
        assert cost.ram_bytes < 2048
    # three coupled axes cost no more than three of the paper's filters
    assert costs["NARX, three axes"].mean_us < 3 * costs["complementary filter"].mean_us * 1.5
    assert embedded.table(costs).count("\n") == 6


@pytest.mark.skipif(bool(embedded.missing_programs()), reason="no avr-gcc or simavr")
def test_cycles_are_those_of_the_processor():
    loop = (
        "#include <util/delay_basic.h>\nvoid bench_start(void) {}\n"
        "void bench_step(const float inputs[3], float angles[3])\n"
        "{ _delay_loop_2(1000); angles[0] = inputs[0]; }\n"
    )
    inputs = np.array([[0.5, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    time_us, angle_rad, _, _ = embedded.measure({"loop.c": loop}, inputs)
    np.testing.assert_array_equal(angle_rad, inputs[:, 0])
    # four cycles a turn at 8 MHz, and the call
    np.testing.assert_allclose(time_us, 500.0, atol=10.0)
