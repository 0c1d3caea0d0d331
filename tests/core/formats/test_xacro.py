"""xacro is expanded by ROS's package in a process of its own; what would do harm is refused in one line."""

import math
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from tests.core.formats.cases import read_files, write_files
from tests.core.formats.test_reports import has

HEAD = '<robot name="car" xmlns:xacro="http://ros.org/wiki/xacro"><link name="base_link"/>'
MACROS = """<robot xmlns:xacro="http://ros.org/wiki/xacro">
  <xacro:property name="height" value="1.5"/>
  <xacro:macro name="mast" params="name parent:=base_link x yaw:=0 tall:=true *extra">
    <link name="${name}"/>
    <joint name="${name}_joint" type="fixed">
      <parent link="${parent}"/><child link="${name}"/>
      <xacro:if value="${tall and x > 0}"><origin xyz="${x} 0 ${height + 0.25}" rpy="0 0 ${radians(yaw)}"/></xacro:if>
      <xacro:unless value="${tall and x > 0}"><origin xyz="${x} 0 ${height/2}"/></xacro:unless>
    </joint>
    <xacro:insert_block name="extra"/>
  </xacro:macro>
</robot>"""
CAR = (
    HEAD
    + """
  <xacro:arg name="prefix" default="front"/>
  <xacro:include filename="$(find my_car)/urdf/parts/macros.xacro"/>
  <xacro:property name="half" value="${wheelbase / 2}"/>
  <xacro:property name="wheelbase" value="3.0"/>
  <xacro:mast name="$(arg prefix)_lidar" x="${half}" yaw="90"><note/></xacro:mast>
  <xacro:mast name="rear_camera" x="${-half}"><note/></xacro:mast>
</robot>"""
)


def test_properties_macros_conditions_includes_and_sums_are_expanded(tmp_path: Path) -> None:
    write_files(tmp_path / "urdf", {"car.xacro": CAR})
    write_files(tmp_path / "urdf" / "parts", {"macros.xacro": MACROS})
    read = read_rig(tmp_path / "urdf" / "car.xacro")
    lidar, camera = read.rig.sensor("front_lidar"), read.rig.sensor("rear_camera")
    axle = read.rig.vehicle.rear_axle_x
    assert lidar.position == pytest.approx((axle + 1.5, 0.0, 1.75)) and lidar.rpy_deg[2] == pytest.approx(
        90.0
    )
    assert camera.position == pytest.approx((axle - 1.5, 0.0, 0.75))
    assert has(read.report, "read", "xacro, expanded here", "1 files included")


LIDAR = (
    '<link name="lidar"/><joint name="j" type="fixed"><parent link="base_link"/><child link="lidar"/></joint>'
)


def first(expression: str, before: str = "", name: str = "rig.xacro") -> float:
    """What an expression is, as the place of a LiDAR ahead of base_link, metres."""
    joint = '<joint name="j" type="fixed"><parent link="base_link"/><child link="lidar"/><origin xyz="{} 0 1"/></joint>'
    text = HEAD + before + '<link name="lidar"/>' + joint.format(expression) + "</robot>"
    read = read_files({name: text})
    return read.rig.sensor("lidar").position[0] - read.rig.vehicle.rear_axle_x


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("${1 + 2*3 - 4/8}", 6.5), ("${2**3 % 5}", 3.0), ("${-(7 // 2)}", -3.0), ("${pi/2}", math.pi / 2),
        ("${sin(pi/6) + sqrt(4)}", 2.5), ("${max(1, 2.5, a)}", 4.0), ("${a if a > 3 else 0}", 4.0), ("1${0}.5", 10.5),
        ("$(eval 3*2)", 6.0), ("${b}", 8.0), ("${'x' == name and 1 or 0}", 1.0), ("${int(2.9)}", 2.0),
        ("$(optenv HOME 1.5)", 1.5), ("$(optenv NOSUCH ${a})", 4.0), ("${round(2.345, 2)}", 2.35),
        ("${round(2.6)}", 3.0),
    ],
)  # fmt: skip
def test_expressions_are_arithmetic(expression: str, value: float) -> None:
    known = "".join(
        f'<xacro:property name="{name}" value="{said}"/>'
        for name, said in (("a", "4"), ("b", "${2*a}"), ("name", "x"))
    )
    assert first(expression, known) == pytest.approx(value)


