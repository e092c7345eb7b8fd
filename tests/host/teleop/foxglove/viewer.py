"""A viewer that speaks Foxglove's WebSocket protocol, and nothing of the SDK's."""

import asyncio
import json
import struct

import aiohttp

from tests.waiting import PATIENCE_S

MESSAGE = 1  # opcode of data, both ways
_HEAD = struct.Struct("<BIQ")  # opcode, subscription, time in ns


class Viewer:
    """One connection. ``channels``: what is advertised, by topic; ``notes``: what the server tells."""

    def __init__(self, socket):
        self._socket = socket
        self.server, self.channels, self.notes = {}, {}, []
        self._newest, self._counts, self._topics = {}, {}, {}

    @classmethod
    async def connect(cls, session, port):
        socket = await session.ws_connect(f"ws://127.0.0.1:{port}", protocols=("foxglove.sdk.v1",))
        self = cls(socket)
        await self.until(lambda: self.server)
        return self

    async def turn(self):
        """Take one message of the server."""
        message = await self._socket.receive(PATIENCE_S)
        if message.type is aiohttp.WSMsgType.TEXT:
            self._take(json.loads(message.data))
        else:
            assert message.type is aiohttp.WSMsgType.BINARY, message
            opcode, number, time_ns = _HEAD.unpack_from(message.data)
            assert opcode == MESSAGE
            topic = self._topics[number]
            self._newest[topic] = (time_ns, json.loads(message.data[_HEAD.size :]))
            self._counts[topic] = self._counts.get(topic, 0) + 1

    def _take(self, value):
        if value["op"] == "serverInfo":
            self.server = value
        elif value["op"] == "advertise":
            self.channels |= {each["topic"]: each for each in value["channels"]}
        elif value["op"] == "status":
            self.notes.append(value["message"])

    async def until(self, found, patience_s=PATIENCE_S):
        """Take messages until it is found; return it."""
        async with asyncio.timeout(patience_s):
            while not found():
                await self.turn()
        return found()

    async def subscribe(self, *topics):
        for topic in topics:
            await self.until(lambda topic=topic: topic in self.channels)
            number = self.channels[topic]["id"]
            self._topics[number] = topic
            await self._say({"op": "subscribe", "subscriptions": [{"id": number, "channelId": number}]})

    async def newest(self, topic):
        """Return the next message of a topic: its time in ns and its values."""
        before = self._counts.get(topic, 0)
        await self.until(lambda: self._counts.get(topic, 0) > before)
        return self._newest[topic]

    async def advertise(self, *topics):
        """Say what will be published; the channel's number is the topic's place."""
        self._own = topics
        how = {"encoding": "json", "schemaName": ""}
        channels = [{"id": at + 1, "topic": topic, **how} for at, topic in enumerate(topics)]
        await self._say({"op": "advertise", "channels": channels})

    async def publish(self, topic, value):
        data = value if isinstance(value, bytes) else json.dumps(value).encode()
        await self._socket.send_bytes(struct.pack("<BI", MESSAGE, self._own.index(topic) + 1) + data)

    async def _say(self, value):
        await self._socket.send_str(json.dumps(value))

    async def close(self):
        await self._socket.close()
