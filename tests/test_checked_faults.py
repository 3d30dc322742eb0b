"""Every row of the table of checks in docs/predict.md has tests that fail without the check."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STAMPS = "narx/recordings/test_stamps.py::"
FAULTS = "narx/recordings/test_faults.py::"
PLAUSIBILITY = "narx/recordings/test_plausibility.py::"
CONSISTENCY = "narx/recordings/test_consistency.py::"
MOUNTING = "narx/inference/test_mounting.py::"
PREDICT = "narx/inference/test_predict.py::"
DEVICE_FILES = "narx/inference/test_device_files.py::"
TEXT = "narx/datasets/test_text_dialect.py::"

# the beginning of a row, which no other row has, and its tests
TESTS = {
    "time in ms, us, ns, hours or days": [
        STAMPS + "test_times_that_are_not_seconds_are_refused",
        STAMPS + "test_stamps_have_the_rate_of_an_inertial_sensor",
        PLAUSIBILITY + "test_implausible_leg_motion_is_refused",
    ],
    "time in minutes": [PLAUSIBILITY + "test_implausible_leg_motion_is_refused"],
    "time in tenths of a second": [
        PLAUSIBILITY + "test_implausible_leg_motion_is_refused",
        PLAUSIBILITY + "test_a_slow_sensor_is_not_taken_for_times_in_tenths",
    ],
    "a missing stamp": [STAMPS + "test_times_that_are_not_seconds_are_refused"],
    "time without a unit": [
        TEXT + "test_times_without_a_unit_are_read_by_their_rate",
        TEXT + "test_times_without_a_unit_that_have_no_likely_one_are_refused",
    ],
    "an interval given as rate": [
        STAMPS + "test_an_interval_given_as_rate_is_pointed_out",
        STAMPS + "test_impossible_rates_are_refused",
    ],
    "duplicated row": [
        STAMPS + "test_repeated_and_exchanged_rows",
        STAMPS + "test_rows_that_occur_twice_are_left_out",
    ],
    "rows out of order": [STAMPS + "test_repeated_and_exchanged_rows"],
    "stamps at arrival": [
        STAMPS + "test_a_regular_clock_takes_the_place_of_stamps_at_arrival",
        STAMPS + "test_sampling_that_is_itself_irregular_about_a_line_is_kept",
        STAMPS + "test_delays_that_grow_do_not_change_the_rate",
        STAMPS + "test_packets_of_a_clock_that_starts_at_zero_are_stamped_at_their_end",
        STAMPS + "test_arrival_without_a_regular_clock_is_refused",
    ],
    "time of day past midnight": [
        STAMPS + "test_a_time_of_day_and_a_counter_go_on_where_they_begin_again",
        TEXT + "test_times_of_day_pass_midnight",
    ],
    "clock that goes back": [
        STAMPS + "test_times_that_are_not_seconds_are_refused",
        STAMPS + "test_halves_in_the_wrong_order_are_not_sorted",
    ],
    "gaps of days": [
        PLAUSIBILITY + "test_implausible_leg_motion_is_refused",
        PLAUSIBILITY + "test_a_gap_of_hours_is_within_one_recording",
    ],
    "two rates on one time axis": [
        PLAUSIBILITY + "test_two_rates_on_one_axis",
        PLAUSIBILITY + "test_single_missing_samples_are_no_other_rate",
    ],
    "a slower sensor on a faster clock": [
        PLAUSIBILITY + "test_a_slower_sensor_gets_its_own_clock",
        FAULTS + "test_a_slower_sensor_on_a_faster_clock",
        FAULTS + "test_repeats_in_runs_of_any_length_are_not_a_slower_sensor",
    ],
    "duplicated column": [
        TEXT + "test_a_name_in_other_letters_is_the_same_column",
        TEXT + "test_a_quantity_in_two_units_must_agree",
        TEXT + "test_times_in_two_units_must_agree",
    ],
    "rows of several sensors in turn": [
        PLAUSIBILITY + "test_rows_of_several_sensors_are_refused",
        PLAUSIBILITY + "test_one_sensor_is_not_taken_for_several",
    ],
    "held rows": [
        FAULTS + "test_faults_become_missing_and_are_counted",
        FAULTS + "test_three_rows_over_30_ms_are_held",
    ],
    "one axis stuck": [
        FAULTS + "test_faults_become_missing_and_are_counted",
        FAULTS + "test_an_axis_that_stays_for_a_quarter_of_a_second_is_stuck",
    ],
    "zeros for missing samples": [
        FAULTS + "test_faults_become_missing_and_are_counted",
        PLAUSIBILITY + "test_impossible_accelerations_are_missing",
    ],
    "spikes of one to three samples": [
        FAULTS + "test_a_spike_stands_out_from_all_other_samples",
        FAULTS + "test_many_spikes_of_several_samples",
        FAULTS + "test_a_jump_of_less_than_two_degrees_is_not_a_spike",
        FAULTS + "test_an_impact_that_rings_is_not_a_spike",
    ],
    "beyond any sensor": [
        FAULTS + "test_faults_become_missing_and_are_counted",
        PLAUSIBILITY + "test_half_a_per_cent_beyond_any_gyroscope_is_refused",
        PLAUSIBILITY + "test_one_impossible_value_is_a_code_for_missing_samples",
        PLAUSIBILITY + "test_impossible_accelerations_are_missing",
    ],
    "16-bit overflow": [
        "narx/recordings/test_overflow.py::test_rates_that_wrap_around_are_continued",
        "narx/recordings/test_overflow.py::test_rates_that_wrap_around_too_often_are_refused",
        "narx/recordings/test_overflow.py::test_a_wrap_that_does_not_come_back_is_refused",
        "narx/recordings/test_overflow.py::test_other_signals_are_left",
    ],
    "sensors of a session that are apart": [
        "narx/recordings/test_session_clock.py::"
        "test_overlapping_stamps_are_used_and_disagreement_is_reported",
        "narx/recordings/test_session_clock.py::"
        "test_a_steady_walk_some_strides_apart_is_not_certain",
    ],
    "clipping": [
        FAULTS + "test_clipping_is_reported_and_left",
        FAULTS + "test_coarse_numbers_are_no_fault",
    ],
    "deg/s as rad/s, raw counts": [PLAUSIBILITY + "test_implausible_leg_motion_is_refused"],
    "rad/s as deg/s": [
        PLAUSIBILITY + "test_implausible_leg_motion_is_refused",
        PLAUSIBILITY + "test_who_stands_is_not_taken_for_a_walker_in_another_unit",
    ],
    "gyroscope's unit or scale": [
        CONSISTENCY + "test_unit_sign_and_handedness",
        CONSISTENCY + "test_limits_of_what_contradicts",
        CONSISTENCY + "test_only_frequencies_below_1_5_hz_are_compared",
        "narx/inference/test_findings.py::"
        "test_a_reversed_axis_of_a_sensor_that_only_turns_is_refused",
        PREDICT + "test_a_gyroscope_that_contradicts_is_only_noted_in_the_sensor_frame",
    ],
    "frame=anatomical, but": [
        MOUNTING + "test_another_axis_is_refused_if_the_frame_was_assumed",
        MOUNTING + "test_a_smaller_deviation_is_noted",
        MOUNTING + "test_the_axis_may_turn_further_within_the_plane_of_y_and_z",
        MOUNTING + "test_only_a_dominant_axis_of_a_fast_swing_is_judged",
        MOUNTING + "test_a_reversed_axis_is_noted",
        MOUNTING + "test_movements_other_than_walking_are_not_judged",
    ],
    "thigh and shank of a session exchanged": [
        "narx/inference/test_session.py::test_exchanged_thigh_and_shank_are_noted",
    ],
    "gyroscope of zeros": [
        PREDICT + "test_missing_data_are_reported",
        "narx/calibration/test_calibrate.py::test_something_that_does_not_walk_is_refused",
    ],
    "accelerometer in g, mg, counts": [
        PLAUSIBILITY + "test_an_accelerometer_in_another_unit_is_named",
        PREDICT + "test_an_accelerometer_in_g_is_refused_where_it_is_needed",
        "narx/inference/test_session.py::test_invalid_input_is_refused_in_one_line",
    ],
    "`still_s` over movement": [
        "narx/inference/test_bias.py::test_a_part_declared_still_may_sway_by_5_deg_s",
    ],
    "`start_pose=known`": [
        "narx/inference/test_bias.py::test_a_known_start_is_there_and_slower_than_20_deg_s",
        DEVICE_FILES + "test_implausible_files_are_refused_in_one_line",
        PREDICT + "test_missing_data_are_reported",
    ],
    "motion that does not resemble": [
        "narx/inference/test_findings.py::"
        "test_motion_unlike_a_leg_is_noted_if_it_is_most_of_the_recording",
    ],
    "recording too short for the network": [
        DEVICE_FILES + "test_a_walk_too_short_for_the_network_is_said",
    ],
    "pipes, devices, folders": [TEXT + "test_paths_that_are_not_files_are_refused_immediately"],
    "files that would take more than": [
        TEXT + "test_paths_that_are_not_files_are_refused_immediately",
        TEXT + "test_a_text_needs_more_memory_than_its_size",
        TEXT + "test_compressed_text",
        "narx/datasets/test_csv_recording.py::"
        "test_a_parquet_file_of_billions_of_equal_values_is_refused",
        "narx/datasets/test_apdm_file.py::test_equal_values_that_take_no_space_need_memory",
        "narx/datasets/test_mat_file.py::test_a_small_file_that_asks_for_gigabytes_is_refused",
        "narx/datasets/test_device_layouts.py::"
        "test_a_zip_that_unpacks_to_more_than_the_limit_is_refused",
    ],
}


def _rows():
    page = (ROOT / "docs" / "predict.md").read_text(encoding="utf-8")
    section = page.split("## What is checked\n", 1)[1].split("\n## ", 1)[0]
    return re.findall(r"^\| (.*?) \|", section, re.MULTILINE)[1:]


def test_every_row_has_its_entry():
    found = [[begin for begin in TESTS if row.startswith(begin)] for row in _rows()]
    assert all(len(begins) == 1 for begins in found), found
    assert [begin for (begin,) in found] == list(TESTS)


def test_the_tests_exist():
    for test in {one for tests in TESTS.values() for one in tests}:
        file, name = test.split("::")
        source = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert re.search(rf"^def {name}\(", source, re.MULTILINE), test
