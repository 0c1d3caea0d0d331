"""Bad rig files: one line with file, line, field, fact and remedy."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.rig.yaml import nodes
from riglens.core.rig.yaml.file import load_rig, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES, parse_yaml, plain_value
from riglens.core.sensors.registry import kind_names

LIDAR = """\
riglens: 1
name: test
vehicle: {body: sedan, length: 4.6}
sensors:
  - name: front
    kind: lidar
    position: [0, 0, 2]
    elevations_deg: {from: -25, to: 25, count: 16}
  - name: rear
    kind: lidar
    position: [1, 2, 3]
    azimuths_deg: {from: -180, to: 180, count: 360}
    elevations_deg: [-10, 0, 10]
"""
CAMERA = """\
riglens: 1
sensors:
  - name: cam
    kind: camera
    position: [0, 0, 2]
    hfov_deg: 70
    image: [1600, 900]
"""


def complaint(text: str) -> str:
    with pytest.raises(InputError) as caught:
        loads(text, "my rig.yaml")
    message = str(caught.value)
    assert "\n" not in message and message.isprintable() and len(message) < 400
    assert message.startswith("my rig.yaml:")
    return message.removeprefix("my rig.yaml:")


def test_the_files_these_tests_break_are_fine() -> None:
    assert len(loads(LIDAR).rig.sensors) == 2 and len(loads(CAMERA).rig.sensors) == 1


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "[1, 2, 3]",
            "[1, .nan, 3]",
            '11: lidar "rear": position[1] must be a finite number (got .nan)',
        ),
        (
            "[1, 2, 3]",
            "[1, 2e7, 3]",
            '11: lidar "rear": position[1] must be at most 10000000 (got 20000000.0)',
        ),
        ("[1, 2, 3]", "[1, 2]", '11: lidar "rear": position[2] is missing'),
        (
            "[1, 2, 3]",
            "[1, 2, 3, 4]",
            '11: lidar "rear": position must have at most 3 items (got [1, 2, 3, 4])',
        ),
        ("[1, 2, 3]", "[1, true, 3]", '11: lidar "rear": position[1] must be a number (got true)'),
        ("[1, 2, 3]", "{x: 1}", '11: lidar "rear": position must be a list (got {x: 1})'),
        ("    position: [1, 2, 3]\n", "", '9: lidar "rear": position is missing'),
        (
            "count: 16",
            "count: 0",
            '8: lidar "front": elevations_deg.count must be at least 1 (got 0)',
        ),
        (
            "count: 16",
            "count: 16.0",
            '8: lidar "front": elevations_deg.count must be an integer (got 16.0)',
        ),
        (
            "count: 16",
            "number: 16",
            '8: lidar "front": elevations_deg.number is not a known field; known are from, to, count',
        ),
        (
            "from: -25",
            "from_: -25",
            '8: lidar "front": elevations_deg.from_ is not a known field (and 1 more)',
        ),
        (
            "from: -25",
            "from: 26",
            "8: lidar \"front\": elevations_deg: 'to' (25.0) must not be below 'from' (26.0)",
        ),
        (
            "to: 25",
            "to: 95",
            '8: lidar "front": elevations_deg must be within [-90, 90] (got -25.0 to 95.0)',
        ),
        (
            "to: 180",
            "to: 181",
            '12: lidar "rear": azimuths_deg must span at most 360 degrees (got 361.0)',
        ),
        ("[-10, 0, 10]", "[]", '13: lidar "rear": elevations_deg must have at least 1 item (got [])'),
        (
            "360}\n    elevations_deg: [-10, 0, 10]",
            "60000}\n    elevations_deg: {from: 1, to: 2, count: 60000}",
            '9: lidar "rear": a LiDAR must cast 1 to 67108864 rays (got 3600000000)',
        ),
        ("[-10, 0, 10]", "10", '13: lidar "rear": elevations_deg must be a mapping or a list (got 10)'),
        (
            "name: rear",
            "name: front",
            "9: lidar \"front\": name 'front' is used twice; names must be unique",
        ),
        ("name: rear", "name: 7", "9: sensors[1]: name must be a text (got 7)"),
        ("name: rear", "name: ''", '9: sensors[1]: name must have at least 1 character (got "")'),
        (
            "  - name: rear\n    kind: lidar",
            "  - kind: lidar",
            "9: sensors[1]: name is missing",
        ),
        (
            "kind: lidar\n    position: [1",
            "kind: sonar\n    position: [1",
            f'10: sonar "rear": kind must be {" or ".join(kind_names())} (got sonar)',
        ),
        (
            "    kind: lidar\n    position: [1",
            "    position: [1",
            f'9: sensor "rear": kind must be {" or ".join(kind_names())}',
        ),
        (
            "    position: [1",
            "    positon: [1",
            "11: lidar \"rear\": positon is not a known field (did you mean 'position'?)",
        ),
        ("length: 4.6", "lenght: 4", "3: vehicle.lenght is not a known field (did you mean 'length'?)"),
        (
            "{body: sedan, length: 4.6}",
            "sedan",
            "3: vehicle must be a mapping (got sedan)",
        ),
        ("name: test", "name: te: st", "2: not valid YAML: mapping values are not allowed here"),
        (
            "name: test",
            "name: &a test",
            "2: anchors and aliases (& and *) are not accepted; write the values out",
        ),
        (
            "name: test",
            "name: !!python/name:os.system x",
            "2: tags are not accepted (got tag:yaml.org,2002:python/name:os.system)",
        ),
        ("name: test", "name: \a", "2: not valid YAML: special characters are not allowed"),
        (
            "name: test",
            "name: " + "x" * 300,
            "2: name must have at most 200 characters (got xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx",
        ),
        (
            "riglens: 1",
            "riglens: 2",
            "1: riglens: format version 2 is newer than this program reads (1); please update RigLens",
        ),
        ("riglens: 1", "riglens: true", "1: riglens must be 1 (got true)"),
        ("riglens: 1", "riglens: " + "1" * 5000, "1: riglens must be 1 (got .inf)"),
        ("riglens: 1\n", "", "1: riglens is missing; a rig starts with 'riglens: 1'"),
    ],
)
def test_a_broken_rig_is_refused(old: str, new: str, expected: str) -> None:
    assert LIDAR.count(old) >= 1
    assert complaint(LIDAR.replace(old, new, 1)).startswith(expected)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (
            "hfov_deg: 70",
            '11: lidar "rear": hfov_deg is not a known field; known are name, model, position, rpy_deg,',
        ),
        (
            "model: vlp-16",
            "11: lidar \"rear\": model: unknown sensor model 'vlp-16'; did you mean 'velodyne-vlp-16' or ",
        ),
        (
            "model: paper-camera-70",
            "11: lidar \"rear\": model 'paper-camera-70' is a camera, but this sensor is a lidar; see",
        ),
        ("enabled: yes", '11: lidar "rear": enabled must be true or false (got "yes")'),
        (
            "range_m: [5, 2]",
            '11: lidar "rear": range_m must be [min, max] with 0 <= min < max, found [5.0, 2.0]',
        ),
        (
            "azimuth_offsets_deg: [1, 2]",
            '11: lidar "rear": azimuth_offsets_deg must hold one offset per beam, 3 (got 2)',
        ),
        ("kind: lidar", "11: key kind is given twice, first in line 10"),
    ],
)
def test_a_broken_field_of_a_sensor_is_refused(line: str, expected: str) -> None:
    assert complaint(LIDAR.replace("    position: [1", f"    {line}\n    position: [1")).startswith(expected)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "hfov_deg: 70",
            "hfov_deg: 70\n    distortion: {model: kannala_brandt}",
            '7: camera "cam": distortion needs the lens as fx, fy, cx, cy in pixels, not as hfov_deg',
        ),
        (
            "hfov_deg: 70",
            "distortion: {model: brown_conrady, k7: 1}",
            '6: camera "cam": distortion.k7 is not a known field; known are model, k1, k2, p1, p2, k3, ',
        ),
        (
            "hfov_deg: 70",
            "distortion: {model: fish, k1: 1}",
            '6: camera "cam": distortion.model must be brown_conrady or kannala_brandt (got fish)',
        ),
        (
            "hfov_deg: 70",
            "distortion: {k1: 1}",
            '6: camera "cam": distortion.model is missing',
        ),
        (
            "hfov_deg: 70",
            "hfov_deg: -70",
            '6: camera "cam": hfov_deg must be at least 0.001 (got -70)',
        ),
        (
            "hfov_deg: 70",
            "hfov_deg: 70\n    fx: 900",
            '3: camera "cam": give either hfov_deg or all of fx, fy, cx, cy',
        ),
        ("    hfov_deg: 70\n", "", '3: camera "cam": give either hfov_deg or all of fx, fy, cx, cy'),
        (
            "[1600, 900]",
            "[1600.5, 900]",
            '7: camera "cam": image[0] must be an integer (got 1600.5)',
        ),
        (
            "[1600, 900]",
            "[1600, 900]\n    cast: [1601, 1]",
            '8: camera "cam": cast [1601, 1] must not exceed the image [1600, 900]',
        ),
    ],
)
def test_a_broken_camera_is_refused(old: str, new: str, expected: str) -> None:
    assert old in CAMERA
    assert complaint(CAMERA.replace(old, new)).startswith(expected)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "1: the file is empty"),
        ("# nothing\n\n", "1: the file is empty"),
        ("- a\n- b\n", "1: a rig must be a mapping that starts with 'riglens: 1' (got [a, b])"),
        ("riglens: 1\nsensors:\n", "2: sensors must be a list (got nothing)"),
        ("riglens: 1\nsensors:\n  - 3\n", "3: sensors[0] must be a mapping (got 3)"),
        (
            "riglens: 1\n---\nriglens: 1\n",
            "2: not valid YAML: expected a single document in the stream, but found another document",
        ),
        ("%YAML 1.1\n---\nriglens: 1\n", "2: YAML directives (%) are not accepted, except '%YAML 1.2'"),
        ("riglens: 1\n? [a]\n: 2\n", "2: a key must be a word, not a list or a mapping"),
        (
            "riglens: 1\nname: 'open\n",
            "3: not valid YAML: while scanning a quoted scalar, found unexpected end of stream",
        ),
        ("riglens: 1\nname: {a: {a: " + "{a: " * 50, "2: nested more than 12 levels deep"),
        (
            "riglens: 1\n\tname: x",
            "2: not valid YAML: while scanning for the next token, found character '\\t' that cannot sta",
        ),
        ("{" * 100_000, "1: nested more than 12 levels deep"),
    ],
)
def test_what_is_no_rig_at_all_is_refused(text: str, expected: str) -> None:
    assert complaint(text).startswith(expected)


def test_several_problems_are_counted_and_the_first_in_the_file_is_said() -> None:
    text = LIDAR.replace("[1, 2, 3]", "[1]").replace("count: 16", "count: 0").replace("4.6", "-1")
    assert complaint(text).startswith("3: vehicle.length must be at least 0.1 (got -1)")
    assert complaint(text).endswith("(and 3 more)")


def test_a_wrong_number_in_a_long_list_is_shown_alone() -> None:
    beams = ",\n      ".join(str(angle) for angle in [*range(40), 99])
    message = complaint(LIDAR.replace("[-10, 0, 10]", f"[{beams}]"))
    assert message.startswith('53: lidar "rear": elevations_deg[40] must be at most 90 (got 99)')


def test_too_many_sensors_are_refused() -> None:
    sensors = "".join(
        f"  - {{name: s{i}, kind: camera, position: [0, 0, 1], hfov_deg: 9}}\n" for i in range(256)
    )
    message = complaint(f"riglens: 1\nsensors:\n{sensors}")
    assert message.startswith("2: sensors must have at most 255 items (got [")


def test_aliases_never_get_to_blow_a_file_up() -> None:
    bomb = "a: &a [x, x]\n" + "".join(
        f"{b}: &{b} [*{a}, *{a}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
    )
    assert complaint(bomb).startswith("1: anchors and aliases (& and *) are not accepted")


@given(
    st.binary(max_size=60) | st.text(alphabet="[]{}:,-#&*!|>'\"%@` \n\tab1.~", max_size=40).map(str.encode)
)
def test_no_file_content_gives_anything_but_a_rig_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "random.yaml"
    path.write_bytes(b"riglens: 1\nname: " + content)
    try:
        load_rig(path)
    except InputError as error:
        assert str(error).startswith(f"{path}:") and "\n" not in str(error)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"riglens: 1\nname: caf\xe9\n", ":2: must be UTF-8 text (got byte 0xe9)"),
        ("riglens: 1\n".encode("utf-16"), ": must be a rig YAML file in UTF-8"),
        (b"\x89PNG\r\n\x1a\n\0\0", ": must be a rig YAML file in UTF-8"),
        (b"# " + b"x" * MAX_BYTES, ": too large for a rig YAML file (at most 1 MB)"),
    ],
)
def test_a_file_that_is_no_text_is_refused(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "rig.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_rig(path)
    assert str(caught.value).startswith(f"{path}{expected}")


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.yaml: no such file$"):
        load_rig(tmp_path / "nowhere.yaml")
    with pytest.raises(InputError, match=r"a rig YAML file .got a folder"):
        load_rig(tmp_path)


def test_very_many_values_are_refused_by_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """A list of a million numbers kept the parser busy for 17 s."""
    assert nodes.MAX_VALUES <= 100_000
    monkeypatch.setattr(nodes, "MAX_VALUES", 100)
    assert complaint("riglens: 1\nname: [" + "0," * 150_000 + "0]") == "2: more than 100 values"
    text = "a: [1, 2, {b: 3}]"  # two mappings, a list, two keys, three numbers
    monkeypatch.setattr(nodes, "MAX_VALUES", 8)
    assert plain_value(parse_yaml(text, "")) == {"a": (1, 2, {"b": 3})}
    monkeypatch.setattr(nodes, "MAX_VALUES", 7)
    assert complaint(text) == "1: more than 7 values"


@pytest.mark.parametrize("text", ['name: "\\ud800"', '"\\udfff": 1', 'keep_out: [{material: "\\ud800"}]'])
def test_halves_of_characters_are_refused_with_their_line(text: str) -> None:
    """Pydantic cannot repeat them in its messages."""
    with pytest.raises(InputError, match=r"^a\.yaml:2: text must consist of whole characters"):
        parse_yaml(f"riglens: 1\n{text}\n", "a.yaml")


@pytest.mark.parametrize("before", ["name: ", "name:\n  ", "[", "{", "- ", '{"a":', ""])
def test_long_tags_are_refused_unparsed(before: str) -> None:
    """The parser's time grows with their square: a megabyte took 14 s."""
    assert "tags are not accepted (got !!!!!" in complaint(f"riglens: 1\nx: 1\n{before}{'!' * 900_000}")


def test_exclamation_marks_in_a_name_are_no_tag() -> None:
    assert loads(f'riglens: 1\nname: "{"!" * 150} wow{"!" * 40}"\nsensors: []\n').rig.name.endswith(
        "wow" + "!" * 40
    )


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_an_unreadable_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "rig.yaml"
    path.write_text(LIDAR, encoding="utf-8")
    path.chmod(0)
    with pytest.raises(InputError, match="cannot be read: Permission denied"):
        load_rig(path)