@pytest.mark.parametrize(
    "expression",
    [
        "${__import__('os').system('touch owned')}", "${open('/etc/passwd').read()}", "${().__class__.__mro__}",
        "${(lambda: ().__class__.__base__.__subclasses__())()}", "${[x for x in (1, 2)].__class__}", "${1/0}",
        "${[g for g in ((x for x in g.gi_frame.f_back.f_builtins) for _ in (1,))]}", "${sqrt(-1)}",
        "${python.type('X', (list,), {'y': 1})}", "${python.vars(xacro.load_yaml)}", "${'a' * 10**10}",
        "${str.format('0.__class__', 1)}", "${'0.__class__'.format_map(math)}", "${1e300*1e300}",
        "${" + "(" * 500 + "1" + ")" * 500 + "}", "$(eval __import__('os').getcwd())", "$(eval open('owned', 'w'))",
        "$(env HOME)", "$(optenv HOME)", "$(dirname)", "$(nosuch)", "$(arg nosuch)", "${nosuch}", "${}", "${a.b}",
        "${a[0]}", "${sin}", "${sin(x=1)}", "${1 if}", "${[1, 2][2]}", "${dict(x=1)['y']}", "${len(a)}",
        "${exec('1')}", "${print(1)}", "${input()}", "${arg('x')}", "${xacro.arg('nosuch')}", "${xacro.fatal('no')}",
        "${load_yaml('rig.xacro')}", "${load_yaml('nosuch.yaml')}", "${load_yaml('/etc/passwd')}", "${load_yaml(a)}",
        f"${{load_yaml('{300 * 'a'}')}}",
    ],
)  # fmt: skip
def test_anything_else_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, expression: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as caught:
        first(expression, '<xacro:property name="a" value="4"/>')
    line = str(caught.value)
    assert "rig.xacro:1: <" in line and line.isprintable() and len(line) < 400
    assert not (tmp_path / "owned").exists()


def test_no_file_is_read_by_a_way_around_xacro(tmp_path: Path) -> None:
    """Whatever an expression reaches, the process itself may only read files of the rig, and open nothing else."""
    write_files(tmp_path, {"secret.yaml": "x: 1"})
    own = str(write_files(tmp_path / "mine", {"own.yaml": "x: 2"}) / "own.yaml")
    attempts = (
        "open('{}')",
        "open('{}', 'a')",
        "__import__('socket').socket()",
        "__import__('os').system('true')",
    )
    code = (
        "import sys; from pathlib import Path; from riglens.core.formats.xacro_process import guard\n"
        "import os; guard({{sys.argv[1]}}); print(open(sys.argv[1]).read())\ntry: {}\n"
        "except PermissionError: print('refused')\n"
    )
    for attempt, file in zip(attempts, (tmp_path / "secret.yaml", own, own, own), strict=True):
        command = [sys.executable, "-c", code.format(attempt.format(file)), own]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
        assert done.stdout.split() == ["x:", "2", "refused"], done.stderr


def test_what_takes_too_long_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("riglens.core.formats.xacro.TIME_LIMIT_S", 1.0)
    with pytest.raises(InputError, match=r"rig\.xacro: reading took more than 1 s"):
        first("${9**9**9**9}")


def test_a_module_in_the_current_folder_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(
        write_files(tmp_path, {"yaml.py": "open('owned', 'w')", "xacro.py": "open('owned', 'w')"})
    )
    assert first("${1 + 1}") == 2.0 and not (tmp_path / "owned").exists()


def test_a_urdf_that_holds_xacro_is_expanded_too() -> None:
    """As TurtleBot3 ships its robots."""
    assert first("${1 + 2}", name="rig.urdf") == 3.0


