"""The web page and its server, which runs in a process of its own: nothing it does can hold up the loop."""
