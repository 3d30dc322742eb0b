"""The methods on an 8-bit microcontroller: correctness and cost."""

import sys

import numpy as np
import pytest

from narx.experiments.embedded import __main__ as embedded
from narx.experiments.embedded import cortex, programs


def test_what_is_missing_is_said(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["embedded"])
    monkeypatch.setattr(programs.shutil, "which", lambda name: None)
    embedded.main()
    assert capsys.readouterr().out.startswith("embedded: skipped, not installed: avr-gcc, avr-size")


def test_help_measures_nothing(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["embedded", "--help"])
    monkeypatch.setattr(embedded, "costs", lambda: pytest.fail("measured"))
    with pytest.raises(SystemExit) as stop:
        embedded.main()
    assert stop.value.code == 0
    assert "avr-gcc, avr-libc and simavr" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.skipif(bool(programs.missing(programs.AVR)), reason="no avr-gcc or simavr")
def test_the_processor_gives_pythons_angles():
    costs = embedded.costs()
    assert len(costs) == 7
    for name, cost in costs.items():
        assert cost.difference_rad < 1e-4, name
        assert 0.0 < cost.mean_us <= cost.worst_us < 30_000.0
        assert cost.flash_bytes < 32_768
        assert cost.ram_bytes < 2048
        if not programs.missing(programs.CORTEX):
            assert 20.0 < cost.instructions["Cortex-M4F"] < cost.instructions["Cortex-M0+"] < 1e5
    # 1,480 us by avr-gcc 5; other releases may need some per cent more
    assert costs["NARX, three axes"].mean_us < 1550.0
    assert costs["NARX, sagittal"].mean_us < costs["complementary filter"].mean_us
    assert embedded.table(costs).count("\n") == 8


@pytest.mark.skipif(bool(programs.missing(programs.AVR)), reason="no avr-gcc or simavr")
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


@pytest.mark.skipif(bool(programs.missing(programs.CORTEX)), reason="no arm-none-eabi-gcc or qemu")
@pytest.mark.parametrize("processor", cortex.PROCESSORS)
def test_instructions_are_counted_in_qemu(processor):
    nothing = (
        "void bench_start(void) {}\n"
        "void bench_step(const float inputs[3], float angles[3])\n"
        '{ __asm__ volatile(".rept 4000\\nnop\\n.endr"); angles[0] = inputs[0]; }\n'
    )
    inputs = np.array([[0.5, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    sources = {"nothing.c": nothing, "signal.h": embedded.signal_header(inputs)}
    instructions, angle_rad = cortex.count(sources, processor)
    np.testing.assert_array_equal(angle_rad, inputs[:, 0])
    # to a step of the counter, and the call
    np.testing.assert_allclose(instructions, 4000.0, atol=100.0)
