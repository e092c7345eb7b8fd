"""The Foxglove process: serves the loop's status as channels, and passes on what viewers publish.

The SDK has threads of its own; this process's only loop handles what they receive.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import foxglove
from foxglove.websocket import Capability, ChannelView, Client, ClientChannel, ServerListener, StatusLevel

from ...control.odometry import Odometry
from ...records.channels import DRAWN, schema
from ...records.scene import Messages, Scene
from ...robot.file import load_robot
from ..link import Link
from .viewers import Viewers

COUNTS_S = 1.0  # between counts, and between messages of the parts that do not change
TOLD_S = 0.5  # between notes of one kind to the viewers


class Ear(ServerListener):
    """Passes what the server receives to the process's loop."""

    def __init__(self, viewers: Viewers, call: Callable[..., object]) -> None:
        self._viewers, self._call = viewers, call
        self._topics: dict[tuple[int, int], str] = {}
        self._held: dict[int, int] = {}  # channels per viewer: a viewer without channels is gone

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """See ServerListener."""
        self._hold(client.id, 1)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """See ServerListener: also called when a viewer hangs up."""
        self._hold(client.id, -1)

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """See ServerListener."""
        self._topics[client.id, channel.id] = channel.topic
        self._call(self._viewers.join, client.id)
        self._hold(client.id, 1)

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """See ServerListener."""
        self._topics.pop((client.id, client_channel_id), None)
        self._hold(client.id, -1)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """See ServerListener."""
        topic = self._topics.get((client.id, client_channel_id), "")
        self._call(self._viewers.take, client.id, topic, data)

    def _hold(self, viewer: int, more: int) -> None:
        self._held[viewer] = self._held.get(viewer, 0) + more
        if self._held[viewer] <= 0:
            del self._held[viewer]
            self._call(self._viewers.leave, viewer)


class Channels:
    """The channels that viewers see; those that do not change are sent again for viewers that come later."""

    def __init__(self, robot: str) -> None:
        self._scene, self._epoch_ns = Scene(load_robot(robot)), time.time_ns() - time.monotonic_ns()
        self._drawn = {topic: foxglove.Channel(topic, schema=schema(topic)) for topic in DRAWN}
        self._status: foxglove.Channel | None = None

    def take(self, status: dict[str, Any]) -> None:
        """Publish a status, and the place of every part."""
        time_ns = self._epoch_ns + int(status["time_s"] * 1e9)
        joints = [angle or 0.0 for angle in status["joints_rad"]]
        at = replace(Odometry(*status["odometry"]), covariance=tuple(status["covariance"]))
        self._log(self._scene.places(time_ns, joints, status["attitude_rad"], at), time_ns)
        if self._status is None:
            told = {**schema_of(status), "title": "caramelo.Status"}
            self._status = foxglove.Channel("/status", schema=told)
        self._status.log(status, log_time=time_ns)

    def repeat(self) -> None:
        """Publish the parts that do not change."""
        now_ns = time.time_ns()
        self._log(self._scene.parts(now_ns), now_ns)

    def _log(self, messages: Messages, time_ns: int) -> None:
        for topic, values in messages.items():
            self._drawn[topic].log(values, log_time=time_ns)


def schema_of(value: Any) -> dict[str, Any]:
    """Return a JSON schema of a value as it is; a value that may be null counts as a number."""
    if isinstance(value, dict):
        return {"type": "object", "properties": {key: schema_of(each) for key, each in value.items()}}
    if isinstance(value, list):
        return {"type": "array", "items": schema_of(value[0] if value else 0.0)}
    if isinstance(value, bool):
        return {"type": "boolean"}
    return {"type": "string" if isinstance(value, str) else "number"}


class Notes:
    """Sends notes to the viewers, and the same note again only after a while."""

    def __init__(self) -> None:
        self.server: foxglove.WebSocketServer | None = None
        self._said: dict[str, float] = {}

    def tell(self, sentence: str) -> None:
        """Send a note."""
        now_s = time.monotonic()
        self._said = {said: at_s for said, at_s in self._said.items() if now_s - at_s < TOLD_S}
        if self.server is not None and sentence not in self._said:
            self._said[sentence] = now_s
            self.server.publish_status(sentence, StatusLevel.Info)


async def serve(link: Link, setup: dict[str, Any]) -> None:
    """Serve viewers until the loop is gone."""
    logging.getLogger("foxglove").setLevel(logging.ERROR)
    notes, loop = Notes(), asyncio.get_running_loop()
    viewers = Viewers(setup["code"], link.send, notes.tell)
    channels = Channels(setup["robot"])
    try:
        notes.server = foxglove.start_server(
            name=f"caramelo: {setup['about']['robot']}{' (simulation)' if setup['about']['simulated'] else ''}",
            host=setup["listen"],
            port=setup["port"],
            capabilities=[Capability.ClientPublish],
            supported_encodings=["json"],
            server_listener=Ear(viewers, loop.call_soon_threadsafe),
        )
    except Exception as error:  # the SDK has no error class for a port that is taken
        link.send({"type": "web", "error": f"Foxglove at {setup['listen']}:{setup['port']}: {error}"})
        return
    link.send({"type": "web", "listens": True})
    counting = asyncio.create_task(_count(viewers, channels, link))
    while (news := await link.receive()) is not None:
        if news["type"] == "status":
            channels.take(news)
        elif news["type"] == "refused":
            notes.tell(f"viewer {news['page']}: {news['message']} refused: another client drives, or it is stopped")
    counting.cancel()
    notes.server.stop()


async def _count(viewers: Viewers, channels: Channels, link: Link) -> None:
    """Report viewers and refusals to the loop once a second; repeat the parts that do not change."""
    while True:
        channels.repeat()
        counts = {"malformed": viewers.malformed, "limited": viewers.limited, "refused": viewers.refused}
        link.send({"type": "web", "pages": len(viewers.known), **counts, "trouble": ""})
        await asyncio.sleep(COUNTS_S)