def test_macros_of_a_namespace_methods_of_texts_and_arguments_in_the_name_are_expanded(
    tmp_path: Path,
) -> None:
    """As Husarion writes its components, which this did not read."""
    part = """<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="deeper.xacro"/>
      <xacro:macro name="spinner" params="parent_link xyz"><link name="${parent_link.rstrip('_link')}_lidar"/>
        <joint name="j" type="fixed"><parent link="${parent_link}"/>
        <child link="${parent_link.rstrip('_link')}_lidar"/><origin xyz="${xyz}" rpy="0 0 ${turn}"/></joint>
      </xacro:macro></robot>"""
    deeper = f'{HEAD.partition("<link")[0]}<xacro:property name="turn" value="${{pi / 2}}"/></robot>'
    text = (
        HEAD.replace('"car"', '"$(arg model)_car"')
        + '<xacro:arg name="model" default="lynx"/><xacro:include filename="parts/part.xacro" ns="top"/>'
        '<xacro:top.spinner parent_link="base_link" xyz="1 0 1.8"/></robot>'
    )
    write_files(tmp_path, {"car.xacro": text})
    write_files(tmp_path / "parts", {"part.xacro": part, "deeper.xacro": deeper})
    rig = read_rig(tmp_path / "car.xacro").rig
    (lidar,) = rig.sensors
    assert (rig.name, lidar.name) == ("lynx_car", "base_lidar")
    assert lidar.position[2] == 1.8 and lidar.rpy_deg[2] == pytest.approx(90.0)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("${p['x']}", 2.0), ("${xacro.dotify(p).x + xacro.dotify(p).inner.y}", 5.0),
        ("${p['inner']['y']}", 3.0), ("${p['n'][1]}", 5.0),
        ("${l[-1]}", 8.0), ("${(1, 2)[1]}", 2.0),
        ("${len(l)}", 3.0), ("${len(l[1:])}", 2.0), ("${1 if 7 in l and 'x' in p else 0}", 1.0), ("${q['1a']}", 1.0),
        ("${dict(p, x=9)['x']}", 9.0), ("${math.radians(180) / math.pi}", 1.0), ("${xacro.arg('a')}", 4.0),
        ("${1 if 'y' not in p else 0}", 1.0),
    ],
)  # fmt: skip
def test_lists_and_dictionaries_have_entries(expression: str, value: float) -> None:
    before = """<xacro:arg name="a" default="4"/><xacro:property name="l" value="${[6, 7, 4*2]}"/>
      <xacro:property name="p" value="${dict(x=2, inner=dict(y=3), n=(4, 5))}"/>
      <xacro:property name="q" value="${dict([('1a', 1), ('2b', 2)])}"/>"""
    assert first(expression, before) == pytest.approx(value)


CALIBRATION = "base_link:\n  velodyne_top: {x: 1.25, y: 0.5, z: 1.5, rpy: [0, 0, 1.5707963267948966]}\n"
KIT = (
    HEAD
    + """
  <xacro:arg name="config_dir" default="$(find kit)/config"/>
  <xacro:property name="calibration" value="${xacro.load_yaml('$(arg config_dir)/kit.yaml')}"/>
  <xacro:macro name="lidar" params="name at">
    <link name="${name}"/><joint name="j" type="fixed"><parent link="base_link"/><child link="${name}"/>
    <origin xyz="${at['x']} ${at['y']} ${at.z}" rpy="${at.rpy[0]} ${at.rpy[1]} ${at.rpy[2]}"/></joint>
  </xacro:macro>
  <xacro:lidar name="velodyne_top" at="${calibration['base_link']['velodyne_top']}"/>
</robot>"""
)


