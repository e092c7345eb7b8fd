"""The firmware build: from shared/ and firmware/ to files a board can import, byte for byte repeatable."""
