"""The scene in a server: nodes where the frames say, a player that keeps time."""

import socket

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.viewing import HOST, GaitScene, Player, frames, free_port, quiet_server


@pytest.fixture(scope="module")
def server():
    with quiet_server() as server:
        yield server


@pytest.fixture
def node(server):
    return lambda name: server.scene.get_handle_by_name(name)


@pytest.fixture
def gait(server, robot_plan):
    server.scene.reset()
    return GaitScene(server.scene, robot_plan, frames(robot_plan, 10.0))


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_every_body_is_where_the_frame_says(share, gait, node):
    frame = round(share * (len(gait.moments) - 1))
    gait.show(frame)
    np.testing.assert_allclose(node("/tool").position, gait.moments.tool.position[frame])
    for name, link in gait.moments.links.items():
        shown = node(f"/robot/{name}")
        assert shown is not None, name
        np.testing.assert_allclose(shown.position, link.position[frame])
        np.testing.assert_allclose(shown.wxyz, link.wxyz[frame])


def test_arrows_end_at_the_contact_and_show_the_force(gait, node):
    frame = len(gait.moments) - 2
    gait.show(frame)
    scale = []
    for number, contact in enumerate(gait.moments.contacts):
        name = f"{contact.track.name}_{number}"
        force, point = contact.force[frame], contact.point[frame]
        arrow = node(f"/force_{name}")
        assert arrow.visible == bool(np.linalg.norm(force) > 1e-3)
        if not arrow.visible:
            continue
        along = Rotation.from_quat(arrow.wxyz, scalar_first=True).as_matrix()[:, 2]
        np.testing.assert_allclose(along, force / np.linalg.norm(force), atol=1e-9)
        head = node(f"/force_{name}/head")
        length = head.position[2] + 0.009 * float(head.scale)
        end = arrow.position if contact.track.is_pivot else arrow.position + along * length
        np.testing.assert_allclose(end, point, atol=1e-9)
        scale.append(length / np.linalg.norm(force))
    np.testing.assert_allclose(scale, scale[0])


def test_a_contact_that_does_not_exist_is_not_shown(gait, node):
    gait.show(0)
    (number,) = (k for k, c in enumerate(gait.moments.contacts) if c.track.name == "middle")
    assert not node(f"/force_middle_{number}").visible
    assert not node(f"/tool/cone_middle_{number}").visible


def test_a_plan_without_a_robot_shows_its_fingertips(server, plan, node):
    server.scene.reset()
    scene = GaitScene(server.scene, plan, frames(plan, 10.0))
    scene.show(0)
    tips = [k for k, c in enumerate(scene.moments.contacts) if c.track.name == "thumb"]
    assert node(f"/tool/tip_thumb_{tips[0]}").visible
    assert node("/robot/palm") is None


def test_the_camera_sees_the_contacts(server, gait):
    gait.aim(server)
    camera = server.initial_camera
    ahead = camera.look_at - camera.position
    for contact in gait.moments.contacts:
        towards = contact.point[np.isfinite(contact.point[:, 0])][0] - camera.position
        cosine = ahead @ towards / np.linalg.norm(ahead) / np.linalg.norm(towards)
        assert np.arccos(cosine) < camera.fov / 2


def test_the_player_keeps_time_and_begins_again(server, plan):
    server.scene.reset()
    player = Player(server, plan)
    last = frames(plan).time[-1]
    player.advance(0.5)
    assert player.time == pytest.approx(0.5)
    player.advance(last)
    assert player.time == pytest.approx(last)
    player.advance(2.0)
    player.advance(0.01)
    assert player.time == pytest.approx(0.0)


def test_a_paused_player_stands_still(server, plan):
    server.scene.reset()
    player = Player(server, plan)
    player.advance(0.3)
    player.toggle()
    player.advance(0.3)
    assert player.time == pytest.approx(0.3)
    player.toggle()
    player.advance(0.3)
    assert player.time == pytest.approx(0.6)


def test_a_jump_goes_to_the_start_of_the_phase(server, plan):
    server.scene.reset()
    player = Player(server, plan)
    player.jump(2)
    assert player.time == pytest.approx(1.3)
    assert "3/4 addition middle" in player.caption


def test_a_port_in_use_is_one_clear_line():
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=str(port)) as caught:
            free_port(port)
        assert caught.value.exit_code == 2
        assert free_port(port, or_any=True) != port


def test_the_server_prints_nothing(capsys):
    with quiet_server() as server:
        assert server.get_port() > 0
    assert capsys.readouterr() == ("", "")