def test_a_calibration_is_loaded_from_the_package_of_the_kit(tmp_path: Path) -> None:
    write_files(tmp_path / "kit", {"package.xml": "<package/>"})
    write_files(tmp_path / "kit" / "config", {"kit.yaml": CALIBRATION})
    write_files(tmp_path / "kit" / "urdf", {"kit.xacro": KIT})
    read = read_rig(tmp_path / "kit" / "urdf" / "kit.xacro")
    lidar = read.rig.sensor("velodyne_top")
    assert lidar.position == pytest.approx((read.rig.vehicle.rear_axle_x + 1.25, 0.5, 1.5))
    assert lidar.rpy_deg[2] == pytest.approx(90.0)
    assert has(read.report, "read", "xacro, expanded here", "1 files included")


def test_a_macro_knows_what_is_known_where_it_is_called(tmp_path: Path) -> None:
    """Autoware's kits include the files of their sensors, with properties of these, in a macro of their own."""
    part = HEAD.replace("car", "part").partition("<link")[0] + (
        '<xacro:property name="half" value="0.5"/><xacro:macro name="lidar" params="name"><link name="${name}"/>'
        '<joint name="j" type="fixed"><parent link="base_link"/><child link="${name}"/>'
        '<origin xyz="${2*half + further} 0 1"/></joint><xacro:property name="after" value="7" scope="parent"/>'
        "</xacro:macro></robot>"
    )
    kit = (
        HEAD + '<xacro:macro name="kit" params="further"><xacro:include filename="part.xacro"/>'
        '<xacro:lidar name="lidar_${further}"/><link name="made_${after}"/></xacro:macro>'
        '<xacro:kit further="3"/></robot>'
    )
    read = read_rig(write_files(tmp_path, {"kit.xacro": kit, "part.xacro": part}) / "kit.xacro")
    (lidar,) = read.rig.sensors
    assert lidar.name == "lidar_3"
    assert lidar.position[0] - read.rig.vehicle.rear_axle_x == pytest.approx(4.0)
    write_files(tmp_path, {"kit.xacro": kit.replace("</robot>", '<link name="${after}"/></robot>')})
    with pytest.raises(InputError, match="'after' is not defined"):
        read_rig(tmp_path / "kit.xacro")


def test_nothing_is_loaded_from_beside_a_package(tmp_path: Path) -> None:
    write_files(tmp_path / "config", {"kit.yaml": CALIBRATION})
    write_files(tmp_path / "kit" / "urdf", {"kit.xacro": KIT})
    for is_package in (False, True):
        if is_package:
            write_files(tmp_path / "kit", {"package.xml": "<package/>"})
        with pytest.raises(InputError, match=r"'/kit/config/kit.yaml' is not in the rig's folder or package"):
            read_rig(tmp_path / "kit" / "urdf" / "kit.xacro")


@pytest.mark.parametrize(
    "content",
    ["a: !!python/object/apply:os.system [true]\n", "a: " + "[" * 5000, "a: [\n", "\0", "a" * 300_000],
)
def test_yaml_that_is_more_than_plain_data_is_refused_in_one_line(tmp_path: Path, content: str) -> None:
    text = (
        f"{HEAD}<xacro:property name='p' value=\"${{load_yaml('p.yaml')}}\"/><link name='${{p.a}}'/></robot>"
    )
    with pytest.raises(InputError, match=r"rig\.xacro:1: <link>") as caught:
        read_rig(write_files(tmp_path, {"rig.xacro": text, "p.yaml": content}) / "rig.xacro")
    assert str(caught.value).isprintable()


def test_yaml_may_have_units(tmp_path: Path) -> None:
    text = CAR.replace('value="${wheelbase / 2}"', """value="${xacro.load_yaml('p.yaml').turn}\"""")
    write_files(tmp_path / "parts", {"macros.xacro": MACROS})
    write_files(tmp_path, {"car.xacro": text, "p.yaml": "turn: !degrees 90\n"})
    read = read_rig(tmp_path / "car.xacro")
    axle = read.rig.vehicle.rear_axle_x
    assert read.rig.sensor("front_lidar").position[0] == pytest.approx(axle + math.pi / 2)


