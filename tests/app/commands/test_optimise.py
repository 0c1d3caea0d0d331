"""`riglens optimise`: a table for people, JSON for programs, rigs in a folder, and refusals in one line."""

import json

import pytest

import riglens as rl
from riglens.core.rig.yaml.file import load_rig
from tests.app.town import write_town

FEW = ("--add", "generic-16", "--spots", "1.4", "--frames", "4", "--held-out", "12", "--threads", "1")


@pytest.fixture(scope="module")
def town(tmp_path_factory):
    """Objects in 20 frames."""
    return write_town(tmp_path_factory.mktemp("town") / "boxes.csv", frames=20, each=2, far_m=40.0)


def test_the_json_the_folder_and_python_say_the_same(riglens, town, tmp_path):
    out = tmp_path / "proposals"
    found = riglens("optimise", "KITTI car", *FEW, "--boxes", town, "--out", out, "--json", "-")
    assert found.code == 0
    document = json.loads(found.out)
    assert document["riglens"] == 1 and document["objective"] == "on_target" and document["frames"] == 4
    best = document["proposals"][0]
    assert document["before"] < best["value"] <= document["bound"]["value"]
    assert len(best["sensors"]) == 2 and best["verdict"] in ("resolved", "not resolved")
    rig = load_rig(out / "proposal-1.yaml").rig
    assert [list(s.position) for s in rig.sensors[-2:]] == [s["position"] for s in best["sensors"]]
    assert (out / "proposals.csv").is_file()
    traffic = rl.load_traffic(town)
    result = rl.optimise(
        rl.open_rig("KITTI car"), traffic, add="generic-16", spots_m=1.4, frames=4, held_out=12, threads=2
    )
    assert result.to_dict() == document
    assert result.proposals[0].rig == rig
    assert rl.targets(rig, traffic, sample=4)["car"].total.on_target.value > 0.0


def test_the_table_says_the_bound_and_the_verdict(riglens, town):
    found = riglens("optimise", "KITTI car", *FEW, "--boxes", town, "--blind", "0.3")
    assert found.code == 0
    for said in ("No pair on these", "held-out frames", "Verdict:", "Front of on target", "proposed"):
        assert said in found.out


def test_a_sensor_moves_by_weights_and_is_checked_in_other_data(riglens, town, tmp_path):
    other = tmp_path / "village.csv"
    other.write_text(town.read_text(encoding="utf-8"), encoding="utf-8")
    name = rl.open_rig("KITTI car").enabled_lidars()[0].name
    asked = ("--move", f"{name}=0.6", "--weight", "pedestrian=2", "--weight", "0-20=3")
    found = riglens(
        "optimise", "KITTI car", *asked, *FEW[2:], "--boxes", town, "--check-boxes", other, "--json", "-"
    )
    assert found.code == 0
    document = json.loads(found.out)
    (best,) = document["proposals"]
    assert {sensor["name"] for sensor in best["sensors"]} <= {name}
    assert best["value"] >= document["before"]
    assert "village" in {one["case"] for one in best["guard"]}


def test_requirements_limit_mounts_and_are_checked(riglens, town, tmp_path):
    file = tmp_path / "requirements.yaml"
    file.write_text(
        "riglens_requirements: 1\n"
        "mounts: {height_m: [1.2, 3.0], gap_m: 0.3}\n"
        "on_target:\n- {id: easy, class: car, at_least: 0.01}\n- {id: hard, class: car, at_least: 1.0}\n",
        encoding="utf-8",
    )
    found = riglens("optimise", "KITTI car", *FEW, "--boxes", town, "--requirements", file, "--json", "-")
    assert found.code == 0
    document = json.loads(found.out)
    assert "hard" in document["unmet"] and "easy" not in document["unmet"]
    assert all(one["position"][2] >= 1.2 for one in document["proposals"][0]["sensors"])


def test_of_a_file_and_an_option_the_stricter_limit_holds(riglens, town, tmp_path):
    file = tmp_path / "requirements.yaml"
    file.write_text(
        "riglens_requirements: 1\nmounts: {height_m: [0.2, 1.3], spacing_m: 0.1}\n", encoding="utf-8"
    )
    few = [word if word != "1.4" else "0.5" for word in FEW]
    asked = ("KITTI car", *few, "--singles", "--boxes", town, "--requirements", file, "--json", "-")
    (best, *_) = json.loads(riglens("optimise", *asked, "--lowest", "1.0").out)["proposals"]
    assert 1.0 <= best["sensors"][0]["position"][2] <= 1.3
    assert "--lowest must be at most 1.3 m" in riglens("optimise", *asked, "--lowest", "1.4").refused()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--add", "velodyne-vlp-61"), "unknown sensor model"),
        (("--add", "nuscenes-front"), "must be a LiDAR"),
        ((*FEW, "--count", "0"), "--count must be between 1 and 20 (got 0)"),
        ((*FEW, "--objective", "beauty"), "--objective must be one of predicted, share_5, "),
        ((*FEW, "--budget", "1"), "--budget must be at least 2, the cheapest addition (got 1)"),
        ((*FEW, "--cost", "generic-16"), "--cost must be MODEL=COST"),
        ((*FEW, "--lowest", "2.9"), "no mount on the car's skin keeps all limits"),
        ((*FEW, "--lowest", "nan"), "--lowest must be a finite number"),
        ((*FEW[:4], "--frames", "19"), "--frames must be at most 18"),
        ((*FEW, "--seed", "-1"), "--seed"),
        ((*FEW, "--box", "1,2"), "--box must be X0,X1,Y0,Y1,Z0,Z1 (got '1,2')"),
        ((*FEW, "--requirements", "missing.yaml"), "missing.yaml"),
        ((*FEW, "--json", "--out"), "--json"),
        ((), "--add must name at least one sensor model, or a sensor to move"),
        (("--move", "nobody"), "--move must name an enabled LiDAR of the rig"),
        (("--move", "nobody=far"), "--move must be NAME or NAME=M (got 'nobody=far')"),
        (("--exchange", "generic-16"), "--exchange must be NAME=MODEL"),
        ((*FEW, "--weight", "lorry=2"), "--weight must name one of car"),
        ((*FEW, "--weight", "20-0=2"), "--weight 20-0 must be a ring in m"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(riglens, town, arguments, said):
    assert said in riglens("optimise", "KITTI car", *arguments, "--boxes", town).refused()
