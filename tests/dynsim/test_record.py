"""Ground-motion records as files."""

import re

import numpy as np
import pytest

from blockstat import InputError
from dynsim import read_record


def record(tmp_path, text, **options):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    return read_record(path, **options)


def test_columns_are_components(tmp_path):
    along = record(tmp_path, "0 1\n0.5 3\n1 -1\n", direction=(0, 3, 4), scale=9.81)
    np.testing.assert_allclose(along.at(0.25), 2 * 9.81 * np.array([0, 0.6, 0.8]))
    plane = record(tmp_path, "# a comment\ntime; x; y\n0; 1; 2\n\n1; 3; 4\n")
    np.testing.assert_allclose(plane.at(0.5), [2, 3, 0])
    space = record(tmp_path, "0.1,1,2,3\n1,3,4,5\n")
    np.testing.assert_allclose(space.at(1.0), [3, 4, 5])
    np.testing.assert_array_equal(space.at(0.05), np.zeros(3))
    np.testing.assert_array_equal(space.at(1.01), np.zeros(3))
    assert space.end == 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,a\n0,1\n0.1,x\n", r'motion\.csv, line 3: "x" is not a finite number'),
        ("0,1\n0.1,nan\n", r'motion\.csv, line 2: "nan" is not a finite number'),
        ("0,1\n0.1,1,2\n", "line 2: 3 columns where the lines above have 2"),
        ("0\n1\n", "line 1: 1 columns"),
        ("0,1,2,3,4\n", "line 1: 5 columns"),
        ("0,1\n# two\n0.2,1\n0.1,1\n", r"line 4: the time 0\.1 does not come after 0\.2"),
        ("-1,1\n0,1\n", "line 1: the time is -1"),
        ("0;1,5\n1;2,5\n", "line 1: commas and semicolons both"),
        ("", "0 lines of numbers"),
        ("t,a\n0,1\n", "1 lines of numbers"),
        ("t,a\ns,m\n0,1\n1,1\n", 'line 2: "s" is not a finite number'),
        ("0,0\n1,0\n", "the acceleration is 0 throughout"),
    ],
)
def test_bad_records_are_named_with_their_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        record(tmp_path, text)


def test_bad_ways_to_read_a_record(tmp_path):
    with pytest.raises(InputError, match=r"gone\.csv: no such file"):
        read_record(tmp_path / "gone.csv")
    with pytest.raises(InputError, match="scale is 0"):
        record(tmp_path, "0,1\n1,1\n", scale=0)
    with pytest.raises(InputError, match="record: direction"):
        record(tmp_path, "0,1\n1,1\n", direction=(0, 0, 0))
    for columns, words in (
        ("0,1,2\n1,1,2\n", "has 2, along x and y"),
        ("0,1,2,3\n1,1,2,3\n", "has 3, along x, y and z"),
    ):
        with pytest.raises(InputError, match=f"a direction is for one column of accelerations; this record {words}"):
            record(tmp_path, columns, direction=(0, 1, 0))
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        read_record(tmp_path / "binary.csv")


@pytest.mark.parametrize("heading", ["t [s], a [m/s2]", "time (s);x (m/s\u00b2)", "time,acceleration", "a [m/s2]"])
def test_headings_may_name_the_units_that_are_read(tmp_path, heading):
    found = record(tmp_path, f"{heading}\n0,1\n1,2\n".replace(",", ";" if ";" in heading else ","))
    assert found.acceleration[:, 0].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("heading", "says"),
    [
        ("t [ms], a [m/s2]", 'line 1: times are in "ms"; they must be in s'),
        ("t [s], a [g]", 'line 1: accelerations are in "g"; they must be in m/s2, or have a scale'),
        ("t (s), a (cm/s2)", 'line 1: accelerations are in "cm/s2"; they must be in m/s2, or have a scale'),
    ],
)
def test_headings_with_other_units_are_refused(tmp_path, heading, says):
    with pytest.raises(InputError, match=re.escape(says)):
        record(tmp_path, f"{heading}\n0,1\n1,2\n")


@pytest.mark.parametrize(
    ("comment", "says"),
    [
        ("# time [s], acceleration [g]", 'accelerations are in "g"'),
        ("#time (s) acceleration (cm/s2)", 'accelerations are in "cm/s2"'),
        ("# a [Gal]", 'accelerations are in "gal"'),
        ("# v [m/s]", 'accelerations are in "m/s"'),
        ("# t [s], a [cm s^-2]", 'accelerations are in "cm s^-2"'),
        ("# t [ms], a [m/s2]", 'times are in "ms"'),
    ],
)
def test_headings_that_numpy_writes_as_a_comment_are_read_for_their_units(tmp_path, comment, says):
    with pytest.raises(InputError, match=re.escape(f"line 2: {says}")):
        record(tmp_path, f"# El Centro (1940)\n{comment}\n0,1\n1,2\n")
    if "times" not in says:
        assert record(tmp_path, f"{comment}\n0,1\n1,2\n", scale=2.0).acceleration[1, 0] == 4.0


@pytest.mark.parametrize(
    "comment", ["time [s], a [m/s2]", "a (m s-2)", "El Centro (1940, NS), every (2) samples", "(s)"]
)
def test_other_comments_are_passed_over(tmp_path, comment):
    assert record(tmp_path, f"# {comment}\n0,1\n# then in (g)\n1,2\n").acceleration[:, 0].tolist() == [1.0, 2.0]


def test_a_scale_explains_other_units_of_accelerations_alone(tmp_path):
    assert record(tmp_path, "t [s], a [g]\n0,1\n1,2\n", scale=9.81).acceleration[1, 0] == pytest.approx(19.62)
    with pytest.raises(InputError, match='times are in "ms"'):
        record(tmp_path, "t [ms], a [g]\n0,1\n1,2\n", scale=9.81)