def test_a_list_in_a_text_is_written_as_python_does() -> None:
    text = (
        HEAD
        + """<xacro:property name="d" value="${dict(a=[1, 2.5], b='x')}"/><link name="${d}_lidar"/>
      <joint name="j" type="fixed"><parent link="base_link"/><child link="${d}_lidar"/></joint></robot>"""
    )
    assert [sensor.name for sensor in read_files({"rig.xacro": text}).rig.sensors] == [
        "{'a': [1, 2.5], 'b': 'x'}_lidar"
    ]


MANY = "".join(f'<xacro:property name="p{n}" value="${{p{n - 1}}}${{p{n - 1}}}"/>' for n in range(1, 29))
DOUBLING = "".join(
    f'<xacro:macro name="m{n}" params=""><xacro:m{n - 1}/><xacro:m{n - 1}/></xacro:macro>'
    for n in range(1, 25)
)

SHARED = '<xacro:macro name="m0" params="p"><link name="${p}"/></xacro:macro>' + "".join(
    f'<xacro:macro name="m{n}" params="p"><xacro:m{n - 1} p="${{dict(a=p, b=p, c=p, d=p, e=p)}}"/></xacro:macro>'
    for n in range(1, 10)
)
NESTED = "".join(
    f'<xacro:property name="p{n}" value="${{{"[" * 45}p{n - 1}{"]" * 45}}}"/>' for n in range(1, 30)
)
NEGATED = "".join(f'<xacro:property name="p{n}" value="${{{"-" * 45}p{n - 1}}}"/>' for n in range(1, 30))


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:property name="p" value="${p2}"/><xacro:property name="p2" value="${p}"/><link name="${p}"/>',
        f'<xacro:property name="p0" value=""/>{MANY}<link name="${{p28}}"/>',
        '<xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/>',
        f'<xacro:macro name="m0" params=""><link name="x"/></xacro:macro>{DOUBLING}<xacro:m24/>',
        '<xacro:include filename="rig.xacro"/>',
        '<xacro:if value="perhaps"><link name="x"/></xacro:if>',
        '<xacro:macro name="m" params="a"/><xacro:m/>',
        f'{SHARED}<xacro:m9 p="${{[1, 2]}}"/>',
        '<xacro:property name="p0" value="1"/>' + NESTED + '<link name="${p29}"/>',
        '<xacro:property name="p0" value="1"/>' + NEGATED + '<link name="${p29}"/>',
    ],
    ids=[
        "loop",
        "doubling texts",
        "recursion",
        "doubling macros",
        "includes itself",
        "no truth",
        "no parameter",
        "shared",
        "nested",
        "negated",
    ],
)
def test_bombs_and_loops_end_in_one_line(inside: str) -> None:
    with pytest.raises(InputError) as caught:
        read_files({"rig.xacro": f"{HEAD}{inside}</robot>"})
    assert str(caught.value).isprintable() and len(str(caught.value)) < 400


@pytest.mark.parametrize("inside", ["<!DOCTYPE a [<!ENTITY b 'cc'>]>", "<robot>&lt;", "<robot a='1' a='2'/>"])
def test_harmful_xml_in_an_included_file_is_refused_with_its_line(tmp_path: Path, inside: str) -> None:
    text = f'{HEAD}<xacro:include filename="part.xacro"/></robot>'
    with pytest.raises(InputError, match=r"part\.xacro:2: |rig\.xacro:1: <xacro:include>: document types"):
        read_rig(write_files(tmp_path, {"rig.xacro": text, "part.xacro": f"\n{inside}"}) / "rig.xacro")


