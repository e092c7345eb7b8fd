"""The CAN protocol in integers: generated codec, names and limits, and hand-written framing and reception."""
