"""The CAN protocol in integers: generated codec, names and limits, and the thin framing round them."""