@pytest.mark.parametrize(
    "said",
    [
        "../secret.xacro",
        "/etc/passwd",
        "$(find x)/../../secret.xacro",
        "link/secret.xacro",
        "a&#9;b",
        "",
        ".",
        "a" * 300,
        "circle/a.xacro",
    ],
)
def test_files_outside_the_folder_are_not_included(tmp_path: Path, said: str) -> None:
    write_files(tmp_path, {"secret.xacro": '<robot><link name="secret_lidar"/></robot>'})
    text = f'{HEAD}{LIDAR}<xacro:include filename="{said}"/></robot>'
    place = write_files(tmp_path / "rig", {"rig.xacro": text})
    (place / "link").symlink_to(tmp_path)
    (place / "circle").symlink_to(place / "circle")
    read = read_rig(place / "rig.xacro")
    assert [sensor.name for sensor in read.rig.sensors] == ["lidar"]
    assert has(read.report, "ignored", "included file that is not in the rig's folder")


def test_an_unknown_macro_is_told_and_the_rest_is_read() -> None:
    read = read_files({"rig.xacro": f'{HEAD}{LIDAR}<xacro:nosuch x="1"/></robot>'})
    assert has(read.report, "ignored", "macro that no file in the rig's folder defines", "nosuch")


def test_the_package_of_an_include_that_is_not_there_is_named() -> None:
    include = '<xacro:include filename="$(find velodyne_description)/urdf/VLP-16.urdf.xacro"/>'
    read = read_files({"rig.xacro": f"{HEAD}{LIDAR}{include}</robot>"})
    assert has(read.report, "ignored", "package velodyne_description")


def test_a_package_of_the_same_workspace_is_found(tmp_path: Path) -> None:
    """As `src/robot/robot_description` and `src/sensors/lidar_description`; a name alone is not a package."""
    include = '<xacro:include filename="$(find lidar_description)/urdf/lidar.xacro"/>'
    place = write_files(tmp_path / "src" / "robot" / "car_description", {"package.xml": "<package/>"})
    rig = write_files(place / "urdf", {"car.xacro": f"{HEAD}{include}</robot>"}) / "car.xacro"
    part = f"<robot>{LIDAR}</robot>"
    for beside in ("src/robot", "src", "src/sensors"):
        package = tmp_path / beside / "lidar_description"
        write_files(package / "urdf", {"lidar.xacro": part})
        with pytest.raises(InputError, match="package lidar_description"):
            read_rig(rig)
        write_files(package, {"package.xml": "<package/>"})
        assert [sensor.name for sensor in read_rig(rig).rig.sensors] == ["lidar"]
        shutil.rmtree(package)
    for name, target in (
        ("lidar_description", tmp_path / "other"),
        ("lidar_description/urdf", tmp_path / "other" / "urdf"),
    ):
        write_files(tmp_path / "other", {"package.xml": "<package/>"})
        write_files(tmp_path / "other" / "urdf", {"lidar.xacro": part})
        link = tmp_path / "src" / "sensors" / name
        link.parent.mkdir(parents=True, exist_ok=True)
        (link.parent / "package.xml").write_text("<package/>", encoding="utf-8")
        link.symlink_to(target)
        with pytest.raises(InputError, match="package lidar_description"):
            read_rig(rig)
        link.unlink()


def test_variables_of_the_environment_are_named() -> None:
    """jackal_description and husky_description switch each sensor on by one."""
    inside = '<xacro:if value="$(optenv JACKAL_LASER 0)"><link name="front_laser"/></xacro:if>'
    read = read_files({"rig.xacro": f"{HEAD}{LIDAR}{inside}</robot>"})
    assert has(read.report, "ignored", "environment variables", "JACKAL_LASER")
    with pytest.raises(InputError, match=r"environment variables are not read.*JACKAL_LASER"):
        read_files({"rig.xacro": f"{HEAD}{inside}</robot>"})


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:insert_block name="nosuch"/>',
        '<xacro:macro name="m" params="*a"/><xacro:m/>',
        '<xacro:macro name="m" params="a"/><xacro:m a="1" b="2"/>',
    ],
)
def test_blocks_and_parameters_must_be_those_of_the_macro(inside: str) -> None:
    with pytest.raises(InputError, match=r"rig\.xacro:1: <xacro:"):
        read_files({"rig.xacro": f"{HEAD}{inside}{LIDAR}</robot>"})
